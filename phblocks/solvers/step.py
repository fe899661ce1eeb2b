"""What a time method returns for one accepted step."""

from __future__ import annotations

from dataclasses import dataclass

from phblocks.triplets import Floats


@dataclass(frozen=True)
class Step:
    """One accepted step, in scaled and reordered unknowns.

    Parameters
    ----------
    x : numpy.ndarray
        Unknowns at the end, shape (n,).
    theta : numpy.ndarray
        Rotation states at the end, shape (n_theta,), rad.
    z : numpy.ndarray
        Unknowns at the stages, shape (stages, n).
    theta_z : numpy.ndarray
        Rotation states at the stages, shape (stages, n_theta).
    u : numpy.ndarray
        Inputs at the stages, shape (stages, n_inputs).
    dt : float
        Length, s.
    iterations : int
        Newton iterations; 0 for a linear system.
    """

    x: Floats
    theta: Floats
    z: Floats
    theta_z: Floats
    u: Floats
    dt: float
    iterations: int
