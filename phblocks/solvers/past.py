"""The last steps of a run, for extrapolation."""

from __future__ import annotations

import numpy as np

from phblocks.solvers.step import Step
from phblocks.triplets import Floats

#: Steps that are kept: three to extrapolate from, and one that may be rejected.
KEPT = 4
#: An extrapolation further than this, in distances of the points it starts from, is not trusted.
FARTHEST = 3.0


class Past:
    """The last steps, as long as each goes on where the one before ended."""

    def __init__(self) -> None:
        self._steps: list[Step] = []

    def add(self, step: Step) -> None:
        """Take in a step; it may still be rejected.

        Parameters
        ----------
        step : Step
            The step.
        """
        self._steps = [*self._steps[1 - KEPT :], step]

    def before(self, x: Floats) -> list[Step]:
        """Return the steps that led to a state: none if the run did not come from there.

        Parameters
        ----------
        x : numpy.ndarray
            Unknowns, the very array that a step ended with.

        Returns
        -------
        list of Step
            The last one last.
        """
        while self._steps and self._steps[-1].x is not x:
            self._steps.pop()
        return self._steps

    def middle(self, x: Floats, dt: float, back: int = 1) -> Floats | None:
        """Extrapolate the mean values of the last step and of one before to the middle of the next.

        Parameters
        ----------
        x : numpy.ndarray
            Unknowns at its start, shape (n,).
        dt : float
            Its length, s.
        back : int, optional
            How many steps before the last the other one is.

        Returns
        -------
        numpy.ndarray or None
            Shape (n,); ``None`` without these steps, or if they are much shorter than the next.
        """
        steps = self.before(x)
        if len(steps) <= back:
            return None
        earlier, *between, last = steps[-1 - back :]
        ratio = (dt + last.dt) / (last.dt + earlier.dt + 2.0 * sum(step.dt for step in between))
        if not 0.0 < ratio <= FARTHEST:
            return None
        return np.asarray((1.0 + ratio) * last.z[-1] - ratio * earlier.z[-1])
