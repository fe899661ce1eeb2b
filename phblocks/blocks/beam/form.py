"""A planar beam reduced to its matrices, and how its angles are read off its states; its fields are in ``fields``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import cast

import numpy as np

from phblocks.approximation import EXACT, Approximation
from phblocks.blocks.beam.damping import Damping
from phblocks.blocks.beam.ends import End
from phblocks.blocks.beam.fields import FieldForm
from phblocks.blocks.beam.interpolation import angle_rows, field_triplets, fraction, quadrature
from phblocks.blocks.beam.load import LineLoad, load_pieces
from phblocks.blocks.beam.matrices import strain_offsets, trace
from phblocks.blocks.beam.mesh import Mesh
from phblocks.blocks.beam.placement import arc
from phblocks.blocks.beam.stacked import stack
from phblocks.blocks.beam.tensors import component_index
from phblocks.blocks.centreline import Centreline
from phblocks.blocks.form import AngleRows, History, MaterialPoints
from phblocks.frames import QUARTER, rotate
from phblocks.ports import Place
from phblocks.triplets import Floats, Ints, Triplets


@dataclass(frozen=True)
class BeamForm(FieldForm):
    """Matrices and read-outs of a planar beam.

    Parameters
    ----------
    start_angle : float
        Initial orientation at the start, rad.
    origin : numpy.ndarray
        Initial place of the start, shape (2,), m.
    """

    start_angle: float = field(kw_only=True)
    origin: Floats = field(kw_only=True)

    def centreline(self) -> Centreline:
        """Describe the reference line at the points of quadrature; see :meth:`Form.centreline`.

        Returns
        -------
        Centreline
            Of constant matrices.
        """
        mesh, (elements, xi, weight) = self.mesh, quadrature(self.mesh)
        strain = tuple(
            field_triplets(mesh, "N", d, elements, xi).scaled(self.compliance[component_index("N", d)])
            for d in mesh.space.translation
        )
        h, length = mesh.lengths[elements], float(mesh.boundaries[-1])
        place = mesh.boundaries[elements] + xi * h
        known = np.array([mesh.segments[mesh.segment_of(int(e))].variant.velocity for e in range(mesh.lengths.size)])
        broken = np.where(known[elements], 0.0, 1.0)  # position is known by its mean only
        first = self.rotation_states[0] if self.rotation_states.size else 0
        if all(segment.variant.spin for segment in mesh.segments):
            spin, lean = field_triplets(mesh, "W", 2, elements, xi), Triplets.empty()
        else:
            spin, lean = (Triplets.from_coo(rows.tocoo()) for rows in angle_rows(mesh, elements, xi))
        return Centreline(
            strain=strain,
            spin=spin.shifted(0, -first),
            lean=lean.scaled(self.compliance[component_index("M", 2)]),
            reference=self.start_angle + self.curvature * place,
            place=place,
            weight=weight,
            arm=place + broken * h * (0.5 - xi),
            kernel=0.5 * (place * (length - place) - broken * h**2 * xi * (1.0 - xi)),
            length=length,
        )

    def angle(self, history: History, place: Place) -> Floats:
        """Read the orientation; see :meth:`Form.angle`.

        Parameters
        ----------
        history : History
            Of this beam.
        place : Place
            Fraction of the length.

        Returns
        -------
        numpy.ndarray
            Shape (times,), rad.
        """
        return self._angles(history, *self._locate(place))[:, 0]

    def _off_arc(self, history: History, place: Place, weights: Floats) -> Floats:
        """What the projection of the initial arc misses at a place, turned with the cross section there."""
        assert self.points is not None
        s = fraction(place) * self.mesh.boundaries[-1]
        missed = self.origin + arc(self.curvature, self.start_angle, np.array([s]))[0] - weights @ self.points.start
        turned = self.angle(history, place) - (self.start_angle + self.curvature * s)
        return rotate(turned, missed)

    def moving(self, velocity: Floats, spin: Floats, about: Floats) -> Floats:
        """Return the states of a rigid motion from the initial configuration; see :meth:`Form.moving`.

        Parameters
        ----------
        velocity : numpy.ndarray
            Of the point ``about``, shape (2,), m/s, in the fixed frame.
        spin : numpy.ndarray
            Angular velocity, shape (), rad/s.
        about : numpy.ndarray
            A point, shape (2,), m.

        Returns
        -------
        numpy.ndarray
            Shape (size,): velocities interpolated at the nodes, forces and moments zero.
        """
        states = []
        for run in self.runs:
            angle = self.start_angle + self.curvature * run.positions
            lever = self.origin + arc(self.curvature, self.start_angle, run.positions) - about
            v = velocity + spin * (lever @ QUARTER.T)
            material = {
                "V1": np.cos(angle) * v[:, 0] + np.sin(angle) * v[:, 1],
                "V2": np.cos(angle) * v[:, 1] - np.sin(angle) * v[:, 0],
                "W3": np.full(angle.size, spin),
            }
            states.append(material.get(run.field, np.zeros(angle.size)))
        return np.concatenate(states)

    def _tangents(self, history: History, elements: Ints, xi: Floats) -> Floats:
        """Lambda (e1 + Gamma) at points, shape (times, points, 2)."""
        angle = self._angles(history, elements, xi)
        c, s = np.cos(angle), np.sin(angle)
        along, across = np.moveaxis(self._stretched(history, elements, xi), -1, 0)
        return np.stack([c * along - s * across, s * along + c * across], axis=-1)

    def _angles(self, history: History, elements: Ints, xi: Floats) -> Floats:
        """Orientation at points, shape (times, points)."""
        place = self.mesh.boundaries[elements] + xi * self.mesh.lengths[elements]
        first = self.rotation_states[0] if self.rotation_states.size else 0
        rows, bend = self._rows(("W", 2), elements, xi)
        angle = (rows[:, first : first + self.rotation_states.size] @ history.theta.T).T
        bent = (bend @ self._mesh_states(history)).T * self.compliance[component_index("M", 2)]
        return cast(Floats, self.start_angle + self.curvature * place + angle + bent)


def beam_form(
    mesh: Mesh,
    ends: tuple[End, End],
    *,
    coefficients: Floats,
    curvature: float,
    origin: Floats,
    start_angle: float,
    damping: Damping | None = None,
    loads: Mapping[str, LineLoad] | None = None,
    kept: Approximation = EXACT,
) -> BeamForm:
    """Reduce a planar beam to its matrices.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering, made for the same ends.
    ends : tuple of End
        What the start and the end give.
    coefficients : numpy.ndarray
        Shape (12,): inertias and compliances per length.
    curvature : float
        Initial curvature, 1/m.
    origin : numpy.ndarray
        Initial place of the start, shape (2,), m.
    start_angle : float
        Initial orientation at the start, rad.
    damping : Damping, optional
        None by default.
    loads : mapping of str to LineLoad, optional
        By the name of their port; none by default.
    kept : Approximation, optional
        Which strains, inertias and products are kept; all by default.

    Returns
    -------
    BeamForm
        The beam in its own coordinates.
    """
    fields = stack(mesh, ends, coefficients, strain_offsets(curvature), damping, kept)
    first, rotation_states = fields.spins[0], fields.spins
    orientations: dict[str, AngleRows | None] = {}
    for name, at_end, end in (("start", False, ends[0]), ("end", True, ends[1])):
        angle = start_angle + (curvature * mesh.boundaries[-1] if at_end else 0.0)
        if end.spin:
            rows = Triplets.of([0], [trace(mesh, "W", 2, at_end) - first], values=[1.0])
            orientations[name] = AngleRows(rows, np.array([angle]))
        else:
            orientations[name] = None
    points = _material_points(mesh, fields.coefficients, curvature, origin, start_angle, first)
    return BeamForm(
        size=fields.size,
        runs=fields.runs,
        E=fields.E,
        J0=fields.J0,
        R=fields.R,
        T=fields.T,
        ports=fields.ports,
        rotation_states=rotation_states,
        orientations=orientations,
        points=points,
        loads={port: load_pieces(load, points, quadrature(mesh)[2]) for port, load in (loads or {}).items()},
        mesh=mesh,
        compliance=fields.coefficients,
        curvature=curvature,
        start_angle=start_angle,
        origin=origin,
        copies=fields.copies,
    )


def _material_points(
    mesh: Mesh, coefficients: Floats, curvature: float, origin: Floats, start_angle: float, first_spin: int
) -> MaterialPoints:
    elements, xi, weights = quadrature(mesh)
    place = mesh.boundaries[elements] + xi * mesh.lengths[elements]
    velocity = []
    for c, d in enumerate(mesh.space.translation):
        rows = field_triplets(mesh, "V", d, elements, xi)
        velocity.append(Triplets((rows.indices[0] * mesh.space.dimension + c, rows.indices[1]), rows.values))
    angles = start_angle + curvature * place
    spin = field_triplets(mesh, "W", 2, elements, xi).shifted(0, -first_spin)
    return MaterialPoints(
        mass=coefficients[component_index("V", 0)] * weights,
        velocity=Triplets.join(velocity),
        angle=AngleRows(spin, angles),
        start=origin + arc(curvature, start_angle, place),
    )
