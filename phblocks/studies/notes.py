"""What is said below the table of a study."""

from __future__ import annotations

from collections.abc import Sequence

from phblocks.studies.run import Run


def notes_of(rows: Sequence[Run]) -> tuple[str, ...]:
    """Say below a table what its numbers are.

    Parameters
    ----------
    rows : sequence of Run
        Of the table.

    Returns
    -------
    tuple of str
        Sentences.
    """
    notes = []
    for quantity, unit, reference, uncertainty, t_end in dict.fromkeys(
        (r.quantity, r.unit, r.reference, f"{r.reference_uncertainty:.2g}", r.t_end) for r in rows
    ):
        units = f" ({unit})" if unit else ""
        known = f", uncertain by {uncertainty}" if uncertainty != "nan" else ""
        notes.append(f"Error: {quantity}{units}, runs of {t_end:g} s. Reference: {reference}{known}.")
    timed = sorted({row.repeats for row in rows if row.ok})
    if timed:
        repeats = f"median of {timed[0]} runs" if timed[-1] > 1 else "one run"
        notes.append(f"Seconds: simulate only, one thread, {repeats}.")
    if any(row.shared_machine for row in rows):
        notes.append("Runs shared a machine (shared_machine): seconds may be longer than those of a run on its own.")
    notes += [f"Machine: {machine}." for machine in dict.fromkeys(row.machine for row in rows)]
    notes += [f"Failed: {row}: {row.status_text}" for row in rows if not row.ok]
    return tuple(notes)
