"""Snapshots of a mechanism and the paths of its points."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from phblocks.blocks.block import BlockPoint
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.ports import Anchor
from phblocks.results.attitudes import require_frames
from phblocks.results.solution import Solution
from phblocks.triplets import Floats, Ints

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Snapshots, if no times are given.
SNAPSHOTS = 6
#: Of paths; snapshots run from violet to green.
PATH_COLOURS = ("tab:red", "tab:orange", "tab:pink", "tab:brown")

Point = BlockPoint | Anchor


def motion(
    solution: Solution,
    times: ArrayLike | None = None,
    path: Point | Sequence[Point] | None = None,
    *,
    ax: Axes | None = None,
) -> Axes:
    """Draw a mechanism at several times, through the bent shapes of its parts.

    Parameters
    ----------
    solution : Solution
        Of a run.
    times : array_like, optional
        When, shape (n,), s; the nearest saved times are drawn. Six, evenly over the run, by default.
    path : BlockPoint, Anchor or sequence of them, optional
        Points whose paths over the whole run are drawn, such as ``beam.at(0.5)`` or ``beam.end``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        Coordinates x and y in m, at equal scale (what is in space is seen along z): the initial configuration dashed,
        one line for each time (with gaps between the blocks), one for each path, triangles where the mechanism is
        joined to the ground.

    Raises
    ------
    DataError
        If a time is outside the run, or no block of the system has an extension.
    OrientationError
        If a block turns in space: where it is then is not computed yet.
    ArgumentTypeError
        If it is not a solution, or a path not a point.
    """
    if not isinstance(solution, Solution):
        raise ArgumentTypeError(
            "plots.motion", expected="a Solution", got=type(solution).__name__, fix="Call ph.simulate() first."
        )
    points = _points(path)
    snapshots = _nearest(solution.t, times)
    shown = np.concatenate([[0], snapshots])
    at_those = solution.sliced(shown)
    shapes, joints = _shapes(at_those), _joints(at_those)
    if ax is None:
        import matplotlib.pyplot as plt

        _, ax = plt.subplots(figsize=(7.0, 5.0), layout="compressed")
    from matplotlib import colormaps

    for point, colour in zip(points, cycle(PATH_COLOURS), strict=False):
        where = solution.position(point)
        ax.plot(where[:, 0], where[:, 1], color=colour, linewidth=0.9, label=f"path of {_name(point)}")
    ax.plot(shapes[0, :, 0], shapes[0, :, 1], color="black", linestyle="--", linewidth=1.2, label="start")
    colours = colormaps["viridis"](np.linspace(0.0, 0.9, snapshots.size))
    for k, (i, colour) in enumerate(zip(snapshots, colours, strict=True), start=1):
        ax.plot(shapes[k, :, 0], shapes[k, :, 1], color=colour, linewidth=1.8, label=f"t = {solution.t[i]:.4g} s")
        if joints.size:
            ax.plot(joints[k, :, 0], joints[k, :, 1], color=colour, linestyle="none", marker="o", markersize=3.5)
    fixed = np.array([site.start for site in solution.system.sites if site.known and not site.inputs])
    if fixed.size:
        ax.plot(
            fixed[:, 0],
            fixed[:, 1],
            color="black",
            linestyle="none",
            marker="^",
            markersize=9,
            zorder=3,
            label="ground",
        )
    ax.set_aspect("equal")
    ax.set_xlabel("x (m)")
    ax.set_ylabel("y (m)")
    ax.grid(alpha=0.3)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return ax


def _points(path: Point | Sequence[Point] | None) -> Sequence[Point]:
    points = [] if path is None else [path] if isinstance(path, (BlockPoint, Anchor)) else path
    for point in points if isinstance(points, Sequence) else [points]:
        if not isinstance(point, (BlockPoint, Anchor)):
            raise ArgumentTypeError(
                "plots.motion path",
                expected="points such as beam.at(0.5) or beam.end",
                got=repr(point),
                fix="Say where on the block.",
            )
    return points


def _name(point: Point) -> str:
    return point.path if isinstance(point, Anchor) else f"{point.block.name} at {point.place}"


def _nearest(t: Floats, times: ArrayLike | None) -> Ints:
    """Numbers of the saved times nearest to those asked for."""
    if times is None:
        wanted = np.linspace(t[0], t[-1], SNAPSHOTS + 1)[1:]
    else:
        try:
            wanted = np.atleast_1d(np.asarray(times, dtype=np.float64)).ravel()
        except (TypeError, ValueError):
            raise ArgumentTypeError(
                "plots.motion times", expected="times in s", got=repr(times), fix="Give numbers."
            ) from None
    slack = 1e-9 * (t[-1] - t[0])
    if not ((wanted >= t[0] - slack) & (wanted <= t[-1] + slack)).all():
        raise DataError(
            "plots.motion times",
            expected=f"times from {t[0]:g} s to {t[-1]:g} s",
            got=repr(times),
            fix="Ask for times within the run.",
        )
    return np.asarray(np.abs(t - wanted[:, None]).argmin(axis=1), dtype=np.int64)


def _shapes(solution: Solution) -> Floats:
    """Places along all blocks, with NaN between blocks, shape (times, places, dimension)."""
    lines = []
    for part in solution.system.parts:
        require_frames([part], "picture")
        if part.form.points is not None:
            lines += [solution.position(part.name, s) for s in part.form.outline()]
            lines.append(np.full_like(lines[-1], np.nan))
    if not lines:
        raise DataError(
            "plots.motion", expected="a block with an extension, such as a beam", got="none", fix="Plot the states."
        )
    return np.stack(lines, axis=1)


def _joints(solution: Solution) -> Floats:
    """Where anchors are joined, shape (times, joints, dimension)."""
    spots = [solution.position(*site.places[0]) for site in solution.system.sites if site.places]
    return np.stack(spots, axis=1) if spots else np.empty((solution.t.size, 0, 2))
