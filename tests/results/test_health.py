"""Health of runs: each number against one worked out by hand or with NumPy alone; scenes that are sick are named."""

import itertools
import json
import math
import warnings
from dataclasses import replace

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, HealthWarning, UnknownNameError
from phblocks.results.chords import position_gaps
from phblocks.results.gaps import block_gaps
from phblocks.results.momentum import free_bodies, momentum_drift

SOFT = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)
QUIET = ph.Limits.none()


def oscillator(k: float = 100.0, m: float = 4.0) -> ph.System:
    """A disc on a torsion spring on the ground: omega = sqrt(k / m) = 5 rad/s."""
    d = ph.Diagram("oscillator")
    disc = d.add(ph.RigidBody("disc", 1.0, m, (0.0, 0.0), {"axle": (0.0, 0.0)}))
    spring = d.add(ph.TorsionSpring("spring", k))
    d.connect(disc["axle"].rotation, spring.first)
    d.connect(spring.second, d.ground.rotation)
    return d.compile()


def driven(law) -> ph.System:
    """A disc of 0.5 kg m^2 behind a gear with a multiplier, turned from outside at twice the speed of the law."""
    d = ph.Diagram("driven")
    disc = d.add(ph.RigidBody("disc", 1.0, 0.5, (0.0, 0.0), {"axle": (0.0, 0.0)}))
    gear = d.add(ph.Transformer("gear", 2.0, multiplier=True))
    d.connect(gear.second, disc["axle"].rotation)
    d.connect(d.add(ph.AngularVelocity("drive", law)).port, gear.first)
    return d.compile()


def spinning(omega: float = 6.0) -> tuple[ph.System, ph.State]:
    d = ph.Diagram("spin")
    beam = d.add(ph.Beam("beam", SOFT, (0.0, 0.0), (1.0, 0.0), elements=3, degree=2))
    d.pin(beam.start, d.ground)
    system = d.compile()
    return system, system.rigid_motion(spin=omega)


def free() -> ph.System:
    """Two beams pinned to each other and to nothing else."""
    d = ph.Diagram("free")
    first = d.add(ph.Beam("first", SOFT, (0.0, 0.0), (1.0, 0.3), elements=3, degree=2))
    second = d.add(ph.Beam("second", SOFT, (1.0, 0.3), (1.0, -0.7), elements=2, degree=3))
    d.pin(first.end, second.start)
    return d.compile()


# What is looked at in every step


@pytest.mark.parametrize("dt", [0.02, 0.2, 2.0])
def test_energy_that_a_step_does_not_resolve(dt):
    """Of one mode (h omega / 2)^2 / (1 + (h omega / 2)^2): 0.0025, 0.2 and 0.96 of the energy at omega = 5 rad/s."""
    system, half = oscillator(), 0.5 * dt * 5.0
    start = system.rigid_motion(spin=1.0)
    found = ph.simulate(system, 40 * dt, dt, start=start, limits=QUIET).health["unresolved share of energy"]
    assert found.value == pytest.approx(half**2 / (1.0 + half**2), rel=1e-10)
    assert found.where in ("disc", "spring")


def test_energy_of_many_modes_that_a_step_does_not_resolve():
    """Against the modes of a dense eigenvalue problem, each with its share; and by block."""
    d = ph.Diagram("bars")
    left = d.add(ph.Beam("left", SOFT, (0.0, 0.0), (1.0, 0.0), elements=4))
    right = d.add(ph.Beam("right", replace_bending(600.0), (1.0, 0.0), (2.0, 0.0), elements=3))
    d.weld(left.start, d.ground)
    d.pin(left.end, right.start)
    d.weld(right.end, d.ground)
    system = d.compile().small_motions()
    x = np.random.default_rng(3).standard_normal(system.n)
    dt = 0.004
    solution = ph.simulate(
        system, 300 * dt, dt, start=ph.State(x, system.start.theta, system.start.points), limits=QUIET
    )
    E, J = system.E.toarray(), system.J().toarray()
    root = np.linalg.cholesky(E)
    omega, shapes = np.linalg.eigh(-1j * np.linalg.solve(root, np.linalg.solve(root, J).T).T.conj())
    energy = np.abs(shapes.conj().T @ root.T @ x) ** 2
    half = 0.5 * dt * omega
    expected = energy @ (half**2 / (1.0 + half**2)) / energy.sum()
    found = solution.health["unresolved share of energy"]
    assert 0.2 < expected < 0.98
    assert found.value == pytest.approx(expected, rel=1e-9)
    missed = solution.recording.sums.missed
    assert found.where == solution.labels.blocks[int(missed.argmax())] in ("left", "right")


