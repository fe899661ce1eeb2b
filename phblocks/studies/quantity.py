"""What the error is measured of: a quantity of a solution, at given times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from phblocks.blocks.block import Block
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.ports import Place
from phblocks.results.solution import Solution
from phblocks.triplets import Floats

#: What can be read at a place of a block, and its unit.
UNITS = {"position": "m", "angle": "rad", "velocity": "m/s", "spin": "rad/s", "force": "N", "moment": "N m"}

Read = Callable[[Solution], ArrayLike]
Quantity = Read | tuple[str, Block | str, Place]


@dataclass(frozen=True)
class Reading:
    """A quantity at a place of a block, as the method of a solution of the same name gives it.

    Parameters
    ----------
    kind : str
        "position", "angle", "velocity", "spin", "force" or "moment".
    block : str
        Name of the block.
    place : Place
        On it.
    """

    kind: str
    block: str
    place: Place

    def __call__(self, solution: Solution) -> ArrayLike:
        """Read it.

        Parameters
        ----------
        solution : Solution
            Of a run.

        Returns
        -------
        array_like
            Shape (times,) or (times, components).
        """
        values: ArrayLike = getattr(solution, self.kind)(self.block, self.place)
        return values

    def __str__(self) -> str:
        """Name it."""
        return f"{self.kind} of {self.block!r} at {self.place!r}"


@dataclass(frozen=True)
class Observed:
    """A quantity with the times at which it is taken.

    Parameters
    ----------
    read : callable
        Takes a solution, returns numbers.
    times : tuple of float or None
        s; ``None``: the solution is given to it whole.
    label, unit : str
        For tables and plots.
    """

    read: Read
    times: tuple[float, ...] | None
    label: str
    unit: str

    def __call__(self, solution: Solution) -> Floats:
        """Evaluate it.

        Parameters
        ----------
        solution : Solution
            Of a run.

        Returns
        -------
        numpy.ndarray
            Finite numbers, with at least one axis.

        Raises
        ------
        DataError
            If a time was not saved, or a number is not finite.
        """
        if self.times is not None:
            solution = solution.sliced(_saved(solution.t, self.times))
        values = np.atleast_1d(np.asarray(self.read(solution), dtype=float))
        if not values.size or not np.isfinite(values).all():
            raise DataError(
                self.label, expected="finite numbers", got=str(values), fix="Correct the function given as quantity."
            )
        return values


def observe(where: str, quantity: object, times: ArrayLike | None, t_end: float, unit: str) -> Observed:
    """Make what the user names into something that is evaluated.

    Parameters
    ----------
    where : str
        The study, for messages.
    quantity : callable or tuple
        A function of a solution, or (kind, block, place).
    times : array_like or None
        s; by default ``t_end`` for a tuple, and the whole solution for a function.
    t_end : float
        End of the runs, s.
    unit : str
        Of a function.

    Returns
    -------
    Observed
        The quantity.

    Raises
    ------
    ArgumentTypeError, DataError
        If it is neither, or of an unknown kind, or a time is not within the run.
    """
    if isinstance(quantity, tuple) and len(quantity) == 3:
        kind, block, place = quantity
        if kind not in UNITS:
            raise DataError(
                f"{where} quantity", expected=f"one of {', '.join(UNITS)}", got=repr(kind), fix="Or give a function."
            )
        read: Read = Reading(kind, block.name if isinstance(block, Block) else block, place)
        label, unit, times = str(read), UNITS[kind], (t_end,) if times is None else times
    elif callable(quantity):
        read, label = quantity, getattr(quantity, "__name__", repr(quantity))
    else:
        raise ArgumentTypeError(
            f"{where} quantity",
            expected='a function of a Solution, or such as ("position", "beam", 1.0)',
            got=repr(quantity),
            fix="Give one.",
        )
    if times is None:
        return Observed(read, None, label, unit)
    when = np.atleast_1d(np.asarray(times, dtype=float))
    if when.ndim != 1 or not when.size or not (np.isfinite(when) & (when >= 0.0) & (when <= t_end)).all():
        raise DataError(f"{where} times", expected=f"times from 0 to {t_end:g} s", got=str(times), fix="Correct them.")
    return Observed(read, tuple(when.tolist()), label, unit)


def distance(a: Floats, b: Floats) -> float:
    """Measure how far two values of a quantity are apart.

    Parameters
    ----------
    a, b : numpy.ndarray
        Of the same shape.

    Returns
    -------
    float
        Largest over the first axis (times) of the Euclidean norm over all others (components).

    Raises
    ------
    DataError
        If they are not of the same shape.
    """
    if a.shape != b.shape:
        raise DataError(
            "quantity of a study",
            expected="a value of the same shape from every run, whatever its step",
            got=f"shapes {a.shape} and {b.shape}",
            fix="Give times=[...], at which the quantity is taken in all of them.",
        )
    difference = (a - b).reshape(a.shape[0], -1)
    return float(np.linalg.norm(difference, axis=1).max())


def _saved(t: Floats, times: tuple[float, ...]) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Which of the saved times these are; nothing is interpolated, which would be an error of its own."""
    numbers = np.array([int(np.abs(t - time).argmin()) for time in times])
    missed = np.abs(t[numbers] - times) > 1e-9 * max(1.0, float(t[-1]))
    if missed.any():
        raise DataError(
            "times of the quantity",
            expected="times that the run saves",
            got=f"{np.asarray(times)[missed][0]:g} s, nearest {t[numbers][missed][0]:g} s",
            fix="Use steps that divide them.",
        )
    return numbers
