"""Damping of a beam: drag on its velocities and internal damping of Kelvin-Voigt type.

Drag is an entry of R on V and W.  Internal damping is a second copy of N and M *without energy*, the viscous part of
the stress, whose equation says that it is proportional to the rate of strain:

    0 = d_s V + K x V + (e1 + Gamma) x W - N_v / (time / C_t)

The copy stands in every product in which N stands as the state (never as the strain that modulates), at the switch
and at the ends, where the force is N + N_v.  So J stays skew, R is constant and positive semidefinite, and an end
may take either quantity of its pair.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from phblocks.blocks.beam.mesh import Mesh
from phblocks.blocks.beam.tensors import component_index
from phblocks.blocks.checks import require_real
from phblocks.blocks.form import NO_ENERGY, StateRun
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.triplets import Floats, Ints, Triplets

#: What is added to the name of a stress component to name its viscous part.
VISCOUS_PART = "v"


@dataclass(frozen=True)
class Damping:
    """Damping of a beam, per length; whatever is zero costs nothing.

    Parameters
    ----------
    viscous : float, optional
        Drag on the velocity, N s/m^2: a force per length against V.
    rotary : float, optional
        Drag on the angular velocity, N s: a moment per length against W.
    internal : float or (float, float, float), optional
        Time of the Kelvin-Voigt law, s: stress = stiffness (strain + time * rate of strain). One number, or one each
        for extension, for shear (and torsion) and for bending. A mode of angular frequency omega has the damping
        ratio time omega / 2.

    Raises
    ------
    DataError
        If a number is negative or not finite.
    ArgumentTypeError
        If it is not a number.
    """

    viscous: float = 0.0
    rotary: float = 0.0
    internal: float | tuple[float, float, float] = 0.0

    def __post_init__(self) -> None:
        for name in ("viscous", "rotary"):
            object.__setattr__(self, name, _not_negative(f"Damping {name}", getattr(self, name)))
        internal = self.internal
        if isinstance(internal, (tuple, list)):
            if len(internal) != 3:
                raise ArgumentTypeError(
                    "Damping internal",
                    expected="a time, or three of them",
                    got=f"{len(internal)} values",
                    fix="Give (extension, shear, bending), s.",
                )
            object.__setattr__(self, "internal", tuple(_not_negative("Damping internal", t) for t in internal))
        else:
            object.__setattr__(self, "internal", _not_negative("Damping internal", internal))

    @property
    def drag(self) -> Floats:
        """Drag per length on each of the twelve components; zero for forces and moments."""
        return np.array([self.viscous] * 3 + [self.rotary] * 3 + [0.0] * 6)

    @property
    def times(self) -> Floats:
        """Kelvin-Voigt time of each of the twelve components, s; zero for velocities."""
        extension, shear, bending = self.internal if isinstance(self.internal, tuple) else (self.internal,) * 3
        return np.array([0.0] * 6 + [extension, shear, shear, shear, bending, bending])


@dataclass(frozen=True)
class DampedMatrices:
    """What damping makes of the matrices of a beam; E has no further entries.

    Parameters
    ----------
    runs : sequence of StateRun
        Those of the mesh and after them the viscous parts of the stresses.
    J0, R : Triplets
        Shape (size, size).
    T : Triplets
        Shape (size, size, size).
    copies : numpy.ndarray
        For each state of the mesh the state that is its viscous part, or -1.
    """

    runs: Sequence[StateRun]
    J0: Triplets
    R: Triplets
    T: Triplets
    copies: Ints


def damp(
    mesh: Mesh, matrices: tuple[Triplets, Triplets, Triplets], coefficients: Floats, damping: Damping
) -> DampedMatrices:
    """Add damping to the matrices of a beam.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.
    matrices : tuple of Triplets
        E, J0 and T without damping.
    coefficients : numpy.ndarray
        Shape (12,): inertias and compliances per length, which E contains.
    damping : Damping
        What is to be added.

    Returns
    -------
    DampedMatrices
        Runs and matrices; the very same objects where nothing is added.
    """
    E, J0, T = matrices
    copies = np.full(mesh.size, -1)
    factors = np.zeros(mesh.size)  # what a diagonal block of E is multiplied by in R
    runs: list[StateRun] = list(mesh.runs)
    first, count = 0, mesh.size
    for run in mesh.runs:
        component = component_index(run.field[0], int(run.field[1:]) - 1)
        states = slice(first, first + run.positions.size)
        if damping.drag[component] > 0.0:
            factors[states] = damping.drag[component] / coefficients[component]
        if damping.times[component] > 0.0 and coefficients[component] > 0.0:  # no strain has no rate
            factors[states] = 1.0 / damping.times[component]
            copies[states] = count + np.arange(run.positions.size)
            runs.append(replace(run, field=run.field + VISCOUS_PART, energy=NO_ENERGY))
            count += run.positions.size
        first = states.stop
    own = np.where(copies < 0, np.arange(mesh.size), copies)  # R acts on the viscous part where there is one
    rows, columns = E.indices
    damped = factors[rows] > 0.0
    return DampedMatrices(
        runs=tuple(runs),
        J0=_doubled(J0, copies),
        R=Triplets((own[rows[damped]], own[columns[damped]]), (E.values * factors[rows])[damped]),
        T=_doubled(T, copies),
        copies=copies,
    )


def _doubled(entries: Triplets, copies: Ints) -> Triplets:
    """Repeat the entries between a velocity and a stress for the viscous part; modulating fields stay as they are.

    No entry has a stress on both of the first two axes, and every entry stands together with its mirror: the result
    is skew to the last bit.
    """
    parts = [entries]
    for axis in (0, 1):
        moved = copies[entries.indices[axis]]
        keep = moved >= 0
        indices = tuple(moved[keep] if i == axis else index[keep] for i, index in enumerate(entries.indices))
        parts.append(Triplets(indices, entries.values[keep]))
    return Triplets.join(parts, order=len(entries.indices))


def _not_negative(where: str, value: object) -> float:
    number = require_real(where, value)
    if not (np.isfinite(number) and number >= 0.0):
        raise DataError(where, expected="zero or a positive number", got=repr(value), fix="Damping takes energy away.")
    return number
