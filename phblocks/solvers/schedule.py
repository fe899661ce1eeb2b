"""The times of a run: its end, its step, and what is saved."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass


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

    def saves(self, count: int) -> bool:
        """Say whether a step is saved because of its number; at the times asked for it is anyway.

        Parameters
        ----------
        count : int
            Its number, from 1.

        Returns
        -------
        bool
            Whether it is.
        """
        return (self.times is None or self.steps_too) and count % self.save_every == 0

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

    def intervals(self) -> Iterator[tuple[float, float, float, bool]]:
        """Iterate over steps of equal length: dt, the last one before a time of its own shorter or all of them.

        Yields
        ------
        tuple
            Begin, length and end, s, and whether the end is saved.
        """
        if self.times is None:
            steps = self._steps(0.0, self.t_end)
            for k in range(steps):
                t0, t1 = k * self.dt, self.t_end if k == steps - 1 else (k + 1) * self.dt
                yield t0, self._length(t0, t1, self.dt), t1, self.saves(k + 1) or k == steps - 1
            return
        count = 0
        for begin, end in itertools.pairwise((0.0, *self.times)):
            steps = self._steps(begin, end)
            h = (end - begin) / steps
            for k in range(steps):
                t1 = end if k == steps - 1 else begin + (k + 1) * h
                count += 1
                yield begin + k * h, self._length(0.0, h, self.dt), t1, self.saves(count) or k == steps - 1

    def _steps(self, begin: float, end: float) -> int:
        return max(1, math.ceil((end - begin) / self.dt - 1e-9))

    @staticmethod
    def _length(t0: float, t1: float, dt: float) -> float:
        # the differences of times vary by round-off, which would cost a linear system its kept factor
        return dt if abs(t1 - t0 - dt) <= 1e-9 * dt else t1 - t0
