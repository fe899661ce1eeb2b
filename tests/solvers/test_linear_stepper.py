"""Steps of linear systems, one by one and many at a time, compiled and not: the same."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.solvers import linear_stepper
from phblocks.solvers.linear_stepper import CompiledRecursion, LinearStepper, PlainRecursion
from phblocks.solvers.method import Marching

METHODS = {
    "midpoint": ph.Midpoint(),
    "linearly implicit": ph.LinearlyImplicit(),
    "discrete gradient": ph.DiscreteGradient(),
    "Gauss 2": ph.GaussLegendre(2),
    "Gauss 3": ph.GaussLegendre(3),
    "Radau 2": ph.RadauIIA(2),
    "Radau 3": ph.RadauIIA(3),
}
DT = 0.004


@pytest.fixture(params=["compiled", "plain"])
def recursion(request, monkeypatch) -> type:
    """Which of both ways from step to step is gone."""
    if request.param == "compiled":
        pytest.importorskip("numba")
        return CompiledRecursion
    monkeypatch.setattr("phblocks.solvers.compiled.find_spec", lambda _: None)
    return PlainRecursion


@pytest.fixture(params=METHODS.values(), ids=METHODS)
def method(request):
    return request.param


@pytest.fixture
def system(scene) -> ph.System:
    return scene.compile().small_motions()


def stepped(stepper: LinearStepper, x, theta, u) -> list:
    """Take steps one by one."""
    steps = []
    for at_nodes in u:
        steps.append(stepper.step(x, theta, DT, at_nodes))
        x, theta = steps[-1].x, steps[-1].theta
    return steps


def test_many_steps_at_a_time_are_the_same_steps(recursion, method, system):
    stepper = method.prepare(system)
    assert isinstance(stepper, LinearStepper) and isinstance(stepper, Marching)
    assert isinstance(stepper._recursion, recursion)
    rng = np.random.default_rng(0)
    x = stepper.stage.pack(0.1 * rng.standard_normal(system.n) / np.sqrt(system.E.diagonal()))
    theta = 0.1 * rng.standard_normal(system.start.theta.size)
    u = rng.standard_normal((7, len(stepper.nodes), system.n_inputs))
    singles, many = stepped(stepper, x, theta, u), stepper.march(x, theta, DT, u)
    assert len(many) == 7
    for i, single in enumerate(singles):
        row = many.row(i)
        for name in ("x", "z", "u"):
            np.testing.assert_array_equal(getattr(row, name), getattr(single, name))
        for name in ("theta", "theta_z"):
            np.testing.assert_allclose(getattr(row, name), getattr(single, name), atol=1e-14)
        if single.damped is not None:
            np.testing.assert_array_equal(row.damped, single.damped)


def test_both_recursions_agree(system, method, monkeypatch):
    pytest.importorskip("numba")
    rng = np.random.default_rng(1)
    u = rng.standard_normal((5, len(method.prepare(system).nodes), system.n_inputs))
    x = rng.standard_normal(system.n)
    ends = []
    for found in (True, False):
        monkeypatch.setattr(linear_stepper, "installed", lambda found=found: found)
        ends.append(method.prepare(system).march(x, np.zeros(system.start.theta.size), DT, u))
    np.testing.assert_allclose(ends[0].x, ends[1].x, atol=1e-10 * np.abs(ends[1].x).max())
    np.testing.assert_allclose(
        ends[0].theta, ends[1].theta, atol=1e-10 * max(1.0, np.abs(ends[1].theta).max(initial=0.0))
    )


@pytest.mark.parametrize("dt", [0.02, 0.1, 1.0 / 3.0, 0.007])
def test_one_factor_serves_a_whole_run(recursion, scenes, monkeypatch, dt):
    system, made = scenes["free"].compile().small_motions(), []
    factorise = recursion.factorise
    monkeypatch.setattr(recursion, "factorise", lambda self, dt: made.append(dt) or factorise(self, dt))
    solution = ph.simulate(system, t_end=200 * dt, dt=dt, inputs={"push": lambda t: (np.sin(t), 0.0)})
    assert solution.statistics.steps == 200 and made == [dt]
    assert solution.max_power_balance_error < 1e-12 * max(1.0, solution.energy.total.max())
    ph.simulate(system, t_end=2.5 * dt, dt=dt)
    assert len(made) == 3  # and one more for the shorter last step


def test_states_too_large_end_a_stretch(recursion, scenes):
    """The march ends with the first step that leaves the safe range; numbers that are not finite are no step."""
    system = scenes["free"].compile().small_motions()
    stepper = ph.Midpoint().prepare(system)
    x, theta = np.full(system.n, 1e139), system.start.theta
    assert len(stepper.march(x, theta, DT, np.zeros((5, 1, system.n_inputs)))) == 5
    assert len(stepper.march(50.0 * x, theta, DT, np.zeros((5, 1, system.n_inputs)))) == 1
    assert stepper.march(np.full(system.n, np.inf), theta, DT, np.zeros((5, 1, system.n_inputs))) is None
