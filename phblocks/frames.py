"""Orientations of frames: angles in the plane, and frames of space that keep their angle to each other.

Rotations in the plane are linear combinations of features, ``Lambda(alpha) = cos(alpha) 1 + sin(alpha) QUARTER``; a
:class:`Turn` is an angle that depends linearly on the rotation states. In space an :class:`Attitude` says how a frame
stands at the start and what it turns with: two that turn with the same thing keep their rotation against each other,
and that is all that is known of them (no quaternions yet: features would be the entries of the rotation matrices).
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np

from phblocks.ports import Anchor
from phblocks.space import Space
from phblocks.triplets import Floats

#: Rotation by a quarter turn; the derivative of a planar rotation at the identity.
QUARTER: Floats = np.array([[0.0, -1.0], [1.0, 0.0]])

#: Cosines and sines of this size are those of quarter turns, whose angle is no number of the machine.
ROUND_OFF = 1e-15


def rotate(angle: Floats, vectors: Floats) -> Floats:
    """Turn vectors by angles, from a frame into the one it is turned against.

    Parameters
    ----------
    angle : numpy.ndarray
        Shape (...,), rad.
    vectors : numpy.ndarray
        Shape (..., 2), or (..., 3) to be turned about axis 3; broadcast against the angles.

    Returns
    -------
    numpy.ndarray
        ``Lambda(angle) vectors``, of as many components.
    """
    turned, flat = np.asarray(angle)[..., None], vectors[..., :2]
    moved = np.asarray(np.cos(turned) * flat + np.sin(turned) * (flat @ QUARTER.T))
    if vectors.shape[-1] == 2:
        return moved
    return np.concatenate([moved, np.broadcast_to(vectors[..., 2:], (*moved.shape[:-1], 1))], axis=-1)


def snapped(value: float) -> float:
    """Set a cosine or sine to zero that is zero up to the round-off of its angle.

    Parameters
    ----------
    value : float
        In [-1, 1].

    Returns
    -------
    float
        The value, or zero.
    """
    return value if abs(value) > ROUND_OFF else 0.0


@dataclass(frozen=True)
class Turn:
    """An angle: ``reference + sum of weights * theta[places]``.

    Parameters
    ----------
    places : tuple of int
        Rotation states, ascending.
    weights : tuple of float
        Not zero.
    reference : float
        Angle at the start, rad.
    """

    places: tuple[int, ...]
    weights: tuple[float, ...]
    reference: float

    @property
    def fixed(self) -> bool:
        """Whether the angle is constant."""
        return not self.places

    @property
    def none(self) -> bool:
        """Whether it is no turn at all, given that it is constant."""
        return self.reference == 0.0

    def minus(self, other: Turn) -> Turn:
        """Subtract another angle; rotation states that cancel are dropped.

        Parameters
        ----------
        other : Turn
            The angle to subtract.

        Returns
        -------
        Turn
            The difference.
        """
        total = dict(zip(self.places, self.weights, strict=True))
        for place, weight in zip(other.places, other.weights, strict=True):
            total[place] = total.get(place, 0.0) - weight
        kept = sorted((p, w) for p, w in total.items() if w != 0.0)
        return Turn(tuple(p for p, _ in kept), tuple(w for _, w in kept), self.reference - other.reference)

    def shifted(self, angle: float) -> Turn:
        """Add a constant.

        Parameters
        ----------
        angle : float
            rad.

        Returns
        -------
        Turn
            The sum.
        """
        return Turn(self.places, self.weights, self.reference + angle)

    def carrying(self, anchor: Anchor) -> Turn:
        """Return the orientation of an anchor that turns with this.

        Parameters
        ----------
        anchor : Anchor
            It keeps its initial angle to this.

        Returns
        -------
        Turn
            Of the anchor.
        """
        return self.shifted(anchor.angle - self.reference)

    def matrix(self) -> Floats:
        """Return the rotation matrix at the start; quarter turns are exact.

        Returns
        -------
        numpy.ndarray
            Shape (2, 2).
        """
        cos, sin = (snapped(f(self.reference)) for f in (math.cos, math.sin))
        return cos * np.eye(2) + sin * QUARTER


NO_TURN = Turn((), (), 0.0)


@dataclass(frozen=True, eq=False)
class Attitude:
    """Orientation of a frame of space: how it stands at the start, and what it turns with.

    Parameters
    ----------
    start : numpy.ndarray
        Its axes at the start as columns, shape (3, 3).
    turning : hashable or None
        What it turns with, the same for all frames that keep their rotation against each other; ``None`` if it does
        not turn. A block names the first of its states that are the angular velocity there.
    """

    start: Floats
    turning: Hashable = None

    @property
    def fixed(self) -> bool:
        """Whether it does not turn."""
        return self.turning is None

    @property
    def none(self) -> bool:
        """Whether it is no rotation at all, given that it does not turn."""
        return bool(np.array_equal(self.start, np.eye(3)))

    def minus(self, other: Attitude) -> Attitude:
        """Return the rotation from this frame into another.

        Parameters
        ----------
        other : Attitude
            The other.

        Returns
        -------
        Attitude
            It does not turn if both turn with the same thing.
        """
        relative = other.start.T @ self.start
        nearest = np.round(relative)
        relative = np.where(np.abs(relative - nearest) <= 8.0 * ROUND_OFF, nearest, relative)
        return Attitude(relative, None if self.turning == other.turning else (self.turning, other.turning))

    def carrying(self, anchor: Anchor) -> Attitude:
        """Return the orientation of an anchor that turns with this.

        Parameters
        ----------
        anchor : Anchor
            With a frame in space.

        Returns
        -------
        Attitude
            Of the anchor.
        """
        return Attitude(self.start if anchor.frame is None else anchor.frame, self.turning)

    def matrix(self) -> Floats:
        """Return the rotation matrix at the start.

        Returns
        -------
        numpy.ndarray
            Shape (3, 3).
        """
        return self.start


#: An orientation in the plane or in space.
Orientation = Turn | Attitude

AT_REST = Attitude(np.eye(3))


def standing(space: Space) -> Orientation:
    """Return the orientation of the fixed frame.

    Parameters
    ----------
    space : Space
        Of the model.

    Returns
    -------
    Turn or Attitude
        No rotation.
    """
    return AT_REST if space.turns("rotation") else NO_TURN
