"""Modes of systems with states without energy: multipliers, gears and dampers are eliminated first."""

import numpy as np
import pytest

import phblocks as ph


def test_a_spring_behind_a_gear():
    d = ph.Diagram("geared")
    disc, gear = d.add(ph.RigidBody("disc", 1.0, 0.5, (0.0, 0.0))), d.add(ph.Transformer("gear", 3.0))
    spring = d.add(ph.TorsionSpring("spring", 2.0))
    d.connect(disc.centre.rotation, gear.first)
    d.connect(gear.second, spring.second)
    d.connect(spring.first, d.ground.rotation)
    modes = d.compile().modes(3)
    np.testing.assert_allclose(modes.frequencies, [3.0 * np.sqrt(2.0 / 0.5)], rtol=1e-12)


def test_two_discs_held_together_by_a_multiplier_and_damped():
    """(2 + 4 * 1) w' = -M - c w, M' = k w."""
    d = ph.Diagram("discs")
    one, two = (d.add(ph.RigidBody(name, 1.0, inertia, (0.0, 0.0))) for name, inertia in (("one", 2.0), ("two", 1.0)))
    gear = d.add(ph.Transformer("gear", -2.0, multiplier=True))
    spring, damper = d.add(ph.TorsionSpring("spring", 8.0)), d.add(ph.TorsionDamper("damper", 1.5))
    d.connect(d.ground.rotation, spring.first, damper.first)
    d.connect(one.centre.rotation, gear.first, spring.second, damper.second)
    d.connect(gear.second, two.centre.rotation)
    modes = d.compile().modes(1)
    root = np.roots([6.0, 1.5, 8.0])[0]
    assert modes.frequencies[0] == pytest.approx(abs(root.imag), rel=1e-12)
    assert modes.growth[0] == pytest.approx(root.real, rel=1e-12)


def test_only_states_without_energy():
    d = ph.Diagram("divider")
    source, r, earth = d.add(ph.Voltage("source", 1.0)), d.add(ph.Resistor("r", 1.0)), d.add(ph.Reference("earth"))
    d.connect(source.port, r.p)
    d.connect(r.n, earth.port)
    system = d.compile()
    assert system.modes(1).frequencies.size == 0
    assert ph.simulate(system, t_end=1.0, dt=0.5).energy.dissipated[-1] == pytest.approx(1.0)
