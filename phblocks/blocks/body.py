"""Rigid bodies and point masses. Linear momentum is kept in the fixed frame, where it is conserved to round-off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from phblocks.approximation import Approximation, require_approximation
from phblocks.blocks.block import Block, BlockPoint, PortChoice, Replacement, Rigid, Tie
from phblocks.blocks.body_form import BodyForm
from phblocks.blocks.checks import is_one_of, require_point, require_positive, require_real
from phblocks.blocks.form import FIXED, AngleRows, MaterialPoints, Piece, PortForm, StateRun
from phblocks.errors import ArgumentTypeError, DataError, UnknownNameError
from phblocks.frames import QUARTER
from phblocks.ports import Anchor, Port
from phblocks.space import PLANAR, Space
from phblocks.triplets import Floats, Triplets

VELOCITIES = tuple(StateRun(f"v{axis}", "m/s", "kinetic", np.zeros(1)) for axis in "xy")
SPIN = StateRun("W3", "rad/s", "kinetic", np.zeros(1))
#: The material frame of a planar body: its one rotation state.
BODY_ROWS = Triplets.of([0], [0], values=1.0)


class RigidBody(Block):
    """A rigid body with any number of anchors, all of which give velocity and angular velocity.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    mass : float
        kg.
    inertia : float
        About the centre of mass, kg m^2.
    centre : array_like
        Initial position of the centre of mass, shape (2,), m.
    anchors : mapping of str to array_like, optional
        Places where others can be attached, by name; the centre of mass is always there as ``"centre"``.
    coordinates : {"world", "body"}, optional
        What the coordinates of the anchors are: initial positions in the fixed frame, or coordinates in the frame of
        the body, from its centre of mass.
    angle : float, optional
        Initial orientation of the frame of the body, rad.
    approximation : Approximation, optional
        What is left out in this body (large rotations, gravity), whatever is left out in the rest of the diagram.

    Raises
    ------
    DataError
        If a number is out of its range or a name is taken.
    ArgumentTypeError
        If an argument is of the wrong kind.

    Notes
    -----
    States are the velocity of the centre of mass in the fixed frame and the spin; ``v_anchor = v + W x Lambda d``.
    """

    def __init__(
        self,
        name: str,
        mass: float,
        inertia: float,
        centre: ArrayLike,
        anchors: Mapping[str, ArrayLike] | None = None,
        coordinates: Literal["world", "body"] = "world",
        angle: float = 0.0,
        approximation: Approximation | None = None,
    ) -> None:
        super().__init__(name)
        where = f"RigidBody {name!r}"
        self.approximation = require_approximation(f"{where} approximation", approximation)
        self.mass = require_positive(f"{where} mass", mass)
        self.inertia = require_positive(f"{where} inertia", inertia)
        self.start = require_point(f"{where} centre", centre)
        self.angle = require_real(f"{where} angle", angle)
        if not np.isfinite(self.angle):
            raise DataError(f"{where} angle", expected="a finite angle, rad", got=repr(angle), fix="Correct it.")
        if not is_one_of(coordinates, ("world", "body")):
            raise DataError(f"{where} coordinates", expected='"world" or "body"', got=repr(coordinates), fix="Choose.")
        turn = np.cos(self.angle) * np.eye(2) + np.sin(self.angle) * QUARTER
        levers = {"centre": np.zeros(2)}
        if anchors is not None and not isinstance(anchors, Mapping):
            raise ArgumentTypeError(
                f"{where} anchors",
                expected="a mapping from names to places",
                got=repr(anchors),
                fix='Write for instance {"hook": (1.0, 0.0)}.',
            )
        for key, place in (anchors or {}).items():
            if key in levers:
                raise DataError(f"{where} anchors", expected="a name not in use", got=repr(key), fix="Rename it.")
            point = require_point(f"{where} anchor {key!r}", place)
            levers[key] = point if coordinates == "body" else turn.T @ (point - self.start)
        self._anchors = {
            key: Anchor(self, key, self.start + turn @ d, self.angle, place=tuple(d.tolist()))
            for key, d in levers.items()
        }

    @property
    def anchors(self) -> Mapping[str, Anchor]:
        """All anchors by name."""
        return self._anchors

    @property
    def centre(self) -> Anchor:
        """The anchor at the centre of mass."""
        return self._anchors["centre"]

    def __getitem__(self, name: str) -> Anchor:
        """Return the anchor of that name: ``body["left"]``."""
        try:
            return self._anchors[name]
        except KeyError:
            raise UnknownNameError(
                f"RigidBody {self.name!r}",
                expected=f"one of the anchors {', '.join(self._anchors)}",
                got=repr(name),
                fix="Name it in anchors={...}.",
            ) from None

    @property
    def space(self) -> Space:
        """The components of the body."""
        return PLANAR

    def at(self, place: ArrayLike) -> BlockPoint:
        """Name a point of the body, for reading results.

        Parameters
        ----------
        place : array_like
            Coordinates in the frame of the body, from its centre of mass, shape (2,), m.

        Returns
        -------
        BlockPoint
            To be given to ``solution.position`` and the like.
        """
        return BlockPoint(self, tuple(require_point(f"point on {self.name!r}", place).tolist()))

    @property
    def rigid(self) -> Rigid:
        """What the body weighs."""
        return Rigid(self.mass, self.inertia, self.start, self.angle)

    def welded_to(self, other: Block, name: str) -> Replacement | None:
        """Make one body of this one and another that cannot move against it; see ``Block.welded_to``.

        Parameters
        ----------
        other : Block
            What it is welded to.
        name : str
            Of the new body.

        Returns
        -------
        Replacement or None
            With the mass, centre and inertia of both; ``None`` if the other is not rigid.
        """
        return _welded(self, other, name)

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that all ports give velocity.

        Returns
        -------
        choices : sequence of PortChoice
            One for each port.
        ties : sequence of Tie
            None.
        """
        return [PortChoice(p, may_give=True, may_take=False, shares=self._shares(p)) for p in self.ports.values()], []

    def _shares(self, port: Port) -> Literal["anchor", "fixed"] | None:
        """Angular velocity is a state of its own, and so is the velocity of the centre of mass."""
        if port.domain.turns_with == "rotation":
            return "anchor"
        assert port.anchor is not None
        return "fixed" if not np.any(port.anchor.place) else None

    def form(self, gives: Mapping[str, bool]) -> BodyForm:
        """Reduce the body to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            Always true.

        Returns
        -------
        BodyForm
            Three states.
        """
        ports = {}
        for anchor in self._anchors.values():
            x, y = anchor.place  # type: ignore[misc]  # made with two coordinates
            lever = Piece(Triplets.of([0, 1], [2, 2], values=[-y, x]))
            velocity = Piece(Triplets.of([0, 1], [0, 1], values=1.0), FIXED)
            ports[anchor.translation.name] = PortForm(True, (velocity, lever) if x or y else (velocity,))
            ports[anchor.rotation.name] = PortForm(True, (Piece(Triplets.of([0], [2], values=1.0)),))
        frame = AngleRows(BODY_ROWS, np.array([self.angle]))
        return BodyForm(
            size=3,
            runs=(*VELOCITIES, SPIN),
            E=Triplets.of([0, 1, 2], [0, 1, 2], values=[self.mass, self.mass, self.inertia]),
            J0=Triplets.empty(),
            R=Triplets.empty(),
            T=Triplets.empty(3),
            ports=ports,
            rotation_states=np.array([2]),
            orientations={key: frame for key in self._anchors},
            points=_centre_of_mass(self.mass, self.start),
            start_angle=self.angle,
            centre=self.start,
            places=tuple(a.place for a in self._anchors.values()),
        )


