"""Writes a run chunk by chunk, and gathers the chunks in one file."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from phblocks.errors import ResultFileError
from phblocks.files.envelope import Content, hdf5, image, put, reading, write_all, write_atomically, write_large
from phblocks.files.settings import Settings, fingerprint
from phblocks.files.stored import Stored, chunk_of, content_of_labels, folder_of, path_of, text_of
from phblocks.files.stream import Stream
from phblocks.results.labels import Labels
from phblocks.results.recording import ROWS, STEPS
from phblocks.results.status import Status
from phblocks.system import System
from phblocks.triplets import Floats

try:  # only one process may write a run
    import fcntl
except ImportError:  # pragma: no cover  (no such locks there)
    fcntl = None  # type: ignore[assignment]


class Journal:
    """Writes a run.

    Parameters
    ----------
    path : pathlib.Path
        The file of the run.
    chunk : int
        Steps in a chunk.
    index : int
        Number of the next chunk.
    rows, steps : int
        Saved times and steps before it.

    Attributes
    ----------
    pending : dict of str to numpy.ndarray
        What has been handed over and is not on disk.
    """

    def __init__(self, path: Path, chunk: int, index: int = 0, rows: int = 0, steps: int = 0) -> None:
        hdf5()
        self.path, self.chunk = path, chunk
        self.pending: dict[str, Floats] = {}
        self._index, self._extent = index, [rows, steps]
        self._lock = self._locked()

    @classmethod
    def create(cls, stream: Stream) -> Journal:
        """Begin a new run.

        Parameters
        ----------
        stream : Stream
            Where to.

        Returns
        -------
        Journal
            Nothing is written yet.

        Raises
        ------
        ResultFileError
            If there is a run already, or no place to write to.
        """
        path = Path(stream.path)
        if not stream.replace and (path.exists() or chunk_of(path, 0).exists()):
            raise ResultFileError(
                f"file {path}",
                expected="a name that is free",
                got="a file, or the chunks of a run",
                fix="Go on with ph.resume, take another name, or ph.Stream(path, replace=True).",
            )
        journal = cls(path, int(stream.chunk))
        with _PlaceToWrite(path):
            for old in (*folder_of(path).glob("*.h5"), path):
                old.unlink(missing_ok=True)
        return journal

    def begin(
        self,
        system: System,
        settings: Settings,
        drained: Mapping[str, Floats],
        worst: Mapping[str, Floats],
        totals: Mapping[str, float],
        checkpoint: tuple[Mapping[str, Floats], Mapping[str, Floats], float],
    ) -> None:
        """Write the first chunk: what the run is about, and a checkpoint at its start.

        Parameters
        ----------
        system : System
            The system.
        settings : Settings
            What is asked for.
        drained, worst, totals, checkpoint
            See :meth:`write`.

        Raises
        ------
        ResultFileError
            If it cannot be written.
        """
        with _PlaceToWrite(self.path):
            self.write(drained, worst, totals, checkpoint=checkpoint, about=(system, settings))

    def write(
        self,
        drained: Mapping[str, Floats],
        worst: Mapping[str, Floats],
        totals: Mapping[str, float],
        *,
        checkpoint: tuple[Mapping[str, Floats], Mapping[str, Floats], float] | None = None,
        status: Status | None = None,
        about: tuple[System, Settings] | None = None,
    ) -> None:
        """Write a chunk.

        Parameters
        ----------
        drained : mapping of str to numpy.ndarray
            New entries of all series.
        worst : mapping of str to numpy.ndarray
            Largest residuals so far.
        totals : mapping of str to float
            What the run took so far.
        checkpoint : tuple, optional
            Where it goes on: of the walk, of the recorder, and the time, s.
        status : Status, optional
            How it ended.
        about : tuple of System and Settings, optional
            In the first chunk, what the run is about.

        Raises
        ------
        OSError
            If it cannot be written; what was written before stays as it is.
        """
        self.pending = {path_of(name): array for name, array in drained.items()}
        content: dict[str, Content] = {**self.pending, **{f"worst/{key}": array for key, array in worst.items()}}
        content |= {"totals": json.dumps(dict(totals)), "index": np.array(self._index)}
        extent = [self._extent[0] + drained["t"].size, self._extent[1] + drained["lag"].size]
        if checkpoint is not None:
            content |= _content_of_checkpoint(*checkpoint, extent, self._index)
        if status is not None:
            content["status"] = json.dumps(text_of(status))
        if about is not None:
            system, settings = about
            described = {"name": system.name, "fingerprint": fingerprint(system), "settings": settings.text()}
            content["about"] = json.dumps({**described, "chunk": self.chunk})
            content |= content_of_labels(Labels.of(system))
        data = image(content)
        write_atomically(chunk_of(self.path, self._index), lambda file: write_all(file, data))
        self._index, self._extent, self.pending = self._index + 1, extent, {}

    def forget_later(self) -> None:
        """Remove chunks after the checkpoint from which the run goes on."""
        index = self._index
        with _PlaceToWrite(self.path):
            while (chunk := chunk_of(self.path, index)).exists():
                chunk.unlink()
                index += 1

    def gather(self) -> Stored:
        """Make one file of all chunks.

        Returns
        -------
        Stored
            The file.

        Raises
        ------
        OSError
            If it cannot be written; the chunks stay.
        """
        stored = Stored.open(self.path)
        write_large(self.path, lambda target: _copy(stored, target))
        self.close()
        shutil.rmtree(folder_of(self.path), ignore_errors=True)
        return Stored(self.path, [self.path])

    def close(self) -> None:
        """Let others write."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def _locked(self) -> int | None:
        """Make the folder and keep others from writing to it, until this process ends in whatever way."""
        with _PlaceToWrite(self.path):
            folder_of(self.path).mkdir(exist_ok=True)
            if fcntl is None:  # pragma: no cover
                return None
            lock = os.open(folder_of(self.path) / "lock", os.O_CREAT | os.O_RDWR)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(lock)
            raise ResultFileError(
                f"file {self.path}",
                expected="a run that nobody else writes",
                got="one that another simulation is writing",
                fix="Wait for it, or end it.",
            ) from error
        return lock


