"""The discrete gradient: exact energy, order two, its derivative, and when it is chosen."""

import numpy as np
import pytest
import scipy.sparse as sp

import phblocks as ph
from phblocks.errors import ArgumentTypeError, MethodError
from phblocks.solvers.stage import StageEquation

LINE = ph.Domain("line", ph.Quantity("velocity", "m/s"), ph.Quantity("force", "N"))
COUPLING = np.array([[2.0, -1.0, 0.3], [-1.0, 1.5, 0.0], [0.3, 0.0, 1.0]])


def hamiltonian(x):
    return 0.5 * x @ COUPLING @ x + 0.25 * (x @ x) ** 2 + np.cosh(x[0] - x[1])


def gradient(x):
    return COUPLING @ x + (x @ x) * x + np.sinh(x[0] - x[1]) * np.array([1.0, -1.0, 0.0])


def hessian(x):
    d = np.array([1.0, -1.0, 0.0])
    return COUPLING + (x @ x) * np.eye(3) + 2.0 * np.outer(x, x) + np.cosh(x[0] - x[1]) * np.outer(d, d)


def build(damping=0.0, start=(0.9, -0.5, 0.4)) -> ph.System:
    """Three states with an energy of products, beside a mass and a spring with quadratic ones."""
    d = ph.Diagram("three")
    J = np.array([[0.0, 1.0, -0.4], [-1.0, 0.0, 0.7], [0.4, -0.7, 0.0]])
    ports = {"driven": ph.SystemPort(LINE, (0,), "velocity"), "joined": ph.SystemPort(LINE, (1,), "velocity")}
    block = d.add(
        ph.CustomBlock(
            "block",
            3,
            hamiltonian,
            gradient,
            hessian,
            J=J,
            R=damping * np.diag([1.0, 0.0, 2.0]),
            G=[[1.0, 0.0], [0.5, 0.2], [0.0, 1.0]],
            ports=ports,
            start=start,
        )
    )
    mass = d.add(ph.Capacitor("mass", 2.0, domain=LINE, energy="kinetic"))
    spring = d.add(ph.Inductor("spring", 0.3, domain=LINE, energy="strain"))
    d.connect(block["joined"], spring.p)
    d.connect(spring.n, mass.p)
    d.connect(mass.n, d.add(ph.Reference("wall", LINE)).port)
    d.expose(block["driven"], "force")
    return d.compile()


def test_the_energy_of_a_step_is_exact():
    (storage,) = build().storages
    rng = np.random.default_rng(0)
    for size in (1.0, 1e-2, 1e-4, 1e-7):
        before = rng.standard_normal(3)
        middle = before + size * rng.standard_normal(3)
        after = 2.0 * middle - before
        found, _, noise = storage.discrete_gradient(before, middle)
        change = hamiltonian(after) - hamiltonian(before)
        assert found @ (after - before) == pytest.approx(change, abs=1e-14 * hamiltonian(before))
        assert noise < 1e-14 / size
    found, slope, _ = storage.discrete_gradient(before, before)
    np.testing.assert_array_equal(found, gradient(before))
    np.testing.assert_array_equal(slope, hessian(before))


@pytest.mark.parametrize("size", [1.0, 0.1])
def test_its_derivative(size):
    (storage,) = build().storages
    before, middle, h = np.array([0.3, -0.8, 0.2]), np.array([0.3, -0.8, 0.2]) + size * np.array([0.5, 0.2, -0.3]), 1e-5
    _, slope, _ = storage.discrete_gradient(before, middle)
    ends = [[storage.discrete_gradient(before, middle + s * d)[0] for s in (1, -1)] for d in h * np.eye(3)]
    expected = np.stack([(a - b) / (2.0 * h) for a, b in ends], axis=1)
    np.testing.assert_allclose(slope, expected, atol=1e-8)


@pytest.mark.parametrize("discrete", [True, False])
def test_the_jacobian_of_the_stage(discrete):
    system = build(damping=0.3)
    stage, rng = StageEquation(system), np.random.default_rng(2)
    x, z = rng.standard_normal((2, system.n))
    stage.begin(40.0, 0.0125, system.start.theta, np.ones(1), 40.0 * stage.momentum(x), x if discrete else None)
    _, entries = stage.evaluate(z)
    jacobian = sp.coo_array((entries, (stage.rows, stage.columns)), shape=(system.n,) * 2).toarray()
    h = 1e-5
    expected = np.stack(
        [(stage.evaluate(z + d)[0] - stage.evaluate(z - d)[0]) / (2.0 * h) for d in h * np.eye(system.n)], axis=1
    )
    np.testing.assert_allclose(jacobian, expected, atol=1e-7)


