"""Simulations: arguments, and what is prepared for the time loop."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from contextlib import suppress
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from phblocks.assembly.justification import require_slow, warn_of_turns, watched
from phblocks.blocks.checks import require_real
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.files.journal import Journal
from phblocks.files.settings import Settings
from phblocks.files.stream import Stream
from phblocks.inputs import Drive, InputFailed, NotFinite, Signal
from phblocks.loop import Run, Seconds, require_resumable, walk_of
from phblocks.results.health import judged
from phblocks.results.limits import Limits, require_limits
from phblocks.results.recording import Recorder
from phblocks.results.solution import Solution
from phblocks.solvers.adaptive import Adaptive
from phblocks.solvers.discrete_gradient import DiscreteGradient
from phblocks.solvers.method import Integrator, Method
from phblocks.solvers.midpoint import Midpoint
from phblocks.solvers.projection import Projection
from phblocks.solvers.schedule import MANY, Schedule
from phblocks.system import State, System, consistent_start
from phblocks.system.states import require_state
from phblocks.triplets import real_array

#: A run of more steps is taken for a mistake in its arguments.
MOST_STEPS = 1e9
#: s. The inverse of a shorter step is no number any more once it was halved some times.
SHORTEST = 1e-200

#: At how many times the inputs are looked at before a run whose blocks must not spin.
SAMPLES = 33


def simulate(
    system: System,
    t_end: float,
    dt: float,
    method: Method | Integrator | None = None,
    start: State | None = None,
    inputs: Mapping[str, Signal] | None = None,
    save_every: int | None = None,
    max_halvings: int = 12,
    adaptive: Adaptive | None = None,
    times: ArrayLike | None = None,
    progress: bool | None = None,
    save: Stream | str | os.PathLike[str] | None = None,
    projection: Projection | None = None,
    limits: Limits | None = None,
) -> Solution:
    """Integrate a system in time.

    A start that violates constraints (joints with multipliers) is projected on them in the energy norm; the change
    of energy is in ``solution.statistics.start_energy_change``.

    A step that fails is repeated with half its length, and the halvings are counted; it is never accepted as it
    is. If halving does not help, the run ends with a status that says so and with the results so far. So it does in
    front of a step in which a J(x) of the user's is not skew, or an R(x) not positive semidefinite, and where a
    function given in ``inputs`` raises an exception, which is then ``solution.status.error``.

    Parameters
    ----------
    system : System
        The system.
    t_end : float
        Duration, s, at least dt.
    dt : float
        Step, s; the last one is shorter if dt does not divide t_end. The first step if the steps are adapted.
    method : Method or Integrator, optional
        Time method with its options; by default ``Midpoint()``, or ``DiscreteGradient()`` if the system has an energy
        that is not quadratic. Others: ``GaussLegendre``, ``RadauIIA``, ``LinearlyImplicit``, ``ScipyIVP``, or one of
        your own that satisfies :class:`~phblocks.solvers.method.Method`.
    start : State, optional
        Where to start from, see ``system.rigid_motion`` and ``solution.at``; the initial configuration at rest by
        default.
    inputs : mapping, optional
        For each exposed port (by the name given in ``expose``) a constant or a function of time, s; scalars for
        scalar ports, arrays of shape (dimension,) in the fixed frame for vectors. A force or moment that is not
        given is zero; an imposed velocity has to be given. Functions are of time alone: they are asked ahead of the
        run, for up to 4096 steps, and a step that fails asks for times before those again.
    save_every : int, optional
        Save every so many steps, each by default; balances are kept over all steps nevertheless.
    max_halvings : int, optional
        How often a failed step is halved before the run ends.
    adaptive : Adaptive, optional
        Adapt the steps to tolerances; energy is kept all the same.
    times : array_like, optional
        Save at these times, s, increasing, instead of every step, or besides every so many if ``save_every`` is given;
        the start and the end are saved too. Steps are shortened to end there, so that the states are as accurate as
        any others and balances are kept.
    progress : bool, optional
        Show a progress bar; by default if a terminal is attached and the run takes longer than a second.
    save : Stream, str or os.PathLike, optional
        Write the run to this file while it goes on, with checkpoints for :func:`phblocks.resume`, and keep only the
        current chunk in memory; needs h5py. See :class:`~phblocks.files.stream.Stream`.
    projection : Projection, optional
        Close loops every so many steps; the energy that this changes is in the ledger.
    limits : Limits, optional
        Above which numbers of ``solution.health`` a run that reached its end is warned of; ``Limits()`` by default,
        with 1e-2 for the balance if the method does not keep energy.

    Returns
    -------
    Solution
        Also of a run that ended early: see ``solution.status``.

    Raises
    ------
    DataError
        If a number is out of its range, or an input or a state has the wrong shape or an unknown name; with
        ``projection``, if an imposed motion may have displaced the start by what no state tells.
    ArgumentTypeError
        If the system or the method is not one, or an argument is of another wrong kind.
    MethodError
        If the method does not keep the energy of the system, or cannot be saved while it runs; if a loop cannot be
        closed.
    PrunedError
        If the start or an input moves what the system leaves out (``system.effects``).
    ApproximationError
        If large rotations are left out in a block that spins too fast for that.
    ResultFileError
        If there is a run in ``save`` already, or no place to write to.

    Warns
    -----
    ApproximationWarning
        If a block without large rotations turned by more than 0.1 rad.
    HealthWarning
        If the run reached its end and a number of ``solution.health`` is above its limit.
    """
    if not isinstance(system, System):
        raise ArgumentTypeError("simulate", expected="a System", got=type(system).__name__, fix="Call compile() first.")
    if system.n == 0:
        raise DataError(
            f"simulate system {system.name!r}",
            expected="a system with states",
            got="one without",
            fix="Add a block that can move or store something.",
        )
    if method is None:
        method = Midpoint() if system.quadratic else DiscreteGradient()
    if isinstance(method, type) or not isinstance(method, (Method, Integrator)):
        raise ArgumentTypeError(
            "simulate method",
            expected="a method such as ph.Midpoint()",
            got=repr(method),
            fix="Make one first.",
        )
    if adaptive is not None and (not isinstance(adaptive, Adaptive) or isinstance(method, Integrator)):
        raise ArgumentTypeError(
            "simulate adaptive",
            expected="options such as ph.Adaptive(), with a method that does not choose its steps itself",
            got=f"{adaptive!r} with {method!r}",
            fix="Make them first, or leave them out.",
        )
    if projection is not None and (not isinstance(projection, Projection) or isinstance(method, Integrator)):
        raise ArgumentTypeError(
            "simulate projection",
            expected="options such as ph.Projection(), with a method that does not choose its steps itself",
            got=f"{projection!r} with {method!r}",
            fix="Make them first, or leave them out.",
        )
    given = require_limits("simulate limits", limits)
    _require_time("dt", dt, 0.0)
    _require_time("t_end", t_end, dt)
    every = 1 if save_every is None else save_every
    for name, value, least in (("save_every", every, 1), ("max_halvings", max_halvings, 0)):
        wrong = isinstance(value, bool) or not isinstance(value, (int, np.integer))
        if wrong or value < least:
            error = ArgumentTypeError if wrong else DataError
            raise error(f"simulate {name}", expected=f"an integer >= {least}", got=repr(value), fix="Correct it.")
    if t_end > MOST_STEPS * dt:
        raise DataError(
            "simulate dt",
            expected=f"at most {MOST_STEPS:g} steps in a run",
            got=f"t_end = {t_end!r} and dt = {dt!r}",
            fix="t_end comes first, then dt, both in s.",
        )
    chosen = None if times is None else _require_times(times, t_end)
    schedule = Schedule(float(t_end), float(dt), int(every), chosen, steps_too=save_every is not None)
    settings = Settings(schedule, method, int(max_halvings), adaptive, projection)
    allowed = given or Limits.suited(settings.keeps_energy)
    state = system.start if start is None else require_state(system, start, "simulate start")
    state = state if system.quadratic else State(system.settled(state.x), state.theta, state.points)
    drive = Drive(system, {} if inputs is None else inputs)
    clock = perf_counter()
    change = 0.0
    with suppress(NotFinite, InputFailed):  # a step will say so
        if watched(system):
            require_slow(system, state, drive.at(np.linspace(0.0, t_end, SAMPLES).tolist()))
    with suppress(NotFinite, InputFailed):
        if system.is_dae:
            state, change = consistent_start(system, state, drive.at([0.0])[0])
    stream = save if save is None or isinstance(save, Stream) else Stream(save)
    walk = walk_of(settings, system, drive, state, MANY if stream is None else stream.chunk)
    recorder = Recorder(system, walk.stage, walk.weights, walk.nodes, 0.0, state)
    run = Run(system, settings, walk, recorder, Seconds(perf_counter() - clock, 0.0, change))
    if stream is None:
        solution = judged(run.carry_out(progress, None), allowed)
        warn_of_turns(system, solution.recording.theta)
        return solution
    require_resumable(walk, settings)
    journal = Journal.create(stream)
    try:
        run.begin(journal)
    except BaseException:
        journal.close()
        raise
    solution = judged(run.carry_out(progress, journal), allowed)
    if watched(system):
        warn_of_turns(system, solution.recording.theta)
    return solution


def _require_times(times: ArrayLike, t_end: float) -> tuple[float, ...]:
    """Check times to be saved; append the end."""
    array = real_array(times)
    if array is None:
        raise ArgumentTypeError("simulate times", expected="numbers, s", got=repr(times), fix="Give a list of times.")
    flat = np.atleast_1d(array)
    fine = flat.ndim == 1 and np.isfinite(flat).all() and (np.diff(flat) > 0.0).all()
    if not fine or (flat.size and not (flat[0] > 0.0 and flat[-1] <= t_end)):
        raise DataError(
            "simulate times",
            expected=f"increasing times after 0 s and up to t_end = {t_end!r} s",
            got=repr(times),
            fix="Sort them; the start is saved anyway.",
        )
    inside = [float(t) for t in flat if t < t_end * (1.0 - 1e-12)]
    return (*inside, float(t_end))


def _require_time(name: str, value: object, least: float) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ArgumentTypeError(f"simulate {name}", expected="a number, s", got=repr(value), fix="Give seconds.")
    number = require_real(f"simulate {name}", value)
    enough = number > SHORTEST if least == 0.0 else number >= least
    if not (math.isfinite(number) and enough):
        expected = f"a time > 0 s, above {SHORTEST:g} s" if least == 0.0 else f"at least one step, {least} s"
        raise DataError(f"simulate {name}", expected=expected, got=repr(value), fix="Correct it.")
