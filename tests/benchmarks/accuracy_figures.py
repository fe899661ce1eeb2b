"""Error, energy error and gap against time, of this library and of peers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullLocator

from phblocks.studies.run import Run
from phblocks.studies.work_precision import WorkPrecisionStudy

COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:red", "tab:purple", "olive", "teal", "tab:pink")
MARKERS = {1: "o", 2: "s", 3: "D", 4: "^"}


def marker(row: Run) -> str:
    """By the degree of the elements; Exudyn's order is the degree of its shape functions."""
    mesh = row.mesh_arguments
    return MARKERS[mesh.get("degree", mesh.get("order", 1))]


def draw(
    result: WorkPrecisionStudy,
    title: str,
    path: Path,
    of_ours: Callable[[Run], bool],
    of_peer: Callable[[Run], bool],
) -> None:
    """Draw one scene: colours are methods, markers degrees, peers are grey and hollow; fronts are broad lines."""
    figure, axes = plt.subplot_mosaic(
        [["error", "energy_error"], ["error", "gap"]],
        figsize=(10.0, 5.6),
        width_ratios=(1.5, 1.0),
        sharex=True,
        layout="constrained",
    )
    rows = [row for row in result if row.ok]
    ours = list(dict.fromkeys(row.method for row in rows if of_ours(row)))
    peers = list(dict.fromkeys(row.method for row in rows if not of_ours(row)))
    colours = dict(zip(ours, COLOURS, strict=False))
    colours |= {name: "black" if name.startswith("Exudyn") else "tab:brown" for name in peers}
    bands = [(of_ours, "gold", "cheapest at each error, ours"), (of_peer, "silver", "the same, Exudyn")]
    for group, colour, _ in bands:
        front = result.filter(group).front
        axes["error"].plot(front.column("seconds"), front.column("error"), color=colour, linewidth=8.0, zorder=1)
    for method in (*ours, *peers):
        own = [row for row in rows if row.method == method]
        for mesh in dict.fromkeys(row.mesh for row in own):
            line = sorted((row for row in own if row.mesh == mesh), key=lambda row: (-row.dt, row.seconds))
            for name, ax in axes.items():
                shown = [row for row in line if getattr(row, name) > 0.0]
                if not shown:
                    continue
                ax.plot(
                    [row.seconds for row in shown],
                    [getattr(row, name) for row in shown],
                    color=colours[method],
                    marker=marker(shown[0]),
                    markersize=5.0,
                    linewidth=0.7,
                    alpha=0.8,
                    linestyle="--" if "modified" in method else "-",
                    markerfacecolor="white" if method in peers else None,
                    zorder=3,
                )
    for ax in axes.values():
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.grid(alpha=0.3)
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        ax.xaxis.set_minor_locator(NullLocator())
        ax.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    low, high = axes["error"].get_ylim()
    known = rows[0].reference_uncertainty if rows else 0.0
    if known > low:
        axes["error"].axhspan(low, known, color="black", alpha=0.08, linewidth=0.0)
        axes["error"].set_ylim(low, high)
    axes["error"].set(xlabel="wall time (s), one thread", ylabel="error (m); grey: uncertainty of the reference")
    axes["energy_error"].set_ylabel("energy error (relative)")
    axes["gap"].set(xlabel="wall time (s), one thread", ylabel="gap, strain to position (m)")
    axes["energy_error"].tick_params(labelbottom=False)
    handles = [Line2D([], [], color=colours[m], label=m, linestyle="--" if "modified" in m else "-") for m in colours]
    handles += [
        Line2D([], [], color="black", marker=m, linestyle="none", label=f"degree {degree}")
        for degree, m in MARKERS.items()
    ]
    handles += [Line2D([], [], color=colour, linewidth=8.0, label=label) for _, colour, label in bands]
    figure.legend(handles=handles, loc="outside upper center", ncols=4, frameon=False, fontsize="small")
    axes["error"].set_title(title, fontsize="medium")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=80)
    plt.close(figure)
