"""A beam reduced to its matrices, and how its fields, angles and positions are read off its states.

Where V (or W) is continuous, position (angle) is read in the same space; what that space cannot follow of an
initial arc is carried along with the cross section. Where it is not, the mean over the element comes from the
velocity states and the shape within the element from strain (curvature): a piecewise constant position would be half
an element off at the ends.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import cast

import numpy as np
import scipy.sparse as sp

from phblocks.approximation import EXACT, Approximation
from phblocks.blocks.beam.damping import VISCOUS_PART, Damping, damp
from phblocks.blocks.beam.ends import End
from phblocks.blocks.beam.load import LineLoad, load_pieces
from phblocks.blocks.beam.matrices import beam_matrices, strain_offsets, trace
from phblocks.blocks.beam.mesh import Mesh
from phblocks.blocks.beam.omission import kept_coefficients, kept_damping, without_energy
from phblocks.blocks.beam.spaces import gauss
from phblocks.blocks.beam.tensors import component_index
from phblocks.blocks.centreline import Centreline
from phblocks.blocks.form import AngleRows, Form, History, MaterialPoints, Piece, PortForm, Profile
from phblocks.errors import DataError, UnknownNameError
from phblocks.frames import QUARTER, rotate
from phblocks.ports import Place
from phblocks.triplets import Floats, Ints, Triplets

PAIRS = (("translation", "V", "N"), ("rotation", "W", "M"))


@dataclass(frozen=True)
class BeamForm(Form):
    """Matrices and read-outs of a planar beam.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.
    compliance : numpy.ndarray
        Shape (12,): inertias and compliances of the section.
    curvature : float
        Initial curvature, 1/m.
    start_angle : float
        Initial orientation at the start, rad.
    origin : numpy.ndarray
        Initial place of the start, shape (2,), m.
    copies : numpy.ndarray
        For each state of the mesh the state that is its viscous part, or -1; shape (0,) without damping.
    """

    mesh: Mesh = field(kw_only=True)
    compliance: Floats = field(kw_only=True)
    curvature: float = field(kw_only=True)
    start_angle: float = field(kw_only=True)
    origin: Floats = field(kw_only=True)
    copies: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64), kw_only=True)

    def place(self, s: object, where: str) -> Place:
        """Check a fraction of the length.

        Parameters
        ----------
        s : object
            The candidate.
        where : str
            What it is, for the message.

        Returns
        -------
        Place
            From 0 (start) to 1 (end).

        Raises
        ------
        DataError
            If it is not a number from 0 to 1.
        """
        return fraction(s, where)

    def cut_sign(self, place: Place) -> float | None:
        """Tell how N and M at an end follow from force and moment on the beam; see :meth:`Form.cut_sign`.

        Parameters
        ----------
        place : Place
            Fraction of the length.

        Returns
        -------
        float or None
            -1 at the start, +1 at the end.
        """
        return {0.0: -1.0, 1.0: 1.0}.get(fraction(place))

    def outline(self) -> Sequence[Place]:
        """List places along the beam; see :meth:`Form.outline`.

        Returns
        -------
        sequence of Place
            Equally spaced from start to end.
        """
        return tuple(np.linspace(0.0, 1.0, 21).tolist())

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

    def value(self, history: History, name: str, place: Place) -> Floats:
        """Read a component of a field; see :meth:`Form.value`.

        Parameters
        ----------
        history : History
            Of this beam.
        name : str
            Such as "V1", "W3", "N2" or "M3". With internal damping "N2" is the whole force, and "N2v" its viscous
            part, which is that over the step that ends at each time.
        place : Place
            Fraction of the length.

        Returns
        -------
        numpy.ndarray
            Shape (times,).

        Raises
        ------
        UnknownNameError
            If the beam has no such field.
        """
        known = [run.field for run in self.runs]
        if name not in known:
            raise UnknownNameError("beam", expected=f"one of {', '.join(known)}", got=repr(name), fix="See docs.")
        stress = name.removesuffix(VISCOUS_PART)
        rows = field_triplets(self.mesh, stress[0], int(stress[1:]) - 1, *self._locate(place))
        if self.copies.size:
            copies = self.copies[rows.indices[1]]
            damped = copies >= 0
            viscous = Triplets((rows.indices[0][damped], copies[damped]), rows.values[damped])
            rows = viscous if stress != name else Triplets.join([rows, viscous])
        return cast(Floats, (rows.csr((1, self.size)) @ history.x.T)[0])

    def profile(self, history: History, quantity: Profile, places: Sequence[Place]) -> Floats:
        """Read moment or strain energy along the beam; see :meth:`Form.profile`.

        Parameters
        ----------
        history : History
            Of this beam.
        quantity : {"moment", "energy"}
            Which; the energy leaves the viscous part of stresses out.
        places : sequence of Place
            Fractions of the length.

        Returns
        -------
        numpy.ndarray
            Shape (times, places), N m or J/m.
        """
        if quantity == "moment":
            return np.stack([self.value(history, "M3", place) for place in places], axis=1)
        located = [self.mesh.locate(fraction(place) * self.mesh.boundaries[-1]) for place in places]
        elements, xi = np.array([e for e, _ in located]), np.array([x for _, x in located])
        density = np.zeros((history.x.shape[0], len(places)))
        stresses = [("N", d) for d in self.mesh.space.translation] + [("M", d) for d in self.mesh.space.rotation]
        for name, d in stresses:
            rows = field_rows(self.mesh, name, d, elements, xi)
            density += 0.5 * self.compliance[component_index(name, d)] * (rows @ self._mesh_states(history)).T ** 2
        return density

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

    def position(self, history: History, place: Place) -> Floats:
        """Read the position integrated from velocity; see :meth:`Form.position`.

        Parameters
        ----------
        history : History
            Of this beam, with points.
        place : Place
            Fraction of the length.

        Returns
        -------
        numpy.ndarray
            Shape (times, 2), m.
        """
        if history.points is None:
            raise UnknownNameError(
                "position from velocity",
                expected="a system that tracks positions",
                got="one compiled without",
                fix='Compile with outputs="all", or ask for source="strain".',
            )
        elements, xi = self._locate(place)
        if self.mesh.segments[self.mesh.segment_of(int(elements[0]))].variant.velocity:
            weights = self._projection(elements, xi)
            projected = _weighted(history.points, weights)
            return projected if self.curvature == 0.0 else projected + self._off_arc(history, place, weights)
        e, (nodes, weights), h = int(elements[0]), gauss(self.mesh.degree + 1), self.mesh.lengths[int(elements[0])]
        same = np.full(nodes.size, e)
        mean = _weighted(history.points[:, e * nodes.size : (e + 1) * nodes.size], weights)
        to_here = xi[0] * _weighted(self._tangents(history, same, nodes * xi[0]), weights)
        to_mean = _weighted(self._tangents(history, same, nodes), weights * (1.0 - nodes))
        return np.asarray(mean + h * (to_here - to_mean))

    def _off_arc(self, history: History, place: Place, weights: Floats) -> Floats:
        """What the projection of the initial arc misses at a place, turned with the cross section there."""
        assert self.points is not None
        s = fraction(place) * self.mesh.boundaries[-1]
        missed = self.origin + arc(self.curvature, self.start_angle, np.array([s]))[0] - weights @ self.points.start
        turned = self.angle(history, place) - (self.start_angle + self.curvature * s)
        return rotate(turned, missed)

    def chord(self, history: History, first: Place, second: Place) -> Floats:
        """Rebuild the vector between two places, the integral of Lambda (e1 + Gamma); see :meth:`Form.chord`.

        Parameters
        ----------
        history : History
            Of this beam.
        first, second : Place
            Fractions of the length.

        Returns
        -------
        numpy.ndarray
            From first to second, shape (times, 2), m.
        """
        mesh, (points, weights) = self.mesh, gauss(self.mesh.degree + 1)
        low, high = sorted((fraction(first) * mesh.boundaries[-1], fraction(second) * mesh.boundaries[-1]))
        begin = np.clip(low, mesh.boundaries[:-1], mesh.boundaries[1:])
        width = np.clip(high, mesh.boundaries[:-1], mesh.boundaries[1:]) - begin
        elements = np.flatnonzero(width > 0.0)
        start = (begin - mesh.boundaries[:-1])[elements] / mesh.lengths[elements]
        xi = start[:, None] + (width / mesh.lengths)[elements, None] * points
        tangents = self._tangents(history, np.repeat(elements, points.size), xi.ravel())
        sign = 1.0 if fraction(second) >= fraction(first) else -1.0
        return sign * _weighted(tangents, (width[elements, None] * weights).ravel())

    def moving(self, velocity: Floats, spin: float, about: Floats) -> Floats:
        """Return the states of a rigid motion from the initial configuration; see :meth:`Form.moving`.

        Parameters
        ----------
        velocity : numpy.ndarray
            Of the point ``about``, shape (2,), m/s, in the fixed frame.
        spin : float
            Angular velocity, rad/s.
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

    def mean_chord(self, history: History) -> Floats:
        """Rebuild the vector from the start to the centre of mass; see :meth:`Form.mean_chord`.

        Parameters
        ----------
        history : History
            Of this beam.

        Returns
        -------
        numpy.ndarray
            Shape (times, 2), m.
        """
        elements, xi, weights = quadrature(self.mesh)
        fraction = (self.mesh.boundaries[elements] + xi * self.mesh.lengths[elements]) / self.mesh.boundaries[-1]
        return _weighted(self._tangents(history, elements, xi), weights * (1.0 - fraction))

    def _locate(self, place: Place) -> tuple[Ints, Floats]:
        element, xi = self.mesh.locate(fraction(place) * self.mesh.boundaries[-1])
        return np.array([element]), np.array([xi])

    def _mesh_states(self, history: History) -> Floats:
        """States with energy, shape (states of the mesh, times)."""
        return history.x[:, : self.mesh.size].T

    def _tangents(self, history: History, elements: Ints, xi: Floats) -> Floats:
        """Lambda (e1 + Gamma) at points, shape (times, points, 2)."""
        gamma = [
            (field_rows(self.mesh, "N", d, elements, xi) @ self._mesh_states(history)).T
            * self.compliance[component_index("N", d)]
            for d in self.mesh.space.translation
        ]
        gamma[0] = gamma[0] + 1.0
        angle = self._angles(history, elements, xi)
        c, s = np.cos(angle), np.sin(angle)
        return np.stack([c * gamma[0] - s * gamma[1], s * gamma[0] + c * gamma[1]], axis=-1)

    def _angles(self, history: History, elements: Ints, xi: Floats) -> Floats:
        """Orientation at points, shape (times, points)."""
        place = self.mesh.boundaries[elements] + xi * self.mesh.lengths[elements]
        first = self.rotation_states[0] if self.rotation_states.size else 0
        rows, bend = angle_rows(self.mesh, elements, xi)
        angle = (rows[:, first : first + self.rotation_states.size] @ history.theta.T).T
        bent = (bend @ self._mesh_states(history)).T * self.compliance[component_index("M", 2)]
        return cast(Floats, self.start_angle + self.curvature * place + angle + bent)

    def _projection(self, elements: Ints, xi: Floats) -> Floats:
        """Weights of the material points in the L2 projection onto the space of V, evaluated at a point."""
        from scipy.sparse.linalg import spsolve

        all_elements, points, weights = quadrature(self.mesh)
        psi = field_rows(self.mesh, "V", 0, all_elements, points)
        used = np.flatnonzero(np.diff(psi.tocsc().indptr))
        psi = psi[:, used]
        mass = sp.csc_array(psi.T @ (psi * weights[:, None]))
        here = field_rows(self.mesh, "V", 0, elements, xi)[:, used].toarray()[0]
        return np.asarray(weights * (psi @ np.atleast_1d(spsolve(mass, here))))