def replace_bending(bending: float) -> ph.Section:
    return ph.Section(axial=4e4, shear=2e4, bending=bending, mass=1.2, rotary=2e-3)


@pytest.mark.parametrize("method", [ph.GaussLegendre(2), ph.GaussLegendre(3)])
def test_methods_with_stages_hide_nothing(method):
    """Their steps end where they began if h omega is large; their stages have next to none of the energy."""
    system = oscillator()
    start = system.rigid_motion(spin=1.0)
    with pytest.warns(HealthWarning, match=r"unresolved share of energy: 0\.9"):
        ph.simulate(system, 400.0, 10.0, start=start, method=method)
    fine = ph.simulate(system, 1.0, 0.01, start=start, method=method)
    assert fine.health["unresolved share of energy"].value < 1e-4


def test_a_step_that_is_far_too_long_is_named():
    """A cantilever that rings at 30 times the rate of the steps, energy kept to round-off."""
    d = ph.Diagram("cantilever")
    beam = d.add(ph.Beam("cane", SOFT, (0.0, 0.0), (1.0, 0.0), elements=4, degree=2))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "tip")
    system = d.compile()
    first = system.modes(1).frequencies[0]
    begin = ph.simulate(system, 0.5, 0.005, inputs={"tip": lambda t: (0.0, 2.0 * min(t, 0.4))}).at(0.5)
    with pytest.warns(HealthWarning, match=r"run of 'cantilever': unresolved share of energy: .* \(cane\)"):
        sick = ph.simulate(system, 40 * 30.0 / first, 30.0 / first, start=begin)
    assert sick.status.ok and sick.max_power_balance_error < 1e-12
    assert not sick.health.ok and sick.health["unresolved share of energy"].verdict == "over"


def test_a_tolerance_that_is_too_loose_is_no_silent_success(four_bar):
    system = four_bar().compile()
    loose = ph.Midpoint(ph.Newton(tolerance=0.5))
    with pytest.warns(HealthWarning, match="energy balance, worst step") as caught:
        solution = ph.simulate(system, 0.5, 0.02, method=loose)
    assert solution.status.ok
    assert caught[0].filename == __file__, "it points at the call of simulate"
    ledger, energy = solution.recording.ledger, solution.energy
    most = max(np.abs(series).max() for name, series in energy.items() if name in ("gravity", "supplied", "dissipated"))
    most = max(most, ledger.stored.sum(axis=(1, 2)).max())
    worst, whole = (solution.health[f"energy balance, {name}"] for name in ("worst step", "whole run"))
    assert worst.value == pytest.approx(solution.max_power_balance_error / most, rel=1e-12)
    assert worst.time == pytest.approx(solution.t[ledger.balance_error.argmax()], abs=1e-12)
    assert worst.where == solution.power.worst[0]
    miss = energy.total - energy.total[0] - energy.supplied + energy.dissipated
    assert whole.value == pytest.approx(np.abs(miss).max() / most, rel=1e-9) and whole.value > 1e-6
    assert whole.time == pytest.approx(solution.t[np.abs(miss).argmax()], abs=1e-12)


def test_the_default_tolerance_is_healthy(four_bar):
    solution = ph.simulate(four_bar().compile(), 0.5, 0.02)
    assert solution.health.ok and solution.health["energy balance, whole run"].value < 1e-12


