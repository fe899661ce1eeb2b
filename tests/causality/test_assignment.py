"""Who gives and who takes: known answers, exhaustive search, independence of order, impossible diagrams."""

import itertools
import random

import pytest

import phblocks as ph
from phblocks.blocks.beam.ends import ENDS
from phblocks.errors import CausalityError


def beam(bar, name, start, end, **options) -> ph.Beam:
    return ph.Beam(name, bar, start, end, **({"elements": 2} | options))


def ends(d: ph.Diagram, name: str) -> str:
    """The causality found for a beam, such as "clamped-free"."""
    return d.network.blocks[name].end_names(d.check().gives(name))


def givers(d: ph.Diagram) -> dict[str, bool]:
    return {a.port.path: a.gives for a in d.check().assignments}


# Known answers


def test_the_four_bar_needs_no_switch(four_bar):
    d = four_bar()
    report = d.check()
    assert report.ok and not report.conflicts and not report.repairs and not report.switches
    assert [ends(d, name) for name in ("crank", "coupler", "rocker")] == [
        "pinned-pinned",
        "free-free",
        "pinned-pinned",
    ]


@pytest.mark.parametrize(
    ("join", "expected", "switches"),
    [
        ([], "free-free", 0),
        ([("pin", "start")], "pinned-free", 1),
        ([("weld", "start")], "clamped-free", 2),
        ([("weld", "end")], "free-clamped", 2),
        ([("pin", "start"), ("pin", "end")], "pinned-pinned", 0),
        ([("weld", "start"), ("weld", "end")], "clamped-clamped", 0),
        ([("weld", "start"), ("pin", "end")], "clamped-pinned", 1),
    ],
)
def test_one_beam_on_the_ground(bar, join, expected, switches):
    d = ph.Diagram()
    b = d.add(beam(bar, "b", (0.0, 0.0), (1.0, 0.0)))
    for verb, where in join:
        getattr(d, verb)(getattr(b, where), d.ground)
    assert ends(d, "b") == expected
    assert len(d.check().switches) == switches


def test_what_the_outside_imposes_is_taken(bar):
    for imposes, expected in (("velocity", "pinned-free"), ("force", "free-free"), (None, "free-free")):
        d = ph.Diagram()
        b = d.add(beam(bar, "b", (0.0, 0.0), (1.0, 0.0)))
        d.expose(b.start.translation, "x", imposes=imposes)
        assert ends(d, "b") == expected


def test_exposing_a_port_that_can_only_take_imposes_velocity(bar):
    d = ph.Diagram()
    b = d.add(beam(bar, "b", (0.0, 0.0), (1.0, 0.0), causality="clamped-free"))
    d.expose(b.start.translation, "x")
    d.expose(b.start.rotation, "w")
    assert d.check().ok and all(i.common for i in d.compile().inputs)


def test_where_three_meet_one_gives(bar):
    d = ph.Diagram()
    parts = [d.add(beam(bar, n, (0.0, 0.0), e)) for n, e in (("a", (1, 0)), ("b", (0, 1)), ("c", (-1, 0)))]
    d.pin(*(p.start for p in parts))
    assert sum(givers(d)[f"{n}.start.translation"] for n in "abc") == 1
    assert len(d.check().switches) == 2  # the other two take at the joint and give at their free ends


def test_fixed_causality_is_kept_and_marked(bar):
    d = ph.Diagram()
    d.add(beam(bar, "b", (0.0, 0.0), (1.0, 0.0), causality="free-free"))
    assert all(a.fixed for a in d.check().assignments if a.port.block.name == "b")
    d = ph.Diagram()
    d.add(beam(bar, "b", (0.0, 0.0), (1.0, 0.0)))
    assert not any(a.fixed for a in d.check().assignments if a.port.block.name == "b")


def test_given_and_taken_are_named_by_their_quantity(four_bar):
    named = {a.port.path: (a.given, a.taken) for a in four_bar().check().assignments}
    assert named["crank.start.translation"] == ("force", "velocity")
    assert named["coupler.start.translation"] == ("velocity", "force")
    assert named["crank.start.rotation"] == ("angular velocity", "moment")


