"""docs/damping.md: its code runs, and its figures are those of the code."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest

import phblocks as ph
from tests.test_readme import python_blocks

PAGE = Path(__file__).parents[1] / "docs" / "damping.md"
TEXT = PAGE.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def session():
    found = {"__name__": "page"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for block in python_blocks(TEXT):
            exec(compile(block, str(PAGE), "exec"), found)
    return found


def test_code_runs(session):
    assert session["solution"].status.ok and session["closed"].status.ok
    assert session["solution"].energy.numerical_loss[-1] > 0.0
    assert session["closed"].energy.projected[-1] != 0.0


def rows(heading: str) -> list[list[str]]:
    part = TEXT[TEXT.index(heading) :]
    lines = re.search(r"(?:^\|.*\n)+", part, re.M)[0].splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_losses_of_the_table():
    """1 - |N / D|^2, N / D the amplification factor at i w: w^4 / 36 over |D|^2, and w^6 / 3600."""
    for w, *texts in rows("## How much"):
        z = 1j * float(w)
        below = abs(1 - 2 * z / 3 + z**2 / 6) ** 2, abs(1 - 3 * z / 5 + 3 * z**2 / 20 - z**3 / 60) ** 2
        lost = abs(z) ** 4 / 36 / below[0], abs(z) ** 6 / 3600 / below[1]
        for text, share in zip(texts, lost, strict=True):
            if text.startswith("all but"):
                assert float(text.removeprefix("all but ")) == pytest.approx(1.0 - share, rel=0.02)
            else:
                assert float(text) == pytest.approx(share, rel=0.01)


def test_measured_rows(session):
    """Those of the four-bar that are quick: the first second of midpoint, damped and projected runs."""
    system = session["system"]
    methods = {"Midpoint()": ph.Midpoint(), "RadauIIA(2)": ph.RadauIIA(2), "RadauIIA(3)": ph.RadauIIA(3)}
    checked = 0
    for name, dt, lost, _, closure in rows("## What it does to the four-bar"):
        if name not in methods or float(dt) != 0.02:
            continue
        run = ph.simulate(system, 1.0, 0.02, method=methods[name])
        assert run.energy.numerical_loss[-1] == pytest.approx(float(lost), rel=0.02)
        assert max(gap.max() for gap in run.closure().values()) == pytest.approx(float(closure), rel=0.2)
        checked += 1
    assert checked == len(methods)
    assert np.isfinite(session["solution"].x).all()
