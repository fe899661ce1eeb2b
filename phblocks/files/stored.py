"""A run on disk, finished or not, as arrays that are read when they are asked for."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phblocks.errors import ResultFileError
from phblocks.files.envelope import Content, hdf5, reading, verify
from phblocks.results.labels import Labels
from phblocks.results.monitor import SUMS
from phblocks.results.recording import RESIDUALS, ROWS
from phblocks.results.status import Status
from phblocks.triplets import Floats, Ints

_TEXTS = ("state_names", "state_units", "theta_names", "energy_kinds", "blocks", "input_names", "output_names")


def folder_of(path: Path) -> Path:
    """Return the folder of the chunks of a run.

    Parameters
    ----------
    path : pathlib.Path
        The file of the run.

    Returns
    -------
    pathlib.Path
        Beside it.
    """
    return path.with_name(path.name + ".parts")


def chunk_of(path: Path, index: int) -> Path:
    """Return the file of a chunk.

    Parameters
    ----------
    path : pathlib.Path
        The file of the run.
    index : int
        Number of the chunk.

    Returns
    -------
    pathlib.Path
        In the folder.
    """
    return folder_of(path) / f"{index:08d}.h5"


def content_of_labels(labels: Labels) -> dict[str, Content]:
    """Take names apart for a file.

    Parameters
    ----------
    labels : Labels
        The names.

    Returns
    -------
    dict of str to array or texts
        By path.
    """
    content: dict[str, Content] = {f"labels/{key}": getattr(labels, key) for key in _TEXTS}
    content["labels/giving"] = tuple(giving for giving, _ in labels.connections)
    content["labels/taking"] = tuple(taking for _, taking in labels.connections)
    content["labels/connected"] = labels.connected
    group = np.full(len(labels.blocks), -1)
    for number, members in enumerate(labels.groups):
        group[list(members)] = number
    content["labels/group"] = group
    return content


@dataclass(frozen=True)
class Checkpoint:
    """Where a run can be resumed.

    Parameters
    ----------
    index, following : int
        Number of the chunk that it ends, and of the one to write next.
    walk, recorder : mapping of str to numpy.ndarray
        What goes on from there.
    rows, steps : int
        Saved times and steps up to there.
    time : float
        s.
    """

    index: int
    following: int
    walk: Mapping[str, Floats]
    recorder: Mapping[str, Floats]
    rows: int
    steps: int
    time: float


@dataclass
class Stored:
    """The files of a run, verified, in their order; and what could not be written, in memory.

    Parameters
    ----------
    path : pathlib.Path
        The file of the run.
    files : list of pathlib.Path
        The file and the chunks that go on from it.
    pending : dict of str to numpy.ndarray, optional
        By path as in a chunk.

    Attributes
    ----------
    about : dict
        Name, fingerprint and settings of the run.
    labels : Labels
        Names.
    totals : dict of str to float
        What it took.
    worst : dict of str to numpy.ndarray
        Largest residuals, and sums over the steps.
    index : int
        Number of the last chunk.
    """

    path: Path
    files: list[Path]
    pending: dict[str, NDArray[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Read what is small."""
        with reading(self.files[0]) as file:
            self.about: dict[str, Any] = json.loads(file["about"].asstr()[()])
            texts = {key: tuple(file[f"labels/{key}"].asstr()[:].tolist()) for key in _TEXTS}
            pairs = zip(file["labels/giving"].asstr()[:], file["labels/taking"].asstr()[:], strict=True)
            group, connected = file["labels/group"][:], file["labels/connected"][:]
            groups = tuple(tuple(np.flatnonzero(group == g).tolist()) for g in range(group.max(initial=-1) + 1))
            self.labels = Labels(
                name=self.about["name"],
                connections=tuple((str(giving), str(taking)) for giving, taking in pairs),
                connected=connected,
                groups=groups,
                **texts,
            )
        with reading(self.files[-1]) as file:
            self.index = int(file["index"][()])
            self.totals: dict[str, float] = json.loads(file["totals"].asstr()[()])
            self._status = json.loads(file["status"].asstr()[()]) if "status" in file else None
            self.worst = {key: file[f"worst/{key}"][:] for key in (*RESIDUALS, *SUMS)}

    @classmethod
    def open(cls, path: Path) -> Stored:
        """Open a run.

        Parameters
        ----------
        path : pathlib.Path
            The file of the run; it is enough that its folder of chunks is there.

        Returns
        -------
        Stored
            All its files.

        Raises
        ------
        ResultFileError
            If there is none, or a file is damaged or foreign.
        """
        hdf5()
        files, index = [], 0
        if path.exists() or not chunk_of(path, 0).exists():
            verify(path)
            files.append(path)
            with reading(path) as file:
                index = int(file["index"][()]) + 1
        while (chunk := chunk_of(path, index)).exists():
            verify(chunk)
            files.append(chunk)
            index += 1
        return cls(path, files)

    @property
    def status(self) -> Status:
        """How the run ended, if it did."""
        if self._status is not None:
            return Status(**self._status)
        checkpoint = self.checkpoint
        return Status.interrupted(checkpoint.time, str(self.path))

    @property
    def checkpoint(self) -> Checkpoint:
        """The last one."""
        for number in range(len(self.files) - 1, -1, -1):
            with reading(self.files[number]) as file:
                if "checkpoint" not in file:
                    continue
                group = file["checkpoint"]
                parts = [
                    {key: np.asarray(group[part][key][()]) for key in group[part]} for part in ("walk", "recorder")
                ]
                rows, steps = map(int, group["extent"][:])
                index, following = int(group["index"][()]), int(file["index"][()]) + 1
                return Checkpoint(index, following, parts[0], parts[1], rows, steps, float(group["time"][()]))
        raise ResultFileError(
            f"file {self.path}", expected="a run with a checkpoint", got="none", fix="Simulate once more."
        )

    @property
    def finished(self) -> bool:
        """Whether the run reached its end, and all of it is in one file."""
        return self.status.ok and self.files == [self.path]

    def array(self, name: str) -> NDArray[Any]:
        """Read a series.

        Parameters
        ----------
        name : str
            One of ``ROWS`` or ``STEPS``.

        Returns
        -------
        numpy.ndarray
            Of all times, or steps.
        """
        path = path_of(name)
        parts = []
        for number in range(len(self.files)):
            with reading(self.files[number]) as file:
                parts.append(file[path][: self.extent(number, file, name)])
        if path in self.pending:
            parts.append(self.pending[path])
        return np.concatenate(parts)

    def taken(self, name: str, rows: Ints) -> NDArray[Any]:
        """Read some entries of a series.

        Parameters
        ----------
        name : str
            One of ``ROWS``.
        rows : numpy.ndarray
            Their numbers.

        Returns
        -------
        numpy.ndarray
            Of these times, in this order.
        """
        total = sum(counts := self._extents(name))
        wanted, order = np.unique(np.arange(total)[rows], return_inverse=True)
        path, parts, first = path_of(name), [], 0
        for number, count in enumerate(counts):
            here = wanted[(wanted >= first) & (wanted < first + count)] - first
            first += count
            if not here.size:
                continue
            if number < len(self.files):
                with reading(self.files[number]) as file:  # h5py selects nothing from what has no entries
                    parts.append(file[path][here] if file[path].size else file[path][:][here])
            else:
                parts.append(self.pending[path][here])
        return np.concatenate(parts)[order] if parts else self.array(name)[:0]

    def _extents(self, name: str) -> list[int]:
        """Entries of a series in each file, and in memory."""
        counts = []
        for number in range(len(self.files)):
            with reading(self.files[number]) as file:
                counts.append(self.extent(number, file, name))
        return [*counts, *([self.pending[path_of(name)].shape[0]] if path_of(name) in self.pending else [])]

    def extent(self, number: int, file: Any, name: str) -> int:
        """Count the entries of a series in a file that still hold.

        Parameters
        ----------
        number : int
            Of the file.
        file : h5py.File
            The file.
        name : str
            One of ``ROWS`` or ``STEPS``.

        Returns
        -------
        int
            All of them, unless the run was resumed from an earlier checkpoint in the file.
        """
        if self.files[number] == self.path and len(self.files) > 1:
            rows, steps = map(int, file["checkpoint/extent"][:])
            return rows if name in ROWS else steps
        return int(file[path_of(name)].shape[0])


def text_of(status: Status) -> dict[str, Any]:
    """Describe a status for JSON; an exception stays behind.

    Parameters
    ----------
    status : Status
        How a run ended.

    Returns
    -------
    dict
        Of its fields.
    """
    return {key: getattr(status, key) for key in ("ok", "name", "text", "time", "state")}


def path_of(name: str) -> str:
    """Return where a series is in a file.

    Parameters
    ----------
    name : str
        One of ``ROWS`` or ``STEPS``.

    Returns
    -------
    str
        The path.
    """
    return f"{'rows' if name in ROWS else 'steps'}/{name}"
