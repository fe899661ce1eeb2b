"""The part of a stage equation that belongs to storages whose energy is not quadratic."""

from __future__ import annotations

import numpy as np

from phblocks.system import System
from phblocks.triplets import Floats, Ints


class StorageEquations:
    """The gradients of the energies in their rows, in scaled, reordered unknowns.

    Parameters
    ----------
    system : System
        The system; it has storages.
    new : numpy.ndarray
        The unknown that each state is.
    scale : numpy.ndarray
        Of each state.
    slots : sequence of numpy.ndarray
        For each storage the places in the Jacobian of its Hessian, by rows.
    """

    def __init__(self, system: System, new: Ints, scale: Floats, slots: list[Ints]) -> None:
        self._storages = system.storages
        self._x = [new[s.energy] for s in self._storages]
        self._z = [new[s.coenergy] for s in self._storages]
        self._scale = [scale[s.energy] for s in self._storages]
        self._slots = slots
        self.noise = np.zeros(len(slots))

    def add(self, unknowns: Floats, before: Floats | None, residual: Floats, jacobian: Floats) -> None:
        """Add to residual and Jacobian of a stage.

        Parameters
        ----------
        unknowns : numpy.ndarray
            At the stage, shape (n,).
        before : numpy.ndarray or None
            Unknowns at the start of the step, for discrete gradients; ``None`` takes the gradients at the stage.
        residual, jacobian : numpy.ndarray
            Changed in place.
        """
        for k, (storage, x, scale) in enumerate(zip(self._storages, self._x, self._scale, strict=True)):
            at = unknowns[x] * scale
            if before is None:
                gradient, slope = np.asarray(storage.gradient(at)), np.asarray(storage.hessian(at))
            else:
                gradient, slope, noise = storage.discrete_gradient(before[x] * scale, at)
                self.noise[k] = noise
            residual[x] += gradient * scale
            jacobian[self._slots[k]] += (slope * np.outer(scale, scale)).ravel()

    def settle(self, unknowns: Floats) -> None:
        """Set the co-energy variables to the gradients.

        Parameters
        ----------
        unknowns : numpy.ndarray
            Shape (n,), changed in place.
        """
        for storage, x, z, scale in zip(self._storages, self._x, self._z, self._scale, strict=True):
            unknowns[z] = np.asarray(storage.gradient(unknowns[x] * scale)) * scale
