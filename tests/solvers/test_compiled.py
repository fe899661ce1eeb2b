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


METHODS = {
    "midpoint": ph.Midpoint(),
    "midpoint from x": ph.Midpoint(predict=False),
    "2 stages": ph.GaussLegendre(2),
    "3 stages": ph.GaussLegendre(3),
    "2 stages, damped": ph.RadauIIA(2),
    "3 stages, damped": ph.RadauIIA(3),
}


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
@pytest.mark.parametrize("scene", ["spring arm", "four-bar"])
def test_the_same_motion(interpreted, method, scene, four_bar):
    """Also where round-off ends the iteration, which looks at the matrices in another way."""
    options = {"inputs": {"push": push}} if scene == "spring arm" else {}
    system = spring_arm() if scene == "spring arm" else four_bar((10, 6, 6)).compile()
    slow, fast = (run(system, 1.6, 0.02, method=method, **options) for run in (interpreted, ph.simulate))
    difference = np.abs(fast.recording.x - slow.recording.x).max(axis=0)
    assert (difference <= 1e-7 * np.abs(slow.recording.x).max(axis=0) + 1e-12 * np.abs(slow.recording.x).max()).all()
    assert np.abs(fast.recording.theta - slow.recording.theta).max() < 1e-9
    assert fast.max_power_balance_error < 1e-11 * np.ptp(fast.energy.gravity)
    iterations = [int(np.sum(s.statistics.newton_iterations)) for s in (slow, fast)]
    assert abs(iterations[0] - iterations[1]) <= 0.02 * iterations[0] + 2


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_states_without_energy(interpreted, method):
    """A joint with a multiplier: its row of E is zero, its value that of the polynomial through the stages."""
    section = ph.Section(axial=3e4, shear=1e4, bending=50.0, mass=1.2, rotary=3e-3)
    d = ph.Diagram("held", gravity=(0.0, -9.81))
    arm = d.add(ph.Beam("arm", section, (0.0, 0.0), (1.0, 0.0), elements=2, causality="free-free"))
    d.pin(arm.start, d.ground, multiplier=True)
    system = d.compile()
    slow, fast = (run(system, 0.5, 0.01, method=method) for run in (interpreted, ph.simulate))
    assert system.algebraic.any()
    np.testing.assert_allclose(fast.recording.x, slow.recording.x, atol=1e-7 * np.abs(slow.recording.x).max())


def test_where_it_is_used(four_bar):
    system = four_bar().compile()
    assert isinstance(ph.GaussLegendre(2).prepare(system), compiled.CompiledStepper)
    for method, other in (
        (ph.GaussLegendre(2, newton=ph.Newton()), system),
        (ph.Midpoint(newton=ph.Newton()), system),
        (ph.GaussLegendre(2), system.small_motions()),
    ):
        assert not isinstance(method.prepare(other), compiled.CompiledStepper)


@pytest.mark.parametrize("method", [ph.GaussLegendre(2), ph.Midpoint()])
def test_a_step_that_is_too_long_fails_alike(interpreted, four_bar, method):
    system = four_bar().compile()
    method = type(method)(newton=ph.ModifiedNewton(max_iterations=6))
    limits = ph.Limits.none()
    slow, fast = (run(system, 0.4, 0.08, method=method, limits=limits) for run in (interpreted, ph.simulate))
    assert slow.statistics.halvings == fast.statistics.halvings > 0
    assert slow.status.ok and fast.status.ok


def test_numbers_that_are_not_finite_end_the_run_alike(interpreted):
    system, far = spring_arm(), lambda t: (1e200 * t, 0.0)
    slow, fast = (run(system, 0.2, 0.1, inputs={"push": far}, max_halvings=1) for run in (interpreted, ph.simulate))
    assert not slow.status.ok and fast.status.text == slow.status.text


def test_runs_at_the_same_time_do_not_disturb_each_other(four_bar):
    """What is constant is shared between runs of a system, what belongs to a step is not."""
    system = four_bar().compile()
    alone = ph.simulate(system, 0.1, 0.01)
    steppers = [ph.Midpoint().prepare(system) for _ in range(2)]
    x, theta = steppers[0].stage.pack(system.start.x), system.start.theta
    ends = [(x, theta), (x, theta)]
    for _ in range(10):
        for k, stepper in enumerate(steppers):
            dt = 0.01 if k == 0 else 0.003
            step = stepper.step(*ends[k], dt, np.zeros((1, system.n_inputs)))
            ends[k] = step.x, step.theta
    np.testing.assert_array_equal(steppers[0].stage.unpack(ends[0][0]), alone.recording.x[-1])