class Mass(Block):
    """A point mass; its anchor gives velocity and has no orientation.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    mass : float
        kg.
    position : array_like
        Initial position, shape (2,), m.
    approximation : Approximation, optional
        What is left out in this mass (gravity), whatever is left out in the rest of the diagram.

    Raises
    ------
    DataError
        If a number is out of its range.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    def __init__(self, name: str, mass: float, position: ArrayLike, approximation: Approximation | None = None) -> None:
        super().__init__(name)
        self.approximation = require_approximation(f"Mass {name!r} approximation", approximation)
        self.mass = require_positive(f"Mass {name!r} mass", mass)
        self.start = require_point(f"Mass {name!r} position", position)
        self.centre = Anchor(self, "centre", self.start, place=(0.0, 0.0), turns=False)

    @property
    def anchors(self) -> Mapping[str, Anchor]:
        """The one anchor: centre."""
        return {"centre": self.centre}

    @property
    def space(self) -> Space:
        """The components of the mass."""
        return PLANAR

    @property
    def rigid(self) -> Rigid:
        """What the mass weighs."""
        return Rigid(self.mass, 0.0, self.start, None)

    def welded_to(self, other: Block, name: str) -> Replacement | None:
        """Make one body of this one and another that cannot move against it; see ``Block.welded_to``.

        Parameters
        ----------
        other : Block
            What it is welded to.
        name : str
            Of the new body.

        Returns
        -------
        Replacement or None
            With the mass, centre and inertia of both; ``None`` if the other is not rigid.
        """
        return _welded(self, other, name)

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that the mass gives velocity.

        Returns
        -------
        choices : sequence of PortChoice
            One.
        ties : sequence of Tie
            None.
        """
        return [PortChoice(self.centre.translation, may_give=True, may_take=False, shares="fixed")], []

    def form(self, gives: Mapping[str, bool]) -> BodyForm:
        """Reduce the mass to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            Always true.

        Returns
        -------
        BodyForm
            Two states.
        """
        velocity = Piece(Triplets.of([0, 1], [0, 1], values=1.0), FIXED)
        return BodyForm(
            size=2,
            runs=VELOCITIES,
            E=Triplets.of([0, 1], [0, 1], values=self.mass),
            J0=Triplets.empty(),
            R=Triplets.empty(),
            T=Triplets.empty(3),
            ports={self.centre.translation.name: PortForm(True, (velocity,))},
            orientations={"centre": FIXED},
            points=_centre_of_mass(self.mass, self.start),
            start_angle=0.0,
            centre=self.start,
        )