def test_a_jump_of_an_imposed_velocity_makes_multipliers_alternate():
    """After a jump by v the velocity is 2v, 0, 2v, ...: a moment of +- 2 J v / h for ever, energy in order.

    Without the jump the moment is that of the acceleration, J times 2 * 3 cos(3 t), seen through the gear.
    """
    dt, jump = 0.01, lambda t: 1.0 if t > 0.1 else 0.0
    with pytest.warns(HealthWarning, match=r"multiplier alternation: 0\.99.*gear\.moment\[0\]"):
        sick = ph.simulate(driven(jump), 1.0, dt)
    assert sick.max_power_balance_error < 1e-12
    sums = sick.recording.sums
    unit = sick.system.part("gear")  # one multiplier; 90 steps of the same size, in any unit
    assert unit.name == "gear" and sums.multipliers.size == 1
    # 90 forces 0, 0, A, -A, A, ...: (a - 2b + c) / 4 is A/4, -3A/4, and 88 times A or -A
    expected = np.sqrt((1 / 16 + 9 / 16 + 88) / 90)
    assert sick.health["multiplier alternation"].value == pytest.approx(expected, rel=1e-9)
    smooth = ph.simulate(driven(lambda t: np.sin(3.0 * t)), 1.0, dt)
    # (a - 2b + c) / 4 of a cosine of frequency 3 is -sin(3 h / 2)^2 of its value
    assert smooth.health["multiplier alternation"].value == pytest.approx(np.sin(1.5 * dt) ** 2, rel=0.1)


def test_small_multipliers_among_large_ones_do_not_count(bar):
    """Of a beam welded to a body those of the weld ring, at a hundredth of the force of the pin."""
    d = ph.Diagram("mixed", gravity=(0.0, -9.81))
    body = d.add(ph.RigidBody("body", 3.0, 0.3, (0.5, 0.0), {"a": (0.0, 0.0), "b": (1.0, 0.0)}))
    beam = d.add(ph.Beam("beam", bar, (1.0, 0.0), (2.0, 0.0), 3))
    d.pin(body["a"], d.ground, multiplier=True)
    d.weld(body["b"], beam.start, multiplier=True)
    assert ph.simulate(d.compile(), 0.1, 0.005).health.ok


def test_where_joints_hold_all_there_is_nothing_to_judge():
    d = ph.Diagram("held", gravity=(0.0, -9.81))
    body = d.add(ph.RigidBody("body", 0.7, 0.2, (0.3, 0.4), {"foot": (0.0, 0.0)}))
    d.weld(body["foot"], d.ground, multiplier=True)
    solution = ph.simulate(d.compile(), 0.1, 0.01)
    assert solution.health.ok and solution.health["unresolved share of energy"].value == 0.0


def test_halvings_are_counted(four_bar):
    """Three iterations are too few for steps as long as these."""
    system = four_bar().compile()
    with pytest.warns(HealthWarning, match=r"halvings a step: 0\.\d+, more than 0\.2"):
        solution = ph.simulate(
            system, 2.0, 0.05, method=ph.Midpoint(ph.Newton(max_iterations=3)), limits=ph.Limits(halvings=0.2)
        )
    found = solution.health["halvings a step"]
    assert found.value == solution.statistics.halvings / solution.statistics.steps > 0.2
    iterations = solution.statistics.newton_iterations
    assert solution.health["Newton iterations a step, mean"].value == iterations.mean()
    assert solution.health["Newton iterations a step, most"].value == iterations.max()


# Positions


