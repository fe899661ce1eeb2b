"""The beam as a block: geometry, element boundaries, what its ends can do, and what is refused."""

import itertools
import math

import numpy as np
import pytest

import phblocks as ph
from phblocks import Beam, Section
from phblocks.blocks.beam.ends import ENDS
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.space import PLANAR

SECTION = Section(axial=900.0, shear=300.0, bending=7.0, mass=1.3, rotary=0.2)


def make(**options) -> Beam:
    arguments = {"name": "b", "section": SECTION, "start": (1.0, 2.0), "end": (4.0, 6.0), "elements": 4}
    return Beam(**(arguments | options))


def test_a_straight_beam():
    beam = make()
    assert (beam.length, beam.curvature, beam.elements, beam.degree) == (5.0, 0.0, 4, 1)
    np.testing.assert_allclose(beam.boundaries, [0.0, 1.25, 2.5, 3.75, 5.0], rtol=1e-15)
    assert beam.start.angle == beam.end.angle == pytest.approx(math.atan2(4.0, 3.0))
    np.testing.assert_array_equal(beam.start.position, [1.0, 2.0])
    np.testing.assert_array_equal(beam.end.position, [4.0, 6.0])
    assert (beam.start.place, beam.end.place) == (0.0, 1.0)
    assert beam.space is PLANAR and repr(beam) == "<Beam 'b'>"
    assert beam.anchors == {"start": beam.start, "end": beam.end}


def test_a_half_circle_bends_to_the_left():
    """From (0, 0) to (2, 0) with curvature 1: through (1, -1), leaving downwards, arriving upwards."""
    beam = make(start=(0.0, 0.0), end=(2.0, 0.0), curvature=1.0)
    assert beam.length == pytest.approx(math.pi)
    assert beam.start.angle == pytest.approx(-math.pi / 2)
    assert beam.end.angle == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("angle", [0.0, 1.0, -2.5, math.pi])
@pytest.mark.parametrize("curvature", [0.3, -0.3, 1e-8])
def test_an_arc_at_any_angle(angle, curvature):
    beam = make(start=(0.0, 0.0), end=(3.0 * math.cos(angle), 3.0 * math.sin(angle)), curvature=curvature)
    half = math.asin(1.5 * curvature)
    assert beam.length == pytest.approx(2.0 * half / curvature)
    assert math.remainder(beam.start.angle - (angle - half), 2 * math.pi) == pytest.approx(0.0, abs=1e-12)
    assert beam.end.angle - beam.start.angle == pytest.approx(2.0 * half)


def test_element_boundaries():
    beam = make(elements=(0.0, 0.2, 0.7, 1.0))
    np.testing.assert_allclose(beam.boundaries, [0.0, 1.0, 3.5, 5.0], rtol=1e-15)
    assert beam.elements == 3
    assert make(elements=np.int64(3)).elements == 3
    assert make(elements=[0, 1]).elements == 1
    assert make(elements=np.linspace(0.0, 1.0, 6)).elements == 5


@pytest.mark.parametrize(
    ("elements", "switch_at", "expected"),
    [
        (4, 0.5, 2),
        (4, 0.01, 1),
        (4, 0.99, 3),
        (2, 0.9, 1),
        ((0, 0.2, 0.7, 1), 0.5, 2),
        ((0, 0.2, 0.7, 1), 0.4, 1),
        (1, 0.5, 0),
    ],
)
def test_the_switch_is_at_the_nearest_inner_boundary(elements, switch_at, expected):
    assert make(elements=elements, switch_at=switch_at).switch_element == expected


def test_a_switch_moves_the_segments():
    beam = make(elements=6, causality="clamped-free", switch_at=0.3)
    segments = beam.mesh(*beam.ends).segments
    assert [(s.first, s.last) for s in segments] == [(0, 2), (2, 6)]
    assert [tuple(vars(s.variant).values()) for s in segments] == [(False, False), (True, True)]
    assert len(beam.mesh(ENDS["free"], ENDS["free"]).segments) == 1


