"""The way of a run through time in equal steps."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from phblocks.inputs import Drive
from phblocks.solvers.method import Stepper
from phblocks.solvers.schedule import Schedule
from phblocks.solvers.step import Step, StepFailed, failure
from phblocks.system import State
from phblocks.triplets import Floats


class EqualSteps:
    """Goes through a schedule in its steps; one that fails is repeated in halves.

    Parameters
    ----------
    prepare : callable
        Makes a stepper, which takes the steps.
    drive : Drive
        The inputs.
    start : State
        Where it starts.
    schedule : Schedule
        The times.
    max_halvings : int
        How often a step is halved before the run ends.

    Attributes
    ----------
    stage, weights, nodes
        Of the stepper.
    steps, halvings, rejections : int
        Counts.
    """

    rejections = 0

    def __init__(
        self, prepare: Callable[[], Stepper], drive: Drive, start: State, schedule: Schedule, max_halvings: int
    ) -> None:
        self._prepare, self._stepper = prepare, prepare()
        self.stage, self.weights, self.nodes = self._stepper.stage, self._stepper.weights, self._stepper.nodes
        self.steps = self.halvings = self._intervals = 0
        self._drive, self._x, self._theta = drive, self.stage.pack(start.x), start.theta
        self._schedule, self._max_halvings = schedule, max_halvings
        # what the inputs gave last; none within an interval
        self._asked: tuple[list[float], Floats] | None = ([], np.zeros((0, 0)))

    def __iter__(self) -> Iterator[tuple[Step, float, bool]]:
        """Go; see :class:`~phblocks.solvers.method.Walk`."""
        for t0, length, t1, save in itertools.islice(self._schedule.intervals(), self._intervals, None):
            yield from self._advance(t0, length, t1, save)

    def mark(self) -> dict[str, Floats] | None:
        """Return where it is; see :class:`~phblocks.solvers.method.Resumable`.

        Returns
        -------
        dict of str to numpy.ndarray or None
            For :meth:`resume`; ``None`` where it cannot be left.
        """
        if self._asked is None:
            return None
        counts = np.array([self._intervals, self.steps, self.halvings], dtype=np.int64)
        times, inputs = self._asked
        return {"counts": counts, "x": self._x, "theta": self._theta, "input_times": np.array(times), "inputs": inputs}

    def resume(self, mark: Mapping[str, Floats]) -> None:
        """Go there; see :class:`~phblocks.solvers.method.Resumable`.

        Parameters
        ----------
        mark : mapping of str to numpy.ndarray
            From :meth:`mark`.
        """
        self._stepper = self._prepare()
        self.stage = self._stepper.stage
        self._intervals, self.steps, self.halvings = map(int, mark["counts"])
        self._x, self._theta = mark["x"], mark["theta"]

    def _advance(self, t0: float, length: float, t1: float, save: bool) -> Iterator[tuple[Step, float, bool]]:
        """Go from t0 to t1 = t0 + length, in one step if possible."""
        done, parts = 0, 1  # the interval is cut into `parts`, of which `done` are behind us
        while done < parts:
            h = length / parts
            t = t0 + done * h
            times = [t + c * h for c in self._stepper.nodes]
            u = self._drive.at(times)
            step = self._stepper.step(self._x, self._theta, h, u)
            if step is None:
                if parts >= 2**self._max_halvings:
                    raise StepFailed(t, h, *failure(self.stage))
                done, parts = 2 * done, 2 * parts
                self.halvings += 1
                continue
            done += 1
            self._x, self._theta = step.x, step.theta
            self.steps += 1
            self._intervals += done == parts
            self._asked = (times, u) if done == parts else None
            yield step, t1 if done == parts else t0 + done * h, save and done == parts
            while parts > 1 and done % 2 == 0 and done < parts:
                done, parts = done // 2, parts // 2  # what is left is tried in longer steps again