# The fewest switches


def random_diagram(bar, seed: int) -> ph.Diagram:
    """Up to three beams between four places, pinned or welded to each other and to the ground, or not."""
    draw = random.Random(seed)
    places = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    d = ph.Diagram(f"random {seed}")
    at: dict[int, list[ph.Beam]] = {i: [] for i in range(4)}
    for name in "abc"[: draw.randint(1, 3)]:
        i, j = draw.sample(range(4), 2)
        n = draw.choice([1, 2, 2])
        fixed = draw.choice(["auto", "auto", "auto", *ENDS])
        if fixed != "auto":
            fixed = f"{fixed}-{fixed if n == 1 else draw.choice(list(ENDS))}"
        b = d.add(beam(bar, name, places[i], places[j], elements=n, causality=fixed))
        at[i].append(b.start)
        at[j].append(b.end)
    for anchors in at.values():
        joined = [*anchors, d.ground] if anchors and draw.random() < 0.4 else anchors
        if len(joined) > 1 and draw.random() < 0.85:
            d.weld(*joined) if draw.random() < 0.5 else d.pin(*joined)
    return d


def count(junction, gives) -> tuple[int, int]:
    """How many givers too few or too many there are, and how many share the states of another one.

    Where beams are welded, all that give are one giver: their ends are the same states.
    """
    givers = [p for p in junction.ports if gives.get(p, True)]  # the ground gives
    beams = [p for p in givers if not p.block.shared]
    rotation = junction.domain is ph.ROTATION
    if (rotation or junction.made_by.startswith("weld")) and beams:
        return abs(len(givers) - len(beams)), len(beams) - 1
    return abs(len(givers) - 1), 0


def search(d: ph.Diagram) -> tuple[int, float]:
    """By trying all assignments: the least number of givers too few or too many, and the least cost at that number.

    The cost is that of switches, less what is saved by sharing.
    """
    blocks = [b for b in d.network.blocks.values() if not b.shared]
    best = []
    for b in blocks:  # the assignments each block allows, with their switches
        choices, ties = b.choices()
        allowed = []
        for gives in itertools.product([False, True], repeat=len(choices)):
            here = {c.port: g for c, g in zip(choices, gives, strict=True)}
            if all(c.may_give if here[c.port] else c.may_take for c in choices):
                differ = [t for t in ties if here[t.first] != here[t.second]]
                if all(t.cost is not None for t in differ):
                    allowed.append((here, len(differ)))
        best.append(allowed)
    junctions = d.network.junctions()
    results = []
    for combination in itertools.product(*best):
        gives = {port: g for here, _ in combination for port, g in here.items()}
        counts = [count(j, gives) for j in junctions]
        switches, shared = sum(n for _, n in combination), sum(n for _, n in counts)
        results.append((sum(n for n, _ in counts), switches - 0.4 * shared))
    return min(results)


@pytest.mark.parametrize("seed", range(60))
def test_as_good_as_an_exhaustive_search(bar, seed):
    d = random_diagram(bar, seed)
    excess, cost = search(d)
    report = d.check()
    assert report.ok == (excess == 0)
    assert len(report.conflicts) <= excess
    assert all(r.apply(d).check().ok for r in report.repairs)
    gives = {a.port: a.gives for a in report.assignments}
    counts = [count(j, gives) for j in d.network.junctions()]
    assert sum(n for n, _ in counts) == excess
    if report.ok:
        assert len(report.switches) - 0.4 * sum(n for _, n in counts) == pytest.approx(cost)
        d.compile()
    else:
        with pytest.raises(CausalityError):
            d.compile()


def test_the_random_diagrams_are_of_all_kinds(bar):
    found = [search(random_diagram(bar, seed)) for seed in range(60)]
    assert 10 < sum(excess == 0 for excess, _ in found) < 50
    assert {switches for excess, switches in found if excess == 0} >= {0, 1, 2}


