"""Sources: constant and in time, fixed and following, and their energy in the ledger."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, DuplicateNameError
from phblocks.space import PLANAR, SPATIAL


def pushed(force, follows=False, spin=0.0):
    d = ph.Diagram("pushed")
    body = d.add(ph.RigidBody("body", 2.0, 0.5, (0.0, 0.0)))
    push = d.add(ph.Force("push", force, follows=follows))
    d.connect(push.port, body.centre.translation)
    system = d.compile(effects="all")  # a start may spin the body, which the force alone does not
    return body, ph.simulate(system, t_end=1.0, dt=0.01, start=system.rigid_motion(spin=spin))


def test_a_constant_force_accelerates_and_its_energy_is_in_the_ledger():
    body, solution = pushed((4.0, -2.0))
    np.testing.assert_allclose(solution.velocity(body.centre)[-1], [2.0, -1.0], rtol=1e-13)
    inputs = solution.power.inputs
    assert inputs["push.x"][-1] == pytest.approx(4.0) and inputs["push.y"][-1] == pytest.approx(1.0)
    assert solution.energy.supplied[-1] == pytest.approx(solution.energy.kinetic[-1], rel=1e-13)


def test_a_force_of_time_is_taken_at_the_middle_of_steps():
    body, solution = pushed(lambda t: (2.0 * t, 0.0))
    assert solution.velocity(body.centre)[-1, 0] == pytest.approx(0.5, rel=1e-13)


def test_a_follower_turns_with_the_body():
    body, solution = pushed((1.0, 0.0), follows=True, spin=2.0)
    v = solution.velocity(body.centre)
    expected = 0.5 * np.stack([np.sin(2.0 * solution.t), 1.0 - np.cos(2.0 * solution.t)], axis=1) / 2.0
    np.testing.assert_allclose(v, expected, atol=2e-5)
    assert solution.max_power_balance_error < 1e-15


def test_a_signal_given_to_the_run_replaces_that_of_the_source():
    d = ph.Diagram("turned")
    disc, drive = d.add(ph.RigidBody("disc", 1.0, 0.5, (0.0, 0.0))), d.add(ph.Moment("drive", 1.0))
    d.connect(drive.port, disc.centre.rotation)
    system = d.compile()
    for inputs, spin in (({}, 2.0), ({"drive": 3.0}, 6.0)):
        solution = ph.simulate(system, t_end=1.0, dt=0.1, inputs=inputs)
        assert solution.spin(disc, (0.0, 0.0))[-1] == pytest.approx(spin)


def test_imposed_velocities_drive_a_beam(bar):
    """A beam whose root is carried and turned: as with expose, but the source brings its signal."""
    runs = []
    for sources in (True, False):
        d = ph.Diagram("shaken")
        beam = d.add(ph.Beam("beam", bar, (0.0, 0.0), (1.0, 0.0), elements=3))
        if sources:
            d.connect(d.add(ph.Velocity("table", (0.0, 0.1))).port, beam.start.translation)
            d.connect(d.add(ph.AngularVelocity("turn", lambda t: t)).port, beam.start.rotation)
            inputs = None
        else:
            d.expose(beam.start.translation, "table", imposes="velocity")
            d.expose(beam.start.rotation, "turn", imposes="angular velocity")
            inputs = {"table": (0.0, 0.1), "turn": lambda t: t}
        runs.append((beam, ph.simulate(d.compile(), t_end=0.2, dt=0.01, inputs=inputs)))
    (one, a), (two, b) = runs
    np.testing.assert_allclose(a.position(one.end), b.position(two.end), atol=1e-12)
    np.testing.assert_allclose(a.energy.supplied, b.energy.supplied, atol=1e-10)
    assert a.angle(one.start)[-1] == pytest.approx(0.02)
    assert [site.known for site in a.system.sites] == [True]


def test_a_constant_angular_velocity_turns_a_beam(bar):
    d = ph.Diagram("turned")
    beam = d.add(ph.Beam("beam", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(beam.start, d.ground)
    d.connect(d.add(ph.AngularVelocity("turn", 0.2)).port, beam.start.rotation)
    system = d.compile()
    solution = ph.simulate(system, t_end=0.5, dt=0.01, start=system.rigid_motion(spin=0.2))
    assert solution.angle(beam.start)[-1] == pytest.approx(0.1, rel=1e-12)


def test_a_constant_angular_velocity_turns_a_clamped_end(bar):
    d = ph.Diagram("turned")
    beam = d.add(ph.Beam("beam", bar, (0.0, 0.0), (1.0, 0.0), elements=2, causality="clamped-free"))
    d.connect(beam.start.translation, d.ground.translation)
    d.connect(d.add(ph.AngularVelocity("turn", 2.0)).port, beam.start.rotation)
    solution = ph.simulate(d.compile(), t_end=0.2, dt=0.01)
    assert solution.angle(beam.start)[-1] == pytest.approx(0.4, rel=1e-12)


def test_names_of_sources_and_exposed_ports_are_one_list():
    d = ph.Diagram("names")
    body = d.add(ph.RigidBody("body", 2.0, 0.5, (0.0, 0.0)))
    d.expose(body.centre.translation, "push")
    with pytest.raises(DuplicateNameError, match="'push'"):
        d.add(ph.Force("push", (0.0, 1.0)))
    d.add(ph.Moment("turn", 0.0))
    with pytest.raises(DuplicateNameError, match="'turn'"):
        d.expose(body.centre.rotation, "turn")


@pytest.mark.parametrize(
    ("make", "error"),
    [
        (lambda: ph.Force("f", 1.0), DataError),
        (lambda: ph.Force("f", (1.0, np.nan)), DataError),
        (lambda: ph.Moment("m", (1.0, 2.0)), DataError),
        (lambda: ph.Velocity("v", "fast"), ArgumentTypeError),
        (lambda: ph.Voltage("v", 1.0, ph.TRANSLATION), DataError),
    ],
)
def test_what_is_refused(make, error):
    with pytest.raises(error):
        make()


def test_a_velocity_that_follows_turns_with_the_part_it_moves():
    """A root that is turned by t^2 and driven along its own axis: as with the same velocity in the fixed frame.

    But for the mean of a turning velocity over a step, which is short of it by (w dt)^2 / 8.
    """
    soft = ph.Section(axial=1e3, shear=5e2, bending=10.0, mass=1.0, rotary=1e-2)

    def tip(follows, dt):
        d = ph.Diagram("root")
        beam = d.add(ph.Beam("beam", soft, (0.0, 0.0), (1.0, 0.0), elements=2))

        def speed(t):
            return (3.0 * t, 0.0) if follows else (3.0 * t * np.cos(t**2), 3.0 * t * np.sin(t**2))

        d.connect(d.add(ph.Velocity("drive", speed, follows=follows)).port, beam.start.translation)
        d.connect(d.add(ph.AngularVelocity("turn", lambda t: 2.0 * t)).port, beam.start.rotation)
        run = ph.simulate(d.compile(), t_end=0.6, dt=dt)
        # where a root that follows has gone to is not the integral of what is imposed
        assert len(run.closure()) == (not follows)
        return run.velocity(beam, 1.0)[-1]

    apart = [np.abs(tip(True, dt) - tip(False, dt)).max() for dt in (0.01, 0.005)]
    assert apart[1] < 1e-4 * np.abs(tip(True, 0.005)).max()
    assert apart[0] / apart[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize(
    ("source", "flat", "spatial"),
    [
        (ph.Force, (1.0, 2.0), (1.0, 2.0, 3.0)),
        (ph.Velocity, (1.0, 2.0), (1.0, 2.0, 3.0)),
        (ph.Moment, 1.0, (1.0, 2.0, 3.0)),
        (ph.AngularVelocity, 1.0, (1.0, 2.0, 3.0)),
    ],
)
def test_the_components_of_a_constant_are_those_of_a_space(source, flat, spatial):
    assert source("s", flat).space is PLANAR and source("s", spatial, follows=True).space is SPATIAL
    assert source("s", lambda t: flat).space is None
    with pytest.raises(DataError, match=r"'s': expected .*in space three"):
        source("s", (1.0, 2.0, 3.0, 4.0))
