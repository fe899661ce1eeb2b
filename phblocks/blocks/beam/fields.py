"""What every beam has, wherever it is: fields interpolated on a mesh, and what is read off them.

Where V (or W) is continuous, position (angle) is read in the same space; what that space cannot follow of an
initial arc is carried along with the cross section. Where it is not, the mean over the element comes from the
velocity states and the shape within the element from strain (curvature): a piecewise constant position would be half
an element off at the ends.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import cast

import numpy as np
import scipy.sparse as sp

from phblocks.blocks.beam.damping import VISCOUS_PART
from phblocks.blocks.beam.interpolation import angle_rows, field_rows, field_triplets, fraction, quadrature, weighted
from phblocks.blocks.beam.mesh import Mesh
from phblocks.blocks.beam.spaces import gauss
from phblocks.blocks.beam.tensors import component_index
from phblocks.blocks.form import Form, History, Profile
from phblocks.errors import UnknownNameError
from phblocks.ports import Place
from phblocks.triplets import Floats, Ints, Triplets


@dataclass(frozen=True)
class FieldForm(Form):
    """Matrices of a beam and what is read off its fields.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.
    compliance : numpy.ndarray
        Shape (12,): inertias and compliances of the section.
    curvature : float
        Initial curvature, 1/m.
    """

    mesh: Mesh = field(kw_only=True)
    compliance: Floats = field(kw_only=True)
    curvature: float = field(kw_only=True)

    @abstractmethod
    def _tangents(self, history: History, elements: Ints, xi: Floats) -> Floats:
        """Lambda (e1 + Gamma) at points, shape (times, points, dimension)."""

    @abstractmethod
    def _off_arc(self, history: History, place: Place, weights: Floats) -> Floats:
        """What the projection of the initial arc misses at a place, turned with the cross section there."""

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

    def velocity(self, history: History, place: Place) -> Floats:
        """Read the velocity in the frame of the cross section; see :meth:`Form.velocity`."""
        names = [f"V{d + 1}" for d in self.mesh.space.translation]
        return np.stack([self.value(history, name, place) for name in names], axis=1)

    def profile(self, history: History, quantity: Profile, places: Sequence[Place]) -> Floats:
        """Read moment or strain energy along the beam; see :meth:`Form.profile`.

        Parameters
        ----------
        history : History
            Of this beam.
        quantity : {"moment", "energy"}
            Which: in space the size of the bending moment; the energy leaves the viscous part of stresses out.
        places : sequence of Place
            Fractions of the length.

        Returns
        -------
        numpy.ndarray
            Shape (times, places), N m or J/m.
        """
        if quantity == "moment":
            parts = [
                np.stack([self.value(history, f"M{d + 1}", place) for place in places], axis=1)
                for d in self.mesh.space.rotation
                if d > 0  # direction 1 is torsion
            ]
            return parts[0] if len(parts) == 1 else np.asarray(np.linalg.norm(parts, axis=0))
        located = [self.mesh.locate(fraction(place) * self.mesh.boundaries[-1]) for place in places]
        elements, xi = np.array([e for e, _ in located]), np.array([x for _, x in located])
        density = np.zeros((history.x.shape[0], len(places)))
        stresses = [("N", d) for d in self.mesh.space.translation] + [("M", d) for d in self.mesh.space.rotation]
        for name, d in stresses:
            rows = field_rows(self.mesh, name, d, elements, xi)
            density += 0.5 * self.compliance[component_index(name, d)] * (rows @ self._mesh_states(history)).T ** 2
        return density

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
            Shape (times, dimension), m.
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
            projected = weighted(history.points, weights)
            return projected if self.curvature == 0.0 else projected + self._off_arc(history, place, weights)
        e, (nodes, weights), h = int(elements[0]), gauss(self.mesh.degree + 1), self.mesh.lengths[int(elements[0])]
        same = np.full(nodes.size, e)
        mean = weighted(history.points[:, e * nodes.size : (e + 1) * nodes.size], weights)
        to_here = xi[0] * weighted(self._tangents(history, same, nodes * xi[0]), weights)
        to_mean = weighted(self._tangents(history, same, nodes), weights * (1.0 - nodes))
        return np.asarray(mean + h * (to_here - to_mean))

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
            From first to second, shape (times, dimension), m.
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
        return sign * weighted(tangents, (width[elements, None] * weights).ravel())

    def mean_chord(self, history: History) -> Floats:
        """Rebuild the vector from the start to the centre of mass; see :meth:`Form.mean_chord`.

        Parameters
        ----------
        history : History
            Of this beam.

        Returns
        -------
        numpy.ndarray
            Shape (times, dimension), m.
        """
        elements, xi, weights = quadrature(self.mesh)
        fraction = (self.mesh.boundaries[elements] + xi * self.mesh.lengths[elements]) / self.mesh.boundaries[-1]
        return weighted(self._tangents(history, elements, xi), weights * (1.0 - fraction))

    def _locate(self, place: Place) -> tuple[Ints, Floats]:
        element, xi = self.mesh.locate(fraction(place) * self.mesh.boundaries[-1])
        return np.array([element]), np.array([xi])

    def _mesh_states(self, history: History) -> Floats:
        """States with energy, shape (states of the mesh, times)."""
        return history.x[:, : self.mesh.size].T

    def _rows(self, component: tuple[str, int], elements: Ints, xi: Floats) -> tuple[sp.csr_array, ...]:
        """What reads a force, or an angle ("W"), at points; kept, as the same points are asked for again and again."""
        name, direction = component
        key = (*component, elements.tobytes(), xi.tobytes())
        if key not in self._known_rows:
            self._known_rows[key] = (
                angle_rows(self.mesh, elements, xi, direction)
                if name == "W"
                else (field_rows(self.mesh, name, direction, elements, xi),)
            )
        return self._known_rows[key]

    @cached_property
    def _known_rows(self) -> dict[tuple[str, int, bytes, bytes], tuple[sp.csr_array, ...]]:
        return {}

    def _stretched(self, history: History, elements: Ints, xi: Floats) -> Floats:
        """Components of e1 + Gamma at points, shape (times, points, dimension)."""
        gamma = np.stack(
            [
                (self._rows(("N", d), elements, xi)[0] @ self._mesh_states(history)).T
                * self.compliance[component_index("N", d)]
                for d in self.mesh.space.translation
            ],
            axis=-1,
        )
        gamma[..., 0] += 1.0
        return gamma

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