def test_without_discrete_gradient_the_stage_is_the_equation_of_motion():
    system = build(damping=0.3)
    stage, rng = StageEquation(system), np.random.default_rng(3)
    z, x = rng.standard_normal((2, system.n))
    u = np.array([0.4])
    stage.begin(40.0, 0.0125, system.start.theta, u, 40.0 * stage.momentum(stage.pack(x)))
    residual, _ = stage.evaluate(stage.pack(z))
    expected = 40.0 * system.rate_matrix @ (z - x) - system.force(z, u=u)
    np.testing.assert_allclose(residual / stage.scale, expected[stage.order], atol=1e-12)


def test_the_balance_of_a_driven_system_is_exact():
    system = build(damping=0.2)
    values = 5.0 * np.random.default_rng(4).standard_normal(2000)
    solution = ph.simulate(system, 60.0, 0.03, inputs={"force": lambda t: values[int(t / 0.03)]})
    assert solution.status.name == "success"
    assert solution.energy.supplied[-1] > 10.0
    assert solution.max_power_balance_error < 1e-13 * solution.energy.total.max()
    for x in solution.x[::100]:
        np.testing.assert_allclose(x, system.settled(x), atol=1e-12)


def test_energy_over_a_long_run_and_the_default_method():
    system = build()
    solution = ph.simulate(system, 100.0, 0.05)  # nothing given: the discrete gradient
    assert np.ptp(solution.energy.total) < 1e-11
    assert np.mean(solution.statistics.newton_iterations) < 5
    start = system.energy(system.start.x)
    assert solution.energy.total[0] == pytest.approx(start, rel=1e-15)
    again = ph.simulate(system, 100.0, 0.05, method=ph.Midpoint(allow_energy_error=True))
    assert np.ptp(again.energy.total) > 1e-6


def test_at_rest_it_stays():
    system = build(start=(0.0, 0.0, 0.0))
    solution = ph.simulate(system, 1.0, 0.1)
    assert np.abs(solution.x).max() < 1e-15


def test_order_two():
    system = build(damping=0.1)

    def end(dt):  # multipliers are those over a step
        return ph.simulate(system, 2.0, dt, inputs={"force": np.sin}).x[-1][~system.algebraic | system.coenergy]

    fine = end(0.1 / 64)
    steps = np.array([0.1, 0.05, 0.025])
    order = np.polyfit(np.log(steps), np.log([np.abs(end(dt) - fine).max() for dt in steps]), 1)[0]
    assert order == pytest.approx(ph.DiscreteGradient.order, abs=0.1)


def test_quadratic_systems_are_integrated_by_the_midpoint_rule():
    d = ph.Diagram("beam", gravity=(0.0, -9.81))
    section = ph.Section.rectangle(width=0.05, height=0.05, young=2e7, poisson=0.3, density=1000.0, shear_factor=1.0)
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(beam.start, d.ground)
    system = d.compile()
    same = ((ph.Midpoint(ph.Newton(), predict=False), ph.DiscreteGradient()), (ph.Midpoint(), None))
    for methods in same:
        first, second = (ph.simulate(system, 0.1, 0.01, method=m) for m in methods)
        np.testing.assert_array_equal(first.x, second.x)


def test_a_user_quadratic_energy_gives_the_midpoint_rule():
    matrix = np.array([[2.0, 0.5], [0.5, 1.0]])
    block = ph.CustomBlock(
        "q", 2, lambda x: x @ matrix @ x / 2, lambda x: matrix @ x, lambda x: matrix, J=[[0, 1], [-1, 0]], start=[1, 0]
    )
    d = ph.Diagram("quadratic")
    d.add(block)
    system = d.compile()
    one, two = (ph.simulate(system, 10.0, 0.1, method=m) for m in (None, ph.Midpoint(allow_energy_error=True)))
    np.testing.assert_allclose(one.x, two.x, atol=1e-12)


def test_midpoint_is_refused_by_name():
    with pytest.raises(MethodError, match=r"Midpoint for system 'three'.*'block'.*ph\.DiscreteGradient\(\)"):
        ph.simulate(build(), 1.0, 0.1, method=ph.Midpoint())


def test_options_are_checked():
    with pytest.raises(ArgumentTypeError, match="DiscreteGradient newton"):
        ph.DiscreteGradient(newton="fast")


def test_an_energy_that_overflows_where_newton_goes_is_no_warning():
    """H = cosh(x) hit so hard that the first update leads to x = 3000: the step is halved until it succeeds."""
    block = ph.CustomBlock(
        "b",
        2,
        lambda x: np.cosh(x[0]) + 0.5 * x[1] ** 2,
        lambda x: np.array([np.sinh(x[0]), x[1]]),
        lambda x: np.diag([np.cosh(x[0]), 1.0]),
        J=[[0.0, 1.0], [-1.0, 0.0]],
        start=[0.0, 3000.0],
    )
    d = ph.Diagram()
    d.add(block)
    solution = ph.simulate(d.compile(), 2.0, 1.0, max_halvings=14, limits=ph.Limits(halvings=1.0))
    assert solution.status.ok and solution.statistics.halvings > 0
    assert np.ptp(solution.energy.total) < 1e-10 * solution.energy.total[0]
