"""The way of a run through time in equal steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from phblocks.inputs import Drive
from phblocks.solvers.method import Booked, Marching, Stepper
from phblocks.solvers.schedule import MANY, Schedule
from phblocks.solvers.step import StepFailed, Steps, failure
from phblocks.system import State
from phblocks.triplets import Floats


class EqualSteps:
    """Goes through a schedule in its steps, several at a time if the stepper can; one that fails is repeated in halves.

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
    longest : int, optional
        The largest number of steps at a time.

    Attributes
    ----------
    stage, weights, nodes
        Of the stepper.
    steps, halvings, rejections : int
        Counts.
    """

    rejections = 0

    def __init__(
        self,
        prepare: Callable[[], Stepper],
        drive: Drive,
        start: State,
        schedule: Schedule,
        max_halvings: int,
        longest: int = MANY,
    ) -> None:
        self._prepare, self._stepper = prepare, prepare()
        self.stage, self.weights, self.nodes = self._stepper.stage, self._stepper.weights, self._stepper.nodes
        self.steps = self.halvings = self._intervals = 0
        self._drive, self._x, self._theta = drive, self.stage.pack(start.x), start.theta
        self._schedule, self._max_halvings, self._longest = schedule, max_halvings, longest
        # what the inputs gave last; none within an interval
        self._asked: tuple[list[float], Floats] | None = ([], np.zeros((0, 0)))

    def __iter__(self) -> Iterator[Booked]:
        """Go; see :class:`~phblocks.solvers.method.Walk`."""
        stepper = self._stepper
        if self._longest == 1 or not isinstance(stepper, Marching):
            for interval in self._schedule.intervals(self._intervals):
                yield from self._advance(*interval)
            return
        for begin, length, end, saved in self._schedule.stretches(self._intervals, self._longest):
            times = begin[:, None] + length * np.array(self.nodes)
            values, wrong = self._drive.ahead(times.ravel())
            whole = len(values) // len(self.nodes)  # steps that know all their inputs
            u = values[: whole * len(self.nodes)].reshape(whole, len(self.nodes), values.shape[1])
            done, alone = 0, False
            while done < begin.size:
                if done == whole and wrong is not None:
                    raise wrong
                steps = None if alone else stepper.march(self._x, self._theta, length, u[done:])
                if steps is None:
                    before = self.halvings
                    yield from self._advance(begin[done], length, end[done], saved[done], u[done])
                    done, alone = done + 1, self.halvings > before
                    continue
                taken = slice(done, done + len(steps))
                done, alone = taken.stop, taken.stop < whole
                self._x, self._theta = steps.last.x, steps.last.theta
                self.steps, self._intervals = self.steps + len(steps), self._intervals + len(steps)
                self._asked = times[done - 1].tolist(), steps.u[-1]
                yield steps, end[taken], saved[taken]

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

    def _advance(
        self, t0: float, length: float, t1: float, save: bool, known: Floats | None = None
    ) -> Iterator[Booked]:
        """Go from t0 to t1 = t0 + length, in one step if possible, for which the inputs may be known."""
        done, parts = 0, 1  # the interval is cut into `parts`, of which `done` are behind us
        while done < parts:
            h = length / parts
            t = t0 + done * h
            times = [t + c * h for c in self._stepper.nodes]
            u = self._drive.at(times) if known is None else known
            known = None
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
            at, last = (t1, save) if done == parts else (t0 + done * h, False)
            yield Steps.of(step), np.array([at]), np.array([last])
            while parts > 1 and done % 2 == 0 and done < parts:
                done, parts = done // 2, parts // 2  # what is left is tried in longer steps again
