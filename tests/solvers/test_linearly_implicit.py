"""Linearly implicit steps: their definition, their balance, what they do not keep, and how they say so."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, MethodError

DT = 0.004


@pytest.mark.parametrize("corrections", [0, 1])
def test_a_step_takes_the_structure_where_it_says(scene, corrections):
    """E (x1 - x0) = dt ((J(x*, theta*) - R) z + gravity(theta*) + G(theta*) u), theta* = theta + dt/2 theta'(x*)."""
    system = scene.compile()
    stepper = ph.LinearlyImplicit(corrections).prepare(system)
    rng = np.random.default_rng(0)
    size = 1.0 / np.sqrt(system.E.diagonal())
    x0, guess = 0.1 * rng.standard_normal((2, system.n)) * size
    theta, u = 0.1 * rng.standard_normal(system.start.theta.size), rng.standard_normal((1, system.n_inputs))
    step = stepper.step(stepper.stage.pack(x0), theta, DT, u, guess=stepper.stage.pack(guess)[None])
    assert step is not None and step.iterations == 1 + corrections
    at, z, x1 = (stepper.stage.unpack(v) for v in (step.frozen[0], step.z[0], step.x))
    if corrections == 0:
        np.testing.assert_allclose(at, guess, rtol=1e-14)
    turned = theta + 0.5 * DT * (system.rates @ at + system.input_rates @ u[0])
    np.testing.assert_allclose(step.theta_z[0], turned, atol=1e-14)
    force = (system.J(at, turned) - system.R) @ z + system.gravity_force(turned) + system.G(turned) @ u[0]
    rate = system.E @ (x1 - x0) / DT
    np.testing.assert_allclose(size * rate, size * force, atol=1e-11 * abs(size * force).max())
    np.testing.assert_allclose(step.theta, theta + DT * (system.rates @ z + system.input_rates @ u[0]), atol=1e-14)
    supplied = DT * (u[0] @ (system.G(turned).T @ z) + z @ system.gravity_force(turned))
    change = system.energy(x1) - system.energy(x0)
    assert change == pytest.approx(supplied, abs=1e-13 * max(1.0, system.energy(x0)))
    lag = np.sqrt((z - at) @ (system.E @ (z - at)) / (z @ (system.E @ z)))
    assert 0.3 * lag < step.lag < 3.0 * lag


def test_a_run_keeps_all_its_books(scene):
    signals = {"load": (0.3, -0.2), "drive": lambda t: np.sin(3 * t), "force": (0.1, 0.4), "moment": 0.02}
    signals |= {"table": lambda t: (0.1 * np.cos(5 * t), 0.0), "hold": 0.0, "joint": (0.0, 0.3), "push": (0.2, 0.1)}
    system = scene.compile()
    known = {i.exposure for i in system.inputs}
    solution = ph.simulate(
        system, 0.4, DT, method=ph.LinearlyImplicit(), inputs={k: v for k, v in signals.items() if k in known}
    )
    assert solution.status.ok
    ledger, scale = solution.recording.ledger, max(1.0, abs(solution.energy.total).max())
    assert solution.max_power_balance_error < 1e-12 * scale
    assert ledger.block_error.max() < 1e-11 * scale and ledger.connection_error.max(initial=0.0) < 1e-11 * scale


def test_it_begins_with_the_midpoint_rule_and_ends_near_it(four_bar):
    system = four_bar().compile()
    run, same = (ph.simulate(system, 0.2, 0.0025, method=m) for m in (ph.LinearlyImplicit(), ph.Midpoint()))
    size = np.sqrt(system.E.diagonal())
    np.testing.assert_allclose(size * run.x[:4], size * same.x[:4], atol=1e-12 * abs(size * same.x).max())
    lag = run.statistics.lag
    assert not lag[:3].any() and (lag[3:] > 0.0).all() and not same.statistics.lag.any()
    assert "structure off by" in str(run.statistics) and "structure" not in str(same.statistics)
    distance = np.abs(run.position("coupler", 0.5) - same.position("coupler", 0.5)).max()
    assert 1e-12 < distance < 1e-5


