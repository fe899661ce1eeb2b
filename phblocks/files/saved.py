"""What a file holds, read when it is asked for: with the system of the run, and without."""

from __future__ import annotations

from typing import Any

from phblocks.files.stored import Stored
from phblocks.results.labels import Labels
from phblocks.results.limits import Limits
from phblocks.results.monitor import Sums
from phblocks.results.readings import Readings
from phblocks.results.recording import ROWS, SERIES, STEPS, Ledger, Recording
from phblocks.results.status import Statistics
from phblocks.triplets import Ints


def limits_of(stored: Stored) -> Limits:
    """Return the limits that suit the method of a run.

    Parameters
    ----------
    stored : Stored
        The files.

    Returns
    -------
    Limits
        The defaults.
    """
    return Limits.suited(bool(stored.about["settings"].get("keeps_energy", True)))


class StoredRecording(Recording):
    """A recording whose arrays are read when they are asked for.

    Parameters
    ----------
    stored : Stored
        The files.
    """

    def __init__(self, stored: Stored) -> None:
        self._stored = stored

    def __getattr__(self, name: str) -> Any:
        """Read an array."""
        if name == "ledger":
            value: Any = StoredLedger(self._stored)
        elif name == "sums":
            value = Sums.of(self._stored.worst)
        elif name in ROWS:
            value = self._stored.array(name)
        else:
            raise AttributeError(name)
        self.__dict__[name] = value
        return value

    def sliced(self, times: Ints) -> Recording:
        """Read some of the saved times only.

        Parameters
        ----------
        times : numpy.ndarray
            Their numbers.

        Returns
        -------
        Recording
            In memory; the largest residuals and the sums stay those of the whole run.
        """
        return Recording.of({name: self._stored.taken(name, times) for name in ROWS}, self._stored.worst)


class StoredLedger(Ledger):
    """A ledger whose arrays are read when they are asked for.

    Parameters
    ----------
    stored : Stored
        The files.
    """

    def __init__(self, stored: Stored) -> None:
        self._stored = stored
        self.block_error, self.connection_error = stored.worst["block_error"], stored.worst["connection_error"]

    def __getattr__(self, name: str) -> Any:
        """Read an array."""
        if name not in (*SERIES, "balance_error"):
            raise AttributeError(name)
        self.__dict__[name] = value = self._stored.array(name)
        return value


class StoredStatistics(Statistics):
    """Statistics whose arrays are read when they are asked for.

    Parameters
    ----------
    stored : Stored
        The files.
    """

    def __init__(self, stored: Stored) -> None:
        self.__dict__.update(stored.totals, _stored=stored)

    def __getattr__(self, name: str) -> Any:
        """Read an array."""
        if name not in STEPS:
            raise AttributeError(name)
        self.__dict__[name] = value = self.__dict__["_stored"].array(name)
        return value


class SavedRun(Readings):
    """A run as it is on disk, finished or not, read without its system.

    Parameters
    ----------
    stored : Stored
        The files.

    Attributes
    ----------
    recording : Recording
        The arrays, read when they are asked for.
    status : Status
        How the run ended; "interrupted" if it was killed, or still goes on.
    statistics : Statistics
        What it took.
    settings : dict
        What it was asked for: ``t_end``, ``dt``, ``method`` and so on.
    """

    def __init__(self, stored: Stored) -> None:
        self._labels = stored.labels
        self.recording, self.statistics = StoredRecording(stored), StoredStatistics(stored)
        self.status, self.settings = stored.status, dict(stored.about["settings"])
        self.limits = limits_of(stored)

    @property
    def labels(self) -> Labels:
        """The names of states, blocks, connections and inputs."""
        return self._labels
