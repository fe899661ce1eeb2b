"""The reference element against the strong equations, evaluated independently by quadrature."""

import itertools

import numpy as np
import pytest

from phblocks.blocks.beam.spaces import gauss
from phblocks.blocks.beam.tensors import (
    FIELDS,
    ReferenceElement,
    Variant,
    component_index,
    field_basis,
    present_components,
    reference_element,
)
from phblocks.space import PLANAR, SPATIAL

DEGREES = [1, 2, 3, 4]
VARIANTS = [Variant(*choice) for choice in itertools.product([True, False], repeat=2)]
SPACES = [PLANAR, SPATIAL]
H = 0.7  # length of the element

every_degree = pytest.mark.parametrize("degree", DEGREES)
every_variant = pytest.mark.parametrize(
    "variant", VARIANTS, ids=lambda v: f"V{'CD'[not v.velocity]}W{'CD'[not v.spin]}"
)
every_space = pytest.mark.parametrize("space", SPACES, ids=lambda s: s.name)


def matrices(element: ReferenceElement, c: np.ndarray, offset: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """E, J0, T as dense arrays, by the formula in the module's first lines."""
    n = element.size
    E = H * element.mass.scaled(c[element.mass_coefficient]).coo((n, n)).toarray()
    J0 = element.slope.coo((n, n)).toarray()
    J0 = J0 + H * element.product.scaled(offset[element.product_offset]).coo((n, n)).toarray()
    T = H * element.cubic.scaled(c[element.cubic_coefficient]).coo((n, n, n)).toarray()
    return E, J0, T


def data() -> tuple[np.ndarray, np.ndarray]:
    """Coefficients and offsets, all different, so that no term hides behind another."""
    rng = np.random.default_rng(7)
    offset = np.zeros(12)
    offset[6:] = rng.uniform(0.5, 1.5, 6)
    return rng.uniform(0.5, 1.5, 12), offset


def weak_form(
    degree: int, variant: Variant, space, x: np.ndarray, c: np.ndarray, offset: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(phi, E x) and the right-hand sides of the four strong equations tested with every basis function.

    The side of a pair that is continuous has its own derivative moved to the test function; end terms left out.
    """
    element = reference_element(degree, variant, space)
    points, weights = gauss(3 * degree + 4)
    weights = H * weights
    fields = {f: np.zeros((3, points.size)) for f in FIELDS}
    slopes = {f: np.zeros((3, points.size)) for f in FIELDS}
    for (f, d), first in zip(element.components, element.first, strict=True):
        basis = field_basis(variant, f, degree)
        own = x[first : first + basis.size]
        fields[f][d] = basis.at(points) @ own
        slopes[f][d] = basis.derivative(points) @ own / H

    def scaled(f: str, values: np.ndarray) -> np.ndarray:
        return c[component_index(f, 0) : component_index(f, 0) + 3, None] * values

    def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.cross(a, b, axis=0)

    V, W, N, M = (fields[f] for f in FIELDS)
    strain = offset[6:9, None] + scaled("N", N)  # e1 + Gamma
    K = offset[9:12, None] + scaled("M", M)
    p, L = scaled("V", V), scaled("W", W)
    algebraic = {
        "V": cross(K, N) + cross(p, W),
        "W": cross(K, M) + cross(strain, N) + cross(p, V) + cross(L, W),
        "N": cross(K, V) + cross(strain, W),
        "M": cross(K, W),
    }
    partner = {"V": "N", "N": "V", "W": "M", "M": "W"}
    rate, mass = np.zeros(element.size), np.zeros(element.size)
    for (f, d), first in zip(element.components, element.first, strict=True):
        basis = field_basis(variant, f, degree)
        psi, dpsi = basis.at(points), basis.derivative(points) / H
        if variant.is_continuous(f):  # tested by parts
            derivative = -(dpsi.T @ (weights * fields[partner[f]][d]))
        else:
            derivative = psi.T @ (weights * slopes[partner[f]][d])
        rate[first : first + basis.size] = derivative + psi.T @ (weights * algebraic[f][d])
        mass[first : first + basis.size] = psi.T @ (weights * scaled(f, fields[f])[d])
    return mass, rate


@every_degree
@every_variant
@every_space
def test_matrices_are_the_weak_form_of_the_strong_equations(space, variant, degree):
    c, offset = data()
    E, J0, T = matrices(reference_element(degree, variant, space), c, offset)
    for seed in range(3):
        x = np.random.default_rng(seed).standard_normal(len(E))
        mass, rate = weak_form(degree, variant, space, x, c, offset)
        np.testing.assert_allclose(E @ x, mass, atol=1e-13)
        np.testing.assert_allclose((J0 + T @ x) @ x, rate, atol=3e-13)
    assert np.abs(T).max() > 0.01 and np.abs(J0).max() > 0.1


@every_degree
@every_variant
@every_space
def test_skew_to_the_last_bit(space, variant, degree):
    element, n = reference_element(degree, variant, space), reference_element(degree, variant, space).size
    slope = element.slope.coo((n, n)).toarray()
    assert np.array_equal(slope, -slope.T)
    for component in range(12):
        here = (element.product_offset == component).astype(float)
        product = element.product.scaled(here).coo((n, n)).toarray()
        assert np.array_equal(product, -product.T)
    cubic = element.cubic.coo((n, n, n)).toarray()
    assert np.array_equal(cubic, -np.swapaxes(cubic, 0, 1))
    c, offset = data()
    _, J0, T = matrices(element, c, offset)
    assert np.array_equal(J0, -J0.T) and np.array_equal(T, -np.swapaxes(T, 0, 1))


@every_degree
@every_variant
def test_the_planar_element_is_a_slice_of_the_spatial_one(variant, degree):
    c, offset = data()
    planar, spatial = reference_element(degree, variant, PLANAR), reference_element(degree, variant, SPATIAL)
    offset[[7, 8, 9, 10]] = 0.0  # planar: e1 along 1, curvature about 3
    inside = np.concatenate(
        [
            spatial.first[spatial.components.index(component)]
            + np.arange(field_basis(variant, component[0], degree).size)
            for component in planar.components
        ]
    )
    outside = np.setdiff1d(np.arange(spatial.size), inside)
    (E, J0, T), (E3, J3, T3) = matrices(planar, c, offset), matrices(spatial, c, offset)
    x = np.random.default_rng(0).standard_normal(planar.size)
    x3 = np.zeros(spatial.size)
    x3[inside] = x
    J, J_spatial = J0 + T @ x, J3 + T3 @ x3
    np.testing.assert_array_equal(E3[np.ix_(inside, inside)], E)
    np.testing.assert_allclose(J_spatial[np.ix_(inside, inside)], J, atol=1e-15)
    np.testing.assert_array_equal(E3[np.ix_(outside, inside)], 0.0)
    np.testing.assert_allclose((J_spatial @ x3)[outside], 0.0, atol=1e-14)  # a planar motion stays in its plane


@every_degree
@every_variant
@every_space
def test_mass_is_symmetric_and_definite(space, variant, degree):
    c, offset = data()
    E = matrices(reference_element(degree, variant, space), c, offset)[0]
    assert (E == E.T).all() and np.linalg.eigvalsh(E).min() > 0.0


@every_variant
@every_space
def test_sizes(space, variant):
    for degree in DEGREES:
        element = reference_element(degree, variant, space)
        components = space.dimension + len(space.rotation)
        assert element.size == components * (2 * degree + 1)  # each pair: k + 1 in CG and k in DG
        assert element.components == present_components(space)


def test_components_are_numbered_field_by_field():
    assert [component_index(f, d) for f in FIELDS for d in range(3)] == list(range(12))
    assert present_components(PLANAR) == (("V", 0), ("V", 1), ("W", 2), ("N", 0), ("N", 1), ("M", 2))


def test_one_side_of_each_pair_is_continuous():
    for variant in VARIANTS:
        assert variant.is_continuous("V") != variant.is_continuous("N")
        assert variant.is_continuous("W") != variant.is_continuous("M")
        assert (variant.is_continuous("V"), variant.is_continuous("W")) == (variant.velocity, variant.spin)
