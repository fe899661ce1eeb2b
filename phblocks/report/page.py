"""One page about a run: drawing, causality, effects, motion, energies, health and cost."""

from __future__ import annotations

import os
from html import escape
from pathlib import Path

from phblocks.blocks.form import Profile
from phblocks.errors import ExportError
from phblocks.report.animation import PAGE_FRAMES, nearest_frames
from phblocks.report.html import page, player, section
from phblocks.report.scene import make_scene
from phblocks.report.sections import causality, cost, drawing, effects, energies, health
from phblocks.results.solution import Solution

#: Whole numbers of coordinates in the animation of a page, at most: some 5 characters each.
NUMBERS = 200_000


def write_report(solution: Solution, path: str | os.PathLike[str], *, colour: Profile | None = "moment") -> Path:
    """Write one page about a run that needs no network and no other file.

    Parameters
    ----------
    solution : Solution
        Of the run.
    path : str or path-like
        With suffix ``.html``.
    colour : {"moment", "energy"} or None, optional
        Colour of beams in the animation.

    Returns
    -------
    pathlib.Path
        Where it is. The page has the diagram, the causality table with reasons, effects kept and dropped (if the system
        knows them), an animation with play, pause and a slider, energies, power flow, health and cost; tables sort.
        Times are thinned out so that it stays small.

    Raises
    ------
    ExportError
        If the suffix is another.
    DataError
        If the colour is unknown.
    """
    target = Path(path)
    if target.suffix not in (".html", ".htm"):
        raise ExportError("report path", expected="a name that ends in .html", got=repr(str(path)), fix="Add it.")
    name = solution.system.name
    parts = [
        ("Diagram", "diagram", drawing(solution)),
        ("Motion", "motion", _motion(solution, colour)),
        ("Causality", "causality", causality(solution)),
        ("Effects kept and dropped", "effects", effects(solution)),
        ("Energies", "energies", energies(solution)),
        ("Health", "health", health(solution)),
        ("Cost", "cost", cost(solution)),
    ]
    parts = [part for part in parts if part[2]]
    links = "\n".join(f'<a href="#{key}">{escape(title)}</a>' for title, key, _ in parts)
    word = "ok" if solution.status.ok else "bad"
    head = (
        f"<h1>{escape(name)}</h1>\n<p>{solution.system.n} states, {solution.t.size} saved times to "
        f'{solution.t[-1]:g} s: <strong class="{word}">{escape(str(solution.status))}</strong></p>\n'
        f"<nav>\n{links}\n</nav>"
    )
    body = "\n".join([head, *(section(title, key, html) for title, key, html in parts)])
    target.write_text(page(name, body), encoding="utf-8")
    return target


def _motion(solution: Solution, colour: Profile | None) -> str:
    """The player, with as many pictures as keep the page small; nothing for a system that is nowhere in space."""
    places = sum(len(part.form.outline()) for part in solution.system.parts)
    most = max(20, min(PAGE_FRAMES, NUMBERS // (3 * max(places, 1))))
    frames = nearest_frames(solution, min(solution.t.size, most), most)
    if places == 0:
        return ""
    return player(make_scene(solution, frames, colour, None).to_json())
