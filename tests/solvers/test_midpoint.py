"""One step of the midpoint rule: its definition, its balance, its symmetry, its cost."""

import dataclasses

import numpy as np
import pytest

import phblocks as ph
from phblocks.solvers.linear import BandedSolver
from phblocks.solvers.midpoint import MidpointStepper

DT = 0.004


@pytest.fixture(params=["full", "small motions"])
def system(request, scene) -> ph.System:
    system = scene.compile()
    return system.small_motions() if request.param == "small motions" else system


def take(stepper: MidpointStepper, system: ph.System, dt: float = DT):
    """A step from a random state, with the inputs it was taken with."""
    rng = np.random.default_rng(0)
    x = 0.1 * rng.standard_normal(system.n) / np.sqrt(system.E.diagonal())
    theta, u = 0.1 * rng.standard_normal(system.start.theta.size), rng.standard_normal((1, system.n_inputs))
    step = stepper.step(stepper.stage.pack(x), theta, dt, u)
    assert step is not None
    return x, theta, u, step


def test_a_step_is_the_midpoint_rule(system):
    stepper = ph.Midpoint().prepare(system)
    x0, theta0, u, step = take(stepper, system)
    x1 = stepper.stage.unpack(step.x)
    z, theta_mid = 0.5 * (x0 + x1), 0.5 * (theta0 + step.theta)
    np.testing.assert_allclose(stepper.stage.unpack(step.z[0]), z, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(step.theta_z[0], theta_mid, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(step.theta, theta0 + DT * (system.rates @ z + system.input_rates @ u[0]), atol=1e-14)
    rate, force = system.E @ (x1 - x0) / DT, system.force(z, theta_mid, u[0])
    size = 1.0 / np.sqrt(system.E.diagonal())
    np.testing.assert_allclose(size * rate, size * force, atol=1e-11 * abs(size * force).max())
    assert step.dt == DT
    np.testing.assert_array_equal(step.u, u)


def test_energy_changes_by_what_is_supplied(system):
    stepper = ph.Midpoint().prepare(system)
    x0, _, u, step = take(stepper, system)
    z = stepper.stage.unpack(step.z[0])
    supplied = DT * (u[0] @ (system.G(step.theta_z[0]).T @ z) + z @ system.gravity_force(step.theta_z[0]))
    change = system.energy(stepper.stage.unpack(step.x)) - system.energy(x0)
    assert change == pytest.approx(supplied, abs=1e-13 * max(1.0, system.energy(x0)))


def test_a_step_back_leads_to_where_it_began(system):
    stepper = ph.Midpoint().prepare(system)
    x0, theta0, u, there = take(stepper, system)
    back = stepper.step(there.x, there.theta, -DT, u)
    assert back is not None
    energy = np.sqrt(2.0 * system.energy(x0))
    np.testing.assert_allclose(back.x, stepper.stage.pack(x0), atol=1e-11 * energy)
    np.testing.assert_allclose(back.theta, theta0, atol=1e-12)


def test_the_guess_changes_nothing_but_the_number_of_iterations(scenes):
    system = scenes["four-bar"].compile()
    stepper = ph.Midpoint().prepare(system)
    x0, theta0, u, step = take(stepper, system)
    good = stepper.step(stepper.stage.pack(x0), theta0, DT, u, guess=step.z)
    assert good is not None and good.iterations < step.iterations
    np.testing.assert_allclose(good.x, step.x, atol=1e-12 * np.linalg.norm(step.x))


def test_a_step_without_convergence_is_none(scenes):
    system = scenes["four-bar"].compile()
    stepper = ph.Midpoint(ph.Newton(max_iterations=1)).prepare(system)
    x = stepper.stage.pack(system.rigid_motion(spin=5.0).x)
    assert stepper.step(x, system.start.theta, 0.1, np.zeros((1, 0))) is None


# Linear systems: one kept factor


@pytest.fixture
def factorisations(monkeypatch) -> list[int]:
    """A list that grows by one with every banded factorisation."""
    count: list[int] = []
    true_factorise = BandedSolver.factorise

    def factorise(self, data):
        count.append(1)
        return true_factorise(self, data)

    monkeypatch.setattr(BandedSolver, "factorise", factorise)
    return count


@pytest.mark.parametrize("dt", [0.02, 0.1, 1.0 / 3.0, 0.007])
def test_one_factor_serves_a_whole_linear_run(scenes, factorisations, without_numba, dt):
    system = scenes["free"].compile().small_motions()
    solution = ph.simulate(system, t_end=200 * dt, dt=dt, inputs={"push": lambda t: (np.sin(t), 0.0)})
    assert solution.statistics.steps == 200 and not solution.statistics.newton_iterations.any()
    assert len(factorisations) == 1
    assert solution.max_power_balance_error < 1e-12 * max(1.0, solution.energy.total.max())


def test_a_shorter_last_step_needs_a_factor_of_its_own(scenes, factorisations, without_numba):
    system = scenes["free"].compile().small_motions()
    ph.simulate(system, t_end=0.25, dt=0.1)
    assert len(factorisations) == 2


def test_a_nonlinear_run_factorises_once_a_step_or_in_every_iteration(scenes, factorisations, without_numba):
    system = scenes["four-bar"].compile()
    kept = ph.simulate(system, t_end=0.4, dt=0.02)
    count = len(factorisations)
    assert 10 <= count <= 25 < kept.statistics.newton_iterations.sum()
    exact = ph.simulate(system, t_end=0.4, dt=0.02, method=ph.Midpoint(ph.Newton(), predict=False))
    assert len(factorisations) - count == exact.statistics.newton_iterations.sum()
    size = np.sqrt(2.0 * exact.energy.total.max() + 2.0 * exact.energy.kinetic.max())
    np.testing.assert_allclose(*(np.sqrt(system.E.diagonal()) * s.x for s in (kept, exact)), atol=1e-11 * size)


def test_a_linear_oscillator_has_the_frequency_of_the_rule(bar):
    """tan(w' dt / 2) = w dt / 2 for every mode: phase after 50 steps, amplitude unchanged."""
    d = ph.Diagram()
    b = d.add(ph.Beam("b", bar, (0.0, 0.0), (1.0, 0.0), elements=3))
    d.weld(b.start, d.ground)
    system = d.compile()
    modes = system.modes(1)
    frequency, shape = modes.frequencies[0], modes.shapes[:, 0]
    dt = 0.3 / frequency
    start = ph.State(np.real(shape), system.start.theta, system.start.points)
    solution = ph.simulate(system.small_motions(), t_end=50 * dt, dt=dt, start=start)
    phase = 50 * 2.0 * np.arctan(0.5 * 0.3)
    np.testing.assert_allclose(solution.x[-1], np.real(shape * np.exp(1j * phase)), atol=1e-9 * abs(shape).max())


def test_a_singular_linear_step_is_none(scenes):
    """Undamped, unloaded and without mass: nothing determines the states."""
    system = scenes["free"].compile().small_motions()
    empty = 0.0 * system.E
    empty.eliminate_zeros()
    nothing = dataclasses.replace(system, E=empty, J0=empty)
    stepper = ph.Midpoint().prepare(nothing)
    assert stepper.step(np.zeros(nothing.n), nothing.start.theta, DT, np.zeros((1, nothing.n_inputs))) is None
