"""Lines of action between two anchors, and their directions as features.

A line has a span r (the vector between its ends, states of its own) and a length l. A spring knows its length from
its force, ``l = free + N/k``; with the direction ``r / l`` the square of the length and that of the span change alike
under the midpoint rule and all Gauss methods, so elongation and geometry never separate. Other lines take ``l = |r|``.
The features are the direction as seen in the frames it acts in: ``e = Lambda^T r / l``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from phblocks.system.angles import Angles
from phblocks.triplets import Floats, Ints


@dataclass(frozen=True)
class Lines:
    """All lines of a system, and the frames their directions are seen in.

    Parameters
    ----------
    spans : numpy.ndarray
        Shape (n_lines, 2): the states that are the components of r.
    free : numpy.ndarray
        Shape (n_lines,): length at zero force, m.
    stretch : scipy.sparse.csr_array
        Shape (n_lines, n): what adds to it.
    taut : numpy.ndarray
        Shape (n_lines,): length from the states; otherwise the length is that of the span.
    line : numpy.ndarray
        Shape (n_directions,): the line of each direction.
    frames : Angles
        Orientation of the frame it is seen in.
    """

    spans: Ints
    free: Floats
    stretch: sp.csr_array
    taut: NDArray[np.bool_]
    line: Ints
    frames: Angles

    @classmethod
    def none(cls, n: int, n_theta: int) -> Lines:
        """Return no lines.

        Parameters
        ----------
        n, n_theta : int
            Numbers of states and rotation states.

        Returns
        -------
        Lines
            Empty.
        """
        empty = np.empty(0, dtype=np.int64)
        return cls(
            empty.reshape(0, 2),
            np.empty(0),
            sp.csr_array((0, n)),
            empty.astype(bool),
            empty,
            Angles(sp.csr_array((0, n_theta)), np.empty(0)),
        )

    @property
    def count(self) -> int:
        """Number of directions."""
        return int(self.line.size)

    def lengths(self, x: Floats) -> Floats:
        """Evaluate the length of each line.

        Parameters
        ----------
        x : numpy.ndarray
            States, shape (n,) or (n, m).

        Returns
        -------
        numpy.ndarray
            Shape (n_lines,) or (n_lines, m), m.
        """
        tail = (1,) * (x.ndim - 1)
        span = np.hypot(x[self.spans[:, 0]], x[self.spans[:, 1]])
        known = self.free.reshape(-1, *tail) + self.stretch @ x
        return np.asarray(np.where(self.taut.reshape(-1, *tail), known, span))

    def directions(self, theta: Floats, x: Floats) -> Floats:
        """Evaluate the features: first components of all directions, then second ones.

        Parameters
        ----------
        theta : numpy.ndarray
            Rotation states, shape (n_theta,) or (n_theta, m).
        x : numpy.ndarray
            States, shape (n,) or (n, m).

        Returns
        -------
        numpy.ndarray
            Shape (2 n_directions,) or (2 n_directions, m).
        """
        if not self.count:
            return np.empty((0, *x.shape[1:]))
        alpha = self.frames.at(theta)
        unit = x[self.spans[self.line]] / self.lengths(x)[self.line][:, None]
        cos, sin = np.cos(alpha), np.sin(alpha)
        return np.concatenate([cos * unit[:, 0] + sin * unit[:, 1], cos * unit[:, 1] - sin * unit[:, 0]])
