"""Ends of blocks: what joints transmit is read exactly and alike from both sides."""

import numpy as np
import pytest

import phblocks as ph


@pytest.fixture(scope="module")
def linkage() -> tuple[dict[str, ph.Beam], ph.Solution]:
    """The four-bar of the README, coarse, in motion."""
    bar = ph.Section.rectangle(width=0.05, height=0.05, young=2.1e11, poisson=0.3, density=2710.0)
    d = ph.Diagram("four-bar", gravity=(0.0, -9.81))
    spots = {"crank": ((0.0, 0.5), (2.0, 1.5)), "coupler": ((2.0, 1.5), (3.5, 1.5)), "rocker": ((3.5, 1.5), (2.5, 0.5))}
    beams = {name: d.add(ph.Beam(name, bar, start, end, elements=4)) for name, (start, end) in spots.items()}
    d.pin(beams["crank"].start, d.ground)
    d.pin(beams["crank"].end, beams["coupler"].start)
    d.pin(beams["coupler"].end, beams["rocker"].start)
    d.pin(beams["rocker"].end, d.ground)
    return beams, ph.simulate(d.compile(), t_end=0.5, dt=0.01)


def test_a_pin_on_the_ground_does_not_move(linkage):
    beams, solution = linkage
    np.testing.assert_array_equal(solution.velocity(beams["crank"].start), 0.0)
    np.testing.assert_array_equal(solution.velocity(beams["rocker"], 1.0), 0.0)


def test_joined_ends_move_together_and_their_forces_are_one(linkage):
    beams, solution = linkage
    for first, second in ((beams["crank"], beams["coupler"]), (beams["coupler"], beams["rocker"])):
        velocity = solution.velocity(second.start)
        np.testing.assert_allclose(solution.velocity(first.end), velocity, atol=1e-12 * abs(velocity).max())
        force = solution.force(second.start, frame="fixed")
        np.testing.assert_allclose(solution.force(first.end, frame="fixed"), force, atol=1e-12 * abs(force).max())
        assert abs(force).max() > 10.0


def test_pins_transmit_no_moment(linkage):
    beams, solution = linkage
    for beam in beams.values():
        np.testing.assert_array_equal(solution.moment(beam.start), 0.0)
        np.testing.assert_array_equal(solution.moment(beam.end), 0.0)


def test_the_value_at_an_end_continues_the_field(linkage):
    beams, solution = linkage
    inside, end = (solution.force(beams["coupler"], s) for s in (0.001, 0.0))
    assert abs(inside - end).max() < 0.3 * abs(end).max()


def test_a_weld_transmits_force_and_moment():
    bar = ph.Section.rectangle(width=0.05, height=0.05, young=2.1e11, poisson=0.3, density=2710.0)
    d = ph.Diagram("frame", gravity=(0.0, -9.81))
    post = d.add(ph.Beam("post", bar, (0.0, 0.0), (0.0, 1.0), elements=4))
    arm = d.add(ph.Beam("arm", bar, (0.0, 1.0), (1.0, 1.0), elements=4))
    tip = d.add(ph.Mass("tip", 3.0, (1.0, 1.0)))
    d.weld(post.start, d.ground)
    d.weld(post.end, arm.start)
    d.pin(arm.end, tip.centre)
    solution = ph.simulate(d.compile(), t_end=0.2, dt=0.002)
    moment = solution.moment(arm.start)
    np.testing.assert_allclose(solution.moment(post.end), moment, atol=1e-12 * abs(moment).max())
    np.testing.assert_allclose(
        solution.force(post.end, frame="fixed"), solution.force(arm.start, frame="fixed"), atol=1e-12 * 1e3
    )
    assert abs(moment).max() > 1.0
    # the mass feels its weight and what the arm does to it: m v' = -N(end) + m g
    pulled = solution.force(arm.end, frame="fixed")
    speed = solution.velocity(tip.centre)
    gained = 3.0 * (speed[-1] - speed[0])
    between = 0.5 * (pulled[1:] + pulled[:-1])
    impulse = 0.002 * (between.sum(axis=0) * -1.0) + 3.0 * np.array([0.0, -9.81]) * 0.2
    # to the order dt^2 by which the frame turns within a step
    np.testing.assert_allclose(gained, impulse, atol=1e-3 * np.abs(gained).max())


def test_a_system_without_outputs_reads_what_needs_no_orientation(linkage):
    beams, _ = linkage
    d = ph.Diagram("free")
    beam = d.add(beams["crank"])
    system = d.compile(outputs=None)
    solution = ph.simulate(system, 0.1, 0.05, start=system.rigid_motion(spin=1.0))
    for read in (solution.force, solution.moment, solution.spin):
        assert np.isfinite(read(beam, 0.5)).all()
