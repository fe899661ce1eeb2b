"""Matrices for other tools: files that MATLAB, Octave, Julia, SciPy and NumPy read, with names, units and convention.

The format follows from the suffix; ``docs/export.md`` describes the files field by field.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from phblocks.errors import ArgumentTypeError, ExportError, ExtraMissingError, PhblocksError
from phblocks.export import archive, matlab, matrix_market
from phblocks.export.matrices import CONVENTION, Matrices, Tangent
from phblocks.export.record import Record, matrices_of, record_of

__all__ = ["CONVENTION", "Matrices", "Tangent", "read", "suffixes", "write"]


class _Format(NamedTuple):
    write: Callable[[Record, Path], tuple[Path, ...]]
    read: Callable[[Path], Record]


_FORMATS = {
    ".mat": _Format(matlab.write, matlab.read),
    ".npz": _Format(archive.write, archive.read),
    ".mtx": _Format(matrix_market.write, matrix_market.read),
}


def suffixes() -> tuple[str, ...]:
    """Return the suffixes of the formats there are.

    Returns
    -------
    tuple of str
        Such as ``".mat"``.
    """
    return tuple(_FORMATS)


def write(matrices: Matrices, path: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write matrices to a file; a file of the same name is replaced.

    Parameters
    ----------
    matrices : Matrices
        What is written.
    path : str or os.PathLike
        The suffix chooses the format: ``.mat`` (MATLAB), ``.npz`` (NumPy), ``.mtx`` (Matrix Market, several files).

    Returns
    -------
    tuple of pathlib.Path
        The files written.

    Raises
    ------
    ExportError
        If the suffix is unknown, the folder does not exist, the file cannot be written or the format cannot hold it.
    ArgumentTypeError
        If it is not matrices that are given, or not a path.
    ExtraMissingError
        If a matrix is too large for a ``.mat`` file of version 5 and h5py, which writes version 7.3, is not installed.
    """
    if not isinstance(matrices, Matrices):
        raise ArgumentTypeError("export.write", expected="Matrices", got=repr(matrices), fix="Use system.export(path).")
    file, chosen = _resolve("export.write", path)
    if not file.parent.is_dir():
        raise ExportError(
            f"file {file}", expected="a folder that exists", got=f"{file.parent}", fix="Make the folder first."
        )
    try:
        return chosen.write(record_of(matrices), file)
    except PhblocksError:
        raise
    except (OSError, ValueError) as error:
        raise ExportError(
            f"file {file}", expected="a place to write to", got=str(error), fix="Check permissions and space."
        ) from error


def read(path: str | os.PathLike[str]) -> Matrices:
    """Read a file written by :func:`phblocks.export.write`; nothing in it is executed.

    Parameters
    ----------
    path : str or os.PathLike
        The path that was given to :func:`phblocks.export.write`.

    Returns
    -------
    Matrices
        Its content, equal to the bit.

    Raises
    ------
    ExportError
        If the suffix is unknown, there is no such file, it is damaged, or it is something else.
    ArgumentTypeError
        If it is not a path.
    ExtraMissingError
        If it is a ``.mat`` file of version 7.3 and h5py is not installed.
    """
    file, chosen = _resolve("export.read", path)
    where = f"file {file}"
    try:
        return matrices_of(chosen.read(file), where)
    except (ExportError, ExtraMissingError):
        raise
    except OSError as error:
        raise ExportError(where, expected="a file that can be read", got=str(error), fix="Check the path.") from error
    except Exception as error:  # whatever the reader of a format says about bytes that are not of its making
        raise ExportError(
            where,
            expected="an undamaged file written by phblocks",
            got=f"{type(error).__name__}: {error}",
            fix="Export once more.",
        ) from error


def _resolve(where: str, path: str | os.PathLike[str]) -> tuple[Path, _Format]:
    if not isinstance(path, (str, os.PathLike)):
        raise ArgumentTypeError(where, expected="a path", got=repr(path), fix='Give one such as "model.mat".')
    file = Path(path)
    chosen = _FORMATS.get(file.suffix.lower())
    if chosen is None:
        raise ExportError(
            f"file {file}",
            expected=f"a suffix out of {', '.join(_FORMATS)}",
            got=repr(file.suffix) if file.suffix else "none",
            fix="The suffix chooses the format.",
        )
    return file, chosen
