"""Large rotations left out where that is wrong: refused where it is known before a run, else a warning after it."""

import warnings

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ApproximationError, ApproximationWarning, PhblocksWarning

LINEAR = ph.Approximation(large_rotation=False)
INSIST = ph.Approximation(large_rotation=False, insist=True)


@pytest.fixture(scope="module")
def section(references):
    b = references["spin_up"]["beam"]
    return ph.Section(axial=b["EA"], shear=b["kGA"], bending=b["EI"], mass=b["rhoA"], rotary=b["rhoI"])


def rotor(section, approximation=None, drive=None):
    """The spin-up beam: its root is pinned, and turned by an exposed angular velocity or by a source."""
    d = ph.Diagram("rotor")
    beam = d.add(ph.Beam("blade", section, (0, 0), (10, 0), elements=4, degree=2, approximation=approximation))
    d.pin(beam.start, d.ground)
    if drive is None:
        d.expose(beam.start.rotation, "root", imposes="angular velocity")
    else:
        motor = d.add(ph.AngularVelocity("motor", drive))
        d.connect(motor.port, beam.start.rotation)
    return d


def test_a_constant_drive_is_refused_by_compile(section):
    """First frequency 3.7976 rad/s: the linear model would diverge at sqrt(6^2 - 3.7976^2) = 4.645 1/s."""
    with pytest.raises(ApproximationError, match=r"4\.645 1/s") as caught:
        rotor(section, LINEAR, drive=6.0).compile()
    error = caught.value
    assert error.code == "PH403" and "'blade'" in error.where
    assert "below 0.3798 rad/s" in error.expected and "centrifugal stiffening" in error.got
    assert "second-order" in error.fix and "insist=True" in error.fix
    with pytest.raises(ApproximationError):
        rotor(section, drive=-6.0).compile(approximation=LINEAR)


def test_below_the_first_frequency_it_says_what_becomes_of_it(section):
    with pytest.raises(ApproximationError, match=r"falls to 2\.329 rad/s"):  # sqrt(3.7976^2 - 3^2)
        rotor(section, LINEAR, drive=3.0).compile()


def test_a_tenth_of_the_first_frequency_is_the_limit(section):
    assert rotor(section, LINEAR, drive=0.379).compile().linear
    with pytest.raises(ApproximationError):
        rotor(section, LINEAR, drive=0.381).compile()


@pytest.mark.parametrize("kept", [INSIST, ph.Approximation(large_rotation="second-order"), ph.Approximation()], ids=str)
def test_not_refused_on_insistence_or_with_the_physics(section, kept):
    assert rotor(section, kept, drive=6.0).compile().n > 0


def test_inputs_and_starts_are_refused_by_simulate(section):
    system = rotor(section, LINEAR).compile()
    with pytest.raises(ApproximationError):
        ph.simulate(system, 0.1, 0.01, inputs={"root": 6.0})
    with pytest.raises(ApproximationError):
        ph.simulate(system, 0.1, 0.01, inputs={"root": lambda t: 6.0 - t})
    with pytest.raises(ApproximationError):
        ph.simulate(system, 0.1, 0.01, inputs={"root": 0.0}, start=system.rigid_motion(spin=6.0))
    assert ph.simulate(system, 0.1, 0.01, inputs={"root": lambda t: 0.1 * t}).status.ok


def test_blocks_that_keep_large_rotations_may_spin(section):
    """Only the other beam of the two is linear, and that one is at rest."""
    d = rotor(section, drive=6.0)
    still = d.add(ph.Beam("still", section, (0, 1), (10, 1), elements=2, approximation=LINEAR))
    d.weld(still.start, d.ground)
    assert [e.block for e in d.compile().approximations] == ["still"]


@pytest.mark.parametrize("outputs", ["all", None])
def test_a_mechanism_that_turns_is_a_warning_after_the_run(four_bar, outputs):
    system = four_bar().compile(outputs, approximation=LINEAR)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        near_rest = ph.simulate(system, 0.1, 0.01)
    assert near_rest.status.ok
    with pytest.warns(ApproximationWarning) as caught:
        solution = ph.simulate(system, 0.5, 0.01)
    assert [str(w.message).split("'")[1] for w in caught] == ["crank", "coupler", "rocker"]
    assert all(w.filename == __file__ for w in caught)
    largest = np.abs(solution.recording.theta[:, system.part("rocker").theta]).max()
    assert largest > 0.1 and f"turned by {largest:.3g} rad" in str(caught[2].message)
    assert issubclass(ApproximationWarning, PhblocksWarning) and issubclass(PhblocksWarning, UserWarning)


def test_who_insists_is_not_warned(four_bar):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert ph.simulate(four_bar().compile(approximation=INSIST), 0.5, 0.01).status.ok


def test_bodies_are_watched_too():
    """A rigid body has no frequency, so nothing is known before; what it turns is a warning."""
    d = ph.Diagram("top")
    d.add(ph.RigidBody("top", 1.0, 0.1, (0, 0), approximation=LINEAR))
    system = d.compile()
    with pytest.warns(ApproximationWarning, match="'top' turned by 3 rad"):
        ph.simulate(system, 1.0, 0.1, start=system.rigid_motion(spin=3.0))


