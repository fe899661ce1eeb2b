"""How far strain and configuration part, and joints open, which energy does not show."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING

from phblocks.errors import DataError, UnknownNameError
from phblocks.plots.arguments import require_solution
from phblocks.results.gaps import block_gaps
from phblocks.results.solution import Solution
from phblocks.triplets import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Lines of a kind; the largest gaps are drawn.
LINES = 6
#: Gaps below this share of the largest are left out: they are round-off.
RANGE = 1e-9


def gap(solution: Solution, *, ax: Axes | None = None) -> Axes:
    """Draw the gaps of a run over time.

    Parameters
    ----------
    solution : Solution
        Of a run.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        m over s, logarithmic. Lines: for each block the largest distance between a place rebuilt from strain and the
        same integrated from velocity. Dashed: for each joint the distance that opened in it
        (``solution.closure()``). Of each kind the six largest; what is below
        1e-9 of the largest of all is left out.

    Raises
    ------
    DataError
        If the system has neither.
    ArgumentTypeError
        If it is not a solution.
    """
    require_solution("plots.gap", solution)
    blocks, joints = block_gaps(solution), _joint_gaps(solution)
    if not blocks and not joints:
        raise DataError(
            "plots.gap",
            expected="a block with two positions or a joint",
            got="neither",
            fix='Compile with outputs="all"; a system without positions has no gaps.',
        )
    if ax is None:
        import matplotlib.pyplot as plt

        _, ax = plt.subplots(figsize=(7.0, 4.4), layout="constrained")
    floor = RANGE * max(float(series.max()) for gaps in (blocks, joints) for series in gaps.values())
    drawn = False
    for kind, gaps, style in (("strain to position", blocks, "-"), ("joint", joints, "--")):
        largest = sorted(gaps, key=lambda name: -float(gaps[name].max()))[:LINES]
        for name in largest:
            shown = gaps[name] > floor
            drawn = drawn or bool(shown.any())
            ax.plot(solution.t[shown], gaps[name][shown], style, linewidth=1.3, label=f"{kind}: {name}")
        if len(gaps) > len(largest):
            ax.plot([], [], " ", label=f"and {len(gaps) - len(largest)} smaller")
    if drawn:
        ax.set_yscale("log")
    ax.set_xlabel("time (s)")
    ax.set_ylabel("gap (m)")
    ax.margins(x=0.0)
    ax.grid(alpha=0.3)
    legend = ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False, fontsize=8)
    for text in legend.get_texts():
        text.set_parse_math(False)
    return ax


def _joint_gaps(solution: Solution) -> Mapping[str, Floats]:
    with suppress(UnknownNameError):
        return solution.closure(source="strain")
    return {}
