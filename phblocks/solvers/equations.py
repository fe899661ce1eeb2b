"""The equations a stage is made of: those of the system, where two say nearly the same, their difference.

The viscous part N_v of a stress is a state without energy (:mod:`phblocks.blocks.beam.damping`). All that strains N
strains N_v too:

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
        followers, leaders = _followers(system, equations)
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


def _followers(system: System, equations: Equations) -> tuple[Ints, Ints]:
    """Find states without energy that feel, to the last bit, what a state with energy feels; and these."""
    damped = np.flatnonzero(system.algebraic & ~system.coenergy & (system.R0.diagonal() > 0.0))
    leading = np.flatnonzero(~system.algebraic)
    if not damped.size or not leading.size:
        return damped[:0], damped[:0]
    parts = [_unfolded(getattr(equations, name), system.n) for name in MODULATED]
    felt = sp.csr_array(sp.hstack([equations.J0, equations.inputs, *parts]))
    felt.sort_indices()  # so that sums of equal rows are equal to the last bit
    mark = felt @ np.random.default_rng(0).uniform(1.0, 2.0, felt.shape[1])
    leading = leading[np.argsort(mark[leading])]
    leaders = leading[np.minimum(np.searchsorted(mark[leading], mark[damped]), leading.size - 1)]
    same = mark[leaders] == mark[damped]
    followers, leaders = damped[same], leaders[same]
    other = np.diff(sp.csr_array(felt[followers] != felt[leaders]).indptr) > 0
    return followers[~other], leaders[~other]


def _unfolded(entries: Triplets, n: int) -> sp.csr_array:
    """Lay all axes but the first one side by side, without columns of zeros."""
    first, *rest = entries.indices
    place = np.zeros_like(first)
    for index in rest:
        place = place * (int(index.max(initial=0)) + 1) + index
    used, column = np.unique(place, return_inverse=True)
    return Triplets((first, column), entries.values).csr((n, used.size))