@pytest.mark.parametrize(("start", "end"), list(itertools.product(ENDS, repeat=2)))
def test_fixed_causality_leaves_no_choice(start, end):
    beam = make(causality=(start, end))
    choices, ties = beam.choices()
    expected = dict(zip(beam.ports, (*ENDS[start], *ENDS[end]), strict=True))
    assert {c.port.name: (c.may_give, c.may_take) for c in choices} == {n: (g, not g) for n, g in expected.items()}
    assert [t.cost for t in ties] == [1.0, 1.0]
    assert beam.end_names(expected) == f"{start}-{end}"


def test_auto_leaves_every_choice_and_prefers_equal_ends():
    beam = make()
    choices, ties = beam.choices()
    assert all(c.may_give and c.may_take for c in choices) and len(choices) == 4
    assert [(t.first.name, t.second.name, t.cost) for t in ties] == [
        ("start.translation", "end.translation", 1.0),
        ("start.rotation", "end.rotation", 1.0),
    ]
    assert "translation inside beam 'b'" in ties[0].what
    assert [t.cost for t in make(elements=1).choices()[1]] == [None, None]  # no boundary to switch at


def test_points():
    beam = make()
    assert (beam.at(0.25).block, beam.at(1).place, beam.at(np.float64(0.5)).place) == (beam, 1.0, 0.5)
    for s in (-1e-9, 1.1, math.nan, "0.5", None, True):
        with pytest.raises(DataError, match=r"point on beam 'b'.*from 0 to 1"):
            beam.at(s)


# Bad input


@pytest.mark.parametrize("name", ["", "a.b", "."])
def test_names(name):
    with pytest.raises(DataError, match="non-empty text without dots"):
        make(name=name)


@pytest.mark.parametrize("name", [None, 1, True, ["b"]])
def test_names_that_are_no_text(name):
    with pytest.raises(ArgumentTypeError, match=r"name of a block.*a text"):
        make(name=name)


@pytest.mark.parametrize("section", [None, 1.0, "steel", Section, {"axial": 1.0}])
def test_something_else_than_a_section(section):
    with pytest.raises(ArgumentTypeError, match=r"Beam 'b' section.*ph\.Section"):
        make(section=section)


def test_zero_length():
    with pytest.raises(DataError, match=r"Beam 'b' length.*finite number > 0, got 0\.0"):
        make(end=(1.0, 2.0))


@pytest.mark.parametrize("where", ["start", "end"])
@pytest.mark.parametrize(
    ("value", "error", "expected"),
    [
        ((1.0, 2.0, math.nan), DataError, "finite coordinates"),
        ((1.0,), DataError, "two finite coordinates"),
        ((math.nan, 0.0), DataError, "two finite coordinates"),
        ((0.0, -math.inf), DataError, "two finite coordinates"),
        (((0.0, 0.0),), DataError, "two finite coordinates"),
        (5.0, DataError, "two finite coordinates"),
        ("ab", ArgumentTypeError, "coordinates"),
        (("1", "2"), ArgumentTypeError, "coordinates"),
        (None, ArgumentTypeError, "coordinates"),
        ((None, 1.0), ArgumentTypeError, "coordinates"),
        ((1.0, (2.0, 3.0)), ArgumentTypeError, "coordinates"),
        ((1j, 0.0), ArgumentTypeError, "coordinates"),
        ((True, False), ArgumentTypeError, "coordinates"),
    ],
)
def test_coordinates(where, value, error, expected):
    with pytest.raises(error, match=f"Beam 'b' {where}.*{expected}"):
        make(**{where: value})


