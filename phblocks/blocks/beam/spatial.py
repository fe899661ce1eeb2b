"""A beam in space reduced to its matrices: twelve components, in the frames of its cross sections.

The intrinsic equations need no orientation: the beam moves, turns and bends without anybody knowing how its frames
stand. What needs to know (positions, weight, what acts in the fixed frame) is there only for a beam whose large
rotations are left out: its frames stay as they are, and turns are small vectors ``theta``, the time integrals of W, so
that ``Lambda = Lambda_0 (1 + theta x)``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from phblocks.approximation import Approximation
from phblocks.blocks.beam.damping import Damping
from phblocks.blocks.beam.ends import End
from phblocks.blocks.beam.fields import FieldForm
from phblocks.blocks.beam.interpolation import field_triplets, fraction, quadrature
from phblocks.blocks.beam.load import LineLoad
from phblocks.blocks.beam.matrices import strain_offsets, trace
from phblocks.blocks.beam.mesh import Mesh
from phblocks.blocks.beam.placement import Placement
from phblocks.blocks.beam.stacked import stack
from phblocks.blocks.beam.tensors import component_index
from phblocks.blocks.form import FIXED, AngleRows, History, MaterialPoints, Piece
from phblocks.errors import OrientationError
from phblocks.frames import Attitude
from phblocks.ports import Place
from phblocks.triplets import Floats, Ints, Triplets


@dataclass(frozen=True)
class SpatialBeamForm(FieldForm):
    """Matrices and read-outs of a spatial beam.

    Parameters
    ----------
    placement : Placement
        Where it is at first.
    """

    placement: Placement = field(kw_only=True)

    def angle(self, history: History, place: Place) -> Floats:
        """Refuse: in space there is no one angle."""
        raise OrientationError(
            "angle of a beam in space",
            expected="a planar beam",
            got="a spatial one: how its frames stand is not computed yet",
            fix="Read its angular velocity with solution.spin().",
        )

    def attitude(self, place: Place) -> Attitude:
        """Tell how a cross section stands; see :meth:`Form.attitude`."""
        frame = self.placement.frames(np.array([fraction(place) * self.mesh.boundaries[-1]]))[0]
        return Attitude(frame, "beam" if self.unoriented else None)

    def position(self, history: History, place: Place) -> Floats:
        """Read the position integrated from velocity, of a beam whose frames stay; see :meth:`Form.position`."""
        self._require_frames("position")
        return super().position(history, place)

    def chord(self, history: History, first: Place, second: Place) -> Floats:
        """Rebuild the vector between two places, of a beam whose frames stay; see :meth:`Form.chord`."""
        self._require_frames("position")
        return super().chord(history, first, second)

    def moving(self, velocity: Floats, spin: Floats, about: Floats) -> Floats:
        """Return the states of a rigid motion from the initial configuration; see :meth:`Form.moving`.

        Parameters
        ----------
        velocity : numpy.ndarray
            Of the point ``about``, shape (3,), m/s, in the fixed frame.
        spin : numpy.ndarray
            Angular velocity, shape (3,), rad/s, in the fixed frame.
        about : numpy.ndarray
            A point, shape (3,), m.

        Returns
        -------
        numpy.ndarray
            Shape (size,): velocities interpolated at the nodes, forces and moments zero.
        """
        states = []
        for run in self.runs:
            kind, d = run.field[0], int(run.field[1]) - 1
            if kind not in "VW":
                states.append(np.zeros(run.positions.size))
                continue
            lever = self.placement.at(run.positions) - about
            vector = velocity + np.cross(spin, lever) if kind == "V" else np.broadcast_to(spin, lever.shape)
            states.append(np.einsum("mi,mi->m", self.placement.frames(run.positions)[:, :, d], vector))
        return np.concatenate(states)

    def _tangents(self, history: History, elements: Ints, xi: Floats) -> Floats:
        """Lambda (e1 + Gamma) at points to first order in turns, shape (times, points, 3)."""
        theta, along = self._turns(history, elements, xi), self._stretched(history, elements, xi)
        along[..., 1] += theta[..., 2]
        along[..., 2] -= theta[..., 1]
        return np.asarray(np.einsum("mij,tmj->tmi", self.placement.frames(self._lengths(elements, xi)), along))

    def _off_arc(self, history: History, place: Place, weights: Floats) -> Floats:
        """What the projection of the initial arc misses at a place, turned with the cross section there."""
        assert self.points is not None
        s = np.array([fraction(place) * self.mesh.boundaries[-1]])
        missed = self.placement.at(s)[0] - weights @ self.points.start
        turned = self._turns(history, *self._locate(place))[:, 0] @ self.placement.frames(s)[0].T
        return np.asarray(missed + np.cross(turned, missed))

    def _turns(self, history: History, elements: Ints, xi: Floats) -> Floats:
        """Small turns at points in the frames of the cross sections, shape (times, points, 3)."""
        first, count = int(self.rotation_states[0]), self.rotation_states.size
        means, bends = [], []
        for d in range(3):
            rows, bend = self._rows(("W", d), elements, xi)
            means.append((rows[:, first : first + count] @ history.theta.T).T)
            bends.append((bend @ self._mesh_states(history)).T * self.compliance[component_index("M", d)])
        mean = np.stack(means, axis=-1)
        if self.curvature != 0.0:  # where the mean is known, the initial curvature turns the frame it is seen in
            jump = [not self.mesh.segments[self.mesh.segment_of(int(e))].variant.spin for e in elements]
            bent = self.curvature * self.mesh.lengths[elements] * (xi - 0.5) * np.array(jump)
            bends[0], bends[1] = bends[0] + bent * mean[..., 1], bends[1] - bent * mean[..., 0]
        return np.asarray(mean + np.stack(bends, axis=-1))

    def _lengths(self, elements: Ints, xi: Floats) -> Floats:
        return np.asarray(self.mesh.boundaries[elements] + xi * self.mesh.lengths[elements])

    def _require_frames(self, what: str) -> None:
        if self.unoriented:
            raise OrientationError(
                f"{what} on a beam in space",
                expected="a beam whose frames stay as they are (large_rotation=False), or a planar one",
                got="one that turns: how its frames stand then is not computed yet",
                fix='Read velocities and forces in its own frames, frame="material".',
            )


def spatial_form(
    mesh: Mesh,
    ends: tuple[End, End],
    *,
    placement: Placement,
    coefficients: Floats,
    damping: Damping | None,
    loads: Mapping[str, LineLoad],
    kept: Approximation,
) -> SpatialBeamForm:
    """Reduce a beam in space to its matrices.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering, made for the same ends.
    ends : tuple of End
        What the start and the end give.
    placement : Placement
        Where it is at first.
    coefficients : numpy.ndarray
        Shape (12,): inertias and compliances per length.
    damping : Damping or None
        Of the beam.
    loads : mapping of str to LineLoad
        By the name of their port.
    kept : Approximation
        Which strains, inertias and products are kept.

    Returns
    -------
    SpatialBeamForm
        The beam in its own coordinates; without products, and with frames that stay, if large rotations are left out.
    """
    fields = stack(mesh, ends, coefficients, strain_offsets(placement.curvature), damping, kept)
    frozen = kept.large_rotation is False
    orientations: dict[str, AngleRows | Attitude | None] = {}
    for name, at_end, end in (("start", False, ends[0]), ("end", True, ends[1])):
        frame = placement.frames(np.array([placement.length if at_end else 0.0]))[0]
        if frozen:
            orientations[name] = Attitude(frame)
        else:
            orientations[name] = Attitude(frame, trace(mesh, "W", 0, at_end)) if end.spin else None
    return SpatialBeamForm(
        size=fields.size,
        runs=fields.runs,
        E=fields.E,
        J0=fields.J0,
        R=fields.R,
        T=Triplets.empty(3) if frozen else fields.T,
        ports=fields.ports,
        rotation_states=fields.spins if frozen else np.empty(0, dtype=np.int64),
        orientations=orientations,
        points=_points(mesh, placement, fields.coefficients) if frozen else None,
        loads={port: (_load(load, mesh, placement, frozen),) for port, load in loads.items()},
        frozen=frozen,
        unoriented=not frozen,
        mesh=mesh,
        compliance=fields.coefficients,
        curvature=placement.curvature,
        copies=fields.copies,
        placement=placement,
    )


def _material_velocity(mesh: Mesh) -> tuple[Triplets, Floats, Floats]:
    """Velocity at the material points in their frames, shape (points * 3, states); their places and lengths."""
    elements, xi, weights = quadrature(mesh)
    rows = []
    for d in range(3):
        of_point = field_triplets(mesh, "V", d, elements, xi)
        rows.append(Triplets((3 * of_point.indices[0] + d, of_point.indices[1]), of_point.values))
    return Triplets.join(rows), mesh.boundaries[elements] + xi * mesh.lengths[elements], weights


def _turned(velocity: Triplets, frames: Floats) -> Triplets:
    """Velocities of points in the fixed frame."""
    row, state = velocity.indices
    point, d = row // 3, row % 3
    values = frames[point, :, d] * velocity.values[:, None]
    entry, component = np.nonzero(values)
    return Triplets.of(3 * point[entry] + component, state[entry], values=values[entry, component])


def _points(mesh: Mesh, placement: Placement, coefficients: Floats) -> MaterialPoints:
    velocity, s, weights = _material_velocity(mesh)
    return MaterialPoints(
        mass=coefficients[component_index("V", 0)] * weights,
        velocity=_turned(velocity, placement.frames(s)),
        angle=AngleRows(Triplets.empty(), np.zeros(s.size)),
        start=placement.at(s),
    )


def _load(load: LineLoad, mesh: Mesh, placement: Placement, frozen: bool) -> Piece:
    """The velocity of each point times the length it stands for, in the frames that the load has its components in."""
    velocity, s, weights = _material_velocity(mesh)
    seen = velocity if load.follows or not frozen else _turned(velocity, placement.frames(s))
    row, state = seen.indices
    together = Triplets.of(row % 3, state, values=seen.values * weights[row // 3]).csr((3, mesh.size)).tocoo()
    turning = not load.follows and not frozen
    return Piece(Triplets.from_coo(together), Attitude(placement.frames(s[:1])[0], load.name) if turning else FIXED)
