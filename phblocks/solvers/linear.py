"""Factorisation of the Newton matrix: LAPACK's banded LU where the band is narrow, SuperLU elsewhere."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.linalg import lapack
from scipy.sparse.linalg import splu

from phblocks.triplets import Floats, Ints

#: Half-bandwidth up to which the banded factorisation is used.
WIDEST_BAND = 80


class LinearSolver(Protocol):
    """Factorises matrices of one pattern and solves with the last factor."""

    def factorise(self, data: Floats) -> bool:
        """Factorise; return False if the matrix is singular.

        Parameters
        ----------
        data : numpy.ndarray
            Entries on the pattern.

        Returns
        -------
        bool
            Whether a factor was found.
        """
        ...

    def solve(self, b: Floats) -> Floats:
        """Solve with the last factor.

        Parameters
        ----------
        b : numpy.ndarray
            Right-hand side, shape (n,).

        Returns
        -------
        numpy.ndarray
            Shape (n,).
        """
        ...


def band_places(rows: Ints, columns: Ints) -> tuple[int, Ints]:
    """Find the places of entries in a band as LAPACK stores it for a factor, column after column.

    Parameters
    ----------
    rows, columns : numpy.ndarray
        Places of the entries in the matrix.

    Returns
    -------
    width : int
        Half-bandwidth, at least 1.
    places : numpy.ndarray
        In an array of ``3 * width + 1`` numbers for each column.
    """
    width = max(1, int(np.abs(rows - columns).max(initial=0)))
    return width, np.asarray(columns * (3 * width + 1) + 2 * width + rows - columns, dtype=np.int64)


def is_narrow(rows: Ints, columns: Ints) -> bool:
    """Say whether a factorisation in a band is the faster one.

    Parameters
    ----------
    rows, columns : numpy.ndarray
        Places of the entries in the matrix.

    Returns
    -------
    bool
        Up to a half-bandwidth of :data:`WIDEST_BAND`.
    """
    return band_places(rows, columns)[0] <= WIDEST_BAND


class BandedSolver:
    """LAPACK ``gbtrf`` and ``gbtrs`` on one reused array.

    Parameters
    ----------
    rows, columns : numpy.ndarray
        Places of the entries.
    n : int
        Number of unknowns.
    kind : type, optional
        Of the entries, float or complex.

    Attributes
    ----------
    width : int
        Half-bandwidth.
    """

    def __init__(self, rows: Ints, columns: Ints, n: int, kind: type = float) -> None:
        self.width, self._spot = band_places(rows, columns)
        height = 3 * self.width + 1
        self._flat: NDArray[Any] = np.zeros(height * n, dtype=kind)
        self._gbtrf = lapack.dgbtrf if kind is float else lapack.zgbtrf
        self._gbtrs = lapack.dgbtrs if kind is float else lapack.zgbtrs
        self._band = self._flat.reshape((height, n), order="F")
        self._factor = self._band
        self._pivots = np.empty(0, dtype=np.int32)

    def factorise(self, data: Floats) -> bool:
        """Factorise; return False if the matrix is singular.

        Parameters
        ----------
        data : numpy.ndarray
            Entries on the pattern.

        Returns
        -------
        bool
            Whether a factor was found.
        """
        self._flat.fill(0.0)
        self._flat[self._spot] = data
        self._factor, self._pivots, info = self._gbtrf(self._band, self.width, self.width, overwrite_ab=1)
        return bool(info == 0)

    def solve(self, b: Floats) -> Floats:
        """Solve with the last factor.

        Parameters
        ----------
        b : numpy.ndarray
            Right-hand side, shape (n,).

        Returns
        -------
        numpy.ndarray
            Shape (n,).
        """
        x, _ = self._gbtrs(self._factor, self.width, self.width, b, self._pivots)
        return np.asarray(x)


class SparseSolver:
    """SuperLU with its own column order, for diagrams whose band is wide.

    Parameters
    ----------
    rows, columns : numpy.ndarray
        Places of the entries, sorted by rows.
    n : int
        Number of unknowns.
    kind : type, optional
        Of the entries, float or complex.
    """

    def __init__(self, rows: Ints, columns: Ints, n: int, kind: type = float) -> None:
        order = np.lexsort((rows, columns))
        self._order = order
        indptr = np.searchsorted(columns[order], np.arange(n + 1))
        self._matrix = sp.csc_array((np.zeros(order.size, dtype=kind), rows[order], indptr), shape=(n, n))

    def factorise(self, data: Floats) -> bool:
        """Factorise; return False if the matrix is singular.

        Parameters
        ----------
        data : numpy.ndarray
            Entries on the pattern.

        Returns
        -------
        bool
            Whether a factor was found.
        """
        self._matrix.data = data[self._order]
        try:
            self._factor = splu(self._matrix)
        except RuntimeError:
            return False
        return True

    def solve(self, b: Floats) -> Floats:
        """Solve with the last factor.

        Parameters
        ----------
        b : numpy.ndarray
            Right-hand side, shape (n,).

        Returns
        -------
        numpy.ndarray
            Shape (n,).
        """
        return np.asarray(self._factor.solve(b))


def linear_solver(rows: Ints, columns: Ints, n: int, kind: type = float) -> LinearSolver:
    """Choose a solver for a pattern.

    Parameters
    ----------
    rows, columns : numpy.ndarray
        Places of the entries, sorted by rows.
    n : int
        Number of unknowns.
    kind : type, optional
        Of the entries, float or complex.

    Returns
    -------
    LinearSolver
        Banded up to a half-bandwidth of :data:`WIDEST_BAND`.
    """
    return (BandedSolver if is_narrow(rows, columns) else SparseSolver)(rows, columns, n, kind)
