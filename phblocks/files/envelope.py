"""HDF5 files with a check sum: nothing of a damaged or foreign file reaches the HDF5 library.

The sum stands in the user block, the first 512 bytes, which other programs skip: any tool opens these files.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from io import SEEK_SET, BytesIO
from pathlib import Path
from types import ModuleType
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from phblocks.errors import PhblocksError, ResultFileError
from phblocks.export.extras import require_extra

#: First line of every file, and the size of the user block.
MAGIC = b"phblocks run, version 1\n"
BLOCK = 512
_PIECE = 1 << 22

Content = NDArray[Any] | str | tuple[str, ...]


def hdf5() -> ModuleType:
    """Import h5py.

    Returns
    -------
    module
        ``h5py``.

    Raises
    ------
    ExtraMissingError
        If it is not installed.
    """
    module: ModuleType = require_extra("h5py", "hdf5", "files of results")
    return module


def image(content: Mapping[str, Content]) -> bytes:
    """Make a file in memory.

    Parameters
    ----------
    content : mapping of str to array, text or texts
        By path in the file.

    Returns
    -------
    bytes
        The file, sealed.
    """
    h5py, memory = hdf5(), BytesIO()
    with h5py.File(memory, "w", userblock_size=BLOCK) as file:
        for path, value in content.items():
            put(file, path, value)
    raw = memory.getvalue()
    body = memoryview(raw)[BLOCK:]
    return _block(hashlib.sha256(body).hexdigest(), len(body)) + raw[BLOCK:]


def put(file: Any, path: str, value: Content) -> None:
    """Write one dataset.

    Parameters
    ----------
    file : h5py.File
        Open for writing.
    path : str
        In the file.
    value : array, text or texts
        What is written.
    """
    if isinstance(value, np.ndarray):
        file.create_dataset(path, data=value)
    else:
        data = value if isinstance(value, str) else np.array(value, dtype=object)
        file.create_dataset(path, data=data, dtype=hdf5().string_dtype())


def write_atomically(path: Path, write: Callable[[BinaryIO], None]) -> None:
    """Write a file that has its name only when it is complete and on the disk.

    Parameters
    ----------
    path : pathlib.Path
        The file; one of the same name is replaced.
    write : callable
        Is given the open file.

    Raises
    ------
    OSError
        If it cannot be written; nothing is left of it then.
    """
    temporary = path.with_name(path.name + ".part")
    try:
        with open(temporary, "w+b", buffering=0) as file:
            write(file)
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):
            temporary.unlink()
        raise
    _sync_folder(path.parent)


def write_all(file: BinaryIO, data: bytes | memoryview) -> None:
    """Write all bytes to a file without a buffer, which may take them in pieces.

    Parameters
    ----------
    file : binary file
        Open for writing.
    data : bytes
        What is written.
    """
    rest = memoryview(data)
    while rest:
        rest = rest[file.write(rest) :]


def write_large(path: Path, fill: Callable[[Any], None]) -> None:
    """Write a file that need not fit in memory, atomically.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    fill : callable
        Is given an ``h5py.File`` to write to.

    Raises
    ------
    OSError
        If it cannot be written.
    """

    def write(file: BinaryIO) -> None:
        guarded = _Guarded(file)
        with hdf5().File(guarded, "w", userblock_size=BLOCK) as target:
            fill(target)
        if guarded.error is not None:
            raise guarded.error
        file.seek(BLOCK)
        digest, size = _digest(file)
        file.seek(0)
        write_all(file, _block(digest, size))

    write_atomically(path, write)


def verify(path: Path) -> None:
    """Check that a file is one of ours and as it was written.

    Parameters
    ----------
    path : pathlib.Path
        The file.

    Raises
    ------
    ResultFileError
        If it cannot be read, is damaged or something else.
    """
    where = f"file {path}"
    try:
        with open(path, "rb") as file:
            block = file.read(BLOCK)
            if not block.startswith(MAGIC):
                raise ResultFileError(
                    where,
                    expected="a run written by phblocks",
                    got="another file",
                    fix="Give a file of simulate(save=).",
                )
            digest, size = _digest(file)
    except OSError as error:
        raise ResultFileError(
            where, expected="a file that can be read", got=str(error), fix="Check the path."
        ) from error
    if block != _block(digest, size):
        raise ResultFileError(
            where,
            expected="an undamaged file",
            got="one that is not as it was written (another SHA-256 sum)",
            fix="It is cut off, damaged or changed by another program; use a copy.",
        )


@contextmanager
def reading(path: Path) -> Iterator[Any]:
    """Open a verified file.

    Parameters
    ----------
    path : pathlib.Path
        The file.

    Yields
    ------
    h5py.File
        Open for reading.

    Raises
    ------
    ResultFileError
        If it is not there any more, or something is missing in it.
    """
    h5py = hdf5()
    try:
        with h5py.File(path, "r") as file:
            yield file
    except PhblocksError:
        raise
    except (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError) as error:
        raise ResultFileError(
            f"file {path}",
            expected="a run written by this version of phblocks, which stays where it is",
            got=f"{type(error).__name__}: {error}",
            fix="If the run went on meanwhile, read it once more.",
        ) from error


def _block(digest: str, size: int) -> bytes:
    text = MAGIC + f"sha256 {digest}\nbytes {size}\nafter this block of {BLOCK} bytes: HDF5\n".encode()
    return text.ljust(BLOCK, b"\n")


def _digest(file: BinaryIO) -> tuple[str, int]:
    """SHA-256 sum and number of the bytes from here on."""
    total, size = hashlib.sha256(), 0
    while piece := file.read(_PIECE):
        total.update(piece)
        size += len(piece)
    return total.hexdigest(), size


def _sync_folder(folder: Path) -> None:
    with suppress(OSError):  # not every system can
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


class _Guarded:
    """A file that HDF5 writes to and that keeps errors to itself: told of a full disk, HDF5 crashes the interpreter."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.error: OSError | None = None

    def write(self, data: Any) -> int:
        if self.error is None:
            try:
                write_all(self._file, memoryview(data).cast("B"))
            except OSError as error:
                self.error = error
        return memoryview(data).nbytes

    def truncate(self, size: int | None = None) -> int:
        if self.error is None:
            try:
                return self._file.truncate(size)
            except OSError as error:
                self.error = error
        return size or 0

    def read(self, size: int) -> bytes:
        return self._file.read(size)

    def seek(self, offset: int, whence: int = SEEK_SET) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def flush(self) -> None:
        """Nothing waits."""
