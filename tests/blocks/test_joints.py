"""Joints with multipliers: the double pendulum, inconsistent starts, redundant joints, sliders."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import CausalityError, ConstraintError, DataError, GapError


def rod(name: str, start, end) -> ph.RigidBody:
    """A uniform bar of 1 kg and 1 m with anchors at its ends."""
    start, end = np.array(start), np.array(end)
    angle = np.arctan2(*(end - start)[::-1])
    return ph.RigidBody(name, 1.0, 1.0 / 12.0, (start + end) / 2.0, angle=angle, anchors={"a": start, "b": end})


def double_pendulum() -> tuple[ph.Diagram, ph.RigidBody, ph.RigidBody]:
    d = ph.Diagram("double pendulum", gravity=(0.0, -9.81))
    one, two = d.add(rod("one", (0.0, 0.0), (1.0, 0.0))), d.add(rod("two", (1.0, 0.0), (1.0, -1.0)))
    d.pin(one["a"], d.ground, multiplier=True)
    d.pin(one["b"], two["a"], multiplier=True)
    return d, one, two


def test_double_pendulum_against_the_reference(references):
    reference = np.array(references["double_pendulum_uniform_bars"]["theta(1)"])
    d, one, two = double_pendulum()
    system = d.compile()
    assert system.is_dae
    names = [f"{joint}.force {axis}[0]" for joint in ("pin one ground", "pin one two") for axis in "xy"]
    assert system.constraint_names == tuple(names)
    errors = []
    for dt in (0.005, 0.0025, 0.00125):
        solution = ph.simulate(system, t_end=1.0, dt=dt)
        angles = np.array([solution.angle(body.centre)[-1] + np.pi / 2.0 for body in (one, two)])
        errors.append(np.abs(angles - reference).max())
        assert solution.max_power_balance_error < 1e-12
        assert solution.statistics.start_energy_change == 0.0
        assert np.ptp(solution.energy.total) < 1e-11
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(rates, 2.0, atol=0.05)
    assert errors[-1] < 1e-4


def test_double_pendulum_stays_together():
    """The gaps of joints with multipliers are measured like those of others; measured 8.5e-5 m at dt 0.005."""
    d, one, two = double_pendulum()
    system = d.compile()
    assert [site.name for site in system.sites] == ["one.a = ground.anchor", "one.b = two.a"]
    assert [site.known for site in system.sites] == [True, False]
    worst = []
    for dt in (0.01, 0.005, 0.0025):
        solution = ph.simulate(system, t_end=1.0, dt=dt)
        by_velocity, by_strain = solution.closure("velocity"), solution.closure("strain")
        ends = [solution.position(anchor, source="velocity") for anchor in (one["b"], two["a"])]
        np.testing.assert_allclose(by_velocity["one.b = two.a"], np.linalg.norm(ends[0] - ends[1], axis=1), atol=1e-15)
        worst.append([gap.max() for gap in by_velocity.values()])
        # rebuilt from the ground a chain of rigid bars is closed
        assert max(gap.max() for gap in by_strain.values()) < 1e-15
        np.testing.assert_allclose(
            solution.position(two["b"], source="strain"),
            solution.position(two["b"], source="velocity"),
            atol=60 * dt**2,
        )
    np.testing.assert_allclose(np.log2(np.array(worst[:-1]) / worst[1:]), 2.0, atol=0.05)
    assert worst[1] == pytest.approx([1.86e-5, 8.51e-5], rel=0.01)


def test_a_loop_of_rigid_bars_closes_to_second_order():
    """A four-bar by multipliers: its gap from strain is at the joint that the chain from the ground ends in."""
    places = [(0.0, 0.0), (0.6, -0.8), (1.6, -0.8), (1.8, 0.0)]
    d = ph.Diagram("four-bar", gravity=(5.0, -9.81))
    bars = [d.add(rod(n, a, b)) for n, a, b in zip(("left", "low", "right"), places, places[1:], strict=False)]
    d.pin(d.ground, bars[0]["a"], multiplier=True)
    d.pin(bars[0]["b"], bars[1]["a"], multiplier=True)
    d.pin(bars[1]["b"], bars[2]["a"], multiplier=True)
    d.pin(bars[2]["b"], d.ground, multiplier=True)
    system = d.compile()
    worst = []
    for dt in (0.02, 0.01):
        gaps = ph.simulate(system, t_end=1.0, dt=dt).closure("strain")
        assert sorted(gap.max() > 1e-12 for gap in gaps.values()) == [False, False, False, True]
        worst.append(max(gap.max() for gap in gaps.values()))
    assert worst[0] / worst[1] == pytest.approx(4.0, rel=0.1) and 0.0 < worst[1] < 1e-4


def test_sites_of_three_at_one_pin_and_of_a_slider():
    d = ph.Diagram("star on a rail")
    bars = [d.add(rod(name, (0.0, 0.0), end)) for name, end in zip("abc", ((1, 0), (0, 1), (-1, 0)), strict=True)]
    d.pin(*(bar["a"] for bar in bars), multiplier=True)
    rail = d.add(ph.Slider("rail", (1.0, 1.0)))
    d.connect(rail.first, d.ground.translation)
    d.connect(rail.second, bars[0]["b"].translation)
    system = d.compile()
    (site,), (guide,) = system.sites, system.guides
    assert site.name == "a.a = b.a = c.a" and [name for name, _ in site.places] == ["a", "b", "c"]
    assert guide.name == "rail" and guide.first.known and guide.second.places[0][0] == "a"
    solution = ph.simulate(system, t_end=1.0, dt=0.01, start=system.rigid_motion((1.0, 1.0), spin=2.0))
    away = solution.position(bars[0]["b"]) - [1.0, 0.0]
    gap = solution.closure()["rail"]
    np.testing.assert_allclose(gap, np.abs(away @ [-1.0, 1.0]) / np.sqrt(2.0), atol=1e-15)
    assert np.ptp(away @ [1.0, 1.0]) > 0.5 and 1e-7 < gap.max() < 1e-3


def test_an_inconsistent_start_is_projected_in_the_energy_norm():
    """A bar that is thrown sideways and then caught at its end keeps its angular momentum about the pin."""
    d = ph.Diagram("caught")
    bar = d.add(rod("bar", (0.0, 0.0), (0.0, -1.0)))
    d.pin(bar["a"], d.ground, multiplier=True)
    system = d.compile()
    solution = ph.simulate(system, t_end=0.5, dt=0.01, start=system.rigid_motion(velocity=(2.0, 1.0)))
    spin = 0.5 * 2.0 / (1.0 / 3.0)
    assert solution.spin(bar, (0.0, 0.0))[0] == pytest.approx(spin, rel=1e-13)
    np.testing.assert_allclose(solution.spin(bar, (0.0, 0.0)), spin, rtol=3e-4)  # (spin dt)**2
    np.testing.assert_allclose(solution.velocity(bar["a"])[0], 0.0, atol=1e-14)
    change = 0.5 * spin**2 / 3.0 - 0.5 * (4.0 + 1.0)
    assert solution.statistics.start_energy_change == pytest.approx(change, rel=1e-12)
    assert "start projected" in str(solution.statistics)
    forces = np.hypot(solution.state("pin bar ground.force x[0]"), solution.state("pin bar ground.force y[0]"))[1:]
    # centripetal; the midpoint rule lets it alternate by little from step to step, so the mean of two is taken
    np.testing.assert_allclose((forces[1:] + forces[:-1]) / 2.0, 0.5 * spin**2, rtol=3e-4)
    assert np.ptp(forces) < 1e-2 * forces.mean()


def test_a_weld_holds_the_angle():
    d = ph.Diagram("welded", gravity=(0.0, -9.81))
    one, two = d.add(rod("one", (0.0, 0.0), (1.0, 0.0))), d.add(rod("two", (1.0, 0.0), (2.0, 0.0)))
    d.pin(one["a"], d.ground, multiplier=True)
    d.weld(one["b"], two["a"], multiplier=True)
    solution = ph.simulate(d.compile(), t_end=0.2, dt=0.001)
    np.testing.assert_allclose(solution.angle(one.centre), solution.angle(two.centre), atol=1e-12)
    # released from horizontal a bar of 2 m starts with 3/2 g / L
    assert solution.spin(one, (0.0, 0.0))[10] == pytest.approx(-0.01 * 1.5 * 9.81 / 2.0, rel=1e-3)


def test_three_at_one_pin_and_names_in_use():
    d = ph.Diagram("star")
    bars = [d.add(rod(name, (0.0, 0.0), end)) for name, end in zip("abc", ((1, 0), (0, 1), (-1, 0)), strict=True)]
    d.pin(*(bar["a"] for bar in bars), multiplier=True)
    d.add(rod("pin a b 2", (5.0, 0.0), (6.0, 0.0)))
    system = d.compile()
    assert len(system.constraint_names) == 4
    solution = ph.simulate(system, t_end=0.5, dt=0.01, start=system.rigid_motion(spin=1.0, blocks=["a"]))
    v = [solution.velocity(bar["a"]) for bar in bars]
    assert max(np.abs(v[0] - v[1]).max(), np.abs(v[0] - v[2]).max()) < 1e-3


def test_redundant_joints_are_named():
    d = ph.Diagram("held twice")
    bar = d.add(rod("bar", (0.0, 0.0), (1.0, 0.0)))
    d.pin(bar["a"], d.ground, multiplier=True)
    d.pin(bar["b"], d.ground, multiplier=True)
    with pytest.raises(
        ConstraintError, match=r"PH302.*pin bar ground.*\(pin at test_joints.py:\d+\).*force x\[0\].*imply already"
    ):
        d.compile()


def test_without_multiplier_two_bodies_conflict_and_a_gap_is_a_gap():
    d = ph.Diagram("two bodies")
    one, two = d.add(rod("one", (0.0, 0.0), (1.0, 0.0))), d.add(rod("two", (1.0, 0.0), (1.0, -1.0)))
    with pytest.raises(GapError):
        d.pin(one["a"], two["a"], multiplier=True)
    with pytest.raises(DataError, match="at least two"):
        d.pin(one["a"], multiplier=True)
    d.pin(one["b"], two["a"])
    with pytest.raises(CausalityError):
        d.compile()


def test_a_flexible_beam_on_a_rigid_body_by_a_multiplier(bar):
    d = ph.Diagram("mixed", gravity=(0.0, -9.81))
    body, beam = d.add(rod("body", (0.0, 0.0), (1.0, 0.0))), d.add(ph.Beam("beam", bar, (1.0, 0.0), (2.0, 0.0), 3))
    d.pin(body["a"], d.ground, multiplier=True)
    d.weld(body["b"], beam.start, multiplier=True)
    solution = ph.simulate(d.compile(), t_end=0.1, dt=0.005)
    assert solution.status.ok and np.ptp(solution.energy.total) < 1e-10
    np.testing.assert_allclose(solution.velocity(body["b"]), solution.velocity(beam.start), atol=1e-3)


@pytest.mark.parametrize("dt", [5e-4, 1e-2])
def test_all_is_held_by_joints(dt):
    """After its projection the start is at rest up to round-off, to which nothing can be relative."""
    d = ph.Diagram("held", gravity=(0.0, -9.81))
    body = d.add(ph.RigidBody("body", 0.7, 0.2, (0.3, 0.4), {"foot": (0.0, 0.0), "tip": (0.5, 0.8)}, angle=2.0))
    mass = d.add(ph.Mass("mass", 5.0, (0.5, 0.8)))
    d.weld(body["foot"], d.ground, multiplier=True)
    d.pin(body["tip"], mass.centre, multiplier=True)
    system = d.compile()
    solution = ph.simulate(system, 10 * dt, dt, start=system.rigid_motion(velocity=(1.0, 1.0), spin=1.0))
    assert solution.status.ok
    np.testing.assert_allclose(solution.velocity(mass.centre)[1:], 0.0, atol=1e-13)
    held = np.array([solution.state(f"pin body mass.force {axis}[0]") for axis in "xy"])
    np.testing.assert_allclose(np.hypot(*held[:, 1:]), 5.0 * 9.81, rtol=1e-9)


@pytest.mark.parametrize("turns", [True, False])
def test_a_slider_runs_down_an_incline(turns):
    """A body on a guide of slope 3/4 falls with g sin; the guide carries m g cos."""
    d = ph.Diagram("incline", gravity=(0.0, -10.0))
    body = d.add(ph.RigidBody("body", 2.0, 0.1, (0.0, 0.0)))
    guide = d.add(ph.Slider("guide", (-4.0, -3.0), turns=turns))
    d.connect(d.ground.translation, guide.first)
    d.connect(guide.second, body.centre.translation)
    if not turns:
        d.connect(d.ground.rotation, guide.first_rotation)
        d.connect(guide.second_rotation, body.centre.rotation)
    system = d.compile()
    solution = ph.simulate(system, t_end=1.0, dt=0.1)
    np.testing.assert_allclose(solution.position(body.centre)[-1], [-0.8 * 3.0, -0.6 * 3.0], atol=1e-12)
    assert abs(solution.state(system.constraint_names[0])[-1]) == pytest.approx(16.0)
    assert np.ptp(solution.energy.total) < 1e-12


def test_a_slider_needs_a_direction():
    with pytest.raises(DataError, match="a direction"):
        ph.Slider("guide", (0.0, 0.0))