@pytest.mark.parametrize(
    ("value", "error", "expected"),
    [
        (0, DataError, "at least 1"),
        (-3, DataError, "at least 1"),
        ((0.0, 0.7, 0.2, 1.0), DataError, "rise from 0 to 1"),
        ((0.0, 0.5, 0.5, 1.0), DataError, "rise from 0 to 1"),
        ((0.0, 0.5), DataError, "rise from 0 to 1"),
        ((0.1, 1.0), DataError, "rise from 0 to 1"),
        ((0.0,), DataError, "rise from 0 to 1"),
        ((), DataError, "rise from 0 to 1"),
        ((0.0, math.nan, 1.0), DataError, "rise from 0 to 1"),
        (((0.0, 1.0),), DataError, "rise from 0 to 1"),
        (2.0, ArgumentTypeError, "whole number or a sequence"),
        (True, ArgumentTypeError, "whole number or a sequence"),
        (None, ArgumentTypeError, "whole number or a sequence"),
        ("4", ArgumentTypeError, "whole number or a sequence"),
        (("0", "1"), ArgumentTypeError, "whole number or a sequence"),
        ((0.0, None, 1.0), ArgumentTypeError, "whole number or a sequence"),
    ],
)
def test_elements(value, error, expected):
    with pytest.raises(error, match=f"Beam 'b' elements.*{expected}"):
        make(elements=value)


@pytest.mark.parametrize(
    ("value", "error"),
    [
        *((value, DataError) for value in (0, -1, 13)),
        *((value, ArgumentTypeError) for value in (1.0, "2", None, True)),
    ],
)
def test_degree(value, error):
    with pytest.raises(error, match=r"Beam 'b' degree.*Use 1, 2 or 3"):
        make(degree=value)


@pytest.mark.parametrize(
    ("value", "error", "expected"),
    [
        (0.41, DataError, r"at most 2/chord = 0\.4 1/m"),
        (-0.41, DataError, r"at most 2/chord"),
        (math.nan, DataError, r"at most 2/chord"),
        (math.inf, DataError, r"at most 2/chord"),
        ("0.1", ArgumentTypeError, "a real number"),
        (True, ArgumentTypeError, "a real number"),
        ([0.1], ArgumentTypeError, "a real number"),
    ],
)
def test_curvature(value, error, expected):
    with pytest.raises(error, match=f"Beam 'b' curvature.*{expected}"):
        make(curvature=value)


@pytest.mark.parametrize("value", [0.0, 1.0, -0.1, 1.5, math.nan])
def test_switch_outside_the_beam(value):
    with pytest.raises(DataError, match=r"Beam 'b' switch_at.*between 0 and 1"):
        make(switch_at=value)


@pytest.mark.parametrize("value", ["0.5", None, True, [0.5]])
def test_switch_at_no_number(value):
    with pytest.raises(ArgumentTypeError, match="Beam 'b' switch_at"):
        make(switch_at=value)


@pytest.mark.parametrize(
    ("value", "error"),
    [("clamped", DataError), ("welded-free", DataError), (None, ArgumentTypeError), (3, ArgumentTypeError)],
)
def test_causality(value, error):
    with pytest.raises(error, match="Beam 'b' causality"):
        make(causality=value)


def test_one_element_cannot_switch():
    assert make(elements=1, causality="pinned-pinned").elements == 1
    with pytest.raises(DataError, match=r"Beam 'b' causality.*equal ends for a beam of one element.*at least two"):
        make(elements=1, causality="pinned-free")


def test_more_elements_than_memory_are_refused():
    section = ph.Section(axial=1.0, shear=1.0, bending=1.0, mass=1.0, rotary=1.0)
    with pytest.raises(ph.errors.DataError, match="at most"):
        ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.0), elements=10**12)


def test_causality_of_another_kind():
    section = ph.Section(axial=1.0, shear=1.0, bending=1.0, mass=1.0, rotary=1.0)
    with pytest.raises(ph.errors.ArgumentTypeError):
        ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.0), elements=2, causality=np.array([1.0, 2.0]))
