"""The closure: edges, products, ways; and the fields of a beam, planar out of spatial ones."""

import numpy as np
import pytest

from phblocks.blocks.beam.matrices import beam_matrices, strain_offsets
from phblocks.blocks.beam.mesh import Segment, number_states
from phblocks.blocks.beam.tensors import Variant
from phblocks.effects import PatternBuilder, reach
from phblocks.space import PLANAR, SPATIAL


def closure(size, edges=(), products=(), excited=()):
    builder = PatternBuilder()
    builder.add_nodes(size)
    for edge in edges:
        builder.add_edges(*edge)
    for product in products:
        builder.add_products(*product)
    mask = np.zeros(size, dtype=bool)
    mask[list(excited)] = True
    return reach(builder.pattern(), mask)


def test_edges_are_followed_in_their_direction():
    found = closure(4, edges=[(0, 1), (1, 2), (3, 2)], excited=[0])
    assert found.mask.tolist() == [True, True, True, False]
    assert found.path(2) == [2, 1, 0]


def test_a_product_needs_both_factors():
    assert closure(3, products=[(0, 1, 2)], excited=[0]).mask.tolist() == [True, False, False]
    assert closure(3, products=[(0, 1, 2)], excited=[0, 1]).mask.all()
    # also if one of them comes late, through another product; and a square
    found = closure(5, edges=[(3, 1)], products=[(0, 1, 2), (0, 0, 3), (2, 3, 4)], excited=[0])
    assert found.mask.all() and found.path(4)[-1] == 0


def test_many_edges_at_one_place_do_not_overflow():
    builder = PatternBuilder()
    builder.add_nodes(2)
    builder.add_edges(np.zeros(256, dtype=np.int64), 1)
    assert reach(builder.pattern(), np.array([True, False])).mask.all()


def beam_closure(space, excited, degree=2, curvature=0.0, elements=3):
    """Fields of a beam that are reached, and how many states they have."""
    coefficients = np.random.default_rng(1).uniform(0.5, 1.5, 12)
    mesh = number_states(
        np.linspace(0.0, 1.0, elements + 1), degree, [Segment(0, elements, Variant(True, True))], space
    )
    builder, fields = PatternBuilder(), [run.field for run in mesh.runs]
    builder.add_nodes(len(fields))
    component = np.repeat(np.arange(len(fields)), [run.positions.size for run in mesh.runs])
    matrices = beam_matrices(mesh, coefficients, strain_offsets(curvature))
    for entries in matrices:
        builder.add_matrix(entries, component)
    found = reach(builder.pattern(), np.isin(fields, excited)).mask
    return {f for f, here in zip(fields, found, strict=True) if here}, np.flatnonzero(found[component]), mesh, matrices


@pytest.mark.parametrize(
    ("excited", "reached"),
    [
        (["V1"], {"V1", "N1"}),
        (["W1"], {"W1", "M1"}),
        (["V1", "V2", "W3"], {"V1", "V2", "W3", "N1", "N2", "M3"}),
        (["V2"], {"V1", "V2", "W3", "N1", "N2", "M3"}),
        (["M2"], {"V1", "V3", "W2", "N1", "N3", "M2"}),
        (["V1", "W1"], {"V1", "W1", "N1", "M1"}),
        (["V2", "W1"], None),
        (["V2", "V3"], None),
    ],
)
def test_the_fields_of_a_straight_spatial_beam(excited, reached):
    """Bar, torsion rod, the two planes, and both together, out of the twelve components."""
    everything = {f"{f}{d}" for f in "VWNM" for d in (1, 2, 3)}
    assert beam_closure(SPATIAL, excited)[0] == (reached or everything)


def test_an_arc_that_is_pulled_bends_in_its_plane():
    assert beam_closure(SPATIAL, ["V1"], curvature=0.4)[0] == {"V1", "V2", "W3", "N1", "N2", "M3"}


def test_planar_out_of_spatial_is_the_planar_beam():
    """The unknowns of the plane, and its matrices to the last bit."""
    _, states, mesh, spatial = beam_closure(SPATIAL, ["V2"])
    _, all_states, plane, planar = beam_closure(PLANAR, ["V2"])
    assert states.size == plane.size == all_states.size == mesh.size // 2
    for mine, theirs in zip(spatial, planar, strict=True):
        order = len(mine.indices)
        cut = mine.coo((mesh.size,) * order).toarray()[np.ix_(*[states] * order)]
        np.testing.assert_array_equal(cut, theirs.coo((plane.size,) * order).toarray())
    # and nothing acts on what is left out: rows of the others are zero on states of the plane
    x = np.zeros(mesh.size)
    x[states] = np.random.default_rng(0).standard_normal(states.size)
    E, J0, T = (m.coo((mesh.size,) * len(m.indices)).toarray() for m in spatial)
    rest = np.setdiff1d(np.arange(mesh.size), states)
    assert not ((J0 + T @ x) @ x)[rest].any() and not (E @ x)[rest].any()
