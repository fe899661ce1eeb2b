"""Rigid bodies keep their linear momentum; springs keep their elongation with the geometry."""

import numpy as np
import pytest

import phblocks as ph


def test_linear_momentum_of_free_bodies_is_conserved_to_round_off():
    """Two spinning bodies tied by a spring from lever to lever, without gravity."""
    d = ph.Diagram("pair")
    left = d.add(ph.RigidBody("left", 2.0, 0.3, (0.0, 0.0), anchors={"arm": (0.3, 0.2)}))
    right = d.add(ph.RigidBody("right", 5.0, 0.7, (2.0, 0.5), anchors={"arm": (1.6, 0.1)}))
    tie = d.add(ph.Spring("tie", 40.0, (0.3, 0.2), (1.6, 0.1), free_length=0.9))
    d.pin(tie.start, left["arm"])
    d.pin(tie.end, right["arm"])
    system = d.compile()
    start = system.rigid_motion(velocity=(1.0, -2.0), spin=3.0, blocks=["left"])
    solution = ph.simulate(system, 5.0, 0.01, start=start)
    momentum = 2.0 * solution.velocity(left.centre) + 5.0 * solution.velocity(right.centre)
    assert np.abs(momentum - [2.0, -4.0]).max() < 1e-11
    assert solution.max_power_balance_error < 1e-11 * solution.energy.total[0]
    # anchors are carried: the lever keeps its length
    lever = solution.position(left["arm"]) - solution.position(left.centre)
    np.testing.assert_allclose(np.hypot(*lever.T), np.hypot(0.3, 0.2), rtol=1e-14)


def test_elongation_and_geometry_of_a_spring_do_not_separate():
    """An elastic pendulum: the length its force knows and the distance of its ends, over 2000 steps."""
    d = ph.Diagram("elastic pendulum", gravity=(0.0, -9.81))
    bob = d.add(ph.Mass("bob", 1.0, (1.0, 0.0)))
    spring = d.add(ph.Spring("spring", 50.0, (0.0, 0.0), (1.0, 0.0)))
    d.pin(spring.start, d.ground)
    d.pin(spring.end, bob.centre)
    solution = ph.simulate(d.compile(), 20.0, 0.01)
    distance = np.hypot(*solution.position(bob.centre).T)
    assert np.abs(distance - (1.0 + solution.state("spring.N[0]") / 50.0)).max() < 1e-11  # measured: 1.1e-13 m
    assert np.ptp(solution.energy.total) < 1e-10
    assert np.ptp(distance) > 0.1


def test_a_damper_dissipates_what_it_receives():
    d = ph.Diagram("damped")
    mass = d.add(ph.Mass("mass", 2.0, (1.0, 0.0)))
    damper = d.add(ph.Damper("damper", 3.0, (0.0, 0.0), (1.0, 0.0)))
    d.pin(damper.start, d.ground)
    d.pin(damper.end, mass.centre)
    system = d.compile()
    solution = ph.simulate(system, 1.0, 0.001, start=system.rigid_motion(velocity=(1.0, 0.0), blocks=["mass"]))
    assert solution.velocity(mass.centre)[-1, 0] == pytest.approx(np.exp(-1.5), rel=1e-6)
    energy = solution.energy
    assert abs(energy.dissipated[-1] - (energy.total[0] - energy.total[-1])) < 1e-13


def test_a_free_length_may_be_zero_and_not_negative():
    assert ph.Spring("s", 1.0, (0.0, 0.0), (1.0, 0.0), free_length=0).free_length == 0.0
    with pytest.raises(ph.errors.DataError, match="free_length: expected a finite number >= 0"):
        ph.Spring("s", 1.0, (0.0, 0.0), (1.0, 0.0), free_length=-1)


@pytest.mark.parametrize("anchors", [[1.0, 2.0], 3.0, lambda: None])
def test_anchors_that_are_no_mapping(anchors):
    with pytest.raises(ph.errors.ArgumentTypeError, match="mapping"):
        ph.RigidBody("body", 1.0, 1.0, (0.0, 0.0), anchors)


def test_inertia_without_an_inverse_is_refused():
    """1 / 5e-324 is infinite: it went as far as the eigenvalues of a repair."""
    with pytest.raises(ph.errors.DataError):
        ph.RigidBody("body", 1.0, 5e-324, (0.0, 0.0))
