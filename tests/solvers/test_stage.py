"""The stage equation against System.J, G and gravity_force, and its Jacobian against differences."""

import numpy as np
import pytest
import scipy.sparse as sp

import phblocks as ph
from phblocks.solvers.stage import StageEquation

MASS_FACTOR, TAU = 70.0, 0.013


@pytest.fixture(params=["full", "small motions", "lean"])
def system(request, scene) -> ph.System:
    """Every scene: as it is, linear, and compiled without outputs."""
    if request.param == "lean":
        return scene.compile(outputs=None)
    system = scene.compile()
    return system.small_motions() if request.param == "small motions" else system


class Problem:
    """A stage with random data, and the same equation written with the matrices of the system."""

    def __init__(self, system: ph.System, seed: int = 0) -> None:
        rng = np.random.default_rng(seed)
        self.system, self.stage = system, StageEquation(system)
        self.size = 1.0 / np.sqrt(system.E.diagonal())
        self.x, self.z = rng.standard_normal((2, system.n)) * self.size
        self.theta = rng.standard_normal(system.start.theta.size)
        self.u = rng.standard_normal(system.n_inputs)
        self.stage.begin(
            MASS_FACTOR, TAU, self.theta, self.u, MASS_FACTOR * self.stage.momentum(self.stage.pack(self.x))
        )

    def residual(self, z: np.ndarray) -> np.ndarray:
        s = self.system
        theta = self.theta + TAU * (s.rates @ z + s.input_rates @ self.u)
        return MASS_FACTOR * (s.E @ (z - self.x)) - s.force(z, theta, self.u)

    def scaled(self, force: np.ndarray) -> np.ndarray:
        """Forces in the units and the order of the stage."""
        return (force * self.size)[self.stage.order]


@pytest.mark.parametrize("seed", range(2))
def test_the_residual_is_the_equation_of_motion(system, seed):
    p = Problem(system, seed)
    residual, _ = p.stage.evaluate(p.stage.pack(p.z))
    expected = p.scaled(p.residual(p.z))
    np.testing.assert_allclose(residual, expected, atol=1e-12 * abs(expected).max())


def test_the_residual_alone_is_the_same(system):
    p = Problem(system)
    z = p.stage.pack(p.z)
    expected, _ = p.stage.evaluate(z)
    np.testing.assert_allclose(p.stage.residual(z), expected, atol=1e-13 * abs(expected).max())


def test_the_jacobian_is_its_derivative(system):
    p = Problem(system)
    z = p.stage.pack(p.z)
    _, entries = p.stage.evaluate(z)
    n = p.stage.n
    jacobian = sp.coo_array((entries, (p.stage.rows, p.stage.columns)), shape=(n, n)).toarray()
    h = 1e-6
    for j in range(n):
        step = np.zeros(n)
        step[j] = h
        difference = (p.stage.evaluate(z + step)[0] - p.stage.evaluate(z - step)[0]) / (2 * h)
        np.testing.assert_allclose(jacobian[:, j], difference, atol=3e-8 * abs(jacobian).max())


def test_the_jacobian_is_that_of_the_matrices_too(system):
    """Through the other road: differences of the residual written with System.force."""
    p = Problem(system, 1)
    _, entries = p.stage.evaluate(p.stage.pack(p.z))
    n = p.stage.n
    jacobian = sp.coo_array((entries, (p.stage.rows, p.stage.columns)), shape=(n, n)).toarray()
    direction = np.random.default_rng(5).standard_normal((3, n)) * p.size
    for d in direction:
        difference = p.scaled((p.residual(p.z + 1e-6 * d) - p.residual(p.z - 1e-6 * d)) / 2e-6)
        found = jacobian @ p.stage.pack(d)
        np.testing.assert_allclose(found, difference, atol=1e-7 * abs(difference).max())


def test_evaluating_leaves_no_trace(system):
    p = Problem(system)
    z = p.stage.pack(p.z)
    first, entries = p.stage.evaluate(z)
    first, entries = first.copy(), entries.copy()
    p.stage.evaluate(2.0 * z)
    again, same = p.stage.evaluate(z)
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(entries, same)
    np.testing.assert_array_equal(z, p.stage.pack(p.z))


def test_beginning_anew_forgets_the_last_stage(system):
    p, q = Problem(system, 0), Problem(system, 1)
    p.stage.begin(MASS_FACTOR, TAU, q.theta, q.u, MASS_FACTOR * p.stage.momentum(p.stage.pack(q.x)))
    for found, expected in zip(p.stage.evaluate(p.stage.pack(q.z)), q.stage.evaluate(q.stage.pack(q.z)), strict=True):
        np.testing.assert_array_equal(found, expected)


def test_unknowns_are_states_in_units_of_energy(system):
    p = Problem(system)
    packed = p.stage.pack(p.x)
    np.testing.assert_allclose(p.stage.unpack(packed), p.x, rtol=1e-15)
    both = np.stack([p.x, p.z])
    np.testing.assert_allclose(p.stage.unpack(p.stage.pack(both)), both, rtol=1e-15)
    energy = system.energy(p.x)
    assert 0.5 * packed @ p.stage.momentum(packed) == pytest.approx(energy, rel=1e-12)
    assert 0.1 * energy < 0.5 * packed @ packed < 10.0 * energy
    spin = system.rates @ p.x + system.input_rates @ p.u
    np.testing.assert_allclose(p.stage.spin(packed, p.u), spin, rtol=1e-12, atol=1e-12)


def test_entries_are_sorted_by_rows_and_unique(system):
    stage = StageEquation(system)
    code = stage.rows * stage.n + stage.columns
    assert (np.diff(code) > 0).all()
    assert sorted(stage.order) == list(range(stage.n))
    assert stage.constant == system.linear


def test_round_off_is_estimated_within_a_few_digits(system):
    """Noise of one unit in the last place on every entry moves the residual by about as much as is estimated."""
    p = Problem(system)
    z = p.stage.pack(p.z)
    p.stage.evaluate(z)
    estimate = p.stage.round_off(z)
    noisy = z * (1.0 + np.finfo(float).eps * np.random.default_rng(0).choice([-1.0, 1.0], z.size))
    moved = np.linalg.norm(p.stage.evaluate(noisy)[0] - p.stage.evaluate(z)[0])
    assert 0.01 * moved <= estimate <= 100.0 * moved