def test_what_stays_still_is_not_named_for_the_turns_of_others():
    """Its angles are no states: neither those of the disc beside it, nor any of a system without angles."""
    d = ph.Diagram("bar and disc")
    bar = d.add(ph.Beam("bar", ph.Section(1e6, 1e6, 1e3, 1.0, 1e-2), (0, 0), (1, 0), elements=2, approximation=LINEAR))
    d.weld(bar.start, d.ground)
    d.connect(bar.end.translation, d.add(ph.Force("pull", (1.0, 0.0))).port)
    assert ph.simulate(d.compile(), 0.1, 0.05).status.ok
    for i in range(2):  # as many angles as the numbers of angles that are none can point at
        disc = d.add(ph.RigidBody(f"disc{i}", 1.0, 1.0, (5.0, 5.0)))
        d.connect(disc.centre.rotation, d.add(ph.Moment(f"turn{i}", 8.0)).port)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solution = ph.simulate(d.compile(), 1.0, 0.1)
    assert solution.angle(disc.centre)[-1] == pytest.approx(4.0)


def test_small_turns_are_read_at_anchors_too():
    """A moment on a disc and a force on a pinned bar: frames are held, what has turned is known all the same."""
    d = ph.Diagram("small turns")
    disc = d.add(ph.RigidBody("disc", 1.0, 2.0, (5.0, 5.0)))
    d.connect(disc.centre.rotation, d.add(ph.Moment("turn", 0.2)).port)
    stiff = ph.Section(axial=1e6, shear=1e6, bending=1e5, mass=1.0, rotary=1e-2)
    beam = d.add(ph.Beam("beam", stiff, (0.0, 0.0), (1.0, 0.0), elements=2, degree=2))
    d.pin(beam.start, d.ground)
    d.connect(beam.end.translation, d.add(ph.Force("push", (0.0, 0.05))).port)
    solution = ph.simulate(d.compile(approximation=LINEAR), 1.0, 0.05)
    assert solution.angle(disc.centre)[-1] == pytest.approx(0.05)
    np.testing.assert_array_equal(solution.angle(beam.end), solution.angle(beam, 1.0))
    assert solution.angle(beam.end)[-1] == pytest.approx(0.5 * 0.05 / (1.0 / 3.0 + 1e-2), rel=0.02)


@pytest.mark.parametrize("ratio", [3.0, 0.3])
def test_a_spin_through_a_gear_is_refused_by_compile(section, ratio):
    """The blade turns at the motor's 2 rad/s times the ratio; its limit is 0.3798 rad/s."""
    d = ph.Diagram("geared")
    beam = d.add(ph.Beam("blade", section, (0, 0), (10, 0), elements=4, degree=2, approximation=LINEAR))
    d.pin(beam.start, d.ground)
    motor, gear = d.add(ph.AngularVelocity("motor", 2.0)), d.add(ph.Transformer("gear", ratio))
    d.connect(motor.port, gear.first)
    d.connect(gear.second, beam.start.rotation)
    with pytest.raises(ApproximationError, match=rf"{2.0 * ratio:.4g} rad/s, where"):
        d.compile()


def test_a_spin_of_the_next_block_is_refused_by_compile(section):
    """A hub turns at 1 rad/s, and the blade that is welded to it with it."""
    d = ph.Diagram("hub and blade")
    hub = d.add(ph.Beam("hub", section, (0, 0), (1, 0), elements=1, degree=2))
    beam = d.add(ph.Beam("blade", section, (1, 0), (10, 0), elements=4, degree=2, approximation=LINEAR))
    d.pin(hub.start, d.ground)
    d.weld(hub.end, beam.start)
    motor = d.add(ph.AngularVelocity("motor", 1.0))
    d.connect(motor.port, hub.start.rotation)
    with pytest.raises(ApproximationError, match="1 rad/s, where"):
        d.compile()


def test_a_velocity_that_turns_a_block_is_refused_by_compile(section):
    """The far end is moved across at 20 m/s, 10 m from the pin: 2 rad/s. Along both ends it is no spin."""

    def moved(*held):
        d = ph.Diagram("pushed")
        beam = d.add(ph.Beam("blade", section, (0, 0), (10, 0), elements=4, degree=2, approximation=LINEAR))
        for i, (anchor, velocity) in enumerate(zip((beam.start, beam.end), held, strict=True)):
            push = d.add(ph.Velocity(f"push {i}", velocity))
            d.connect(push.port, anchor.translation)
        return d

    with pytest.raises(ApproximationError, match="2 rad/s, where"):
        moved((0.0, 0.0), (0.0, 20.0)).compile()
    assert moved((0.0, 20.0), (0.0, 20.0)).compile().linear


def test_a_spin_up_is_refused_by_simulate_although_it_starts_at_rest(section):
    """A source that is a function of time is looked at over the whole run: 6 t (1 - t / 2 s) has its peak at 1 s."""
    system = rotor(section, LINEAR, drive=lambda t: 6.0 * t * (1.0 - 0.5 * t)).compile()
    with pytest.raises(ApproximationError, match="3 rad/s, where"):
        ph.simulate(system, 2.0, 0.01)
    assert ph.simulate(system, 0.05, 0.01).status.ok


def test_an_input_that_fails_later_is_a_status_as_ever(section):
    system = rotor(section, LINEAR).compile()
    solution = ph.simulate(system, 0.1, 0.01, inputs={"root": lambda t: 0.01 if t < 0.055 else 1.0 / (t - t)})
    assert solution.status.name == "input failed" and solution.t[-1] == pytest.approx(0.05)
