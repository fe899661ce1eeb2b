"""Plain state-space models, ``x' = A x + B u``, ``y = C x + D u``, of the tangent or of the port-Hamiltonian matrices.

python-control and SciPy know no E: it is inverted by a factorisation, and refused where it is singular. States that
have no rate but follow from the others (index 1) can be eliminated first; of a tangent, those states marked 2,

    0 = A_21 d_1 + A_22 d_2 + B_2 u,    A <- A_11 - A_12 A_22^-1 A_21,    B, C and D likewise: exact.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from phblocks.errors import StructureError
from phblocks.export.matrices import Matrices, Tangent
from phblocks.triplets import Floats, Ints

#: A matrix whose states, scaled, are nearer to dependent than this counts as singular.
CONDITION = 1e13


@dataclass(frozen=True, eq=False)
class StateSpace:
    """``x' = A x + B u``, ``y = C x + D u``, dense, with names.

    Parameters
    ----------
    A, B, C, D : numpy.ndarray
        Shape (k, k), (k, m), (m, k), (m, m).
    state_names : tuple of str
        Of the k states.
    """

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    state_names: tuple[str, ...]


def tangent_of(m: Matrices) -> Tangent:
    """Return the tangent of matrices; without one, the port-Hamiltonian matrices multiplied out.

    Parameters
    ----------
    m : Matrices
        Such as :func:`phblocks.export.read` returns.

    Returns
    -------
    Tangent
        Its A is ``(J - R) Q``, B ``G - P``, C ``(G + P)^T Q`` and D ``S + N`` if there was none.
    """
    if m.tangent is not None:
        return m.tangent
    names, units = m.state_names, m.state_units
    return Tangent(
        A=(m.J - m.R) @ m.Q,
        B=m.G - m.P,
        C=(m.G + m.P).T @ m.Q,
        D=m.S + m.N,
        E=m.E,
        state_names=names,
        state_units=units,
    )


def state_space(m: Matrices, eliminate: bool = False) -> StateSpace:
    """Invert E.

    Parameters
    ----------
    m : Matrices
        Their tangent is taken; without one, the port-Hamiltonian matrices multiplied out.
    eliminate : bool, optional
        Eliminate states without a rate first.

    Returns
    -------
    StateSpace
        Dense.

    Raises
    ------
    StructureError
        If E is singular, or states that are to be eliminated do not follow from the others.
    """
    where, t = f"state-space model of {m.name!r}", tangent_of(m)
    A, B, C, D = t.A, t.B, t.C, t.D
    kept, free = rated(t.E)
    if free.size and not eliminate:
        raise _refused(where, t, free, "an E that can be inverted", "no rate of", "Use eliminate=True, or to_pymor().")
    E = t.E[kept][:, kept]
    if free.size:
        among = _factor(A[free][:, free])
        if among is None:
            fix = "They are multipliers of constraints (joints with inertia on both sides): use to_pymor()."
            raise _refused(
                where, t, free, "states without a rate that follow from the others", "constraints among", fix
            )
        by_states, by_inputs = (among.solve(M.toarray()) for M in (A[free][:, kept], B[free]))
        A, B, C, D = (
            A[kept][:, kept] - A[kept][:, free] @ by_states,
            B[kept] - A[kept][:, free] @ by_inputs,
            C[:, kept] - C[:, free] @ by_states,
            D - C[:, free] @ by_inputs,
        )
    factor = _factor(E)
    if factor is None:
        raise _refused(where, t, kept, "an E that can be inverted", "a singular one of", "Use to_pymor().")
    A, B, C, D = (np.asarray(M.toarray() if sp.issparse(M) else M) for M in (A, B, C, D))
    return StateSpace(factor.solve(A), factor.solve(B), C, D, tuple(t.state_names[i] for i in kept))


def transfer(m: Matrices | Tangent, s: complex) -> Any:
    """Evaluate the transfer function ``C (s E - A)^-1 B + D``.

    Parameters
    ----------
    m : Matrices or Tangent
        Of matrices the port-Hamiltonian ones are taken, not their tangent; what has no equation (spans) is left out.
    s : complex
        Such as ``2j * pi * frequency``, 1/s.

    Returns
    -------
    numpy.ndarray
        Shape (n_outputs, n_inputs), complex.
    """
    if isinstance(m, Matrices):
        A, B, C, D, E = (m.J - m.R) @ m.Q, m.G - m.P, (m.G + m.P).T @ m.Q, m.S + m.N, m.E
        used = takes_part(m)
        A, B, C, E = A[used][:, used], B[used], C[:, used], E[used][:, used]
    else:
        A, B, C, D, E = m.A, m.B, m.C, m.D, m.E
    inner = splu(sp.csc_array(s * E - A)).solve(B.toarray().astype(complex)) if A.shape[0] else np.zeros(B.shape)
    return C @ inner + D.toarray()


def rated(E: sp.csr_array) -> tuple[Ints, Ints]:
    """Tell states with a rate from those without.

    Parameters
    ----------
    E : scipy.sparse.csr_array
        Shape (n, n).

    Returns
    -------
    kept, free : numpy.ndarray
        Their indices: those with an entry in their row or column of E, and the others.
    """
    size = np.asarray(abs(E).sum(axis=0) + abs(E).sum(axis=1))
    return np.flatnonzero(size > 0.0), np.flatnonzero(size == 0.0)


def takes_part(m: Matrices) -> Ints:
    """Find the states with an entry in any matrix.

    Parameters
    ----------
    m : Matrices
        The matrices.

    Returns
    -------
    numpy.ndarray
        All but spans of lines and distances along guides, whose rates only the nonlinear model and the tangent have.
    """
    rows = [abs(M).sum(axis=1) for M in (m.E, m.J, m.R, m.G, m.P)]
    return np.flatnonzero(np.sum(rows, axis=0) + abs(m.E).sum(axis=0) > 0.0)


def legal_names(names: Iterable[str]) -> list[str]:
    """Make names of letters, digits and underscores, different from each other.

    Parameters
    ----------
    names : iterable of str
        Such as ``"crank.V1[0]"``.

    Returns
    -------
    list of str
        Such as ``"crank_V1_0"``; a number is added to a name that is taken already.
    """
    found: dict[str, None] = {}
    for name in names:
        plain = re.sub(r"\W+", "_", name).strip("_") or "unnamed"
        new, count = plain, 1
        while new in found:
            count += 1
            new = f"{plain}_{count}"
        found[new] = None
    return list(found)


def _factor(matrix: sp.csr_array) -> Any:
    """Factorise a matrix; ``None`` if it is singular. Rows and columns are scaled to tell."""
    columns, rows = (np.asarray(abs(matrix).max(axis=i).todense()).ravel() for i in (0, 1))
    if not (rows.all() and columns.all()):
        return None
    try:
        factor = splu(sp.csc_array(matrix))
    except RuntimeError:  # exactly singular
        return None
    size = sp.diags_array(1.0 / np.sqrt(rows)), sp.diags_array(1.0 / np.sqrt(columns))
    pivots = np.abs(splu(sp.csc_array(size[0] @ matrix @ size[1])).U.diagonal())
    return factor if pivots.min(initial=1.0) * CONDITION > pivots.max(initial=1.0) else None


def _refused(where: str, t: Tangent, states: Ints, expected: str, got: str, fix: str) -> StructureError:
    names = ", ".join(t.state_names[i] for i in states[:5]) + (", ..." if states.size > 5 else "")
    return StructureError(where, expected=expected, got=f"{got} {names}", fix=fix)
