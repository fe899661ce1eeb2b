"""Rotations in the plane as linear combinations of features: ``Lambda(alpha) = cos(alpha) 1 + sin(alpha) QUARTER``.

A :class:`Turn` is an angle that depends linearly on the rotation states. What is written here is all that a
spatial version has to write anew (quaternions; features are then the entries of the rotation matrices).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

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
        Shape (..., 2), broadcast against the angles.

    Returns
    -------
    numpy.ndarray
        ``Lambda(angle) vectors``, shape (..., 2).
    """
    turned = np.asarray(angle)[..., None]
    return np.asarray(np.cos(turned) * vectors + np.sin(turned) * (vectors @ QUARTER.T))


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
