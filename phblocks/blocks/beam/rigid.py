"""A beam that does not bend: a rigid body with the ports of the beam, read at fractions of its length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from phblocks.blocks.beam.damping import Damping
from phblocks.blocks.beam.interpolation import fraction
from phblocks.blocks.beam.load import LineLoad
from phblocks.blocks.beam.placement import arc
from phblocks.blocks.beam.spaces import gauss
from phblocks.blocks.beam.tensors import component_index
from phblocks.blocks.block import Rigid
from phblocks.blocks.body import BODY_ROWS, SPIN, VELOCITIES
from phblocks.blocks.body_form import BodyForm
from phblocks.blocks.form import FIXED, AngleRows, History, MaterialPoints, Piece, PortForm
from phblocks.errors import UnknownNameError
from phblocks.frames import QUARTER, rotate
from phblocks.ports import Place
from phblocks.triplets import Floats, Triplets

#: Integrates the moments of an arc of less than half a circle to round-off.
POINTS = 24


@dataclass(frozen=True)
class RigidLine:
    """A circular or straight line with mass.

    Parameters
    ----------
    origin : numpy.ndarray
        Initial place of its start, shape (2,), m.
    angle : float
        Initial orientation at its start, rad.
    curvature : float
        1/m.
    length : float
        m.
    coefficients : numpy.ndarray
        Shape (12,): inertias of the section per length.
    """

    origin: Floats
    angle: float
    curvature: float
    length: float
    coefficients: Floats

    def at(self, s: Floats) -> Floats:
        """Return initial places.

        Parameters
        ----------
        s : numpy.ndarray
            Fractions of the length, shape (m,).

        Returns
        -------
        numpy.ndarray
            Shape (m, 2), m.
        """
        return self.origin + arc(self.curvature, self.angle, self.length * np.asarray(s))

    def lever(self, s: Floats) -> Floats:
        """Return places in the frame of the body, that of its start, from the centre of mass.

        Parameters
        ----------
        s : numpy.ndarray
            Fractions of the length, shape (m,).

        Returns
        -------
        numpy.ndarray
            Shape (m, 2), m.
        """
        return rotate(np.array(-self.angle), self.at(s) - self.centre)

    @property
    def second_moment(self) -> float:
        """Integral of the squared distance from the centre of mass over the length, m^3."""
        s, weights = gauss(POINTS)
        return float(self.length * weights @ ((self.at(s) - self.centre) ** 2).sum(axis=1))

    @property
    def centre(self) -> Floats:
        """Initial place of the centre of mass, shape (2,), m."""
        s, weights = gauss(POINTS)
        return np.asarray(weights @ self.at(s))

    @property
    def body(self) -> Rigid:
        """What it weighs."""
        mass, rotary = self.coefficients[component_index("V", 0)], self.coefficients[component_index("W", 2)]
        inertia = mass * self.second_moment + rotary * self.length
        return Rigid(float(mass * self.length), float(inertia), self.centre, self.angle)


@dataclass(frozen=True)
class RigidBeamForm(BodyForm):
    """A rigid body whose places are fractions of the length of a beam.

    Parameters
    ----------
    line : RigidLine
        The beam.
    """

    line: RigidLine = field(kw_only=True)
    base = 0.0

    def place(self, s: object, where: str) -> Place:
        """Check a fraction of the length; see :meth:`Form.place`."""
        return fraction(s, where)

    def cut_sign(self, place: Place) -> float | None:
        """Tell how the internal force at an end follows from that on the beam; see :meth:`Form.cut_sign`."""
        return {0.0: -1.0, 1.0: 1.0}.get(fraction(place))

    def outline(self) -> Sequence[Place]:
        """List places along the beam; see :meth:`Form.outline`."""
        return tuple(np.linspace(0.0, 1.0, 21).tolist())

    def value(self, history: History, name: str, place: Place) -> Floats:
        """Read a velocity in the frame of the cross section; see :meth:`Form.value`."""
        if name in ("V1", "V2"):
            return self.velocity(history, place)[:, int(name[1]) - 1]
        if name == "W3":
            return history.x[:, 2]
        raise UnknownNameError(
            "beam that is approximated as rigid",
            expected="V1, V2 or W3",
            got=repr(name),
            fix="It has no force inside: ask for the force at an end, or keep flexible=True.",
        )

    def velocity(self, history: History, place: Place) -> Floats:
        """Read the velocity in the frame of the cross section; see :meth:`Form.velocity`."""
        arm = rotate(super().angle(history, place), np.asarray(self._lever(place)))
        fixed = history.x[:, :2] + history.x[:, 2:3] * (arm @ QUARTER.T)
        return rotate(-self.angle(history, place), fixed)

    def angle(self, history: History, place: Place) -> Floats:
        """Read the orientation of a cross section; see :meth:`Form.angle`."""
        return super().angle(history, place) + self.line.curvature * self.line.length * fraction(place)

    def chord(self, history: History, first: Place, second: Place) -> Floats:
        """Return the vector between two places; see :meth:`Form.chord`."""
        lever = np.asarray(self._lever(second)) - np.asarray(self._lever(first))
        return rotate(super().angle(history, first), lever)

    def position(self, history: History, place: Place) -> Floats:
        """Read the position: that of the centre of mass, and the lever to the place; see :meth:`Form.position`."""
        return np.asarray(super().position(history, place) - self.mean_chord(history))

    def mean_chord(self, history: History) -> Floats:
        """Return the vector from the start to the centre of mass; see :meth:`Form.mean_chord`."""
        return rotate(super().angle(history, self.base), -np.asarray(self._lever(self.base)))

    def _lever(self, place: Place) -> Place:
        x, y = self.line.lever(np.array([fraction(place)]))[0]
        return float(x), float(y)


def rigid_form(line: RigidLine, damping: Damping | None, loads: Mapping[str, LineLoad]) -> RigidBeamForm:
    """Reduce a beam to a rigid body.

    Parameters
    ----------
    line : RigidLine
        The beam.
    damping : Damping or None
        Of which the drag is left.
    loads : mapping of str to LineLoad
        By the name of their port.

    Returns
    -------
    RigidBeamForm
        Three states: velocity of the centre of mass in the fixed frame, and spin.
    """
    body = line.body
    frame = AngleRows(BODY_ROWS, np.array([line.angle]))
    ports, orientations = {}, {}
    for name, s in (("start", 0.0), ("end", 1.0)):
        x, y = line.lever(np.array([s]))[0]
        lever = Piece(Triplets.of([0, 1], [2, 2], values=[-y, x]), frame)
        ports[f"{name}.translation"] = PortForm(True, (Piece(Triplets.of([0, 1], [0, 1], values=1.0), FIXED), lever))
        ports[f"{name}.rotation"] = PortForm(True, (Piece(Triplets.of([0], [2], values=1.0)),))
        turned = line.angle + line.curvature * line.length * s
        orientations[name] = AngleRows(BODY_ROWS, np.array([turned]))
    drag = np.zeros(12) if damping is None else damping.drag
    c, c_r = drag[component_index("V", 0)], drag[component_index("W", 2)]
    resist = np.array([c * line.length, c * line.length, c * line.second_moment + c_r * line.length])
    return RigidBeamForm(
        size=3,
        runs=(*VELOCITIES, SPIN),
        E=Triplets.of([0, 1, 2], [0, 1, 2], values=[body.mass, body.mass, body.inertia]),
        J0=Triplets.empty(),
        R=Triplets.of([0, 1, 2], [0, 1, 2], values=resist) if resist.any() else Triplets.empty(),
        T=Triplets.empty(3),
        ports=ports,
        rotation_states=np.array([2]),
        orientations=orientations,
        points=MaterialPoints(
            np.array([body.mass]), Triplets.of([0, 1], [0, 1], values=1.0), FIXED, np.asarray(body.centre)[None]
        ),
        loads={port: _load(load, line) for port, load in loads.items()},
        start_angle=line.angle,
        centre=body.centre,
        line=line,
    )


def _load(load: LineLoad, line: RigidLine) -> Sequence[Piece]:
    """A dead load acts at the centre of mass; one that follows turns with the cross sections, which have a moment."""
    if not load.follows:
        return (Piece(Triplets.of([0, 1], [0, 1], values=line.length), FIXED),)
    s, weights = gauss(POINTS)
    turned = line.curvature * line.length * s
    force = sum(
        line.length * w * (np.cos(a) * np.eye(2) + np.sin(a) * QUARTER) for w, a in zip(weights, turned, strict=True)
    )
    arms = rotate(-turned, line.lever(s))  # in the frames of the cross sections
    moment = line.length * weights @ (arms @ QUARTER.T)
    component, state = np.meshgrid([0, 1], [0, 1], indexing="ij")
    # what acts in the frame of the body is turned into the fixed one by the frame with the opposite angle
    back = AngleRows(BODY_ROWS.scaled(-1.0), np.array([-line.angle]))
    return (
        Piece(Triplets.of(component, state, values=np.asarray(force).T), back),
        Piece(Triplets.of([0, 1], 2, values=moment), FIXED),
    )
