"""What every test runs under: no screen, the same random examples in every run, the reference numbers."""

import itertools
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

import phblocks as ph

os.environ["MPLBACKEND"] = "Agg"

settings.register_profile("fixed", derandomize=True, deadline=None)
settings.load_profile("fixed")


@pytest.fixture(scope="session")
def references() -> dict[str, Any]:
    """Numbers this project did not compute; see tests/README.md."""
    return json.loads(Path(__file__).with_name("references.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def bar() -> ph.Section:
    """The square steel bar of the reference four-bar."""
    return ph.Section.rectangle(width=0.05, height=0.05, young=2.1e11, poisson=0.3, density=2710.0, shear_factor=1.0)


@pytest.fixture(scope="session")
def four_bar(bar: ph.Section) -> Callable[..., ph.Diagram]:
    """A function that draws the reference four-bar (physics of the scene: references.json)."""

    def draw(
        elements: tuple[int, int, int] = (4, 3, 3),
        degree: int = 1,
        gravity: tuple[float, float] | None = (0.0, -9.81),
        coupler: ph.Section = bar,
    ) -> ph.Diagram:
        d = ph.Diagram("four-bar", gravity=gravity)
        places = ((0.0, 0.5), (2.0, 1.5), (3.5, 1.5), (2.5, 0.5))
        bars = [
            d.add(ph.Beam(name, section, start, end, elements=n, degree=degree))
            for name, section, start, end, n in zip(
                ("crank", "coupler", "rocker"), (bar, coupler, bar), places, places[1:], elements, strict=False
            )
        ]
        d.pin(bars[0].start, d.ground)
        for left, right in itertools.pairwise(bars):
            d.pin(left.end, right.start)
        d.pin(bars[2].end, d.ground)
        return d

    return draw
