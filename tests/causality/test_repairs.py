"""Conflicts are irreducible and named; every repair that is offered runs, with energy exact."""

import itertools
import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import phblocks as ph
from phblocks.causality.conflicts import _contradiction
from phblocks.causality.problem import Problem
from phblocks.errors import DanglingPortError, OverdeterminedError, PortInUseError
from tests.benchmarks.compilation import truss

SOFT = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)


def beam(name, x, **options):
    return ph.Beam(name, SOFT, (x, 0.0), (x + 1.0, 0.0), **({"elements": 2} | options))


def body(name, x):
    return ph.RigidBody(name, 1.0 + x, 0.1, (x + 0.5, 0.0), {"left": (x, 0.0), "right": (x + 1.0, 0.0)})


def two_bodies_pinned():
    d = ph.Diagram("bodies", gravity=(0.0, -9.81))
    a, b = d.add(body("a", 0)), d.add(body("b", 1))
    d.pin(a["right"], b["left"])
    return d


def two_bodies_welded():
    d = ph.Diagram("welded", gravity=(0.0, -9.81))
    a, b, c = d.add(body("a", 0)), d.add(body("b", 1)), d.add(beam("c", 2))
    d.weld(a["right"], b["left"])
    d.weld(b["right"], c.start)
    return d


def body_on_the_ground():
    d = ph.Diagram("mounted", gravity=(0.0, -9.81))
    a, c = d.add(body("a", 0)), d.add(beam("c", 1))
    d.weld(a["left"], d.ground)
    d.weld(a["right"], c.start)
    return d


def two_fixed_beams():
    d = ph.Diagram("fixed", gravity=(0.0, -9.81))
    a = d.add(beam("a", 0, causality="free-free"))
    b = d.add(beam("b", 1, causality="free-free"))
    d.pin(a.end, b.start)
    return d


def one_element():
    d = ph.Diagram("one", gravity=(0.0, -9.81))
    a = d.add(beam("a", 0, elements=1))
    d.weld(a.start, d.ground)
    return d


def dangling():
    d = ph.Diagram("dangling", gravity=(0.0, -9.81))
    d.add(beam("a", 0, causality="pinned-free"))
    return d


def several():
    d = ph.Diagram("several", gravity=(0.0, -9.81))
    a = d.add(beam("a", 0, causality="free-free"))
    b = d.add(beam("b", 1, causality="free-free"))
    c = d.add(beam("c", 2, causality="pinned-pinned"))
    d.pin(a.start, d.ground)
    d.pin(a.end, b.start)
    d.pin(b.end, c.start)
    return d


BROKEN = [
    two_bodies_pinned,
    two_bodies_welded,
    body_on_the_ground,
    two_fixed_beams,
    one_element,
    dangling,
    several,
]

EXPECTED = {
    "two_bodies_pinned": [({"a.right.translation = b.left.translation"}, 2, 0)],
    "two_bodies_welded": [({"a.right.translation = b.left.translation"}, 2, 0)],  # their angular velocity is shared
    "two_fixed_beams": [({"a.end.translation = b.start.translation"}, 2, 0)],
    "one_element": [
        ({"a.start.rotation = ground.anchor.rotation", "a.end.rotation"}, 1, 1),
        ({"a.start.translation = ground.anchor.translation", "a.end.translation"}, 1, 1),
    ],
    "dangling": [({"a.start.translation"}, 1, 0)],
}


@pytest.mark.parametrize("make", [m for m in BROKEN if m.__name__ in EXPECTED])
def test_the_conflict_is_what_conflicts_and_nothing_else(make):
    found = [({j.name for j in c.junctions}, len(c.fixed), len(c.ties)) for c in make().check().conflicts]
    key = lambda c: sorted(c[0])  # noqa: E731
    assert sorted(found, key=key) == sorted(EXPECTED[make.__name__], key=key)


