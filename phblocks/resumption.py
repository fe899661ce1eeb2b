"""Runs that go on where they were left."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from time import perf_counter

import numpy as np

from phblocks.errors import DataError
from phblocks.files.access import require_same, solution_of
from phblocks.files.journal import Journal
from phblocks.files.settings import Settings
from phblocks.files.stored import Checkpoint, Stored
from phblocks.files.stream import require_path
from phblocks.inputs import Drive, InputFailed, NotFinite, Signal
from phblocks.loop import Run, Seconds, require_resumable, walk_of
from phblocks.results.health import judged
from phblocks.results.limits import Limits, require_limits
from phblocks.results.recording import Recorder
from phblocks.results.solution import Solution
from phblocks.solvers.method import Integrator, Method
from phblocks.system import System


def resume(
    path: str | os.PathLike[str],
    system: System,
    inputs: Mapping[str, Signal] | None = None,
    method: Method | Integrator | None = None,
    progress: bool | None = None,
    limits: Limits | None = None,
) -> Solution:
    """Go on with a run that ``simulate(..., save=path)`` wrote and that did not reach its end.

    It goes on from the end of the last chunk, bit for bit as if it had never stopped (on the same machine, with the
    same libraries and number of threads). A run that has ended is returned as it is.

    Parameters
    ----------
    path : str or os.PathLike
        The file.
    system : System
        The system of the run, compiled once more: files hold no programs.
    inputs : mapping, optional
        Those of the run, which are not in the file either.
    method : Method or Integrator, optional
        That of the run, if it is one of your own; others are told by the file.
    progress : bool, optional
        Show a progress bar; by default if a terminal is attached and the run takes longer than a second.
    limits : Limits, optional
        As in ``simulate``.

    Returns
    -------
    Solution
        Of the whole run.

    Raises
    ------
    ResultFileError
        If there is no such run, a file is damaged or foreign, the run is of another system or method, or another
        process is writing it.
    DataError
        If the inputs are not those of the run.
    ArgumentTypeError
        If an argument is of the wrong kind.

    Warns
    -----
    HealthWarning
        As in ``simulate``, where the run goes on.
    """
    given = require_limits("resume limits", limits)
    clock, file = perf_counter(), require_path("resume path", path)
    stored = Stored.open(file)
    require_same(stored, system, "resume")
    if stored.finished:
        return solution_of(stored, system, stored.status)
    settings = Settings.of(stored.about["settings"], method, f"file {file}")
    checkpoint, drive = stored.checkpoint, Drive(system, {} if inputs is None else inputs)
    _require_same_inputs(checkpoint, drive)
    journal = Journal(file, stored.about["chunk"], checkpoint.following, checkpoint.rows, checkpoint.steps)
    if stored.status.ok:  # nothing is left but to gather its chunks
        try:
            return solution_of(journal.gather(), system, stored.status)
        finally:
            journal.close()
    journal.forget_later()
    walk = require_resumable(walk_of(settings, system, drive, system.start, journal.chunk), settings)
    walk.resume(checkpoint.walk)
    recorder = Recorder(system, walk.stage, walk.weights, walk.nodes, 0.0, system.start)
    recorder.remember(checkpoint.recorder)
    seconds = Seconds(**{key: stored.totals[key] for key in Seconds.__dataclass_fields__})
    seconds.preparation_seconds += perf_counter() - clock
    solution = Run(system, settings, walk, recorder, seconds, checkpoint.time).carry_out(progress, journal)
    return judged(solution, given or Limits.suited(settings.keeps_energy))


def _require_same_inputs(checkpoint: Checkpoint, drive: Drive) -> None:
    """Ask the inputs once more what they gave last before the checkpoint."""
    times, then = checkpoint.walk["input_times"].tolist(), checkpoint.walk["inputs"]
    now = None
    with suppress(NotFinite, InputFailed):
        now = drive.at(times)
    if not times or (now is not None and np.array_equal(now, then)):
        return
    raise DataError(
        f"resume inputs at t = {times[-1]:.9g} s",
        expected=f"{then.tolist()} as in the run",
        got="an exception, or values that are not finite" if now is None else repr(now.tolist()),
        fix="Give the inputs of the run.",
    )
