"""Blocks that share states: the coordinates of blocks, and the states of the system they follow from.

Every block has coordinates of its own. Where ends that all give velocity are welded, those of one follow from those of
another by a constant matrix, ``x_blocks = expansion x``; only the x are states of the system, and its matrices are
``expansion^T (those of the blocks) expansion``: ordinary finite-element assembly. Coordinates that are proven to stay
what they are (zero, or a place) have a row of zeros, and stand in ``constant``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from phblocks.triplets import Floats, Ints, Triplets


@dataclass(frozen=True)
class Sharing:
    """How the coordinates of all blocks follow from the states of the system.

    Parameters
    ----------
    expansion : scipy.sparse.csr_array
        Shape (n_coordinates, n).
    kept : numpy.ndarray
        Shape (n,): the coordinate that each state is.
    groups : tuple of tuple of int
        Numbers of the blocks that share states with each other, directly or through others; those that share none
        left out.
    constant : numpy.ndarray
        Shape (n_coordinates,): what coordinates are beside what follows from states; zero for those that are not left
        out.
    """

    expansion: sp.csr_array
    kept: Ints
    groups: tuple[tuple[int, ...], ...]
    constant: Floats

    @classmethod
    def of(cls, n: int, shared: Triplets, groups: Sequence[Sequence[int]]) -> Sharing:
        """Number the states.

        Parameters
        ----------
        n : int
            Number of coordinates.
        shared : Triplets
            Shape (n, n): rows of the coordinates that are no states, in terms of those that are.
        groups : sequence of sequence of int
            Blocks that share.

        Returns
        -------
        Sharing
            With the states in the order of the coordinates.
        """
        is_state = np.ones(n, dtype=bool)
        is_state[shared.indices[0]] = False
        kept = np.flatnonzero(is_state)
        number = np.cumsum(is_state) - 1
        rows, columns = shared.indices
        entries = [Triplets.of(kept, number[kept], values=1.0), Triplets((rows, number[columns]), shared.values)]
        expansion = Triplets.join(entries).csr((n, kept.size))
        return cls(expansion, kept, tuple(tuple(g) for g in groups), np.zeros(n))

    def without(self, dropped: NDArray[np.bool_], constant: Floats) -> Sharing:
        """Leave coordinates out that stay what they are.

        Parameters
        ----------
        dropped : numpy.ndarray
            Shape (n_coordinates,): which; with a state all coordinates that follow from it.
        constant : numpy.ndarray
            Shape (n_coordinates,): what they are; others are not looked at.

        Returns
        -------
        Sharing
            With fewer states.
        """
        stay = ~dropped[self.kept]
        return Sharing(
            sp.csr_array(self.expansion[:, np.flatnonzero(stay)]),
            self.kept[stay],
            self.groups,
            np.where(dropped, constant, 0.0),
        )

    @property
    def trivial(self) -> bool:
        """Whether every coordinate is a state."""
        return bool(self.kept.size == self.constant.size)

    def state_of(self, coordinates: Ints) -> Ints:
        """Number coordinates that no other block shares.

        Parameters
        ----------
        coordinates : numpy.ndarray
            Of blocks.

        Returns
        -------
        numpy.ndarray
            The states they are.
        """
        return np.asarray(np.searchsorted(self.kept, coordinates), dtype=np.int64)

    def expand(self, x: Floats) -> Floats:
        """Find the coordinates of all blocks.

        Parameters
        ----------
        x : numpy.ndarray
            States, shape (n,) or (times, n).

        Returns
        -------
        numpy.ndarray
            Shape (n_coordinates,) or (times, n_coordinates); the same array if every coordinate is a state.
        """
        return x if self.trivial else np.asarray((self.expansion @ x.T).T) + self.constant

    def of_block(self, x: Floats, coordinates: slice) -> Floats:
        """Find the coordinates of one block.

        Parameters
        ----------
        x : numpy.ndarray
            States, shape (times, n).
        coordinates : slice
            Those of the block.

        Returns
        -------
        numpy.ndarray
            Shape (times, coordinates of the block).
        """
        if self.trivial:
            return x[:, coordinates]
        return np.asarray((self.expansion[coordinates] @ x.T).T) + self.constant[coordinates]

    def reduced(self, entries: Triplets, axes: Sequence[int]) -> Triplets:
        """Project entries on the states.

        Parameters
        ----------
        entries : Triplets
            In coordinates of blocks.
        axes : sequence of int
            Those that count coordinates.

        Returns
        -------
        Triplets
            In states.
        """
        if self.trivial:
            return entries
        if not self.groups:
            number = np.full(self.constant.size, -1)
            number[self.kept] = np.arange(self.kept.size)
            indices = [number[i] if axis in axes else i for axis, i in enumerate(entries.indices)]
            stay = np.all([indices[axis] >= 0 for axis in axes], axis=0)
            return Triplets(tuple(i[stay] for i in indices), entries.values[stay])
        for axis in axes:
            entries = entries.times(axis, self.expansion)
        return entries
