"""SciPy's integrators on the same system: the same motion, an energy that is not kept, and an honest ledger."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, MethodError
from phblocks.solvers.scipy_ivp import RateEquation


@pytest.mark.parametrize("linear", [False, True])
def test_the_jacobian_is_the_derivative_of_the_rates(scene, linear):
    system = scene.compile()
    equation = RateEquation(system.small_motions() if linear else system)
    rng = np.random.default_rng(0)
    y = equation.join(system.start)
    y, u = y + 0.3 * rng.standard_normal(y.size), rng.standard_normal(system.n_inputs)
    jacobian = equation.jacobian(y, u).toarray()
    h = 1e-6
    columns = [(equation.rates(y + h * e, u) - equation.rates(y - h * e, u)) / (2 * h) for e in np.eye(y.size)]
    np.testing.assert_allclose(jacobian, np.stack(columns, axis=1), atol=3e-8 * abs(jacobian).max())


def test_the_rates_are_those_of_the_system(scene):
    system = scene.compile()
    equation, rng = RateEquation(system), np.random.default_rng(1)
    x, theta = 0.1 * rng.standard_normal(system.n), rng.standard_normal(system.start.theta.size)
    u = rng.standard_normal(system.n_inputs)
    unknowns, spins, _ = equation.split(equation.rates(equation.join(ph.State(x, theta, system.start.points)), u))
    force = system.force(x, theta, u)
    size = 1.0 / np.sqrt(system.E.diagonal())
    np.testing.assert_allclose(
        size * (system.E @ equation.unpack(unknowns)), size * force, atol=1e-11 * abs(size * force).max()
    )
    np.testing.assert_allclose(spins, system.rates @ x + system.input_rates @ u, atol=1e-12)


@pytest.fixture(scope="module")
def swing() -> ph.System:
    """A soft thick beam on a pin under a force at its tip, and gravity."""
    section = ph.Section.rectangle(0.2, 0.2, young=1e6, poisson=0.3, density=2710.0, shear_factor=1.0)
    d = ph.Diagram("swing", gravity=(0.0, -1.0))
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(beam.start, d.ground)
    d.expose(beam.end.translation, "tip")
    return d.compile()


def run(system: ph.System, method, **options):
    force = {"tip": lambda t: (0.0, 150.0 * np.sin(np.pi * t) ** 8)}
    return ph.simulate(system, 1.0, 0.05, method=method, inputs=force, **options)


@pytest.mark.parametrize(("name", "rtol"), [("Radau", 1e-7), ("BDF", 1e-6), ("DOP853", 1e-8)])
def test_the_same_motion(swing, name, rtol):
    solution = run(swing, ph.ScipyIVP(name, rtol=rtol, atol=rtol))
    exact = ph.simulate(
        swing,
        1.0,
        0.005,
        method=ph.GaussLegendre(3),
        save_every=10,
        inputs={"tip": lambda t: (0.0, 150.0 * np.sin(np.pi * t) ** 8)},
    )
    assert solution.status.ok
    np.testing.assert_allclose(solution.t, exact.t, rtol=1e-14)
    for source in ("velocity", "strain"):
        ours, theirs = (s.position("beam", 1.0, source=source) for s in (exact, solution))
        assert np.abs(ours - theirs).max() < 1e3 * rtol
    np.testing.assert_allclose(theirs, ours, atol=1e3 * rtol)
    np.testing.assert_allclose(solution.energy.supplied, exact.energy.supplied, atol=1e5 * rtol)


@pytest.fixture(scope="module")
def swung(swing) -> np.ndarray:
    """Where the tip is at the end, m: three stages, 500 steps."""
    return run(swing, ph.GaussLegendre(3), times=np.arange(1, 501) / 500.0).position("beam", 1.0)[-1]


@pytest.mark.parametrize(("name", "loosest"), [("Radau", 1e-2), ("BDF", 1e-2), ("DOP853", 1e-5)])
def test_the_error_falls_with_the_tolerance(swing, swung, name, loosest):
    """On smooth data: a hundredth of the tolerance, at most a tenth of the error, down to 1e-5 m or less.

    Looser than 1e-5 the steps of the explicit method are those of its limit of stability.
    """
    errors = []
    for rtol in (loosest, 1e-2 * loosest, 1e-4 * loosest):
        solution = run(swing, ph.ScipyIVP(name, rtol=rtol, atol=rtol), limits=ph.Limits(balance=0.1))
        errors.append(np.linalg.norm(solution.position("beam", 1.0)[-1] - swung))
    assert errors[1] < 0.1 * errors[0] and errors[2] < 0.1 * errors[1] and errors[2] < 1e-5


def test_the_energy_error_is_shown_as_it_is(swing):
    """It falls with the tolerance; that of the midpoint rule does not depend on anything."""
    start = swing.rigid_motion(spin=2.0)
    drifts = []
    for rtol in (1e-3, 1e-5, 1e-6):
        solution = ph.simulate(swing, 1.0, 0.1, method=ph.ScipyIVP("Radau", rtol, rtol), start=start)
        total = solution.energy.total
        drifts.append(np.abs(total - total[0]).max())
        assert solution.max_power_balance_error >= 0.0 and solution.statistics.steps > 10
    assert drifts[0] > 10.0 * drifts[1] > 30.0 * drifts[2] > 1e-10


def test_saved_times_are_those_asked_for(swing):
    method, times = ph.ScipyIVP("DOP853"), [0.123, 0.5, 0.77]
    np.testing.assert_array_equal(run(swing, method, times=times).t, [0.0, *times, 1.0])
    np.testing.assert_allclose(run(swing, method, save_every=7).t, [0.0, 0.35, 0.7, 1.0])


def test_states_without_a_rate_are_refused_by_name():
    d = ph.Diagram("damped")
    mass, damper = d.add(ph.Mass("mass", 1.0, (1.0, 0.0))), d.add(ph.Damper("damper", 2.0, (0.0, 0.0), (1.0, 0.0)))
    d.pin(damper.start, d.ground)
    d.pin(damper.end, mass.centre)
    with pytest.raises(MethodError, match=r"E regular, got none for damper\."):
        ph.simulate(d.compile(), 1.0, 0.1, method=ph.ScipyIVP())


def test_a_signal_that_is_not_finite_stops_the_run(swing):
    solution = ph.simulate(
        swing, 1.0, 0.1, method=ph.ScipyIVP("DOP853"), inputs={"tip": lambda t: (0.0, np.nan if t > 0.5 else 1.0)}
    )
    assert solution.status.name == "input not finite" and 0.3 <= solution.t[-1] <= 0.5


@pytest.mark.parametrize("options", [{"method": "Euler"}, {"rtol": 0.0}, {"atol": -1.0}, {"rtol": np.nan}])
def test_options_out_of_range(options):
    with pytest.raises(DataError, match="ScipyIVP"):
        ph.ScipyIVP(**options)


def test_options_of_the_wrong_kind(swing):
    with pytest.raises(ArgumentTypeError, match="ScipyIVP"):
        ph.ScipyIVP(rtol="1e-3")
    with pytest.raises(ArgumentTypeError, match="simulate adaptive"):
        run(swing, ph.ScipyIVP(), adaptive=ph.Adaptive())
