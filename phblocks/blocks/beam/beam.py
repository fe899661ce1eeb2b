"""The geometrically exact beam as a block."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from phblocks.approximation import Approximation, require_approximation
from phblocks.blocks.beam.damping import Damping
from phblocks.blocks.beam.ends import END_NAMES, ENDS, End, parse_causality
from phblocks.blocks.beam.form import BeamForm, beam_form
from phblocks.blocks.beam.interpolation import fraction
from phblocks.blocks.beam.load import LINE, LineLoad, require_loads
from phblocks.blocks.beam.mesh import Mesh, Segment, number_states
from phblocks.blocks.beam.omission import COMPONENTS, STRAINS, kept_coefficients, states
from phblocks.blocks.beam.placement import Placement, fractions_of
from phblocks.blocks.beam.rigid import RigidBeamForm, RigidLine, rigid_form
from phblocks.blocks.beam.section import Section
from phblocks.blocks.beam.spatial import SpatialBeamForm, spatial_form
from phblocks.blocks.beam.tensors import Variant, component_index
from phblocks.blocks.block import Alternative, Block, BlockPoint, PortChoice, Rigid, Tie
from phblocks.blocks.checks import require_real
from phblocks.blocks.form import Form
from phblocks.errors import ArgumentTypeError, DataError, OrientationError
from phblocks.ports import Anchor, Exposure, Port
from phblocks.space import PLANAR, Space
from phblocks.triplets import Floats, Ints


class Beam(Block):
    """Geometrically exact beam, straight or initially circular, in mixed finite elements.

    States are velocity V, angular velocity W, internal force N and internal moment M in the material frame; each
    pair (V, N), (W, M) is discretised in CG_k and DG_{k-1}, which one in which depending on the causality of the
    ends. Translation and rotation, start and end, choose separately; a pair whose ends differ switches at one
    interior element boundary.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    section : Section
        Stiffness and inertia.
    start, end : array_like
        Initial places of the two ends, shape (2,), m; of shape (3,) they make a spatial beam, with all twelve
        components.
    elements : int or array_like
        Number of elements of equal length, or the element boundaries as fractions of the length, from 0 to 1.
    degree : int, optional
        k of the pairs CG_k, DG_{k-1}; the error falls with order 2k in frequencies.
    causality : str or tuple of str, optional
        "auto", or what the two ends are, such as "free-free", "pinned-pinned", "clamped-free" or
        ("clamped", "free"): a *free* end takes force and moment, a *pinned* one velocity and moment, a *clamped*
        one velocity and angular velocity, a *guided* one force and angular velocity.
    curvature : float, optional
        Initial curvature, 1/m, positive for a beam that bends to the left on its way from start to end; the arc
        is the shorter one through both ends.
    switch_at : float, optional
        Where a pair switches if its ends differ, as a fraction of the length; moved to the nearest interior
        element boundary.
    damping : Damping, optional
        Drag and internal damping; none by default.
    loads : LineLoad or sequence of LineLoad, optional
        Forces per length; none by default.
    approximation : Approximation, optional
        What is left out in this beam, whatever is left out in the rest of the diagram.
    normal : array_like, optional
        Of a spatial beam: the direction that axis 3 of the cross sections is as near to as it can be, shape (3,); by
        default (0, 0, 1), and (1, 0, 0) for a beam along z. The curvature is about axis 3.

    Raises
    ------
    DataError
        If a number is out of its range: coinciding ends, no elements, degree < 1, a radius that does not span
        the ends; or the section of a spatial beam has no torsional stiffness.
    SpaceError
        If the ends have different numbers of coordinates, or a planar beam has a normal.
    ArgumentTypeError
        If an argument is of the wrong kind.

    Notes
    -----
    Brugnoli, Kinon, Sanfedino, Betsch: Structure-preserving discretization of intrinsic geometrically exact
    beams for explicit multibody dynamics, eqs. (2) to (5); Hodges (2003), doi:10.2514/2.2054.
    """

    def __init__(
        self,
        name: str,
        section: Section,
        start: ArrayLike,
        end: ArrayLike,
        elements: int | ArrayLike,
        degree: int = 1,
        causality: str | tuple[str, str] = "auto",
        curvature: float | None = None,
        switch_at: float = 0.5,
        damping: Damping | None = None,
        loads: LineLoad | Sequence[LineLoad] = (),
        approximation: Approximation | None = None,
        normal: ArrayLike | None = None,
    ) -> None:
        super().__init__(name)
        if not isinstance(section, Section):
            raise ArgumentTypeError(
                f"Beam {name!r} section",
                expected="a Section",
                got=type(section).__name__,
                fix="Make a ph.Section.",
            )
        if damping is not None and not isinstance(damping, Damping):
            raise ArgumentTypeError(
                f"Beam {name!r} damping",
                expected="a Damping",
                got=type(damping).__name__,
                fix="Make a ph.Damping(viscous=..., internal=...).",
            )
        if isinstance(degree, bool) or not isinstance(degree, (int, np.integer)):
            raise ArgumentTypeError(
                f"Beam {name!r} degree", expected="an integer", got=repr(degree), fix="Use 1, 2 or 3."
            )
        if not 1 <= degree <= 12:
            raise DataError(
                f"Beam {name!r} degree",
                expected="an integer from 1 to 12",
                got=repr(degree),
                fix="Use 1, 2 or 3.",
            )
        self.section = section
        self.damping = damping
        self.approximation = require_approximation(f"Beam {name!r} approximation", approximation)
        self.degree = int(degree)
        self.placement = Placement.of(name, start, end, curvature, normal)
        self._coefficients = section.coefficients(self.space)
        self.loads = require_loads(f"Beam {name!r} loads", loads, self.space)
        self._load_ports = {f"load {load.name}": Port(self, f"load {load.name}", LINE) for load in self.loads}
        self.boundaries = fractions_of(name, elements) * self.length
        self.ends = parse_causality(f"Beam {name!r} causality", causality)
        self.switch_at = switch_at
        self.switch_element = self._nearest_boundary(switch_at)
        if self.ends is not None and self.ends[0] != self.ends[1] and self.elements == 1:
            raise DataError(
                f"Beam {name!r} causality",
                expected="equal ends for a beam of one element",
                got=repr(causality),
                fix="Use at least two elements: the switch needs an interior element boundary.",
            )
        where, end_angle = self.placement, self.start_angle + self.curvature * self.length
        self.start = Anchor(self, "start", where.start, self.start_angle, 0.0, frame=where.frame(0.0))
        self.end = Anchor(self, "end", where.end, end_angle, 1.0, frame=where.frame(self.length))

    @property
    def curvature(self) -> float:
        """Initial curvature, 1/m."""
        return self.placement.curvature

    @property
    def length(self) -> float:
        """Along the initial arc, m."""
        return self.placement.length

    @property
    def start_angle(self) -> float:
        """Initial orientation of the cross section at the start in the plane of axes 1 and 2, rad."""
        return self.placement.angle

    @property
    def elements(self) -> int:
        """Number of elements."""
        return int(self.boundaries.size - 1)

    @property
    def anchors(self) -> Mapping[str, Anchor]:
        """The two ends: start and end."""
        return {"start": self.start, "end": self.end}

    @property
    def space(self) -> Space:
        """The components of the beam."""
        return self.placement.space

    def exposures(self) -> Sequence[Exposure]:
        """List the inputs that the loads are.

        Returns
        -------
        sequence of Exposure
            One for each load.
        """
        return [
            Exposure(load.name, port, gives=False, follows=load.follows, signal=load.force)
            for load, port in zip(self.loads, self._load_ports.values(), strict=True)
        ]

    @property
    def arguments(self) -> dict[str, Any]:
        """Those of the constructor that were given; of a nested beam the loads have their longer names."""
        return {**super().arguments, **({"loads": self.loads} if self.loads else {})}

    def prefix(self, prefix: str) -> None:
        """Put a prefix before the name of the beam and those of its loads.

        Parameters
        ----------
        prefix : str
            Of a copy in a diagram that is nested in another.
        """
        super().prefix(prefix)
        self.loads = tuple(replace(load, name=prefix + load.name) for load in self.loads)

    def at(self, s: float) -> BlockPoint:
        """Name a point of the beam, for reading results.

        Parameters
        ----------
        s : float
            Fraction of the length, from 0 (start) to 1 (end).

        Returns
        -------
        BlockPoint
            To be given to ``solution.position`` and the like.

        Raises
        ------
        DataError
            If s is not in [0, 1].
        """
        return BlockPoint(self, fraction(s, f"point on beam {self.name!r}"))

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say what the four ports are able to do.

        Returns
        -------
        choices : sequence of PortChoice
            All free with causality "auto", all fixed otherwise.
        ties : sequence of Tie
            Each pair prefers equal ends: a switch costs one. None if the beam is taken for rigid: then all give.
        """
        if self.held:
            return [PortChoice(port, may_give=True, may_take=False) for port in self.ports.values()], []
        choices = []
        for i, anchor in enumerate((self.start, self.end)):
            for port, fixed in zip(anchor.ports, self.ends[i] if self.ends else (None, None), strict=True):
                choices.append(PortChoice(port, fixed is not False, fixed is not True, shares="anchor"))
        cost = 1.0 if self.elements > 1 else None
        ties = [
            Tie(a, b, cost, f"a switch of {a.domain.name} inside beam {self.name!r}")
            for a, b in zip(self.start.ports, self.end.ports, strict=True)
        ]
        return choices, ties

    def alternatives(self) -> Sequence[Alternative]:
        """List versions with more choice: ends that choose, and elements enough for a switch.

        Returns
        -------
        sequence of Alternative
            None if the beam is free to choose already, or taken for rigid.
        """
        if self.held:
            return []
        chosen = f' (causality="auto", was "{"-".join(END_NAMES[e] for e in self.ends)}")' if self.ends else ""
        first = f"let beam {self.name!r} choose its ends{chosen}"
        result = [Alternative(self._like("", self._fractions), first)] if self.ends else []
        if self.elements == 1:
            what = f"give beam {self.name!r} two elements" + (f" and {first}" if self.ends else "")
            result.append(Alternative(self._like("", np.array([0.0, 0.5, 1.0])), what))
        return result

    @property
    def coarsest(self) -> Beam:
        """The beam in two elements of degree one, without damping and loads; two, as its ends may need a switch."""
        at = self.placement
        return Beam(self.name, self.section, at.start, at.end, 2, curvature=self.curvature, normal=self._normal)

    def split(self, at: float) -> tuple[Beam, Beam]:
        """Cut the beam in two: blocks of their own, to be joined with ``weld(first.end, second.start)``.

        Parameters
        ----------
        at : float
            Where, as a fraction of the length. An element that is cut becomes two.

        Returns
        -------
        tuple of Beam
            From start to the cut and from there to the end, named such as ``"crank-1"`` and ``"crank-2"``. Section,
            damping, loads (named likewise), degree, curvature and element boundaries are kept; all ends choose their
            causality.

        Raises
        ------
        DataError
            If at is not between 0 and 1.
        """
        where = f"Beam {self.name!r} split at"
        if not 0.0 < require_real(where, at) < 1.0:
            raise DataError(
                where, expected="a fraction between 0 and 1", got=repr(at), fix="0.5 cuts it in the middle."
            )
        inner = self._fractions[1:-1]
        inner = inner[np.abs(inner - at) > 1e-9]
        low, high = inner[inner < at], inner[inner > at]
        pieces = np.array([0.0, *low / at, 1.0]), np.array([0.0, *(high - at) / (1.0 - at), 1.0])
        cut = self.placement.at(np.array([at * self.length]))[0]
        ends = (self.placement.start, cut), (cut, self.placement.end)
        return (
            self._like("-1", pieces[0], *ends[0]),
            self._like("-2", pieces[1], *ends[1]),
        )

    @property
    def _fractions(self) -> Floats:
        fractions = self.boundaries / self.length
        fractions[-1] = 1.0
        return fractions

    def _like(self, suffix: str, elements: Floats, start: Floats | None = None, end: Floats | None = None) -> Beam:
        """Make a beam of the same kind whose ends choose; the suffix is that of its name and of its loads."""
        return Beam(
            self.name + suffix,
            self.section,
            self.placement.start if start is None else start,
            self.placement.end if end is None else end,
            elements,
            degree=self.degree,
            curvature=self.curvature,
            switch_at=self.switch_at,
            damping=self.damping,
            loads=[replace(load, name=load.name + suffix) for load in self.loads],
            approximation=self.approximation,
            normal=self._normal,
        )

    @property
    def _normal(self) -> Floats | None:
        return None if self.placement.axes is None else self.placement.axes[:, 2]

    @property
    def held(self) -> bool:
        """Whether the beam is taken for rigid: all its ports give velocity then."""
        if not self.kept.flexible and self.space != PLANAR:
            raise OrientationError(
                f"beam {self.name!r} with flexible=False",
                expected="a planar beam",
                got="a spatial one: a rigid body in space has an orientation that turns, which is not computed yet",
                fix="Keep flexible=True, or give both ends two coordinates.",
            )
        return not self.kept.flexible

    @property
    def rigid(self) -> Rigid | None:
        """What the beam weighs if it is taken for rigid."""
        return self._line.body if self.held else None

    @property
    def _line(self) -> RigidLine:
        coefficients, _ = kept_coefficients(self._coefficients, self.kept)
        return RigidLine(self.placement.start, self.start_angle, self.curvature, self.length, coefficients)

    def effects(self, form: Form) -> Mapping[str, Ints]:
        """List the effects that the beam has and could leave out; see ``Block.effects``.

        Parameters
        ----------
        form : Form
            What ``reduced_form`` made of the beam.

        Returns
        -------
        mapping of str to numpy.ndarray
            Name of the effect -> the states that carry its energy.
        """
        found = dict(super().effects(form))
        if self.held:
            return found
        own = self.section.coefficients(self.space)  # a compliance of zero is not there to be left out
        names = [name for name, parts in COMPONENTS.items() if getattr(self.kept, name) and own[list(parts)].any()]
        found |= {name: states(form.runs, COMPONENTS[name]) for name in names}
        found["flexible"] = states(form.runs, STRAINS)
        if self.damping is not None and self.kept.internal_damping and (self.damping.times > 0.0).any():
            found["internal_damping"] = np.empty(0, dtype=np.int64)
        return found

    def left_out(self, form: Form) -> Mapping[str, int]:
        """List the effects that are left out on request; see ``Block.left_out``.

        Parameters
        ----------
        form : Form
            What ``reduced_form`` made of the beam.

        Returns
        -------
        mapping of str to int
            Name of the effect -> number of states that belong to it. The states of strains and inertias that are left
            out are still there, without energy.
        """
        found = dict(super().left_out(form))
        if self.held:
            whole = self.mesh(ENDS["free"], ENDS["free"])
            return found | {"flexible": whole.size - form.size}
        if self.kept.large_rotation == "second-order":
            found["large_rotation"] = 0
        found |= {
            name: states(form.runs, components).size
            for name, components in COMPONENTS.items()
            if not getattr(self.kept, name)
        }
        if self.damping is not None and not self.kept.internal_damping:
            damped = self.damping.times > 0.0
            found["internal_damping"] = sum(
                run.positions.size for run in form.runs if damped[component_index(run.field[0], int(run.field[1]) - 1)]
            )
        return found

    def mesh(self, start: End, end: End) -> Mesh:
        """Number the states for given causalities of the ends.

        Parameters
        ----------
        start, end : End
            What the two ends give.

        Returns
        -------
        Mesh
            With one segment, or two if a pair switches.
        """
        n = self.elements
        if start == end:
            segments = [Segment(0, n, Variant(*start))]
        else:
            m = self.switch_element
            segments = [Segment(0, m, Variant(*start)), Segment(m, n, Variant(*end))]
        return number_states(self.boundaries, self.degree, segments, self.space)

    def form(self, gives: Mapping[str, bool]) -> BeamForm | SpatialBeamForm | RigidBeamForm:
        """Reduce the beam to its matrices for a given causality.

        Parameters
        ----------
        gives : mapping of str to bool
            For each of the four ports whether it gives the velocity.

        Returns
        -------
        BeamForm, SpatialBeamForm or RigidBeamForm
            Matrices, ports, orientation and mass points.
        """
        loads = dict(zip(self._load_ports, self.loads, strict=True))
        if self.held:
            return rigid_form(self._line, self.damping, loads)
        start, end = (End(gives[f"{a}.translation"], gives[f"{a}.rotation"]) for a in ("start", "end"))
        if self.placement.axes is not None:
            return spatial_form(
                self.mesh(start, end),
                (start, end),
                placement=self.placement,
                coefficients=self._coefficients,
                damping=self.damping,
                loads=loads,
                kept=self.kept,
            )
        return beam_form(
            self.mesh(start, end),
            (start, end),
            coefficients=self._coefficients,
            curvature=self.curvature,
            origin=self.placement.start,
            start_angle=self.start_angle,
            damping=self.damping,
            loads=loads,
            kept=self.kept,
        )

    def end_names(self, gives: Mapping[str, bool]) -> str:
        """Name a causality of the beam.

        Parameters
        ----------
        gives : mapping of str to bool
            For each of the four ports whether it gives the velocity.

        Returns
        -------
        str
            Such as "clamped-free".
        """
        ends = (End(gives[f"{a}.translation"], gives[f"{a}.rotation"]) for a in ("start", "end"))
        return "-".join(END_NAMES[e] for e in ends)

    def _nearest_boundary(self, switch_at: float) -> int:
        if not 0.0 < require_real(f"Beam {self.name!r} switch_at", switch_at) < 1.0:
            raise DataError(
                f"Beam {self.name!r} switch_at",
                expected="a fraction between 0 and 1",
                got=repr(switch_at),
                fix="0.5 puts the switch in the middle.",
            )
        inner = self.boundaries[1:-1]
        return 1 + int(np.argmin(np.abs(inner - switch_at * self.length))) if inner.size else 0