def _content_of_checkpoint(
    walk: Mapping[str, Floats], recorder: Mapping[str, Floats], time: float, extent: Sequence[int], index: int
) -> dict[str, Content]:
    content: dict[str, Content] = {f"checkpoint/walk/{key}": array for key, array in walk.items()}
    content |= {f"checkpoint/recorder/{key}": array for key, array in recorder.items()}
    numbers = {"extent": np.array(extent), "index": np.array(index), "time": np.array(time)}
    return content | {f"checkpoint/{key}": array for key, array in numbers.items()}


def _copy(stored: Stored, target: Any) -> None:
    """Write all that a run has to one file, chunk by chunk."""
    for name in (*ROWS, *STEPS):
        path, counts = path_of(name), []
        for number, source in enumerate(stored.files):
            with reading(source) as file:
                counts.append(stored.extent(number, file, name))
        series, end = None, 0
        for source, count in zip(stored.files, counts, strict=True):
            with reading(source) as file:
                if series is None:
                    shape = (sum(counts), *file[path].shape[1:])
                    series = target.create_dataset(path, shape=shape, dtype=file[path].dtype)
                series[end : end + count] = file[path][:count]
                end += count
    c = stored.checkpoint
    content: dict[str, Content] = {
        "about": json.dumps(stored.about),
        "totals": json.dumps(stored.totals),
        "status": json.dumps(text_of(stored.status)),
        "index": np.array(stored.index),
        **{f"worst/{key}": array for key, array in stored.worst.items()},
        **content_of_labels(stored.labels),
        **_content_of_checkpoint(c.walk, c.recorder, c.time, (c.rows, c.steps), c.index),
    }
    for path, value in content.items():
        put(target, path, value)


class _PlaceToWrite:
    """Turns an OSError into one that says where and what to do."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def __enter__(self) -> None:
        """Nothing to prepare."""

    def __exit__(self, kind: Any, error: BaseException | None, trace: Any) -> None:
        if isinstance(error, (OSError, ValueError)):
            raise ResultFileError(
                f"file {self._path}",
                expected="a place to write to",
                got=str(error),
                fix="Check folder, rights and space.",
            ) from error
