"""Modes of systems with states without energy: multipliers, gears and dampers are eliminated first."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.system import constraints


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


@pytest.mark.parametrize("elements", [4, 40])
def test_long_chains_of_states_without_energy_are_found_regular_without_dense_matrices(monkeypatch, elements):
    """Viscous stresses of a damped beam are one group as long as the beam; its rank is that of a mass matrix."""
    dense = []
    svd = np.linalg.svd
    monkeypatch.setattr(np.linalg, "svd", lambda a, *args, **kw: dense.append(len(a)) or svd(a, *args, **kw))
    section = ph.Section(axial=2.8e7, shear=1e7, bending=1.4e4, mass=1.2, rotary=6e-4)
    names = []
    for large in (constraints.LARGE, 10**6):
        monkeypatch.setattr(constraints, "LARGE", large)
        d = ph.Diagram("damped")
        damping = ph.Damping(internal=1e-3)
        beam = d.add(ph.Beam("beam", section, (0, 0), (10, 0), elements, degree=3, damping=damping))
        d.weld(beam.start, d.ground)
        d.expose(beam.end.translation, "tip")
        dense.clear()
        names.append(d.compile(effects="all").constraint_names)
        assert (max(dense, default=0) > 60) == (elements == 40 and large == 10**6)
    assert names == [(), ()]
