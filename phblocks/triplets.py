"""Sparse matrices and third-order tensors as lists of entries, the form in which blocks hand them over.

Blocks write entries in their own numbering; assembly shifts and joins them.  Only the assembled matrices become
``scipy.sparse`` arrays, so that a diagram of thousands of blocks costs one conversion and not thousands.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def real_array(value: object) -> Floats | None:
    """Make an array of what a user gave, if it is real numbers.

    Parameters
    ----------
    value : object
        A number, or numbers in a list, tuple or array.

    Returns
    -------
    numpy.ndarray or None
        A copy; ``None`` for texts, truth values, complex numbers, ``None`` and lists of unequal length.
    """
    try:
        array = np.array(value)
    except (TypeError, ValueError):
        return None
    return array.astype(np.float64) if array.dtype.kind in "iuf" else None


@dataclass(frozen=True, slots=True)
class Triplets:
    """Entries of a sparse array of any order; entries at the same place add up.

    Parameters
    ----------
    indices : tuple of numpy.ndarray
        One integer array of shape (n_entries,) per axis.
    values : numpy.ndarray
        Shape (n_entries,).
    """

    indices: tuple[Ints, ...]
    values: Floats

    @classmethod
    def of(cls, *indices: ArrayLike, values: ArrayLike) -> Triplets:
        """Broadcast indices and values against each other and flatten them.

        Parameters
        ----------
        *indices : array_like of int
            One per axis.
        values : array_like of float
            The entries.

        Returns
        -------
        Triplets
            The entries as flat arrays.
        """
        *ix, vals = np.broadcast_arrays(*indices, values)
        return cls(
            tuple(np.ascontiguousarray(i, dtype=np.int64).ravel() for i in ix),
            np.ascontiguousarray(vals, dtype=np.float64).ravel(),
        )

    @classmethod
    def empty(cls, order: int = 2) -> Triplets:
        """Return an array without entries.

        Parameters
        ----------
        order : int
            Number of axes.

        Returns
        -------
        Triplets
            No entries.
        """
        none = np.empty(0, dtype=np.int64)
        return cls((none,) * order, np.empty(0))

    @classmethod
    def join(cls, parts: Iterable[Triplets], order: int = 2) -> Triplets:
        """Concatenate lists of entries of the same order.

        Parameters
        ----------
        parts : iterable of Triplets
            The lists.
        order : int
            Number of axes, used when there are no parts.

        Returns
        -------
        Triplets
            All entries.
        """
        kept = [p for p in parts if p.values.size]
        if not kept:
            return cls.empty(order)
        if len(kept) == 1:
            return kept[0]
        indices = tuple(np.concatenate(axis) for axis in zip(*(p.indices for p in kept), strict=True))
        return cls(indices, np.concatenate([p.values for p in kept]))

    def shifted(self, *by: int) -> Triplets:
        """Move all entries.

        Parameters
        ----------
        *by : int
            Offset of each axis.

        Returns
        -------
        Triplets
            The moved entries.
        """
        return Triplets(tuple(i + b for i, b in zip(self.indices, by, strict=True)), self.values)

    def scaled(self, factor: float | Floats) -> Triplets:
        """Multiply the entries.

        Parameters
        ----------
        factor : float or numpy.ndarray
            One number, or one for each entry.

        Returns
        -------
        Triplets
            The multiplied entries.
        """
        return Triplets(self.indices, self.values * factor)

    @property
    def transposed(self) -> Triplets:
        """The entries with the first two axes exchanged."""
        i, j, *rest = self.indices
        return Triplets((j, i, *rest), self.values)

    @property
    def skew(self) -> Triplets:
        """The entries together with their negatives at the transposed places: skew to the last bit."""
        return Triplets.join([self, self.transposed.scaled(-1.0)], order=len(self.indices))

    @classmethod
    def from_coo(cls, array: sp.coo_array) -> Triplets:
        """Take the entries of a sparse array.

        Parameters
        ----------
        array : scipy.sparse.coo_array
            Of any order.

        Returns
        -------
        Triplets
            Its entries.
        """
        return cls(tuple(np.asarray(c, dtype=np.int64) for c in array.coords), array.data)

    def contracted(self, vector: Floats) -> Triplets:
        """Contract the last axis with a vector.

        Parameters
        ----------
        vector : numpy.ndarray
            As long as the last axis.

        Returns
        -------
        Triplets
            Of an order less by one.
        """
        *rest, last = self.indices
        return Triplets(tuple(rest), self.values * vector[last])

    def times(self, axis: int, matrix: sp.csr_array) -> Triplets:
        """Multiply one axis by a matrix.

        Parameters
        ----------
        axis : int
            The axis.
        matrix : scipy.sparse.csr_array
            Shape (length of the axis, new length).

        Returns
        -------
        Triplets
            Of the same order.
        """
        index = self.indices[axis]
        counts = np.diff(matrix.indptr)[index]
        entry = np.repeat(np.arange(index.size), counts)
        within = np.arange(entry.size) - np.repeat(np.cumsum(counts) - counts, counts)
        place = matrix.indptr[index[entry]] + within
        indices = [i[entry] for i in self.indices]
        indices[axis] = matrix.indices[place].astype(np.int64)
        return Triplets(tuple(indices), self.values[entry] * matrix.data[place])

    def coo(self, shape: Sequence[int]) -> sp.coo_array:
        """Convert to ``scipy.sparse``, adding up entries at the same place.

        Parameters
        ----------
        shape : sequence of int
            Length of each axis.

        Returns
        -------
        scipy.sparse.coo_array
            Of the given shape.
        """
        array = sp.coo_array((self.values, self.indices), shape=tuple(shape))
        array.sum_duplicates()
        return array

    def csr(self, shape: tuple[int, int]) -> sp.csr_array:
        """Convert a list of order two to a compressed sparse row array.

        Parameters
        ----------
        shape : tuple of int
            Rows and columns.

        Returns
        -------
        scipy.sparse.csr_array
            With sorted indices and without duplicates.
        """
        array = sp.csr_array((self.values, self.indices), shape=shape)
        array.sum_duplicates()
        return array
