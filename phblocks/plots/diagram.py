"""A diagram on paper: blocks, junctions, and who gives what."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import cycle, pairwise
from typing import TYPE_CHECKING

import networkx as nx
import numpy as np

from phblocks.blocks.block import Block
from phblocks.causality import CausalityReport
from phblocks.diagram import Diagram
from phblocks.errors import ArgumentTypeError, ExportError
from phblocks.network import Junction
from phblocks.plots.placement import SHEET, place_nodes
from phblocks.ports import ROTATION, TRANSLATION, Domain, Exposure, Port
from phblocks.triplets import Floats

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

# sizes in inch and point, at full size
FONT, SMALL = 9.0, 7.0
LETTER = 0.085
BOX_HEIGHT = 0.34
DOT, MARK = 0.14, 4.5

SUFFIXES = (".svg", ".png")
CONFLICT, REPAIR = "tab:red", "tab:green"
#: Repairs written below a diagram that is not causal, and letters in a line of them.
REPAIRS, COLUMNS = 2, 84

Node = Hashable


def diagram(
    diagram: Diagram | CausalityReport, *, path: str | os.PathLike[str] | None = None, ax: Axes | None = None
) -> Axes:
    """Draw blocks, junctions, and which side of every connection gives the velocity.

    Boxes are blocks, dots are junctions, lines are ports, named by their place on the block and in the colour of
    their domain. The common quantity (velocity) goes along the arrows, the summed one (force) against them; the square
    where a line meets its block is full if the block gives the common quantity. A junction is red, and says why, if
    not exactly one arrow goes into it, or if the outside cannot act there; the cheapest repairs stand below, and the
    blocks that the first one changes have a green frame. Ports that nobody joined are left out, unless they are a
    conflict. Long and narrow diagrams are folded into rows.

    Parameters
    ----------
    diagram : Diagram or CausalityReport
        The diagram, or what :meth:`phblocks.Diagram.check` said of it.
    path : str or path-like, optional
        Where to write the figure: by suffix ``.svg`` or ``.png`` (200 dots an inch).
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure of fitting size by default.

    Returns
    -------
    matplotlib.axes.Axes
        Without coordinates; the legend names the quantities of each domain with their units.

    Raises
    ------
    ArgumentTypeError
        If it is neither a diagram nor a report.
    ExportError
        If the path has another suffix.
    """
    if isinstance(diagram, Diagram):
        report, title = diagram.check(), diagram.name
    elif isinstance(diagram, CausalityReport):
        report, title = diagram, ""
    else:
        raise ArgumentTypeError(
            "plots.diagram", expected="a Diagram or a CausalityReport", got=repr(diagram), fix="Make a ph.Diagram."
        )
    if path is not None and os.path.splitext(path)[1] not in SUFFIXES:
        raise ExportError(
            "plots.diagram path", expected=" or ".join(SUFFIXES), got=repr(str(path)), fix="Choose such a suffix."
        )
    sheet = _lay_out(report)
    handles = _handles(sheet, report)
    scale, ax = _prepare(sheet, ax, sum(1 + str(h.get_label()).count("\n") for h in handles))
    for line in sheet.lines:
        _draw_line(ax, sheet, line, scale)
    mended = _mended(report)
    for node, block in sheet.blocks.items():
        _draw_block(ax, sheet, node, block, scale, block.name in mended)
    for node, junction in sheet.junctions.items():
        _draw_junction(ax, sheet, node, junction, scale)
    for node, exposure in sheet.outside.items():
        x, y = sheet.places[node]
        ax.text(x, y, exposure.name, ha="center", va="center", fontsize=FONT * scale, style="italic", parse_math=False)
    _label(ax, handles, report, title)
    figure = ax.get_figure(root=True)
    if path is not None and figure is not None:
        figure.savefig(path, dpi=200, bbox_inches="tight")
    return ax


@dataclass(frozen=True)
class _Line:
    """A port or an opening to the outside: from node to junction, along the arrow or against it."""

    node: Node
    junction: Node
    gives: bool
    domain: Domain
    conflict: bool
    label: str = ""


@dataclass
class _Sheet:
    """What is drawn, and where (inch)."""

    blocks: dict[Node, Block] = field(default_factory=dict)
    junctions: dict[Node, Junction] = field(default_factory=dict)
    outside: dict[Node, Exposure] = field(default_factory=dict)
    lines: list[_Line] = field(default_factory=list)
    wrong: dict[Node, str] = field(default_factory=dict)
    sizes: dict[Node, tuple[float, float]] = field(default_factory=dict)
    places: dict[Node, Floats] = field(default_factory=dict)

    @property
    def colours(self) -> Mapping[str, str]:
        """Colour of each domain, by name."""
        others = {line.domain.name for line in self.lines} - {TRANSLATION.name, ROTATION.name}
        colours = {TRANSLATION.name: "tab:blue", ROTATION.name: "tab:orange"}
        palette = cycle(("tab:green", "tab:purple", "tab:brown", "tab:olive"))
        return colours | {name: next(palette) for name in sorted(others)}


def _lay_out(report: CausalityReport) -> _Sheet:
    sheet = _Sheet()
    gives = {a.port: a.gives for a in report.assignments}
    conflicts = {c.junction.ports for c in report.conflicts}
    junctions = {a.junction.ports: a.junction for a in report.assignments if not a.port.block.shared}
    junctions |= {c.junction.ports: c.junction for c in report.conflicts}
    for a in report.assignments:
        if not a.port.block.shared:
            _add(sheet, a.port.block.name, a.port.block)
    where: Node
    for number, (ports, junction) in enumerate(junctions.items()):
        if len(ports) + len(junction.exposures) < 2 and ports not in conflicts:
            continue
        node = ("junction", number)
        sheet.junctions[node], sheet.sizes[node] = junction, (DOT, DOT)
        if ports in conflicts:  # what is wrong is written above the dot
            givers = sum(gives[p] for p in ports) + sum(e.gives for e in junction.exposures)
            sheet.wrong[node] = _reason(givers, junction)
            sheet.sizes[node] = (0.85 * LETTER * len(sheet.wrong[node]) + 0.1, 0.56)
        sources = {e.port: e for e in junction.exposures if e.name in _brought(e.port.block)}
        for port in ports:
            where = _block_node(port, ports)
            _add(sheet, where, port.block)
            label = "" if port.block.shared or port in sources else port.anchor.name if port.anchor else port.name
            given = sources[port].gives if port in sources else gives[port]  # a source is the outside
            sheet.lines.append(_Line(where, node, given, port.domain, ports in conflicts, label))
        for exposure in (e for e in junction.exposures if e.port not in sources):
            where = ("outside", exposure.name)
            sheet.outside[where], sheet.sizes[where] = exposure, (LETTER * len(exposure.name) + 0.1, 0.2)
            sheet.lines.append(_Line(where, node, exposure.gives, junction.domain, ports in conflicts))
    graph: nx.Graph[Node] = nx.Graph()
    graph.add_nodes_from(sheet.sizes)
    for line in sheet.lines:
        gap = 0.3 + 0.8 * LETTER * len(line.label)
        written = (0.8 * LETTER * len(line.label) + 0.2, 0.16) if line.label else (0.25, 0.16)
        graph.add_edge(
            line.node, line.junction, length=0.5 * sheet.sizes[line.node][0] + gap, drawn=True, label=written
        )
    grounds = [node for node, block in sheet.blocks.items() if block.shared]
    for first, second in pairwise(grounds):  # it is one body: keep its symbols near each other
        graph.add_edge(first, second, length=1.0, drawn=False)
    sheet.places = place_nodes(graph, sheet.sizes, _start(sheet))
    return sheet


def _brought(block: Block) -> set[str]:
    """Names of the openings that a block brings along: it is the outside."""
    return {exposure.name for exposure in block.exposures()}


def _block_node(port: Port, ports: tuple[Port, ...]) -> Node:
    """A block is one node; the ground, which is everywhere, one for each set of anchors attached to it."""
    if not port.block.shared:
        return port.block.name
    return (port.block.name, frozenset(p.anchor or p for p in ports if p is not port))


def _add(sheet: _Sheet, node: Node, block: Block) -> None:
    sheet.blocks[node] = block
    sheet.sizes[node] = (0.3, 0.3) if block.shared else (LETTER * len(block.name) + 0.2, BOX_HEIGHT)


def _start(sheet: _Sheet) -> dict[Node, Floats] | None:
    """Places in the model, m, if all blocks have one."""
    start: dict[Node, Floats] = {}
    for node, block in sheet.blocks.items():
        positions = [a.position[:2] for a in block.anchors.values() if a.position is not None]
        if positions:
            start[node] = np.mean(positions, axis=0)
        elif not block.shared:
            return None
    for node, junction in sheet.junctions.items():
        anchors = [p.anchor for p in junction.ports if p.anchor is not None]
        placed = [a.position[:2] for a in anchors if a.position is not None]
        if not placed:
            return None
        start[node] = placed[0]
    lengths = [np.linalg.norm(start[line.node] - start[line.junction]) for line in sheet.lines if line.node in start]
    below = float(np.median(lengths)) if lengths else 0.0
    for line in sheet.lines:
        start.setdefault(line.node, start[line.junction] - (0.0, below or 1.0))
    return start


def _prepare(sheet: _Sheet, ax: Axes | None, below: int) -> tuple[float, Axes]:
    """Set the limits of the axes, and find by how much to scale fonts and lines; so many lines stand below them."""
    places = np.array([sheet.places[node] for node in sheet.sizes] or [np.zeros(2)])
    half = 0.5 * np.array(list(sheet.sizes.values()) or [(1.0, 1.0)])
    low, high = (places - half).min(axis=0) - 0.3, (places + half).max(axis=0) + 0.3
    width, height = high - low
    if ax is None:
        import matplotlib.pyplot as plt

        scale = min(1.0, SHEET[0] / width, SHEET[1] / height)
        room = 0.4, 0.2 + 0.17 * below  # for the title, and the legend
        size = max(5.5, scale * width), scale * height + sum(room)
        ax = plt.figure(figsize=size).add_axes((0.0, room[1] / size[1], 1.0, scale * height / size[1]))
    else:
        extent, dpi = ax.get_window_extent(), ax.figure.dpi
        scale = min(extent.width / dpi / width, extent.height / dpi / height)
    ax.set_axis_off()
    ax.set_aspect("equal")
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    return min(scale, 1.3), ax


def _border(sheet: _Sheet, node: Node, towards: Node) -> Floats:
    """Where the line between the middles of two nodes leaves the first."""
    direction = sheet.places[towards] - sheet.places[node]
    half = 0.5 * np.array(sheet.sizes[node])
    if node in sheet.junctions:
        return np.asarray(sheet.places[node] + 0.5 * DOT * direction / np.linalg.norm(direction))
    if node in sheet.blocks and sheet.blocks[node].shared:
        return sheet.places[node]
    return np.asarray(sheet.places[node] + direction * min(half / np.maximum(np.abs(direction), 1e-9)))


def _draw_line(ax: Axes, sheet: _Sheet, line: _Line, scale: float) -> None:
    ends = _border(sheet, line.node, line.junction), _border(sheet, line.junction, line.node)
    tail, head = ends if line.gives else ends[::-1]
    colour = CONFLICT if line.conflict else sheet.colours[line.domain.name]
    arrow = {
        "arrowstyle": "-|>",
        "mutation_scale": 11.0 * scale,
        "color": colour,
        "linewidth": 1.3 * scale,
        "shrinkA": 0.0,
        "shrinkB": 0.0,
    }
    ax.annotate("", xy=(head[0], head[1]), xytext=(tail[0], tail[1]), arrowprops=arrow)
    if line.node in sheet.blocks:
        face, label = (colour, "_gives") if line.gives else ("white", "_takes")
        marks = ax.plot(*ends[0], marker="s", markersize=MARK * scale, color=colour, markerfacecolor=face, label=label)
        marks[0].set_zorder(3 if not sheet.blocks[line.node].shared else 1)
    if line.label:
        x, y = 0.5 * (ends[0] + ends[1])
        behind = {"facecolor": "white", "edgecolor": "none", "pad": 0.8 * scale}
        text = ax.text(x, y, line.label, ha="center", va="center", color=colour, bbox=behind, parse_math=False)
        text.set(fontsize=SMALL * scale, zorder=4)  # above all arrows


def _draw_block(ax: Axes, sheet: _Sheet, node: Node, block: Block, scale: float, mended: bool) -> None:
    from matplotlib.patches import Rectangle

    (x, y), (width, height) = sheet.places[node], sheet.sizes[node]
    if block.shared:
        _draw_ground(ax, sheet, node, scale)
        return
    ax.add_patch(
        Rectangle(
            (x - 0.5 * width, y - 0.5 * height),
            width,
            height,
            facecolor="0.95",
            edgecolor=REPAIR if mended else "black",
            linewidth=(2.4 if mended else 1.2) * scale,
            label=block.name,
        )
    )
    ax.text(x, y, block.name, ha="center", va="center", fontsize=FONT * scale, parse_math=False)


def _draw_ground(ax: Axes, sheet: _Sheet, node: Node, scale: float) -> None:
    """A bar across the direction from which it is attached, hatched behind."""
    middle = sheet.places[node]
    towards = np.sum([sheet.places[line.junction] - middle for line in sheet.lines if line.node == node], axis=0)
    normal = towards / (np.linalg.norm(towards) or 1.0)
    along = np.array([normal[1], -normal[0]])
    strokes = [(middle - 0.18 * along, middle + 0.18 * along)]
    strokes += [(middle + k * along, middle + (k - 0.08) * along - 0.1 * normal) for k in np.linspace(-0.1, 0.18, 5)]
    for i, (a, b) in enumerate(strokes):
        ax.plot(
            [a[0], b[0]],
            [a[1], b[1]],
            color="black",
            linewidth=(1.8 if i == 0 else 0.8) * scale,
            label="ground" if i == 0 else "_hatch",
        )


def _draw_junction(ax: Axes, sheet: _Sheet, node: Node, junction: Junction, scale: float) -> None:
    reason = sheet.wrong.get(node, "")
    colour = CONFLICT if reason else sheet.colours[junction.domain.name]
    x, y = sheet.places[node]
    ax.plot(
        x,
        y,
        marker="o",
        markersize=(10.0 if reason else 7.0) * scale,
        markerfacecolor=colour if reason else "white",
        markeredgecolor=colour,
        markeredgewidth=1.5 * scale,
        linestyle="none",
        label="_junction",
    )
    if reason:
        text = ax.text(x, y + 0.12, reason, ha="center", va="bottom", fontsize=SMALL * scale, color=CONFLICT, zorder=4)
        text.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.8 * scale})


def _reason(givers: int, junction: Junction) -> str:
    common = junction.domain.common.name
    return {0: f"nobody gives {common}", 1: "held: the outside cannot act"}.get(givers, f"{givers} give {common}")


def _handles(sheet: _Sheet, report: CausalityReport) -> list[Artist]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Artist] = [
        Line2D(
            [],
            [],
            color=sheet.colours[domain.name],
            label=f"{domain.name}: {domain.common.name} ({domain.common.unit}) along the arrow, "
            f"{domain.summed.name} ({domain.summed.unit}) against it",
        )
        for domain in dict.fromkeys(line.domain for line in sheet.lines)
    ]
    if report.conflicts:
        handles.append(Line2D([], [], color=CONFLICT, marker="o", label="conflict"))
    for number, repair in enumerate(report.repairs[:REPAIRS], start=1):
        text = textwrap.fill(f"repair {number}: {repair.what}", COLUMNS, subsequent_indent="    ")
        handles.append(Patch(facecolor="none", edgecolor=REPAIR if number == 1 else "none", label=text))
    return handles


def _label(ax: Axes, handles: Sequence[Artist], report: CausalityReport, title: str) -> None:
    if report.conflicts:
        title = f"{title}: not causal" if title else "not causal"
    if handles:
        legend = ax.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0.0), frameon=False, fontsize=8)
        for text in legend.get_texts():
            text.set_parse_math(False)
    ax.set_title(title, color=CONFLICT if report.conflicts else "black", parse_math=False)


def _mended(report: CausalityReport) -> frozenset[str]:
    """Names of the blocks that the cheapest repair changes, or joins in another way."""
    if not report.repairs:
        return frozenset()
    before, after = report.network, report.repairs[0].change(report.network)
    changed = {name for name, block in before.blocks.items() if after.blocks.get(name) is not block}
    kept = {frozenset(port.path for port in junction.ports) for junction in after.joined}
    for junction in before.joined:
        if frozenset(port.path for port in junction.ports) not in kept:
            changed |= {port.block.name for port in junction.ports}
    opened = {exposure.name for exposure in after.exposures()}
    return frozenset(changed | {e.port.block.name for e in before.exposures() if e.name not in opened})
