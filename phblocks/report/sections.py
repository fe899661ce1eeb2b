"""The sections of the page, each HTML made of what the solution says."""

from __future__ import annotations

from contextlib import suppress
from html import escape
from typing import Any

import numpy as np

from phblocks.causality import CausalityReport
from phblocks.errors import UnknownNameError
from phblocks.plots.diagram import diagram
from phblocks.plots.energy import energy
from phblocks.plots.power_flow import power_flow
from phblocks.report.html import Cell, figure_svg, table
from phblocks.results.solution import Solution

#: Saved times in a drawn curve.
TIMES = 300
#: Ports up to which the reason of each choice is told.
REASONS = 200


def drawing(solution: Solution) -> str:
    """Draw the diagram.

    Parameters
    ----------
    solution : Solution
        Of a run.

    Returns
    -------
    str
        HTML.
    """
    ax = diagram(_causality(solution))
    figure = ax.get_figure(root=True)
    assert figure is not None
    return figure_svg(figure, "drawing", f"block diagram of {solution.system.name}")


def causality(solution: Solution) -> str:
    """Tabulate who gives and takes what, and why.

    Parameters
    ----------
    solution : Solution
        Of a run.

    Returns
    -------
    str
        HTML.
    """
    report = _causality(solution)
    ports = [a for a in report.assignments if not a.port.block.shared]
    rows: list[list[Cell]] = []
    for a in ports:
        others = [p.path for p in a.junction.ports if p is not a.port]
        others += [f"outside {e.name!r}" for e in a.junction.exposures]
        why = report.explain(a.port).splitlines()[0] if len(ports) <= REASONS else ""
        rows.append([a.port.path, a.port.domain.name, a.given, a.taken, ", ".join(others) or "nothing", why])
    switches = "".join(f"<li>{escape(text)}</li>" for text in report.switches)
    listed = f"<p>Switches inside blocks:</p>\n<ul>{switches}</ul>\n" if switches else ""
    return listed + table(("port", "domain", "gives", "takes", "joined to", "why"), rows, "ports")


def effects(solution: Solution) -> str:
    """Tabulate what was kept of the physics, proven to change nothing, and left out on request.

    Parameters
    ----------
    solution : Solution
        Of a run.

    Returns
    -------
    str
        HTML, of ``system.effects``.
    """
    rows: list[list[Cell]] = [
        [e.block or "the whole", e.name, e.status, e.states, e.reason] for e in solution.system.effects
    ]
    return table(("block", "effect", "status", "states", "why"), rows, "effects-table")


def energies(solution: Solution) -> str:
    """Draw and tabulate energies, and who fed whom.

    Parameters
    ----------
    solution : Solution
        Of a run.

    Returns
    -------
    str
        HTML.
    """
    times = np.unique(np.linspace(0, solution.t.size - 1, TIMES).round().astype(np.int64))
    shown = solution.sliced(times)
    ax = energy(shown)
    figure = ax.get_figure(root=True)
    assert figure is not None
    parts = [figure_svg(figure, "energy", "energies over time")]
    rows: list[list[Cell]] = [
        [name, float(series[0]), float(series[-1]), float(series.min()), float(series.max())]
        for name, series in solution.energy.items()
    ]
    parts.append(table(("energy, J", "start", "end", "least", "most"), rows, "energy-table"))
    columns = solution.power.columns
    rows = [[name, *(float(row[c][-1]) for c in columns)] for name, row in solution.power.blocks.items()]
    parts.append(
        "<h3>Blocks: energy since the start, J</h3>\n"
        + table(("block", *(c.replace("_", " ") for c in columns)), rows, "ledger")
    )
    if solution.t.size > 1 and any(any(row[1:]) for row in rows):
        figure = power_flow(shown).get_figure(root=True)
        assert figure is not None
        parts.append("<h3>Mean power</h3>\n" + figure_svg(figure, "flow", "mean power between blocks"))
    return "\n".join(parts)


def health(solution: Solution) -> str:
    """Tabulate what the run keeps, and what it does not.

    Parameters
    ----------
    solution : Solution
        Of a run.

    Returns
    -------
    str
        HTML; also what an attribute ``health`` of the solution says, if there is one.
    """
    worst, residual = solution.power.worst
    energy = max((float(np.abs(series).max()) for series in solution.energy.values()), default=0.0)
    rows: list[list[Cell]] = [
        ["balance of the whole, worst step", solution.max_power_balance_error, "J"],
        ["largest energy, for comparison", energy, "J"],
        [f"balance of {worst}, the worst part", residual, "J"],
        ["energy the start was changed by", solution.statistics.start_energy_change, "J"],
        ["steps halved", solution.statistics.halvings, ""],
        ["times loops were closed", solution.statistics.projections, ""],
        ["energy that closing loops added", solution.statistics.projection_energy_change, "J"],
        ["energy the method took away", float(solution.energy.numerical_loss[-1]), "J"],
        ["steps rejected", solution.statistics.rejections, ""],
    ]
    with suppress(UnknownNameError):
        rows += [[f"gap of {name}", float(gap.max()), "m"] for name, gap in solution.closure().items()]
    told: Any = getattr(solution, "health", None)
    own = "" if told is None else f"<pre>{escape(str(told))}</pre>\n"
    return own + table(("what", "value", "unit"), rows, "health-table")


def cost(solution: Solution) -> str:
    """Tabulate time and iterations.

    Parameters
    ----------
    solution : Solution
        Of a run.

    Returns
    -------
    str
        HTML.
    """
    s = solution.statistics
    iterations = s.newton_iterations
    rows: list[list[Cell]] = [
        ["steps", s.steps, ""],
        ["Newton iterations a step, mean", float(iterations.mean()) if iterations.size else 0.0, ""],
        ["Newton iterations a step, most", int(iterations.max(initial=0)), ""],
        ["before the time loop", s.preparation_seconds, "s"],
        ["time loop", s.loop_seconds, "s"],
        ["a step", 1e6 * s.loop_seconds / max(s.steps, 1), "µs"],
    ]
    counts = np.bincount(iterations) if iterations.size else np.empty(0, dtype=int)
    spread: list[list[Cell]] = [[k, int(count)] for k, count in enumerate(counts) if count]
    return (
        table(("what", "value", "unit"), rows, "cost-table")
        + "\n"
        + table(("iterations", "steps"), spread, "iterations")
    )


def _causality(solution: Solution) -> CausalityReport:
    assert isinstance(solution.system.report, CausalityReport)
    return solution.system.report
