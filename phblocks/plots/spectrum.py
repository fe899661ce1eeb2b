"""Natural frequencies, their damping, and what a step resolves of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from phblocks.blocks.checks import require_positive
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.modes import Modes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Values of step times angular frequency at which lines are drawn: resolved well, one radian a step, half a turn.
LEVELS = ((0.1, "0.1"), (1.0, "1"), (np.pi, "π"))


def spectrum(modes: Modes, dt: float | None = None, *, ax: Axes | None = None) -> Axes:
    """Draw frequencies in their order, coloured by damping, and how well a step resolves them.

    Parameters
    ----------
    modes : Modes
        What ``system.modes(n)`` gave.
    dt : float, optional
        Length of a step, s: lines at ``h omega = 0.1``, 1 and pi. Above pi a wave turns by more than half a circle
        in a step; what a method makes of it then is not its motion.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        Frequency, Hz, logarithmic, over the number of the mode. Damped and growing modes are coloured by the damping
        ratio ``-growth / sqrt(growth**2 + frequency**2)``, with a colour bar; undamped ones are all blue. The title
        counts motions that diverge without oscillating.

    Raises
    ------
    DataError
        If there are no modes, or the step is not positive.
    ArgumentTypeError
        If it is not modes.
    """
    if not isinstance(modes, Modes):
        raise ArgumentTypeError(
            "plots.spectrum", expected="Modes", got=type(modes).__name__, fix="Call system.modes(n) first."
        )
    if not modes.frequencies.size:
        raise DataError("plots.spectrum", expected="a mode or more", got="none", fix="Nothing oscillates there.")
    if dt is not None:
        dt = require_positive("plots.spectrum dt", dt)
    if ax is None:
        import matplotlib.pyplot as plt

        _, ax = plt.subplots(figsize=(7.0, 4.0), layout="constrained")
    from matplotlib.ticker import MaxNLocator

    number = np.arange(1, modes.frequencies.size + 1)
    ratio = -modes.growth / np.hypot(modes.growth, modes.frequencies)
    if np.abs(ratio).max() > 1e-10:
        size = float(np.abs(ratio).max())
        growing = bool((ratio < -1e-10).any())
        dots = ax.scatter(
            number,
            modes.hertz,
            c=ratio,
            cmap="coolwarm_r" if growing else "viridis",
            vmin=-size if growing else 0.0,
            vmax=size,
            zorder=3,
        )
        ax.figure.colorbar(dots, ax=ax, label="damping ratio" + (" (negative: growing)" if growing else ""))
    else:
        ax.scatter(number, modes.hertz, color="tab:blue", zorder=3)
    ax.set_yscale("log")
    if dt is not None:
        for level, name in LEVELS:
            line = level / (2.0 * np.pi * dt)
            ax.axhline(line, color="tab:red" if level > 3.0 else "0.4", linestyle="--", linewidth=1.0, zorder=1)
            ax.annotate(
                f"hω = {name}",
                (0.99, line),
                xycoords=("axes fraction", "data"),
                ha="right",
                xytext=(0, 2),
                textcoords="offset points",
                fontsize=8,
            )
    if modes.diverging.size:
        ax.set_title(f"{modes.diverging.size} more diverge without oscillating", color="tab:red", fontsize="medium")
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_xlabel("mode")
    ax.set_ylabel("frequency (Hz)")
    ax.grid(alpha=0.3)
    return ax