def test_corrections_lead_to_the_midpoint_rule(four_bar):
    system = four_bar().compile()
    exact = ph.simulate(system, 0.2, 0.01).x
    size = np.sqrt(system.E.diagonal())
    errors = [
        np.abs(size * (ph.simulate(system, 0.2, 0.01, method=ph.LinearlyImplicit(n)).x - exact)).max()
        for n in (0, 1, 2, 4)
    ]
    assert errors[1] < 0.5 * errors[0] and errors[2] < 0.1 * errors[1] and errors[3] < 1e-2 * errors[2]


def test_a_linear_system_is_integrated_by_the_midpoint_rule(scenes):
    system = scenes["free"].compile().small_motions()
    options = {"inputs": {"push": lambda t: (np.sin(t), 0.0)}}
    one, two = (ph.simulate(system, 1.0, 0.05, method=m, **options) for m in (ph.LinearlyImplicit(), ph.Midpoint()))
    np.testing.assert_array_equal(one.x, two.x)


def test_steps_may_change_in_length(four_bar):
    """Times that cut steps short: the extrapolation knows the lengths, and the path stays second-order accurate."""
    system = four_bar().compile()
    times = np.cumsum(np.tile([0.0025, 0.001, 0.0017], 20))
    run = ph.simulate(system, times[-1], 0.0025, method=ph.LinearlyImplicit(), times=times)
    same = ph.simulate(system, times[-1], 0.0025, times=times)
    assert np.abs(run.position("coupler", 0.5) - same.position("coupler", 0.5)).max() < 1e-5
    assert np.abs(run.energy.total - run.energy.total[0]).max() < 1e-11


def test_the_energy_of_a_spring_is_kept_its_length_to_second_order():
    """The direction is frozen: elongation by force and distance of the ends separate, by 4 times less at dt/2."""
    d = ph.Diagram("elastic pendulum", gravity=(0.0, -9.81))
    mass = d.add(ph.Mass("mass", 1.0, (1.0, 0.0)))
    spring = d.add(ph.Spring("spring", 40.0, (0.0, 0.0), (1.0, 0.0), free_length=0.9))
    d.pin(spring.start, d.ground)
    d.pin(spring.end, mass.centre)
    system, gaps = d.compile(), []
    for dt in (0.02, 0.01, 0.005):
        solution = ph.simulate(system, 5.0, dt, method=ph.LinearlyImplicit())
        assert np.abs(solution.energy.total - solution.energy.total[0]).max() < 1e-11
        assert solution.max_power_balance_error < 1e-12
        span = np.hypot(*solution.x[:, system.lines.spans[0]].T)
        gaps.append(np.abs(span - system.lines.lengths(solution.x.T)[0]).max())
    assert np.log2(gaps[0] / gaps[1]) > 1.7 and np.log2(gaps[1] / gaps[2]) > 1.7 and gaps[0] > 1e-9


def test_energies_that_are_not_quadratic_are_refused():
    block = ph.CustomBlock(
        "q", 2, lambda x: x @ x / 2, lambda x: x, lambda x: np.eye(2), J=[[0, 1], [-1, 0]], start=[1, 0]
    )
    d = ph.Diagram("custom")
    d.add(block)
    with pytest.raises(MethodError, match="LinearlyImplicit"):
        ph.simulate(d.compile(), 1.0, 0.1, method=ph.LinearlyImplicit())


def test_options_are_checked():
    with pytest.raises(DataError, match="corrections"):
        ph.LinearlyImplicit(corrections=-1)
    for options in ({"corrections": 1.0}, {"corrections": True}, {"newton": 3}):
        with pytest.raises(ArgumentTypeError, match="LinearlyImplicit"):
            ph.LinearlyImplicit(**options)
