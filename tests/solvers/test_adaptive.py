"""Adapted steps: tolerances are met, energy is kept, times are reached, and what cannot be done is said."""

import dataclasses

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, UnknownNameError


@pytest.fixture(scope="module")
def swing() -> ph.System:
    """A soft thick beam on a pin under a force at its tip."""
    section = ph.Section.rectangle(0.2, 0.2, young=1e6, poisson=0.3, density=2710.0, shear_factor=1.0)
    d = ph.Diagram("swing")
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(beam.start, d.ground)
    d.expose(beam.end.translation, "tip")
    return d.compile()


def run(system: ph.System, rtol: float = 1e-3, method=None, t_end: float = 1.0, **options):
    force = {"tip": lambda t: (0.0, 150.0 * np.sin(np.pi * t) ** 8)}
    adaptive = options.pop("adaptive", ph.Adaptive(rtol=rtol))
    return ph.simulate(system, t_end, 0.01, method=method, inputs=force, adaptive=adaptive, **options)


@pytest.mark.parametrize("method", [ph.Midpoint(), ph.GaussLegendre(2), ph.GaussLegendre(3)])
def test_a_smaller_tolerance_gives_a_smaller_error_at_the_cost_of_the_order(swing, method):
    """Steps grow as rtol^(-1/(order + 1)); the tip follows the tolerance within a power."""
    exact = run(swing, 1e-9, ph.GaussLegendre(3)).position("beam", 1.0)[-1]
    tolerances = np.array([1e-3, 1e-4, 1e-5])
    solutions = [run(swing, rtol, method) for rtol in tolerances]
    errors = [np.linalg.norm(s.position("beam", 1.0)[-1] - exact) for s in solutions]
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    assert 0.5 <= slope <= 1.3
    steps = [s.statistics.steps for s in solutions]
    growth = -np.polyfit(np.log(tolerances), np.log(steps), 1)[0]
    assert growth == pytest.approx(1.0 / (method.order + 1), abs=0.07)
    for solution, rtol in zip(solutions, tolerances, strict=True):
        assert solution.status.ok and solution.t[-1] == 1.0
        assert solution.max_power_balance_error < 1e-12 * solution.energy.supplied.max()
        assert 0 <= solution.statistics.rejections < 0.3 * solution.statistics.steps
        assert errors[list(tolerances).index(rtol)] < 30.0 * rtol


def test_the_estimate_is_the_error_of_the_two_halves(swing):
    """At the order of the method the difference of one step and two, over 2^p - 1, is their error (to 20 %)."""
    from phblocks.solvers.adaptive import ErrorNorm

    method, rng = ph.Midpoint(), np.random.default_rng(1)
    stepper, u = method.prepare(swing), np.zeros((1, swing.n_inputs))
    fine = ph.GaussLegendre(3).prepare(swing)
    x = stepper.stage.pack(swing.rigid_motion(spin=2.0).x + 0.05 * rng.standard_normal(swing.n))
    theta, h = swing.start.theta, 1e-3
    one = stepper.step(x, theta, h, u)
    half = stepper.step(x, theta, 0.5 * h, u)
    two = stepper.step(half.x, half.theta, 0.5 * h, u)
    true = fine.step(x, theta, h, np.zeros((3, swing.n_inputs)))
    size, unpack = ErrorNorm(swing, ph.Adaptive(rtol=1.0)), stepper.stage.unpack
    states = [(unpack(s.x), s.theta) for s in (one, two, true)]
    assert size(states[0], states[1]) / 3.0 == pytest.approx(size(states[1], states[2]), rel=0.2)


def test_times_asked_for_are_reached_exactly(swing):
    times = [0.1, 0.33, 0.34, 0.9]
    solution = run(swing, 1e-4, times=times)
    np.testing.assert_array_equal(solution.t, [0.0, *times, 1.0])
    everything = run(swing, 1e-4)
    assert everything.t.size == 1 + everything.statistics.steps // 2
    assert (np.diff(everything.t) > 0.0).all() and everything.t[-1] == 1.0
    some = run(swing, 1e-4, save_every=4)
    np.testing.assert_array_equal(some.t[:-1], everything.t[::4][: some.t.size - 1])
    exact = run(swing, 1e-8, ph.GaussLegendre(3), times=times)
    assert np.abs(solution.position("beam", 1.0) - exact.position("beam", 1.0)).max() < 1e-4


def test_steps_are_long_where_nothing_happens(swing):
    """The force has its bump in the middle of the second: at rest before it, with an absolute tolerance."""
    solution = run(swing, adaptive=ph.Adaptive(rtol=1e-5, atol=1e-5))
    h = np.diff(solution.t)
    assert h[solution.t[1:] < 0.1].max() > 2.0 * h[(solution.t[1:] > 0.4) & (solution.t[1:] < 0.6)].max()


def test_rejected_steps_are_counted_and_leave_no_trace(swing):
    """A first step that is far too long."""
    options = {"adaptive": ph.Adaptive(rtol=1e-5), "t_end": 0.5}
    start = swing.rigid_motion(spin=3.0)
    solution = ph.simulate(swing, 0.5, 0.5, start=start, adaptive=options["adaptive"])
    assert solution.statistics.rejections + solution.statistics.halvings > 0
    assert f"{solution.statistics.rejections} rejections" in str(solution.statistics)
    assert np.abs(solution.energy.total - solution.energy.total[0]).max() < 1e-12 * solution.energy.total[0]
    assert solution.statistics.steps == solution.statistics.newton_iterations.size


