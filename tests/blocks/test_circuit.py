"""Circuits: an oscillating one, series and parallel, an accumulator, constraints by a loop or a missing reference."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, CausalityError, DataError, UndeterminedError

R, L, C = 2.0, 0.5, 0.1


def series(voltage=1.0, **capacitor) -> ph.Diagram:
    d = ph.Diagram("RLC")
    source = d.add(ph.Voltage("source", voltage))
    r, coil = d.add(ph.Resistor("r", R)), d.add(ph.Inductor("l", L))
    c, earth = d.add(ph.Capacitor("c", C, **capacitor)), d.add(ph.Reference("earth"))
    d.connect(source.port, r.p)
    d.connect(r.n, coil.p)
    d.connect(coil.n, c.p)
    d.connect(c.n, earth.port)
    return d


def test_step_of_a_series_circuit():
    a, errors = R / (2.0 * L), []
    w = np.sqrt(1.0 / (L * C) - a**2)
    system = series().compile()
    assert system.is_dae and system.constraint_names == () and system.linear
    for dt in (0.02, 0.01):
        solution = ph.simulate(system, t_end=2.0, dt=dt)
        t = solution.t
        exact = 1.0 - np.exp(-a * t) * (np.cos(w * t) + a / w * np.sin(w * t))
        errors.append(np.abs(solution.state("c.voltage[0]") - exact).max())
        assert solution.max_power_balance_error < 1e-15
        energy = solution.energy
        assert energy.supplied[-1] == pytest.approx(energy.total[-1] + energy.dissipated[-1], rel=1e-13)
        np.testing.assert_allclose(solution.power.inputs["source"], energy.supplied)
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)
    assert errors[1] < 2e-4
    assert {"magnetic", "electric"} < set(energy) and "none" not in energy


def test_poles_are_those_of_the_circuit():
    from scipy.linalg import eigvals

    linear = series().compile().linearize()
    values = eigvals(linear.A.toarray(), linear.E.toarray())
    finite = np.sort_complex(values[np.isfinite(values) & (np.abs(values) < 1e6)])
    expected = np.sort_complex(np.roots([L * C, R * C, 1.0]).astype(complex))
    np.testing.assert_allclose(finite, expected, rtol=1e-12)


def test_a_current_divides_over_resistors_in_parallel():
    d = ph.Diagram("divider")
    source, earth = d.add(ph.Current("source", lambda t: 3.0)), d.add(ph.Reference("earth"))
    one, two = d.add(ph.Resistor("one", 1.0)), d.add(ph.Resistor("two", 2.0))
    d.connect(source.port, one.p, two.p)
    d.connect(one.n, two.n, earth.port)
    solution = ph.simulate(d.compile(), t_end=1.0, dt=0.1)
    assert solution.state("one.current[0]")[-1] == pytest.approx(2.0, rel=1e-14)
    assert solution.state("two.current[0]")[-1] == pytest.approx(1.0, rel=1e-14)
    assert solution.energy.dissipated[-1] == pytest.approx(6.0, rel=1e-13)
    assert solution.energy.supplied[-1] == pytest.approx(6.0, rel=1e-13)


def test_inductor_and_capacitor_start_charged():
    d = ph.Diagram("tank")
    coil, c, earth = (
        d.add(ph.Inductor("l", L, current=1.0)),
        d.add(ph.Capacitor("c", C, voltage=2.0)),
        d.add(ph.Reference("earth")),
    )
    d.connect(coil.p, c.p)
    d.connect(coil.n, c.n, earth.port)
    solution = ph.simulate(d.compile(), t_end=1.0, dt=0.001)
    assert solution.energy.magnetic[0] == pytest.approx(0.5 * L) and solution.energy.electric[0] == pytest.approx(
        0.5 * C * 4.0
    )
    w = 1.0 / np.sqrt(L * C)
    exact = 2.0 * np.cos(w * solution.t) - np.sqrt(L / C) * np.sin(w * solution.t)
    np.testing.assert_allclose(solution.state("c.voltage[0]"), exact, atol=2e-5)
    assert np.ptp(solution.energy.total) < 1e-13


def test_a_hydraulic_accumulator_fills():
    d = ph.Diagram("hydraulic")
    pump, tank = d.add(ph.Voltage("pump", 2e5, ph.HYDRAULIC)), d.add(ph.Reference("tank", ph.HYDRAULIC))
    pipe = d.add(ph.Resistor("pipe", 1e8, ph.HYDRAULIC))
    vessel = d.add(ph.Capacitor("vessel", 1e-8, domain=ph.HYDRAULIC))
    d.connect(pump.port, pipe.p)
    d.connect(pipe.n, vessel.p)
    d.connect(vessel.n, tank.port)
    system = d.compile()
    assert system.state_units[0] == "m^3/s" and system.energy_kinds == ("none", "hydraulic")
    solution = ph.simulate(system, t_end=1.0, dt=0.01)
    np.testing.assert_allclose(solution.state("vessel.pressure[0]"), 2e5 * (1.0 - np.exp(-solution.t)), atol=5.0)


def test_a_domain_of_the_users_own():
    line = ph.Domain("line", ph.Quantity("velocity", "m/s"), ph.Quantity("force", "N"))
    d = ph.Diagram("mass on a spring")
    ground, mass = d.add(ph.Reference("frame", line)), d.add(ph.Capacitor("mass", 2.0, 1.0, line, energy="kinetic"))
    spring = d.add(ph.Inductor("spring", 1.0 / 50.0, domain=line, energy="strain"))
    d.connect(mass.p, spring.p)
    d.connect(mass.n, spring.n, ground.port)
    solution = ph.simulate(d.compile(), t_end=1.0, dt=0.001)
    np.testing.assert_allclose(solution.state("mass.velocity[0]"), np.cos(5.0 * solution.t), atol=2e-5)
    assert solution.energy.kinetic[0] == pytest.approx(1.0)


def test_a_capacitor_at_a_source_is_a_constraint_and_its_charge_is_projected():
    d = ph.Diagram("loop")
    source, c = d.add(ph.Voltage("source", 3.0)), d.add(ph.Capacitor("c", C, voltage=1.0))
    earth = d.add(ph.Reference("earth"))
    d.connect(source.port, c.p)
    d.connect(c.n, earth.port)
    system = d.compile()
    assert system.constraint_names == ("c.current[0]",)
    solution = ph.simulate(system, t_end=1.0, dt=0.1)
    assert solution.statistics.start_energy_change == pytest.approx(0.5 * C * (9.0 - 1.0))
    np.testing.assert_allclose(solution.state("c.voltage[0]"), 3.0, rtol=1e-12)


def test_a_circuit_without_reference_is_named():
    d = ph.Diagram("floating")
    coil, c = d.add(ph.Inductor("l", L)), d.add(ph.Capacitor("c", C, voltage=1.0))
    d.connect(coil.p, c.p)
    d.connect(coil.n, c.n)
    with pytest.raises(UndeterminedError, match=r"PH307.*voltage of c\.p \+1, voltage of c\.n \+1.*Reference"):
        d.compile()


def test_two_sources_at_one_junction_conflict():
    d = ph.Diagram("sources")
    one, two = d.add(ph.Voltage("one", 1.0)), d.add(ph.Voltage("two", 2.0))
    r = d.add(ph.Resistor("r", R))
    d.connect(one.port, two.port, r.p)
    with pytest.raises(
        CausalityError, match=r"outside 'one' gives voltage \(add at \S+\), outside 'two' gives voltage"
    ):
        d.compile()


def test_what_is_refused():
    with pytest.raises(DataError, match="Resistor 'r' resistance"):
        ph.Resistor("r", 0.0)
    with pytest.raises(ArgumentTypeError, match="a Domain"):
        ph.Resistor("r", 1.0, "electrical")
    with pytest.raises(DataError, match="a domain of scalars, got rotation"):
        ph.Inductor("l", 1.0, domain=ph.ROTATION)
    with pytest.raises(DataError, match="Capacitor 'c' voltage"):
        ph.Capacitor("c", 1.0, voltage=np.nan)
