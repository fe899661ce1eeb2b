"""Parts of J and R that depend on energy variables, and what only a quadratic energy allows."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from phblocks.blocks.modulation import Modulation
from phblocks.errors import StructureError
from phblocks.triplets import Floats, Ints, Triplets

if TYPE_CHECKING:
    from phblocks.system.system import System


def modulated(system: System, x: Floats, matrix: Callable[[Modulation, Floats], Floats]) -> sp.csr_array:
    """Put matrices that depend on energy variables where they act.

    Parameters
    ----------
    system : System
        The system.
    x : numpy.ndarray
        States, shape (n,).
    matrix : callable
        Which matrix of a modulation, at its energy variables.

    Returns
    -------
    scipy.sparse.csr_array
        Shape (n, n); zero where no block brings functions.
    """
    parts = [dense(m.on, m.on, matrix(m, x[m.by])) for m in system.modulations]
    return Triplets.join(parts).csr((system.n, system.n))


def modulation_slopes(system: System, x: Floats) -> sp.csr_array:
    """Differentiate ``(J - R) x`` by the energy variables that J and R depend on.

    Parameters
    ----------
    system : System
        The system.
    x : numpy.ndarray
        States, shape (n,).

    Returns
    -------
    scipy.sparse.csr_array
        Shape (n, n): what is to be added to J - R.
    """
    parts = [dense(m.on, m.by, np.einsum("ijk,j->ik", m.slope(x[m.by]), x[m.on])) for m in system.modulations]
    return Triplets.join(parts).csr((system.n, system.n))


def dense(rows: Ints, columns: Ints, matrix: Floats) -> Triplets:
    """List the entries of a small matrix at given rows and columns.

    Parameters
    ----------
    rows, columns : numpy.ndarray
        Where its rows and columns stand.
    matrix : numpy.ndarray
        Shape (rows.size, columns.size).

    Returns
    -------
    Triplets
        Without zeros.
    """
    i, j = np.nonzero(matrix)
    return Triplets.of(rows[i], columns[j], values=matrix[i, j])


def require_quadratic(system: System, what: str) -> None:
    """Refuse what only a quadratic energy allows.

    Parameters
    ----------
    system : System
        The system.
    what : str
        That is asked for.

    Raises
    ------
    StructureError
        If the energy is not quadratic.
    """
    if not system.quadratic:
        names = ", ".join(repr(p.name) for p in system.parts if p.form.storage is not None)
        raise StructureError(
            f"{what} of system {system.name!r}",
            expected="an energy that is quadratic in the states",
            got=f"another one in {names}",
            fix="Use matrices() or linearize() at a state.",
        )
