"""Units in which all states are of one size."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from phblocks.triplets import Floats

if TYPE_CHECKING:
    from phblocks.system.system import System


def state_scale(system: System) -> Floats:
    """Return the size of each state that carries energy of order one.

    States without energy (multipliers, states of stateless parts: a row of zeros in E) are scaled so that their
    largest entry in J or R, seen with the other states in their units, is one per second.

    Parameters
    ----------
    system : System
        The system.

    Returns
    -------
    numpy.ndarray
        Shape (n,), in the unit of each state.
    """
    diagonal = system.E.diagonal()
    carries = diagonal > 0.0  # also for matrices that are still to be verified
    scale = np.where(carries, 1.0 / np.sqrt(np.where(carries, diagonal, 1.0)), 1.0)
    for storage in system.storages:
        carries[storage.energy] = carries[storage.coenergy] = True
        scale[storage.energy], scale[storage.coenergy] = storage.size, 1.0 / storage.size
    if not carries.all():
        coupling = abs(system.J()) @ np.where(carries, scale, 0.0)
        damping = system.R.diagonal()
        free = ~carries
        size = np.maximum(coupling, np.sqrt(np.abs(damping)))
        scale[free] = 1.0 / np.where(size[free] > 0.0, size[free], 1.0)
    return scale
