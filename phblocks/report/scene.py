"""What moves in a picture of a run: lines through the deformed blocks, joints, trails, and their colours.

What is in space is seen along z.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from phblocks.blocks.block import BlockPoint
from phblocks.blocks.form import Profile
from phblocks.causality import CausalityReport
from phblocks.errors import ArgumentTypeError, DataError, UnknownNameError
from phblocks.ports import Anchor
from phblocks.results.attitudes import require_frames
from phblocks.results.kinematics import history_of
from phblocks.results.solution import Solution
from phblocks.system import Part
from phblocks.triplets import Floats, Ints

UNITS: Mapping[Profile, str] = {"moment": "N m", "energy": "J/m"}
NAMES: Mapping[Profile, str] = {"moment": "bending moment", "energy": "strain energy a length"}
#: Coordinates in a page are whole numbers up to this, over the larger side of the picture.
GRID = 20000


@dataclass(frozen=True)
class Line:
    """A line through a block.

    Parameters
    ----------
    name : str
        Of the block.
    places : numpy.ndarray
        Shape (frames, places, 2), m.
    values : numpy.ndarray or None
        Moment (N m) or energy density (J/m) there, shape (frames, places); ``None`` for a block that has none.
    """

    name: str
    places: Floats
    values: Floats | None

    @property
    def dot(self) -> bool:
        """Whether it is a point."""
        return not np.ptp(self.places, axis=1).any()


@dataclass(frozen=True)
class Scene:
    """All that a picture shows.

    Parameters
    ----------
    name : str
        Of the system.
    t : numpy.ndarray
        Time of each frame, shape (frames,), s.
    lines : tuple of Line
        Blocks.
    joints : numpy.ndarray
        Shape (frames, joints, 2), m.
    fixed : numpy.ndarray
        Joints with the ground, shape (n, 2), m.
    trails : mapping of str to numpy.ndarray
        Paths of points, shape (frames, 2), m.
    colour : {"moment", "energy"} or None
        What the values of lines are.
    """

    name: str
    t: Floats
    lines: tuple[Line, ...]
    joints: Floats
    fixed: Floats
    trails: Mapping[str, Floats]
    colour: Profile | None

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lowest and highest coordinates that are ever reached, each of shape (2,), m."""
        points = [line.places.reshape(-1, 2) for line in self.lines] + [self.joints.reshape(-1, 2), self.fixed]
        every = np.concatenate(points)
        low, high = every.min(axis=0), every.max(axis=0)
        edge = 0.05 * max(float((high - low).max()), 1e-9)
        return low - edge, high + edge

    @property
    def largest(self) -> float:
        """Largest absolute value of any line, N m or J/m; 0 if there are none."""
        return max((float(np.abs(line.values).max()) for line in self.lines if line.values is not None), default=0.0)

    def to_json(self) -> dict[str, Any]:
        """Round to whole numbers, for a page.

        Returns
        -------
        dict
            Coordinates in units of ``unit`` metres from ``low``, values in units of ``largest / 100``.
        """
        low, high = self.bounds
        unit = float((high - low).max()) / GRID
        largest = self.largest

        def whole(points: Floats) -> list[Any]:
            return list(np.rint((points - low) / unit).astype(np.int64).reshape(*points.shape[:-2], -1).tolist())

        return {
            "name": self.name,
            "t": [round(float(t), 9) for t in self.t],
            "low": low.tolist(),
            "unit": unit,
            "size": np.rint((high - low) / unit).astype(int).tolist(),
            "lines": [
                {
                    "name": line.name,
                    "dot": line.dot,
                    "places": whole(line.places),
                    "values": None
                    if line.values is None or not largest
                    else np.rint(100.0 * line.values / largest).astype(np.int64).tolist(),
                }
                for line in self.lines
            ],
            "joints": whole(self.joints),
            "fixed": whole(self.fixed),
            "trails": [{"name": name, "places": whole(path)} for name, path in self.trails.items()],
            "colour": None
            if self.colour is None
            else {"name": NAMES[self.colour], "unit": UNITS[self.colour], "largest": largest},
        }


