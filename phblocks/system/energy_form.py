"""Matrices in energy variables: momenta and elongations as states, E = 1, states without energy eliminated.

With z = Q x, and the states without energy marked 2, ``0 = A_21 z_1 + A_22 z_2 + B_2 u`` for ``A = J - R``,
``B = G - P`` gives z_2. What is left is the Schur complement of

    [  J - R         G - P     ]
    [ -(G + P)^T    -(S + N)   ]

in A_22. Its symmetric part stays negative semidefinite, so that the result is port-Hamiltonian again: J is the skew and
-R the symmetric part of its first block. Then ``y = E x`` are the states, with H = 1/2 y^T (Q E^-1) y.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from phblocks.errors import StructureError
from phblocks.export import Matrices
from phblocks.triplets import Ints


def in_energy_variables(m: Matrices, names: Sequence[str], units: Sequence[str]) -> Matrices:
    """Eliminate the states without energy and take E x of the others as states.

    Parameters
    ----------
    m : Matrices
        Rows and columns of zeros in E belong to states without energy; those that have nothing in J, R, G and P
        either are left out.
    names, units : sequence of str
        Of the energy variables, one for each state of m.

    Returns
    -------
    Matrices
        With E = 1 and without a tangent.

    Raises
    ------
    StructureError
        If states without energy do not follow from the others, or a constant load acts on them.
    """
    kept, free = _split(m)
    if m.f0[free].any():
        raise _refused(m, free[m.f0[free] != 0.0], "no constant load on states without energy", "one on")
    structure = sp.block_array([[m.J - m.R, m.G - m.P], [-(m.G + m.P).T, -(m.S + m.N)]], format="csr")
    n, inputs = m.E.shape[0], m.G.shape[1]
    left = np.concatenate([kept, n + np.arange(inputs)])
    rest = structure[left][:, left].toarray()
    if free.size:
        held = structure[free][:, free].toarray()
        size = np.sqrt(np.abs(held).max(axis=1) * np.abs(held).max(axis=0))
        if not size.all() or np.linalg.cond(held / np.sqrt(np.outer(size, size))) > 1e12:
            raise _refused(m, free, "states without energy that follow from the others", "constraints among")
        rest -= structure[left][:, free] @ np.linalg.solve(held, structure[free][:, left].toarray())
    k = kept.size
    A, B, C, D = rest[:k, :k], rest[:k, k:], -rest[k:, :k].T, -rest[k:, k:]
    E = m.E[kept][:, kept].toarray()
    Q = np.linalg.solve(E.T, m.Q[kept][:, kept].toarray().T).T
    return replace(
        m,
        about=f"{m.about}; in energy variables E x, states without energy eliminated",
        E=sp.eye_array(k),
        J=(A - A.T) / 2.0,
        R=-(A + A.T) / 2.0,
        Q=(Q + Q.T) / 2.0,
        G=(C + B) / 2.0,
        P=(C - B) / 2.0,
        S=(D + D.T) / 2.0,
        N=(D - D.T) / 2.0,
        x0=E @ m.x0[kept],
        f0=m.f0[kept],
        state_names=tuple(names[i] for i in kept),
        state_units=tuple(units[i] for i in kept),
        state_positions=m.state_positions[kept],
        tangent=None,
        nonlinear=None,
    )


def _split(m: Matrices) -> tuple[Ints, Ints]:
    """Which states have energy, and which have none but take part."""
    count = abs(m.E).sum(axis=0) + abs(m.E).sum(axis=1)
    rows = abs(m.J).sum(axis=1) + abs(m.R).sum(axis=1) + abs(m.G).sum(axis=1) + abs(m.P).sum(axis=1) + abs(m.f0)
    return np.flatnonzero(count > 0.0), np.flatnonzero((count == 0.0) & (rows > 0.0))


def _refused(m: Matrices, states: Ints, expected: str, got: str) -> StructureError:
    names = ", ".join(m.state_names[i] for i in states[:5])
    return StructureError(
        f"matrices of {m.name!r} in energy variables",
        expected=expected,
        got=f"{got} {names}" + (", ..." if len(states) > 5 else ""),
        fix="Use matrices() without energy_variables: a descriptor system, with these states.",
    )
