"""Scenes that are written to disk, and what makes two runs the same to the bit."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import phblocks as ph
from phblocks.results.recording import ROWS, SERIES, STEPS


def arm() -> ph.System:
    """A beam that hangs on a hub by a pin with multipliers, with a force at its tip: every kind of state."""
    section = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)
    d = ph.Diagram("arm", gravity=(0.0, -9.81))
    hub = d.add(ph.RigidBody("hub", 1.0, 0.1, (0.0, 0.0), {"rim": (0.2, 0.0)}))
    beam = d.add(ph.Beam("beam", section, (0.2, 0.0), (1.2, 0.0), elements=2))
    damper = d.add(ph.TorsionDamper("damper", 0.05))
    d.pin(hub.centre, d.ground, multiplier=True)
    d.weld(hub["rim"], beam.start)
    d.connect(d.ground.rotation, damper.first)
    d.connect(hub.centre.rotation, damper.second)
    d.expose(beam.end.translation, "tip")
    return d.compile()


def beam() -> ph.System:
    """A pinned beam without multipliers, for methods that need a rate for every state."""
    section = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)
    d = ph.Diagram("beam", gravity=(0.0, -9.81))
    b = d.add(ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(b.start, d.ground)
    d.expose(b.end.translation, "tip")
    return d.compile()


def duffing() -> ph.System:
    """An energy that is not quadratic, opened."""
    block = ph.CustomBlock(
        "duffing",
        2,
        lambda x: 0.5 * x[1] ** 2 + 0.25 * x[0] ** 4,
        gradient=lambda x: np.array([x[0] ** 3, x[1]]),
        hessian=lambda x: np.diag([3.0 * x[0] ** 2, 1.0]),
        J=np.array([[0.0, 1.0], [-1.0, 0.0]]),
        start=(1.0, 0.5),
    )
    d = ph.Diagram("duffing")
    d.add(block)
    return d.compile()


def truss() -> ph.System:
    """Two beams between three pins, one of them with multipliers, pulled where they meet: a loop."""
    section = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)
    d = ph.Diagram("truss", gravity=(0.0, -9.81))
    left = d.add(ph.Beam("left", section, (0.0, 0.0), (1.0, 0.2), elements=2))
    right = d.add(ph.Beam("right", section, (1.0, 0.2), (2.0, 0.0), elements=2))
    d.pin(left.start, d.ground)
    d.pin(left.end, right.start)
    d.pin(right.end, d.ground, multiplier=True)
    d.expose(left.end.translation, "tip")
    return d.compile()


SYSTEMS = {"arm": arm, "beam": beam, "duffing": duffing, "truss": truss}


def tip(t: float) -> tuple[float, float]:
    """A force that swings."""
    return 0.5 * np.sin(3.0 * t), 0.2 * t


def series(solution: Any) -> dict[str, np.ndarray]:
    """All arrays of a solution."""
    recording, ledger, statistics = solution.recording, solution.recording.ledger, solution.statistics
    own = {key: getattr(recording, key) for key in ROWS if key not in (*SERIES, "balance_error")}
    books = {key: getattr(ledger, key) for key in (*SERIES, "balance_error", "block_error", "connection_error")}
    return own | books | {key: getattr(statistics, key) for key in (*STEPS, "steps", "halvings", "rejections")}


@pytest.fixture(scope="session")
def systems() -> dict[str, ph.System]:
    return {name: draw() for name, draw in SYSTEMS.items()}


@pytest.fixture(scope="session")
def same() -> Callable[[Any, Any], None]:
    """Assert that two solutions are the same to the bit."""

    def compare(one: Any, other: Any) -> None:
        first, second = series(one), series(other)
        for key, array in first.items():
            np.testing.assert_array_equal(second[key], array, err_msg=key, strict=True)

    return compare


@pytest.fixture(scope="session")
def cut() -> Callable[..., None]:
    """Simulate, written to disk, up to a time at which the process is stopped in the middle of everything."""

    def simulate(system: ph.System, path: Any, at: float, **options: Any) -> None:
        signal = options.pop("inputs", {}).get("tip")

        class Stopped(BaseException):
            pass

        def stopping(t: float) -> Any:
            if t > at:
                raise Stopped
            return signal(t)

        with pytest.raises(Stopped):
            ph.simulate(system, save=path, inputs={"tip": stopping}, **options)

    return simulate
