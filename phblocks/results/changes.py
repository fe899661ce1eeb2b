"""Energies of steps that are not of the equations: taken by the time method, added where loops were closed."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from phblocks.solvers.step import Step
from phblocks.triplets import Floats

#: From rows of unknowns, or of positions of material points, to energies by block.
Energies = Callable[[Floats], Floats]


def taken_by_method(steps: Sequence[Step], stored: Energies, blocks: int) -> Floats:
    """Evaluate what the time method took away in each step.

    Parameters
    ----------
    steps : sequence of Step
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
    found = [(i, step.damped) for i, step in enumerate(steps) if step.damped is not None]
    taken = np.zeros((len(steps), blocks))
    if found:
        at, damped = (np.array(of_all) for of_all in zip(*found, strict=True))
        taken[at] = stored(damped)
    return taken


def added_by_projection(steps: Sequence[Step], stored: Energies, potential: Energies, blocks: int) -> Floats:
    """Evaluate what closing loops added at the end of each step.

    Parameters
    ----------
    steps : sequence of Step
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
    found = [(i, s.x, s.before, s.shift) for i, s in enumerate(steps) if s.before is not None and s.shift is not None]
    added = np.zeros((len(steps), blocks))
    if found:
        at, after, before, shift = (np.array(of_all) for of_all in zip(*found, strict=True))
        added[at] = stored(after) - stored(before) + potential(shift)
    return added
