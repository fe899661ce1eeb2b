"""Momentum of what nothing outside acts on: a free part of a diagram keeps it, a scheme need not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from phblocks.frames import rotate
from phblocks.space import LEVI_CIVITA
from phblocks.triplets import Floats, Ints, Triplets

if TYPE_CHECKING:
    from phblocks.results.solution import Solution
    from phblocks.system import System

#: Forces on a rigid motion below this, relative to the largest there are, are round-off.
RIGID = 1e-9


@dataclass(frozen=True)
class FreeBody:
    """Blocks joined to each other and to nothing else, on which no load, gravity or drag acts.

    Parameters
    ----------
    blocks : tuple of str
        Their names.
    points : numpy.ndarray
        Numbers of their material points.
    spin : numpy.ndarray or None
        What makes the moment of momentum of cross sections and bodies about their own centres of their coordinates,
        shape (rotations, n_coordinates), kg m^2; ``None`` if only linear momentum is kept (a part drives against the
        frame).
    """

    blocks: tuple[str, ...]
    points: Ints
    spin: Floats | None

    @property
    def name(self) -> str:
        """The blocks, the first three by name."""
        shown = " + ".join(self.blocks[:3])
        return shown if len(self.blocks) <= 3 else f"{shown} + {len(self.blocks) - 3} more"


def free_bodies(system: System) -> Sequence[FreeBody]:
    """Find them; what was found is kept with the system.

    Parameters
    ----------
    system : System
        The system.

    Returns
    -------
    sequence of FreeBody
        None in most systems.
    """
    known = system.prepared.get("free bodies")
    if not isinstance(known, tuple):
        known = system.prepared["free bodies"] = tuple(_found(system))
    return known


def momentum_drift(solution: Solution, body: FreeBody) -> tuple[Floats, Floats | None]:
    """Measure how far a free body departs from the momentum it began with.

    Parameters
    ----------
    solution : Solution
        Of a run.
    body : FreeBody
        One of :func:`free_bodies`.

    Returns
    -------
    linear : numpy.ndarray
        ``|p(t) - p(0)|`` over the largest ``sum of m |v|``, shape (times,); zero for what never moves.
    angular : numpy.ndarray or None
        The same of the moment of momentum about the place where the centre was at the start.
    """
    system, recording = solution.system, solution.recording
    mass, d = system.point_mass[body.points], system.dimension
    rows = (body.points[:, None] * d + np.arange(d)).ravel()
    v = np.asarray((system.point_velocity[rows] @ recording.x.T).T).reshape(recording.t.size, -1, d)
    v = rotate(system.point_angles.at(recording.theta.T).T[:, body.points], v)
    linear = np.einsum("m,tmd->td", mass, v)
    size = np.einsum("m,tm->t", mass, np.linalg.norm(v, axis=2))
    drift = _relative(np.linalg.norm(linear - linear[0], axis=1), size)
    if body.spin is None:
        return drift, None
    places = recording.points[:, body.points]
    arm = places - mass @ places[0] / mass.sum()
    own = system.sharing.expand(recording.x) @ body.spin.T
    axes = LEVI_CIVITA[np.ix_(system.space.rotation, range(d), range(d))]
    angular = np.einsum("m,kij,tmi,tmj->tk", mass, axes, arm, v) + own
    reach = np.einsum("m,tm->t", mass, np.linalg.norm(arm, axis=2) * np.linalg.norm(v, axis=2))
    apart = np.linalg.norm(angular - angular[0], axis=1)
    return drift, _relative(apart, reach + np.linalg.norm(own, axis=1))


def _relative(apart: Floats, size: Floats) -> Floats:
    largest = float(size.max())
    return apart / largest if largest > 0.0 else np.zeros(apart.size)


def _found(system: System) -> Sequence[FreeBody]:
    """Components of the diagram whose rigid motions meet no force at all at the start."""
    held = np.array([part.block.shared for part in system.parts])
    held[_loaded(system)] = True
    pairs = [*map(tuple, system.connections.blocks), *((g[0], b) for g in system.sharing.groups for b in g[1:])]
    n = len(system.parts)
    graph = Triplets.of([a for a, _ in pairs], [b for _, b in pairs], values=1.0).csr((n, n))
    count, label = connected_components(graph, directed=False)
    bound = np.bincount(label, weights=held, minlength=count) > 0.0
    loose = np.flatnonzero(~bound)
    return [body for c in loose if (body := _body(system, np.flatnonzero(label == c))) is not None]


def _loaded(system: System) -> Ints:
    """Blocks on which an input or gravity acts."""
    first = np.array([part.states.stop for part in system.parts])
    rows = system.connections.supply.indices[0]
    weighed = [
        i
        for i, part in enumerate(system.parts)
        if system.gravity.any() and part.form.points is not None and part.form.points.weighs
    ]
    return np.unique(np.concatenate([np.searchsorted(first, rows, side="right"), weighed])).astype(np.int64)


def _body(system: System, members: Ints) -> FreeBody | None:
    """A component, if it may translate freely; of other than mechanical parts there are no points."""
    parts = [system.parts[i] for i in members]
    moving = [part for part in parts if part.form.points is not None]
    if not moving or any(part.points.stop == part.points.start for part in moving):
        return None
    points = np.concatenate([np.arange(part.points.start, part.points.stop) for part in moving])
    if not system.point_mass[points].any():
        return None
    still, spins = np.zeros(system.dimension), _unit_spins(system)
    if not all(_moves_freely(system, members, velocity, 0.0 * spins[0]) for velocity in np.eye(system.dimension)):
        return None
    names = tuple(part.name for part in parts)
    if not all(_moves_freely(system, members, still, spin) for spin in spins):
        return FreeBody(names, points, None)
    return FreeBody(names, points, np.stack([_own_inertia(system, members, spin) for spin in spins]))


def _unit_spins(system: System) -> Floats:
    """About each axis: numbers in the plane, vectors in space."""
    count = len(system.space.rotation)
    return np.ones(1) if count == 1 else np.eye(count)


def _rigid(system: System, members: Ints, velocity: Floats, spin: Floats) -> Floats:
    """Coordinates of all blocks in a rigid motion of some."""
    z = np.zeros(system.sharing.constant.size)
    for part in (system.parts[i] for i in members):
        z[part.states] = part.form.moving(velocity, spin, np.zeros(system.dimension))
    return z


def _moves_freely(system: System, members: Ints, velocity: Floats, spin: Floats) -> bool:
    """Whether a rigid motion meets neither stress nor loss; what is left out of the states cannot move."""
    z = _rigid(system, members, velocity, spin)
    x = z[system.sharing.kept]
    if not x.any():
        return True  # nothing moves it that way
    if np.abs(system.sharing.expand(x) - z).max() > RIGID * np.abs(z).max():
        return False
    met = sp.csr_array(system.J() - system.R)
    return bool(np.all(np.abs(met @ x) <= RIGID * (abs(met) @ np.abs(x)).max()))


def _own_inertia(system: System, members: Ints, spin: Floats) -> Floats:
    """Rotary inertia: of a unit spin, the momentum of the coordinates that are angular velocities."""
    z = _rigid(system, members, np.zeros(system.dimension), spin)
    result = np.zeros(z.size)
    for part in (system.parts[i] for i in members):
        own = np.zeros(part.form.size)
        own[part.form.rotation_states] = z[part.states][part.form.rotation_states]
        result[part.states] = part.form.E.csr((part.form.size,) * 2) @ own
    return result
