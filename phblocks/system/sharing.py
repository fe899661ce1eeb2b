"""Blocks that share states: the coordinates of blocks, and the states of the system they follow from.

Every block has coordinates of its own. Where ends that all give velocity are welded, those of one follow from those of
another by a constant matrix, ``x_blocks = expansion x``; only the x are states of the system, and its matrices are
``expansion^T (those of the blocks) expansion``: ordinary finite-element assembly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

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
    """

    expansion: sp.csr_array
    kept: Ints
    groups: tuple[tuple[int, ...], ...]

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
        return cls(Triplets.join(entries).csr((n, kept.size)), kept, tuple(tuple(g) for g in groups))

    @property
    def trivial(self) -> bool:
        """Whether every coordinate is a state."""
        return not self.groups

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
            Shape (n_coordinates,) or (times, n_coordinates); the same array if nothing is shared.
        """
        return x if self.trivial else np.asarray((self.expansion @ x.T).T)

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
        return x[:, coordinates] if self.trivial else np.asarray((self.expansion[coordinates] @ x.T).T)

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
        for axis in axes:
            entries = entries.times(axis, self.expansion)
        return entries
