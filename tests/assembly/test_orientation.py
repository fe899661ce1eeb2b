"""Joints, loads and openings in space: what needs no orientation that turns, and that all else is refused."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import OrientationError, SpaceError
from phblocks.space import PLANAR, SPATIAL

SECTION = ph.Section(axial=2e3, shear=(1e3, 1.2e3), bending=(10.0, 15.0), mass=1.0, rotary=(2e-2, 3e-2), torsion=8.0)
LINEAR = ph.Approximation(large_rotation=False)
O, A, B = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0)


def arm(d, name="arm", start=O, end=A, **options):
    return d.add(ph.Beam(name, SECTION, start, end, 2, **options))


def clamped(gravity=None, **options):
    d = ph.Diagram("clamped", gravity)
    beam = arm(d, **options)
    d.weld(d.ground, beam.start)
    return d, beam


def two(joint):
    d = ph.Diagram("two")
    first, second = arm(d, "first"), arm(d, "second", A, B)
    d.weld(d.ground, first.start)
    getattr(d, joint)(first.end, second.start)
    return d


def with_force(**options):
    d, beam = clamped()
    d.connect(beam.end.translation, d.add(ph.Force("pull", (0.0, 0.0, 1.0), **options)).port)
    return d


def with_moment(**options):
    d, beam = clamped()
    d.connect(beam.end.rotation, d.add(ph.Moment("twist", (0.0, 0.0, 1.0), **options)).port)
    return d


def driven(source, port, **options):
    d = ph.Diagram("driven")
    beam = arm(d)
    if port == "rotation":
        d.pin(d.ground, beam.start)
    d.connect(getattr(beam.start, port), d.add(source("drive", lambda t: (0.0, 0.0, t), **options)).port)
    return d


def exposed(port, **options):
    d, beam = clamped()
    d.expose(getattr(beam.end, port), "tip", **options)
    return d


NEEDS = {
    "a pin of two beams": (lambda **_: two("pin"), r"joint of .*first\.end\.translation"),
    "a force": (with_force, r"input 'pull' on arm\.end\.translation"),
    "a moment": (with_moment, r"input 'twist' on arm\.end\.rotation"),
    "a velocity": (lambda **o: driven(ph.Velocity, "translation", **o), "input 'drive' on arm.start.translation"),
    "a spin": (lambda **o: driven(ph.AngularVelocity, "rotation", **o), "input 'drive' on arm.start.rotation"),
    "an open force": (lambda **o: exposed("translation", **o), "input 'tip' on arm.end.translation"),
    "an open moment": (lambda **o: exposed("rotation", **o), "input 'tip' on arm.end.rotation"),
    "a line load": (
        lambda **o: clamped(loads=ph.LineLoad("snow", (0.0, 0.0, -1.0), **o))[0],
        "load 'snow' of 'arm'",
    ),
    "gravity": (lambda **_: clamped((0.0, 0.0, -9.81))[0], "gravity on 'arm'"),
}


@pytest.mark.parametrize(("make", "where"), NEEDS.values(), ids=NEEDS)
def test_what_needs_an_orientation_that_turns_is_refused(make, where):
    """And says what to do: each is there without large rotations, and all that is given in components if it follows."""
    d = make()
    with pytest.raises(OrientationError, match=f"PH405.*{where}.*not computed yet.*large") as caught:
        d.compile()
    assert "plane" in caught.value.fix
    with pytest.raises(OrientationError):
        d.compile(approximation=ph.Approximation(large_rotation="second-order"))
    assert d.compile(approximation=LINEAR).n > 0
    if "pin" not in where and "gravity" not in where and "joint" not in where:
        followed = make(follows=True).compile()
        assert followed.n > 0 and followed.attitudes
        assert not followed.K.values.size and not followed.K_u.values.size  # nothing turns against anything


def test_gravity_that_is_left_out_needs_no_orientation():
    d, _ = clamped((0.0, 0.0, -9.81))
    assert d.compile(approximation=ph.Approximation(gravity=False)).n > 0
    assert clamped(O)[0].compile().space == SPATIAL


def test_frames_at_a_weld_turn_together():
    """Shared states, given and taken, and imposed from outside: everything at the joint turns with one thing."""
    system = two("weld").compile()
    one, other = (system.attitudes[path] for path in ("first.end", "second.start"))
    assert one.turning == other.turning is not None
    np.testing.assert_allclose(other.minus(one).matrix(), [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)
    assert system.attitudes["first.start"].fixed and system.attitudes["ground.anchor"].fixed
    assert not system.attitudes["second.end"].minus(other).fixed
    drive = driven(ph.AngularVelocity, "rotation", follows=True).compile()
    assert drive.attitudes["arm.start"].turning == "drive"


def test_a_quarter_turn_between_welded_beams_stays_in_its_plane():
    """V1 of one is V2 of the other: a push across the second leaves of both the components of the plane."""
    d = ph.Diagram("corner")
    first, second = arm(d, "first"), arm(d, "second", A, B)
    d.weld(d.ground, first.start)
    d.weld(first.end, second.start)
    d.connect(second.end.translation, d.add(ph.Force("push", (0.0, 1.0, 0.0), follows=True)).port)
    for approximation in (None, LINEAR):
        system = d.compile(approximation=approximation)
        for name in ("first", "second"):
            left = [e.name for e in system.effects.select(block=name, status="kept") if len(e.name) == 2]
            assert left == ["V1", "V2", "W3", "N1", "N2", "M3"]


def test_components_follow_the_frame_of_the_port_that_was_opened():
    """At a weld of beams whose frames differ, the opened port says in whose frame the force is."""
    found = []
    for own in ("first", "second"):
        d = ph.Diagram("corner")
        beams = {"first": arm(d, "first"), "second": arm(d, "second", A, B)}
        d.weld(d.ground, beams["first"].start)
        d.weld(beams["first"].end, beams["second"].start)
        port = beams["first"].end if own == "first" else beams["second"].start
        d.expose(port.translation, "push", follows=True)
        system = d.compile(effects="all")
        force = (2.0, 1.0, 3.0) if own == "first" else (1.0, -2.0, 3.0)  # axis 1 of the second is axis 2 of the first
        found.append(ph.simulate(system, 0.2, 0.01, inputs={"push": force}).x)
    np.testing.assert_allclose(found[0], found[1], rtol=0.0, atol=1e-13)


@pytest.mark.parametrize(
    ("put", "says"),
    [
        (lambda d: d.add(ph.Mass("m", 1.0, (0.0, 0.0))), "add 'm'.*expected spatial parts, as block 'arm' says"),
        (lambda d: d.add(ph.Force("f", (0.0, 0.0))), "add 'f'"),
        (lambda d: d.add(ph.Moment("f", 1.0)), "add 'f'"),
        (lambda d: d.add(ph.TorsionSpring("t", 1.0)), "add 't'"),
        (lambda d: d.weld(d.ground, d.blocks["arm"].start, multiplier=True), "weld 'weld ground arm'"),
        (lambda d: d.add(ph.Diagram("flat", gravity=(0.0, 0.0))), "no gravity of its own"),
    ],
)
def test_parts_of_the_plane_in_space(put, says):
    d = ph.Diagram("space")
    arm(d)
    before = list(d.blocks), list(d.network.joined)
    with pytest.raises(ph.PhblocksError, match=says) as caught:
        put(d)
    assert isinstance(caught.value, (SpaceError, ph.errors.NestingError))
    assert (list(d.blocks), list(d.network.joined)) == before


def test_what_comes_first_decides():
    d = ph.Diagram("plane")
    assert d.network.space == PLANAR
    d.add(ph.Force("any", lambda t: (t, t, t)))  # a function fits any space
    arm(d)
    assert d.network.space == SPATIAL
    for made in (ph.Diagram("plane", gravity=(0.0, 0.0)), ph.Diagram("plane")):
        if made.network.gravity is None:
            made.add(ph.Mass("m", 1.0, (0.0, 0.0)))
        with pytest.raises(
            SpaceError, match=r"PH208.*expected planar parts, as (its gravity|block 'm') says, got a spat"
        ):
            arm(made)
    outer = ph.Diagram("outer")
    nested = outer.add(d, "inner")
    assert outer.network.space == SPATIAL and nested["arm"].space == SPATIAL
    flat = ph.Diagram("flat")
    flat.add(ph.Mass("m", 1.0, (0.0, 0.0)))
    with pytest.raises(SpaceError, match=r"diagram 'flat' in diagram 'outer'"):
        outer.add(flat)


@pytest.mark.parametrize(
    "make",
    [
        lambda: ph.Mass("m", 1.0, O),
        lambda: ph.RigidBody("m", 1.0, 1.0, O),
        lambda: ph.Spring("m", 1.0, O, A),
        lambda: ph.Damper("m", 1.0, O, A),
        lambda: ph.Slider("m", O),
    ],
)
def test_parts_that_space_does_not_have_yet(make):
    with pytest.raises(OrientationError, match=r"'m' .*expected two coordinates.*In space there are beams"):
        make()


def test_repairs_in_space_put_in_no_parts_of_the_plane():
    d = ph.Diagram("stuck")
    beam = arm(d, causality="free-free")
    d.weld(d.ground, beam.start)
    report = d.check()
    assert not report.ok and [repair.what for repair in report.repairs]
    for repair in report.repairs:
        assert repair.apply(d).compile().space == SPATIAL
    assert not any(word in str(report) for word in ("bushing", "multiplier", "point mass"))
