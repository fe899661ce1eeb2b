"""Opens runs on disk, alone or with their system."""

from __future__ import annotations

import os
from typing import overload

from phblocks.errors import ArgumentTypeError, ResultFileError
from phblocks.files.saved import SavedRun, StoredRecording, StoredStatistics, limits_of
from phblocks.files.settings import fingerprint
from phblocks.files.stored import Stored
from phblocks.files.stream import require_path
from phblocks.results.labels import Labels
from phblocks.results.solution import Solution
from phblocks.results.status import Status
from phblocks.system import System


@overload
def read(path: str | os.PathLike[str]) -> SavedRun: ...
@overload
def read(path: str | os.PathLike[str], system: System) -> Solution: ...
def read(path: str | os.PathLike[str], system: System | None = None) -> SavedRun | Solution:
    """Open a run that ``simulate(..., save=path)`` wrote, or is writing; nothing in it is executed.

    Arrays are read when they are asked for.

    Parameters
    ----------
    path : str or os.PathLike
        The file; for a run that has not ended it is enough that its folder of chunks is there.
    system : System, optional
        The system of the run, compiled once more, for everything that needs it: positions, velocities, forces.

    Returns
    -------
    SavedRun or Solution
        Without the system: states, energies and the power ledger by their names, status and statistics. With the
        system: a solution as ``simulate`` returns it. A run that was killed has the status "interrupted".

    Raises
    ------
    ResultFileError
        If there is no such run, a file is damaged or foreign, or the run is of another system.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """
    stored = Stored.open(require_path("read path", path))
    if system is None:
        return SavedRun(stored)
    require_same(stored, system, "read")
    return solution_of(stored, system, stored.status)


def solution_of(stored: Stored, system: System, status: Status) -> Solution:
    """Make a solution of a run on disk.

    Parameters
    ----------
    stored : Stored
        The files.
    system : System
        Of the run.
    status : Status
        How it ended.

    Returns
    -------
    Solution
        Its arrays are read when they are asked for.
    """
    return Solution(system, StoredRecording(stored), status, StoredStatistics(stored), limits_of(stored))


def require_same(stored: Stored, system: System, where: str) -> None:
    """Check that a run is one of a system.

    Parameters
    ----------
    stored : Stored
        The files.
    system : System
        The candidate.
    where : str
        What is called, for messages.

    Raises
    ------
    ResultFileError
        If it is another one.
    ArgumentTypeError
        If it is none.
    """
    if not isinstance(system, System):
        raise ArgumentTypeError(where, expected="a System", got=type(system).__name__, fix="Call compile() first.")
    if stored.about["fingerprint"] == fingerprint(system):
        return
    names = Labels.of(system).state_names
    differ = "the same states and other numbers" if names == stored.labels.state_names else "other states"
    raise ResultFileError(
        f"file {stored.path}",
        expected=f"the system {stored.labels.name!r} of the run",
        got=f"{system.name!r} with {differ}",
        fix="Compile the diagram of the run, with nothing changed.",
    )
