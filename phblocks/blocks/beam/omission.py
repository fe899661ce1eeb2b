"""What is left out of the numbers of a beam: compliances and inertias of zero, and so states without energy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from phblocks.approximation import Approximation
from phblocks.blocks.beam.damping import Damping
from phblocks.blocks.beam.tensors import component_index
from phblocks.blocks.form import NO_ENERGY, StateRun
from phblocks.triplets import Floats

#: Components of the twelve that each effect is the energy of.
COMPONENTS = {
    "extension": (component_index("N", 0),),
    "shear": (component_index("N", 1), component_index("N", 2)),
    "rotary_inertia": tuple(component_index("W", d) for d in range(3)),
}


def kept_coefficients(coefficients: Floats, kept: Approximation) -> tuple[Floats, Floats]:
    """Set inertias and compliances to zero.

    Parameters
    ----------
    coefficients : numpy.ndarray
        Shape (12,): all of them.
    kept : Approximation
        What is kept.

    Returns
    -------
    coefficients : numpy.ndarray
        Shape (12,): of E; the very same array if all are kept.
    modulating : numpy.ndarray
        Shape (12,): of T. The second-order theory has no products with the axial strain.
    """
    gone = [c for name, components in COMPONENTS.items() if not getattr(kept, name) for c in components]
    left = _without(coefficients, gone)
    second_order = kept.large_rotation == "second-order"
    return left, _without(left, COMPONENTS["extension"]) if second_order else left


def _without(coefficients: Floats, components: Sequence[int]) -> Floats:
    if not components:
        return coefficients
    left = coefficients.copy()
    left[list(components)] = 0.0
    return left


def kept_damping(damping: Damping, kept: Approximation) -> Damping:
    """Leave out internal damping, or that of strains that are left out: no strain, no viscous stress of its own.

    Parameters
    ----------
    damping : Damping
        Of the beam.
    kept : Approximation
        What is kept.

    Returns
    -------
    Damping
        With times of zero in the place of the others.
    """
    inner = damping.internal
    times = inner if isinstance(inner, tuple) else (inner, inner, inner)
    keeps = np.array([kept.extension, kept.shear, True]) & kept.internal_damping
    extension, shear, bending = (time if keep else 0.0 for time, keep in zip(times, keeps, strict=True))
    return replace(damping, internal=(extension, shear, bending))


def without_energy(runs: Sequence[StateRun], coefficients: Floats) -> Sequence[StateRun]:
    """Mark the states whose inertia or compliance is zero: they are forces or motions that a constraint determines.

    Parameters
    ----------
    runs : sequence of StateRun
        Of the beam.
    coefficients : numpy.ndarray
        Shape (12,): of E.

    Returns
    -------
    sequence of StateRun
        The same states.
    """
    return tuple(
        replace(run, energy=NO_ENERGY)
        if coefficients[component_index(run.field[0], int(run.field[1]) - 1)] == 0.0
        else run
        for run in runs
    )


def sizes(runs: Sequence[StateRun], name: str) -> int:
    """Count the states of an effect.

    Parameters
    ----------
    runs : sequence of StateRun
        Of the beam.
    name : str
        One of :data:`COMPONENTS`.

    Returns
    -------
    int
        How many there are, with or without energy.
    """
    fields = {f"{'VWNM'[c // 3]}{c % 3 + 1}" for c in COMPONENTS[name]}
    return sum(run.positions.size for run in runs if run.field in fields)
