"""Matrices that depend on the state, in a stage: residual, Jacobian, and the balance of a step."""

import numpy as np
import pytest
import scipy.sparse as sp

import phblocks as ph
from phblocks.solvers.stage import StageEquation

LINE = ph.Domain("line", ph.Quantity("velocity", "m/s"), ph.Quantity("force", "N"))


def build(feedthrough: bool) -> ph.System:
    """A block of three states with an anharmonic energy, beside a mass and a spring."""
    d = ph.Diagram("three")

    def J(x):
        return np.array([[0.0, 1.0 + x[2] ** 2, -x[1]], [-1.0 - x[2] ** 2, 0.0, x[0]], [x[1], -x[0], 0.0]])

    options = {"G": [[1.0, 0.0], [0.5, 0.2], [0.0, 1.0]]}
    if feedthrough:
        options = {"G": lambda x: [[np.cos(x[0]), 0.0], [0.5, x[1]], [0.0, 1.0]], "S": 0.3 * np.eye(2)}
        options["N"] = lambda x: [[0.0, x[0] * x[1]], [-x[0] * x[1], 0.0]]
    block = d.add(
        ph.CustomBlock(
            "block",
            3,
            lambda x: x @ x / 2.0 + (x @ x) ** 2,
            lambda x: x + 4.0 * (x @ x) * x,
            lambda x: (1.0 + 4.0 * (x @ x)) * np.eye(3) + 8.0 * np.outer(x, x),
            J=J,
            R=lambda x: np.outer(x, x),
            **options,
            ports={"driven": ph.SystemPort(LINE, (0,), "velocity"), "joined": ph.SystemPort(LINE, (1,), "velocity")},
            start=[0.4, -0.5, 0.9],
        )
    )
    mass = d.add(ph.Capacitor("mass", 2.0, domain=LINE, energy="kinetic"))
    spring = d.add(ph.Inductor("spring", 0.3, domain=LINE, energy="strain"))
    d.connect(block["joined"], spring.p)
    d.connect(spring.n, mass.p)
    d.connect(mass.n, d.add(ph.Reference("wall", LINE)).port)
    d.expose(block["driven"], "force")
    return d.compile()


@pytest.fixture(params=[False, True], ids=["plain", "feedthrough"])
def system(request) -> ph.System:
    return build(request.param)


@pytest.mark.parametrize("discrete", [True, False])
def test_the_jacobian_of_the_stage(system, discrete):
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


def test_the_residual_is_the_equation_of_motion(system):
    stage, rng = StageEquation(system), np.random.default_rng(3)
    z, x = rng.standard_normal((2, system.n))
    u = np.array([0.4])
    stage.begin(40.0, 0.0125, system.start.theta, u, 40.0 * stage.momentum(stage.pack(x)))
    residual, _ = stage.evaluate(stage.pack(z))
    expected = 40.0 * system.rate_matrix @ (z - x) - system.force(z, u=u)
    np.testing.assert_allclose(residual / stage.scale, expected[stage.order], atol=1e-12)


def test_the_balance_of_a_driven_system_is_exact(system):
    values = 2.0 * np.random.default_rng(4).standard_normal(500)
    solution = ph.simulate(system, 15.0, 0.03, inputs={"force": lambda t: values[int(t / 0.03)]})
    assert solution.status.ok
    assert solution.energy.supplied[-1] > 1.0 and solution.energy.dissipated[-1] > 1.0
    assert solution.max_power_balance_error < 1e-12 * solution.energy.total.max()
    assert np.mean(solution.statistics.newton_iterations) < 6


def test_other_systems_have_none_of_it():
    d = ph.Diagram("mass")
    d.add(ph.Mass("m", 1.0, (0.0, 0.0)))
    system = d.compile()
    assert system.modulations == () and system.R is system.R0
    assert StageEquation(system)._modulated is None
