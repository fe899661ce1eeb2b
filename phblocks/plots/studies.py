"""What accuracy costs, and how errors fall, on logarithmic axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.studies.convergence import ConvergenceStudy
from phblocks.studies.run import Run
from phblocks.studies.work_precision import WorkPrecisionStudy

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

MARKERS = "osD^vP*X"
#: Places of ticks in a decade, for axes of fewer decades than the number before.
TICKS = ((0.7, (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)), (2.0, (1.0, 2.0, 5.0)), (3.5, (1.0, 3.0)))


def work_precision(study: WorkPrecisionStudy) -> Figure:
    """Draw error, energy error and gap of a study against time.

    Parameters
    ----------
    study : WorkPrecisionStudy
        The runs. One line a method and mesh: methods by colour, meshes by marker and lightness, finer ones darker.

    Returns
    -------
    matplotlib.figure.Figure
        A new one with three axes: the error with the front (runs that no other beats in both error and time) drawn
        broad below the lines and the uncertainty of the reference in grey; the relative energy error; the gap between
        strain and configuration, m. Zeros and runs that failed are left out; the title counts the latter.

    Raises
    ------
    ArgumentTypeError
        If it is not such a study.
    DataError
        If no run reached its end.
    """
    if not isinstance(study, WorkPrecisionStudy):
        raise ArgumentTypeError(
            "plots.work_precision",
            expected="a WorkPrecisionStudy",
            got=type(study).__name__,
            fix="Call ph.studies.work_precision() first.",
        )
    rows = _require_runs("plots.work_precision", study.rows)
    import matplotlib.pyplot as plt
    from matplotlib.lines import Line2D

    figure, axes = plt.subplot_mosaic(
        [["error", "energy_error"], ["error", "gap"]],
        figsize=(9.6, 5.2),
        width_ratios=(1.5, 1.0),
        sharex=True,
        layout="constrained",
    )
    methods, meshes = list(dict.fromkeys(r.method for r in rows)), list(dict.fromkeys(r.mesh for r in rows))
    colours = dict(zip(methods, plt.rcParams["axes.prop_cycle"].by_key()["color"] * len(methods), strict=False))
    markers = dict(zip(meshes, MARKERS * len(meshes), strict=False))
    strengths = dict(zip(meshes, np.linspace(0.45, 1.0, len(meshes)) if len(meshes) > 1 else [1.0], strict=True))

    front = study.front
    axes["error"].plot(
        front.column("seconds"), front.column("error"), color="gold", linewidth=7.0, solid_capstyle="round", zorder=1
    )
    for method in methods:
        for mesh in meshes:
            chosen = study.filter(lambda row: row.ok, method=method, mesh=mesh).sort("dt", "rtol", reverse=True)
            for name, ax in axes.items():
                _line(ax, chosen.rows, name, colours[method], markers[mesh], float(strengths[mesh]))
    largest = max((row.reference_uncertainty for row in rows), default=math.nan)
    shaded = _shade(axes["error"], largest)
    first = rows[0]
    unit = f" ({first.unit})" if first.unit else ""
    axes["error"].set_ylabel(f"error of {first.quantity}{unit}")
    axes["energy_error"].set_ylabel("energy error (relative)")
    axes["gap"].set_ylabel("gap, strain to position (m)")
    axes["energy_error"].tick_params(labelbottom=False)
    for ax in axes.values():
        _mark(ax.yaxis)
    _mark(axes["error"].xaxis, plain=True)
    shared = any(row.shared_machine for row in rows)
    for name in ("error", "gap"):
        axes[name].set_xlabel("wall time of simulate (s)" + (", on a shared machine" if shared else ""))

    handles: list[Artist] = [Line2D([], [], color=colours[m], linewidth=2.0, label=m) for m in methods]
    if meshes != ["default"]:
        handles += [
            Line2D([], [], color="black", alpha=float(strengths[m]), marker=markers[m], linestyle="none", label=m)
            for m in meshes
        ]
    handles.append(Line2D([], [], color="gold", linewidth=7.0, label="cheapest at each error"))
    handles += shaded
    figure.legend(handles=handles, loc="outside upper center", ncols=min(len(handles), 3), frameon=False)
    failed = len(study.rows) - len(rows)
    if failed:
        axes["error"].set_title(f"{failed} of {len(study.rows)} runs failed and are not shown", fontsize="medium")
    return figure


def convergence(study: ConvergenceStudy, *, ax: Axes | None = None) -> Axes:
    """Draw the errors of a convergence study and the line fitted to their asymptotic part.

    Parameters
    ----------
    study : ConvergenceStudy
        The runs.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        Error over step or element length, both logarithmic, or over the degree. Runs that the line is not fitted to
        are hollow, the uncertainty of the reference is grey.

    Raises
    ------
    ArgumentTypeError
        If it is not such a study.
    DataError
        If no run reached its end.
    """
    if not isinstance(study, ConvergenceStudy):
        raise ArgumentTypeError(
            "plots.convergence",
            expected="a ConvergenceStudy",
            got=type(study).__name__,
            fix="Call ph.studies.convergence() first.",
        )
    rows = _require_runs("plots.convergence", study.rows)
    if ax is None:
        import matplotlib.pyplot as plt

        _, ax = plt.subplots(figsize=(5.6, 4.2), layout="constrained")
    first, degree = rows[0], rows[0].over == "degree"
    for fitted, face in ((True, "tab:blue"), (False, "none")):
        chosen = [row for row in rows if row.fitted is fitted and row.error > 0.0]
        ax.plot(
            [row.size for row in chosen],
            [row.error for row in chosen],
            linestyle="none",
            marker="o",
            color="tab:blue",
            markerfacecolor=face,
            label="runs" if fitted else "runs not in the fit",
        )
    sizes = np.array([row.size for row in rows if row.fitted])
    if sizes.size > 1:
        slope = study.fit.slope
        x = sizes if degree else np.log(sizes)
        level = np.mean([math.log(row.error) for row in rows if row.fitted]) - slope * x.mean()
        label = f"falls by {study.rate:.3g} a degree" if degree else f"order {slope:.2f}"
        ax.plot(sizes, np.exp(level + slope * x), color="black", linewidth=1.0, label=label)
    ax.set_yscale("log")
    _mark(ax.yaxis)
    if degree:
        ax.set_xticks([row.size for row in rows])
    else:
        ax.set_xscale("log")
        _mark(ax.xaxis, plain=True)
    _shade(ax, first.reference_uncertainty)
    ax.set_xlabel({"dt": "step (s)", "elements": "1 / number of elements", "degree": "degree"}[first.over])
    ax.set_ylabel(f"error of {first.quantity}" + (f" ({first.unit})" if first.unit else ""))
    ax.grid(alpha=0.3)
    ax.legend(frameon=False)
    return ax


def _require_runs(where: str, rows: Sequence[Any]) -> list[Any]:
    kept = [row for row in rows if row.ok]
    if not kept:
        raise DataError(
            where, expected="runs that reached their end", got=f"none of {len(rows)}", fix="See the column status_text."
        )
    return kept


def _line(ax: Axes, rows: Sequence[Run], name: str, colour: str, marker: str, strength: float) -> None:
    """One method on one mesh, from coarse to fine steps."""
    shown = [row for row in rows if getattr(row, name) > 0.0]
    ax.plot(
        [row.seconds for row in shown],
        [getattr(row, name) for row in shown],
        color=colour,
        alpha=strength,
        marker=marker,
        markersize=5.0,
        linewidth=1.3,
    )
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.grid(alpha=0.3)


def _mark(axis: Axis, plain: bool = False) -> None:
    """Put ticks where labels do not overlap and there are some: the fewer decades, the more in each."""
    from matplotlib.ticker import LogFormatterSciNotation, LogLocator, NullLocator

    low, high = axis.get_view_interval()
    decades = math.log10(high / low)
    if decades < 0.3:  # as wide as holds a tick for certain
        margin = 10.0 ** (0.5 * (0.3 - decades))
        axis.set_view_interval(low / margin, high * margin, ignore=True)
    subs = next((subs for most, subs in TICKS if decades < most), (1.0,))
    axis.set_major_locator(LogLocator(subs=subs))
    axis.set_minor_locator(NullLocator())
    if plain and decades < 4.0:
        axis.set_major_formatter(lambda value, _: f"{value:g}")
    else:
        axis.set_major_formatter(LogFormatterSciNotation(minor_thresholds=(math.inf, math.inf)))


def _shade(ax: Axes, uncertainty: float) -> list[Artist]:
    """Where errors say nothing; drawn only where errors come close to it."""
    low, high = ax.get_ylim()
    if not uncertainty > low:
        return []
    label = "uncertainty of the reference"
    area = ax.axhspan(low, uncertainty, color="black", alpha=0.08, linewidth=0.0, label=label)
    ax.set_ylim(low, high)
    return [area]
