"""The plane is a slice of space."""

import numpy as np
import pytest

from phblocks.space import LEVI_CIVITA, PLANAR, SPATIAL


def test_the_symbol_makes_cross_products():
    a, b = np.random.default_rng(0).standard_normal((2, 3))
    np.testing.assert_array_equal(np.einsum("ijk,j,k->i", LEVI_CIVITA, a, b), np.cross(a, b))


def test_components():
    assert (PLANAR.translation, PLANAR.rotation, PLANAR.dimension) == ((0, 1), (2,), 2)
    assert (SPATIAL.translation, SPATIAL.rotation, SPATIAL.dimension) == ((0, 1, 2), (0, 1, 2), 3)


@pytest.mark.parametrize(
    ("space", "kind", "turns"),
    [
        (PLANAR, "translation", True),
        (PLANAR, "rotation", False),  # a rotation of the plane leaves angular velocities alone
        (PLANAR, None, False),
        (SPATIAL, "translation", True),
        (SPATIAL, "rotation", True),
        (SPATIAL, None, False),
    ],
)
def test_what_a_rotation_changes(space, kind, turns):
    assert space.turns(kind) is turns