@pytest.mark.parametrize(("elements", "degree"), [(3, 1), (2, 2)])
@pytest.mark.parametrize("root", ["free", "pinned", "driven"])
def test_gaps_of_all_at_once_are_those_of_one_after_the_other(root, elements, degree):
    """In several causalities: what strain and velocity say of centre and chord, against read-outs place by place."""
    d = ph.Diagram("one")
    beam = d.add(ph.Beam("beam", SOFT, (0.2, 0.1), (1.1, 0.5), elements, degree=degree, curvature=0.4))
    if root != "free":
        d.pin(beam.start, d.ground)
    if root == "driven":
        d.expose(beam.start.rotation, "drive", imposes="angular velocity")
    system = d.compile(outputs="all")
    begin = system.rigid_motion(spin=6.0, about=(0.2, 0.1))
    inputs = {"drive": 6.0} if root == "driven" else None
    solution = ph.simulate(system, 0.6, 0.05, start=begin, inputs=inputs, limits=QUIET).sliced(np.array([0, 4, 8, 12]))
    found = position_gaps(system, solution.recording)[0]["beam"]
    s = np.linspace(0.0, 1.0, 61)  # by trapezoids, the vectors of phblocks.results.chords
    by_velocity, by_strain = (
        np.array([solution.position(beam, float(at), source=source) for at in s]) for source in ("velocity", "strain")
    )
    apart = by_velocity - by_strain
    centre, chord = np.trapezoid(apart, s, axis=0), 12.0 * np.trapezoid((s - 0.5)[:, None, None] * apart, s, axis=0)
    c, s = np.cos(6.0 * solution.t), np.sin(6.0 * solution.t)  # what quadrature makes of the arc turns with it
    turn = np.array([[c, -s], [s, c]])
    ends = [both - np.einsum("ijt,j->ti", turn, both[0]) for both in (centre + 0.5 * chord, centre - 0.5 * chord)]
    by_hand = np.max([np.linalg.norm(end, axis=1) for end in ends], axis=0)
    assert by_hand.max() > 2e-3
    np.testing.assert_allclose(found, by_hand, atol=0.06 * by_hand.max())


def test_gap_of_a_spinning_beam(four_bar):
    """Steady spin: 2 (omega dt)^2 / 24 of the length, at omega dt = 0.5 too much, with energy in order."""
    system, start = spinning()
    values = []
    for step in (0.4, 0.2, 0.1):
        run = ph.simulate(system, 3.0, step / 6.0, start=start, limits=QUIET)
        found = run.health["gap of strain and configuration"]
        slow = block_gaps(run)["beam"].max()
        assert found.value == pytest.approx(slow, rel=0.15) and found.where == "beam"
        values.append(found.value)
    np.testing.assert_allclose(np.log2(np.array(values[:-1]) / values[1:]), 2.0, atol=0.15)
    assert values[-1] == pytest.approx(0.1**2 / 12.0, rel=0.1)
    with pytest.warns(HealthWarning, match=r"gap of strain and configuration: 0\.0\d+, more than 0\.015 \(beam, t = "):
        sick = ph.simulate(system, 3.0, 0.5 / 6.0, start=start)
    assert sick.max_power_balance_error < 1e-11 and sick.health["energy balance, whole run"].verdict == "ok"


def test_closure_is_that_of_the_solution(four_bar):
    """At the saved times it looks at, over the length of the longer bar of the joint."""
    solution = ph.simulate(four_bar().compile(), 0.64, 0.02)  # 33 saved times: all
    gap = solution.closure()["coupler.end = rocker.start"]
    found = solution.health["closure of joints"]
    assert found.where == "coupler.end = rocker.start"
    assert found.value == pytest.approx(gap.max() / 1.5, rel=1e-9) and found.value > 1e-5
    assert found.time == solution.t[gap.argmax()]


def test_a_loop_that_opens_is_named(bar, four_bar):
    """The structure from the state before is too old at this step: the loop opens, energy is exact."""
    soft = ph.Section.rectangle(0.05, 0.05, young=2.1e8, poisson=0.3, density=2710.0, shear_factor=1.0)
    system = four_bar(elements=(4, 3, 3), coupler=soft).compile()
    with pytest.warns(HealthWarning, match=r"closure of joints: .*coupler\.end = rocker\.start"):
        sick = ph.simulate(system, 2.0, 0.1, method=ph.LinearlyImplicit())
    assert sick.status.ok and sick.health["energy balance, whole run"].verdict == "ok"


def test_positions_of_many_blocks_are_left_to_those_who_ask(bar):
    """Twelve links in 40 steps: their gaps would cost more than a twentieth of the run; printed they are."""
    d = ph.Diagram("chain", gravity=(0.0, -9.81))
    links = [d.add(ph.Beam(f"link {i}", bar, (i, 0.0), (i + 1.0, 0.0), elements=2)) for i in range(12)]
    d.pin(links[0].start, d.ground)
    for left, right in itertools.pairwise(links):
        d.pin(left.end, right.start)
    health = ph.simulate(d.compile(), 0.2, 0.005, limits=ph.Limits(gap=1e-12)).health
    name = "gap of strain and configuration"
    assert health.ok and name not in {f.name for f in health.watched}
    assert health[name].verdict == "over" and name in str(health)


