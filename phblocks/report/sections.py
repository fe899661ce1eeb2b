"""The sections of the page, each HTML made of what the solution says."""

from __future__ import annotations

from html import escape

import numpy as np

from phblocks.causality import CausalityReport
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
    """Tabulate what the run keeps, and what it does not, each with a limit, a verdict and what to do.

    Parameters
    ----------
    solution : Solution
        Of a run.

    Returns
    -------
    str
        HTML, of ``solution.health``.
    """
    findings = solution.health.findings
    rows: list[list[Cell]] = [
        [f.name, "not known" if f.value is None else f.value, f.cells[2], f.verdict, f.cells[4], f.needed]
        for f in findings
    ]
    s = solution.statistics
    noted: list[tuple[str, float]] = [
        ("energy the start was changed by, J", s.start_energy_change),
        ("times loops were closed", s.projections),
        ("energy that closing loops added, J", s.projection_energy_change),
        ("energy the method took away, J", float(solution.energy.numerical_loss[-1])),
    ]
    rows += [[what, value, "", "noted", "", ""] for what, value in noted if value]
    over = "".join(f'<li class="bad">{escape(str(finding))}</li>' for finding in findings.over)
    listed = f"<ul>{over}</ul>\n" if over else ""
    return listed + table(("what", "value", "limit", "verdict", "where", "advice"), rows, "health-table")


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
