"""Pieces of HTML; everything that comes from a user is escaped here."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Cell = str | float | int


def page(title: str, body: str) -> str:
    """Wrap a body into a page with style and scripts in it.

    Parameters
    ----------
    title : str
        In plain text.
    body : str
        HTML.

    Returns
    -------
    str
        The page.
    """
    own = files(__package__)
    style, script = (own.joinpath(name).read_text(encoding="utf-8") for name in ("page.css", "page.js"))
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        # nothing is loaded from anywhere, whatever names say
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
        "script-src 'unsafe-inline'; img-src data:\">\n"
        f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n{body}\n</main>\n"
        f"<script>\n{script}</script>\n</body>\n</html>\n"
    )


def player(scene: Mapping[str, Any], speed: float = 1.0) -> str:
    """Make the animation: a canvas, play and pause, a slider, and the data as JSON.

    Parameters
    ----------
    scene : mapping
        What :meth:`Scene.to_json` gave.
    speed : float, optional
        Seconds of the run in a second.

    Returns
    -------
    str
        HTML.
    """
    data = json.dumps({**scene, "speed": speed}, separators=(",", ":"), allow_nan=False)
    data = data.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
    last = len(scene["t"]) - 1
    return (
        '<div class="player" id="player">\n'
        '<canvas id="stage" width="960" height="540" aria-label="animation of the mechanism"></canvas>\n'
        '<div class="controls"><button type="button" id="play">Play</button>\n'
        f'<input type="range" id="time" min="0" max="{last}" value="0" step="1" aria-label="time">\n'
        '<output id="clock" for="time">t = 0 s</output>\n'
        '<label>speed <select id="speed"><option value="0.1">0.1</option><option value="0.25">0.25</option>'
        '<option value="1" selected>1</option><option value="4">4</option></select></label>\n'
        '<label><input type="checkbox" id="trails" checked> trails</label></div>\n'
        '<div id="legend" class="legend"></div>\n'
        f'<script type="application/json" id="scene">{data}</script>\n</div>'
    )


def table(columns: Sequence[str], rows: Iterable[Sequence[Cell]], name: str) -> str:
    """Make a table that sorts when a heading is clicked.

    Parameters
    ----------
    columns : sequence of str
        Headings, plain text.
    rows : iterable of sequence
        Texts, or numbers, which are shown to six digits and sorted by value.
    name : str
        Its id.

    Returns
    -------
    str
        HTML.
    """
    head = "".join(f'<th scope="col"><button type="button">{escape(c)}</button></th>' for c in columns)
    lines = []
    for row in rows:
        cells = "".join(
            f"<td>{escape(cell)}</td>"
            if isinstance(cell, str)
            else f'<td class="number" data-value="{cell!r}">{cell:.6g}</td>'
            for cell in (float(c) if isinstance(c, np.floating) else c for c in row)
        )
        lines.append(f"<tr>{cells}</tr>")
    body = "\n".join(lines)
    return (
        f'<div class="scroll"><table class="sortable" id="{name}">\n<thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{body}\n</tbody></table></div>"
    )


def section(title: str, name: str, body: str) -> str:
    """Wrap HTML into a section with a heading.

    Parameters
    ----------
    title : str
        In plain text.
    name : str
        Its id.
    body : str
        HTML.

    Returns
    -------
    str
        HTML.
    """
    return f'<section id="{name}">\n<h2>{escape(title)}</h2>\n{body}\n</section>'


def figure_svg(figure: Figure, name: str, alt: str) -> str:
    """Put a figure into a page: SVG with texts as texts, and ids of its own.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure; it is closed.
    name : str
        Put before every id.
    alt : str
        What it shows, in plain text.

    Returns
    -------
    str
        HTML.
    """
    import matplotlib.pyplot as plt

    text = io.StringIO()
    with plt.rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        figure.savefig(text, format="svg", bbox_inches="tight", metadata={"Date": None})
    plt.close(figure)
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"<!--.*?-->", "", svg, flags=re.DOTALL)  # they repeat texts
    for before, after in ((' id="', f' id="{name}-'), ("url(#", f"url(#{name}-"), ('href="#', f'href="#{name}-')):
        svg = svg.replace(before, after)
    svg = svg.replace("<svg ", f'<svg role="img" aria-label="{escape(alt)}" ', 1)
    return f'<figure class="drawing" id="{name}">\n{svg}</figure>'
