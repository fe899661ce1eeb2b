"""Rotations in the plane as linear combinations of features, and angles that are linear in the rotation states."""

import numpy as np
import pytest

from phblocks.frames import NO_TURN, QUARTER, Turn


@pytest.mark.parametrize("angle", [0.0, 0.7, -2.0, 9.0])
def test_the_matrix_turns_by_the_reference_angle(angle):
    matrix = Turn((), (), angle).matrix()
    np.testing.assert_allclose(matrix @ [1.0, 0.0], [np.cos(angle), np.sin(angle)], atol=1e-15)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(2), atol=1e-15)
    assert np.linalg.det(matrix) == pytest.approx(1.0)


def test_a_quarter_turn_is_the_derivative_at_the_identity():
    h = 1e-6
    slope = (Turn((), (), h).matrix() - Turn((), (), -h).matrix()) / (2 * h)
    np.testing.assert_allclose(slope, QUARTER, atol=1e-10)


def test_differences_drop_what_cancels():
    a = Turn((2, 5), (1.0, 0.5), 0.3)
    b = Turn((1, 5), (2.0, 0.5), 0.1)
    difference = a.minus(b)
    assert difference.places == (1, 2) and difference.weights == (-2.0, 1.0)
    assert difference.reference == pytest.approx(0.2)
    assert not difference.fixed


def test_ends_that_turn_together_keep_their_angle():
    a = Turn((3,), (1.0,), 0.5)
    difference = a.minus(a.shifted(-0.2))
    assert difference.fixed and difference.reference == pytest.approx(0.2)
    assert NO_TURN.fixed and a.minus(NO_TURN) == a
