"""The pair CG_k, DG_{k-1} on the reference element."""

import numpy as np
import pytest
from numpy.polynomial import Legendre, Polynomial

from phblocks.blocks.beam.spaces import continuous, discontinuous, gauss

POINTS = np.linspace(0.0, 1.0, 9)
DEGREES = [1, 2, 3, 4, 7, 12]


@pytest.mark.parametrize("n", [1, 2, 3, 6, 12])
def test_gauss_is_exact_up_to_degree_2n_minus_1(n):
    points, weights = gauss(n)
    assert points.shape == weights.shape == (n,)
    assert (weights > 0.0).all() and ((points > 0.0) & (points < 1.0)).all()
    powers = np.arange(2 * n)
    np.testing.assert_allclose(weights @ points[:, None] ** powers, 1.0 / (powers + 1.0), rtol=1e-13)
    assert abs(weights @ points ** (2 * n) - 1.0 / (2 * n + 1)) > 1e-16  # and not one degree further


@pytest.mark.parametrize("degree", DEGREES)
def test_nodes(degree):
    nodes = continuous(degree).nodes
    assert len(nodes) == degree + 1 and (nodes[0], nodes[-1]) == (0.0, 1.0)
    assert (np.diff(nodes) > 0.0).all()
    slopes = Legendre.basis(degree, domain=[0, 1]).deriv()(np.array(nodes[1:-1]))
    np.testing.assert_allclose(slopes, 0.0, atol=1e-11 * degree**3)  # Gauss-Lobatto: extrema of the Legendre polynomial
    np.testing.assert_array_equal(discontinuous(degree).nodes, gauss(degree)[0])


@pytest.mark.parametrize("degree", DEGREES)
@pytest.mark.parametrize("space", [continuous, discontinuous])
def test_functions_are_one_at_their_node_and_zero_at_the_others(space, degree):
    basis = space(degree)
    np.testing.assert_allclose(basis.at(np.array(basis.nodes)), np.eye(basis.size), atol=1e-12)
    np.testing.assert_allclose(basis.at(POINTS).sum(axis=1), 1.0, rtol=1e-12)


@pytest.mark.parametrize("degree", DEGREES)
@pytest.mark.parametrize("space", [continuous, discontinuous])
def test_polynomials_of_their_degree_and_their_derivatives_are_exact(space, degree):
    basis = space(degree)
    p = Polynomial(np.random.default_rng(degree).standard_normal(basis.size))
    values = p(np.array(basis.nodes))
    np.testing.assert_allclose(basis.at(POINTS) @ values, p(POINTS), atol=1e-11)
    np.testing.assert_allclose(basis.derivative(POINTS) @ values, p.deriv()(POINTS) + 0.0 * POINTS, atol=1e-9)


@pytest.mark.parametrize("degree", DEGREES)
def test_the_derivative_maps_the_first_space_exactly_onto_the_second(degree):
    first, second = continuous(degree), discontinuous(degree)
    d = first.derivative(np.array(second.nodes))  # of CG_k, in the coordinates of DG_{k-1}
    np.testing.assert_allclose(second.at(POINTS) @ d, first.derivative(POINTS), atol=1e-9)
    assert np.linalg.matrix_rank(d) == degree  # onto
    np.testing.assert_allclose(d @ np.ones(degree + 1), 0.0, atol=1e-10)  # and only constants are lost


def test_one_point_is_enough_for_values_at_it():
    assert continuous(2).at(np.array([0.5])).shape == (1, 3)
    np.testing.assert_allclose(continuous(2).at(np.array([0.5]))[0], [0.0, 1.0, 0.0], atol=1e-15)
