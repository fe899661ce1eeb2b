"""What every test runs under: no screen, no figure of another test, the same random examples, the reference numbers."""

import itertools
import json
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

import phblocks as ph

os.environ["MPLBACKEND"] = "Agg"

settings.register_profile("fixed", derandomize=True, deadline=None)
settings.load_profile("fixed")


@pytest.fixture(autouse=True)
def _close_figures() -> Iterator[None]:
    """Leave none to the next test, which may count them; tests that draw nothing do not load matplotlib for this."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


@pytest.fixture
def without_numba():
    """Run as if numba were not installed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("phblocks.solvers.compiled.find_spec", lambda _: None)
        yield


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


@pytest.fixture(scope="session")
def scenes(bar: ph.Section, four_bar: Callable[..., ph.Diagram]) -> dict[str, ph.Diagram]:
    """Small diagrams that together use every kind of joint, input, causality and geometry.

    - four-bar: a loop of pins under gravity, no switch
    - frame: welded corners and a curved beam, clamped at both feet, degree 2, a load in the fixed frame
    - arm: root on the ground and turned from outside, force and moment at the tip, gravity, switches
    - shaken: root moved by an imposed velocity, clamped to a second beam, switches
    - free: two beams pinned to each other and to nothing else, loads on the joint and on an end
    """
    soft = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)

    frame = ph.Diagram("frame", gravity=(0.5, -9.81))
    left = frame.add(ph.Beam("left", soft, (0.0, 0.0), (0.2, 1.0), elements=3, degree=2))
    top = frame.add(ph.Beam("top", soft, (0.2, 1.0), (1.4, 1.1), elements=(0.0, 0.3, 1.0), degree=2, curvature=-0.9))
    right = frame.add(ph.Beam("right", soft, (1.4, 1.1), (1.5, 0.0), elements=2, degree=2))
    frame.weld(left.start, frame.ground)
    frame.weld(left.end, top.start)
    frame.weld(top.end, right.start)
    frame.weld(right.end, frame.ground)
    frame.expose(top.end.translation, "load")

    arm = ph.Diagram("arm", gravity=(0.0, -9.81))
    b = arm.add(ph.Beam("arm", soft, (0.1, 0.2), (0.9, 0.8), elements=4))
    arm.pin(b.start, arm.ground)
    arm.expose(b.start.rotation, "drive", imposes="angular velocity")
    arm.expose(b.end.translation, "force")
    arm.expose(b.end.rotation, "moment")

    shaken = ph.Diagram("shaken")
    b = shaken.add(ph.Beam("lower", soft, (0.0, 0.0), (0.0, 1.0), elements=3, curvature=0.4))
    c = shaken.add(ph.Beam("upper", soft, (0.0, 1.0), (1.0, 1.5), elements=2, degree=2))
    shaken.expose(b.start.translation, "table", imposes="velocity")
    shaken.weld(b.end, c.start)
    shaken.expose(b.start.rotation, "hold", imposes="angular velocity")

    free = ph.Diagram("free")
    b = free.add(ph.Beam("first", soft, (0.0, 0.0), (1.0, 0.3), elements=3, degree=2))
    c = free.add(ph.Beam("second", soft, (1.0, 0.3), (1.0, -0.7), elements=2, degree=3))
    free.pin(b.end, c.start)
    free.expose(b.end.translation, "joint")
    free.expose(c.end.translation, "push")

    return {"four-bar": four_bar(), "frame": frame, "arm": arm, "shaken": shaken, "free": free}


@pytest.fixture(params=["four-bar", "frame", "arm", "shaken", "free"])
def scene(request: pytest.FixtureRequest, scenes: dict[str, ph.Diagram]) -> ph.Diagram:
    """One of the scenes after the other."""
    return scenes[request.param]
