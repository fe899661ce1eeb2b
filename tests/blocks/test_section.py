"""Stiffness and inertia of cross sections, and what is refused."""

import math

import numpy as np
import pytest

import phblocks as ph
from phblocks import Section
from phblocks.blocks.beam.section import require_positive, require_real
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.space import PLANAR, SPATIAL

GOOD = {"axial": 2.0, "shear": 3.0, "bending": 4.0, "mass": 5.0, "rotary": 6.0}
INERT = ("mass", "rotary", "polar")
MATERIAL = {"young": 2.1e11, "poisson": 0.3, "density": 7800.0}
G = 2.1e11 / 2.6


def test_a_rectangle():
    s = Section.rectangle(width=0.02, height=0.05, **MATERIAL)  # bends in the plane about its strong axis
    assert s.axial == pytest.approx(2.1e11 * 1e-3)
    assert s.mass == pytest.approx(7.8)
    assert s.shear == pytest.approx(5.0 / 6.0 * G * 1e-3)
    about_2, about_3 = 0.05 * 0.02**3 / 12, 0.02 * 0.05**3 / 12
    np.testing.assert_allclose(s.bending, [2.1e11 * about_2, 2.1e11 * about_3], rtol=1e-14)
    np.testing.assert_allclose(s.rotary, [7800 * about_2, 7800 * about_3], rtol=1e-14)
    assert s.coefficients(PLANAR)[11] == pytest.approx(1.0 / (2.1e11 * about_3))


def test_torsion_of_rectangles():
    """Square: 0.1406 a^4 (Timoshenko and Goodier); a thin strip: b t^3 / 3; turned by a right angle: the same."""
    square = Section.rectangle(width=0.1, height=0.1, **MATERIAL)
    assert square.torsion == pytest.approx(0.1406 * 0.1**4 * G, rel=3e-3)
    strip = Section.rectangle(width=1.0, height=1e-3, **MATERIAL)
    assert strip.torsion == pytest.approx(1e-9 / 3.0 * G, rel=1e-3)
    assert Section.rectangle(width=1e-3, height=1.0, **MATERIAL).torsion == strip.torsion


def test_a_circle_and_a_tube():
    s = Section.circle(radius=0.03, **MATERIAL)
    area, second = math.pi * 9e-4, math.pi * 0.03**4 / 4
    assert (s.axial, s.mass) == (pytest.approx(2.1e11 * area), pytest.approx(7800 * area))
    assert s.shear == pytest.approx(6.0 / 7.0 * G * area)
    np.testing.assert_allclose(s.bending, [2.1e11 * second] * 2, rtol=1e-14)
    assert s.torsion == pytest.approx(2.0 * G * second)
    t = Section.tube(radius=0.03, thickness=0.01, **MATERIAL)
    hole = Section.circle(radius=0.02, **MATERIAL)
    for name in ("axial", "mass", "torsion"):
        assert getattr(t, name) == pytest.approx(getattr(s, name) - getattr(hole, name))
    np.testing.assert_allclose(t.bending, np.subtract(s.bending, hole.bending), rtol=1e-14)
    assert t.shear == pytest.approx(0.5 * G * math.pi * 5e-4)


def test_coefficients_are_inertias_and_compliances():
    pairs = GOOD | {"shear": (3.0, 30.0), "bending": (4.0, 40.0), "rotary": (6.0, 60.0), "torsion": 8.0}
    expected = [5.0, 5.0, 5.0, 66.0, 6.0, 60.0, 1 / 2, 1 / 3, 1 / 30, 1 / 8, 1 / 4, 1 / 40]
    np.testing.assert_allclose(Section(**pairs).coefficients(SPATIAL), expected, rtol=1e-15)
    assert Section(**pairs, polar=7.0).coefficients(SPATIAL)[3] == 7.0
    planar = Section(**GOOD).coefficients(PLANAR)  # one number serves both directions, torsion is not needed
    np.testing.assert_allclose(planar[[0, 1, 5, 6, 7, 11]], [5.0, 5.0, 6.0, 1 / 2, 1 / 3, 1 / 4], rtol=1e-15)


def test_a_spatial_beam_needs_torsion():
    with pytest.raises(DataError, match=r"Section torsion.*GJ for a spatial beam"):
        Section(**GOOD).coefficients(SPATIAL)


@pytest.mark.parametrize("name", [*GOOD, "torsion", "polar"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, -math.inf, 5e-324, np.float64(-2.0)])
def test_values_that_are_not_positive(name, value):
    expected = "a finite number > 0" if name in INERT else "a number > 0, or math.inf"
    with pytest.raises(DataError, match=rf"Section {name}: expected {expected}, got .*SI units"):
        Section(**(GOOD | {name: value}))


@pytest.mark.parametrize("name", INERT)
def test_inertias_are_finite(name):
    with pytest.raises(DataError, match=rf"Section {name}: expected a finite number > 0, got inf"):
        Section(**(GOOD | {name: math.inf}))


