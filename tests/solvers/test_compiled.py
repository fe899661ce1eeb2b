"""Compiled iterations: the same steps as without, whatever the system; and nothing but speed is lost without numba."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.solvers import compiled

pytest.importorskip("numba")


@pytest.fixture
def interpreted(monkeypatch):
    """Run as if numba were not installed."""

    def run(*arguments, **options):
        with monkeypatch.context() as patch:
            patch.setattr(compiled, "find_spec", lambda _: None)
            return ph.simulate(*arguments, **options)

    return run


def spring_arm() -> ph.System:
    """A flexible arm on a pin, held by a spring, pushed: joints, gravity, inputs and a line of action."""
    section = ph.Section(axial=3e4, shear=1e4, bending=50.0, mass=1.2, rotary=3e-3)
    d = ph.Diagram("arm", gravity=(0.0, -9.81))
    arm = d.add(ph.Beam("arm", section, (0.0, 0.0), (1.0, 0.0), elements=2, degree=2))
    spring = d.add(ph.Spring("spring", 500.0, (0.0, 1.0), (1.0, 0.0)))
    d.pin(arm.start, d.ground)
    d.pin(arm.end, spring.end)
    d.connect(spring.start.translation, d.ground.translation)
    d.expose(arm.end.translation, "push")
    return d.compile()


def push(t: float) -> tuple[float, float]:
    return 3.0 * np.sin(9.0 * t), 1.0


@pytest.mark.parametrize("stages", [2, 3])
@pytest.mark.parametrize("scene", ["spring arm", "four-bar"])
def test_the_same_motion(interpreted, stages, scene, four_bar):
    """Also where round-off ends the iteration, which looks at the matrices in another way."""
    options = {"inputs": {"push": push}} if scene == "spring arm" else {}
    system = spring_arm() if scene == "spring arm" else four_bar((10, 6, 6)).compile()
    method = ph.GaussLegendre(stages)
    slow, fast = (run(system, 1.6, 0.02, method=method, **options) for run in (interpreted, ph.simulate))
    difference = np.abs(fast.recording.x - slow.recording.x).max(axis=0)
    assert (difference <= 1e-7 * np.abs(slow.recording.x).max(axis=0) + 1e-12 * np.abs(slow.recording.x).max()).all()
    assert fast.max_power_balance_error < 1e-11 * np.ptp(fast.energy.gravity)
    iterations = [int(np.sum(s.statistics.newton_iterations)) for s in (slow, fast)]
    assert abs(iterations[0] - iterations[1]) <= 0.02 * iterations[0] + 2


def test_where_it_is_used(four_bar):
    system = four_bar().compile()
    assert isinstance(ph.GaussLegendre(2).prepare(system)._newton, compiled.CompiledNewton)
    for method, other in (
        (ph.GaussLegendre(2, newton=ph.Newton()), system),
        (ph.GaussLegendre(2), system.small_motions()),
    ):
        assert not isinstance(method.prepare(other)._newton, compiled.CompiledNewton)


def test_a_step_that_is_too_long_fails_alike(interpreted, four_bar):
    system = four_bar().compile()
    method = ph.GaussLegendre(2, newton=ph.ModifiedNewton(max_iterations=6))
    slow, fast = (run(system, 0.4, 0.08, method=method) for run in (interpreted, ph.simulate))
    assert slow.statistics.halvings == fast.statistics.halvings > 0
    assert slow.status.ok and fast.status.ok
