"""Gears, levers, racks, pistons: statics, dynamics in either causality, a gear between inertias."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, CausalityError, DataError


@pytest.mark.parametrize("turned_round", [False, True])
def test_a_spring_behind_a_gear_is_n_squared_as_stiff(turned_round):
    """Whichever port is at the inertia; the other then gives the angular velocity of the spring."""
    n, k, inertia = 3.0, 2.0, 0.5
    d = ph.Diagram("geared spring")
    disc = d.add(ph.RigidBody("disc", 1.0, inertia, (0.0, 0.0)))
    spring = d.add(ph.TorsionSpring("spring", k, twist=0.3))
    gear = d.add(ph.Transformer("gear", 1.0 / n if turned_round else n))
    near, far = (gear.second, gear.first) if turned_round else (gear.first, gear.second)
    d.connect(disc.centre.rotation, near)
    d.connect(far, spring.second)
    d.connect(spring.first, d.ground.rotation)
    report = d.check()
    assert report.ok and report.switches == ()
    assert report.gives("gear") == {"first": turned_round, "second": not turned_round}
    solution = ph.simulate(d.compile(), t_end=2.0, dt=0.001)
    w = n * np.sqrt(k / inertia)
    np.testing.assert_allclose(solution.angle(disc.centre), 0.1 * (np.cos(w * solution.t) - 1.0), atol=2e-5)
    assert np.ptp(solution.energy.total) < 1e-13 and solution.max_power_balance_error < 1e-15


def test_statics_of_a_lever():
    """A lever of arms 1 : 3 holds a force of 3 N at the short arm with 1 N at the long one."""
    line = ph.Domain("line", ph.Quantity("velocity", "m/s"), ph.Quantity("force", "N"))
    d = ph.Diagram("lever")
    lever, ground = d.add(ph.Transformer("lever", 3.0, line, line)), d.add(ph.Reference("frame", line))
    load = d.add(ph.Current("load", 3.0, line))
    spring = d.add(ph.Inductor("spring", 0.01, domain=line, energy="strain"))
    damper = d.add(ph.Resistor("damper", 0.2, line))
    d.connect(load.port, lever.first)
    d.connect(lever.second, spring.p, damper.p)
    d.connect(spring.n, damper.n, ground.port)
    solution = ph.simulate(d.compile(), t_end=5.0, dt=0.05)
    assert solution.state("spring.force[0]")[-1] == pytest.approx(1.0, rel=1e-9)
    assert solution.max_power_balance_error < 1e-14


def geared_discs(multiplier: bool) -> ph.Diagram:
    d = ph.Diagram("geared discs")
    one, two = (d.add(ph.RigidBody(name, 1.0, inertia, (0.0, 0.0))) for name, inertia in (("one", 2.0), ("two", 1.0)))
    gear = d.add(ph.Transformer("gear", -2.0, multiplier=multiplier))
    push = d.add(ph.Moment("push", 3.0))
    d.connect(push.port, one.centre.rotation, gear.first)
    d.connect(gear.second, two.centre.rotation)
    return d


def test_a_gear_between_inertias_is_a_constraint_on_request():
    with pytest.raises(CausalityError):
        geared_discs(multiplier=False).compile()
    system = geared_discs(multiplier=True).compile()
    assert system.constraint_names == ("gear.moment[0]",)
    solution = ph.simulate(system, t_end=1.0, dt=0.1, start=system.rigid_motion(spin=1.0, blocks=["one"]))
    # energy-norm projection of (1, 0): momentum along (1, -2) is kept, 2 = (2 + 4) w
    spin = 1.0 / 3.0 + 0.5 * solution.t
    np.testing.assert_allclose(solution.state("one.W3[0]"), spin, atol=1e-13)
    np.testing.assert_allclose(solution.state("two.W3[0]"), -2.0 * spin, atol=1e-13)
    assert solution.statistics.start_energy_change == pytest.approx(3.0 / 9.0 - 1.0)
    assert solution.max_power_balance_error < 1e-14


@pytest.mark.parametrize("both_give", [False, True])
def test_a_piston(both_give):
    """Pressure 2 Pa on 3 m^2 holds 6 N; the volume flow of 0.5 m/s is 1.5 m^3/s."""
    area, line = 3.0, ph.Domain("line", ph.Quantity("velocity", "m/s"), ph.Quantity("force", "N"))
    d = ph.Diagram("piston")
    piston = d.add(ph.Gyrator("piston", area, ph.HYDRAULIC, line))
    if both_give:
        pump, brake = d.add(ph.Current("pump", 1.5, ph.HYDRAULIC)), d.add(ph.Resistor("brake", 0.5 / 6.0, line))
        ground = d.add(ph.Reference("frame", line))
        d.connect(brake.n, ground.port)
        d.connect(piston.second, brake.p)
        d.connect(piston.first, pump.port)
        solution = ph.simulate(d.compile(), t_end=1.0, dt=0.5)
        assert abs(solution.power.inputs["pump"][-1]) == pytest.approx(3.0)
    else:
        source, move = d.add(ph.Voltage("pressure", 2.0, ph.HYDRAULIC)), d.add(ph.Voltage("move", 0.5, line))
        d.connect(piston.first, source.port)
        d.connect(piston.second, move.port)
        solution = ph.simulate(d.compile(), t_end=1.0, dt=0.5)
        flow, force = solution.state("piston.volume flow of first[0]"), solution.state("piston.force of second[0]")
        assert flow[-1] == pytest.approx(1.5) and force[-1] == pytest.approx(-6.0)
        assert solution.power.inputs["pressure"][-1] == pytest.approx(3.0)
        assert solution.power.inputs["move"][-1] == pytest.approx(-3.0)


STIFFNESS = (50.0, 20.0)  # N/m along x and y


def sprung_mass(ratio, turned_round, axes="xy"):
    """A mass of 0.5 kg at one end of a lever, springs along the axes at the other."""
    d = ph.Diagram("sprung mass")
    mass = d.add(ph.Mass("mass", 0.5, (0.0, 0.0)))
    springs = [
        d.add(ph.Spring(axis, k, start, (0.0, 0.0)))
        for axis, k, start in zip("xy", STIFFNESS, ((-1.0, 0.0), (0.0, -1.0)), strict=True)
        if axis in axes
    ]
    lever = d.add(ph.Transformer("lever", ratio, ph.TRANSLATION, ph.TRANSLATION))
    near, far = (lever.second, lever.first) if turned_round else (lever.first, lever.second)
    d.connect(far, *(spring.end.translation for spring in springs))
    for spring in springs:
        d.pin(d.ground, spring.start)
    return d, mass, near


@pytest.mark.parametrize("turned_round", [False, True])
@pytest.mark.parametrize("ratio", [3.0, [[0.0, -2.0], [1.0, 0.5]]])
def test_a_lever_in_the_plane(ratio, turned_round):
    """The stiffness behind a lever with the matrix A is A^T K A, whichever end gives."""
    d, mass, near = sprung_mass(ratio, turned_round)
    d.connect(mass.centre.translation, near)
    report = d.check()
    assert report.ok and report.gives("lever") == {"first": turned_round, "second": not turned_round}
    A = ratio * np.eye(2) if np.isscalar(ratio) else np.array(ratio)
    A = np.linalg.inv(A) if turned_round else A
    system = d.compile()
    squares = np.linalg.eigvalsh(A.T @ np.diag(STIFFNESS) @ A / 0.5)
    np.testing.assert_allclose(system.modes(2).frequencies ** 2, squares, rtol=1e-10)
    solution = ph.simulate(system, t_end=1.0, dt=0.01, start=system.rigid_motion(velocity=(0.3, -0.2)))
    assert np.ptp(solution.energy.total) < 1e-15 and solution.energy.total[0] == pytest.approx(0.25 * (0.09 + 0.04))
    assert solution.max_power_balance_error < 1e-16
    J = system.J(np.random.default_rng(1).standard_normal(system.n))
    assert abs(J + J.T).max() == 0.0


def test_statics_of_a_bell_crank():
    """Arms of 1 : 2 turn 4 N along x at one end into 2 N along y on a spring at the other."""
    d, mass, near = sprung_mass([[0.0, -1.0], [2.0, 0.0]], turned_round=False, axes="y")
    damper, push = d.add(ph.Damper("damper", 10.0, (-1.0, 0.0), (0.0, 0.0))), d.add(ph.Force("push", (4.0, 0.0)))
    d.connect(mass.centre.translation, near, push.port, damper.end.translation)
    d.pin(d.ground, damper.start)
    solution = ph.simulate(d.compile(), t_end=20.0, dt=0.02)
    assert solution.state("y.N[0]")[-1] == pytest.approx(2.0, rel=1e-9)
    assert solution.position(mass.centre)[-1] == pytest.approx([2.0 / 20.0 / 2.0, 0.0], rel=1e-9, abs=1e-12)


def rack_and_pinion(multiplier=True, wheel=True):
    """A rack of 2 kg along (3, 4) on a wheel of 0.25 m and 0.1 kg m^2, with a torsion spring of 5 N m."""
    d = ph.Diagram("rack and pinion")
    rack, spring = d.add(ph.Mass("rack", 2.0, (0.0, 0.0))), d.add(ph.TorsionSpring("spring", 5.0))
    pinion = d.add(
        ph.Transformer("pinion", 0.25, second=ph.TRANSLATION, multiplier=multiplier, second_direction=(3.0, 4.0))
    )
    push = d.add(ph.Force("push", (1.0, 0.5)))
    shaft = [d.add(ph.RigidBody("wheel", 1.0, 0.1, (5.0, 5.0))).centre.rotation] if wheel else []
    d.connect(pinion.first, spring.second, *shaft)
    d.connect(spring.first, d.ground.rotation)
    d.connect(rack.centre.translation, push.port, pinion.second)
    return d, rack


def test_rack_and_pinion():
    """Along the rack moves m + I / r^2 = 3.6 kg, across it 2 kg, and the spring is k / r^2 = 80 N/m."""
    d, rack = rack_and_pinion()
    system = d.compile()
    assert system.constraint_names == ("pinion.force[0]",)
    np.testing.assert_allclose(d.compile(effects="all").modes(1).frequencies, [np.sqrt(80.0 / 3.6)], rtol=1e-12)
    solution = ph.simulate(system, t_end=1.0, dt=0.002)
    along, across = np.array([0.6, 0.8]), np.array([-0.8, 0.6])
    path = solution.position(rack.centre)
    w = np.sqrt(80.0 / 3.6)
    np.testing.assert_allclose(path @ along, (1.0 / 80.0) * (1.0 - np.cos(w * solution.t)), atol=1e-6)
    np.testing.assert_allclose(path @ across, -0.5 / 2.0 * 0.5 * solution.t**2, atol=1e-13)
    np.testing.assert_allclose(0.25 * solution.state("wheel.W3[0]"), solution.velocity(rack.centre) @ along, atol=1e-14)
    # the first step from rest: with the spring still slack, the acceleration of the effective mass
    start = ph.simulate(system, t_end=1e-5, dt=1e-5)
    assert start.velocity(rack.centre)[-1] @ along / 1e-5 == pytest.approx(1.0 / 3.6, rel=1e-8)
    assert solution.max_power_balance_error < 1e-15


def test_a_rack_without_a_wheel_turns_the_shaft():
    d, _ = rack_and_pinion(multiplier=False, wheel=False)
    assert d.check().gives("pinion") == {"first": True, "second": False}
    system = d.compile()
    assert system.constraint_names == ()
    np.testing.assert_allclose(d.compile(effects="all").modes(1).frequencies, [np.sqrt(80.0 / 2.0)], rtol=1e-12)
    with pytest.raises(CausalityError):  # the wheel has an angular velocity of its own
        rack_and_pinion(multiplier=False)[0].compile()


def test_a_port_along_a_direction_only_takes():
    """A winch cannot drive a spring that has no mass beside it: nobody says how that end moves across the rope."""
    d = ph.Diagram("winch")
    winch = d.add(ph.Transformer("winch", 0.2, second=ph.TRANSLATION, second_direction=(0.0, 1.0)))
    wheel, spring = d.add(ph.RigidBody("wheel", 1.0, 0.1, (0.0, 0.0))), d.add(ph.Spring("s", 1.0, (0, 0), (0, 1)))
    d.connect(wheel.centre.rotation, winch.first)
    d.connect(winch.second, spring.start.translation)
    d.pin(spring.end, d.ground)
    with pytest.raises(CausalityError, match=r"winch\.second can only take velocity"):
        d.compile()


def test_a_lever_between_two_directions():
    """Two masses of 2 kg, free across: 3 N along x on the first act as on 2 + 2 * 3^2 kg, and move the second in y."""
    d = ph.Diagram("lever")
    one, two = (d.add(ph.Mass(name, 2.0, (x, 0.0))) for name, x in (("one", 0.0), ("two", 5.0)))
    lever = d.add(
        ph.Transformer(
            "lever", 3.0, ph.TRANSLATION, ph.TRANSLATION, first_direction=(2.0, 0.0), second_direction=(0.0, -1.0)
        )
    )
    push = d.add(ph.Force("push", (3.0, 4.0)))
    d.connect(push.port, one.centre.translation, lever.first)
    d.connect(two.centre.translation, lever.second)
    solution = ph.simulate(d.compile(), t_end=1.0, dt=0.1)
    np.testing.assert_allclose(solution.velocity(one.centre)[-1], [0.15, 2.0], atol=1e-14)
    np.testing.assert_allclose(solution.velocity(two.centre)[-1], [0.0, -0.45], atol=1e-14)
    assert solution.max_power_balance_error < 1e-14  # of 8 J


def test_a_lever_between_masses_by_a_multiplier():
    """With the matrix A the masses move as m_1 + A^T m_2 A."""
    A = np.array([[1.0, 2.0], [0.0, -1.0]])
    d = ph.Diagram("lever")
    one, two = (d.add(ph.Mass(name, m, (0.0, 0.0))) for name, m in (("one", 2.0), ("two", 0.5)))
    lever = d.add(ph.Transformer("lever", A, ph.TRANSLATION, ph.TRANSLATION, multiplier=True))
    push = d.add(ph.Force("push", (1.0, 3.0)))
    d.connect(push.port, one.centre.translation, lever.first)
    d.connect(two.centre.translation, lever.second)
    system = d.compile()
    assert system.constraint_names == ("lever.force x[0]", "lever.force y[0]")
    solution = ph.simulate(system, t_end=1.0, dt=0.25)
    velocity = np.linalg.solve(2.0 * np.eye(2) + 0.5 * A.T @ A, [1.0, 3.0])
    np.testing.assert_allclose(solution.velocity(one.centre)[-1], velocity, rtol=1e-13)
    np.testing.assert_allclose(solution.velocity(two.centre)[-1], A @ velocity, rtol=1e-13)
    assert solution.max_power_balance_error < 1e-15


def test_what_is_refused():
    line = {"first": ph.TRANSLATION, "second": ph.TRANSLATION}
    with pytest.raises(DataError, match="Transformer 'g' ratio"):
        ph.Transformer("g", 0.0)
    with pytest.raises(DataError, match="first_direction beside one component"):
        ph.Transformer("g", 1.0, ph.TRANSLATION)
    with pytest.raises(DataError, match="second_direction beside one component"):
        ph.Transformer("g", 1.0, **line, first_direction=(1.0, 0.0))
    with pytest.raises(DataError, match="second_direction: expected none for rotation"):
        ph.Transformer("g", 1.0, second_direction=(1.0, 0.0))
    with pytest.raises(DataError, match="first_direction: expected a direction"):
        ph.Transformer("g", 1.0, ph.TRANSLATION, first_direction=(0.0, 0.0))
    with pytest.raises(DataError, match="an invertible matrix"):
        ph.Transformer("g", [[1.0, 2.0], [2.0, 4.0]], **line)
    with pytest.raises(DataError, match=r"shape \(2, 2\)"):
        ph.Transformer("g", [1.0, 2.0], **line)
    for ratio in ("two", [[1.0], [2.0, 3.0]], [[1.0]]):
        with pytest.raises(ArgumentTypeError, match="a real number"):
            ph.Transformer("g", ratio)
    with pytest.raises(DataError, match="one component, got translation"):
        ph.Gyrator("g", 1.0, ph.TRANSLATION, ph.ROTATION)
    with pytest.raises(DataError, match="Gyrator 'g' ratio"):
        ph.Gyrator("g", 0.0, ph.HYDRAULIC, ph.ROTATION)
    with pytest.raises(ArgumentTypeError, match="a Domain"):
        ph.Gyrator("g", 1.0, "hydraulic", ph.ROTATION)
