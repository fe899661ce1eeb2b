"""Sums over the steps of a run: of some of them they are those of all, whatever oscillates."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.results import monitor

DT, STEPS = 2e-2, 4096


@pytest.fixture(scope="module")
def cantilever() -> ph.System:
    """A cantilever that is linear, pushed across from outside."""
    section = ph.Section(axial=3e4, shear=1e4, bending=50.0, mass=1.2, rotary=3e-3)
    d = ph.Diagram("pushed")
    small = ph.Approximation(large_rotation=False)
    arm = d.add(ph.Beam("arm", section, (0.0, 0.0), (1.0, 0.0), elements=2, approximation=small))
    d.weld(d.ground, arm.start)
    d.expose(arm.end.translation, "push")
    return d.compile()


@pytest.mark.parametrize("phase", [0.0, 0.125])
@pytest.mark.parametrize("period", [2, 4, 8, 16, 32])
def test_one_step_in_four_tells_what_is_not_resolved(cantilever, period, phase, monkeypatch):
    """The push has a period of so many steps; RadauIIA damps what the start left."""

    def push(t: float) -> tuple[float, float]:
        return 0.0, np.sin(2.0 * np.pi * (t / (period * DT) + phase)) * min(1.0, t / (100 * DT))

    shares = []
    for counted in (monitor.ALL, STEPS):
        monkeypatch.setattr(monitor, "ALL", counted)
        run = ph.simulate(
            cantilever, STEPS * DT, DT, inputs={"push": push}, method=ph.RadauIIA(2), limits=ph.Limits.none()
        )
        sums = run.recording.sums
        shares.append((sums.missed.sum() / sums.held.sum(), sums.held.sum()))
    some, all_ = shares
    assert some[0] == pytest.approx(all_[0], rel=0.1, abs=1e-4)  # its limit is 0.6
    assert some[1] == pytest.approx(all_[1], rel=0.05)
