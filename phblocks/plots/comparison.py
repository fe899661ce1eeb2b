"""Several runs side by side: a path or a quantity, and how far each is from the first."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from phblocks.blocks.block import BlockPoint
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.plots.arguments import require_solution
from phblocks.ports import Anchor
from phblocks.results.solution import Solution
from phblocks.triplets import Floats, Ints

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Read = BlockPoint | Anchor | str | Callable[[Solution], Floats]


def comparison(solutions: Mapping[str, Solution], quantity: Read, unit: str = "") -> Figure:
    """Draw a quantity of several runs, and its distance from that of the first.

    Parameters
    ----------
    solutions : mapping of str to Solution
        Two or more by name; the first is what the others are compared with. Meshes may differ.
    quantity : BlockPoint, Anchor, str or callable
        A point such as ``beam.at(0.5)``, looked up by block name and place in each run: its path. A text: a kind of
        energy such as "strain", or the name of a state. Or a function of a solution, the values of shape (times,) or
        (times, components).
    unit : str, optional
        Of what a function returns, for the axes.

    Returns
    -------
    matplotlib.figure.Figure
        Two axes: paths at equal scale, m, or values over time, s; and the distances from the first run (Euclidean
        over components) at the saved times that both have, on a logarithmic axis; zeros are left out.

    Raises
    ------
    DataError
        If there are fewer than two runs, values of another shape, or no saved time in common after the start.
    UnknownNameError
        If a run has no such block, state or energy.
    ArgumentTypeError
        If the solutions are not a mapping to solutions, or the quantity is nothing to read.
    """
    if not isinstance(solutions, Mapping) or isinstance(quantity, bool) or not _readable(quantity):
        raise ArgumentTypeError(
            "plots.comparison",
            expected="solutions by name, and a point, a name or a function",
            got=f"{type(solutions).__name__} and {quantity!r}",
            fix='For example plots.comparison({"fine": a, "coarse": b}, beam.end).',
        )
    if len(solutions) < 2:
        raise DataError("plots.comparison", expected="two solutions", got=str(len(solutions)), fix="Give another.")
    for solution in solutions.values():
        require_solution("plots.comparison", solution)
    values = {name: _values(name, solution, quantity) for name, solution in solutions.items()}
    is_path = isinstance(quantity, (BlockPoint, Anchor))
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 3.8), layout="constrained")
    first, *others = solutions
    for number, (name, solution) in enumerate(solutions.items()):
        style = {
            "color": f"C{number}",
            "linewidth": 2.4 if name == first else 1.2,
            "alpha": 0.6 if name == first else 1,
        }
        if is_path:
            left.plot(values[name][:, 0], values[name][:, 1], **style, label=name)
        else:
            for c, column in enumerate(values[name].T):
                left.plot(solution.t, column, **style, label=name if c == 0 else "_component")
    drawn = False
    for number, name in enumerate(others, start=1):
        here, there = _common_times(name, solutions[name].t, solutions[first].t)
        apart = np.linalg.norm(values[name][here] - values[first][there], axis=1)
        shown = apart > 0.0
        drawn = drawn or bool(shown.any())
        right.plot(solutions[name].t[here][shown], apart[shown], color=f"C{number}", label=name)
    if drawn:
        right.set_yscale("log")
    unit = "m" if is_path else unit or ("J" if isinstance(quantity, str) and quantity in solution.energy else "")
    called = quantity if isinstance(quantity, str) else "" if is_path else getattr(quantity, "__name__", "value")
    called = "value" if called == "<lambda>" else called
    suffix = f" ({unit})" if unit else ""
    if is_path:
        left.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    else:
        left.set(xlabel="time (s)", ylabel=f"{called}{suffix}")
    right.set(xlabel="time (s)", ylabel=f"distance from {first!r}{suffix}")
    for ax in (left, right):
        ax.grid(alpha=0.3)
    handles, labels = left.get_legend_handles_labels()
    legend = figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    for text in (*legend.get_texts(), left.yaxis.label, right.yaxis.label):
        text.set_parse_math(False)
    return figure


def _readable(quantity: object) -> bool:
    return isinstance(quantity, (BlockPoint, Anchor, str)) or callable(quantity)


def _values(name: str, solution: Solution, quantity: Read) -> Floats:
    """Shape (times, components)."""
    if isinstance(quantity, (BlockPoint, Anchor)):
        return solution.position(quantity.block.name, quantity.place)
    if isinstance(quantity, str):
        found = solution.energy[quantity] if quantity in solution.energy else solution.state(quantity)
        return found[:, None]
    found = np.asarray(quantity(solution), dtype=float)
    if found.shape[:1] != solution.t.shape or found.ndim > 2:
        raise DataError(
            f"plots.comparison quantity of {name!r}",
            expected=f"shape ({solution.t.size},) or ({solution.t.size}, components)",
            got=str(found.shape),
            fix="Return a value for each saved time.",
        )
    return found.reshape(solution.t.size, -1)


def _common_times(name: str, t: Floats, reference: Floats) -> tuple[Ints, Ints]:
    """Numbers of the saved times that two runs have in common."""
    nearest = np.abs(reference - t[:, None]).argmin(axis=1)
    here = np.flatnonzero(np.abs(reference[nearest] - t) <= 1e-9 * max(float(reference[-1]), 1e-300))
    if here.size < 2:
        raise DataError(
            f"plots.comparison of {name!r}",
            expected="two saved times or more in common with the first",
            got=str(here.size),
            fix="Save both at the same times (save_every).",
        )
    return here, nearest[here]
