"""What is asked of a run that is written to disk."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from phblocks.errors import ArgumentTypeError, DataError

#: Fewer steps in a chunk do not tell the states without a rate at the start.
LEAST = 10


@dataclass(frozen=True)
class Stream:
    """A file that a run is written to while it goes on; for ``simulate(..., save=...)``.

    Only the current chunk is kept in memory. At the end of each chunk the run can be resumed (:func:`phblocks.resume`):
    a kill loses one chunk at most.

    Parameters
    ----------
    path : str or os.PathLike
        The file, such as ``"run.h5"``. Until the run ends its chunks are in a folder ``run.h5.parts`` beside it.
    chunk : int, optional
        Steps in a chunk, at least 10. At its end the method starts anew, without the factors and steps it remembers:
        the run is the same to round-off with ``Midpoint``, ``DiscreteGradient`` and ``GaussLegendre``, and to the
        order of the method with ``LinearlyImplicit`` and ``ScipyIVP``, whose first steps are others.
    replace : bool, optional
        Replace a run that is already there.

    Raises
    ------
    ArgumentTypeError
        If an argument is of the wrong kind.
    DataError
        If the chunk is too short.
    """

    path: str | os.PathLike[str]
    chunk: int = 1000
    replace: bool = False

    def __post_init__(self) -> None:
        """Check the values."""
        require_path("Stream path", self.path)
        if isinstance(self.chunk, bool) or not isinstance(self.chunk, (int, np.integer)):
            raise ArgumentTypeError("Stream chunk", expected="an integer", got=repr(self.chunk), fix="Use 1000.")
        if self.chunk < LEAST:
            raise DataError("Stream chunk", expected=f"at least {LEAST}", got=repr(self.chunk), fix="Use 1000.")
        if not isinstance(self.replace, bool):
            raise ArgumentTypeError(
                "Stream replace", expected="a bool", got=repr(self.replace), fix="Use True or False."
            )


def require_path(where: str, path: object) -> Path:
    """Return a path.

    Parameters
    ----------
    where : str
        What it is, for the message.
    path : object
        The candidate.

    Returns
    -------
    pathlib.Path
        The path.

    Raises
    ------
    ArgumentTypeError
        If it is not one.
    """
    if not isinstance(path, (str, os.PathLike)) or not str(path):
        raise ArgumentTypeError(where, expected="a path", got=repr(path), fix='Give one such as "run.h5".')
    return Path(path)
