"""What ports exchange, from what each of them gives and where it points.

The matrices of a system carry power across a connection as ``z_t^T C z_g``. The same power is force times velocity in
the fixed frame, ``f . v`` with ``f = sum of Lambda output z`` over the pieces of the taking port and v likewise of the
giving one. The two have nothing in common but the outputs of the blocks, so that one can be held against the other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from phblocks.frames import rotate
from phblocks.system.angles import Angles
from phblocks.system.lines import Lines
from phblocks.triplets import Floats, Ints


@dataclass(frozen=True)
class Exchange:
    """The pieces of the ports on both sides of all connections.

    Parameters
    ----------
    outputs : scipy.sparse.csr_array
        Shape (n_pieces * dimension, n_coordinates): what each piece gives, in its frame; rows of components that a
        piece does not have are empty.
    frames : Angles
        Orientation of the frame of each piece. Rotation states that the system does not keep are left out: they turn
        both sides alike.
    line : numpy.ndarray
        Shape (n_pieces,): the line that a piece points along, -1 if none.
    giving, taking : scipy.sparse.csr_array
        Shape (n_connections, n_pieces): which pieces add up to what the giving and the taking port give.
    """

    outputs: sp.csr_array
    frames: Angles
    line: Ints
    giving: sp.csr_array
    taking: sp.csr_array

    def powers(self, lines: Lines, theta: Floats, x: Floats, coordinates: Floats) -> Floats:
        """Evaluate force times velocity at each connection.

        Parameters
        ----------
        lines : Lines
            Of the system.
        theta : numpy.ndarray
            Rotation states, shape (m, n_theta).
        x : numpy.ndarray
            States, shape (m, n).
        coordinates : numpy.ndarray
            Those of all blocks, shape (m, n_coordinates).

        Returns
        -------
        numpy.ndarray
            Shape (m, n_connections), W: from the giving to the taking block.
        """
        pieces, m = self.line.size, len(x)
        if not pieces:
            return np.zeros((m, self.giving.shape[0]))
        local = np.asarray((self.outputs @ coordinates.T).T).reshape(m, pieces, -1)
        fixed, turned = local.copy(), self._turned
        if turned.size:
            fixed[:, turned] = rotate(self.frames.at(theta.T)[turned].T, local[:, turned])
        along = np.flatnonzero(self.line >= 0)
        if along.size:
            fixed[:, along] = local[:, along, :1] * self._units(lines, x)
        stacked = fixed.transpose(1, 0, 2).reshape(pieces, -1)
        return np.asarray(((self.giving @ stacked) * (self.taking @ stacked)).reshape(-1, m, local.shape[2]).sum(2).T)

    @cached_property
    def _turned(self) -> Ints:
        """Pieces whose frame is not the fixed one, or turns."""
        return np.flatnonzero((self.frames.reference != 0.0) | (np.diff(self.frames.rows.indptr) > 0))

    def _units(self, lines: Lines, x: Floats) -> Floats:
        """Vectors along the lines of the pieces that point along one, shape (m, such pieces, dimension)."""
        line = self.line[self.line >= 0]
        return np.asarray(x[:, lines.spans[line]] / lines.lengths(x.T)[line].T[..., None])

    def held(self, lines: Lines, theta: Floats, x: Floats) -> Exchange:
        """Keep all directions as they are.

        Parameters
        ----------
        lines : Lines
            Of the system.
        theta : numpy.ndarray
            Rotation states, shape (n_theta,).
        x : numpy.ndarray
            States, shape (n,).

        Returns
        -------
        Exchange
            Without lines, and with frames that do not turn.
        """
        angle, size = self.frames.at(theta), np.ones(self.line.size)
        along = np.flatnonzero(self.line >= 0)
        if along.size:
            units = self._units(lines, x[None])[0]
            angle[along], size[along] = np.arctan2(units[:, 1], units[:, 0]), np.hypot(units[:, 0], units[:, 1])
        count = self.outputs.shape[0] // max(size.size, 1)
        return replace(
            self,
            outputs=sp.csr_array(sp.diags_array(np.repeat(size, count)) @ self.outputs),
            frames=Angles(sp.csr_array(self.frames.rows.shape), angle),
            line=np.full_like(self.line, -1),
        )