# Order


LATTICE = {
    (0, 0): (1, 0),
    (1, 0): (2, 0),
    (0, 1): (1, 1),
    (1, 1): (2, 1),
    (0, 2): (0, 1),
    (1, 2): (1, 1),
    (2, 2): (2, 1),
}


def lattice(bar, order: random.Random | None) -> ph.Diagram:
    """A frame with many equally good assignments, its blocks, joints and the anchors in them in any order."""
    d = ph.Diagram()
    names = [f"b{i}" for i in range(len(LATTICE))]
    beams = dict(zip(names, LATTICE.items(), strict=True))
    shuffle = order.shuffle if order else lambda items: None
    shuffle(names)
    at: dict[tuple[int, int], list] = {}
    for name in names:
        start, end = beams[name]
        b = d.add(beam(bar, name, start, end))
        at.setdefault(start, []).append(b.start)
        at.setdefault(end, []).append(b.end)
    joints = sorted(at)
    shuffle(joints)
    for place in joints:
        anchors = at[place] + ([d.ground] if place[1] == 2 else [])
        shuffle(anchors)
        if len(anchors) > 1:
            (d.weld if place[0] == 1 else d.pin)(*anchors)
    return d


@pytest.mark.parametrize("seed", range(8))
def test_independent_of_the_order_of_adding(bar, seed):
    first, second = lattice(bar, None), lattice(bar, random.Random(seed))
    assert first.check().ok
    assert givers(first) == givers(second)
    assert sorted(first.check().switches) == sorted(second.check().switches)


def test_asking_twice_gives_the_same_answer(bar):
    d = lattice(bar, None)
    assert givers(d) == givers(d)


# Impossible diagrams


def refusal(d: ph.Diagram) -> str:
    report = d.check()
    assert not report.ok and str(report).endswith("not causal")
    with pytest.raises(CausalityError) as caught:
        d.compile()
    assert all(c.text in str(caught.value) for c in report.conflicts)
    assert all(c.advice in caught.value.fix for c in report.conflicts)
    assert all(repair.what in caught.value.fix for repair in report.repairs)
    return str(caught.value)


def test_two_givers_at_a_pin(bar):
    d = ph.Diagram()
    a = d.add(beam(bar, "a", (0.0, 0.0), (1.0, 0.0), causality="free-free"))
    b = d.add(beam(bar, "b", (1.0, 0.0), (2.0, 0.0), causality="free-free"))
    d.pin(a.end, b.start)
    text = refusal(d)
    assert "junction [a.end.translation = b.start.translation] (pin at test_assignment.py:" in text
    assert "a.end.translation can only give velocity, b.start.translation can only give velocity" in text
    assert "Let all but one of a.end.translation, b.start.translation take velocity and give force" in text
    assert 'causality="auto"' in text
    assert [c.junction.name for c in d.check().conflicts] == ["a.end.translation = b.start.translation"]


def test_no_giver_at_a_pin(bar):
    d = ph.Diagram()
    a = d.add(beam(bar, "a", (0.0, 0.0), (1.0, 0.0), causality="free-pinned"))
    b = d.add(beam(bar, "b", (1.0, 0.0), (2.0, 0.0), causality="pinned-free"))
    d.pin(a.end, b.start)
    text = refusal(d)
    assert "a.end.translation can only take velocity, b.start.translation can only take velocity" in text
    assert "Let one of a.end.translation, b.start.translation give velocity" in text


def test_a_dangling_port_that_takes_velocity(bar):
    d = ph.Diagram()
    d.add(beam(bar, "a", (0.0, 0.0), (1.0, 0.0), causality="pinned-free"))
    text = refusal(d)
    assert "junction [a.start.translation] (not joined; add at test_assignment.py:" in text
    assert "a.start.translation can only take velocity" in text
    assert "a.start.translation takes velocity and nothing gives it: join it" in text
    assert 'imposes="velocity"' in text


