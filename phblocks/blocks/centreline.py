"""The line of a block in space, in constant matrices: for checks of all blocks and many times at once."""

from __future__ import annotations

from dataclasses import dataclass

from phblocks.triplets import Floats, Triplets


@dataclass(frozen=True)
class Centreline:
    """How strain and orientation make a line, at its material points.

    Its tangent t is ``Lambda(angle) (e + strain x)`` with ``angle = reference + spin theta + lean x``, e the unit
    vector along it. By parts, ``sum of weight (arm - length/2) r = sum of weight kernel t`` for the positions r of the
    points: what strain says on the right, what velocity says on the left. Where position is known by its mean over an
    element only, arm is the middle of the element for all its points; else arm is place and kernel ``s (length - s) /
    2``.

    Parameters
    ----------
    strain : tuple of Triplets
        For each direction, shape (m, states).
    spin : Triplets
        Shape (m, rotation states).
    lean : Triplets
        Shape (m, states).
    reference : numpy.ndarray
        Shape (m,), rad.
    place, weight : numpy.ndarray
        Where the points are along the line, and the length that each stands for, shape (m,), m.
    arm, kernel : numpy.ndarray
        See above, shape (m,), m and m^2.
    length : float
        Of the whole line, m.
    """

    strain: tuple[Triplets, ...]
    spin: Triplets
    lean: Triplets
    reference: Floats
    place: Floats
    weight: Floats
    arm: Floats
    kernel: Floats
    length: float
