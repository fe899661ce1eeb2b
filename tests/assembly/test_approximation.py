"""Who leaves what out: the diagram for blocks that say nothing, each block for itself; and the record of it."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.effects.record import Effect

A = ph.Approximation
SOFT = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)


def two_bars(first=None, second=None):
    """A pendulum of two beams: diagram."""
    d = ph.Diagram("two", gravity=(0.0, -9.81))
    a = d.add(ph.Beam("a", SOFT, (0, 0), (1, 0), elements=3, approximation=first))
    b = d.add(ph.Beam("b", SOFT, (1, 0), (2, 0), elements=3, approximation=second))
    d.pin(a.start, d.ground)
    d.pin(a.end, b.start)
    return d


def same(one, other):
    """Whether two systems have the same matrices to the last bit."""
    constant = all(np.array_equal(getattr(one, m).toarray(), getattr(other, m).toarray()) for m in ("E", "J0", "T"))
    weight = np.array_equal(one.gravity_force(), other.gravity_force())
    return one.state_names == other.state_names and constant and weight


SAMPLE = [
    A(shear=False),
    A(extension=False, rotary_inertia=False),
    A(flexible=False),
    A(large_rotation=False, insist=True),
    A(large_rotation="second-order"),
    A(gravity=False),
]


@pytest.mark.parametrize("approximation", SAMPLE, ids=str)
def test_for_all_blocks_or_for_the_diagram_is_the_same(approximation):
    by_block = two_bars(approximation, approximation).compile()
    whole = two_bars().compile(approximation=approximation)
    assert same(by_block, whole) and by_block.approximations == whole.approximations
    paths = [ph.simulate(s, 0.1, 0.005).position("b", 1.0) for s in (by_block, whole)]
    np.testing.assert_array_equal(*paths)


@pytest.mark.parametrize("approximation", SAMPLE, ids=str)
def test_a_block_wins_over_the_diagram(approximation):
    """All of what it says takes the place of all of what the diagram says."""
    mixed = two_bars(first=A()).compile(approximation=approximation)
    named = two_bars(first=A(), second=approximation).compile()
    assert same(mixed, named)
    assert {e.block for e in mixed.approximations} == {"b"}
    assert not same(mixed, two_bars().compile(approximation=approximation))


def test_nothing_left_out_is_nothing_changed():
    exact = two_bars().compile()
    assert exact.approximations == ()
    again = two_bars().compile(approximation=A())
    assert same(exact, again) and again.approximations == ()


def test_every_effect_has_a_record():
    """States that the effects have: N1, N2, W3 of three elements, pinned at the start, free at the end: 3 or 4 each."""
    approximation = A(
        extension=False, shear=False, rotary_inertia=False, large_rotation=False, gravity=False, insist=True
    )
    system = two_bars().compile(approximation=approximation)
    sizes = {
        (block, name): sum(s.startswith(f"{block}.{field}[") for s in system.state_names)
        for block in "ab"
        for name, field in (("extension", "N1"), ("shear", "N2"), ("rotary_inertia", "W3"))
    }
    assert all(size in (3, 4) for size in sizes.values())
    expected = [
        Effect(block, name, "approximated", sizes.get((block, name), 0), f"{name}=False")
        for block in "ab"
        for name in ("large_rotation", "gravity", "extension", "shear", "rotary_inertia")
    ]
    assert list(system.approximations) == expected


def test_what_a_block_does_not_have_has_no_record():
    d = ph.Diagram("mixed", gravity=(0.0, -9.81))
    d.add(ph.Mass("m", 1.0, (0, 0)))
    d.add(ph.RigidBody("r", 1.0, 1.0, (0, 0)))
    d.add(ph.Beam("b", SOFT, (0, 0), (1, 0), elements=4, degree=2, damping=ph.Damping(internal=1e-3)))
    everything = A(*[False] * 7, insist=True)
    found = [(e.block, e.name, e.states) for e in d.compile(approximation=everything).approximations]
    assert found == [
        ("m", "gravity", 0),
        ("r", "large_rotation", 0),
        ("r", "gravity", 0),
        ("b", "large_rotation", 0),
        ("b", "gravity", 0),
        ("b", "flexible", 3 * (9 + 8) - 3),
    ]
    (damped,) = d.compile(approximation=A(internal_damping=False)).approximations
    assert (damped.name, damped.states) == ("internal_damping", 24)
    (order,) = d.compile(approximation=A(large_rotation="second-order")).approximations
    assert (order.block, order.reason) == ("b", "large_rotation='second-order'")


def test_the_users_blocks_are_as_they_were_and_find_their_results(bar):
    d = two_bars()
    before = d.network
    system = d.compile(approximation=A(flexible=False))
    assert d.network is before and len(before.blocks) == 3
    a = before.blocks["a"]
    assert a.approximation is None and system.part("a").block is not a
    solution = ph.simulate(system, 0.1, 0.01)
    by_name = solution.position("a", 1.0)
    for target, s in ((a, 1.0), (a.end, None), (a.at(1.0), None)):
        np.testing.assert_array_equal(solution.position(target, s), by_name)
    with pytest.raises(ph.errors.ForeignBlockError):
        solution.position(ph.Beam("a", bar, (0, 0), (1, 0), elements=1), 1.0)


def test_nested_diagrams_take_it_over_and_keep_their_own():
    outer = ph.Diagram("outer", gravity=(0.0, -9.81))
    arm = outer.add(two_bars(first=A(shear=False)), "arm")
    system = outer.compile(approximation=A(extension=False))
    assert [(e.block, e.name) for e in system.approximations] == [("arm/a", "shear"), ("arm/b", "extension")]
    assert ph.simulate(system, 0.1, 0.01).position(arm["b"].end).shape == (11, 2)


def test_pieces_of_a_beam_say_the_same():
    beam = ph.Beam("b", SOFT, (0, 0), (1, 0), elements=4, approximation=A(shear=False))
    assert [piece.approximation for piece in beam.split(0.5)] == [A(shear=False)] * 2


def test_sources_and_exposed_ports_come_along():
    """A load on a diagram of twins acts where it acted: the tip force accelerates a rigid beam by hand."""
    d = ph.Diagram("pushed")
    b = d.add(ph.Beam("b", SOFT, (0, 0), (1, 0), elements=3))
    d.expose(b.end.translation, "tip")
    d.add(push := ph.Force("push", (0.0, 2.0)))
    d.connect(push.port, b.start.translation)
    d.free(b.end.rotation)
    system = d.compile(approximation=A(flexible=False))
    solution = ph.simulate(system, 0.01, 0.001, inputs={"tip": (0.0, 2.0)})
    np.testing.assert_allclose(solution.velocity(b, 0.5)[-1], [0.0, 4.0 * 0.01 / 1.2], rtol=0, atol=1e-14)


def test_the_table_of_a_rigid_part_names_its_joints():
    """A block that says it is rigid is held already when the diagram is checked."""
    report = two_bars(A(flexible=False), A(flexible=False)).check()
    assert report.ok
    assert "pin ground a" in str(report) and "pin a b" in str(report)


@pytest.mark.parametrize("multiplier", [False, True])
def test_a_rigid_beam_is_driven_by_sources(bar, multiplier):
    """A crank that turns at 2 rad/s: at t = 0.3 s its end is at the angle 0.6."""
    d = ph.Diagram("crank")
    crank = d.add(ph.Beam("crank", bar, (0, 0), (1, 0), elements=2, approximation=ph.Approximation(flexible=False)))
    d.pin(crank.start, d.ground)
    motor = d.add(ph.AngularVelocity("motor", 2.0))
    if multiplier:  # through a gear, which then takes on both sides
        motor.signal = 1.0
        gear = d.add(ph.Transformer("gear", 2.0, multiplier=True))
        d.connect(motor.port, gear.first)
        d.connect(gear.second, crank.start.rotation)
    else:
        d.connect(motor.port, crank.start.rotation)
    solution = ph.simulate(d.compile(), 0.3, 0.001)
    assert solution.status.ok
    np.testing.assert_allclose(solution.position(crank, 1.0)[-1], (np.cos(0.6), np.sin(0.6)), atol=1e-6)


def test_a_rigid_beam_is_carried_by_a_velocity(bar):
    d = ph.Diagram("carried")
    beam = d.add(ph.Beam("beam", bar, (0, 0), (1, 0), elements=2, approximation=ph.Approximation(flexible=False)))
    carriage = d.add(ph.Velocity("carriage", (0.5, 0.0)))
    d.connect(carriage.port, beam.start.translation)
    solution = ph.simulate(d.compile(), 0.4, 0.01)
    np.testing.assert_allclose(solution.position(beam, 0.0)[-1], (0.2, 0.0), atol=1e-12)
