"""The time loop."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from time import perf_counter

import numpy as np

from phblocks.errors import MethodError, ResultFileError, StructureError
from phblocks.files.access import solution_of
from phblocks.files.journal import Journal
from phblocks.files.settings import Settings
from phblocks.files.stored import Stored, path_of
from phblocks.inputs import Drive, InputFailed, NotFinite
from phblocks.results.recording import STEPS, Recorder, Recording
from phblocks.results.solution import Solution
from phblocks.results.status import Statistics, Status
from phblocks.solvers.adaptive import AdaptiveSteps, ErrorNorm
from phblocks.solvers.equal_steps import EqualSteps
from phblocks.solvers.method import Booked, Integrator, Resumable, Walk
from phblocks.solvers.projection import ProjectedSteps
from phblocks.solvers.schedule import MANY, together
from phblocks.solvers.step import SAFE, StepFailed, Steps
from phblocks.system import State, System
from phblocks.triplets import Floats

#: Why a run ends before such states.
TOO_LARGE = "states or their energy are too large for floating-point numbers"


def walk_of(settings: Settings, system: System, drive: Drive, start: State, chunk: int = MANY) -> Walk:
    """Prepare the way through time.

    Parameters
    ----------
    settings : Settings
        What is asked for.
    system : System
        The system.
    drive : Drive
        The inputs.
    start : State
        Where it starts.
    chunk : int, optional
        It can be left after so many steps.

    Returns
    -------
    Walk
        From the start.
    """
    method, schedule = settings.method, settings.schedule
    if isinstance(method, Integrator):
        return method.integrate(system, drive, start, schedule)

    walk: EqualSteps | AdaptiveSteps
    if settings.adaptive is None:
        longest = together(system.n, chunk) if settings.projection is None else 1
        walk = EqualSteps(lambda: method.prepare(system), drive, start, schedule, settings.max_halvings, longest)
    else:
        adaptive = settings.adaptive
        norm, limits = ErrorNorm(system, adaptive), (adaptive.shortest, adaptive.longest)
        walk = AdaptiveSteps(lambda: method.prepare(system), drive, start, schedule, norm, method.order, limits)
    return walk if settings.projection is None else ProjectedSteps(walk, system, drive, start, settings.projection)


def require_resumable(walk: Walk, settings: Settings) -> Resumable:
    """Return a walk if it can be left and resumed.

    Parameters
    ----------
    walk : Walk
        The candidate.
    settings : Settings
        With its method, for the message.

    Returns
    -------
    Resumable
        The walk.

    Raises
    ------
    MethodError
        If it cannot.
    """
    if isinstance(walk, Resumable):
        return walk
    raise MethodError(
        "simulate save",
        expected="a method whose walk can be left and resumed",
        got=f"{type(walk).__name__} of {settings.method!r}",
        fix="Give its walk mark and resume (phblocks.solvers.method.Resumable), or leave out save.",
    )


@dataclass
class Seconds:
    """What a run took besides its steps, in all its sessions.

    Parameters
    ----------
    preparation_seconds, loop_seconds : float
        Time before and in the time loop, s.
    start_energy_change : float
        Of the projection of the start, J.
    """

    preparation_seconds: float
    loop_seconds: float
    start_energy_change: float


@dataclass
class Run:
    """A run that is about to begin, or to go on.

    Parameters
    ----------
    system : System
        The system.
    settings : Settings
        What is asked for.
    walk : Walk
        The way through time.
    recorder : Recorder
        What is kept of it.
    seconds : Seconds
        What it took so far.
    t : float
        Where it is, s.
    """

    system: System
    settings: Settings
    walk: Walk
    recorder: Recorder
    seconds: Seconds
    t: float = 0.0

    def carry_out(self, progress: bool | None, journal: Journal | None) -> Solution:
        """Go all the way, or as far as it goes.

        Parameters
        ----------
        progress : bool or None
            Show a progress bar; if ``None``, on a terminal and if it takes longer than a second.
        journal : Journal or None
            Where it is written.

        Returns
        -------
        Solution
            With a status.
        """
        try:
            status = self._go(progress, self._steps(journal))
            return self._in_memory(status) if journal is None else self._on_disk(status, journal)
        finally:
            if journal is not None:
                journal.close()

    def begin(self, journal: Journal) -> None:
        """Write what the run is about, and where it starts.

        Parameters
        ----------
        journal : Journal
            Where it is written.

        Raises
        ------
        MethodError
            If the method cannot leave checkpoints.
        ResultFileError
            If it cannot be written.
        """
        mark, recorder = require_resumable(self.walk, self.settings).mark(), self.recorder
        assert mark is not None
        drained = recorder.drain()
        journal.begin(self.system, self.settings, drained, recorder.worst, self._totals(), self._checkpoint(mark))

    def _go(self, progress: bool | None, steps: Iterator[Booked]) -> Status:
        from tqdm import tqdm

        bar = tqdm(
            total=self.settings.schedule.t_end,
            initial=self.t,
            desc=self.system.name,
            delay=1.0,
            disable=None if progress is None else not progress,
            bar_format="{l_bar}{bar}| {n:.4g}/{total:.4g} s [{elapsed}<{remaining}]",
        )
        status, clock = Status.success(), perf_counter()
        with bar:
            try:
                for taken, at, saved in steps:
                    sound = _count_sound(taken)
                    if sound:
                        self.recorder.add(taken.first(sound), at[:sound], saved[:sound])
                        bar.update(at[sound - 1] - self.t)
                        self.t = float(at[sound - 1])
                    if sound < len(taken):
                        raise StepFailed(self.t, float(taken.dt[sound]), TOO_LARGE)
            except NotFinite as error:
                status = Status.input_not_finite(error.time, error.name)
            except InputFailed as error:
                status = Status.input_failed(error.time, error.name, error.error)
            except StructureError as error:
                status = Status.structure_lost(self.t, error)
            except StepFailed as error:
                status = Status.step_failed(error.time, error.dt, error.why, error.state)
            except _NotWritten as error:
                status = Status.not_written(self.t, error.path, error.error)
        if not status.ok:
            self.recorder.save_last(self.t)
        self.seconds.loop_seconds += perf_counter() - clock
        return status

    def _steps(self, journal: Journal | None) -> Iterator[Booked]:
        """All steps; at the end of each chunk it is written, and the walk begins anew."""
        walk, going = self.walk, True
        if journal is None:
            yield from walk
            return
        assert isinstance(walk, Resumable)
        while going:
            going, before = False, walk.steps
            for item in walk:
                yield item
                full = walk.steps - before >= journal.chunk and self.t < self.settings.schedule.t_end
                if full and (mark := walk.mark()) is not None:
                    drained = self.recorder.drain()
                    with _telling(journal):
                        journal.write(drained, self.recorder.worst, self._totals(), checkpoint=self._checkpoint(mark))
                    walk.resume(mark)
                    self.recorder.stage, going = walk.stage, True
                    break

    def _in_memory(self, status: Status) -> Solution:
        clock = perf_counter()
        recording, steps = self.recorder.finish()
        self.seconds.loop_seconds += perf_counter() - clock
        return Solution(self.system, recording, status, self._statistics(steps))

    def _on_disk(self, status: Status, journal: Journal) -> Solution:
        """Write what is left and gather the chunks; what cannot be written stays in memory."""
        worst, totals = self.recorder.worst, self._totals()
        rest, stored = self.recorder.drain(last=True), None
        if journal.pending:
            rest = {name: np.concatenate([journal.pending[path_of(name)], rest[name]]) for name in rest}
        else:
            try:
                worst, totals = self.recorder.worst, self._totals()
                with _telling(journal):
                    journal.write(rest, worst, totals, status=status)
                    rest = {}
                    stored = journal.gather()
            except _NotWritten as error:
                status = Status.not_written(self.t, error.path, error.error)
        try:
            stored = stored or Stored.open(journal.path)
        except ResultFileError:  # the folder is gone
            rest = rest or self.recorder.drain(last=True)
            return Solution(self.system, Recording.of(rest, worst), status, self._statistics(rest))
        stored.pending = {path_of(name): array for name, array in rest.items()}
        stored.worst, stored.totals = worst, totals
        return solution_of(stored, self.system, status)

    def _checkpoint(self, mark: Mapping[str, Floats]) -> tuple[Mapping[str, Floats], Mapping[str, Floats], float]:
        return mark, self.recorder.memory(), self.t

    def _totals(self) -> dict[str, float]:
        walk = self.walk
        counts: dict[str, float] = {"steps": walk.steps, "halvings": walk.halvings, "rejections": walk.rejections}
        if isinstance(walk, ProjectedSteps):
            counts |= {"projections": walk.projections, "largest_gap": walk.largest_gap}
            counts["projection_energy_change"] = walk.energy_change
        return {**counts, **asdict(self.seconds)}

    def _statistics(self, steps: Mapping[str, Floats]) -> Statistics:
        return Statistics(**self._totals(), **{name: steps[name] for name in STEPS})  # type: ignore[arg-type]


def _count_sound(steps: Steps) -> int:
    """How many steps there are before the states after one, or their energy, are too large for a number."""
    x = steps.x
    if max(x.max(), -x.min()) < SAFE:
        return len(steps)
    with np.errstate(all="ignore"):
        sound = np.isfinite(np.square(x).sum(axis=1))
    return len(steps) if sound.all() else int(sound.argmin())


class _NotWritten(Exception):
    """Results cannot be written; ends the run with a status."""

    def __init__(self, path: str, error: OSError) -> None:
        super().__init__(f"{path}: {error}")
        self.path, self.error = path, error


@contextmanager
def _telling(journal: Journal) -> Iterator[None]:
    """Tell errors of the disk from others."""
    try:
        yield
    except OSError as error:
        raise _NotWritten(str(journal.path), error) from error
