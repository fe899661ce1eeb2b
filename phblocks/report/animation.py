"""A run as a film: a page with a player of its own, a GIF, or an MP4."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING, Any

import numpy as np

from phblocks.blocks.block import BlockPoint
from phblocks.blocks.checks import require_positive
from phblocks.blocks.form import Profile
from phblocks.errors import ExportError
from phblocks.export.extras import require_extra
from phblocks.ports import Anchor
from phblocks.report.html import page, player
from phblocks.report.scene import NAMES, UNITS, Scene, make_scene
from phblocks.results.solution import Solution
from phblocks.triplets import Ints

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUFFIXES = (".html", ".gif", ".mp4")
#: Pictures in a page, and in a film.
PAGE_FRAMES, FILM_FRAMES = 400, 2000


def write_animation(
    solution: Solution,
    path: str | os.PathLike[str],
    *,
    colour: Profile | None = "moment",
    trails: Sequence[BlockPoint | Anchor] = (),
    speed: float = 1.0,
    fps: float = 25.0,
) -> Path:
    """Write a film of a run; beams are drawn as they bend, to scale.

    Parameters
    ----------
    solution : Solution
        Of the run.
    path : str or path-like
        By suffix ``.html`` (a page with play, pause and a slider, that needs nothing else), ``.gif``, or ``.mp4``
        (by ffmpeg: that of the machine, or of the extra ``film``).
    colour : {"moment", "energy"} or None, optional
        Colour of beams: bending moment, N m, or strain energy a length, J/m.
    trails : sequence of BlockPoint or Anchor, optional
        Points that leave a trail.
    speed : float, optional
        Seconds of the run in a second of the film.
    fps : float, optional
        Pictures a second. A page has at most 400 pictures, a film at most 2000.

    Returns
    -------
    pathlib.Path
        Where it is.

    Raises
    ------
    ExportError
        If the suffix is another.
    ExtraMissingError
        If there is no ffmpeg for an MP4.
    DataError
        If speed or fps is not positive, the colour unknown, or no block has an extension.
    ArgumentTypeError
        If a trail is not a point.
    """
    target = Path(path)
    if target.suffix not in SUFFIXES:
        raise ExportError(
            "animate path", expected=f"one of {', '.join(SUFFIXES)}", got=repr(str(path)), fix="Choose such a suffix."
        )
    speed, fps = require_positive("animate speed", speed), require_positive("animate fps", fps)
    most = PAGE_FRAMES if target.suffix == ".html" else FILM_FRAMES
    frames = nearest_frames(solution, 1 + round(float(solution.t[-1] - solution.t[0]) * fps / speed), most)
    scene = make_scene(solution, frames, colour, trails)
    if target.suffix == ".html":
        target.write_text(page(scene.name, player(scene.to_json(), speed)), encoding="utf-8")
    else:
        _write_film(scene, target, fps)
    return target


def nearest_frames(solution: Solution, wanted: int, most: int) -> Ints:
    """Choose saved times, evenly over the run.

    Parameters
    ----------
    solution : Solution
        Of the run.
    wanted, most : int
        How many pictures, and how many at most.

    Returns
    -------
    numpy.ndarray
        Numbers of saved times, first and last among them; the same may be there several times.
    """
    times = np.linspace(solution.t[0], solution.t[-1], max(2, min(wanted, most)))
    after = np.clip(np.searchsorted(solution.t, times), 1, max(solution.t.size - 1, 1))
    before = after - 1
    after = np.minimum(after, solution.t.size - 1)
    return np.where(times - solution.t[before] < solution.t[after] - times, before, after).astype(np.int64)


def _write_film(scene: Scene, target: Path, fps: float) -> None:
    import matplotlib.pyplot as plt
    from matplotlib import animation

    mp4 = target.suffix == ".mp4"
    kind: Any = animation.FFMpegWriter if mp4 else animation.PillowWriter
    with plt.rc_context({"animation.ffmpeg_path": _ffmpeg() if mp4 else "ffmpeg"}):
        writer, (figure, update) = kind(fps=fps), draw_scene(scene)
        with writer.saving(figure, str(target), 90):
            for frame in range(scene.t.size):
                update(frame)
                writer.grab_frame()
    plt.close(figure)


def _ffmpeg() -> str:
    """The program of the machine, else that of the extra."""
    return which("ffmpeg") or str(require_extra("imageio_ffmpeg", "film", "animate to .mp4").get_ffmpeg_exe())


def draw_scene(scene: Scene) -> tuple[Figure, Any]:
    """Draw a scene with Matplotlib.

    Parameters
    ----------
    scene : Scene
        What to draw.

    Returns
    -------
    figure : matplotlib.figure.Figure
        With x and y in m, at equal scale.
    update : callable
        Shows the frame of a number.
    """
    import matplotlib.pyplot as plt
    from matplotlib.collections import LineCollection

    low, high = scene.bounds
    width, height = high - low
    figure, ax = plt.subplots(figsize=(7.0, min(7.0, max(3.0, 6.0 * height / width + 0.8))), layout="constrained")
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x (m)", ylabel="y (m)")
    ax.grid(alpha=0.3)
    signed = scene.colour == "moment"
    largest = scene.largest or 1.0
    lines = []
    for line in scene.lines:
        coloured = line.values is not None
        lines.append(
            LineCollection(
                [],
                linewidths=3.0 if coloured else 10.0 if line.dot else 1.2,
                capstyle="round",
                label=line.name,
                zorder=2,
            )
        )
        if coloured:
            lines[-1].set(cmap="coolwarm" if signed else "viridis", clim=(-largest if signed else 0.0, largest))
        else:
            lines[-1].set_color("0.35")
        ax.add_collection(lines[-1], autolim=False)
    shaded = [c for c, line in zip(lines, scene.lines, strict=True) if line.values is not None]
    if shaded and scene.colour is not None:
        figure.colorbar(shaded[0], ax=ax, label=f"{NAMES[scene.colour]} ({UNITS[scene.colour]})", shrink=0.8)
    trails = [ax.plot([], [], linewidth=0.9, alpha=0.8, label=f"trail of {name}")[0] for name in scene.trails]
    (joints,) = ax.plot([], [], "o", color="black", markersize=4, zorder=4)
    if scene.fixed.size:
        ax.plot(*scene.fixed.T, "^", color="black", markersize=9, zorder=3, label="ground")
    title = ax.set_title("", parse_math=False)

    def update(frame: int) -> None:
        for collection, line in zip(lines, scene.lines, strict=True):
            p = line.places[frame]
            collection.set_segments(np.stack([p[:-1], p[1:]], axis=1))  # type: ignore[arg-type]
            if line.values is not None:
                collection.set_array(0.5 * (line.values[frame][:-1] + line.values[frame][1:]))
        for drawn, path in zip(trails, scene.trails.values(), strict=True):
            drawn.set_data(*path[: frame + 1].T)
        joints.set_data(*scene.joints[frame].T)
        title.set_text(f"{scene.name}, t = {scene.t[frame]:.3f} s")

    update(0)
    return figure, update
