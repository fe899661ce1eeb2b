"""Linear models against differences of the nonlinear right-hand side."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import DataError


@pytest.fixture
def system(scene) -> ph.System:
    return scene.compile()


def differences(function, at: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Central differences column by column."""
    columns = []
    for i, size in enumerate(sizes):
        step = np.zeros(at.size)
        step[i] = 1e-5 * size
        columns.append((function(at + step) - function(at - step)) / (2e-5 * size))
    return np.stack(columns, axis=1) if columns else np.zeros((function(at).size, 0))


def test_derivatives_of_the_right_hand_side_and_the_outputs(system):
    rng = np.random.default_rng(0)
    size = 1.0 / np.sqrt(system.E.diagonal())
    x, u = rng.standard_normal(system.n) * size, rng.standard_normal(system.n_inputs)
    theta = rng.standard_normal(system.start.theta.size)
    linear = system.linearize(ph.State(x, theta, system.start.points), u)
    n, ones = system.n, np.ones(theta.size)
    A, B, C = linear.A.toarray(), linear.B.toarray(), linear.C.toarray()

    def close(found, expected):  # in units of energy
        scaled = size[:n, None] * (found - expected)
        assert abs(scaled).max(initial=0.0) <= 1e-6 * max(1.0, abs(size[:n, None] * expected).max(initial=0.0))

    assert linear.n == n
    close(A[:n, :n] * size, differences(lambda v: system.force(v, theta, u), x, size) * size)
    close(B[:n], differences(lambda v: system.force(x, theta, v), u, np.ones(u.size)))
    kept = linear.theta
    dropped = np.setdiff1d(np.arange(theta.size), kept)
    by_theta = differences(lambda v: system.force(x, v, u), theta, ones)
    slopes = differences(lambda v: system.G(v).T @ x, theta, ones)
    # rotation states are left out only where nothing depends on them
    assert abs(size[:n, None] * by_theta[:, dropped]).max(initial=0.0) <= 1e-6 and not slopes[:, dropped].any()
    close(A[:n, n:], by_theta[:, kept])
    np.testing.assert_array_equal(A[n:, :n], system.rates.toarray()[kept])
    np.testing.assert_array_equal(A[n:, n:], 0.0)
    np.testing.assert_array_equal(B[n:], system.input_rates.toarray()[kept])
    np.testing.assert_allclose(C[:, n:], slopes[:, kept], atol=1e-7 * max(1.0, abs(slopes).max(initial=0.0)))
    np.testing.assert_array_equal(linear.E.toarray()[n:, n:], np.eye(kept.size))
    np.testing.assert_array_equal(C[:, :n], system.G(theta).T.toarray())
    assert not linear.D.toarray().any()


def test_at_rest_without_gravity_only_the_states_matter(scenes):
    linear = scenes["free"].compile().linearize()
    assert linear.A.shape == (linear.n, linear.n)
    assert abs(linear.A + linear.A.T).max() <= 1e-12 * abs(linear.A).max()


def test_small_motions_are_the_linearisation_with_angles_held(system):
    small = system.small_motions()
    assert small.linear and not system.linear
    linear = system.linearize()
    n = system.n
    assert abs(small.J() - linear.A[:n, :n]).max() <= 1e-13 * abs(small.J()).max()
    np.testing.assert_allclose(small.gravity_force(), system.gravity_force(), atol=1e-13)
    assert abs(small.G() - system.G()).max() == 0.0 if system.n_inputs else small.n_inputs == 0
    assert small.state_names == system.state_names and small.input_names == system.input_names


def test_small_motions_follow_the_full_system_while_they_are_small(scenes):
    """A frame under a load of 1e-3 N, without gravity: the difference is of second order."""
    d = scenes["frame"]
    light = ph.Diagram("light")
    for name in ("left", "top", "right"):
        light.add(d.network.blocks[name])
    left, top, right = (light.network.blocks[n] for n in ("left", "top", "right"))
    light.weld(left.start, light.ground)
    light.weld(left.end, top.start)
    light.weld(top.end, right.start)
    light.weld(right.end, light.ground)
    light.expose(top.end.translation, "load")
    full = light.compile()
    runs = [ph.simulate(s, t_end=0.05, dt=1e-3, inputs={"load": (1e-3, -2e-3)}) for s in (full, full.small_motions())]
    size = np.sqrt(full.E.diagonal())
    x, y = (run.x * size for run in runs)
    assert np.abs(y).max() > 1e-6
    assert np.abs(x - y).max() <= 1e-4 * np.abs(y).max()
    moved = [run.position("top", 0.5) - run.position("top", 0.5)[0] for run in runs]
    np.testing.assert_allclose(moved[0], moved[1], atol=2e-4 * np.abs(moved[1]).max())


# Modes


def test_modes_are_eigenpairs_of_the_linearisation(scenes):
    system = scenes["shaken"].compile()
    linear, modes = system.linearize(), system.modes(4)
    assert modes.frequencies.shape == (4,) and (np.diff(modes.frequencies) > 0.0).all()
    np.testing.assert_allclose(modes.growth, 0.0, atol=1e-9 * modes.frequencies[0])
    np.testing.assert_allclose(modes.hertz * 2 * np.pi, modes.frequencies, rtol=1e-15)
    for shape, frequency in zip(modes.shapes.T, modes.frequencies, strict=True):
        residual = linear.A @ shape - 1j * frequency * (linear.E @ shape)
        assert np.linalg.norm(residual) <= 1e-9 * np.linalg.norm(linear.A @ shape)
        assert (shape.conj() @ (linear.E @ shape)).real == pytest.approx(2.0)


def test_modes_of_a_pendulum_under_gravity(bar):
    """Hanging: the lowest mode is the swing of a rigid bar, omega^2 = 3 g / (2 L)."""
    d = ph.Diagram(gravity=(0.0, -9.81))
    b = d.add(ph.Beam("b", bar, (0.0, 0.0), (0.0, -2.0), elements=4, degree=2))
    d.pin(b.start, d.ground)
    modes = d.compile(effects="all").modes(1)
    # about the straight bar without the tension of its weight: gravity acts on the angle alone
    assert modes.frequencies[0] == pytest.approx(np.sqrt(1.5 * 9.81 / 2.0), rel=2e-3)


@pytest.mark.parametrize("n", [0, -1, 1.5, "3", None, True])
def test_numbers_of_modes(scenes, n):
    with pytest.raises(DataError, match="modes n: expected a positive integer"):
        scenes["four-bar"].compile().modes(n)