def test_an_infinite_stiffness_is_a_compliance_of_zero():
    section = Section(**(GOOD | {"axial": math.inf, "shear": (math.inf, 3.0), "torsion": math.inf}))
    assert section.coefficients(SPATIAL).tolist() == [5.0, 5.0, 5.0, 12.0, 6.0, 6.0, 0.0, 0.0, 1 / 3, 0.0, 1 / 4, 1 / 4]


@pytest.mark.parametrize("name", GOOD)
@pytest.mark.parametrize("value", ["1.0", None, True, 1j, {}, np.array([1.0, 2.0])])
def test_values_that_are_no_numbers(name, value):
    with pytest.raises(ArgumentTypeError, match=rf"Section {name}: expected a real number, got {type(value).__name__}"):
        Section(**(GOOD | {name: value}))


@pytest.mark.parametrize("name", ["shear", "bending", "rotary"])
@pytest.mark.parametrize(
    ("value", "error"),
    [
        ((1.0,), ArgumentTypeError),
        ((1.0, 2.0, 3.0), ArgumentTypeError),
        ([], ArgumentTypeError),
        ((1.0, -2.0), DataError),
        ((math.nan, 1.0), DataError),
        ((1.0, "2"), ArgumentTypeError),
        (((1.0, 2.0), 3.0), ArgumentTypeError),
    ],
)
def test_pairs(name, value, error):
    with pytest.raises(error, match=f"Section {name}"):
        Section(**(GOOD | {name: value}))


@pytest.mark.parametrize("name", ["axial", "mass"])
def test_where_a_pair_has_no_meaning(name):
    with pytest.raises(ArgumentTypeError, match=f"Section {name}"):
        Section(**(GOOD | {name: (1.0, 2.0)}))


SHAPES = [
    (Section.rectangle, {"width": 0.1, "height": 0.2}),
    (Section.circle, {"radius": 0.1}),
    (Section.tube, {"radius": 0.1, "thickness": 0.01}),
]


@pytest.mark.parametrize(("shape", "size"), SHAPES)
@pytest.mark.parametrize(
    ("value", "error"),
    [(0.0, DataError), (-1.0, DataError), (math.nan, DataError), ("1", ArgumentTypeError), (None, ArgumentTypeError)],
)
def test_shapes_name_the_number_at_fault(shape, size, value, error):
    for name in [*size, "young", "density", "shear_factor"]:
        with pytest.raises(error, match=f"Section {name}"):
            shape(**(size | MATERIAL | {name: value}))


@pytest.mark.parametrize(("shape", "size"), SHAPES)
def test_poisson_numbers(shape, size):
    shape(**(size | MATERIAL | {"poisson": 0.5}))
    shape(**(size | MATERIAL | {"poisson": -0.99}))
    for value in (-1.0, 0.51, math.nan, math.inf):
        with pytest.raises(DataError, match=r"Section poisson.*\(-1, 0\.5\]"):
            shape(**(size | MATERIAL | {"poisson": value}))
    for wrong in ("0.3", None, True, 1j):
        with pytest.raises(ArgumentTypeError, match="Section poisson"):
            shape(**(size | MATERIAL | {"poisson": wrong}))


@pytest.mark.parametrize("thickness", [0.1, 0.2])
def test_a_tube_needs_a_hole(thickness):
    with pytest.raises(DataError, match=r"Section thickness.*less than the radius 0\.1.*circle\(\)"):
        Section.tube(radius=0.1, thickness=thickness, **MATERIAL)


def test_numbers_of_numpy_are_numbers():
    assert require_positive("x", np.float32(2.0)) == 2.0
    assert require_positive("x", np.int64(3)) == 3.0
    assert math.isnan(require_real("x", math.nan))


def test_a_section_cannot_be_changed():
    section = Section(**GOOD)
    with pytest.raises(AttributeError):
        section.axial = -1.0


@pytest.mark.parametrize("size", [1e300, 1e-300, 10**400])
def test_dimensions_whose_fourth_power_is_no_number(size):
    """Once an OverflowError of Python, or a stiffness of zero."""
    for make in (
        lambda: ph.Section.rectangle(size, 0.1, 2.1e11, 0.3, 7850.0),
        lambda: ph.Section.rectangle(0.1, size, 2.1e11, 0.3, 7850.0),
        lambda: ph.Section.circle(size, 2.1e11, 0.3, 7850.0),
    ):
        with pytest.raises(ph.errors.DataError):
            make()


@pytest.mark.parametrize("name", ["axial", "shear", "bending"])
def test_a_stiffness_of_400_digits_is_a_slip(name):
    values = {"axial": 1e4, "shear": 1e4, "bending": 10.0, "mass": 1.0, "rotary": 1e-3} | {name: 10**400}
    with pytest.raises(
        DataError, match=rf"Section {name}: expected a number > 0, or math\.inf, got a number too large"
    ):
        ph.Section(**values)
