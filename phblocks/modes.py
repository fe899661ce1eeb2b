"""Natural frequencies and shapes of a linear descriptor system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from phblocks.errors import DataError
from phblocks.triplets import Floats

Complexes = NDArray[np.complex128]

#: Up to this size dense eigenvalues are taken: all of them, and nothing to tune.
DENSE = 800
#: The same for systems that are not skew: under gravity, in motion, with damping.
DENSE_GENERAL = 1500
#: Round-off in an eigenvalue, in units of eps * size * condition.
SCATTER = 100.0
#: Relative size below which an iterative eigenvalue of a system that is not skew is taken for a scattered zero.
DEFECTIVE = 1e-7


@dataclass(frozen=True)
class Modes:
    """Oscillations ``w(t) = shape * exp((growth + 1j * frequency) * t)``.

    Parameters
    ----------
    frequencies : numpy.ndarray
        Shape (m,), rad/s, ascending, above zero.
    growth : numpy.ndarray
        Shape (m,), 1/s; negative if damped, zero for an undamped system at rest.
    shapes : numpy.ndarray
        Complex, shape (states, m), of unit energy: ``1/2 w^H E w = 1``.
    diverging : numpy.ndarray
        Growth rates above zero of motions that do not oscillate, 1/s, descending: the state is unstable if there are
        any.
    """

    frequencies: Floats
    growth: Floats
    shapes: Complexes
    diverging: Floats

    def __repr__(self) -> str:
        """Say how many there are and where, without the shapes."""
        span = f", {self.frequencies[0]:.4g} to {self.frequencies[-1]:.4g} rad/s" if self.frequencies.size else ""
        return f"<Modes: {self.frequencies.size}{span}, {self.diverging.size} diverging>"

    @property
    def hertz(self) -> Floats:
        """Frequencies in Hz, shape (m,)."""
        return self.frequencies / (2.0 * np.pi)


def find_modes(E: sp.csr_array, A: sp.csr_array, n: int) -> Modes:
    """Find the lowest natural frequencies of ``E w' = A w``.

    Where A is skew (an undamped system at rest) the problem ``-1j A w = omega E w`` is Hermitian and is solved as
    such: frequencies are real, and shapes are orthogonal in E. Systems of more than 800 states (1500 if not skew) are
    solved by shift-and-invert Lanczos or Arnoldi (ARPACK) about frequency zero; of a system that is not skew only
    frequencies above 1e-7 of the largest are told from zero there. Frequencies that round-off could have made of a
    zero (rigid motions under gravity are a defective one) are left out.

    Parameters
    ----------
    E : scipy.sparse.csr_array
        Shape (m, m), symmetric positive definite, or with rows of zeros for states without energy: those are
        eliminated, and with them the constraints they imply.
    A : scipy.sparse.csr_array
        Shape (m, m).
    n : int
        How many modes.

    Returns
    -------
    Modes
        The n lowest (or all, if there are fewer) with a frequency above zero.

    Raises
    ------
    DataError
        If n is not a positive integer.
    """
    if isinstance(n, bool) or not isinstance(n, (int, np.integer)) or n < 1:
        raise DataError("modes n", expected="a positive integer", got=repr(n), fix="Ask for the lowest n modes.")
    idle = E.diagonal() == 0.0
    if idle.any():
        E_e, A_e, back = _without_idle(E, A, idle)
        if not E_e.shape[0]:
            return Modes(np.empty(0), np.empty(0), np.empty((idle.size, 0), dtype=complex), np.empty(0))
        found = find_modes(E_e, A_e, n)
        return Modes(found.frequencies, found.growth, back @ found.shapes, found.diverging)
    scale = sp.diags_array(1.0 / np.sqrt(E.diagonal()))  # one size for forces and velocities
    E, A = sp.csc_array(scale @ E @ scale), sp.csc_array(scale @ A @ scale)
    largest = float(np.sqrt((A.multiply(A)).sum(axis=1).max(initial=0.0)))
    skew = np.abs((A + A.T).data).max(initial=0.0) <= 1e-14 * largest
    if E.shape[0] <= (DENSE if skew else DENSE_GENERAL):
        values, shapes, error = _dense(E, A, skew, largest)
    else:
        values, shapes, error = _sparse(E, A, skew, n, largest)
    above = np.flatnonzero(values.imag > error)
    order = above[np.argsort(values.imag[above])][:n]
    diverging = np.sort(values.real[(np.abs(values.imag) <= error) & (values.real > error)])[::-1]
    shapes = shapes[:, order]
    energy = 0.5 * np.einsum("im,im->m", shapes.conj(), E @ shapes).real
    return Modes(values[order].imag, values[order].real, scale @ (shapes / np.sqrt(energy)), diverging)


def _without_idle(
    E: sp.csr_array, A: sp.csr_array, idle: NDArray[np.bool_]
) -> tuple[sp.csr_array, sp.csr_array, NDArray[np.float64]]:
    """Eliminate states without energy: solve for those that follow, keep to what the constraints of the others allow.

    Returns E and A of the coordinates y that are left, and the matrix that makes all states of y.
    """
    from scipy.linalg import null_space

    kept = np.flatnonzero(~idle)
    free = np.flatnonzero(idle)
    size = np.ones(idle.size)
    size[kept] = 1.0 / np.sqrt(E.diagonal()[kept])
    coupling = np.abs((A @ sp.diags_array(size)).tocsr()[free]).max(axis=1).toarray().ravel()
    size[free] = 1.0 / np.where(coupling > 0.0, coupling, 1.0)
    units = sp.diags_array(size)
    B, M = (units @ A @ units).toarray(), (units @ E @ units).toarray()[np.ix_(kept, kept)]
    ee, ea, ae, aa = (B[np.ix_(i, j)] for i in (kept, free) for j in (kept, free))
    U, values, Vt = np.linalg.svd(aa)
    rank = int((values > 1e-10 * max(1.0, values[0])).sum())
    solved = -(Vt[:rank].T / values[:rank]) @ (U[:, :rank].T @ ae)  # states that follow, of those with energy
    allowed = null_space(U[:, rank:].T @ ae) if rank < free.size else np.eye(kept.size)
    skew = np.abs(B + B.T).max() <= 1e-14 * np.abs(B).max()
    tested = allowed if skew or rank == free.size else null_space((ea @ Vt[rank:].T).T)
    E_y, A_y = allowed.T @ M @ allowed, tested.T @ (ee + ea @ solved) @ allowed
    if tested is not allowed:  # multiplied from the left so that the energy stands on the left again
        A_y = E_y @ np.linalg.solve(tested.T @ M @ allowed, A_y)
    back = np.zeros((idle.size, allowed.shape[1]))
    back[kept], back[free] = allowed, solved @ allowed
    A_y = (A_y - A_y.T) / 2.0 if skew else A_y
    return sp.csr_array(E_y), sp.csr_array(A_y), size[:, None] * back


def _dense(E: sp.csc_array, A: sp.csc_array, skew: bool, largest: float) -> tuple[Complexes, Complexes, Floats]:
    """All eigenvalues, shapes, and a bound of the round-off in each eigenvalue."""
    from scipy.linalg import eig, eigh

    if skew:
        frequencies, shapes = eigh(-1j * A.toarray(), E.toarray())
        return 1j * frequencies, shapes, np.full(frequencies.size, 1e-12 * largest)
    values, left, shapes = eig(A.toarray(), E.toarray(), left=True, right=True)
    # the condition of each eigenvalue: rigid motions are a defective zero, which round-off scatters far
    overlap = np.abs(np.einsum("im,im->m", left.conj(), E @ shapes))
    sizes = np.linalg.norm(left, axis=0) * np.linalg.norm(shapes, axis=0)
    tiny = np.finfo(float).tiny
    return values, shapes, SCATTER * np.finfo(float).eps * largest * sizes / np.maximum(overlap, tiny)


def _sparse(
    E: sp.csc_array, A: sp.csc_array, skew: bool, n: int, largest: float
) -> tuple[Complexes, Complexes, Floats]:
    """Eigenvalues nearest to a small shift; where that is safe, ask for more until n of them are oscillations."""
    from scipy.sparse.linalg import eigs, eigsh

    size, wanted = E.shape[0], 2 * n + 12
    start = np.random.default_rng(0).standard_normal(size).astype(complex)
    if not skew:
        values, shapes = eigs(A.astype(complex), min(2 * wanted, size - 2), M=E, sigma=1e-9j * largest, v0=start)
        return values, shapes, np.full(values.size, DEFECTIVE * largest)
    while True:
        wanted = min(wanted, size - 2)
        frequencies, shapes = eigsh(-1j * A, wanted, M=E, sigma=1e-9 * largest, v0=start)
        if (frequencies > 1e-12 * largest).sum() >= n or wanted >= size - 2:
            return 1j * frequencies, shapes, np.full(frequencies.size, 1e-12 * largest)
        wanted *= 2
