"""Collocation: the stages of a step as one equation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from phblocks.solvers.coefficients import Collocation
from phblocks.solvers.linear import band_places, linear_solver
from phblocks.solvers.stage import StageEquation
from phblocks.system import System
from phblocks.triplets import Floats, Ints


class CollocationEquation(StageEquation):
    """The equations of all stages of a step, for a simplified Newton method.

    Unknowns are the values at the stages, shape (n, stages), and

        residual_i = 1/dt E sum_j (A^-1)_ij (z_j - x_n) - f(z_i, theta_i),
        theta_i = theta_n + dt sum_j A_ij theta'(z_j).

    With one linearisation ``f_z, f_theta`` for all stages, the eigenvectors of A take the equations apart: for each
    eigenvalue lambda there is one matrix ``E / (lambda dt) - f_z - lambda dt f_theta rates`` on the pattern, and of
    the band, of a single stage. Orientations stay eliminated, because A and its inverse share eigenvectors. Of
    conjugate eigenvalues one suffices.

    Parameters
    ----------
    system : System
        The system to integrate.
    collocation : Collocation
        Coefficients of the method.

    Notes
    -----
    E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., IV.8, doi:10.1007/978-3-642-05221-7.
    """

    def __init__(self, system: System, collocation: Collocation) -> None:
        super().__init__(system)
        self.collocation = collocation
        self.modes = Modes.of(collocation.A)
        self._inverse = collocation.inverse

    def _make_all(self) -> None:
        super()._make_all()
        _ = self.tables

    def begin_step(self, x: Floats, theta: Floats, dt: float, u: Floats) -> None:
        """Fix the data of a step.

        Parameters
        ----------
        x : numpy.ndarray
            Unknowns at its start, shape (n,).
        theta : numpy.ndarray
            Rotation states at its start, shape (n_theta,), rad.
        dt : float
            Its length, s.
        u : numpy.ndarray
            Inputs at the stages, shape (stages, n_inputs).
        """
        self._rate_weights, self._turn_weights = self._inverse.T / dt, dt * self.collocation.A.T
        self._momentum = self.momentum(x)[:, None]
        driven = theta[:, None] + (self.system.input_rates @ u.T) @ self._turn_weights
        self._alpha_known = self._alpha_reference[:, None] + self._alpha_rows @ driven
        self._kappa_given = self._kappa_gravity[:, None] + self._kappa_input @ u.T
        self._known_force = self._inputs @ u.T
        self._dt = self._span = dt

    def residual(self, z: Floats) -> Floats:
        """Evaluate the residual.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns, shape (n, stages).

        Returns
        -------
        numpy.ndarray
            Shape (n, stages).
        """
        parts = self._parts
        turned, kappa, momentum, forced = parts.linear(z)
        alpha, kappa = self._alpha_known + turned @ self._turn_weights, kappa + self._kappa_given
        self._at, features = (alpha, kappa), self._features(z, alpha)[0]
        summed = parts.summed(z, kappa * features.take(self._feature, axis=0))
        rate = (momentum - self._momentum) @ self._rate_weights
        return np.asarray(rate - forced - self._known_force - summed)

    def evaluate(self, z: Floats) -> tuple[Floats, Floats]:
        """Evaluate the residual, and the matrices of the modes at the mean of the stages.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns, shape (n, stages).

        Returns
        -------
        residual : numpy.ndarray
            Shape (n, stages).
        matrices : numpy.ndarray
            Complex entries on the pattern, shape (modes, entries).
        """
        residual, weights = self.residual(z), self.collocation.b
        mean, alpha, kappa = z @ weights, self._at[0] @ weights, self._at[1] @ weights
        features, slopes, by_line = self._features(mean, alpha)
        first, by_angle, by_lines = self._modulation_parts
        direct = self._rest + self._cubic @ mean + first @ features
        if by_line:
            direct += by_lines @ np.concatenate([kappa * derivative[self._feature] for derivative in by_line])
        turning = by_angle @ (kappa * slopes[self._feature])
        tau = self._dt * self.modes.values[:, None]
        return residual, self.mass / tau - direct - tau * turning

    def lost(self, x: Floats, ends: Floats, z: Floats) -> Floats | None:
        """Return the unknowns whose energy steps in a row lose to the method.

        Parameters
        ----------
        x : numpy.ndarray
            Unknowns at the start of the first, shape (n,).
        ends : numpy.ndarray
            At the ends, shape (steps, n).
        z : numpy.ndarray
            At the stages, shape (steps, stages, n).

        Returns
        -------
        numpy.ndarray or None
            Shape (steps, n); ``None`` for a method that keeps energies.
        """
        loss = self.collocation.loss
        return None if loss is None else loss @ (z - np.concatenate([x[None], ends[:-1]])[:, None])

    def round_off(self, z: Floats) -> float:
        """Estimate the round-off in the residual at the last evaluation.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns, shape (n, stages).

        Returns
        -------
        float
            Of its Euclidean norm.
        """
        size, known = np.abs(z), np.abs(self._known_force)
        _, _, momentum, forced = abs(self._parts).linear(size)
        rates = momentum @ np.abs(self._rate_weights)
        force = forced + abs(self._parts).summed(size, np.abs(self._at[1])) + known
        return float(np.finfo(float).eps * np.linalg.norm(rates + force))

    @cached_property
    def tables(self) -> Tables:
        """What does not change during a run, for compiled code; copies: SciPy sorts entries when it pleases."""
        parts, lines = self._parts, self._line_data
        first, by_angle, by_lines = self._modulation_parts
        none = arrays_of(sp.csr_array((0, self.n)))
        line: tuple[Any, ...] = (none, none, np.empty(0), np.empty(0, dtype=bool))
        if lines is not None:
            line = (arrays_of(lines.span), arrays_of(lines.stretch), lines.free.copy(), lines.taut.copy())
        by_mean = sp.csr_array(sp.hstack([self._cubic, first, *([by_lines] if lines is not None else [])]))
        _, spot = band_places(self.rows, self.columns)
        jacobian = (arrays_of(by_mean), arrays_of(by_angle), self._rest.copy(), self.mass.copy(), spot)
        sizes = self._turn.shape[0], self._n_angles
        feature = self._feature.astype(np.int64)
        equation = (
            *(arrays_of(matrix) for matrix in (parts.stacked, parts.forces)),
            parts.pairs.astype(np.int64), feature, sizes, line, jacobian,
        )  # fmt: skip
        turn = (
            arrays_of(self._alpha_rows), self._alpha_reference.copy(), self.collocation.end,
            self.collocation.extrapolation, arrays_of(self._rates),
        )  # fmt: skip
        by_inputs = (self._kappa_input, self._inputs, sp.csr_array(self.system.input_rates))
        inputs = (self._kappa_gravity.copy(), *(arrays_of(matrix) for matrix in by_inputs))
        return Tables(equation, turn, inputs)


def arrays_of(matrix: sp.csr_array) -> tuple[Floats, NDArray[np.int32], NDArray[np.int32]]:
    """Take a sparse matrix apart, for compiled code.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array
        The matrix.

    Returns
    -------
    tuple of numpy.ndarray
        Copies of its entries, their columns and the starts of its rows.
    """
    return matrix.data.copy(), matrix.indices.astype(np.int32), matrix.indptr.astype(np.int32)


@dataclass(frozen=True)
class Tables:
    """What does not change during a run, as plain arrays.

    Parameters
    ----------
    equation : tuple
        What is linear in the unknowns (angles, modulated quantities, E, J0 - R: one below the other), what sums
        products into forces, factors of these products, feature of each pair, numbers of angles (all, of joints),
        lines, and the matrices of the Jacobian: by the mean of the stages, by turning, constant, mass, places.
    turn : tuple
        Angles by rotation states, their references, weights of the stages at the end of the step, the same for states
        without rate, and rates of the rotation states.
    inputs : tuple
        Modulated quantities without inputs and by inputs, forces and rotation rates by inputs.
    """

    equation: tuple[Any, ...]
    turn: tuple[Any, ...]
    inputs: tuple[Any, ...]


@dataclass(frozen=True)
class Modes:
    """Eigenvalues of A and their vectors, one of each conjugate pair.

    Parameters
    ----------
    values : numpy.ndarray
        Shape (modes,).
    right : numpy.ndarray
        Eigenvectors, shape (modes, stages); those of a pair doubled, for ``2 Re(w v) = w v + conjugate``.
    left : numpy.ndarray
        Rows of the inverse of the eigenvectors, shape (modes, stages).
    """

    values: NDArray[np.complex128]
    right: NDArray[np.complex128]
    left: NDArray[np.complex128]

    @classmethod
    def of(cls, A: Floats) -> Modes:
        """Find them.

        Parameters
        ----------
        A : numpy.ndarray
            Shape (stages, stages).

        Returns
        -------
        Modes
            The real ones and those of positive imaginary part.
        """
        values, vectors = np.linalg.eig(A)
        left = np.linalg.inv(vectors)
        values = np.where(np.abs(values.imag) < 1e-12, values.real, values)
        kept = np.flatnonzero(values.imag >= 0.0)
        factor = np.where(values[kept].imag > 0.0, 2.0, 1.0)
        return cls(values[kept], factor[:, None] * vectors[:, kept].T, left[kept])


class ModeSolver:
    """Factorises and solves for all modes; real ones in real numbers.

    Parameters
    ----------
    rows, columns : numpy.ndarray
        Places of the entries of a single stage.
    n : int
        Number of unknowns of a single stage.
    modes : Modes
        Of the method.
    """

    def __init__(self, rows: Ints, columns: Ints, n: int, modes: Modes) -> None:
        self._parts = []
        for value, left, right in zip(modes.values, modes.left, modes.right, strict=True):
            kind = complex if value.imag else float
            solver = linear_solver(rows, columns, n, kind)
            width = 2 if value.imag else 1
            pair = np.stack([left.real, left.imag], axis=1), np.stack([right.real, -right.imag])
            self._parts.append((solver, kind, pair[0][:, :width].copy(), pair[1][:width].copy()))

    def factorise(self, data: Floats) -> bool:
        """Factorise; return False if a matrix is singular.

        Parameters
        ----------
        data : numpy.ndarray
            Entries on the pattern, shape (modes, entries).

        Returns
        -------
        bool
            Whether all factors were found.
        """
        parts = zip(self._parts, data, strict=True)
        return all(solver.factorise(d if kind is complex else d.real) for (solver, kind, _, _), d in parts)

    def solve(self, b: Floats) -> Floats:
        """Solve with the last factors.

        Parameters
        ----------
        b : numpy.ndarray
            Right-hand sides, shape (n, stages).

        Returns
        -------
        numpy.ndarray
            Shape (n, stages).
        """
        z = 0.0
        for solver, kind, left, right in self._parts:
            # pairs of real numbers are complex numbers: no complex products of the small matrices
            w = solver.solve(np.ascontiguousarray(b @ left).view(kind).ravel())
            z = z + w.view(float).reshape(-1, left.shape[1]) @ right
        return np.asarray(z)