def test_a_dangling_port_that_takes_angular_velocity(bar):
    d = ph.Diagram()
    d.add(beam(bar, "a", (0.0, 0.0), (1.0, 0.0), causality="free-guided"))
    assert 'expose it with imposes="angular velocity"' in refusal(d)


def test_a_giving_end_on_the_ground(bar):
    d = ph.Diagram()
    a = d.add(beam(bar, "a", (0.0, 0.0), (1.0, 0.0), causality="free-free"))
    d.weld(a.start, d.ground)
    text = refusal(d)
    assert "a.start.translation can only give velocity, ground.anchor.translation can only give velocity" in text
    assert "a.start.rotation can only give angular velocity, ground.anchor.rotation" in text
    assert len(d.check().conflicts) == 2  # both are reported at once


def test_the_ground_twice(bar):
    d = ph.Diagram()
    a = d.add(beam(bar, "a", (0.0, 0.0), (1.0, 0.0)))
    with pytest.raises(ph.errors.PortInUseError, match=r"ground\.anchor\.translation.*twice"):
        d.pin(a.start, d.ground, d.ground)


def test_one_element_cannot_be_clamped_and_free(bar):
    d = ph.Diagram()
    a = d.add(beam(bar, "a", (0.0, 0.0), (1.0, 0.0), elements=1))
    d.weld(a.start, d.ground)
    assert "give beam 'a' two elements" in refusal(d)


def test_a_velocity_imposed_on_a_giving_end(bar):
    d = ph.Diagram()
    a = d.add(beam(bar, "a", (0.0, 0.0), (1.0, 0.0), causality="free-free"))
    d.expose(a.end.translation, "drive", imposes="velocity")
    assert "a.end.translation can only give velocity, outside 'drive' gives velocity" in refusal(d)


def test_two_velocities_imposed_on_one_joint(bar):
    d = ph.Diagram()
    a = d.add(beam(bar, "a", (0.0, 0.0), (1.0, 0.0)))
    d.expose(a.end.translation, "one", imposes="velocity")
    d.expose(a.end.translation, "two", imposes="velocity")
    text = refusal(d)
    assert "outside 'one' gives velocity (expose at test_assignment.py:" in text
    assert "outside 'two' gives velocity (expose at test_assignment.py:" in text


@pytest.mark.parametrize("held_by", ["ground", "velocity"])
def test_a_force_on_what_is_held_acts_on_nothing(bar, held_by):
    d = ph.Diagram()
    a = d.add(beam(bar, "a", (0.0, 0.0), (1.0, 0.0)))
    if held_by == "ground":
        d.pin(a.start, d.ground)
    else:
        d.expose(a.start.translation, "drive", imposes="velocity")
    d.expose(a.start.translation, "load", imposes="force")
    text = refusal(d)
    assert "outside 'load' takes velocity" in text and "is held" in text


# The table


def test_the_report_prints_as_a_table(bar):
    d = ph.Diagram()
    a = d.add(beam(bar, "a", (0.0, 0.0), (1.0, 0.0)))
    d.pin(a.start, d.ground)
    d.expose(a.end.translation, "load")
    lines = str(d.check()).splitlines()
    assert lines[0].split() == ["port", "gives", "takes", "joined", "to"]
    assert set(lines[1]) == {"-"} and len(lines[1]) == max(map(len, lines[:6]))
    cells = [[cell for cell in line.split("  ") if cell] for line in lines[2:6]]
    assert [[c.strip() for c in row] for row in cells] == [
        ["a.start.translation", "force", "velocity", "ground.anchor.translation"],
        ["a.start.rotation", "angular velocity", "moment", "nothing: moment 0"],
        ["a.end.translation", "velocity", "force", "outside 'load'"],
        ["a.end.rotation", "angular velocity", "moment", "nothing: moment 0"],
    ]
    assert lines[6:] == ["switch: a switch of translation inside beam 'a'", "causal"]


def test_the_table_of_an_empty_diagram():
    assert str(ph.Diagram().check()).splitlines()[-1] == "causal"
