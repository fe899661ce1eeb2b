"""Energies of steps that are not of the equations: taken by the time method, added where loops were closed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from phblocks.solvers.step import Steps
from phblocks.triplets import Floats

#: From rows of unknowns, or of positions of material points, to energies by block.
Energies = Callable[[Floats], Floats]


def taken_by_method(steps: Steps, stored: Energies, blocks: int) -> Floats:
    """Evaluate what the time method took away in each step.

    Parameters
    ----------
    steps : Steps
        The steps.
    stored : callable
        Stored energies of unknowns of shape (m, n), shape (m, blocks), J.
    blocks : int
        How many there are.

    Returns
    -------
    numpy.ndarray
        Shape (steps, blocks), J.
    """
    return np.zeros((len(steps), blocks)) if steps.damped is None else stored(steps.damped)


def added_by_projection(steps: Steps, stored: Energies, potential: Energies, blocks: int) -> Floats:
    """Evaluate what closing loops added at the end of each step.

    Parameters
    ----------
    steps : Steps
        The steps.
    stored : callable
        Stored energies of unknowns of shape (m, n), shape (m, blocks), J.
    potential : callable
        Potential energies of gravity of positions of shape (m, n_points, dimension), shape (m, blocks), J.
    blocks : int
        How many there are.

    Returns
    -------
    numpy.ndarray
        Shape (steps, blocks), J.
    """
    if steps.before is None or steps.shift is None:
        return np.zeros((len(steps), blocks))
    return np.asarray(stored(steps.x) - stored(steps.before) + potential(steps.shift))
