"""The part of a stage equation that belongs to matrices which depend on energy variables."""

from __future__ import annotations

import numpy as np

from phblocks.system import System
from phblocks.triplets import Floats, Ints


class ModulatedMatrices:
    """J(x) - R(x) at the stage, in scaled, reordered unknowns.

    Parameters
    ----------
    system : System
        The system; it has modulations.
    new : numpy.ndarray
        The unknown that each state is.
    scale : numpy.ndarray
        Of each state.
    slots : sequence of (numpy.ndarray, numpy.ndarray)
        For each modulation the places in the Jacobian of the states it acts on by themselves, and by those it depends
        on, by rows.

    Attributes
    ----------
    undefined : str
        The first matrix that was not finite and where, since it was last set to the empty text.
    """

    def __init__(self, system: System, new: Ints, scale: Floats, slots: list[tuple[Ints, Ints]]) -> None:
        self._parts = [
            (m, new[m.by], scale[m.by], new[m.on], scale[m.on], *places)
            for m, places in zip(system.modulations, slots, strict=True)
        ]
        self.noise = np.zeros(len(slots))
        self.undefined = ""

    def add(self, unknowns: Floats, residual: Floats, jacobian: Floats) -> None:
        """Add to residual and Jacobian of a stage.

        Parameters
        ----------
        unknowns : numpy.ndarray
            At the stage, shape (n,).
        residual, jacobian : numpy.ndarray
            Changed in place.
        """
        for k, (m, by, by_scale, on, on_scale, among, across) in enumerate(self._parts):
            x, z = unknowns[by] * by_scale, unknowns[on] * on_scale
            matrix = m.interconnection(x) - m.dissipation(x)
            residual[on] -= on_scale * (matrix @ z)
            jacobian[among] -= (matrix * np.outer(on_scale, on_scale)).ravel()
            slope = m.slope(x)
            finite = np.isfinite(matrix).all() and np.isfinite(slope).all()
            if not finite and not self.undefined and np.isfinite(x).all():
                self.undefined = m.undefined(x)
            turned = np.einsum("ijk,j->ik", slope, z)
            jacobian[across] -= (turned * np.outer(on_scale, by_scale)).ravel()
            size = on_scale * (np.abs(matrix) @ np.abs(z))
            self.noise[k] = np.finfo(float).eps * np.linalg.norm(size)
