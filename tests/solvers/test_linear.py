"""Factorisation and solution on a fixed pattern, against dense linear algebra."""

import numpy as np
import pytest
import scipy.sparse as sp

from phblocks.solvers.linear import WIDEST_BAND, BandedSolver, SparseSolver, linear_solver


def pattern(n: int, width: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """An unsymmetric pattern within a band, sorted by rows, the diagonal included."""
    rows, columns = np.indices((n, n)).reshape(2, -1)
    keep = np.abs(rows - columns) <= width
    rows, columns = rows[keep], columns[keep]
    some = (rows == columns) | (np.random.default_rng(seed).random(rows.size) < 0.6)
    some |= (rows == 0) & (columns == min(width, n - 1))  # the band is as wide as it says
    return rows[some], columns[some]


def values(rows: np.ndarray, columns: np.ndarray, seed: int) -> np.ndarray:
    data = np.random.default_rng(seed).standard_normal(rows.size)
    data[rows == columns] += 0.1  # not dominant: pivots are needed
    return data


@pytest.mark.parametrize("kind", [BandedSolver, SparseSolver])
@pytest.mark.parametrize(("n", "width"), [(1, 0), (6, 1), (30, 4), (30, 29), (200, 9)])
def test_solutions(kind, n, width):
    rows, columns = pattern(n, width)
    solver = kind(rows, columns, n)
    for seed in range(3):  # the same arrays serve again and again
        data = values(rows, columns, seed)
        matrix = sp.coo_array((data, (rows, columns)), shape=(n, n)).toarray()
        assert solver.factorise(data) is True
        b = np.random.default_rng(seed + 10).standard_normal(n)
        for right in (b, 2.0 * b):  # one factor, two right-hand sides
            given = right.copy()
            np.testing.assert_allclose(matrix @ solver.solve(right), right, atol=1e-8 * np.linalg.cond(matrix) ** 0.5)
            np.testing.assert_array_equal(right, given)


@pytest.mark.parametrize("kind", [BandedSolver, SparseSolver])
def test_values_are_not_touched(kind):
    rows, columns = pattern(20, 3)
    data = values(rows, columns, 0)
    given = data.copy()
    kind(rows, columns, 20).factorise(data)
    np.testing.assert_array_equal(data, given)


@pytest.mark.parametrize("kind", [BandedSolver, SparseSolver])
def test_a_singular_matrix_has_no_factor(kind):
    rows, columns = pattern(12, 2)
    data = values(rows, columns, 0)
    solver = kind(rows, columns, 12)
    assert solver.factorise(np.where(columns == 5, 0.0, data)) is False
    assert solver.factorise(data) is True  # and the next one is not spoilt


def test_the_band_decides():
    n = WIDEST_BAND + 20
    ends = np.arange(n)
    for width, kind in ((1, BandedSolver), (WIDEST_BAND, BandedSolver), (WIDEST_BAND + 1, SparseSolver)):
        rows, columns = np.append(ends, 0), np.append(ends, width)
        order = np.lexsort((columns, rows))
        assert type(linear_solver(rows[order], columns[order], n)) is kind


def test_a_diagonal_matrix_is_banded():
    i = np.arange(5)
    solver = linear_solver(i, i, 5)
    assert isinstance(solver, BandedSolver) and solver.factorise(2.0 * np.ones(5))
    np.testing.assert_allclose(solver.solve(np.arange(5.0)), np.arange(5.0) / 2.0)
