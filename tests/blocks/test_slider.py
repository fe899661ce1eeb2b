"""Sliders on guides that turn: a bead on a bar, the crank-slotted arm, guides of all kinds, and what is refused."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import CausalityError, DataError, GapError

ALONG, ACROSS = np.array([0.8, 0.6]), np.array([-0.6, 0.8])
STIFF = ph.Section(axial=1e9, shear=1e9, bending=1e7, mass=1.0, rotary=1e-3)


def driven(dt, spin=2.0, r0=0.3):
    """A bead on a guide that turns at constant speed about the ground, at first at rest on it."""
    d = ph.Diagram("driven bead")
    bead, motor = d.add(ph.Mass("bead", 0.7, r0 * ALONG)), d.add(ph.AngularVelocity("motor", spin))
    guide = d.add(ph.Slider("guide", ALONG, guide="first", start=(0.0, 0.0), end=r0 * ALONG))
    d.connect(guide.first, d.ground.translation)
    d.connect(guide.first_rotation, motor.port)
    d.connect(guide.second, bead.centre.translation)
    system = d.compile()
    return ph.simulate(system, t_end=1.0, dt=dt, start=system.rigid_motion(spin=spin)), bead


def test_a_bead_is_thrown_out():
    """In the frame of the guide r'' = omega^2 r, so r = r0 cosh(omega t); the motor pays for the energy."""
    errors, gaps = [], []
    for dt in (0.02, 0.01, 0.005):
        solution, bead = driven(dt)
        exact = 0.3 * np.cosh(2.0 * solution.t)
        distance = np.linalg.norm(solution.position(bead.centre), axis=1)
        errors.append([np.abs(solution.state("guide.distance[0]") - exact).max(), np.abs(distance - exact).max()])
        gaps.append(solution.closure()["guide"].max())
        assert solution.max_power_balance_error < 1e-14 and solution.statistics.start_energy_change == 0.0
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 2.0, atol=0.01)
    np.testing.assert_allclose(np.log2(np.array(gaps[:-1]) / gaps[1:]), 2.0, atol=0.01)
    assert max(errors[-1]) < 3e-5 and gaps[-1] < 3e-6
    # the bead pushes back with 2 m omega r'
    lateral = -2.0 * 0.7 * 2.0 * 0.6 * np.sinh(2.0 * solution.t)
    np.testing.assert_allclose(solution.state("guide.force across[0]"), lateral, atol=1.2e-4 * 6.1)
    moment = solution.state("guide.moment of guide[0]")
    np.testing.assert_allclose(moment[:-1], -lateral[:-1] * exact[:-1], atol=2e-4 * 6.9)
    assert moment[-1] == pytest.approx(-lateral[-1] * exact[-1], rel=5e-4)  # extrapolated


def free(turns=True, offset=0.0, gravity=None, pinned=True):
    """A bead or a small body on a bar of 1.3 kg, whose guide begins 0.1 m from its pin."""
    d = ph.Diagram("free bead", gravity=gravity)
    bar = d.add(ph.RigidBody("bar", 1.3, 0.4, 0.2 * ALONG, {"pin": (0.0, 0.0), "guide": 0.1 * ALONG}))
    place = 0.3 * ALONG + offset * ACROSS
    bead = d.add(ph.Mass("bead", 0.7, place) if turns else ph.RigidBody("bead", 0.7, 0.05, place))
    guide = d.add(ph.Slider("guide", 3.0 * ALONG, turns, guide="first", start=0.1 * ALONG, end=place))
    if pinned:
        d.pin(bar["pin"], d.ground, multiplier=True)
    d.connect(guide.first, bar["guide"].translation)
    d.connect(guide.first_rotation, bar["guide"].rotation)
    d.connect(guide.second, bead.centre.translation)
    if not turns:
        d.connect(guide.second_rotation, bead.centre.rotation)
    return d, bar, bead


@pytest.mark.parametrize("turns", [True, False])
@pytest.mark.parametrize("offset", [0.0, 0.07])
def test_angular_momentum_of_bar_and_bead(turns, offset):
    drift = []
    for dt in (0.02, 0.01, 0.005):
        d, bar, bead = free(turns, offset)
        system = d.compile()
        solution = ph.simulate(system, t_end=2.0, dt=dt, start=system.rigid_motion(spin=2.0))
        r, v = solution.position(bead.centre), solution.velocity(bead.centre)
        momentum = (0.4 + 1.3 * 0.04) * solution.spin(bar.centre) + 0.7 * (r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0])
        if not turns:
            momentum += 0.05 * solution.spin(bead.centre)
            np.testing.assert_allclose(solution.angle(bead.centre), solution.angle(bar.centre), atol=1e-13)
        drift.append(np.ptp(momentum))
        assert np.ptp(solution.energy.total) < 2e-13 and solution.max_power_balance_error < 1e-14
        assert np.linalg.norm(r[-1]) > 1.0
    np.testing.assert_allclose(np.log2(np.array(drift[:-1]) / drift[1:]), 2.0, atol=0.02)
    assert drift[-1] < 1e-5


def test_linear_momentum_of_bar_and_bead_in_free_flight():
    """Forces on both sides of the joint are opposite to the last bit, so this is kept to round-off."""
    d, bar, bead = free(pinned=False)
    system = d.compile()
    solution = ph.simulate(system, t_end=2.0, dt=0.02, start=system.rigid_motion((1.0, -0.5), spin=2.0))
    momentum = 1.3 * solution.velocity(bar, (0.0, 0.0), frame="fixed") + 0.7 * solution.velocity(bead.centre)
    np.testing.assert_allclose(momentum, np.tile(momentum[0], (len(momentum), 1)), atol=1e-13)
    assert np.ptp(solution.state("guide.distance[0]")) > 0.3


def test_gravity_and_structure():
    d, _, _ = free(gravity=(0.0, -9.81), offset=0.07)
    system = d.compile()
    assert system.constraint_names[0] == "guide.force across[0]" and len(system.constraint_names) == 3
    solution = ph.simulate(system, t_end=1.0, dt=0.005)
    assert np.ptp(solution.energy.total) < 1e-11
    assert solution.closure()["guide"].max() < 1e-5
    random = np.random.default_rng(3)
    for _ in range(5):
        J = system.J(random.standard_normal(system.n), random.standard_normal(system.start.theta.size))
        assert abs(J + J.T).max() == 0.0


def test_what_is_not_asked_for_is_not_kept():
    """Without outputs there remains the angle of the guide, which the physics needs; the motion is the same."""
    ends = []
    for outputs in ("all", None):
        d, _, _ = free(turns=False)
        system = d.compile(outputs)
        solution = ph.simulate(system, t_end=0.5, dt=0.01, start=system.rigid_motion(spin=2.0))
        ends.append((system.start.theta.size, solution.state("guide.distance[0]")[-1]))
    assert [size for size, _ in ends] == [2, 1]
    assert ends[0][1] == pytest.approx(ends[1][1], abs=1e-14)


def test_linearisation_is_the_derivative():
    d, _, _ = free(gravity=(0.0, -9.81), offset=0.07, turns=False)
    system = d.compile()
    solution = ph.simulate(system, t_end=0.3, dt=0.01)
    x, theta = solution.x[-1], solution.recording.theta[-1]
    A = system.linearize(ph.State(x, theta, system.start.points)).A.toarray()
    random = np.random.default_rng(0).standard_normal(system.n)
    step = 1e-6
    numeric = (system.force(x + step * random, theta) - system.force(x - step * random, theta)) / (2.0 * step)
    np.testing.assert_allclose(A[: system.n, : system.n] @ random, numeric, atol=1e-7)


def test_small_motions_keep_the_arm_of_the_force():
    """A spring pulls on a bead across a free bar, 0.2 m from its centre."""
    d = ph.Diagram("held across")
    bar = d.add(ph.RigidBody("bar", 1.3, 0.4, (0.0, 0.0), {"guide": (0.0, 0.0)}))
    bead, spring = d.add(ph.Mass("bead", 0.7, (0.2, 0.0))), d.add(ph.Spring("spring", 50.0, (0.2, 1.0), (0.2, 0.0)))
    guide = d.add(ph.Slider("guide", (1.0, 0.0), guide="first", start=(0.0, 0.0), end=(0.2, 0.0)))
    d.pin(spring.start, d.ground)
    d.connect(guide.first, bar["guide"].translation)
    d.connect(guide.first_rotation, bar.centre.rotation)
    d.connect(guide.second, bead.centre.translation, spring.end.translation)
    system = d.compile()
    # the bead feels its own mass, and of the bar 1 / (1/m + s^2/I) at its place
    mass = 0.7 + 1.0 / (1.0 / 1.3 + 0.04 / 0.4)
    for linear in (system, system.small_motions()):
        assert linear.modes(1).frequencies[0] == pytest.approx(np.sqrt(50.0 / mass), rel=1e-9)


@pytest.mark.parametrize("turns", [True, False])
def test_a_guide_on_the_ground_is_a_fixed_one(turns):
    paths = []
    for kind in ("fixed", "first"):
        d = ph.Diagram("incline", gravity=(0.0, -10.0))
        body = d.add(ph.RigidBody("body", 2.0, 0.1, (1.0, 2.0), {"off": (1.5, 2.0)}))
        guide = d.add(ph.Slider("guide", (-4.0, -3.0), turns, guide=kind, start=(0.0, 0.0), end=(1.5, 2.0)))
        d.connect(d.ground.translation, guide.first)
        if kind == "first" or not turns:
            d.connect(d.ground.rotation, guide.first_rotation)
        if not turns:
            d.connect(guide.second_rotation, body.centre.rotation)
        d.connect(guide.second, body["off"].translation)
        solution = ph.simulate(d.compile(), t_end=1.0, dt=0.02)
        paths.append(np.hstack([solution.position(body.centre), solution.angle(body.centre)[:, None]]))
        assert np.ptp(solution.energy.total) < 1e-11 and solution.max_power_balance_error < 1e-13
    np.testing.assert_allclose(paths[0], paths[1], atol=1e-12)


CRANK, BETWEEN, SPIN = 0.2, 0.5, 3.0  # m from the pivot of the crank to its pin, between the pivots, rad/s


def swing(t):
    """Angle of the slotted arm: it points from its pivot to the pin of the crank."""
    return np.arctan2(BETWEEN + CRANK * np.sin(SPIN * t), CRANK * np.cos(SPIN * t))


def test_quick_return_of_rigid_parts():
    """The pin of the crank moves as it is told and turns a rigid arm by its slot."""
    errors = []
    for dt in (0.02, 0.01, 0.005):
        d = ph.Diagram("quick return")
        arm = d.add(ph.RigidBody("arm", 1.0, 0.1, (0.5 * np.cos(swing(0.0)), 0.5), {"a": (0.0, 0.0), "b": (0.0, 0.0)}))
        pin = (CRANK, BETWEEN)
        crank = d.add(ph.Velocity("crank", lambda t: CRANK * SPIN * np.array([-np.sin(SPIN * t), np.cos(SPIN * t)])))
        guide = d.add(ph.Slider("guide", pin, guide="first", start=(0.0, 0.0), end=pin))
        d.pin(arm["a"], d.ground, multiplier=True)
        d.connect(guide.first, arm["b"].translation)
        d.connect(guide.first_rotation, arm["b"].rotation)
        d.connect(guide.second, crank.port)
        solution = ph.simulate(d.compile(), t_end=2.0, dt=dt)
        turned = solution.angle(arm.centre) - solution.angle(arm.centre)[0]
        errors.append(np.abs(turned - swing(solution.t) + swing(0.0)).max())
        assert solution.max_power_balance_error < 1e-14
        assert solution.closure("velocity")["guide"].max() < 0.01 * dt**2
    assert np.ptp(swing(solution.t)) > 0.8
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 2.0, atol=0.1)
    assert errors[-1] < 2e-5


def test_quick_return_of_beams():
    """The guide is the root of an arm of beam; the crank is a beam too, stiff but not rigid."""
    d = ph.Diagram("quick return")
    pin, start = (CRANK, BETWEEN), swing(0.0)
    arm = d.add(ph.Beam("arm", STIFF, (0.0, 0.0), (np.cos(start), np.sin(start)), 2, degree=2))
    crank, drive = d.add(ph.Beam("crank", STIFF, (0.0, BETWEEN), pin, 2)), d.add(ph.AngularVelocity("drive", SPIN))
    guide = d.add(ph.Slider("guide", pin, guide="first", start=(0.0, 0.0), end=pin))
    d.connect(arm.start.translation, d.ground.translation, guide.first)
    d.connect(arm.start.rotation, guide.first_rotation)
    d.pin(crank.start, d.ground)
    d.connect(drive.port, crank.start.rotation)
    d.connect(crank.end.translation, guide.second)
    system = d.compile()
    begin = system.rigid_motion(spin=SPIN, about=(0.0, BETWEEN), blocks=["crank"])
    gaps = []
    for dt in (0.02, 0.01):
        # motion and energy are right; the moment of the guide changes sign from step to step
        with pytest.warns(ph.errors.HealthWarning, match=r"alternation: 0\.9.*guide\.moment of guide\[0\]"):
            solution = ph.simulate(system, t_end=2.0, dt=dt, start=begin)
        assert solution.max_power_balance_error < 1e-12
        assert set(solution.closure()) == {"arm.start = ground.anchor", "crank.start = ground.anchor", "guide"}
        gaps.append(solution.closure("velocity")["guide"].max())
    np.testing.assert_allclose(solution.angle(arm.start) - start, swing(solution.t) - start, atol=1e-4)
    assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.05) and gaps[1] < 1e-5


def test_a_nested_guide_turns_with_its_own_bar():
    inner, bar, _ = free()
    outer = ph.Diagram("two")
    left, right = outer.add(inner, "left"), outer.add(inner, "right")
    system = outer.compile()
    start = system.rigid_motion(spin=2.0, blocks=["left/bar", "left/bead"])
    solution = ph.simulate(system, t_end=0.5, dt=0.01, start=start)
    assert solution.state("left/guide.distance[0]")[-1] > 0.25
    np.testing.assert_allclose(solution.state("right/guide.distance[0]"), 0.2, atol=1e-14)
    assert solution.angle(left[bar].centre)[-1] > 0.5 and solution.angle(right[bar].centre)[-1] == 0.0


def test_what_is_refused():
    with pytest.raises(DataError, match="a direction"):
        ph.Slider("guide", (0.0, 0.0))
    with pytest.raises(DataError, match='expected "fixed" or "first", got \'second\''):
        ph.Slider("guide", (1.0, 0.0), guide="second")
    with pytest.raises(DataError, match="places start and end"):
        ph.Slider("guide", (1.0, 0.0), guide="first", start=(0.0, 0.0))
    d, _, _ = free()
    d.network.blocks["guide"]._end = np.array([0.5, 0.5])
    with pytest.raises(GapError, match=r"PH206.*guide and bead.centre.*0\.41"):
        d.compile()
    d = ph.Diagram("loose")
    guide = d.add(ph.Slider("guide", (1.0, 0.0), guide="first", start=(0.0, 0.0), end=(0.0, 0.0)))
    mass = d.add(ph.Mass("mass", 1.0, (0.0, 0.0)))
    d.connect(guide.first, d.ground.translation)
    d.connect(guide.second, mass.centre.translation)
    with pytest.raises(CausalityError, match=r"guide\.first\.rotation"):
        d.compile()
