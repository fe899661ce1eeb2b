"""Where the entries of a matrix are, block by block."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
import scipy.sparse as sp

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.solvers.stage import StageEquation
from phblocks.system import System
from phblocks.triplets import Floats, Ints

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: More labels than this on an axis are not legible: fields are left out, then blocks.
MOST_LABELS = 40

Name = Literal["J", "E", "R", "newton"]
Entries = dict[str, tuple[Ints, Ints]]


def sparsity(system: System, matrix: Name | Floats | sp.sparray = "J", *, ax: Axes | None = None) -> Axes:
    """Draw which entries of a matrix of a system are not zero.

    Parameters
    ----------
    system : System
        Its blocks and fields label the axes.
    matrix : {"J", "E", "R", "newton"} or array_like or scipy.sparse.sparray, optional
        "J" tells constant entries from those that states (velocity, stress) and turning joints modulate; "newton"
        is the matrix of a step in the order in which it is solved; an array has shape (n, n), in the order of the
        states, for instance ``system.J(x, theta)``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        Rows downwards, columns to the right, numbered by state (no unit).

    Raises
    ------
    DataError
        If the matrix has another shape, or its name is unknown.
    ArgumentTypeError
        If it is not a system.
    """
    if not isinstance(system, System):
        raise ArgumentTypeError(
            "plots.sparsity", expected="a System", got=type(system).__name__, fix="Call compile() first."
        )
    title, entries = _entries(system, matrix)
    if ax is None:
        import matplotlib.pyplot as plt

        _, ax = plt.subplots(figsize=(6.4, 6.8), layout="compressed")
    n = system.n
    ax.set_aspect("equal")
    ax.set_xlim(-0.5, n - 0.5)
    ax.set_ylim(n - 0.5, -0.5)
    in_order_of_states = not (isinstance(matrix, str) and matrix == "newton")
    if in_order_of_states:
        _mark_blocks(system, ax)
    extent = ax.get_window_extent()
    points = 72.0 * min(extent.width, extent.height) / ax.figure.dpi
    for label, (rows, columns) in entries.items():
        if rows.size:
            ax.plot(
                columns,
                rows,
                linestyle="none",
                marker="s",
                markersize=max(0.7, 0.8 * points / max(n, 1)),
                markeredgewidth=0.0,
                label=label,
            )
    ax.set_title(title)
    ax.set_xlabel("column: state" if in_order_of_states else "column: unknown, in the order of solution")
    ax.set_ylabel("row: state" if in_order_of_states else "row: unknown, in the order of solution", labelpad=8.0)
    if len(entries) > 1:
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3, frameon=False, markerscale=2.0)
    return ax


def _entries(system: System, matrix: Name | Floats | sp.sparray) -> tuple[str, Entries]:
    """Title, and the places of the entries by kind."""
    n = system.n
    if isinstance(matrix, str):
        if matrix == "J":
            return f"J of {system.name}: {n} × {n}", _structure(system)
        if matrix == "newton":
            stage = StageEquation(system)
            width = int(np.abs(stage.rows - stage.columns).max(initial=0))
            title = f"Newton matrix of {system.name}: {n} × {n}, half-bandwidth {width}"
            return title, {"entries": (stage.rows, stage.columns)}
        if matrix not in ("E", "R"):
            raise DataError(
                "plots.sparsity matrix",
                expected='"J", "E", "R", "newton" or a matrix',
                got=repr(matrix),
                fix="Choose one of them.",
            )
        name, array = f"{matrix} of {system.name}", sp.coo_array(system.E if matrix == "E" else system.R)
    else:
        name, array = system.name, sp.coo_array(matrix)
    if array.shape != (n, n):
        raise DataError(
            "plots.sparsity matrix",
            expected=f"shape ({n}, {n}), the states of {system.name!r}",
            got=f"shape {array.shape}",
            fix="Give a matrix of this system.",
        )
    array.eliminate_zeros()
    return f"{name}: {n} × {n}, {array.nnz} entries", {"entries": array.coords}


def _structure(system: System) -> Entries:
    """The entries of J, each place once: under the first of the kinds that reaches it."""
    kinds = {
        "constant": system.J0.tocoo().coords,
        "times velocity or stress": system.T.coords[:2],
        "turning joints": system.K.indices[:2],
    }
    entries, seen = {}, np.empty(0, dtype=np.int64)
    for kind, (rows, columns) in kinds.items():
        code = np.setdiff1d(np.asarray(rows, dtype=np.int64) * system.n + columns, seen)
        seen = np.union1d(seen, code)
        entries[kind] = (code // system.n, code % system.n)
    return entries


def _mark_blocks(system: System, ax: Axes) -> None:
    """Name blocks outside and their fields next to the axes, with lines between them."""
    parts = [part for part in system.parts if part.states.stop > part.states.start]
    runs = [run for part in parts for run in part.form.runs]
    edges = system.sharing.state_of(np.cumsum([0, *(run.positions.size for run in runs)])) - 0.5
    firsts = system.sharing.state_of(np.array([*(part.states.start for part in parts), parts[-1].states.stop]))
    borders = firsts[1:-1] - 0.5
    wide = np.diff(edges) > 0.0  # fields of which states are left
    if len(runs) <= MOST_LABELS:
        for axis in (ax.xaxis, ax.yaxis):
            centres = 0.5 * (edges[1:] + edges[:-1])
            axis.set_ticks(centres[wide], [run.field for run, w in zip(runs, wide, strict=True) if w], fontsize=7)
            axis.set_tick_params(length=0)
        for edge in edges[1:-1]:
            ax.axhline(edge, color="0.9", linewidth=0.5, zorder=0)
            ax.axvline(edge, color="0.9", linewidth=0.5, zorder=0)
        ax.tick_params(axis="x", labelrotation=90)
    for border in borders:
        ax.axhline(border, color="0.4", linewidth=0.8, zorder=1)
        ax.axvline(border, color="0.4", linewidth=0.8, zorder=1)
    if len(parts) <= MOST_LABELS:
        middles = 0.5 * (firsts[1:] + firsts[:-1] - 1)
        names = [part.name if w else "" for part, w in zip(parts, np.diff(firsts) > 0, strict=True)]
        top, right = ax.secondary_xaxis("top"), ax.secondary_yaxis("right")
        top.set_xticks(middles, names, fontsize=9)
        right.set_yticks(middles, names, fontsize=9, rotation=270, va="center")
        top.tick_params(length=0)
        right.tick_params(length=0)
