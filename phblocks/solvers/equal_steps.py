"""The way of a run through time in equal steps."""

from __future__ import annotations

from collections.abc import Iterator

from phblocks.inputs import Drive
from phblocks.solvers.method import Stepper
from phblocks.solvers.schedule import Schedule
from phblocks.solvers.step import Step, StepFailed
from phblocks.triplets import Floats


class EqualSteps:
    """Goes through a schedule in its steps; one that fails is repeated in halves.

    Parameters
    ----------
    stepper : Stepper
        Takes the steps.
    drive : Drive
        The inputs.
    x, theta : numpy.ndarray
        Unknowns and rotation states at the start.
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
        self, stepper: Stepper, drive: Drive, x: Floats, theta: Floats, schedule: Schedule, max_halvings: int
    ) -> None:
        self.stage, self.weights, self.nodes = stepper.stage, stepper.weights, stepper.nodes
        self.steps = self.halvings = 0
        self._stepper, self._drive, self._x, self._theta = stepper, drive, x, theta
        self._schedule, self._max_halvings = schedule, max_halvings

    def __iter__(self) -> Iterator[tuple[Step, float, bool]]:
        """Go; see :class:`~phblocks.solvers.method.Walk`."""
        for t0, length, t1, save in self._schedule.intervals():
            yield from self._advance(t0, length, t1, save)

    def _advance(self, t0: float, length: float, t1: float, save: bool) -> Iterator[tuple[Step, float, bool]]:
        """Go from t0 to t1 = t0 + length, in one step if possible."""
        done, parts = 0, 1  # the interval is cut into `parts`, of which `done` are behind us
        while done < parts:
            h = length / parts
            t = t0 + done * h
            u = self._drive.at([t + c * h for c in self._stepper.nodes])
            step = self._stepper.step(self._x, self._theta, h, u)
            if step is None:
                if parts >= 2**self._max_halvings:
                    raise StepFailed(t, h, getattr(self.stage, "why", "the method found no solution"))
                done, parts = 2 * done, 2 * parts
                self.halvings += 1
                continue
            done += 1
            self._x, self._theta = step.x, step.theta
            self.steps += 1
            yield step, t1 if done == parts else t0 + done * h, save and done == parts
            while parts > 1 and done % 2 == 0 and done < parts:
                done, parts = done // 2, parts // 2  # what is left is tried in longer steps again