def test_small_motions_have_no_gap(four_bar):
    system = four_bar().compile().small_motions()
    health = ph.simulate(system, 0.5, 0.02).health
    with pytest.raises(UnknownNameError, match="closure"):
        health["closure of joints"]


# Momentum


def test_momentum_of_free_beams_falls_with_the_square_of_the_step():
    """Against momenta summed by hand over places of the beams, from velocities and positions that are read out."""
    system, drifts = free(), []
    for dt in (0.02, 0.01):
        run = ph.simulate(system, 1.0, dt, start=system.rigid_motion((1.0, 0.5), 3.0))
        found = [run.health[f"{kind} momentum of free bodies"] for kind in ("linear", "angular")]
        assert [f.where for f in found] == ["first + second"] * 2 and all(f.verdict == "ok" for f in found)
        drifts.append([f.value for f in found])
    np.testing.assert_allclose(np.log2(np.array(drifts[0]) / drifts[1]), 2.0, atol=0.1)
    # by hand: Simpson's rule over 40 pieces of each beam
    spots, weights = np.linspace(0.0, 1.0, 41), np.full(41, 2.0)
    weights[1::2], weights[[0, -1]] = 4.0, 1.0
    weights /= weights.sum()
    few = run.sliced(np.array([0, 25, 50, 75, 100]))
    mass = {"first": 1.2 * math.hypot(1.0, 0.3), "second": 1.2}
    read = {
        name: [np.array([what(name, float(s)) for s in spots]) for what in (few.position, few.velocity, few.spin)]
        for name in mass
    }
    centre = sum(m * weights @ read[name][0][:, 0] for name, m in mass.items()) / sum(mass.values())
    linear, angular, moving, reach = 0.0, 0.0, 0.0, 0.0
    for name, m in mass.items():
        r, v, w = read[name]
        arm, own = r - centre, 2e-3 / 1.2 * w
        speed = np.linalg.norm(v, axis=2)
        linear = linear + m * np.einsum("s,std->td", weights, v)
        angular = angular + m * weights @ (arm[..., 0] * v[..., 1] - arm[..., 1] * v[..., 0] + own)
        moving = moving + m * weights @ speed
        reach = reach + m * weights @ (np.linalg.norm(arm, axis=2) * speed)
    body, *_ = free_bodies(system)
    for found, by_hand in zip(
        momentum_drift(few, body),
        (np.linalg.norm(linear - linear[0], axis=1) / moving.max(), np.abs(angular - angular[0]) / reach.max()),
        strict=True,
    ):
        np.testing.assert_allclose(found[1:], by_hand[1:], rtol=0.05, atol=2e-5)
        assert by_hand.max() > 1e-4


def test_momentum_that_is_lost_is_named():
    """A coarse step of a fast tumble."""
    system = free()
    with pytest.warns(HealthWarning, match=r"linear momentum of free bodies: .* \(first \+ second, t = "):
        ph.simulate(system, 2.0, 0.08, start=system.rigid_motion((1.0, 0.5), 6.0))


def test_what_something_acts_on_is_not_free(four_bar):
    d = ph.Diagram("two")
    loose, tied = (d.add(ph.Beam(name, SOFT, (0.0, y), (1.0, y), 2)) for name, y in (("loose", 0.0), ("tied", 1.0)))
    spring = d.add(ph.TorsionSpring("spring", 3.0))
    d.connect(tied.start.rotation, spring.first)
    d.connect(spring.second, d.ground.rotation)
    d.free(loose.start, loose.end)
    system = d.compile(outputs="all")
    # a torsion spring on the ground takes the angular momentum of what hangs on it, the linear one it leaves alone
    assert {body.blocks: body.spin is None for body in free_bodies(system)} == {
        ("loose",): False,
        ("tied", "spring"): True,
    }
    assert not free_bodies(four_bar(gravity=None).compile())
    for change in ("gravity", "load", "drag"):
        d = ph.Diagram(change, gravity=(0.0, -9.81) if change == "gravity" else None)
        damping = ph.Damping(viscous=0.1) if change == "drag" else None
        beam = d.add(ph.Beam("beam", SOFT, (0.0, 0.0), (1.0, 0.0), 2, damping=damping))
        if change == "load":
            d.expose(beam.end.translation, "push")
        assert not free_bodies(d.compile(outputs="all")), change
    d = ph.Diagram("inner")
    d.add(ph.Beam("beam", SOFT, (0.0, 0.0), (1.0, 0.0), 2, damping=ph.Damping(internal=0.01)))
    assert [body.name for body in free_bodies(d.compile(outputs="all"))] == ["beam"]


