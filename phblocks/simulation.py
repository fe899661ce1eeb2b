"""The time loop."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike
from tqdm import tqdm

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.inputs import Drive, NotFinite
from phblocks.results.recording import Recorder
from phblocks.results.solution import Solution
from phblocks.results.status import Statistics, Status
from phblocks.solvers.discrete_gradient import DiscreteGradient
from phblocks.solvers.midpoint import Midpoint, MidpointStepper
from phblocks.solvers.step import Step
from phblocks.system import State, System, consistent_start
from phblocks.system.states import require_state
from phblocks.triplets import Floats

#: A run of more steps is taken for a mistake in its arguments.
MOST_STEPS = 1e9

Signal = Callable[[float], ArrayLike] | ArrayLike


def simulate(
    system: System,
    t_end: float,
    dt: float,
    method: Midpoint | DiscreteGradient | None = None,
    start: State | None = None,
    inputs: Mapping[str, Signal] | None = None,
    save_every: int = 1,
    max_halvings: int = 12,
    progress: bool | None = None,
) -> Solution:
    """Integrate a system in time.

    A start that violates constraints (joints with multipliers) is projected on them in the energy norm; the change
    of energy is in ``solution.statistics.start_energy_change``.

    A step that fails is repeated with half its length, and the halvings are counted; it is never accepted as it
    is. If halving does not help, the run ends with a status that says so and with the results so far.

    Parameters
    ----------
    system : System
        The system.
    t_end : float
        Duration, s, at least dt.
    dt : float
        Step, s; the last one is shorter if dt does not divide t_end.
    method : Midpoint or DiscreteGradient, optional
        Time method with its options; by default ``Midpoint()``, or ``DiscreteGradient()`` if the system has an energy
        that is not quadratic.
    start : State, optional
        Where to start from, see ``system.rigid_motion`` and ``solution.at``; the initial configuration at rest by
        default.
    inputs : mapping, optional
        For each exposed port (by the name given in ``expose``) a constant or a function of time, s; scalars for
        scalar ports, arrays of shape (dimension,) in the fixed frame for vectors. A force or moment that is not
        given is zero; an imposed velocity has to be given.
    save_every : int, optional
        Save every so many steps; balances are kept over all steps nevertheless.
    max_halvings : int, optional
        How often a failed step is halved before the run ends.
    progress : bool, optional
        Show a progress bar; by default if a terminal is attached and the run takes longer than a second.

    Returns
    -------
    Solution
        Also of a run that ended early: see ``solution.status``.

    Raises
    ------
    DataError
        If a number is out of its range, or an input or a state has the wrong shape or an unknown name.
    ArgumentTypeError
        If the system or the method is not one, or an argument is of another wrong kind.
    MethodError
        If the method does not keep the energy of the system.
    StructureError
        If a J(x) or R(x) of the user's is not skew, or not positive semidefinite, at a step.
    """
    if not isinstance(system, System):
        raise ArgumentTypeError("simulate", expected="a System", got=type(system).__name__, fix="Call compile() first.")
    if method is None:
        method = Midpoint() if system.quadratic else DiscreteGradient()
    if not isinstance(method, (Midpoint, DiscreteGradient)):
        raise ArgumentTypeError(
            "simulate method",
            expected="a method such as ph.Midpoint()",
            got=repr(method),
            fix="Make one first.",
        )
    _require_time("dt", dt, 0.0)
    _require_time("t_end", t_end, dt)
    for name, value, least in (("save_every", save_every, 1), ("max_halvings", max_halvings, 0)):
        wrong = isinstance(value, bool) or not isinstance(value, (int, np.integer))
        if wrong or value < least:
            error = ArgumentTypeError if wrong else DataError
            raise error(f"simulate {name}", expected=f"an integer >= {least}", got=repr(value), fix="Correct it.")
    state = system.start if start is None else require_state(system, start, "simulate start")
    state = state if system.quadratic else State(system.settled(state.x), state.theta, state.points)
    drive = Drive(system, {} if inputs is None else inputs)
    clock = perf_counter()
    change = 0.0
    if system.is_dae:
        with suppress(NotFinite):  # the first step will say so
            state, change = consistent_start(system, state, drive.at([0.0])[0])
    stepper = method.prepare(system)
    recorder = Recorder(system, stepper.stage, stepper.weights, 0.0, state)
    run = _Run(stepper, drive, stepper.stage.pack(state.x), state.theta, max_halvings)
    if t_end > MOST_STEPS * dt:
        raise DataError(
            "simulate dt",
            expected=f"at most {MOST_STEPS:g} steps in a run",
            got=f"t_end = {t_end!r} and dt = {dt!r}",
            fix="t_end comes first, then dt, both in s.",
        )
    steps = max(1, math.ceil(t_end / dt - 1e-9))
    preparation, clock = perf_counter() - clock, perf_counter()
    with tqdm(
        total=steps,
        desc=system.name,
        unit="step",
        delay=1.0,
        disable=None if progress is None else not progress,
    ) as bar:
        for k in range(steps):
            t0, t1 = k * dt, t_end if k == steps - 1 else (k + 1) * dt
            save = (k + 1) % save_every == 0 or k == steps - 1
            # the differences of times vary by round-off, which would cost a linear system its kept factor
            h = dt if abs(t1 - t0 - dt) <= 1e-9 * dt else t1 - t0
            if not run.advance(t0, h, t1, recorder, save):
                break
            bar.update()
    recording = recorder.finish()
    statistics = Statistics(
        steps=run.steps,
        halvings=run.halvings,
        newton_iterations=np.array(run.iterations, dtype=np.int64),
        preparation_seconds=preparation,
        loop_seconds=perf_counter() - clock,
        start_energy_change=change,
    )
    return Solution(system, recording, run.status, statistics)


@dataclass
class _Run:
    """The state of a run and how it goes on."""

    stepper: MidpointStepper
    drive: Drive
    x: Floats
    theta: Floats
    max_halvings: int
    steps: int = 0
    halvings: int = 0

    def __post_init__(self) -> None:
        self.iterations: list[int] = []
        self.status = Status.success()

    def advance(self, t0: float, length: float, t1: float, recorder: Recorder, save: bool) -> bool:
        """Go from t0 to t1 = t0 + length, in one step if possible; say whether t1 was reached."""
        done, parts, t = 0, 1, t0  # the interval is cut into `parts`, of which `done` are behind us
        while done < parts:
            h = length / parts
            t = t0 + done * h
            try:
                u = self.drive.at([t + c * h for c in self.stepper.nodes])
            except NotFinite as error:
                self.status = Status.input_not_finite(error.time, error.name)
                recorder.save_last(t)
                return False
            step = self.stepper.step(self.x, self.theta, h, u)
            if step is None:
                if parts >= 2**self.max_halvings:
                    self.status = Status.step_failed(t, h)
                    recorder.save_last(t)
                    return False
                done, parts = 2 * done, 2 * parts
                self.halvings += 1
                continue
            done += 1
            self._accept(step, recorder, t1 if save and done == parts else None)
            while parts > 1 and done % 2 == 0 and done < parts:
                done, parts = done // 2, parts // 2  # what is left is tried in longer steps again
        return True

    def _accept(self, step: Step, recorder: Recorder, save_at: float | None) -> None:
        self.x, self.theta = step.x, step.theta
        self.steps += 1
        self.iterations.append(step.iterations)
        recorder.add(step, save_at)


def _require_time(name: str, value: object, least: float) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ArgumentTypeError(f"simulate {name}", expected="a number, s", got=repr(value), fix="Give seconds.")
    enough = float(value) > 0.0 if least == 0.0 else float(value) >= least
    if not (math.isfinite(float(value)) and enough):
        expected = "a time > 0 s" if least == 0.0 else f"at least one step, {least} s"
        raise DataError(f"simulate {name}", expected=expected, got=repr(value), fix="Correct it.")
