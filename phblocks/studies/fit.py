"""Orders and rates: how errors fall from run to run, and the line through those that fall alike.

Over steps and elements the logarithm of the error is a straight line over that of the size, over the degree over the
degree itself.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

#: Neighbouring slopes that differ by less than this, relative, are of the asymptotic part.
STEADY = 0.15


class Fit(NamedTuple):
    """A line through the logarithms.

    Parameters
    ----------
    slope : float
        Of the line; NaN with fewer than two runs.
    deviation : float
        Standard deviation of the slope; NaN with fewer than three runs.
    runs : int
        How many it goes through.
    """

    slope: float
    deviation: float
    runs: int


def fit_line(over: str, sizes: Sequence[float], errors: Sequence[float]) -> Fit:
    """Fit a line through the logarithms by least squares.

    Parameters
    ----------
    over : str
        "dt", "elements" or "degree".
    sizes, errors : sequence of float
        Of the runs; errors above zero.

    Returns
    -------
    Fit
        The line.
    """
    if len(sizes) < 2:
        return Fit(math.nan, math.nan, len(sizes))
    x, y = np.array([_abscissa(over, size) for size in sizes]), np.log(errors)
    x = x - x.mean()
    slope = float(x @ y / (x @ x))
    rest = float(np.sum((y - y.mean() - slope * x) ** 2))
    deviation = math.sqrt(rest / (len(sizes) - 2) / float(x @ x)) if len(sizes) > 2 else math.nan
    return Fit(slope, deviation, len(sizes))


def pairwise_rates(over: str, sizes: Sequence[float], errors: Sequence[float]) -> list[float]:
    """Compare each run with the next coarser one.

    Parameters
    ----------
    over : str
        "dt", "elements" or "degree".
    sizes, errors : sequence of float
        Of the runs, from coarse to fine; an error may be NaN.

    Returns
    -------
    list of float
        Orders, or over the degree the factor by which the error falls with one degree more; NaN for the first run and
        where an error is zero or NaN.
    """
    slopes = [_slope(over, sizes, errors, i, i + 1) for i in range(len(sizes) - 1)]
    return [math.nan, *((math.exp(-slope) for slope in slopes) if over == "degree" else slopes)]


def asymptotic_part(over: str, sizes: Sequence[float], errors: Sequence[float], floor: float) -> set[int]:
    """Find the runs from the finest one on back between which the slope stays the same.

    Parameters
    ----------
    over : str
        "dt", "elements" or "degree".
    sizes, errors : sequence of float
        Of the runs, from coarse to fine; an error may be NaN.
    floor : float
        Errors below it say nothing.

    Returns
    -------
    set of int
        Their numbers: none, or two and more.
    """
    judged = [i for i, error in enumerate(errors) if error > 0.0 and error >= floor]
    if len(judged) < 2:
        return set()
    kept = judged[-2:]
    finest = _slope(over, sizes, errors, *kept)
    for j, i in itertools.pairwise(reversed(judged[:-1])):
        if not abs(_slope(over, sizes, errors, i, j) - finest) <= STEADY * abs(finest):
            break
        kept.append(i)
    return set(kept)


def _abscissa(over: str, size: float) -> float:
    return size if over == "degree" else math.log(size)


def _slope(over: str, sizes: Sequence[float], errors: Sequence[float], i: int, j: int) -> float:
    """Of the line through two errors; NaN if one is zero or unknown."""
    if not (errors[i] > 0.0 and errors[j] > 0.0):
        return math.nan
    return math.log(errors[j] / errors[i]) / (_abscissa(over, sizes[j]) - _abscissa(over, sizes[i]))