def make_scene(
    solution: Solution,
    frames: Ints,
    colour: Profile | None = "moment",
    trails: Sequence[BlockPoint | Anchor] | None = (),
) -> Scene:
    """Read what is shown off a solution.

    Parameters
    ----------
    solution : Solution
        Of a run.
    frames : numpy.ndarray
        Numbers of the saved times that are shown.
    colour : {"moment", "energy"} or None, optional
        What beams are coloured by.
    trails : sequence of BlockPoint or Anchor or None, optional
        Points that leave a trail; ``None`` for the joints that move, at most six.

    Returns
    -------
    Scene
        In all frames.

    Raises
    ------
    DataError
        If the colour is unknown, or no block has an extension.
    ArgumentTypeError
        If a trail is not a point.
    OrientationError
        If a block turns in space: where it is then is not computed yet.
    """
    if colour is not None and colour not in UNITS:
        raise DataError("animation colour", expected='"moment", "energy" or None', got=repr(colour), fix="Choose one.")
    shown = solution.sliced(frames)
    lines = [line for part in shown.system.parts for line in _lines(shown, part, colour)]
    if not lines:
        raise DataError(
            "animation", expected="a block with an extension, such as a beam", got="none", fix="Plot the states."
        )
    sites = [site for site in shown.system.sites if site.places]
    spots = [shown.position(*site.places[0])[:, :2] for site in sites]
    fixed = [site.start[:2] for site in shown.system.sites if site.known and not site.inputs]
    if trails is None:
        paths = {s.name: p for s, p in zip(sites, spots, strict=True) if not s.known}
        paths = dict(list(paths.items())[:6])
    else:
        paths = {_name(point): shown.position(point)[:, :2] for point in trails}
    return Scene(
        name=solution.system.name,
        t=shown.t,
        lines=tuple(lines),
        joints=np.stack(spots, axis=1) if spots else np.empty((shown.t.size, 0, 2)),
        fixed=np.array(fixed, dtype=float).reshape(-1, 2),
        trails=paths,
        colour=colour,
    )


def _name(point: object) -> str:
    if isinstance(point, Anchor):
        return point.path
    if isinstance(point, BlockPoint):
        return f"{point.block.name} at {point.place}"
    raise ArgumentTypeError(
        "animation trails", expected="points such as beam.at(0.5) or beam.end", got=repr(point), fix="Give points."
    )


def _lines(solution: Solution, part: Part, colour: Profile | None) -> list[Line]:
    """A block with an outline is a line through it; one that acts along a line is that line."""
    require_frames([part], "picture")
    form, places = part.form, part.form.outline()
    if form.points is not None and places:
        history = history_of(solution.system, solution.recording, part)
        if len(places) == 1:  # a point: a line of no length, which round ends make a dot
            places = (*places, *places)
        values = None if colour is None else form.profile(history, colour, places)
        where = np.stack([solution.position(part.name, s)[:, :2] for s in places], axis=1)
        return [Line(part.name, where, values)]
    x = solution.system.sharing.of_block(solution.recording.x, part.states)
    found = []
    for line in form.lines:
        start = _partner(solution, part, line.start)
        if start is not None:
            found.append(Line(part.name, np.stack([start, start + x[:, line.span : line.span + 2]], axis=1), None))
    return found


def _partner(solution: Solution, part: Part, port: str) -> Floats | None:
    """Where what a port is joined to has gone; None if that is not known."""
    report = solution.system.report
    assert isinstance(report, CausalityReport)
    here = next(a for a in report.assignments if a.port is part.block.ports[port])
    for other in here.junction.ports:
        if other is here.port or other.anchor is None:
            continue
        if other.block.shared and here.port.anchor is not None and here.port.anchor.position is not None:
            return np.tile(here.port.anchor.position, (solution.t.size, 1))
        with suppress(UnknownNameError):
            return solution.position(other.anchor)
    return None
