"""Lists of entries against dense arrays."""

import numpy as np
import pytest

from phblocks.triplets import Triplets, real_array


def dense(entries: Triplets, shape: tuple[int, ...]) -> np.ndarray:
    """Add up the entries one by one."""
    array = np.zeros(shape)
    for *place, value in zip(*entries.indices, entries.values, strict=True):
        array[tuple(place)] += value
    return array


@pytest.fixture
def entries() -> Triplets:
    rng = np.random.default_rng(1)
    return Triplets.of(rng.integers(0, 4, 12), rng.integers(0, 4, 12), values=rng.standard_normal(12))


@pytest.fixture
def cube() -> Triplets:
    rng = np.random.default_rng(2)
    return Triplets.of(*rng.integers(0, 3, (3, 15)), values=rng.standard_normal(15))


def test_indices_and_values_are_broadcast_and_flattened():
    entries = Triplets.of(np.arange(2)[:, None], np.arange(3), values=2.0)
    assert [i.tolist() for i in entries.indices] == [[0, 0, 0, 1, 1, 1], [0, 1, 2, 0, 1, 2]]
    assert entries.values.tolist() == [2.0] * 6
    assert entries.indices[0].dtype == np.int64 and entries.values.dtype == np.float64


def test_conversion_adds_up_what_is_at_the_same_place(entries, cube):
    assert len(set(zip(*entries.indices, strict=True))) < entries.values.size  # there are duplicates
    np.testing.assert_allclose(entries.csr((4, 4)).toarray(), dense(entries, (4, 4)), atol=1e-15)
    np.testing.assert_allclose(cube.coo((3, 3, 3)).toarray(), dense(cube, (3, 3, 3)), atol=1e-15)
    csr = entries.csr((4, 4))
    assert csr.nnz == len(set(zip(*entries.indices, strict=True)))
    assert csr.has_sorted_indices


def test_moving_scaling_and_joining(entries):
    moved = entries.shifted(1, 2)
    np.testing.assert_array_equal(dense(moved, (5, 6))[1:, 2:], dense(entries, (4, 4)))
    np.testing.assert_allclose(dense(entries.scaled(3.0), (4, 4)), 3.0 * dense(entries, (4, 4)), atol=1e-15)
    each = np.arange(12.0)
    np.testing.assert_array_equal(entries.scaled(each).values, each * entries.values)
    both = Triplets.join([entries, Triplets.empty(), entries.transposed])
    np.testing.assert_allclose(dense(both, (4, 4)), dense(entries, (4, 4)) + dense(entries, (4, 4)).T, atol=1e-15)


def test_moving_needs_an_offset_for_each_axis(entries):
    with pytest.raises(ValueError, match=r"zip\(\)"):
        entries.shifted(1)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_joining_nothing_keeps_the_order(order):
    nothing = Triplets.join([], order=order)
    assert len(nothing.indices) == order and nothing.values.size == 0


def test_entries_and_their_mirror_images_are_skew(entries, cube):
    matrix, tensor = dense(entries, (4, 4)), dense(cube, (3, 3, 3))
    np.testing.assert_allclose(dense(entries.skew, (4, 4)), matrix - matrix.T, atol=1e-15)
    np.testing.assert_allclose(dense(cube.skew, (3, 3, 3)), tensor - np.swapaxes(tensor, 0, 1), atol=1e-15)
    assert np.abs(matrix - matrix.T).max() > 0.1


def test_where_no_two_meet_they_are_skew_to_the_last_bit():
    i, j = np.triu_indices(5, 1)
    values = np.random.default_rng(3).standard_normal(i.size)
    matrix = Triplets.of(i, j, values=values).skew.csr((5, 5)).toarray()
    assert (matrix == -matrix.T).all()
    assert (matrix[i, j] == values).all()


@pytest.mark.parametrize("value", [1, 2.5, np.float32(2.5), [1, 2], (1.0, 2.0), np.arange(3), [[1, 2], [3, 4]], []])
def test_real_numbers_become_an_array(value):
    array = real_array(value)
    assert array is not None and array.dtype == np.float64
    np.testing.assert_array_equal(array, np.asarray(value, dtype=float))


@pytest.mark.parametrize(
    "value", ["1", ("1", "2"), None, (None, 1.0), True, [True, False], 1j, [[1], [2, 3]], {}, object()]
)
def test_anything_else_does_not(value):
    assert real_array(value) is None


def test_the_array_is_a_copy():
    given = np.zeros(2)
    array = real_array(given)
    assert array is not None
    array[0] = 1.0
    assert given[0] == 0.0
