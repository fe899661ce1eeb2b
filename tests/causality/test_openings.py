"""Too much imposed from outside, or where nothing can answer: what to leave out is named, and the rest runs."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import HeldPortError, OverdeterminedError, UnderdeterminedError

SOFT = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)


def beam(d: ph.Diagram, **options) -> ph.Beam:
    return d.add(ph.Beam("b", SOFT, (0.0, 0.0), (1.0, 0.0), **({"elements": 2} | options)))


def two_velocities(d):
    start = beam(d).start.translation
    d.expose(start, "one", imposes="velocity")
    d.expose(start, "two", imposes="velocity")


def two_sources(d):
    one, two = d.add(ph.Velocity("one", (0.3, 0.1))), d.add(ph.Velocity("two", lambda t: (np.sin(t), 0.2)))
    d.connect(beam(d).start.translation, one.port, two.port)


def driven_and_grounded(d):
    start = beam(d).start
    d.expose(start.translation, "one", imposes="velocity")
    d.pin(start, d.ground)


def turned_and_grounded(d):
    start = beam(d).start
    d.weld(start, d.ground)
    d.expose(start.rotation, "one", imposes="angular velocity")


def force_on_the_ground(d):
    start = beam(d).start
    d.pin(start, d.ground)
    d.expose(start.translation, "one", imposes="force")


def force_on_what_is_driven(d):
    start = beam(d).start.translation
    d.expose(start, "one", imposes="force")
    d.expose(start, "two", imposes="velocity")


def force_on_a_taking_end(d):
    d.expose(beam(d, causality="pinned-free").start.translation, "one", imposes="force")


def force_between_springs(d):
    a, b = d.add(ph.Spring("a", 10.0, (0, 0), (1, 0))), d.add(ph.Spring("b", 30.0, (1, 0), (2, 0)))
    m = d.add(ph.Mass("m", 1.0, (2.0, 0.0)))
    d.pin(a.start, d.ground)
    d.pin(a.end, b.start)
    d.pin(b.end, m.centre)
    d.expose(a.end.translation, "one", imposes="force")


def velocity_on_a_mass(d):
    d.expose(d.add(ph.Mass("m", 1.0, (0.0, 0.0))).centre.translation, "one", imposes="velocity")


DROP = "leave out {!r}, which imposes {}"
CASES = {
    two_velocities: (OverdeterminedError, [DROP.format("one", "velocity"), DROP.format("two", "velocity")]),
    two_sources: (OverdeterminedError, [DROP.format("one", "velocity"), DROP.format("two", "velocity")]),
    driven_and_grounded: (
        OverdeterminedError,
        [DROP.format("one", "velocity"), "take b.start.translation off the ground: 'one' moves it"],
    ),
    turned_and_grounded: (
        OverdeterminedError,
        [DROP.format("one", "angular velocity"), "take b.start.rotation off the ground: 'one' moves it"],
    ),
    force_on_the_ground: (HeldPortError, [DROP.format("one", "force")]),
    force_on_what_is_driven: (
        HeldPortError,
        [
            DROP.format("two", "velocity"),
            "let 'two' impose force instead of velocity",
            DROP.format("one", "force"),
        ],
    ),
    force_on_a_taking_end: (
        UnderdeterminedError,
        [
            'let beam \'b\' choose its ends (causality="auto", was "pinned-free")',
            "let 'one' impose velocity instead of force",
        ],
    ),
    force_between_springs: (
        UnderdeterminedError,
        [
            "put a point mass of 0.0133 kg at [a.end.translation = b.start.translation = outside 'one']",
            "let 'one' impose velocity instead of force",
        ],
    ),
    velocity_on_a_mass: (
        OverdeterminedError,
        [
            "put a bushing of 1e+06 N/m between outside 'one' and m.centre",
            "hold m, one together by a multiplier (multiplier=True)",
            DROP.format("one", "velocity"),
            "let 'one' impose force instead of velocity",
        ],
    ),
}


@pytest.mark.parametrize("build", CASES, ids=lambda f: f.__name__)
def test_what_is_offered_runs_with_exact_energy(build):
    d = ph.Diagram(build.__name__, gravity=(0.0, -9.81))
    build(d)
    report = d.check()
    error, expected = CASES[build]
    assert {c.error for c in report.conflicts} == {error}
    assert [r.what for r in report.repairs] == expected
    for repair in report.repairs:
        given_up = repair.what.startswith(("leave out", "take", "let 'one'", "let 'two'"))
        assert repair.cost.demands == given_up
        mended = repair.apply(d)
        assert mended.check().ok
        system = mended.compile()
        inputs = {e.name: 0.3 if e.port.domain is ph.ROTATION else (0.3, 0.1) for e in mended.network.exposed}
        solution = ph.simulate(system, t_end=0.1, dt=0.005, inputs=inputs)
        assert solution.status.name == "success", repair
        scale = max(np.abs(solution.energy["kinetic"]).max(), np.abs(solution.energy["supplied"]).max())
        assert scale > 1e-3, repair
        assert solution.max_power_balance_error < 1e-11 * scale, repair
    assert not d.check().ok


def test_a_named_opening_is_gone_and_the_other_is_left():
    d = ph.Diagram()
    two_sources(d)
    for repair, left in zip(d.check().repairs, ("two", "one"), strict=True):
        mended = repair.apply(d)
        assert [e.name for e in mended.network.exposures()] == [left]
        assert {left, "b"} < set(mended.network.blocks)


def test_off_the_ground_the_input_moves_what_the_ground_held():
    """Of a weld, only the translation is let go: the beam slides along without turning."""
    d = ph.Diagram()
    start = beam(d).start
    d.weld(start, d.ground)
    d.expose(start.translation, "one", imposes="velocity")
    repair = d.check().repairs[1]
    assert repair.what == "take b.start.translation off the ground: 'one' moves it"
    solution = ph.simulate(repair.apply(d).compile(), t_end=0.5, dt=0.01, inputs={"one": (0.2, 0.0)})
    np.testing.assert_allclose(solution.position("b", 0.0)[-1], (0.1, 0.0), atol=2e-3)
    np.testing.assert_allclose(solution.angle("b", 0.0), 0.0, atol=1e-12)


def test_an_opening_of_a_block_with_other_ports_stays():
    """A load that a beam brings along is no source: the beam is not taken out with it."""
    d = ph.Diagram()
    b = beam(d, loads=ph.LineLoad("wind", (0.0, 1.0)))
    d.expose(b.start.translation, "one", imposes="velocity")
    d.pin(b.start, d.ground)
    assert all("wind" not in r.what for r in d.check().repairs)


def test_changing_what_was_mended_leaves_the_first_alone():
    d = ph.Diagram()
    two_velocities(d)
    for repair in d.check().repairs:
        mended = repair.apply(d)
        mended.add(ph.Mass("m", 1.0, (5.0, 5.0)))
        mended.expose(mended.network.blocks["m"].centre.translation, "push")
    assert "m" not in d.network.blocks and [e.name for e in d.network.exposures()] == ["one", "two"]


def loose_spring() -> ph.Diagram:
    d = ph.Diagram("loose")
    spring, mass = d.add(ph.Spring("spring", 9.0, (0.0, 0.0), (1.0, 0.0))), d.add(ph.Mass("mass", 1.0, (1.0, 0.0)))
    d.pin(spring.end, mass.centre)
    return d


def loose_damper() -> ph.Diagram:
    d = ph.Diagram("loose")
    damper, mass = d.add(ph.Damper("damper", 9.0, (0.0, 0.0), (1.0, 0.0))), d.add(ph.Mass("mass", 1.0, (1.0, 0.0)))
    d.pin(damper.end, mass.centre)
    return d


def loose_torsion_spring() -> ph.Diagram:
    d = ph.Diagram("loose")
    spring, wheel = d.add(ph.TorsionSpring("spring", 9.0)), d.add(ph.RigidBody("wheel", 1.0, 1.0, (0.0, 0.0)))
    d.connect(spring.second, wheel.centre.rotation)
    return d


@pytest.mark.parametrize(
    ("make", "path", "frequencies"),
    [
        (loose_spring, "spring.start.translation", [3.0]),
        (loose_damper, "damper.start.translation", []),
        (loose_torsion_spring, "spring.first", [3.0]),
    ],
)
def test_a_loose_end_may_be_attached_to_the_ground(make, path, frequencies):
    d = make()
    report = d.check()
    (conflict,), repair = report.conflicts, report.repairs[-1]
    assert "attach it to the ground" in conflict.advice and "auto" not in conflict.advice
    assert repair.what == f"attach {path} to the ground" and repair.cost.demands == 1
    mended = repair.apply(d)
    assert mended.check().ok and not d.check().ok
    np.testing.assert_allclose(mended.compile().modes(5).frequencies, frequencies, rtol=1e-12)


def test_several_loose_ends_are_attached_together():
    d = ph.Diagram("loose")
    mass = d.add(ph.Mass("mass", 1.0, (0.0, 0.0)))
    springs = [d.add(ph.Spring(f"s{i}", 3.0, (0.0, 0.0), (1.0, 0.0))) for i in range(3)]
    d.pin(mass.centre, *(spring.start for spring in springs))
    repair = d.check().repairs[-1]
    assert repair.cost.demands == 3
    np.testing.assert_allclose(repair.apply(d).compile().modes(5).frequencies, [3.0], rtol=1e-12)


def test_a_loose_terminal_has_no_ground():
    d = ph.Diagram("circuit")
    port = {"terminal": ph.SystemPort(ph.ELECTRICAL, (0,), "current")}
    identity = np.eye(1)
    d.add(ph.SystemBlock("winding", J=[[0.0]], G=identity, Q=identity, ports=port))
    report = d.check()
    assert report.repairs == () and "ground" not in report.conflicts[0].advice


def test_the_advice_names_what_the_block_can_do():
    d = ph.Diagram("beam")
    d.add(
        ph.Beam("b", ph.Section(1e4, 1e4, 1.0, 1.0, 1e-3), (0.0, 0.0), (1.0, 0.0), elements=3, causality="pinned-free")
    )
    assert "let beam 'b' choose its ends (causality=\"auto\"" in d.check().conflicts[0].advice
