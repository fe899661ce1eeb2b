"""Joint forces and other states without a rate, at the saved times: against a pendulum worked out by hand."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.results.middles import Middles

m, J, r, g = 2.0, 0.3, 0.5, 9.81


@pytest.fixture(scope="module")
def pendulum() -> ph.System:
    """A rigid body that hangs on a pin with multipliers, released with its centre at the height of the pin."""
    d = ph.Diagram("pendulum", gravity=(0.0, -g))
    body = d.add(ph.RigidBody("body", m, J, (r, 0.0), {"pin": (0.0, 0.0)}))
    d.pin(body["pin"], d.ground, multiplier=True)
    return d.compile()


def by_hand(solution: ph.Solution) -> np.ndarray:
    """Force of the pin on the body: mass times acceleration of the centre, and the weight; shape (times, 2)."""
    angle, spin = solution.angle("body", (0.0, 0.0)), solution.spin("body", (0.0, 0.0))
    spun_up = -m * g * r * np.cos(angle) / (J + m * r**2)
    along, across = np.stack([np.cos(angle), np.sin(angle)], 1), np.stack([-np.sin(angle), np.cos(angle)], 1)
    acceleration = r * spun_up[:, None] * across - r * spin[:, None] ** 2 * along
    return m * acceleration + np.array([0.0, m * g])


def multipliers(solution: ph.Solution) -> np.ndarray:
    return solution.x[:, solution.system.algebraic]


def test_at_release_it_carries_what_inertia_does_not(pendulum):
    """m g (1 - m r^2 / (J + m r^2)), 7.36 N: the first row, where the start itself has no forces."""
    expected = (0.0, m * g * J / (J + m * r**2))
    assert expected[1] == pytest.approx(7.3575)
    errors = [
        np.abs(multipliers(ph.simulate(pendulum, 0.2, dt))[0] - expected).max() for dt in (0.02, 0.01, 0.005, 0.0025)
    ]
    assert errors[-1] < 0.005
    assert np.polyfit(np.log2([8.0, 4.0, 2.0, 1.0]), np.log2(errors), 1)[0] == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("method", [ph.Midpoint(), ph.LinearlyImplicit(), ph.DiscreteGradient()])
def test_at_every_saved_time_to_second_order(pendulum, method):
    errors = []
    for dt in (0.02, 0.01, 0.005):
        solution = ph.simulate(pendulum, 1.0, dt, method=method)
        errors.append(np.abs(multipliers(solution) - by_hand(solution)).max())
    assert errors[-1] < 0.012  # N, of 60; a first-order value would be off by 0.07
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 2.0, atol=0.1)


def test_unequal_steps(pendulum):
    """The mean over two steps is that of their impulses: adapted steps, and times of the user's."""
    adapted = ph.simulate(pendulum, 1.0, 0.01, adaptive=ph.Adaptive(1e-5))
    np.testing.assert_allclose(multipliers(adapted), by_hand(adapted), atol=0.01)
    chosen = ph.simulate(pendulum, 1.0, 0.005, times=[0.011, 0.3, 0.3007, 0.9])
    np.testing.assert_allclose(multipliers(chosen), by_hand(chosen), atol=0.2)


@pytest.mark.parametrize("ratio", [1.0, 0.3])
def test_what_alternates_cancels(pendulum, ratio):
    """Impulses that alternate by 1 N s on a line 3 + 2 t: also at both ends, and where the step changes."""
    h = np.where(np.arange(12) < 6, 0.1, 0.1 * ratio)
    t = np.concatenate([[0.0], np.cumsum(h)])
    z = np.zeros((12, 1, pendulum.n))
    z[:, 0, 3] = 3.0 + (t[1:] + t[:-1]) + (-1.0) ** np.arange(12) / h
    middles = Middles(pendulum, (0.5,))
    start, before, ends = middles.add(h[:5], z[:5])
    assert before is None and start[0] == pytest.approx(3.0, abs=1e-12)
    assert ends[-1, 0] == pytest.approx(4.0, abs=1e-12)  # extrapolated, for now
    start, before, later = middles.add(h[5:], z[5:])
    assert start is None
    values = np.concatenate([ends[:-1, 0], before[:1], later[:, 0]])
    expected = 3.0 + 2.0 * t[1:]
    expected[5] = 3.0 + t[5] + t[7]  # between unequal steps, the middle of both
    np.testing.assert_allclose(values, expected, atol=1e-12)


@pytest.mark.parametrize("stages", [2, 3])
def test_methods_with_stages_start_with_their_polynomial(pendulum, stages):
    start = multipliers(ph.simulate(pendulum, 0.2, 0.01, method=ph.GaussLegendre(stages)))[0]
    np.testing.assert_allclose(start, (0.0, 7.3575), atol=0.003)


@pytest.mark.parametrize("chunk", [1, 2, 7])
def test_chunks_leave_no_trace(pendulum, chunk, cut_chunks):
    whole = ph.simulate(pendulum, 0.3, 0.01)
    counts = cut_chunks(chunk)
    np.testing.assert_array_equal(ph.simulate(pendulum, 0.3, 0.01).x, whole.x)
    some = ph.simulate(pendulum, 0.3, 0.01, save_every=4)
    np.testing.assert_array_equal(some.x, whole.x[[*range(0, 30, 4), 30]])
    assert max(counts) <= chunk


@pytest.mark.parametrize("steps", [1, 2])
def test_runs_too_short_for_an_extrapolation(pendulum, steps):
    force = multipliers(ph.simulate(pendulum, steps * 0.001, 0.001))
    np.testing.assert_allclose(force, np.tile([0.0, 7.3575], (steps + 1, 1)), atol=0.2)


def test_coenergy_is_left_alone():
    """Gradients of an energy that is not quadratic have no rate either, but are known at the ends of steps."""
    block = ph.CustomBlock(
        "duffing",
        2,
        lambda x: 0.5 * x[1] ** 2 + 0.25 * x[0] ** 4,
        gradient=lambda x: np.array([x[0] ** 3, x[1]]),
        hessian=lambda x: np.diag([3.0 * x[0] ** 2, 1.0]),
        J=np.array([[0.0, 1.0], [-1.0, 0.0]]),
        start=(1.0, 0.0),
    )
    d = ph.Diagram()
    d.add(block)
    system = d.compile()
    solution = ph.simulate(system, 1.0, 0.1)
    energy, coenergy = solution.x[:, ~system.coenergy], solution.x[:, system.coenergy]
    np.testing.assert_allclose(coenergy, np.stack([energy[:, 0] ** 3, energy[:, 1]], 1), atol=1e-13)
