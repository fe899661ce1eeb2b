"""What rigid bodies and point masses reduce themselves to, with what can be read of their motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from phblocks.blocks.checks import require_point
from phblocks.blocks.form import Form, History
from phblocks.errors import UnknownNameError
from phblocks.frames import QUARTER, rotate
from phblocks.ports import Place
from phblocks.triplets import Floats


@dataclass(frozen=True)
class BodyForm(Form):
    """A body in its own coordinates: velocity of the centre of mass in the fixed frame, and spin.

    Parameters
    ----------
    start_angle : float
        Initial orientation, rad.
    centre : numpy.ndarray
        Initial position of the centre of mass, shape (2,), m.
    places : tuple of Place
        The anchors, for drawing.
    """

    start_angle: float = field(kw_only=True)
    centre: Floats = field(kw_only=True)
    places: tuple[Place, ...] = field(kw_only=True, default=())
    base: ClassVar[Place] = (0.0, 0.0)

    def place(self, s: object, where: str) -> Place:
        """Check coordinates in the frame of the body; see :meth:`Form.place`.

        Parameters
        ----------
        s : object
            The candidate.
        where : str
            What it is, for the message.

        Returns
        -------
        Place
            Two coordinates, m, from the centre of mass.

        Raises
        ------
        DataError
            If it has not two finite coordinates.
        ArgumentTypeError
            If it is not made of numbers.
        """
        return tuple(require_point(where, s).tolist())  # type: ignore[arg-type]  # checked there

    def outline(self) -> Sequence[Place]:
        """List the anchors, each joined to the centre of mass; see :meth:`Form.outline`.

        Returns
        -------
        sequence of Place
            Coordinates in the frame of the body, m.
        """
        return tuple(p for place in self.places for p in (self.base, place)) or (self.base,)

    def value(self, history: History, name: str, place: Place) -> Floats:
        """Read a state; see :meth:`Form.value`.

        Parameters
        ----------
        history : History
            Of this body.
        name : str
            "vx", "vy" or "W3".
        place : Place
            Does not matter.

        Returns
        -------
        numpy.ndarray
            Shape (times,).

        Raises
        ------
        UnknownNameError
            If the body has no such state.
        """
        names = [run.field for run in self.runs]
        if name not in names:
            raise UnknownNameError("body", expected=f"one of {', '.join(names)}", got=repr(name), fix="Correct it.")
        return history.x[:, names.index(name)]

    def velocity(self, history: History, place: Place) -> Floats:
        """Read the velocity of a place in the frame of the body; see :meth:`Form.velocity`.

        Parameters
        ----------
        history : History
            Of this body.
        place : Place
            Coordinates in the frame of the body, m.

        Returns
        -------
        numpy.ndarray
            Shape (times, 2), m/s.
        """
        v = history.x[:, :2]
        material = rotate(-self.angle(history, place), v)
        spin = history.x[:, 2:3] if history.x.shape[1] > 2 else 0.0
        return np.asarray(material + spin * (QUARTER @ np.asarray(place)))

    def angle(self, history: History, place: Place) -> Floats:
        """Read the orientation; see :meth:`Form.angle`.

        Parameters
        ----------
        history : History
            Of this body.
        place : Place
            Does not matter.

        Returns
        -------
        numpy.ndarray
            Shape (times,), rad.
        """
        return np.asarray(self.start_angle + history.theta.sum(axis=1))

    def position(self, history: History, place: Place) -> Floats:
        """Read the position: that of the centre of mass, integrated from velocity, and the lever to the place.

        Parameters
        ----------
        history : History
            Of this body, with points.
        place : Place
            Coordinates in the frame of the body, m.

        Returns
        -------
        numpy.ndarray
            Shape (times, 2), m.

        Raises
        ------
        UnknownNameError
            If positions were not tracked.
        """
        if history.points is None:
            raise UnknownNameError(
                "position", expected="tracked positions", got="none", fix='Compile with outputs="all".'
            )
        return history.points[:, 0] + self.chord(history, self.base, place)

    def chord(self, history: History, first: Place, second: Place) -> Floats:
        """Return the vector between two places; see :meth:`Form.chord`.

        Parameters
        ----------
        history : History
            Of this body.
        first, second : Place
            Coordinates in the frame of the body, m.

        Returns
        -------
        numpy.ndarray
            From first to second, shape (times, 2), m.
        """
        lever = np.asarray(second) - np.asarray(first)
        return rotate(self.angle(history, first), lever)

    def mean_chord(self, history: History) -> Floats:
        """Return the vector from the centre of mass to itself: zero.

        Parameters
        ----------
        history : History
            Of this body.

        Returns
        -------
        numpy.ndarray
            Shape (times, 2), m.
        """
        return np.zeros((history.x.shape[0], 2))

    def moving(self, velocity: Floats, spin: Floats, about: Floats) -> Floats:
        """Return the states of a rigid motion; see :meth:`Form.moving`.

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
            Shape (size,).
        """
        v = velocity + spin * (QUARTER @ (self.centre - about))
        return np.array([*v, spin])[: self.size]