def test_a_gear_between_free_discs_takes_angular_momentum_to_its_housing():
    d = ph.Diagram("gear")
    one, two = (
        d.add(ph.RigidBody(name, 1.0, 0.5, (x, 0.0), {"axle": (x, 0.0)})) for name, x in (("one", 0.0), ("two", 1.0))
    )
    gear = d.add(ph.Transformer("gear", 2.0, multiplier=True))
    d.connect(one["axle"].rotation, gear.first)
    d.connect(two["axle"].rotation, gear.second)
    (body,) = free_bodies(d.compile(outputs="all"))
    assert set(body.blocks) == {"one", "two", "gear"} and body.spin is None


# Limits, tables, files


def test_limits_are_the_users(four_bar):
    system = four_bar().compile()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ph.simulate(system, 0.4, 0.02)
        with pytest.raises(HealthWarning, match=r"closure of joints: .*more than 1e-09"):
            ph.simulate(system, 0.4, 0.02, limits=ph.Limits(closure=1e-9))
        solution = ph.simulate(system, 0.4, 0.02, limits=ph.Limits.none())
    assert solution.health.ok and not solution.health.judged(ph.Limits(gap=1e-9)).ok
    with pytest.raises(DataError, match="Limits gap"):
        ph.Limits(gap=-1.0)
    with pytest.raises(ArgumentTypeError, match="Limits balance"):
        ph.Limits(balance="small")
    with pytest.raises(ArgumentTypeError, match="simulate limits"):
        ph.simulate(system, 0.2, 0.02, limits=0.1)


def test_methods_that_do_not_promise_energy_have_a_wider_limit():
    """A hundredth, unless the user says otherwise."""
    system = oscillator()
    rough = ph.ScipyIVP("BDF", rtol=1e-3, atol=1e-6)
    start = system.rigid_motion(spin=1.0)
    solution = ph.simulate(system, 0.5, 0.01, start=start, method=rough)
    assert solution.limits.balance == 1e-2 and 1e-7 < solution.health["energy balance, whole run"].value < 1e-2
    with pytest.warns(HealthWarning, match="energy balance, whole run"):
        ph.simulate(system, 20.0, 0.01, start=start, method=rough)


def test_a_short_run_is_judged_by_its_balance_only(four_bar):
    """Nothing alternates, and no energy is unresolved, in a few steps."""
    system = four_bar().compile()
    ph.simulate(system, 19 * 0.02, 0.02, limits=ph.Limits(closure=1e-9))
    with pytest.warns(HealthWarning, match="energy balance"):
        ph.simulate(system, 19 * 0.02, 0.02, method=ph.Midpoint(ph.Newton(tolerance=0.5)))


def test_a_run_that_ended_early_has_a_status_and_is_not_warned_of(four_bar):
    method = ph.Midpoint(ph.Newton(max_iterations=1, tolerance=1e-15))
    solution = ph.simulate(four_bar().compile(), 1.0, 0.5, method=method, max_halvings=0, limits=ph.Limits(gap=1e-12))
    assert solution.status.name == "step failed"
    assert "step failed" in str(solution.health)


