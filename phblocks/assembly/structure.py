"""Verification of the port-Hamiltonian structure of an assembled system."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from phblocks.errors import StructureError
from phblocks.system import System
from phblocks.system.scaling import state_scale
from phblocks.system.undetermined import made_by
from phblocks.triplets import Ints

TOLERANCE = 1e-12


def check_structure(system: System) -> None:
    """Verify that E and R are symmetric and positive (semi)definite, and J skew.

    J is checked at a pseudo-random state and configuration, which exercises all of J0, T and K.

    Parameters
    ----------
    system : System
        The system.

    Raises
    ------
    StructureError
        Naming the matrix and the states concerned.
    """
    for name, matrix in (("E", system.E), ("R", system.R)):
        _require_small(system, name, "symmetric", matrix - matrix.T, matrix)
    random = np.random.default_rng(0)
    x, theta = random.standard_normal(system.n), random.standard_normal(system.start.theta.size)
    # scaled by the square root of the energy, so that forces and velocities are of one size
    x = x * state_scale(system)
    for m in system.modulations:  # functions of the user's need not be defined everywhere
        x[m.by] = system.start.x[m.by]
    J = system.J(x, theta)
    _require_small(system, "J", "skew", J + J.T, J)
    _require_definite(system, "E", "definite", system.E, np.flatnonzero(system.carries_energy))
    _require_definite(system, "R", "semidefinite", system.R, np.flatnonzero(abs(system.R).sum(axis=0)))


def _require_small(system: System, name: str, what: str, defect: sp.csr_array, matrix: sp.csr_array) -> None:
    size = np.abs(matrix.data).max() if matrix.nnz else 0.0
    entries = defect.tocoo()
    bad = np.flatnonzero(~(np.abs(entries.data) <= TOLERANCE * size))
    if bad.size:
        i, j = (int(axis[bad[0]]) for axis in entries.coords)
        where = dict.fromkeys(_told(system, state) for state in (i, j))
        raise StructureError(
            f"{name} of system {system.name!r}",
            expected=f"a {what} matrix",
            got=f"a defect of {entries.data[bad[0]]:.3g} at ({system.state_names[i]}, {system.state_names[j]})",
            fix=f"Check the matrices of {' and '.join(where)}.",
        )


def _told(system: System, state: int) -> str:
    """The block of a state, and the call that added it."""
    block = next((p.name for p in system.parts if system.state_names[state].startswith(f"{p.name}.")), "")
    return f"{block!r}{made_by(system, block)}"


def _require_definite(system: System, name: str, expected: str, matrix: sp.csr_array, used: Ints) -> None:
    """Banded Cholesky of the states that take part, scaled to unit diagonal and shifted by round-off."""
    from scipy.linalg import LinAlgError, cholesky_banded
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    diagonal = matrix.diagonal()
    bad = used[~(diagonal[used] > 0.0)]
    if bad.size:
        raise StructureError(
            f"{name} of system {system.name!r}",
            expected=f"a positive {expected} matrix, so positive diagonal entries",
            got=f"{diagonal[bad[0]]!r} at {system.state_names[bad[0]]}",
            fix=f"Check the inertias, compliances and dampings of {_told(system, int(bad[0]))}.",
        )
    if not used.size:
        return
    scale = 1.0 / np.sqrt(diagonal[used])
    matrix = sp.csr_array(sp.diags_array(scale) @ matrix[used][:, used] @ sp.diags_array(scale))
    order = reverse_cuthill_mckee(sp.csr_matrix(matrix), symmetric_mode=True)
    scaled = sp.coo_array(matrix[order][:, order])
    row, column = scaled.coords
    upper = column >= row
    width = int((column - row).max(initial=0))
    band = np.zeros((width + 1, used.size))
    band[width + (row - column)[upper], column[upper]] = scaled.data[upper]
    band[width] += 1e-10
    try:
        cholesky_banded(band)
    except LinAlgError:
        raise StructureError(
            f"{name} of system {system.name!r}",
            expected=f"a positive {expected} matrix",
            got="one with a negative direction",
            fix="Check the inertias, compliances and dampings of the blocks.",
        ) from None
