"""Rotations in the plane as linear combinations of features, and angles that are linear in the rotation states."""

import numpy as np
import pytest

from phblocks.frames import AT_REST, NO_TURN, QUARTER, Attitude, Turn, rotate, standing
from phblocks.space import PLANAR, SPATIAL


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


def about(axis, angle):
    """A rotation about one of the axes."""
    matrix = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[[i, j], [i, j]] = np.cos(angle)
    matrix[j, i] = np.sin(angle)
    matrix[i, j] = -np.sin(angle)
    return matrix


def test_vectors_of_three_components_turn_about_the_third_axis():
    angle, vectors = np.array([0.0, 0.4, -2.0]), np.random.default_rng(0).standard_normal((3, 3))
    expected = np.stack([about(2, a) @ v for a, v in zip(angle, vectors, strict=True)])
    np.testing.assert_allclose(rotate(angle, vectors), expected, atol=1e-15)
    np.testing.assert_array_equal(rotate(np.zeros(3), vectors), vectors)
    assert rotate(angle, vectors[0]).shape == (3, 3)


def test_frames_that_turn_with_the_same_keep_their_rotation():
    a, b = Attitude(about(0, 0.3), "W"), Attitude(about(0, 0.3) @ about(2, 0.5), "W")
    assert not a.fixed and not b.fixed
    relative = b.minus(a)
    assert relative.fixed and not relative.none
    np.testing.assert_allclose(relative.matrix(), about(2, 0.5), atol=1e-15)
    assert a.minus(Attitude(about(0, 0.3), "W")).none  # round-off is no rotation
    quarter = Attitude(about(1, 0.5 * np.pi) @ about(2, 0.3), "W").minus(Attitude(about(2, 0.3), "W"))
    assert Attitude(about(1, 0.5 * np.pi)).minus(AT_REST).matrix()[0, 0] == 0.0  # nor is a quarter turn nearly one
    assert not quarter.none


def test_frames_that_turn_with_something_else_do_not():
    assert not Attitude(np.eye(3), "W").minus(Attitude(np.eye(3), "another")).fixed
    assert not Attitude(np.eye(3), "W").minus(AT_REST).fixed
    assert Attitude(about(1, 0.2)).minus(AT_REST).fixed


def test_the_fixed_frame_of_a_space():
    assert standing(PLANAR) is NO_TURN and standing(SPATIAL) is AT_REST
