"""Springs and dampers along the line between two anchors; the line follows the anchors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from phblocks.blocks.block import Block, PortChoice, Replacement, Tie
from phblocks.blocks.checks import require_not_negative, require_point, require_positive
from phblocks.blocks.form import CONFIGURATION, FIXED, NO_ENERGY, Form, LineForm, Piece, PortForm, StateRun
from phblocks.ports import Anchor, Port
from phblocks.space import PLANAR, Space
from phblocks.triplets import Floats, Triplets


class Line(Block):
    """What springs and dampers share: two anchors that take velocity, and a force along the line between them.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    start, end : array_like
        Initial places of the two ends, shape (2,), m.

    Raises
    ------
    DataError
        If the places coincide.
    """

    def __init__(self, name: str, start: object, end: object) -> None:
        super().__init__(name)
        kind = type(self).__name__
        self._start, self._end = (
            require_point(f"{kind} {name!r} {w}", p)  # type: ignore[arg-type]  # checked there
            for w, p in (("start", start), ("end", end))
        )
        require_positive(f"{kind} {name!r} length (distance from start to end)", float(np.hypot(*self.span)))
        self.start = Anchor(self, "start", self._start, place=0.0, turns=False)
        self.end = Anchor(self, "end", self._end, place=1.0, turns=False)

    @property
    def span(self) -> Floats:
        """Initial vector from start to end, shape (2,), m."""
        return np.asarray(self._end - self._start)

    @property
    def anchors(self) -> Mapping[str, Anchor]:
        """The two ends: start and end."""
        return {"start": self.start, "end": self.end}

    @property
    def space(self) -> Space:
        """The components of the line."""
        return PLANAR

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that both ends take velocity and give force.

        Returns
        -------
        choices : sequence of PortChoice
            Two.
        ties : sequence of Tie
            None.
        """
        return [PortChoice(p, may_give=False, may_take=True) for p in self.ports.values()], []

    def _outer(self, other: Line, inner: tuple[Port, Port]) -> tuple[Anchor, Anchor] | None:
        """Return the two ends that are not joined to each other; ``None`` if they are in one place."""
        first, second = (
            line.end if port is line.start.translation else line.start
            for line, port in zip((self, other), inner, strict=True)
        )
        apart = np.linalg.norm(np.asarray(second.position) - np.asarray(first.position))
        return (first, second) if apart > 0.0 else None

    def _replaced(self, other: Line, line: Line, outer: tuple[Anchor, Anchor]) -> Replacement:
        """The line from one outer end to the other."""
        what = f"make one {type(self).__name__.lower()} of {self.name!r} and {other.name!r} in series"
        places = {outer[0].translation: line.start.translation, outer[1].translation: line.end.translation}
        return Replacement(line, places, what)

    def _form(self, energy: str, E: Triplets, R: Triplets, start: float, free: float, stretch: float | None) -> Form:
        """Three states: the force N (tension positive) and the span."""
        ends = (("start.translation", -1.0), ("end.translation", 1.0))
        zero = np.zeros(1)
        return Form(
            size=3,
            runs=(
                StateRun("N", "N", energy, zero),
                StateRun("rx", "m", CONFIGURATION, zero),
                StateRun("ry", "m", CONFIGURATION, zero),
            ),
            E=E,
            J0=Triplets.empty(),
            R=R,
            T=Triplets.empty(3),
            ports={port: PortForm(False, (Piece(Triplets.of([0], [0], values=sign), line=0),)) for port, sign in ends},
            orientations={"start": FIXED, "end": FIXED},
            start=np.array([start, *self.span]),
            lines=(LineForm(ends[0][0], ends[1][0], 1, free, None if stretch is None else (0, stretch)),),
        )


class Spring(Line):
    """Linear spring between two anchors.

    The direction of the force is span over length, and the length follows from the force, ``l = free + N/k``, so
    that elongation and geometry do not separate: the energy ``N^2 / (2 k)`` is that of the distance of the anchors
    at every step.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    stiffness : float
        k, N/m.
    start, end : array_like
        Initial places of the two ends, shape (2,), m.
    free_length : float, optional
        Length at zero force, m, zero or more; the initial distance by default.

    Raises
    ------
    DataError
        If a number is out of its range or the places coincide.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    def __init__(
        self, name: str, stiffness: float, start: object, end: object, free_length: float | None = None
    ) -> None:
        super().__init__(name, start, end)
        self.stiffness = require_positive(f"Spring {name!r} stiffness", stiffness)
        length = float(np.hypot(*self.span))
        self.free_length = length if free_length is None else free_length
        if free_length is not None:
            require_not_negative(f"Spring {name!r} free_length", free_length)

    def in_series_with(self, other: Block, name: str, inner: tuple[Port, Port]) -> Replacement | None:
        """Make one spring of this one and another in series: ``1/k = 1/k_1 + 1/k_2``, free lengths added.

        It is what the two are without a mass between them, once they are straight.

        Parameters
        ----------
        other : Block
            The other one.
        name : str
            Of the new spring.
        inner : (Port, Port)
            The ports that are joined to each other.

        Returns
        -------
        Replacement or None
            ``None`` if the other is no spring, or the outer ends are in one place.
        """
        outer = self._outer(other, inner) if isinstance(other, Spring) else None
        if outer is None or not isinstance(other, Spring):
            return None
        stiffness = 1.0 / (1.0 / self.stiffness + 1.0 / other.stiffness)
        free = self.free_length + other.free_length
        spring = Spring(name, stiffness, outer[0].position, outer[1].position, free)
        return self._replaced(other, spring, outer)

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the spring to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            Always false.

        Returns
        -------
        Form
            Force and span.
        """
        force = self.stiffness * (float(np.hypot(*self.span)) - self.free_length)
        compliance = 1.0 / self.stiffness
        E = Triplets.of([0], [0], values=compliance)
        return self._form("strain", E, Triplets.empty(), force, self.free_length, compliance)


class Damper(Line):
    """Linear viscous damper between two anchors: force = damping times the rate of their distance.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    damping : float
        c, N s/m.
    start, end : array_like
        Initial places of the two ends, shape (2,), m.

    Raises
    ------
    DataError
        If a number is out of its range or the places coincide.
    ArgumentTypeError
        If an argument is of the wrong kind.

    Notes
    -----
    The force is a state without energy, ``0 = d . (v_end - v_start) - N / c``.
    """

    def __init__(self, name: str, damping: float, start: object, end: object) -> None:
        super().__init__(name, start, end)
        self.damping = require_positive(f"Damper {name!r} damping", damping)

    def in_series_with(self, other: Block, name: str, inner: tuple[Port, Port]) -> Replacement | None:
        """Make one damper of this one and another in series: ``1/c = 1/c_1 + 1/c_2``.

        It is what the two are without a mass between them, once they are straight.

        Parameters
        ----------
        other : Block
            The other one.
        name : str
            Of the new damper.
        inner : (Port, Port)
            The ports that are joined to each other.

        Returns
        -------
        Replacement or None
            ``None`` if the other is no damper, or the outer ends are in one place.
        """
        outer = self._outer(other, inner) if isinstance(other, Damper) else None
        if outer is None or not isinstance(other, Damper):
            return None
        damping = 1.0 / (1.0 / self.damping + 1.0 / other.damping)
        damper = Damper(name, damping, outer[0].position, outer[1].position)
        return self._replaced(other, damper, outer)

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the damper to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            Always false.

        Returns
        -------
        Form
            Force and span.
        """
        R = Triplets.of([0], [0], values=1.0 / self.damping)
        return self._form(NO_ENERGY, Triplets.empty(), R, 0.0, 0.0, None)
