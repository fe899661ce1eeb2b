"""Where the energy of a run is, and how well every step adds up."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from phblocks.errors import ArgumentTypeError
from phblocks.results.readings import Readings

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def energy(solution: Readings, *, increments: bool = False, ax: Axes | None = None) -> Axes:
    """Draw the energies of a run over time, or the balance of its steps.

    Parameters
    ----------
    solution : Solution or SavedRun
        Of a run.
    increments : bool, optional
        Draw what the balance of a step leaves over, ``|dH - supplied + losses|``, on a logarithmic axis (the
        largest of the steps between two saved times), with the round-off of the largest energy for comparison.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        Without increments one line for each kind of energy that is not zero throughout, and the total, J over s.
        With increments the residuals, J over s; those that are exactly zero are left out.

    Raises
    ------
    ArgumentTypeError
        If it is not a solution.

    Notes
    -----
    After Fig. 7 of Brugnoli, Kinon, Sanfedino, Betsch: Structure-preserving discretization of intrinsic
    geometrically exact beams for explicit multibody dynamics.
    """
    if not isinstance(solution, Readings):
        raise ArgumentTypeError(
            "plots.energy", expected="a Solution", got=type(solution).__name__, fix="Call ph.simulate() first."
        )
    if ax is None:
        import matplotlib.pyplot as plt

        _, ax = plt.subplots(figsize=(7.0, 3.6), layout="constrained")
    if increments:
        _draw_increments(solution, ax)
    else:
        _draw_energies(solution, ax)
    ax.set_xlabel("time (s)")
    ax.margins(x=0.0)
    ax.grid(alpha=0.3)
    # above the axes, where it hides no curve
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=len(ax.lines), frameon=False)
    return ax


def _draw_energies(solution: Readings, ax: Axes) -> None:
    for name, series in solution.energy.items():
        if name == "total":
            ax.plot(solution.t, series, color="black", linewidth=2.0, label=name)
        elif series.any():
            ax.plot(solution.t, series, linewidth=1.2, label=name.replace("_", " "))
    ax.set_ylabel("energy (J)")


def _draw_increments(solution: Readings, ax: Axes) -> None:
    error = solution.recording.ledger.balance_error[1:]
    shown = error > 0.0
    round_off = np.finfo(float).eps * max(float(np.abs(series).max()) for series in solution.energy.values())
    if round_off > 0.0:
        ax.set_yscale("log")
    ax.plot(
        solution.t[1:][shown],
        error[shown],
        linestyle="none",
        marker=".",
        markersize=3.0,
        label="each step",
    )
    ax.axhline(round_off, color="black", linestyle="--", linewidth=1.0, label="round-off of largest energy")
    ax.set_ylabel("|ΔH − supplied + losses| (J)")