@pytest.mark.parametrize("make", BROKEN)
def test_every_repair_checks_and_runs_with_energy_exact(make):
    d = make()
    before = str(d.check())
    repairs = d.check().repairs
    assert repairs
    for repair in repairs:
        mended = repair.apply(d)
        assert mended.check().ok, repair
        solution = ph.simulate(mended.compile(), t_end=0.05, dt=0.01)
        assert solution.status.name == "success", repair
        scale = max(1.0, float(np.abs(solution.energy["kinetic"]).max()))
        assert solution.max_power_balance_error < 1e-9 * scale, repair
    assert str(d.check()) == before and not d.check().ok  # the given one is not changed


def test_repairs_are_ranked_and_priced():
    first, *others = two_bodies_welded().check().repairs
    assert first.what == "make one body of 'a' and 'b'" and first.cost.states == -2 and first.cost.index == 0
    assert [(r.cost.index, r.cost.stiffness is None) for r in others] == [(0, False), (2, True)]
    bushing, multiplier = two_bodies_pinned().check().repairs
    assert bushing.cost.states == 4 and bushing.cost.index == 0
    assert multiplier.cost.states == 2 and multiplier.cost.index == 2
    assert "give beam 'a' two elements" in one_element().check().repairs[0].what


def test_a_merged_body_keeps_momentum_and_inertia():
    d = two_bodies_welded()
    whole = d.check().repairs[0].apply(d).network.blocks["a-b"]
    assert whole.mass == pytest.approx(3.0)
    np.testing.assert_allclose(whole.start, [(0.5 + 2 * 1.5) / 3, 0.0])
    assert whole.inertia == pytest.approx(0.2 + 1.0 * (7 / 6 - 0.5) ** 2 + 2.0 * (1.5 - 7 / 6) ** 2)


def test_a_loop_of_imposed_velocities():
    d = ph.Diagram()
    a = d.add(beam("a", 0, elements=1))
    b = d.add(beam("b", 1, elements=1))
    d.pin(a.end, b.start)
    d.expose(a.start.translation, "one", imposes="velocity")
    d.expose(b.end.translation, "two", imposes="velocity")
    (conflict,) = d.check().conflicts
    assert len(conflict.junctions) == 3 and len(conflict.ties) == 2 and not conflict.fixed
    for name in ("one", "two"):
        assert f"outside {name!r} gives velocity (expose at test_repairs.py:" in conflict.text


def test_messages_say_where():
    with pytest.raises(OverdeterminedError, match=r"pin at test_repairs.py:\d+"):
        two_bodies_pinned().compile()
    with pytest.raises(DanglingPortError, match=r"add at test_repairs.py:\d+"):
        dangling().compile()


@pytest.mark.parametrize("make", BROKEN)
def test_conflicts_are_irreducible(make):
    d = make()
    problem = Problem.of(d.network)
    number = {c.port: p for p, c in enumerate(problem.choices)}
    for conflict in d.check().conflicts:
        names = {j.ports for j in conflict.junctions}
        elements = [
            e
            for e in problem.elements
            if (e.kind == "junction" and problem.junctions[e.number].ports in names)
            or (e.kind == "choice" and e.number in {number[p] for p in conflict.fixed})
            or (e.kind == "tie" and problem.ties[e.number] in conflict.ties)
        ]
        assert _contradiction(problem, elements)
        for e in elements:
            assert _contradiction(problem, [other for other in elements if other != e]) is None


# Reasons


def test_explanations_follow_the_chain():
    d = ph.Diagram()
    a, b = d.add(beam("a", 0)), d.add(beam("b", 1))
    d.weld(a.start, d.ground)
    d.pin(a.end, b.start)
    report = d.check()
    lines = report.explain(a.start.translation).splitlines()
    assert lines[0].startswith("a.start.translation takes velocity because junction [")
    assert lines[0].endswith("has its giver, ground.anchor.translation.") and "weld at test_repairs.py:" in lines[0]
    assert lines[1] == "ground.anchor.translation gives velocity: it is the ground."
    assert "it is free: force 0" in report.explain("b.end.translation")
    assert "the program chose it: the cheapest for" in report.explain("a.end.translation")
    with pytest.raises(LookupError):
        report.explain("a.middle.translation")
    with pytest.raises(TypeError):
        report.explain(a)
    tied = one_element().check()
    assert all(tied.explain(x.port) for x in tied.assignments)