def fraction(s: object, where: str = "place on a beam") -> float:
    """Check a fraction of the length.

    Parameters
    ----------
    s : object
        The candidate.
    where : str, optional
        What it is, for the message.

    Returns
    -------
    float
        From 0 to 1.

    Raises
    ------
    DataError
        If it is not a number from 0 to 1.
    """
    if isinstance(s, bool) or not isinstance(s, (int, float, np.number)) or not 0.0 <= float(s) <= 1.0:
        raise DataError(
            where,
            expected="a fraction of the length from 0 to 1",
            got=repr(s),
            fix="0 is the start, 1 the end.",
        )
    return float(s)


def _weighted(values: Floats, weights: Floats) -> Floats:
    """Sum of vectors at points, shape (times, points, 2), times weights of the points."""
    return np.asarray(np.einsum("tmd,m->td", values, weights))


def quadrature(mesh: Mesh) -> tuple[Ints, Floats, Floats]:
    """List the material points of a beam: k + 1 Gauss points in each element.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.

    Returns
    -------
    elements : numpy.ndarray
        Element of each point.
    xi : numpy.ndarray
        Coordinate in the element.
    weights : numpy.ndarray
        Length that the point stands for, m.
    """
    points, weights = gauss(mesh.degree + 1)
    n = mesh.lengths.size
    return (
        np.repeat(np.arange(n), points.size),
        np.tile(points, n),
        (mesh.lengths[:, None] * weights).ravel(),
    )


