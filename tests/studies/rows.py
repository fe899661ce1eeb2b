"""Rows made by hand."""

import dataclasses
import math

from phblocks.studies import Run

TEXTS = dict.fromkeys(
    (
        "platform",
        "cpu",
        "python",
        "numpy",
        "scipy",
        "numba",
        "phblocks",
        "status_text",
        "quantity",
        "reference",
        "settings",
    ),
    "x",
)
NUMBERS = dict.fromkeys(("cores", "states", "steps", "newton_iterations", "repeats"), 1)
FLOATS = dict.fromkeys(("dt", "t_end", "energy_error", "gap", "lag", "reference_uncertainty"), 0.0)


def make_run(method: str, seconds: float, error: float = math.nan, **more: object) -> Run:
    """Make a row of what matters: method, seconds, error; without an error the run has failed."""
    given = {
        **TEXTS,
        **NUMBERS,
        **FLOATS,
        "method": method,
        "halvings": 0,
        "rejections": 0,
        "rtol": 0.0,
        "mesh": "elements=4",
        "seconds": seconds,
        "seconds_min": seconds,
        "seconds_max": seconds,
        "error": error,
        "status": "step failed" if math.isnan(error) else "success",
        "shared_machine": False,
        "unit": "m",
    }
    row = Run(**given)
    return dataclasses.replace(row, **more)