# Free, split


def test_a_port_declared_free_cannot_be_joined():
    d = ph.Diagram()
    a, b = d.add(beam("a", 0)), d.add(beam("b", 1))
    d.free(a.end, b.start.rotation)
    assert "free: force 0" in str(d.check())
    with pytest.raises(PortInUseError, match=r"free at test_repairs\.py"):
        d.pin(a.end, b.start)
    d.compile()


def test_a_free_port_must_be_able_to_give():
    d = ph.Diagram()
    a = d.add(beam("a", 0, causality="pinned-free"))
    d.free(a.start)
    with pytest.raises(DanglingPortError, match=r"free at test_repairs\.py"):
        d.compile()


@pytest.mark.parametrize("curvature", [None, 0.7])
@pytest.mark.parametrize("at", [0.5, 0.3])
def test_halves_make_the_whole(curvature, at):
    whole = beam("w", 0, elements=4, degree=2, curvature=curvature)
    first, second = whole.split(at)
    assert (first.name, second.name) == ("w-1", "w-2")
    assert first.length + second.length == pytest.approx(whole.length, rel=1e-12)
    assert first.length == pytest.approx(at * whole.length)
    boundaries = np.concatenate([first.boundaries, first.length + second.boundaries[1:]])
    expected = np.union1d(whole.boundaries, [at * whole.length]) if at == 0.3 else whole.boundaries
    np.testing.assert_allclose(boundaries, expected, atol=1e-12)
    assert second.start_angle == pytest.approx(first.start_angle + first.curvature * first.length)
    d = ph.Diagram()
    d.add(first), d.add(second)
    d.weld(first.end, second.start)
    d.compile()


# Order, size


@settings(max_examples=25)
@given(st.integers(0, 2**32))
def test_conflicts_do_not_depend_on_the_order_of_adding(seed):
    def build(order):
        blocks = [
            beam("a", 0, causality="free-free"),
            beam("b", 1, elements=1),
            beam("c", 2, causality="pinned-pinned"),
            body("d", 3),
        ]
        order.shuffle(blocks)
        d = ph.Diagram()
        for block in blocks:
            d.add(block)
        of = {b.name: b for b in blocks}
        joints = [(of["a"].end, of["b"].start), (of["b"].end, of["c"].start), (of["c"].end, of["d"]["left"])]
        order.shuffle(joints)
        for joint in joints:
            joint = list(joint)
            order.shuffle(joint)
            d.pin(*joint)
        d.pin(of["d"]["right"], d.ground)
        return d.check()

    first, second = build(random.Random(0)), build(random.Random(seed))

    def summary(report):
        return [
            [frozenset(p.path for p in j.ports) for j in c.junctions] + [p.path for p in c.fixed]
            for c in sorted(report.conflicts, key=lambda c: sorted(p.path for p in c.junction.ports))
        ]

    assert summary(first) == summary(second)
    assert {a.port.path: a.gives for a in first.assignments} == {a.port.path: a.gives for a in second.assignments}
    assert [r.cost for r in first.repairs] == [r.cost for r in second.repairs]


def test_a_thousand_beams_in_a_truss():
    report = truss(1000).check()
    assert report.ok and len(report.switches) == 1


def test_a_conflict_in_a_long_chain_is_named_alone():
    d = ph.Diagram()
    beams = [d.add(beam(f"b{i:03d}", i, **({"causality": "free-free"} if i in (150, 151) else {}))) for i in range(300)]
    for left, right in itertools.pairwise(beams):
        d.pin(left.end, right.start)
    (conflict,) = d.check().conflicts
    assert [j.name for j in conflict.junctions] == ["b150.end.translation = b151.start.translation"]