def field_triplets(mesh: Mesh, name: str, direction: int, elements: Ints, xi: Floats) -> Triplets:
    """Interpolate a component at points.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.
    name : {"V", "W", "N", "M"}
        The field.
    direction : int
        0, 1 or 2.
    elements : numpy.ndarray
        Element of each point, shape (m,).
    xi : numpy.ndarray
        Coordinate of each point in its element, shape (m,).

    Returns
    -------
    Triplets
        Shape (m, states).
    """
    parts = []
    for i, segment in enumerate(mesh.segments):
        here = np.flatnonzero((elements >= segment.first) & (elements < segment.last))
        if here.size:
            states = mesh.states[i][name, direction][elements[here] - segment.first]
            parts.append(Triplets.of(here[:, None], states, values=mesh.basis(i, name).at(xi[here])))
    return Triplets.join(parts)


def field_rows(mesh: Mesh, name: str, direction: int, elements: Ints, xi: Floats) -> sp.csr_array:
    """Interpolate a component at points, as a matrix; see :func:`field_triplets`.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.
    name : {"V", "W", "N", "M"}
        The field.
    direction : int
        0, 1 or 2.
    elements : numpy.ndarray
        Element of each point, shape (m,).
    xi : numpy.ndarray
        Coordinate of each point in its element, shape (m,).

    Returns
    -------
    scipy.sparse.csr_array
        Shape (m, states).
    """
    return field_triplets(mesh, name, direction, elements, xi).csr((elements.size, mesh.size))


