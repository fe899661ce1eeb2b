"""Numbering of the states of a beam, with and without a switch."""

import itertools

import numpy as np
import pytest

from phblocks.blocks.beam.ends import ENDS
from phblocks.blocks.beam.mesh import Mesh, Segment, number_states
from phblocks.blocks.beam.tensors import Variant, present_components
from phblocks.space import PLANAR, SPATIAL

PAIRS_OF_ENDS = list(itertools.product(ENDS, repeat=2))
BOUNDARIES = np.array([0.0, 0.3, 0.5, 1.2, 2.0])  # four elements of different lengths
M = 3  # where pairs switch

every_causality = pytest.mark.parametrize(("start", "end"), PAIRS_OF_ENDS)


def mesh_of(start: str, end: str, degree: int, space=PLANAR) -> Mesh:
    n = len(BOUNDARIES) - 1
    a, b = Variant(*ENDS[start]), Variant(*ENDS[end])
    segments = [Segment(0, n, a)] if a == b else [Segment(0, M, a), Segment(M, n, b)]
    return number_states(BOUNDARIES, degree, segments, space)


@every_causality
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_number_of_states(start, end, degree):
    """Each component of a pair has 2nk + 1 states, and one more if the pair switches."""
    n = len(BOUNDARIES) - 1
    a, b = ENDS[start], ENDS[end]
    translation, rotation = (2 * n * degree + 1 + (a[i] != b[i]) for i in (0, 1))
    assert mesh_of(start, end, degree).size == 2 * translation + rotation
    assert mesh_of(start, end, degree, SPATIAL).size == 3 * translation + 3 * rotation


@every_causality
@pytest.mark.parametrize("degree", [1, 3])
def test_every_state_belongs_to_an_element_and_to_one_component(start, end, degree):
    mesh = mesh_of(start, end, degree)
    used = [{int(i) for states in mesh.states for i in states[c].ravel()} for c in present_components(PLANAR)]
    assert sorted(i for component in used for i in component) == list(range(mesh.size))
    assert [len(component) for component in used] == [run.positions.size for run in mesh.runs]
    assert [run.field for run in mesh.runs] == ["V1", "V2", "W3", "N1", "N2", "M3"]


@every_causality
@pytest.mark.parametrize("degree", [1, 3])
def test_positions_are_those_of_the_nodes(start, end, degree):
    mesh = mesh_of(start, end, degree)
    positions = np.concatenate([run.positions for run in mesh.runs])
    for i, segment in enumerate(mesh.segments):
        for component, states in mesh.states[i].items():
            nodes = np.array(mesh.basis(i, component[0]).nodes)
            left = BOUNDARIES[segment.first : segment.last, None]
            spots = left + mesh.lengths[segment.first : segment.last, None] * nodes
            np.testing.assert_allclose(positions[states], spots, atol=1e-15)
    assert all((np.diff(run.positions) >= 0.0).all() for run in mesh.runs)  # from start to end


@every_causality
def test_fields_are_continuous_within_a_variant_and_across_a_switch_of_the_other_pair(start, end):
    mesh = mesh_of(start, end, degree=2)
    for i, segment in enumerate(mesh.segments):
        for (field, _), states in mesh.states[i].items():
            shared = states[:-1, -1] == states[1:, 0]
            assert (shared == segment.variant.is_continuous(field)).all()
    if len(mesh.segments) == 2:
        left, right = (s.variant for s in mesh.segments)
        for component in present_components(PLANAR):
            field = component[0]
            through = mesh.states[0][component][-1, -1] == mesh.states[1][component][0, 0]
            assert through == (left.is_continuous(field) and right.is_continuous(field))


def test_units_and_kinds_of_energy():
    runs = mesh_of("free", "clamped", 1).runs
    assert [run.unit for run in runs] == ["m/s", "m/s", "rad/s", "N", "N", "N m"]
    assert [run.energy for run in runs] == ["kinetic"] * 3 + ["strain"] * 3


@pytest.mark.parametrize(
    ("place", "element", "xi"),
    [(0.0, 0, 0.0), (0.15, 0, 0.5), (0.3, 0, 1.0), (0.4, 1, 0.5), (1.2, 2, 1.0), (2.0, 3, 1.0), (-1e-9, 0, 0.0)],
)
def test_locating_a_point_prefers_the_element_to_the_left(place, element, xi):
    found, where = mesh_of("free", "free", 1).locate(place)
    assert found == element and where == pytest.approx(xi, abs=1e-15)


def test_segments():
    mesh = mesh_of("clamped", "free", 1)
    assert [mesh.segment_of(e) for e in range(4)] == [0, 0, 0, 1]
    assert mesh.local_states(0).shape == (3, 6 * 1 + 3) and mesh.local_states(1).shape == (1, 9)
    np.testing.assert_allclose(mesh.lengths, [0.3, 0.2, 0.7, 0.8])
