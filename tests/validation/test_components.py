"""Planar is a slice of spatial: the same beam with 12 and with 6 components, integrated by a dense midpoint rule."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.blocks.beam.matrices import beam_matrices, strain_offsets
from phblocks.blocks.beam.mesh import Segment, number_states
from phblocks.blocks.beam.tensors import Variant
from phblocks.space import PLANAR, SPATIAL, Space

SECTION = ph.Section(axial=1e4, shear=(1e4, 9e3), bending=(80.0, 100.0), mass=1.0, rotary=(8.0, 10.0), torsion=90.0)
IN_PLANE = ("V1", "V2", "W3", "N1", "N2", "M3")

CASES = [
    pytest.param((True, True), (True, True), 1, 0.0, id="free-free, degree 1"),
    pytest.param((True, True), (True, True), 3, 0.2, id="free-free, degree 3, curved"),
    pytest.param((False, True), (False, True), 2, 0.0, id="pinned-pinned, degree 2"),
    pytest.param((False, False), (True, True), 2, -0.1, id="clamped-free, degree 2, curved, with a switch"),
]


class Dense:
    """E, J0 and T of a beam of 4 elements and 5 m, free of forces, and its midpoint rule."""

    def __init__(self, space, start, end, degree, curvature, section=SECTION):
        boundaries = np.array([0.0, 1.0, 2.5, 3.5, 5.0])
        segments = [Segment(0, 4, Variant(*start))]
        if start != end:
            segments = [Segment(0, 2, Variant(*start)), Segment(2, 4, Variant(*end))]
        mesh = number_states(boundaries, degree, segments, space)
        self.E, self.J0, self.T = (
            dense(entries, mesh.size)
            for entries in beam_matrices(mesh, section.coefficients(space), strain_offsets(curvature))
        )
        self.names = [f"{run.field} at {s:.9f}, {i}" for run in mesh.runs for i, s in enumerate(run.positions)]
        self.field = np.array([name[:2] for name in self.names])

    def J(self, x):
        return self.J0 + self.T @ x

    def run(self, x, dt, steps):
        """States after each step; Newton's method with the exact Jacobian, to the last bit it can reach."""
        states = [x]
        for _ in range(steps):
            z = x
            for _ in range(8):
                residual = 2 / dt * self.E @ (z - x) - self.J(z) @ z
                jacobian = 2 / dt * self.E - self.J(z) - np.einsum("ijk,j->ik", self.T, z)
                z = z - np.linalg.solve(jacobian, residual)
            x = 2 * z - x
            states.append(x)
        return np.array(states)


def dense(entries, n):
    array = np.zeros((n,) * len(entries.indices))
    np.add.at(array, entries.indices, entries.values)
    return array


@pytest.mark.parametrize(("start", "end", "degree", "curvature"), CASES)
def test_matrices_are_a_slice(start, end, degree, curvature):
    """Entries of the planar beam are those of the spatial one, to the last bits (measured: equal)."""
    plane, space = (Dense(s, start, end, degree, curvature) for s in (PLANAR, SPATIAL))
    assert len(space.names) == 2 * len(plane.names)
    place = np.array([space.names.index(name) for name in plane.names])
    for name, axes in (("E", 2), ("J0", 2), ("T", 3)):
        ours, theirs = getattr(plane, name), getattr(space, name)[np.ix_(*[place] * axes)]
        assert np.abs(ours).max() > 0.0
        np.testing.assert_allclose(ours, theirs, rtol=1e-15, atol=0.0)


@pytest.mark.parametrize(("start", "end", "degree", "curvature"), CASES)
def test_planar_motion_of_twelve_components(start, end, degree, curvature):
    """40 steps of a strongly bent, fast planar motion agree to 1e-12 and stay in the plane."""
    plane, space = (Dense(s, start, end, degree, curvature) for s in (PLANAR, SPATIAL))
    place = np.array([space.names.index(name) for name in plane.names])
    size = {"V": 3.0, "W": 1.0, "N": 500.0, "M": 40.0}  # strain 0.05, curvature 0.4 1/m
    x = np.array([size[f[0]] for f in plane.field]) * np.random.default_rng(0).uniform(-1.0, 1.0, len(plane.names))
    full = np.zeros(len(space.names))
    full[place] = x
    dt, steps = 0.01, 40
    planar, spatial = plane.run(x, dt, steps), space.run(full, dt, steps)
    weight = np.sqrt(np.diag(plane.E))
    assert np.abs(weight * (planar - spatial[:, place])).max() <= 1e-12 * np.linalg.norm(weight * x)
    out = ~np.isin(space.field, IN_PLANE)
    assert out.sum() == len(plane.names)
    assert not spatial[:, out].any()
    # the motion is worth comparing: it is nonlinear, it goes far, and it keeps its energy
    linear = Dense(PLANAR, start, end, degree, curvature)
    linear.T = np.zeros_like(linear.T)
    assert np.linalg.norm(weight * (linear.run(x, dt, steps)[-1] - planar[-1])) > 0.05 * np.linalg.norm(weight * x)
    energy = 0.5 * np.einsum("ti,ij,tj->t", planar, plane.E, planar)
    assert np.abs(energy / energy[0] - 1.0).max() <= 1e-13


@pytest.mark.parametrize("degree", [1, 2])
def test_motion_in_the_other_plane(degree):
    """Bending about axis 2 is bending about axis 3 of the beam rolled by a quarter turn: V3 for V2, -W2 for W3.

    With one section for both, a motion in the plane (1, 3) and its image in (1, 2) agree to 1e-12: the signs of all
    twelve components are tied together.
    """
    alike = ph.Section(axial=1e4, shear=9e3, bending=100.0, mass=1.0, rotary=10.0, torsion=90.0)
    beam = Dense(SPATIAL, (True, True), (True, True), degree, 0.0, alike)
    n = len(beam.names)
    rng = np.random.default_rng(1)
    size = {"V": 3.0, "W": 1.0, "N": 500.0, "M": 40.0}
    x = np.array([size[f[0]] if f in IN_PLANE else 0.0 for f in beam.field]) * rng.uniform(-1.0, 1.0, n)
    # roll about axis 1 by a quarter turn: e2 -> e3, e3 -> -e2
    image = np.zeros((n, n))
    for field in "VWNM":
        first, second, third = (np.flatnonzero(beam.field == f"{field}{i}") for i in (1, 2, 3))
        image[first, first] = image[third, second] = 1.0
        image[second, third] = -1.0
    assert (image @ x)[np.isin(beam.field, ("W2", "V3"))].any()
    a, b = beam.run(x, 0.01, 20), beam.run(image @ x, 0.01, 20)
    weight = np.sqrt(np.diag(beam.E))
    assert np.abs(weight * (a @ image.T - b)).max() <= 1e-12 * np.linalg.norm(weight * x)


@pytest.mark.parametrize(
    ("components", "space"),
    [(("V1", "N1"), Space("bar", (0,), ())), (("W1", "M1"), Space("rod", (), (0,)))],
)
def test_bars_and_rods_are_slices_too(components, space):
    """An axial bar is V1 N1, a torsion rod W1 M1 of spatial beams: linear, entries equal to the spatial ones."""
    small, full = (Dense(s, (True, True), (True, True), 2, 0.0) for s in (space, SPATIAL))
    assert set(small.field) == set(components)
    assert not small.T.any()
    place = np.array([full.names.index(name) for name in small.names])
    for name in ("E", "J0"):
        np.testing.assert_allclose(
            getattr(small, name), getattr(full, name)[np.ix_(place, place)], rtol=1e-15, atol=0.0
        )
