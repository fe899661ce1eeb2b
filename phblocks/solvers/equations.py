"""The equations a stage is made of: those of the system, where two say nearly the same, their difference.

The viscous part N_v of a stress is a state without energy (:mod:`phblocks.blocks.beam.damping`). All that strains N
strains N_v too, and the form of the beam says so (``copies``):

    C N' = s(x),    0 = s(x) - (C / time) N_v

In a stiff beam both are small differences s of large velocities, divided by a compliance C of next to nothing: N and
N_v follow from them to as many digits as s has, which is none where C is small enough. Their difference,

    0 = C N' - (C / time) N_v,

has no s. Taken in the place of the second it determines N_v from N to round-off, whatever the stiffness. Solutions
are the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from phblocks.solvers.features import taken
from phblocks.system import System
from phblocks.system.scaling import state_scale
from phblocks.triplets import Floats, Ints, Triplets

#: What depends on states and orientations.
MODULATED = ("T", "K", "kinematics", "K_g", "K_u")


@dataclass(frozen=True)
class Equations:
    """Rows of the matrices of a system, as they are solved; columns belong to the states.

    Parameters
    ----------
    rate_matrix, J0, R0, inputs : scipy.sparse.csr_array
        What multiplies x', x and, for the last, u: G0 together with the kinematics of the inputs.
    T, K, kinematics, K_g, K_u : Triplets
        As in the system.
    followers : numpy.ndarray
        The states whose equations are differences.
    scale, size : numpy.ndarray
        Units of the states, and what equations are multiplied by to be of order one in them, shape (n,). Forces of one
        unit are of one kind: those without energy have that of the others that feel the same.
    """

    rate_matrix: sp.csr_array
    J0: sp.csr_array
    R0: sp.csr_array
    inputs: sp.csr_array
    T: Triplets
    K: Triplets
    kinematics: Triplets
    K_g: Triplets
    K_u: Triplets
    followers: Ints
    scale: Floats
    size: Floats

    @classmethod
    def of(cls, system: System) -> Equations:
        """Take them from a system.

        Parameters
        ----------
        system : System
            The system.

        Returns
        -------
        Equations
            The differences in the place of those of the followers.
        """
        scale = state_scale(system)
        equations = cls(
            system.rate_matrix, system.J0, system.R0, sp.csr_array(system.G0 + system.kinematics_u),
            Triplets.from_coo(system.T), system.K, system.kinematics, system.K_g, system.K_u,
            np.empty(0, dtype=np.int64), scale, scale,
        )  # fmt: skip
        followers, leaders = _followers(system)
        return equations._subtracted(followers, leaders) if followers.size else equations

    def _subtracted(self, followers: Ints, leaders: Ints) -> Equations:
        """Subtract the equations of the leaders; what both feel goes."""
        n = self.size.size
        minus = Triplets.of(followers, leaders, values=1.0).csr((n, n))
        R0, scale = sp.csr_array(self.R0 - minus @ self.R0), self.scale.copy()
        scale[followers] = scale[leaders]
        size = scale.copy()
        size[followers] = 1.0 / (R0.diagonal()[followers] * scale[followers])
        left = np.ones(n, dtype=bool)
        left[followers] = False
        keep = sp.diags_array(left.astype(np.float64))
        parts = {name: getattr(self, name) for name in MODULATED}
        return Equations(
            rate_matrix=sp.csr_array(self.rate_matrix - minus @ self.rate_matrix),
            J0=sp.csr_array(keep @ self.J0),
            R0=R0,
            inputs=sp.csr_array(keep @ self.inputs),
            followers=followers,
            scale=scale,
            size=size,
            **{name: taken(part, left[part.indices[0]]) for name, part in parts.items()},
        )


def _followers(system: System) -> tuple[Ints, Ints]:
    """Find the states that blocks declare to be copies, and what they are copies of.

    A pair counts where both are computed and neither is shared: what acts on one acts on the other then.
    """
    sharing = system.sharing
    alone = np.bincount(sharing.expansion.indices, minlength=system.n) == 1
    number = np.full(sharing.constant.size, -1)
    number[sharing.kept[alone]] = np.flatnonzero(alone)
    declared = [np.empty((2, 0), dtype=np.int64)]
    for part in system.parts:
        copied = np.flatnonzero(part.form.copies >= 0)
        declared.append(part.states.start + np.stack([part.form.copies[copied], copied]))
    followers, leaders = number[np.concatenate(declared, axis=1)]
    both = (followers >= 0) & (leaders >= 0)
    return followers[both], leaders[both]