class Bounded:
    """The midpoint rule, but steps longer than 0.03 s lead to infinity or NaN."""

    order = 2

    def __init__(self, nonsense):
        self.nonsense = nonsense

    def prepare(self, system):
        stepper = ph.Midpoint().prepare(system)
        step = stepper.step
        stepper.step = lambda x, theta, dt, u: self.spoilt(step(x, theta, dt, u))
        return stepper

    def spoilt(self, step):
        return dataclasses.replace(step, x=self.nonsense * step.x) if step and step.dt > 0.03 else step


@pytest.mark.parametrize("nonsense", [np.inf, np.nan])
@pytest.mark.filterwarnings("ignore:invalid value")
def test_a_method_of_the_users_that_leaves_all_bounds_is_given_shorter_steps(swing, nonsense):
    """The run does not hang, and what is allowed is as if the step had not been tried."""
    start, options = swing.rigid_motion(spin=2.0), {"adaptive": ph.Adaptive(rtol=1e-4)}
    sound, spoilt = (
        ph.simulate(swing, 0.2, dt, method=method, start=start, **options)
        for dt, method in ((0.01, ph.Midpoint()), (0.05, Bounded(nonsense)))
    )
    assert spoilt.status.ok and spoilt.statistics.rejections > 0
    assert spoilt.statistics.steps == pytest.approx(sound.statistics.steps, rel=0.2)
    gap = np.abs(spoilt.position("beam", 1.0)[-1] - sound.position("beam", 1.0)[-1]).max()
    assert gap < 1e-3


def test_named_outputs_are_watched(swing):
    outputs = tuple(swing.output_names)
    solution = run(swing, adaptive=ph.Adaptive(rtol=1e-4, outputs=outputs[:1]))
    loose = run(swing, adaptive=ph.Adaptive(rtol=0.0, atol=10.0, outputs=outputs[:1]))
    assert solution.status.ok and loose.statistics.steps < solution.statistics.steps
    exact = run(swing, 1e-8, ph.GaussLegendre(3))
    errors = [np.linalg.norm(s.position("beam", 1.0)[-1] - exact.position("beam", 1.0)[-1]) for s in (solution, loose)]
    assert errors[0] < 1e-3 and errors[0] < errors[1]
    with pytest.raises(UnknownNameError, match="'nonsense'"):
        run(swing, adaptive=ph.Adaptive(outputs=("nonsense",)))


def test_tolerances_that_cannot_be_met_end_the_run_with_the_results_so_far(swing):
    solution = run(swing, adaptive=ph.Adaptive(rtol=1e-7, shortest=1e-3))
    assert not solution.status.ok and solution.status.name == "step failed"
    assert "tolerances ask for shorter steps" in solution.status.text
    assert solution.t[-1] == pytest.approx(solution.status.time)


def test_steps_are_never_longer_than_allowed(swing):
    solution = run(swing, adaptive=ph.Adaptive(rtol=0.5, longest=0.02))
    assert np.diff(solution.t).max() <= 0.02 * (1 + 1e-12)


def test_energies_that_are_not_quadratic_are_measured_by_their_hessian():
    block = ph.CustomBlock(
        "pendulum",
        2,
        lambda x: 0.5 * x[1] ** 2 + 1.0 - np.cos(x[0]),
        lambda x: np.array([np.sin(x[0]), x[1]]),
        lambda x: np.diag([np.cos(x[0]), 1.0]),
        J=[[0, 1], [-1, 0]],
        start=[2.0, 0.0],
    )
    d = ph.Diagram("pendulum")
    d.add(block)
    system, errors = d.compile(), []
    exact = ph.simulate(system, 6.0, 2e-3).x[-1, :2]
    for rtol in (1e-2, 1e-4):
        solution = ph.simulate(system, 6.0, 0.1, adaptive=ph.Adaptive(rtol=rtol))
        assert solution.status.ok
        assert np.abs(solution.energy.total - solution.energy.total[0]).max() < 1e-12
        errors.append(np.abs(solution.x[-1, :2] - exact).max())
    assert errors[1] < 0.2 * errors[0] < 0.02


@pytest.mark.parametrize(
    "options",
    [
        {"rtol": -1.0},
        {"rtol": 0.0},
        {"rtol": np.nan},
        {"atol": -1.0},
        {"rtol": np.inf},
        {"shortest": 0.0},
        {"shortest": 1.0, "longest": 0.5},
    ],
)
def test_options_out_of_range(options):
    with pytest.raises(DataError, match="Adaptive"):
        ph.Adaptive(**options)


@pytest.mark.parametrize("options", [{"rtol": "1e-3"}, {"atol": None}, {"outputs": "tip"}, {"outputs": (1,)}])
def test_options_of_the_wrong_kind(options):
    with pytest.raises(ArgumentTypeError, match="Adaptive"):
        ph.Adaptive(**options)


@pytest.mark.parametrize("adaptive", [1e-3, ph.Adaptive, "yes"])
def test_simulate_takes_options_only(swing, adaptive):
    with pytest.raises(ArgumentTypeError, match="simulate adaptive"):
        run(swing, adaptive=adaptive)