def _centre_of_mass(mass: float, start: Floats) -> MaterialPoints:
    return MaterialPoints(np.array([mass]), Triplets.of([0, 1], [0, 1], values=1.0), FIXED, start[None])


def _welded(first: Block, second: Block, name: str) -> Replacement | None:
    """One body of two: a point mass of two in the same place, else a rigid body with the anchors of both."""
    a, b = first.rigid, second.rigid
    if a is None or b is None:
        return None
    what = f"make one body of {first.name!r} and {second.name!r}"
    mass = a.mass + b.mass
    if a.angle is None and b.angle is None:
        point = Mass(name, mass, a.centre)
        return Replacement(
            point, {q: point.centre.translation for p in (first, second) for q in p.ports.values()}, what
        )
    centre = (a.mass * a.centre + b.mass * b.centre) / mass
    inertia = sum(p.inertia + p.mass * float(np.sum((p.centre - centre) ** 2)) for p in (a, b))
    anchors = {f"{p.name}-{key}": anchor for p in (first, second) for key, anchor in p.anchors.items()}
    positions = {key: anchor.position for key, anchor in anchors.items() if anchor.position is not None}
    body = RigidBody(name, mass, inertia, centre, positions, angle=b.angle if a.angle is None else a.angle)  # type: ignore[arg-type]  # one has
    places = {q: r for key, anchor in anchors.items() for q, r in zip(anchor.ports, body[key].ports, strict=False)}
    return Replacement(body, places, what)
