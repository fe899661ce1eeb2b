"""The times of a run: its end, its step, and what is saved."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phblocks.triplets import Floats, Ints

#: Steps that are taken and evaluated together: at most so many, of about so many unknowns in all.
MANY, NUMBERS = 4096, 2**17
#: Lengths that differ by less, relative, are one: the differences of times vary by round-off.
SAME = 1e-9
#: Intervals of one length in a row: their begins, their length, their ends, and which ends are saved.
Stretch = tuple[Floats, float, Floats, NDArray[np.bool_]]


def together(n: int, chunk: int = MANY) -> int:
    """Say how many steps to take at a time.

    Parameters
    ----------
    n : int
        Number of unknowns.
    chunk : int, optional
        A number of steps to end with, some stretches of about equal length later.

    Returns
    -------
    int
        At least one.
    """
    most = max(1, min(MANY, NUMBERS // max(1, n)))
    return math.ceil(chunk / math.ceil(chunk / most))


@dataclass(frozen=True)
class Schedule:
    """Times of a run.

    Parameters
    ----------
    t_end : float
        Its end, s.
    dt : float
        Its step, s.
    save_every : int
        Save every so many steps.
    times : tuple of float, optional
        Save at these instead, s, increasing; the last one is ``t_end``.
    steps_too : bool, optional
        Save at these and every so many steps.
    """

    t_end: float
    dt: float
    save_every: int = 1
    times: tuple[float, ...] | None = None
    steps_too: bool = False

    def saves(self, count: int | Ints) -> bool | NDArray[np.bool_]:
        """Say whether a step is saved because of its number; at the times asked for it is anyway.

        Parameters
        ----------
        count : int or numpy.ndarray
            Its number, from 1, or those of several.

        Returns
        -------
        bool or numpy.ndarray
            Whether it is.
        """
        return (self.times is None or self.steps_too) & (count % self.save_every == 0)

    def targets(self) -> Iterator[tuple[float, float]]:
        """Iterate over the intervals between times that are saved.

        Yields
        ------
        tuple of float
            Begin and end, s.
        """
        last = 0.0
        for _, _, end, save in self.intervals():
            if save:
                yield last, end
                last = end

    def intervals(self, first: int = 0) -> Iterator[tuple[float, float, float, bool]]:
        """Iterate over steps of equal length: dt, the last one before a time of its own shorter or all of them.

        Parameters
        ----------
        first : int, optional
            Number of the interval to begin with.

        Yields
        ------
        tuple
            Begin, length and end, s, and whether the end is saved.
        """
        for begin, length, end, saved in self.stretches(first):
            yield from zip(begin.tolist(), itertools.repeat(length), end.tolist(), saved.tolist(), strict=False)

    def stretches(self, first: int = 0, longest: int = MANY) -> Iterator[Stretch]:
        """Iterate over the same intervals in stretches of equal length.

        Parameters
        ----------
        first : int, optional
            Number of the interval to begin with.
        longest : int, optional
            The largest number of intervals in a stretch.

        Yields
        ------
        tuple
            Begins, the common length and ends, s, and which ends are saved; arrays of shape (intervals,).
        """
        held: list[Stretch] = []
        count = 0
        for begin, length, end, saved in self._pieces(first, longest):
            if held and abs(length - held[0][1]) <= SAME * length:
                length = held[0][1]
            count += begin.size
            if held and (held[0][1] != length or count > longest):
                yield _joined(held)
                held, count = [], begin.size
            held.append((begin, length, end, saved))
        if held:
            yield _joined(held)

    def _pieces(self, first: int, longest: int) -> Iterator[Stretch]:
        """The same, of which none goes on over a time that is asked for."""
        times, count = self.times or (self.t_end,), 0
        for begin, end in itertools.pairwise((0.0, *times)):
            steps = self._steps(begin, end)
            apart = self.times is not None  # each with its own length
            h = (end - begin) / steps if apart else self.dt
            length = self._length(h)
            last = length if apart else self._length(end - (steps - 1) * h)
            whole = steps if last == length else steps - 1
            before = max(0, first - count)
            if steps == 1 and not before:  # a time that is asked for at every step
                one = np.array([begin]), last, np.array([end]), np.array([True])
                count += 1
                yield one
                continue
            cuts = ((low, min(low + longest, whole), length) for low in range(before, whole, longest))
            for low, high, size in itertools.chain(cuts, [(max(whole, before), steps, last)]):
                k = np.arange(low, high)
                if k.size:
                    ends = np.asarray(np.where(k == steps - 1, end, begin + (k + 1) * h), dtype=np.float64)
                    saved: NDArray[np.bool_] = (k == steps - 1) | self.saves(count + k + 1)
                    yield np.asarray(begin + k * h, dtype=np.float64), size, ends, saved
            count += steps

    def _steps(self, begin: float, end: float) -> int:
        return max(1, math.ceil((end - begin) / self.dt - 1e-9))

    def _length(self, length: float) -> float:
        # another length would cost a linear system its kept factor
        return self.dt if abs(length - self.dt) <= SAME * self.dt else length


def _joined(pieces: list[Stretch]) -> Stretch:
    if len(pieces) == 1:
        return pieces[0]
    begin, _, end, saved = zip(*pieces, strict=True)
    return np.concatenate(begin), pieces[0][1], np.concatenate(end), np.concatenate(saved)
