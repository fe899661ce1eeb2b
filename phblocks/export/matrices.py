"""The matrices of a system with all their names: what an export file holds, whatever its format."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.triplets import Floats

#: The sign convention, in the words of every file. The letters are those of the port-Hamiltonian benchmark collection.
CONVENTION = (
    "E x' = (J - R) Q x + f0 + (G - P) u; y = (G + P)^T Q x + (S + N) u; energy H = 1/2 x^T Q^T E x; "
    "y^T u is the power supplied to the system; J, N skew, R, S symmetric; f0 is the constant load (gravity). "
    "J, G, f0 are those at the state x0 described in 'about'. "
    "If A, B, C, D, E_lin are present: E_lin d' = A d + B du, dy = C d + D du is the tangent at that state, "
    "d and du being small departures from it."
)


@dataclass(frozen=True, eq=False, kw_only=True)
class Tangent:
    """The tangent of a system at a state: ``E d' = A d + B du``, ``dy = C d + D du``.

    The states d are small departures of the energy states, followed by those of the configuration (angles).
    Matrices may be given in any form, dense or sparse; they are kept sparse.

    Parameters
    ----------
    A : scipy.sparse.csr_array
        Shape (m, m).
    B : scipy.sparse.csr_array
        Shape (m, n_inputs).
    C : scipy.sparse.csr_array
        Shape (n_outputs, m).
    D : scipy.sparse.csr_array
        Shape (n_outputs, n_inputs).
    E : scipy.sparse.csr_array
        Shape (m, m); may be singular. In files its name is ``E_lin``.
    state_names : tuple of str
        Name of each of the m states.
    state_units : tuple of str
        SI unit of each of the m states.

    Raises
    ------
    DataError
        If shapes do not fit each other, an entry is not a finite real number, or a name cannot be written.
    ArgumentTypeError
        If names are not strings.
    """

    A: sp.csr_array
    B: sp.csr_array
    C: sp.csr_array
    D: sp.csr_array
    E: sp.csr_array
    state_names: tuple[str, ...]
    state_units: tuple[str, ...]

    def __post_init__(self) -> None:
        where = "tangent"
        _set(self, "state_names", _labels(f"{where}: state_names", self.state_names))
        m = len(self.state_names)
        _set(self, "state_units", _labels(f"{where}: state_units", self.state_units, m))
        D = _sparse(f"{where}: D", self.D)
        p, q = D.shape
        shapes = {"A": (m, m), "B": (m, q), "C": (p, m), "D": (p, q), "E": (m, m)}
        for key, shape in shapes.items():
            _set(self, key, _sparse(f"{where}: {key}", getattr(self, key), shape))


@dataclass(frozen=True, eq=False, kw_only=True)
class Matrices:
    """A port-Hamiltonian system at one state, in matrices with names.

        E x' = (J - R) Q x + f0 + (G - P) u,    y = (G + P)^T Q x + (S + N) u,    H = 1/2 x^T Q^T E x

    Power ``y^T u`` counts into the system. There are n states and n_inputs inputs, each with its power-conjugate
    output. Matrices may be given in any form, dense or sparse; they are kept as sparse copies in 64-bit floating
    point, with sorted indices, without duplicates and without stored zeros.

    Parameters
    ----------
    name : str
        Of the system.
    about : str
        The state at which the matrices are taken, in words.
    E, J, R, Q : scipy.sparse.csr_array
        Shape (n, n).
    G : scipy.sparse.csr_array
        Shape (n, n_inputs).
    x0 : numpy.ndarray
        Energy states at which the matrices are taken, shape (n,), units in ``state_units``.
    f0 : numpy.ndarray
        Constant load such as gravity, shape (n,), in the units of ``E x'``; zero if there is none.
    state_names, state_units : tuple of str
        Name and SI unit of each state.
    state_positions : numpy.ndarray
        Place of each state along its block, shape (n,), m; NaN where a state has no place.
    input_names, input_units : tuple of str
        Name and SI unit of each input.
    output_names, output_units : tuple of str
        Name and SI unit of the output conjugate to each input.
    P : scipy.sparse.csr_array, optional
        Shape (n, n_inputs); zero by default.
    S, N : scipy.sparse.csr_array, optional
        Feedthrough, shape (n_inputs, n_inputs); zero by default.
    tangent : Tangent, optional
        The tangent at the same state, with everything the configuration adds to it.
    convention : str, optional
        The sign convention in words.

    Raises
    ------
    DataError
        If shapes do not fit each other, an entry is not a finite real number, or a name cannot be written.
    ArgumentTypeError
        If names are not strings, or the tangent is of the wrong kind.
    """

    name: str
    about: str
    E: sp.csr_array
    J: sp.csr_array
    R: sp.csr_array
    Q: sp.csr_array
    G: sp.csr_array
    x0: Floats
    f0: Floats
    state_names: tuple[str, ...]
    state_units: tuple[str, ...]
    state_positions: Floats
    input_names: tuple[str, ...]
    input_units: tuple[str, ...]
    output_names: tuple[str, ...]
    output_units: tuple[str, ...]
    P: sp.csr_array = None
    S: sp.csr_array = None
    N: sp.csr_array = None
    tangent: Tangent | None = None
    convention: str = CONVENTION

    def __repr__(self) -> str:
        """Count states and inputs."""
        return f"<Matrices of {self.name!r}: {len(self.state_names)} states, {len(self.input_names)} inputs>"

    def __post_init__(self) -> None:
        where = f"matrices of {self.name!r}"
        _labels(f"{where}: name, about, convention", (self.name, self.about, self.convention))
        _set(self, "state_names", _labels(f"{where}: state_names", self.state_names))
        _set(self, "input_names", _labels(f"{where}: input_names", self.input_names))
        n, m = len(self.state_names), len(self.input_names)
        _set(self, "state_units", _labels(f"{where}: state_units", self.state_units, n))
        for key in ("input_units", "output_names", "output_units"):
            _set(self, key, _labels(f"{where}: {key}", getattr(self, key), m))
        shapes = {
            "E": (n, n),
            "J": (n, n),
            "R": (n, n),
            "Q": (n, n),
            "G": (n, m),
            "P": (n, m),
            "S": (m, m),
            "N": (m, m),
        }
        for key, shape in shapes.items():
            value = getattr(self, key)
            zero = value is None and key in ("P", "S", "N")
            _set(self, key, sp.csr_array(shape) if zero else _sparse(f"{where}: {key}", value, shape))
        for key in ("x0", "f0", "state_positions"):
            _set(self, key, _vector(f"{where}: {key}", getattr(self, key), n, gaps=key == "state_positions"))
        self._check_tangent(f"{where}: tangent", m)

    def with_states(self, change: ArrayLike, names: Iterable[str], units: Iterable[str]) -> Matrices:
        """Write the same system in other states, linear combinations of these.

        With ``x_new = T x``: ``E = T E T^-1``, ``J = T J T^T``, R likewise, ``Q = T^-T Q T^-1``, ``G = T G``, P and f0
        likewise; inputs, outputs and the energy stay as they are.

        Parameters
        ----------
        change : array_like
            T, shape (n, n), invertible; a permutation only changes the order.
        names, units : iterable of str
            Of the new states, n of each.

        Returns
        -------
        Matrices
            Without a tangent, and with places of states only where T is a permutation.

        Raises
        ------
        DataError
            If the change is not an invertible matrix of finite numbers of this shape, or n names are not given.
        ArgumentTypeError
            If names are not strings.
        """
        where = f"matrices of {self.name!r}: change"
        n = self.E.shape[0]
        T = _sparse(where, change, (n, n)).toarray()
        if n and np.linalg.matrix_rank(T / np.maximum(np.abs(T).max(axis=1, keepdims=True), 1e-300)) < n:
            raise DataError(where, expected="an invertible matrix", got="a singular one", fix="Give n new states.")
        back = np.linalg.inv(T)
        order = np.abs(T).argmax(axis=1) if n else np.empty(0, dtype=np.int64)
        permutation = bool((np.eye(n)[order] == T).all())
        return replace(
            self,
            E=T @ self.E @ back,
            J=T @ self.J @ T.T,
            R=T @ self.R @ T.T,
            Q=back.T @ self.Q @ back,
            G=T @ self.G,
            P=T @ self.P,
            x0=T @ self.x0,
            f0=T @ self.f0,
            state_names=tuple(names),
            state_units=tuple(units),
            state_positions=self.state_positions[order] if permutation else np.full(n, np.nan),
            tangent=None,
        )

    def _check_tangent(self, where: str, n_inputs: int) -> None:
        if self.tangent is None:
            return
        if not isinstance(self.tangent, Tangent):
            raise ArgumentTypeError(where, expected="a Tangent or None", got=repr(self.tangent), fix="Make a Tangent.")
        if self.tangent.D.shape != (n_inputs, n_inputs):
            raise DataError(
                where,
                expected=f"{n_inputs} inputs and outputs",
                got=f"D of shape {self.tangent.D.shape}",
                fix="Linearise with the inputs and outputs that are named.",
            )


def _set(target: object, key: str, value: object) -> None:
    object.__setattr__(target, key, value)


def _labels(where: str, values: Iterable[str], count: int | None = None) -> tuple[str, ...]:
    labels = tuple(values) if isinstance(values, Iterable) and not isinstance(values, str) else (None,)
    if not all(isinstance(label, str) for label in labels):
        raise ArgumentTypeError(where, expected="strings", got=repr(values)[:60], fix="Give a sequence of strings.")
    if count is not None and len(labels) != count:
        raise DataError(where, expected=f"{count} of them", got=str(len(labels)), fix="Name each state, input, output.")
    for label in labels:
        # NUL ends a string in some formats, and half of a surrogate pair has no place in any.
        if "\0" in str(label) or (not str(label).isascii() and any("\ud800" <= c <= "\udfff" for c in str(label))):
            raise DataError(where, expected="text", got=repr(label), fix="Leave out the characters that are not text.")
    return tuple(str(label) for label in labels)


def _sparse(where: str, value: Any, shape: tuple[int, int] | None = None) -> sp.csr_array:
    try:
        array = sp.csr_array(value if sp.issparse(value) else np.asarray(value), copy=True)
    except (TypeError, ValueError) as error:
        raise DataError(
            where, expected="a matrix", got=repr(value)[:60], fix="Give a sparse or dense array."
        ) from error
    if array.dtype.kind not in "fiu":
        raise DataError(where, expected="real numbers", got=f"dtype {array.dtype}", fix="Give a real matrix.")
    if array.ndim != 2 or (shape is not None and array.shape != shape):
        expected = "two axes" if shape is None else f"shape {shape}"
        raise DataError(where, expected=expected, got=f"shape {array.shape}", fix="Compare it with the names given.")
    array = array.astype(np.float64)
    array.sum_duplicates()
    array.eliminate_zeros()
    if not np.isfinite(array.data).all():
        raise DataError(where, expected="finite entries", got="NaN or infinity", fix="Look for it in the parameters.")
    return array


def _vector(where: str, value: ArrayLike, n: int, *, gaps: bool) -> Floats:
    try:
        vector = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise DataError(where, expected=f"{n} real numbers", got=repr(value)[:60], fix="Give an array.") from error
    if vector.shape != (n,):
        raise DataError(where, expected=f"shape ({n},)", got=f"shape {vector.shape}", fix="Give one for each state.")
    if not (np.isfinite(vector) | (np.isnan(vector) & gaps)).all():
        raise DataError(where, expected="finite numbers", got="NaN or infinity", fix="Look for it in the state.")
    return vector
