"""Quantities read what a solution says, at saved times only."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.studies.quantity import UNITS, distance, observe
from tests.studies import scenes


@pytest.fixture(scope="module")
def solution():
    return ph.simulate(scenes.pendulum(), t_end=0.2, dt=0.05)


@pytest.mark.parametrize("kind", UNITS)
def test_every_kind_reads_the_solution(solution, kind):
    """By the block or its name, in the middle of the beam; the run has times 0, 0.05, ..., 0.2."""
    block = solution.system.part("beam").block
    expected = getattr(solution, kind)("beam", 0.5)[[1, 4]]
    for target in (block, "beam"):
        observed = observe("test", (kind, target, 0.5), [0.05, 0.2], 0.2, "")
        np.testing.assert_array_equal(observed(solution), expected)
        assert observed.unit == UNITS[kind] and observed.label == f"{kind} of 'beam' at 0.5"


def test_default_times(solution):
    """The end for a place; the whole solution for a function."""
    assert observe("test", ("angle", "beam", 0.5), None, 0.2, "")(solution).shape == (1,)
    assert observe("test", lambda s: s.t, None, 0.2, "s")(solution).shape == (5,)
    assert observe("test", lambda s: s.t, [0.1], 0.2, "s")(solution) == pytest.approx(0.1)


def test_values_that_are_none(solution):
    for value in (np.nan, []):
        with pytest.raises(ph.errors.DataError, match="finite numbers"):
            observe("test", lambda s, value=value: value, None, 0.2, "")(solution)


def test_nothing_is_interpolated(solution):
    with pytest.raises(ph.errors.DataError, match=r"got 0.12 s, nearest 0.1 s"):
        observe("test", ("angle", "beam", 0.5), [0.05, 0.12], 0.2, "")(solution)


def test_distance():
    """Euclidean over components, largest over times."""
    a = np.zeros((2, 2))
    assert distance(a, np.array([[3.0, 4.0], [0.0, -4.5]])) == 5.0
    assert distance(np.zeros(2), np.array([1.0, -2.0])) == 2.0
