"""Where a beam is at first: its axes in space, its arc, its element boundaries."""

import numpy as np
import pytest

from phblocks.blocks.beam.placement import Placement
from phblocks.errors import ArgumentTypeError, DataError, SpaceError
from phblocks.space import PLANAR, SPATIAL

O = (0.0, 0.0, 0.0)


def axes(end, normal=None):
    placement = Placement.of("b", O, end, None, normal)
    assert placement.axes is not None
    return placement.axes


def test_axes_of_a_beam_in_the_plane_of_x_and_y_are_those_of_the_planar_one():
    for angle in (0.0, 0.7, 2.0, -1.0):
        c, s = np.cos(angle), np.sin(angle)
        np.testing.assert_allclose(axes((c, s, 0.0)), [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], atol=1e-15)
    np.testing.assert_array_equal(axes((0.0, 2.0, 0.0)), [[0, -1, 0], [1, 0, 0], [0, 0, 1]])


def test_axes_are_a_right_handed_frame_with_the_third_nearest_to_the_normal():
    random = np.random.default_rng(1)
    for _ in range(20):
        end, normal = random.standard_normal((2, 3))
        frame = axes(end, normal)
        np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-14)
        assert np.linalg.det(frame) == pytest.approx(1.0)
        np.testing.assert_allclose(frame[:, 0], end / np.linalg.norm(end), atol=1e-15)
        # in the plane of the beam and the normal, on the side of the normal
        assert frame[:, 1] @ normal == pytest.approx(0.0, abs=1e-14) and frame[:, 2] @ normal > 0.0


def test_a_beam_along_z_has_its_third_axis_along_x():
    np.testing.assert_array_equal(axes((0.0, 0.0, 3.0)), [[0, 0, 1], [0, -1, 0], [1, 0, 0]])
    with pytest.raises(DataError, match=r"normal: expected a direction across the beam"):
        axes((0.0, 0.0, 3.0), (0.0, 0.0, 1.0))


def test_an_arc_in_space_is_that_of_the_plane_in_its_own_plane():
    end, normal = np.array([0.3, -0.5, 0.4]), np.array([0.2, 0.1, 1.0])
    placement = Placement.of("b", O, end, 1.1, normal)
    flat = Placement.of("b", (0.0, 0.0), (float(np.linalg.norm(end)), 0.0), 1.1, None)
    assert placement.length == flat.length > np.linalg.norm(end)
    s = np.linspace(0.0, placement.length, 7)
    points, frames = placement.at(s), placement.frames(s)
    np.testing.assert_allclose(points, flat.at(s) @ placement.axes[:, :2].T, atol=1e-15)
    np.testing.assert_allclose(points[-1], end, atol=1e-15)
    h = 1e-6  # axis 1 is the tangent, and turns about axis 3 by the curvature
    tangent = (placement.at(s + h) - placement.at(s - h)) / (2.0 * h)
    np.testing.assert_allclose(tangent, frames[:, :, 0], atol=1e-9)
    bend = (placement.frames(s + h) - placement.frames(s - h))[:, :, 0] / (2.0 * h)
    np.testing.assert_allclose(bend, 1.1 * frames[:, :, 1], atol=1e-9)
    np.testing.assert_array_equal(placement.frame(0.0), frames[0])
    assert flat.frame(0.0) is None


def test_the_number_of_coordinates_is_the_space():
    assert Placement.of("b", O, (1.0, 0.0, 0.0), None, None).space is SPATIAL
    assert Placement.of("b", O[:2], (1.0, 0.0), None, None).space is PLANAR


@pytest.mark.parametrize(
    ("start", "end", "normal", "error", "says"),
    [
        (O, (1.0, 0.0), None, SpaceError, "end: expected 3 coordinates"),
        (O[:2], (1.0, 0.0, 0.0), None, SpaceError, "end: expected 2 coordinates"),
        (O[:2], (1.0, 0.0), (0.0, 0.0, 1.0), SpaceError, "normal: expected none for a planar beam"),
        (O, O, None, DataError, r"length .*finite number > 0, got 0\.0"),
        (O, (1.0, 0.0, np.inf), None, DataError, "end: expected finite coordinates"),
        (O, (1.0, 0.0, 0.0), (0.0, 1.0), DataError, "normal: expected 3 components"),
        (O, (1.0, 0.0, 0.0), O, DataError, "normal: expected a direction"),
        (O, (1.0, 0.0, 0.0), "up", ArgumentTypeError, "normal: expected coordinates"),
    ],
)
def test_what_is_refused(start, end, normal, error, says):
    with pytest.raises(error, match=f"Beam 'b' {says}"):
        Placement.of("b", start, end, None, normal)
