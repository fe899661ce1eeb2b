"""Who feeds whom, as arrows as broad as the power."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import networkx as nx
import numpy as np

from phblocks.errors import DataError
from phblocks.plots.arguments import require_solution
from phblocks.plots.placement import SHEET, place_nodes
from phblocks.results.flows import Flow, Node, flows_of
from phblocks.results.solution import Solution
from phblocks.triplets import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FONT, SMALL = 9.0, 7.0
LETTER, LINE = 0.085, 0.16
#: Width of the strongest arrow, points, and the share of it below which a flow is left out.
BROADEST, WEAKEST = 9.0, 1e-6
#: Rows of the ledger that are written into a block.
ROWS = ("stored", "gravity", "dissipated", "numerical_loss", "projected")

Statistic = Literal["mean", "peak"]


def power_flow(solution: Solution, statistic: Statistic = "mean", *, ax: Axes | None = None) -> Axes:
    """Draw the power that passes between blocks, and between them and the outside.

    Parameters
    ----------
    solution : Solution
        Of a run; the numbers are those of ``solution.power``.
    statistic : {"mean", "peak"}, optional
        The mean over the run, or the largest mean over one interval between saved times, with the sign it has there.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        Without coordinates. Arrows, as broad as the power, go where it goes, with the number in W; boxes are blocks, in
        which stands how their stored energy and that of gravity rise, what they lose, to the time method too, and what
        closing loops added: mean powers in and out of a block add up to these. Openings to the outside are in italics.
        What is below 1e-6 of the strongest is left out.

    Raises
    ------
    DataError
        If the statistic is another, or the run has no length.
    ArgumentTypeError
        If it is not a solution.
    """
    require_solution("plots.power_flow", solution)
    if statistic not in ("mean", "peak"):
        raise DataError(
            "plots.power_flow statistic", expected='"mean" or "peak"', got=repr(statistic), fix="Choose one of them."
        )
    if solution.t.size < 2:
        raise DataError(
            "plots.power_flow", expected="two saved times or more", got=str(solution.t.size), fix="Simulate longer."
        )
    flows = [(flow, power_of(flow.energy, solution.t, statistic)) for flow in flows_of(solution)]
    strongest = max((abs(power) for _, power in flows), default=0.0)
    flows = [(flow, power) for flow, power in flows if abs(power) > WEAKEST * strongest]
    texts = _texts(solution, flows, statistic)
    sizes = {node: (LETTER * max(map(len, lines)) + 0.2, LINE * len(lines) + 0.18) for node, lines in texts.items()}
    graph: nx.Graph[object] = nx.Graph()
    graph.add_nodes_from(texts)
    for flow, _ in flows:
        length = 0.5 * (sizes[flow.source][0] + sizes[flow.target][0]) + 0.9
        graph.add_edge(flow.source, flow.target, length=length, drawn=True, label=(0.7, 0.18))
    places = place_nodes(graph, sizes, None)
    ax, scale = _prepare(places, sizes, ax)
    for flow, power in flows:
        _draw_flow(ax, flow, power, strongest, places, sizes, scale)
    for node, lines in texts.items():
        _draw_node(ax, node, lines, places[node], sizes[node], scale)
    what = "mean" if statistic == "mean" else "peak"
    ax.set_title(f"{solution.system.name}: {what} power, 0 to {solution.t[-1]:.4g} s", parse_math=False)
    return ax


def power_of(energy: Floats, t: Floats, statistic: Statistic) -> float:
    """Reduce an energy over time to one power.

    Parameters
    ----------
    energy : numpy.ndarray
        Since the start, shape (times,), J.
    t : numpy.ndarray
        Shape (times,), s.
    statistic : {"mean", "peak"}
        See :func:`power_flow`.

    Returns
    -------
    float
        W.
    """
    if statistic == "mean":
        return float((energy[-1] - energy[0]) / (t[-1] - t[0]))
    powers = np.diff(energy) / np.diff(t)
    return float(powers[np.abs(powers).argmax()])


def _texts(solution: Solution, flows: list[tuple[Flow, float]], statistic: Statistic) -> dict[object, list[str]]:
    """What is written at each node; blocks where nothing happens are left out."""
    texts: dict[object, list[str]] = {}
    for name, row in solution.power.blocks.items():
        powers = {key: power_of(row[key], solution.t, statistic) for key in ROWS}
        lines = [f"{key.replace('_', ' ')} {power:+.3g} W" for key, power in powers.items() if power]
        node = Node("block", name)
        if lines or any(node in (flow.source, flow.target) for flow, _ in flows):
            texts[node] = [name, *lines]
    for flow, _ in flows:
        for node in (flow.source, flow.target):
            texts.setdefault(node, [node.name])
    return texts


def _prepare(
    places: dict[object, Floats], sizes: dict[object, tuple[float, float]], ax: Axes | None
) -> tuple[Axes, float]:
    middles = np.array([places[node] for node in sizes] or [np.zeros(2)])
    half = 0.5 * np.array(list(sizes.values()) or [(1.0, 1.0)])
    low, high = (middles - half).min(axis=0) - 0.25, (middles + half).max(axis=0) + 0.25
    width, height = high - low
    if ax is None:
        import matplotlib.pyplot as plt

        scale = min(1.0, SHEET[0] / width, SHEET[1] / height)
        size = max(4.5, scale * width), scale * height + 0.4
        ax = plt.figure(figsize=size).add_axes((0.0, 0.0, 1.0, scale * height / size[1]))
    else:
        extent, dpi = ax.get_window_extent(), ax.figure.dpi
        scale = min(extent.width / dpi / width, extent.height / dpi / height, 1.3)
    ax.set_axis_off()
    ax.set_aspect("equal")
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    return ax, float(scale)


def _draw_flow(
    ax: Axes,
    flow: Flow,
    power: float,
    strongest: float,
    places: dict[object, Floats],
    sizes: dict[object, tuple[float, float]],
    scale: float,
) -> None:
    tail, head = (flow.source, flow.target) if power > 0.0 else (flow.target, flow.source)
    along = places[head] - places[tail]
    reach = [min(0.5 * np.array(sizes[node]) / np.maximum(np.abs(along), 1e-9)) for node in (tail, head)]
    a, b = places[tail] + reach[0] * along, places[head] - reach[1] * along
    width = (0.8 + (BROADEST - 0.8) * abs(power) / strongest) * scale
    arrow = {
        "arrowstyle": "simple,head_width=2.0,head_length=2.0,tail_width=0.8" if width > 3.0 * scale else "-|>",
        "mutation_scale": width if width > 3.0 * scale else 9.0 * scale,
        "linewidth": 0.0 if width > 3.0 * scale else width,
        "color": "tab:orange",
        "shrinkA": 0.0,
        "shrinkB": 0.0,
    }
    ax.annotate("", xy=(b[0], b[1]), xytext=(a[0], a[1]), arrowprops=arrow)
    x, y = 0.5 * (a + b)
    text = ax.text(x, y, f"{abs(power):.3g} W", ha="center", va="center", fontsize=SMALL * scale, zorder=4)
    text.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.8 * scale, "alpha": 0.85})


def _draw_node(
    ax: Axes, node: object, lines: list[str], place: Floats, size: tuple[float, float], scale: float
) -> None:
    from matplotlib.patches import Rectangle

    assert isinstance(node, Node)
    if node.kind == "block":
        corner = (place[0] - 0.5 * size[0], place[1] - 0.5 * size[1])
        ax.add_patch(
            Rectangle(corner, *size, facecolor="0.95", edgecolor="black", linewidth=1.2 * scale, label=node.name)
        )
    for i, line in enumerate(lines):
        y = place[1] + LINE * (0.5 * (len(lines) - 1) - i)
        style = "italic" if node.kind != "block" else "normal"
        font = (FONT if i == 0 else SMALL) * scale
        ax.text(place[0], y, line, ha="center", va="center", fontsize=font, style=style, parse_math=False, zorder=5)
