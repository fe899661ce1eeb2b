"""Frames that stay as they were, and parts without weight, in blocks of every kind."""

import numpy as np
import pytest

import phblocks as ph

LINEAR = ph.Approximation(large_rotation=False)
WEIGHTLESS = ph.Approximation(gravity=False)


def pendulum(approximation=None, diagram=None):
    """A uniform rigid bar of 1 m and 1 kg, horizontal, pinned at its left end: (system, body)."""
    d = ph.Diagram("pendulum", gravity=(0.0, -9.81))
    bar = ph.RigidBody("bar", 1.0, 1.0 / 12.0, (0.5, 0.0), {"left": (0.0, 0.0)}, approximation=approximation)
    d.add(bar)
    d.pin(bar["left"], d.ground, multiplier=True)
    return d.compile(approximation=diagram), bar


def test_a_body_whose_weight_does_not_turn_accelerates_for_ever():
    """The moment of the weight stays m g l/2: spin 3/2 g t, by hand; energy to round-off."""
    system, bar = pendulum(ph.Approximation(large_rotation=False, insist=True))
    assert system.linear
    solution = ph.simulate(system, t_end=1.0, dt=0.01)
    np.testing.assert_allclose(solution.spin(bar, (0.0, 0.0)), -1.5 * 9.81 * solution.t, rtol=1e-12, atol=1e-12)
    assert solution.max_power_balance_error < 1e-12


def test_the_true_one_swings():
    system, bar = pendulum()
    assert not system.linear
    solution = ph.simulate(system, t_end=1.0, dt=0.01)
    assert solution.spin(bar, (0.0, 0.0))[-1] > -3.0  # past the lowest point, where it had 5.4 rad/s


def test_weight_left_out_in_one_block_only():
    d = ph.Diagram("two", gravity=(0.0, -9.81))
    heavy, light = d.add(ph.Mass("heavy", 2.0, (0, 0))), d.add(ph.Mass("light", 2.0, (1, 0), approximation=WEIGHTLESS))
    system = d.compile()
    solution = ph.simulate(system, t_end=1.0, dt=0.1)
    assert solution.velocity(heavy, (0, 0))[-1, 1] == pytest.approx(-9.81, rel=1e-13)
    assert not solution.velocity(light, (0, 0)).any()
    assert solution.energy["total"] == pytest.approx(0.0, abs=1e-12)
    assert solution.energy["gravity"][-1] == pytest.approx(-2.0 * 9.81**2 / 2.0, rel=1e-12)
    assert [(e.block, e.name) for e in system.approximations] == [("light", "gravity")]


def test_what_a_block_says_wins_over_the_diagram():
    d = ph.Diagram("two", gravity=(0.0, -9.81))
    d.add(ph.Mass("heavy", 2.0, (0, 0), approximation=ph.Approximation()))
    light = d.add(ph.Mass("light", 2.0, (1, 0)))
    system = d.compile(approximation=WEIGHTLESS, effects="all")
    assert system.gravity_force().tolist() == [0.0, -2.0 * 9.81, 0.0, 0.0]
    assert light.approximation is None  # the user's block is as it was


def test_without_any_weight_there_is_no_gravity_to_turn():
    """One point in the air: no features for gravity, so the system is linear."""
    system, _ = pendulum(diagram=ph.Approximation(gravity=False, large_rotation=False))
    assert system.linear and system.n_features == 1
    assert not system.gravity_force().any()


def stretched(approximation):
    """A mass on a spring from the ground along (3, 4): system."""
    d = ph.Diagram("spring")
    m = d.add(ph.Mass("m", 2.0, (3.0, 4.0)))
    s = d.add(ph.Spring("s", 50.0, start=(0.0, 0.0), end=(3.0, 4.0)))
    d.connect(m.centre.translation, s.end.translation)
    d.connect(s.start.translation, d.ground.translation)
    return d.compile(approximation=approximation)


def test_a_line_of_action_keeps_its_direction():
    """Moved across its first direction a linear spring gives no force; moved along it the frequency is sqrt(k/m)."""
    linear, true = stretched(LINEAR), stretched(None)
    assert linear.linear and not true.linear
    assert linear.modes(3).frequencies == pytest.approx([5.0], rel=1e-12)
    np.testing.assert_array_equal(linear.J0.toarray(), true.J().toarray())
    across = linear.rigid_motion((-0.8, 0.6))
    solution = ph.simulate(linear, t_end=1.0, dt=0.01, start=across)
    assert np.abs(solution.energy["strain"]).max() < 1e-28
    assert ph.simulate(true, t_end=1.0, dt=0.01, start=across).energy["strain"].max() > 1e-3


def test_a_guide_keeps_its_direction_and_its_arm():
    """J of the linear slider is that of the true one at the start, with the distance as the arm of the force."""
    d = ph.Diagram("guide")
    disc = d.add(ph.RigidBody("disc", 2.0, 0.5, (0.0, 0.0)))
    bead = d.add(ph.Mass("bead", 0.3, (0.4, 0.3)))
    slider = d.add(ph.Slider("rail", (4.0, 3.0), guide="first", start=(0.0, 0.0), end=(0.4, 0.3)))
    d.connect(disc.centre.translation, slider.first)
    d.connect(disc.centre.rotation, slider.first_rotation)
    d.connect(bead.centre.translation, slider.second)
    true, linear = d.compile(), d.compile(approximation=LINEAR)
    assert linear.linear and not true.linear
    np.testing.assert_allclose(linear.J0.toarray(), true.J(true.start.x).toarray(), rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", ["four-bar", "frame", "arm", "shaken", "free"])
def test_a_linear_diagram_is_that_of_small_motions(scenes, name):
    """One way is to drop T and angles from the assembled matrices, the other to leave them out of every block."""
    approximation = ph.Approximation(large_rotation=False, insist=True)
    by_block, whole = scenes[name].compile(approximation=approximation), scenes[name].compile().small_motions()
    assert by_block.linear
    for matrix in ("E", "J0", "R0", "G0"):
        a, b = (getattr(s, matrix).toarray() for s in (by_block, whole))
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-14 * max(1.0, np.abs(b).max(initial=0.0)))
    np.testing.assert_allclose(by_block.gravity_force(), whole.gravity_force(), rtol=0, atol=1e-13)
