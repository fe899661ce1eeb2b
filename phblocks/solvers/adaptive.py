"""Steps adapted to tolerances, for every one-step method."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from phblocks.errors import ArgumentTypeError, DataError, UnknownNameError
from phblocks.inputs import Drive
from phblocks.solvers.method import Booked, Stepper
from phblocks.solvers.schedule import Schedule
from phblocks.solvers.step import Step, StepFailed, Steps, failure
from phblocks.system import State, System
from phblocks.triplets import Floats

SAFETY, LEAST_FACTOR, MOST_FACTOR = 0.9, 0.2, 4.0


@dataclass(frozen=True)
class Adaptive:
    """Step control: each step is compared with two of half its length, which are what the run goes on with.

    The difference, divided by ``2^order - 1``, estimates the error of the two halves. It is measured in the energy
    norm, ``sqrt(1/2 d^T E d)`` (with the Hessian, eigenvalues taken positive, where the energy is not quadratic),
    against ``atol + rtol`` times the largest norm of the state so far, or on named outputs against ``atol + rtol``
    times the largest size of each so far, at the ends of rejected steps too: a run that starts at rest would not start
    otherwise, and starts with short steps unless atol is given. A PI controller chooses the next step. Energy is kept
    exactly whatever the steps, because every accepted step is one of the method. Costs half as many steps again as the
    same steps without control.

    Parameters
    ----------
    rtol : float, optional
        Relative tolerance of the error of a step.
    atol : float, optional
        Absolute tolerance, J^(1/2) or in the units of the outputs.
    outputs : tuple of str, optional
        Names among ``system.output_names`` that are watched instead of the energy norm.
    shortest, longest : float, optional
        Limits of the step, s. A run that asks for shorter steps ends with a status.

    Raises
    ------
    DataError
        If a value is out of its range.
    ArgumentTypeError
        If a value is of the wrong kind.

    Notes
    -----
    K. Gustafsson, Control theoretic techniques for stepsize selection in explicit Runge-Kutta methods,
    doi:10.1145/210232.210242; E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.4.
    """

    rtol: float = 1e-3
    atol: float = 0.0
    outputs: tuple[str, ...] = ()
    shortest: float = 1e-12
    longest: float = math.inf

    def __post_init__(self) -> None:
        """Check the values."""
        for name in ("rtol", "atol", "shortest", "longest"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
                raise ArgumentTypeError(f"Adaptive {name}", expected="a number", got=repr(value), fix="Correct it.")
            if not value >= 0.0:
                raise DataError(f"Adaptive {name}", expected="a number >= 0", got=repr(value), fix="Correct it.")
        if not 0.0 < self.rtol + self.atol < math.inf:
            raise DataError(
                "Adaptive rtol, atol", expected="one > 0", got=repr((self.rtol, self.atol)), fix="Use rtol=1e-3."
            )
        if not 0.0 < self.shortest <= self.longest:
            raise DataError(
                "Adaptive shortest, longest",
                expected="0 < shortest <= longest",
                got=repr((self.shortest, self.longest)),
                fix="Correct them.",
            )
        if not isinstance(self.outputs, (tuple, list)) or not all(isinstance(name, str) for name in self.outputs):
            raise ArgumentTypeError(
                "Adaptive outputs", expected="names of outputs", got=repr(self.outputs), fix='Write ("tip velocity",).'
            )


class ErrorNorm:
    """Measures errors against tolerances.

    Parameters
    ----------
    system : System
        The system.
    options : Adaptive
        Tolerances and outputs.

    Attributes
    ----------
    largest : numpy.ndarray
        The largest norm, or the largest size of each output, so far.
    """

    def __init__(self, system: System, options: Adaptive) -> None:
        self._system, self._options = system, options
        names = list(system.output_names)
        for name in options.outputs:
            if name not in names:
                raise UnknownNameError(
                    "Adaptive outputs",
                    expected=f"one of {', '.join(names) or '(there are none)'}",
                    got=repr(name),
                    fix="Use system.output_names.",
                )
        self._watched = [names.index(name) for name in options.outputs]
        self.largest = np.zeros(max(1, len(self._watched)))

    def __call__(self, coarse: tuple[Floats, Floats], fine: tuple[Floats, Floats]) -> float:
        """Compare two states with their orientations.

        Parameters
        ----------
        coarse, fine : tuple of numpy.ndarray
            States and rotation states, shapes (n,) and (n_theta,).

        Returns
        -------
        float
            Their difference as a multiple of what is allowed.
        """
        if self._watched:
            rough, value = (self._system.G(theta, x).T[self._watched] @ x for x, theta in (coarse, fine))
            error, size = np.abs(rough - value), np.abs(value)
        else:
            error, size = (np.array([self._energy_norm(d, fine[0])]) for d in (coarse[0] - fine[0], fine[0]))
        self.largest = np.maximum(self.largest, np.where(np.isfinite(size), size, 0.0))
        allowed = self._options.atol + self._options.rtol * self.largest
        return float(np.max(error / np.maximum(allowed, np.finfo(float).tiny)))

    def _energy_norm(self, d: Floats, x: Floats) -> float:
        energy = 0.5 * float(d @ (self._system.E @ d))
        for storage in self._system.storages:
            values, vectors = np.linalg.eigh(np.asarray(storage.hessian(x[storage.energy])))
            energy += 0.5 * float(np.abs(values) @ (vectors.T @ d[storage.energy]) ** 2)
        return float(np.sqrt(energy))


class AdaptiveSteps:
    """Goes to the end of a schedule in steps adapted to tolerances.

    Parameters
    ----------
    prepare : callable
        Makes a stepper, which takes the steps.
    drive : Drive
        The inputs.
    start : State
        Where it starts.
    schedule : Schedule
        The times; its dt is the first step.
    norm : ErrorNorm
        Measures errors.
    order : int
        Of the method.
    limits : tuple of float
        Shortest and longest step, s.

    Attributes
    ----------
    stage, weights, nodes
        Of the stepper.
    steps, halvings, rejections : int
        Counts.
    """

    def __init__(
        self,
        prepare: Callable[[], Stepper],
        drive: Drive,
        start: State,
        schedule: Schedule,
        norm: ErrorNorm,
        order: int,
        limits: tuple[float, float],
    ) -> None:
        self._prepare, self._stepper = prepare, prepare()
        self.stage, self.weights, self.nodes = self._stepper.stage, self._stepper.weights, self._stepper.nodes
        self.steps = self.halvings = self.rejections = self._count = 0
        self._drive, self._x, self._theta = drive, self.stage.pack(start.x), start.theta
        self._t, self._h, self._last_error = 0.0, min(schedule.dt, limits[1]), 1.0
        self._asked: tuple[list[float], Floats] = ([], np.zeros((0, 0)))
        self._whole = True  # not between the halves of a step
        self._schedule, self._norm, self._order, self._limits = schedule, norm, order, limits

    def __iter__(self) -> Iterator[Booked]:
        """Go; see :class:`~phblocks.solvers.method.Walk`."""
        schedule = self._schedule
        for target in schedule.times or (schedule.t_end,):
            while self._t < target:
                t, h, room = self._t, self._h, target - self._t
                # a rest of less than a step is taken at once or in two, never as a splinter
                length = room if h >= room * (1.0 - 1e-9) else min(h, 0.5 * room)
                pair, error = self._attempt(t, length)
                if not error <= 1.0:
                    self._h = length * self._factor(error, 1.0)
                    if self._h < self._limits[0]:
                        why = "the tolerances ask for shorter steps than are allowed"
                        raise StepFailed(t, length, why) if pair else StepFailed(t, length, *failure(self.stage))
                    continue
                self._t, self._count = target if length == room else t + length, self._count + 1
                self._x, self._theta = pair[1].x, pair[1].theta
                proposed = length * self._factor(error, self._last_error)
                self._h = min(max(proposed, h) if length < h else proposed, self._limits[1])
                self._last_error = max(error, 1e-4)
                self.steps, self._whole = self.steps + 1, False
                yield Steps.of(pair[0]), np.array([t + 0.5 * length]), np.array([False])
                self.steps, self._whole = self.steps + 1, True
                saved = self._t == target or schedule.saves(self._count)
                yield Steps.of(pair[1]), np.array([self._t]), np.array([saved])

    def mark(self) -> dict[str, Floats] | None:
        """Return where it is; see :class:`~phblocks.solvers.method.Resumable`.

        Returns
        -------
        dict of str to numpy.ndarray or None
            For :meth:`resume`; ``None`` where it cannot be left.
        """
        if not self._whole:
            return None
        times, inputs = self._asked
        return {
            "counts": np.array([self._count, self.steps, self.halvings, self.rejections], dtype=np.int64),
            "control": np.array([self._t, self._h, self._last_error]),
            "largest": self._norm.largest,
            "x": self._x,
            "theta": self._theta,
            "input_times": np.array(times),
            "inputs": inputs,
        }

    def resume(self, mark: Mapping[str, Floats]) -> None:
        """Go there; see :class:`~phblocks.solvers.method.Resumable`.

        Parameters
        ----------
        mark : mapping of str to numpy.ndarray
            From :meth:`mark`.
        """
        self._stepper = self._prepare()
        self.stage = self._stepper.stage
        self._count, self.steps, self.halvings, self.rejections = map(int, mark["counts"])
        self._t, self._h, self._last_error = map(float, mark["control"])
        self._norm.largest = mark["largest"]
        self._x, self._theta = mark["x"], mark["theta"]

    def _factor(self, error: float, last: float) -> float:
        """How much longer the next step may be: Gustafsson's PI controller."""
        if error == 0.0:
            return MOST_FACTOR
        if not math.isfinite(error):  # no step, or one of a method of the user's that left all bounds
            return LEAST_FACTOR
        k = 1.0 / (self._order + 1)
        return float(np.clip(SAFETY * error ** (-0.7 * k) * last ** (0.4 * k), LEAST_FACTOR, MOST_FACTOR))

    def _attempt(self, t: float, length: float) -> tuple[list[Step], float]:
        """Two half steps and their error; no steps and an infinite error if there is no convergence."""
        whole = self._step(self._x, self._theta, t, length)
        pair: list[Step] = []
        x, theta = self._x, self._theta
        for i in range(2 if whole else 0):
            step = self._step(x, theta, t + 0.5 * i * length, 0.5 * length)
            if step is None:
                break
            pair.append(step)
            x, theta = step.x, step.theta
        if whole is None or len(pair) < 2:
            self.halvings += 1
            return [], math.inf
        unpack = self.stage.unpack
        error = self._norm((unpack(whole.x), whole.theta), (unpack(x), theta)) / (2**self._order - 1)
        self.rejections += not error <= 1.0
        return pair, error

    def _step(self, x: Floats, theta: Floats, t: float, h: float) -> Step | None:
        times = [t + c * h for c in self._stepper.nodes]
        u = self._drive.at(times)
        self._asked = times, u
        return self._stepper.step(x, theta, h, u)
