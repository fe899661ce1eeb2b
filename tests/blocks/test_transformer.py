"""Gears and levers, pistons: statics, dynamics in either causality, a gear between inertias."""

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


def test_what_is_refused():
    with pytest.raises(DataError, match="Transformer 'g' ratio"):
        ph.Transformer("g", 0.0)
    with pytest.raises(DataError, match="one component, got translation"):
        ph.Transformer("g", 1.0, ph.TRANSLATION)
    with pytest.raises(ArgumentTypeError, match="a Domain"):
        ph.Gyrator("g", 1.0, "hydraulic", ph.ROTATION)
