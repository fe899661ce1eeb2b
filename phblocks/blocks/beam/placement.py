"""Where a beam is at first: an arc or a straight line in the plane of its axes 1 and 2, and its element boundaries."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from phblocks.blocks.checks import require_direction, require_place, require_real
from phblocks.errors import ArgumentTypeError, DataError, SpaceError
from phblocks.space import Space, space_of
from phblocks.triplets import Floats, real_array

#: More elements than this are a mistake, and would fill the memory before anybody noticed.
MOST_ELEMENTS = 1_000_000
#: A beam closer than this to the direction that axis 3 was to have leaves it no choice (sine of the angle).
PARALLEL = 1e-6


@dataclass(frozen=True, eq=False)
class Placement:
    """The two ends of a beam, its arc and its axes.

    Parameters
    ----------
    start, end : numpy.ndarray
        Places of the two ends, shape (dimension,), m.
    curvature : float
        About axis 3, 1/m.
    length : float
        Of the arc, m.
    angle : float
        Orientation of the cross section at the start in the plane of axes 1 and 2, rad.
    axes : numpy.ndarray or None
        Of a beam in space: the directions that the angle is counted from, axis 3 last, as columns, shape (3, 3).
    """

    start: Floats
    end: Floats
    curvature: float
    length: float
    angle: float
    axes: Floats | None

    @classmethod
    def of(
        cls, name: str, start: ArrayLike, end: ArrayLike, curvature: float | None, normal: ArrayLike | None
    ) -> Placement:
        """Check what a user gives.

        Parameters
        ----------
        name : str
            Of the beam, for messages.
        start, end : array_like
            Places of the two ends, shape (2,) or (3,), m.
        curvature : float or None
            About axis 3, 1/m.
        normal : array_like or None
            Direction that axis 3 is to be near to, shape (3,).

        Returns
        -------
        Placement
            Of the beam.

        Raises
        ------
        DataError
            If a number is out of its range.
        ArgumentTypeError
            If an argument is of the wrong kind.
        SpaceError
            If the ends are of different spaces, or axis 3 is given in the plane.
        """
        a, b = (require_place(f"Beam {name!r} {w}", p) for w, p in (("start", start), ("end", end)))
        if a.size != b.size:
            raise SpaceError(
                f"Beam {name!r} end",
                expected=f"{a.size} coordinates, as of its start",
                got=str(b.size),
                fix="Two coordinates make a planar beam, three a spatial one.",
            )
        span = b - a
        chord = float(np.linalg.norm(span)) if a.size == 3 else float(np.hypot(*span))
        if not (math.isfinite(chord) and chord > 0.0 and math.isfinite(1.0 / chord)):
            raise DataError(
                f"Beam {name!r} length (distance from start to end)",
                expected="a finite number > 0",
                got=repr(chord),
                fix="Give a value in SI units.",
            )
        bend = _curvature(name, curvature, chord)
        length = _arc_length(bend, chord)
        axes = _axes(name, span / chord, normal)
        along = math.atan2(span[1], span[0]) if axes is None else 0.0
        return cls(a, b, bend, length, along - 0.5 * bend * length, axes)

    @property
    def space(self) -> Space:
        """That of its coordinates."""
        return space_of(self.start.size)

    def at(self, s: Floats) -> Floats:
        """Return initial places.

        Parameters
        ----------
        s : numpy.ndarray
            Lengths from the start, shape (m,), m.

        Returns
        -------
        numpy.ndarray
            Shape (m, dimension), m.
        """
        flat = arc(self.curvature, self.angle, s)
        return np.asarray(self.start + (flat if self.axes is None else flat @ self.axes[:, :2].T))

    def frames(self, s: Floats) -> Floats:
        """Return initial orientations of cross sections of a beam in space.

        Parameters
        ----------
        s : numpy.ndarray
            Lengths from the start, shape (m,), m.

        Returns
        -------
        numpy.ndarray
            Their axes as columns, shape (m, 3, 3).
        """
        assert self.axes is not None
        angle = self.angle + self.curvature * np.asarray(s)
        about = np.zeros((angle.size, 3, 3))
        about[:, 0, 0] = about[:, 1, 1] = np.cos(angle)
        about[:, 1, 0] = np.sin(angle)
        about[:, 0, 1] = -about[:, 1, 0]
        about[:, 2, 2] = 1.0
        return np.asarray(self.axes @ about)

    def frame(self, s: float) -> Floats | None:
        """Return the initial orientation of one cross section.

        Parameters
        ----------
        s : float
            Length from the start, m.

        Returns
        -------
        numpy.ndarray or None
            Shape (3, 3); ``None`` in the plane.
        """
        return None if self.axes is None else self.frames(np.array([s]))[0]


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


def _axes(name: str, along: Floats, normal: ArrayLike | None) -> Floats | None:
    """Axes of a beam in space: 1 along the chord, 3 as near as can be to a direction."""
    where = f"Beam {name!r} normal"
    if along.size == 2:
        if normal is not None:
            raise SpaceError(
                where,
                expected="none for a planar beam, whose axis 3 is out of the plane",
                got=repr(normal),
                fix="Leave it out, or give three coordinates to both ends.",
            )
        return None
    wanted = np.array([0.0, 0.0, 1.0]) if normal is None else require_direction(where, normal, dimension=3)
    if float(np.linalg.norm(np.cross(along, wanted))) < PARALLEL:
        if normal is not None:
            raise DataError(
                where, expected="a direction across the beam", got=repr(normal), fix="Axis 3 is across the beam."
            )
        wanted = np.array([1.0, 0.0, 0.0])  # of a beam along z
    second = np.cross(wanted, along)
    second /= np.linalg.norm(second)
    return np.stack([along, second, np.cross(along, second)], axis=1)


def _curvature(name: str, curvature: float | None, chord: float) -> float:
    if curvature is None:
        return 0.0
    where = f"Beam {name!r} curvature"
    curvature = require_real(where, curvature)
    if not (math.isfinite(curvature) and abs(curvature) * chord <= 2.0):
        raise DataError(
            where,
            expected=f"at most 2/chord = {2.0 / chord:.6g} 1/m in size",
            got=repr(curvature),
            fix="The circle must reach from start to end; split a longer arc into several beams.",
        )
    return curvature


def _arc_length(curvature: float, chord: float) -> float:
    half = 0.5 * abs(curvature) * chord
    return chord if half < 1e-12 else chord * math.asin(half) / half


def fractions_of(name: str, elements: int | ArrayLike) -> Floats:
    """Check element boundaries.

    Parameters
    ----------
    name : str
        Of the beam, for messages.
    elements : int or array_like
        Their number, or the boundaries as fractions of the length.

    Returns
    -------
    numpy.ndarray
        Shape (elements + 1,), from 0 to 1.

    Raises
    ------
    DataError
        If there are none or too many, or the fractions do not rise from 0 to 1.
    ArgumentTypeError
        If they are of the wrong kind.
    """
    where = f"Beam {name!r} elements"
    if isinstance(elements, (int, np.integer)) and not isinstance(elements, bool):
        if not 1 <= elements <= MOST_ELEMENTS:
            raise DataError(
                where,
                expected=f"at least 1 and at most {MOST_ELEMENTS}",
                got=repr(elements),
                fix="Start with 4 elements of degree 2.",
            )
        return np.linspace(0.0, 1.0, int(elements) + 1)
    fractions = real_array(elements)
    if fractions is None or fractions.ndim == 0:
        raise ArgumentTypeError(
            where,
            expected="a whole number or a sequence of fractions",
            got=repr(elements),
            fix="Give an int, or boundaries such as (0, 0.2, 1).",
        )
    if (
        fractions.ndim != 1
        or fractions.size < 2
        or fractions[0] != 0.0
        or fractions[-1] != 1.0
        or not (np.diff(fractions) > 0.0).all()
    ):
        raise DataError(
            where,
            expected="fractions that rise from 0 to 1",
            got=repr(elements),
            fix="Give element boundaries such as (0, 0.2, 1).",
        )
    return fractions
