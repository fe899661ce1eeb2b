"""Which setting to use."""

from __future__ import annotations

from typing import TypeVar

from phblocks.blocks.checks import require_real
from phblocks.errors import ArgumentTypeError, DataError, UnreachedError
from phblocks.studies.run import Run
from phblocks.studies.table import Table

R = TypeVar("R", bound=Run)


def cheapest(study: Table[R], tolerance: float) -> R:
    """Choose the fastest run that is accurate enough.

    Parameters
    ----------
    study : WorkPrecisionStudy or ConvergenceStudy
        The runs.
    tolerance : float
        What the error, with the uncertainty of the reference added, may be at most.

    Returns
    -------
    Run
        With the setting to use.

    Raises
    ------
    UnreachedError
        If no run is; names the most accurate one.
    ArgumentTypeError, DataError
        If it is no study, or the tolerance no number above zero.
    """
    rows = _judged("cheapest", study, tolerance)
    enough = [row for row in rows if row.error_bound <= tolerance]
    if not enough:
        best = min(rows, key=lambda row: row.error_bound)
        raise UnreachedError(
            "cheapest",
            expected=f"a run with an error of at most {tolerance:g} {best.unit}".rstrip(),
            got=f"at best {best}, against a reference uncertain by {best.reference_uncertainty:.2g}",
            fix="Add smaller steps, finer meshes or a method of higher order, or a better reference.",
        )
    return min(enough, key=lambda row: row.seconds)


def best_within(study: Table[R], seconds: float) -> R:
    """Choose the most accurate run that is fast enough.

    Parameters
    ----------
    study : WorkPrecisionStudy or ConvergenceStudy
        The runs.
    seconds : float
        What it may take, s.

    Returns
    -------
    Run
        With the setting to use.

    Raises
    ------
    UnreachedError
        If no run is; names the fastest one.
    ArgumentTypeError, DataError
        If it is no study, or the time no number above zero.
    """
    rows = _judged("best_within", study, seconds)
    enough = [row for row in rows if row.seconds <= seconds]
    if not enough:
        best = min(rows, key=lambda row: row.seconds)
        raise UnreachedError(
            "best_within",
            expected=f"a run of at most {seconds:g} s",
            got=f"at best {best}",
            fix="Add larger steps or coarser meshes.",
        )
    return min(enough, key=lambda row: (row.error, row.seconds))


def _judged(where: str, study: Table[R], bound: float) -> list[R]:
    """The rows that have an error."""
    if not isinstance(study, Table):
        raise ArgumentTypeError(where, expected="a study", got=type(study).__name__, fix="Call work_precision() first.")
    if not require_real(where, bound) > 0.0:
        raise DataError(where, expected="a number > 0", got=repr(bound), fix="Correct it.")
    rows = [row for row in study if row.ok]
    if not rows:
        raise UnreachedError(
            where,
            expected="runs that reached their end",
            got=f"none of {len(study)}",
            fix="Look at the column status_text.",
        )
    return rows
