"""Orders of small bandwidth."""

import numpy as np
import pytest

from phblocks.solvers.ordering import narrow_order


def width(rows: np.ndarray, columns: np.ndarray, order: np.ndarray) -> int:
    place = np.empty_like(order)
    place[order] = np.arange(order.size)
    return int(np.abs(place[rows] - place[columns]).max(initial=0))


def edges(pairs: list[tuple[int, int]], n: int) -> tuple[np.ndarray, np.ndarray]:
    both = np.array([*pairs, *((b, a) for a, b in pairs), *((i, i) for i in range(n))])
    return both[:, 0], both[:, 1]


@pytest.mark.parametrize("seed", range(4))
def test_a_shuffled_chain_is_put_in_line_again(seed):
    n = 50
    name = np.random.default_rng(seed).permutation(n)
    rows, columns = edges([(name[i], name[i + 1]) for i in range(n - 1)], n)
    order = narrow_order(rows, columns, n)
    assert sorted(order) == list(range(n)) and width(rows, columns, order) == 1


def test_a_ring_needs_a_band_of_two():
    n = 30
    rows, columns = edges([(i, (i + 1) % n) for i in range(n)], n)
    assert width(rows, columns, narrow_order(rows, columns, n)) == 2


def test_parts_that_are_not_joined():
    rows, columns = edges([(0, 4), (4, 8), (1, 5), (5, 9)], 10)  # two chains and four single unknowns
    order = narrow_order(rows, columns, 10)
    assert sorted(order) == list(range(10)) and width(rows, columns, order) == 1


def test_one_sided_patterns_are_taken_as_two_sided():
    rows, columns = np.arange(9), np.arange(9) + 1  # entries above the diagonal only
    order = narrow_order(rows, columns, 10)
    assert sorted(order) == list(range(10)) and width(rows, columns, order) == 1


def test_the_band_of_a_four_bar_does_not_grow_with_its_elements(four_bar):
    from phblocks.solvers.stage import StageEquation

    widths = []
    for elements in ((4, 3, 3), (10, 6, 6), (40, 24, 24)):
        stage = StageEquation(four_bar(elements).compile())
        widths.append(int(np.abs(stage.rows - stage.columns).max()))
    assert max(widths) <= 20 and widths[2] <= widths[1] + 2
