"""The nonlinear model as constant sparse matrices: what a file holds so that other tools can integrate it.

    E x' = (J0 + T[x] + K[phi] + V[phi] - R) x + Kg phi + (G + Ku[phi] + Vu) u
    theta' = W x + Wu u,        y = (G + Ku[phi])^T x,        points' = turn(gamma0 + gamma theta) (points x)

``T[x] = reshape(T x, n, n)`` by columns, as in MATLAB, Julia and Fortran; K, V and Ku likewise with phi, and

    phi = [1, cos a, sin a, e1, e2],    a = alpha0 + alpha theta,    b = beta0 + beta theta,
    e1 = (cos b r1x + sin b r2x) / l,   e2 = (cos b r2x - sin b r1x) / l,     r1x = r1 x,  r2x = r2 x,
    l = free + stretch x where taut = 1, else sqrt(r1x^2 + r2x^2).
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import scipy.sparse as sp

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.triplets import Floats

#: Fields that are matrices with the shape of each; n states, m inputs, t rotation states, f features, d directions, p
#: coordinates of the points (2 or 3 each), q points.
SHAPES = {
    **{"E": "nn", "J0": "nn", "R": "nn", "T": "(nn)n", "K": "(nn)f", "V": "(nn)f", "Kg": "nf"},
    **{"G": "nm", "Ku": "(nm)f", "Vu": "nm", "W": "tn", "Wu": "tm"},
    **{"alpha": "at", "beta": "dt", "r1": "dn", "r2": "dn", "stretch": "dn", "points": "pn", "gamma": "qt"},
}
#: Fields that are vectors with the length of each.
LENGTHS = {"theta0": "t", "alpha0": "a", "beta0": "d", "free": "d", "taut": "d", "gamma0": "q", "points0": "p"}
#: Fields that are names.
LABELS = ("theta_names", "point_names")


@dataclass(frozen=True, eq=False, kw_only=True)
class NonlinearModel:
    """The equations of motion in constant matrices; see the module for the equations.

    Matrices may be given in any form; they are kept as ``scipy.sparse.coo_array``. In files the names begin with "nl_".

    Parameters
    ----------
    E, J0, R : scipy.sparse.coo_array
        Shape (n, n): what multiplies x' (with ones for spans), the constant parts of J and R.
    T : scipy.sparse.coo_array
        Shape (n n, n): products of states; the row of (i, j) is ``i + n j``, counted from 0.
    K, V : scipy.sparse.coo_array
        Shape (n n, f): joints that turn, and rates of the configuration; rows as in T.
    Kg : scipy.sparse.coo_array
        Shape (n, f): gravity.
    G, Vu : scipy.sparse.coo_array
        Shape (n, m): constant parts of the input matrix; Vu is not part of the outputs.
    Ku : scipy.sparse.coo_array
        Shape (n m, f): inputs in the fixed frame; the row of (i, k) is ``i + n k``.
    W, Wu : scipy.sparse.coo_array
        Shape (t, n) and (t, m): rates of the rotation states.
    alpha, beta, gamma : scipy.sparse.coo_array
        Shape (a, t), (d, t), (q, t): angles of joints, of the frames that lines are seen in, and of the points.
    r1, r2, stretch : scipy.sparse.coo_array
        Shape (d, n): the components of the span of each direction, and what adds to its length.
    points : scipy.sparse.coo_array
        Shape (2 q, n), in space (3 q, n): velocities of the points in their own frames, one point after the other.
    theta0 : numpy.ndarray
        Shape (t,): rotation states at the state that was exported, rad.
    alpha0, beta0, gamma0 : numpy.ndarray
        Shape (a,), (d,), (q,): the same angles where theta is zero, rad.
    free, taut : numpy.ndarray
        Shape (d,): length at zero force, m; 1 where the length comes from it, 0 where from the span.
    points0 : numpy.ndarray
        Shape (2 q,), in space (3 q,): positions of the points at the state that was exported, m.
    theta_names : tuple of str
        Of the rotation states.
    point_names : tuple of str
        Of the points: block and number on it.

    Raises
    ------
    DataError
        If shapes do not fit each other, or an entry is not a finite number.
    ArgumentTypeError
        If a name is not a text.
    """

    E: sp.coo_array
    J0: sp.coo_array
    R: sp.coo_array
    T: sp.coo_array
    K: sp.coo_array
    V: sp.coo_array
    Kg: sp.coo_array
    G: sp.coo_array
    Ku: sp.coo_array
    Vu: sp.coo_array
    W: sp.coo_array
    Wu: sp.coo_array
    alpha: sp.coo_array
    beta: sp.coo_array
    gamma: sp.coo_array
    r1: sp.coo_array
    r2: sp.coo_array
    stretch: sp.coo_array
    points: sp.coo_array
    theta0: Floats
    alpha0: Floats
    beta0: Floats
    free: Floats
    taut: Floats
    gamma0: Floats
    points0: Floats
    theta_names: tuple[str, ...]
    point_names: tuple[str, ...]

    def __post_init__(self) -> None:
        for key in LABELS:
            if not all(isinstance(name, str) for name in getattr(self, key)):
                raise ArgumentTypeError(f"nonlinear model: {key}", expected="texts", got="others", fix="Name them.")
            object.__setattr__(self, key, tuple(getattr(self, key)))
        for key in SHAPES:
            object.__setattr__(self, key, _entries(f"nonlinear model: {key}", getattr(self, key)))
        for key in LENGTHS:
            object.__setattr__(self, key, np.array(getattr(self, key), dtype=np.float64).reshape(-1))
        sizes = {"n": self.E.shape[0], "m": self.G.shape[1], "t": len(self.theta_names), "f": self.Kg.shape[1]}
        sizes |= {
            "a": self.alpha0.size,
            "d": self.beta0.size,
            "q": len(self.point_names),
            "p": (3 if self.points.shape[0] == 3 * len(self.point_names) else 2) * len(self.point_names),
        }
        wanted = {key: _shape(code, sizes) for key, code in (SHAPES | LENGTHS).items()}
        features = 1 + 2 * sizes["a"] + 2 * sizes["d"]
        wrong = [key for key, shape in wanted.items() if getattr(self, key).shape != shape]
        if wrong or sizes["f"] != features:
            key = wrong[0] if wrong else "Kg"
            expected = wanted[key] if wrong else (sizes["n"], features)
            raise DataError(
                f"nonlinear model: {key}",
                expected=f"shape {expected}",
                got=str(getattr(self, key).shape),
                fix="Correct.",
            )
        for key in SHAPES | LENGTHS:
            value = getattr(self, key)
            if not np.isfinite(value.data if sp.issparse(value) else value).all():
                raise DataError(f"nonlinear model: {key}", expected="finite numbers", got="others", fix="Correct them.")


def parts_of(model: NonlinearModel) -> dict[str, Any]:
    """Take a model apart.

    Parameters
    ----------
    model : NonlinearModel
        The model.

    Returns
    -------
    dict
        Its fields by name.
    """
    return {field.name: getattr(model, field.name) for field in fields(model)}


def _shape(code: str, sizes: dict[str, int]) -> tuple[int, ...]:
    if code.startswith("("):
        return (sizes[code[1]] * sizes[code[2]], sizes[code[4]])
    return tuple(sizes[letter] for letter in code)


def _entries(where: str, value: Any) -> sp.coo_array:
    try:
        array = sp.coo_array(value, dtype=np.float64, copy=True)
    except (TypeError, ValueError) as error:
        raise DataError(where, expected="a matrix of real numbers", got=repr(value)[:60], fix="Give one.") from error
    if array.ndim != 2:
        raise DataError(where, expected="two axes", got=f"shape {array.shape}", fix="Correct it.")
    array.sum_duplicates()
    array.eliminate_zeros()
    return array