def angle_rows(mesh: Mesh, elements: Ints, xi: Floats) -> tuple[sp.csr_array, sp.csr_array]:
    """Interpolate the angle at points from the rotation states and, where W is discontinuous, from curvature.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.
    elements : numpy.ndarray
        Element of each point, shape (m,).
    xi : numpy.ndarray
        Coordinate of each point in its element, shape (m,).

    Returns
    -------
    rotation : scipy.sparse.csr_array
        Shape (m, states), to be applied to the time integrals of W3.
    bending : scipy.sparse.csr_array
        Shape (m, states), to be applied to M3 and multiplied by the compliance.
    """
    points, weights = gauss(mesh.degree + 1)
    h, n = mesh.lengths[elements][:, None], elements.size
    spots = np.arange(n * points.size).reshape(n, points.size)

    def integral(name: str, at: Floats, factors: Floats) -> sp.csr_array:
        """Sum of factors times the field at points of the same element, both of shape (n, points)."""
        values = field_rows(mesh, name, 2, np.repeat(elements, points.size), np.broadcast_to(at, spots.shape).ravel())
        return Triplets.of(np.arange(n)[:, None], spots, values=factors).csr((n, spots.size)) @ values

    smooth = np.array([mesh.segments[mesh.segment_of(int(e))].variant.spin for e in elements], dtype=np.float64)
    keep, replace = sp.diags_array(smooth), sp.diags_array(1.0 - smooth)
    up_to_xi = integral("M", xi[:, None] * points, h * xi[:, None] * weights)
    mean_of_that = integral("M", points, h * weights * (1.0 - points))
    interpolated = field_rows(mesh, "W", 2, elements, xi)
    mean = integral("W", points, weights)
    return (
        sp.csr_array(keep @ interpolated + replace @ mean),
        sp.csr_array(replace @ (up_to_xi - mean_of_that)),
    )


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
    full, offsets = coefficients, strain_offsets(curvature)
    coefficients, modulating = kept_coefficients(full, kept)
    E, J0, T = beam_matrices(mesh, coefficients, offsets, modulating)
    runs, R, copies = mesh.runs, Triplets.empty(), np.empty(0, dtype=np.int64)
    damping = None if damping is None else kept_damping(damping, kept)
    if damping is not None:
        inertia = E if coefficients is full else beam_matrices(mesh, full, offsets)[0]  # drag needs no inertia
        damped = damp(mesh, (inertia, J0, T), full, damping)
        runs, J0, R, T, copies = damped.runs, damped.J0, damped.R, damped.T, damped.copies
    runs = without_energy(runs, coefficients)
    spin_runs = [i for i, run in enumerate(mesh.runs) if run.field.startswith("W")]
    first = sum(run.positions.size for run in mesh.runs[: spin_runs[0]])
    rotation_states = first + np.arange(sum(mesh.runs[i].positions.size for i in spin_runs))
    ports: dict[str, PortForm] = {}
    orientations: dict[str, AngleRows | None] = {}
    for name, at_end, end in (("start", False, ends[0]), ("end", True, ends[1])):
        for (kind, common, summed), gives in zip(PAIRS, end, strict=True):
            directions = mesh.space.translation if kind == "translation" else mesh.space.rotation
            states = [trace(mesh, common if gives else summed, d, at_end) for d in directions]
            sign = 1.0 if gives or at_end else -1.0  # -N(0) and +N(L) are the forces on the beam
            output = Triplets.of(np.arange(len(states)), states, values=sign)
            if copies.size:  # the force is that of the elastic and the viscous part
                viscous = copies[states] >= 0
                added = Triplets.of(np.flatnonzero(viscous), copies[states][viscous], values=sign)
                output = Triplets.join([output, added])
            ports[f"{name}.{kind}"] = PortForm(gives, (Piece(output),))
        angle = start_angle + (curvature * mesh.boundaries[-1] if at_end else 0.0)
        if end.spin:
            rows = Triplets.of([0], [trace(mesh, "W", 2, at_end) - first], values=[1.0])
            orientations[name] = AngleRows(rows, np.array([angle]))
        else:
            orientations[name] = None
    points = _material_points(mesh, coefficients, curvature, origin, start_angle, first)
    return BeamForm(
        size=sum(run.positions.size for run in runs),
        runs=runs,
        E=E,
        J0=J0,
        R=R,
        T=T,
        ports=ports,
        rotation_states=rotation_states,
        orientations=orientations,
        points=points,
        loads={port: load_pieces(load, points, quadrature(mesh)[2]) for port, load in (loads or {}).items()},
        mesh=mesh,
        compliance=coefficients,
        curvature=curvature,
        start_angle=start_angle,
        origin=origin,
        copies=copies,
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


def arc(curvature: float, angle: float, place: Floats) -> Floats:
    """Trace a circular arc from the origin.

    Parameters
    ----------
    curvature : float
        1/m.
    angle : float
        Orientation at the origin, rad.
    place : numpy.ndarray
        Arc lengths, shape (m,), m.

    Returns
    -------
    numpy.ndarray
        Shape (m, 2), m.
    """
    half = 0.5 * curvature * place
    chord = place * np.sinc(half / np.pi)  # exact also for curvature 0
    return np.stack([chord * np.cos(angle + half), chord * np.sin(angle + half)], axis=-1)
