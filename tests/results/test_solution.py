"""Reading results: names, frames, signs of forces, full turns, and what is refused."""

import dataclasses
import math

import numpy as np
import pytest

import phblocks as ph
from phblocks.blocks.form import Form
from phblocks.errors import ArgumentTypeError, DataError, UnknownNameError

READ_OUTS = ["position", "angle", "velocity", "force", "moment", "spin"]


def ramp(t: float) -> float:
    """From 0 to 1 in 0.3 s, smooth enough to leave next to no oscillation behind."""
    s = min(t / 0.3, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


# Names


def test_states_by_name(solution):
    for i in (0, solution.system.n // 2, solution.system.n - 1):
        name = solution.system.state_names[i]
        np.testing.assert_array_equal(solution.state(name), solution.x[:, i])
    for name in ("crank.V1[99]", "", None, 3, ["x"]):
        with pytest.raises(UnknownNameError, match=r"system\.state_names"):
            solution.state(name)


def test_energies_by_name(solution):
    energy = solution.energy
    names = ("kinetic", "strain", "gravity", "supplied", "dissipated", "numerical_loss", "projected", "total")
    assert tuple(energy) == names and len(energy) == 8
    assert not energy.numerical_loss.any() and not energy.projected.any()
    assert energy["kinetic"] is energy.kinetic and energy.kinetic.shape == solution.t.shape
    np.testing.assert_allclose(energy.total, energy.kinetic + energy.strain + energy.gravity, atol=1e-12)
    np.testing.assert_allclose(
        energy.kinetic + energy.strain, [solution.system.energy(x) for x in solution.x], rtol=1e-12
    )
    balance = energy.total - energy.supplied + energy.dissipated
    np.testing.assert_allclose(balance, balance[0], atol=1e-12 * max(1.0, np.abs(energy.total).max()))
    with pytest.raises(UnknownNameError, match="one of kinetic, strain, gravity"):
        energy["heat"]
    with pytest.raises(AttributeError, match="there are kinetic"):
        _ = energy.heat
    assert energy.get("heat") is None and "heat" not in energy


def test_a_place_can_be_named_in_four_ways(solutions, scenes):
    solution, crank = solutions["four-bar"], scenes["four-bar"].network.blocks["crank"]
    for read in READ_OUTS:
        first = getattr(solution, read)(crank, 1.0)
        for target in (("crank", 1.0), (crank.at(1.0),), (crank.end,)):
            np.testing.assert_allclose(getattr(solution, read)(*target), first, rtol=1e-13, atol=1e-13)
        assert first.shape == (solution.t.size, 2)[: first.ndim]
        assert first.ndim == (2 if read in ("position", "velocity", "force") else 1)


# Frames and turns


def test_frames_differ_by_the_angle_of_the_cross_section(solutions):
    solution = solutions["four-bar"]
    angle = solution.angle("crank", 0.5)
    for read in (solution.velocity, solution.force):
        fixed, material = read("crank", 0.5, frame="fixed"), read("crank", 0.5, frame="material")
        c, s = np.cos(angle), np.sin(angle)
        np.testing.assert_allclose(fixed[:, 0], c * material[:, 0] - s * material[:, 1], atol=1e-9)
        np.testing.assert_allclose(fixed[:, 1], s * material[:, 0] + c * material[:, 1], atol=1e-9)
    np.testing.assert_array_equal(solution.velocity("crank", 0.5), solution.velocity("crank", 0.5, frame="fixed"))
    np.testing.assert_array_equal(solution.force("crank", 0.5), solution.force("crank", 0.5, frame="material"))


def test_velocity_is_the_rate_of_position():
    """A stiff beam thrown with a spin."""
    stiff = ph.Section(axial=4e7, shear=2e7, bending=6e4, mass=1.2, rotary=2e-3)
    d = ph.Diagram(gravity=(0.0, -10.0))
    b = d.add(ph.Beam("b", stiff, (0.0, 0.0), (0.6, 0.8), 3, degree=2))
    system = d.compile()
    start = system.rigid_motion(velocity=(1.0, 3.0), spin=2.0)
    solution = ph.simulate(system, t_end=1.0, dt=0.01, start=start)
    for place in (0.0, 0.4, 1.0):
        path, angle = solution.position(b, place), solution.angle(b, place)
        velocity = solution.velocity(b, place)[1:-1]
        assert np.abs(velocity).max() > 3.0
        np.testing.assert_allclose((path[2:] - path[:-2]) / 0.02, velocity, atol=0.01)
        np.testing.assert_allclose((angle[2:] - angle[:-2]) / 0.02, solution.spin(b, place)[1:-1], atol=0.01)
        np.testing.assert_allclose(solution.spin(b, place), 2.0, atol=0.01)


def test_angles_are_counted_on_over_full_turns():
    stiff = ph.Section(axial=4e7, shear=2e7, bending=6e4, mass=1.2, rotary=2e-3)
    d = ph.Diagram()
    b = d.add(ph.Beam("b", stiff, (0.0, 0.0), (-1.0, 0.0), 2, degree=2))  # begins at 180 degrees
    d.pin(b.start, d.ground)
    d.expose(b.start.rotation, "drive", imposes="angular velocity")
    system = d.compile()
    spin = -2.0 * math.pi
    solution = ph.simulate(system, 2.5, 0.01, start=system.rigid_motion(spin=spin), inputs={"drive": spin})
    for read in (b.start, b.end, b.at(0.3), b.at(1.0)):
        angle = solution.angle(read)
        np.testing.assert_allclose(angle, math.pi + spin * solution.t, atol=2e-3)
    assert solution.angle(b.end)[-1] == pytest.approx(-4.0 * math.pi, abs=2e-3)


# Signs of forces: statics by a slow ramp


@pytest.fixture(scope="module")
def cantilever(bar):
    """A cantilever of two welded beams, 2 m, along y, loaded at its tip by (30, 20) N and 5 N m."""
    d = ph.Diagram()
    a = d.add(ph.Beam("a", bar, (0.0, 0.0), (0.0, 1.2), 3, degree=2))
    b = d.add(ph.Beam("b", bar, (0.0, 2.0), (0.0, 1.2), 2, degree=2))  # drawn the other way round
    d.weld(a.start, d.ground)
    d.weld(a.end, b.end)
    d.expose(b.start.translation, "force")
    d.expose(b.start.rotation, "moment")
    force = np.array([30.0, 20.0])
    inputs = {"force": lambda t: ramp(t) * force, "moment": lambda t: 5.0 * ramp(t)}
    return a, b, ph.simulate(d.compile(), t_end=0.4, dt=0.004, inputs=inputs)


@pytest.mark.parametrize("place", [0.0, 0.25, 0.5, 1.0])
def test_internal_force_is_what_the_far_part_does_to_the_near_part(cantilever, place):
    """On beam a everything beyond a cut pulls with the load; on b, drawn towards the root, the reaction does."""
    a, b, solution = cantilever
    np.testing.assert_allclose(solution.force(a, place, frame="fixed")[-1], [30.0, 20.0], rtol=6e-3)
    np.testing.assert_allclose(solution.force(a, place)[-1], [20.0, -30.0], rtol=6e-3)  # axial first: e1 is y, e2 is -x
    np.testing.assert_allclose(solution.force(b, place, frame="fixed")[-1], [-30.0, -20.0], rtol=6e-3)
    np.testing.assert_allclose(solution.force(b, place)[-1], [20.0, -30.0], rtol=6e-3)  # tension stays tension


@pytest.mark.parametrize("place", [0.0, 0.5, 1.0])
def test_internal_moment_is_load_times_lever(cantilever, place):
    """About axis 3, r x F = -y Fx: at height y the part above gives 5 - (2 - y) 30."""
    a, b, solution = cantilever
    assert solution.moment(a, place)[-1] == pytest.approx(5.0 - 30.0 * (2.0 - 1.2 * place), rel=1e-2)
    assert solution.moment(b, place)[-1] == pytest.approx(-(5.0 - 30.0 * 0.8 * place), rel=1e-2)


def test_the_tip_goes_where_it_is_pushed(cantilever, bar):
    """Linear theory: F L^3 / 3 EI + F L / kGA with the moment's -M L^2 / 2 EI."""
    _, b, solution = cantilever
    EI = bar.bending[1]
    x = 30.0 * 8.0 / (3.0 * EI) + 30.0 * 2.0 / bar.shear - 5.0 * 4.0 / (2.0 * EI)
    for source in ("strain", "velocity"):
        moved = solution.position(b.start, source=source)[-1] - solution.position(b.start, source=source)[0]
        assert moved[0] == pytest.approx(x, rel=1e-2)
    turned = 5.0 * 2.0 / EI - 30.0 * 4.0 / (2.0 * EI)
    assert solution.angle(b.start)[-1] - solution.angle(b.start)[0] == pytest.approx(turned, rel=1e-2)


def test_reactions_at_a_weld_are_opposite(cantilever):
    """Newton's third law: what b does to a at their weld is minus what a does to b. Both are drawn towards it."""
    a, b, solution = cantilever
    scale = 40.0
    force = solution.force(a.end, frame="fixed") + solution.force(b.end, frame="fixed")
    np.testing.assert_allclose(force[-1], 0.0, atol=1e-3 * scale)
    np.testing.assert_allclose(solution.moment(a.end)[-1] + solution.moment(b.end)[-1], 0.0, atol=1e-2 * scale)
    np.testing.assert_allclose(solution.velocity(a.end), solution.velocity(b.end), atol=1e-4)


def test_a_truss_carries_its_load_by_axial_forces(bar):
    """Two bars at 3-4-5 angles, pinned at their feet and to each other, pushed down at the top by 100 N."""
    d = ph.Diagram()
    left = d.add(ph.Beam("left", bar, (0.0, 0.0), (0.3, 0.4), 2))
    right = d.add(ph.Beam("right", bar, (0.3, 0.4), (0.6, 0.0), 2))
    d.pin(left.start, d.ground)
    d.pin(left.end, right.start)
    d.pin(right.end, d.ground)
    d.expose(left.end.translation, "load")
    solution = ph.simulate(d.compile(), 0.4, 0.004, inputs={"load": lambda t: (0.0, -100.0 * ramp(t))})
    for beam, way in ((left, (0.6, 0.8)), (right, (0.6, -0.8))):
        np.testing.assert_allclose(solution.force(beam, 0.5)[-1], [-62.5, 0.0], atol=0.2)  # pressure: 100 / (2 * 0.8)
        np.testing.assert_allclose(solution.force(beam, 0.5, frame="fixed")[-1], -62.5 * np.array(way), atol=0.2)
    joint = solution.force(left.end, frame="fixed")[-1] - solution.force(right.start, frame="fixed")[-1]
    np.testing.assert_allclose(joint, [0.0, -100.0], atol=0.3)  # what acts on the two bars is the load
    assert np.abs(solution.moment(left, 0.5)).max() < 0.2


def test_pinned_bars_pull_on_each_other_in_motion(four_bar):
    """At the joints of the four-bar: same velocity, opposite forces, up to the mesh."""
    solution = ph.simulate(four_bar((6, 6, 6), degree=3).compile(), t_end=1.0, dt=0.005)
    for first, second in (("crank", "coupler"), ("coupler", "rocker")):
        one, other = (solution.force(b, s, frame="fixed") for b, s in ((first, 1.0), (second, 0.0)))
        assert np.abs(one).max() > 100.0
        np.testing.assert_allclose(one, other, atol=0.05 * np.abs(one).max())
        speed = solution.velocity(first, 1.0), solution.velocity(second, 0.0)
        np.testing.assert_allclose(*speed, atol=0.05 * np.abs(speed[0]).max())


def test_the_weight_hangs_on_the_pin(bar):
    """A bar that hangs at rest after its weight was let go slowly would sway; so compare the mean of the force."""
    d = ph.Diagram(gravity=(0.0, -9.81))
    b = d.add(ph.Beam("b", bar, (0.0, 0.0), (0.0, -2.0), 4))
    d.pin(b.start, d.ground)
    period = 4.0 * 2.0 / math.sqrt(bar.axial / bar.mass)  # of the lowest axial vibration
    solution = ph.simulate(d.compile(), t_end=20 * period, dt=period / 40)
    weight = bar.mass * 2.0 * 9.81
    assert solution.force(b, 0.0)[:, 0].mean() == pytest.approx(weight, rel=0.01)
    assert solution.force(b, 0.0)[:, 0].max() == pytest.approx(2.0 * weight, rel=0.1)  # dropped, not let down


# What is refused


@pytest.mark.parametrize("read", READ_OUTS)
def test_targets(solutions, scenes, read):
    solution, crank = solutions["four-bar"], scenes["four-bar"].network.blocks["crank"]
    ask = getattr(solution, read)
    for thing in (None, 1, crank.end.translation, scenes["four-bar"], ["crank"]):
        with pytest.raises(ArgumentTypeError, match=r"target: expected a block, its name, beam\.at\(s\) or an anchor"):
            ask(thing, 0.5)
    with pytest.raises(UnknownNameError, match="one of ground, crank, coupler, rocker, got 'slider'"):
        ask("slider", 0.5)
    with pytest.raises(UnknownNameError, match="'arm'"):
        ask(scenes["arm"].network.blocks["arm"], 0.5)
    for s in (-0.1, 1.1, math.nan, "0.5", True, [0.5]):
        with pytest.raises(DataError, match=r"place on 'crank'.*from 0 to 1"):
            ask(crank, s)
    with pytest.raises(DataError, match=r"place on 'crank'.*expected s, got none"):
        ask("crank")
    with pytest.raises(DataError, match="none together with a point"):
        ask(crank.at(0.5), 0.5)
    with pytest.raises(DataError, match="none together with a point"):
        ask(crank.end, 0.5)


def test_the_ground_is_at_rest_and_has_nothing_else_to_read(solutions, scenes):
    ground = scenes["four-bar"].ground
    for read in ("position", "force", "moment"):
        with pytest.raises(UnknownNameError):
            getattr(solutions["four-bar"], read)(ground)
    for read in ("angle", "velocity", "spin"):
        np.testing.assert_array_equal(getattr(solutions["four-bar"], read)(ground), 0.0)


def test_a_block_without_places_has_nothing_to_read_either():
    class Clock(ph.Mass):
        """A mass whose form has no read-outs of its own."""

        def form(self, gives):
            form = super().form(gives)
            return Form(**{f.name: getattr(form, f.name) for f in dataclasses.fields(Form)})

    d = ph.Diagram()
    d.add(Clock("clock", 1.0, (0.0, 0.0)))
    solution = ph.simulate(d.compile(), 0.2, 0.1)
    with pytest.raises(DataError, match="a block with places"):
        solution.position("clock", 0.0)


def test_sources_and_frames(solutions):
    solution = solutions["four-bar"]
    with pytest.raises(DataError, match='source: expected "velocity" or "strain", got \'guess\''):
        solution.position("crank", 0.5, source="guess")
    with pytest.raises(DataError, match="source"):
        solution.closure("guess")
    for read in (solution.velocity, solution.force):
        with pytest.raises(DataError, match='frame: expected "fixed" or "material"'):
            read("crank", 0.5, frame="local")


def test_a_lean_system_says_what_it_did_not_keep(run, scenes):
    """Without outputs: the arm under gravity keeps all, the free chain its joint only, and says so."""
    lean, full = run("arm", system=scenes["arm"].compile(outputs=None)), run("arm")
    np.testing.assert_allclose(lean.position("arm", 0.7), full.position("arm", 0.7), atol=1e-10)
    np.testing.assert_allclose(lean.angle("arm", 0.7), full.angle("arm", 0.7), atol=1e-10)
    lean, full = run("free", system=scenes["free"].compile(outputs=None)), run("free")
    np.testing.assert_allclose(lean.x, full.x, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(lean.force("first", 0.5), full.force("first", 0.5), atol=1e-9)
    first = scenes["free"].network.blocks["first"]
    np.testing.assert_allclose(lean.angle(first.end), full.angle(first.end), atol=1e-10)  # the joint needs this one
    with pytest.raises(UnknownNameError, match=r"orientation of 'first'.*outputs=\"all\""):
        lean.angle("first", 0.5)
    with pytest.raises(UnknownNameError, match=r"outputs=\"all\""):
        lean.position("first", 0.5)
    with pytest.raises(UnknownNameError, match=r"outputs=\"all\""):
        lean.position("first", 0.5, source="velocity")
    with pytest.raises(UnknownNameError, match=r"outputs=\"all\""):
        lean.velocity("first", 0.5)
    with pytest.raises(UnknownNameError, match=r"outputs=\"all\""):
        lean.closure()
    assert lean.velocity("first", 0.5, frame="material").shape == (lean.t.size, 2)


# Status and statistics


def test_status_and_statistics_print_what_happened(solutions):
    solution = solutions["four-bar"]
    assert str(solution.status) == "success: the end was reached"
    numbers = solution.statistics
    mean = numbers.newton_iterations.mean()
    assert str(numbers).startswith(f"40 steps, {mean:.2f} Newton iterations a step, 0 halvings")
    assert numbers.preparation_seconds > 0.0 and numbers.loop_seconds > 0.0
    assert 3 <= numbers.newton_iterations.max() <= 8