def test_the_table_and_its_record(four_bar):
    solution = ph.simulate(four_bar().compile(), 0.4, 0.02)
    health = solution.health
    lines = str(health).splitlines()
    assert lines[0] == "four-bar: success" and lines[1].split() == ["what", "value", "limit", "verdict", "where"]
    assert repr(health) == str(health) and len(lines) == 3 + len(health.findings)
    record = json.loads(json.dumps(health.to_json()))
    assert [f["name"] for f in record["findings"]] == [f.name for f in health.findings]
    assert {f["verdict"] for f in record["findings"]} == {"ok", "noted"}
    card = solution.system.stability_card(0.02, solution.at(0.4))
    assert health["h omega_max"].value == pytest.approx(card.h_omega_max, rel=1e-9)
    assert health["condition of the Newton matrix"].value == pytest.approx(card.condition, rel=1e-6)
    with pytest.raises(UnknownNameError, match="energy balance, whole run"):
        health["nothing"]
    strict = str(health.judged(ph.Limits(gap=1e-12)))
    assert "over" in strict and strict.splitlines()[-1].startswith("gap of strain and configuration: Rotation")


@pytest.mark.parametrize(("save_every", "chunk"), [(1, 20), (7, 13)])
def test_a_run_on_disk_has_the_same_health(tmp_path, save_every, chunk):
    """Watched chunk by chunk, read without the system as far as that goes."""
    pytest.importorskip("h5py")
    system, start = spinning()
    options = {"t_end": 2.0, "dt": 0.01, "start": start, "save_every": save_every}
    solution = ph.simulate(system, **options)
    written = ph.simulate(system, save=ph.Stream(tmp_path / "run.h5", chunk=chunk), **options)
    for one, two in itertools.product([solution], [written, ph.read(tmp_path / "run.h5", system)]):
        for a, b in zip(one.health.findings, two.health.findings, strict=True):
            assert a.name == b.name and a.where == b.where
            if a.name.startswith("Newton"):  # begins anew with every chunk
                continue
            assert a.value == pytest.approx(b.value, rel=1e-6, abs=1e-12), a.name
    alone = ph.read(tmp_path / "run.h5").health
    assert alone["unresolved share of energy"].value == pytest.approx(
        solution.health["unresolved share of energy"].value, rel=1e-6
    )
    gap = alone["gap of strain and configuration"]
    assert gap.verdict == "unknown" and "ph.read(path, system)" in gap.advice and alone.ok


def test_saving_less_hides_nothing():
    """Sums are over all steps, also those that are not saved; the state of the chunks leaves no trace."""
    jump = driven(lambda t: 1.0 if t > 0.1 else 0.0)
    full, thin = (ph.simulate(jump, 5.0, 0.01, save_every=every, limits=QUIET) for every in (1, 50))
    for name in ("multiplier alternation", "unresolved share of energy", "energy balance, worst step"):
        assert full.health[name].value == pytest.approx(thin.health[name].value, rel=1e-9), name


def test_momenta_in_space():
    """A free beam that moves and turns in a linear scene keeps all three components of both."""
    section = ph.Section(
        axial=1e6, shear=(4e5, 4e5), bending=(200.0, 100.0), mass=1.0, rotary=(1e-3, 2e-3), torsion=150.0, polar=3e-3
    )
    d = ph.Diagram("free in space")
    beam = d.add(ph.Beam("beam", section, (0, 0, 0), (1, 0, 0), elements=4))
    system = d.compile(approximation=ph.Approximation(large_rotation=False), effects="all")
    solution = ph.simulate(system, 0.2, 1e-3, start=system.rigid_motion((1.0, 2.0, 3.0), (0.01, 0.02, 0.03)))
    drift = {f.name: f.value for f in solution.health.watched if "momentum" in f.name}
    assert drift.keys() == {"linear momentum of free bodies", "angular momentum of free bodies"}
    assert all(0.0 <= value < 1e-12 for value in drift.values())
    # the moment of momentum of a unit spin is the inertia of the sections: rho J, rho I and rho I, times the length
    (body,) = free_bodies(system)
    spun = [system.sharing.expand(system.rigid_motion(spin=spin).x) for spin in np.eye(3)]
    np.testing.assert_allclose(body.spin @ np.transpose(spun), np.diag([3e-3, 1e-3, 2e-3]), atol=1e-12)
    assert beam.name in body.name


# Runs that start where an imposed motion has come


