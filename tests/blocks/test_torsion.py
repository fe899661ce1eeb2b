"""Torsion springs and dampers: the torsional oscillator, and what is refused."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError

INERTIA, STIFFNESS, DAMPING, TWIST = 2.0, 8.0, 1.5, 0.3


def oscillate(dt: float) -> tuple[ph.RigidBody, ph.Solution]:
    d = ph.Diagram("torsional oscillator")
    disc = d.add(ph.RigidBody("disc", 1.0, INERTIA, (0.0, 0.0)))
    spring = d.add(ph.TorsionSpring("spring", STIFFNESS, twist=TWIST))
    damper = d.add(ph.TorsionDamper("damper", DAMPING))
    d.connect(d.ground.rotation, spring.first, damper.first)
    d.connect(disc.centre.rotation, spring.second, damper.second)
    return disc, ph.simulate(d.compile(), t_end=5.0, dt=dt)


def exact(t):
    a = DAMPING / (2.0 * INERTIA)
    w = np.sqrt(STIFFNESS / INERTIA - a**2)
    return TWIST * np.exp(-a * t) * (np.cos(w * t) + a / w * np.sin(w * t))


def test_damped_oscillation_is_the_exact_one_to_second_order():
    errors = []
    for dt in (0.02, 0.01):
        disc, solution = oscillate(dt)
        errors.append(np.abs(TWIST + solution.angle(disc.centre) - exact(solution.t)).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)
    assert errors[1] < 2e-5


def test_energy_adds_up():
    _, solution = oscillate(0.02)
    start = 0.5 * STIFFNESS * TWIST**2
    assert solution.energy.strain[0] == pytest.approx(start, rel=1e-15)
    assert solution.max_power_balance_error <= 1e-14 * start
    assert solution.energy.dissipated[-1] == pytest.approx(start - solution.energy.total[-1], rel=1e-12)
    assert solution.power.blocks["damper"]["dissipated"][-1] == solution.energy.dissipated[-1] > 0.9 * start


def test_moment_and_angle_never_separate():
    disc, solution = oscillate(0.05)
    moment = solution.state("spring.M3[0]")
    np.testing.assert_allclose(moment / STIFFNESS, TWIST + solution.angle(disc.centre), atol=1e-14)


def test_the_damper_is_a_state_without_energy():
    d = ph.Diagram("damped")
    disc = d.add(ph.RigidBody("disc", 1.0, INERTIA, (0.0, 0.0)))
    damper = d.add(ph.TorsionDamper("damper", DAMPING))
    d.connect(d.ground.rotation, damper.first)
    d.connect(disc.centre.rotation, damper.second)
    system = d.compile()
    assert system.is_dae and system.constraint_names == ()
    solution = ph.simulate(system, t_end=1.0, dt=0.005, start=system.rigid_motion(spin=2.0))
    decay = np.exp(-DAMPING / INERTIA * solution.t)
    np.testing.assert_allclose(solution.spin(disc, (0.0, 0.0)), 2.0 * decay, atol=1e-5)
    spin, moment = solution.spin(disc, (0.0, 0.0)), solution.state("damper.M3[0]")
    np.testing.assert_allclose(moment, DAMPING * spin, atol=1e-4 * DAMPING)
    # over a step it is that of the mean spin; at a saved time the mean of two steps
    np.testing.assert_allclose(moment[1:-1], DAMPING * (spin[:-2] + 2.0 * spin[1:-1] + spin[2:]) / 4.0, rtol=1e-12)


@pytest.mark.parametrize(("value", "error"), [(0.0, DataError), (-1.0, DataError), (np.inf, DataError)])
@pytest.mark.parametrize("kind", [ph.TorsionSpring, ph.TorsionDamper])
def test_what_is_refused(kind, value, error):
    with pytest.raises(error, match="'t'"):
        kind("t", value)
    with pytest.raises(ArgumentTypeError, match="real number"):
        kind("t", "soft")