def carried() -> ph.System:
    """Two bars on a support that is drawn aside, the second also on the ground."""
    d = ph.Diagram("carried")
    first = d.add(ph.Beam("first", SOFT, (0.0, 0.0), (1.0, 1.0), elements=2))
    second = d.add(ph.Beam("second", SOFT, (1.0, 1.0), (2.0, 0.0), elements=2))
    d.connect(first.start.translation, d.add(ph.Velocity("drive", lambda t: (0.3, 0.0))).port)
    d.pin(first.end, second.start)
    d.pin(second.end, d.ground)
    return d.compile(outputs="all")


def test_what_a_start_does_not_tell_is_left_out():
    """The support had come by 0.15 m: none of it is taken for a gap, and joints between blocks are compared still."""
    system = carried()
    whole = ph.simulate(system, 1.0, 0.01)
    held = "first.start"
    assert held in whole.closure()
    go_on = ph.simulate(system, 0.5, 0.01, start=whole.at(0.5))
    assert held not in go_on.closure() and "first.end = second.start" in go_on.closure()
    for name in ("gap of strain and configuration", "closure of joints"):
        assert go_on.health[name].value < 0.01, name
    np.testing.assert_array_equal(
        go_on.sliced(np.array([30])).position("first", 0.0, source="strain")[0],
        go_on.position("first", 0.0, source="strain")[30],
    )
    # the same place, counted from the ground instead of the support
    np.testing.assert_allclose(go_on.position("first", 0.0, source="strain")[0], [0.15, 0.0], atol=5e-3)


def test_a_joint_to_nothing_but_an_imposed_motion_is_unknown():
    d = ph.Diagram("towed")
    beam = d.add(ph.Beam("beam", SOFT, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.connect(beam.start.translation, d.add(ph.Velocity("drive", lambda t: (0.3, 0.1))).port)
    system = d.compile(outputs="all")
    whole = ph.simulate(system, 1.0, 0.01)
    assert whole.health["closure of joints"].verdict == "ok"
    go_on = ph.simulate(system, 0.5, 0.01, start=whole.at(0.5))
    assert go_on.health.ok and go_on.health["gap of strain and configuration"].value < 0.01
    found = go_on.health["closure of joints"]
    assert found.verdict == "unknown" and "initial configuration" in found.advice


def test_a_gap_that_was_there_at_the_start_is_told():
    """A run that goes on from a state goes on with its gap, and does not count from there."""
    system, start = spinning()
    whole = ph.simulate(system, 1.0, 0.02, start=start, limits=QUIET)
    go_on = ph.simulate(system, 0.5, 0.02, start=whole.at(0.5), limits=QUIET)
    all_of_it, rest = (position_gaps(system, run.recording)[0]["beam"] for run in (whole, go_on))
    assert rest[0] > 5e-4
    np.testing.assert_allclose(rest, all_of_it[25:], rtol=1e-6)
    assert go_on.health["gap of strain and configuration"].value > 5e-4


def test_an_arc_that_turns_rigidly_has_no_gap():
    """Two points an element leave 0.8 mm of this arc to quadrature; wherever it is turned to, that is no gap."""
    d = ph.Diagram("arc", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("beam", SOFT, (0.0, 0.0), (1.0, 0.0), elements=2, degree=1, curvature=1.8))
    d.pin(beam.start, d.ground)
    system = d.compile(outputs="all")
    run = ph.simulate(system, 0.1, 0.01, limits=QUIET)
    angle = np.linspace(0.0, 2.0 * np.pi, run.t.size)
    c, s = np.cos(angle), np.sin(angle)
    turned = np.einsum("ijt,pj->tpi", np.array([[c, -s], [s, c]]), system.start.points)
    theta = system.start.theta + angle[:, None]
    x = np.broadcast_to(system.start.x, run.x.shape)  # without strain
    rigid = replace(run.recording, x=x, theta=theta, points=turned)
    assert block_gaps(replace(run, recording=rigid))["beam"].min() > 5e-4
    np.testing.assert_allclose(position_gaps(system, rigid)[0]["beam"], 0.0, atol=1e-13)
