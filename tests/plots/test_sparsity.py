"""Entries on paper are those of the matrices."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
import scipy.sparse as sp

import phblocks as ph
from phblocks import plots


@pytest.fixture(scope="module")
def system(four_bar):
    return four_bar().compile()


def entries(ax):
    """Label -> set of (row, column)."""
    drawn = [line for line in ax.lines if line.get_marker() == "s"]
    return {line.get_label(): {(int(y), int(x)) for x, y in line.get_xydata()} for line in drawn}


def places(matrix):
    matrix = sp.coo_array(matrix)
    return {(int(i), int(j)) for i, j in zip(*matrix.coords, strict=True)}


def test_structure_matrix(system):
    kinds = entries(plots.sparsity(system))
    assert list(kinds) == ["constant", "times velocity or stress", "turning joints"]
    assert kinds["constant"] == places(system.J0)
    rng = np.random.default_rng(0)
    generic = system.J(rng.standard_normal(system.n), rng.standard_normal(system.start.theta.size))
    assert set().union(*kinds.values()) == places(generic)
    assert sum(map(len, kinds.values())) == generic.nnz  # no place twice


def test_mass_matrix(system):
    ax = plots.sparsity(system, "E")
    assert entries(ax) == {"entries": places(system.E)}
    assert ax.get_title() == f"E of four-bar: {system.n} × {system.n}, {system.E.nnz} entries"
    assert entries(plots.sparsity(system, "R")) == {}


def test_newton_matrix(system):
    ax = plots.sparsity(system, "newton")
    [drawn] = entries(ax).values()
    width = max(abs(i - j) for i, j in drawn)
    assert f"half-bandwidth {width}" in ax.get_title()
    assert width <= 8  # of a loop of planar beams of degree 1
    assert "order of solution" in ax.get_xlabel()


def test_array(system):
    matrix = np.zeros((system.n, system.n))
    matrix[3, 5] = 1.0
    assert entries(plots.sparsity(system, matrix)) == {"entries": {(3, 5)}}
    assert entries(plots.sparsity(system, sp.csr_array(matrix))) == {"entries": {(3, 5)}}


def test_blocks_and_fields_are_named(system):
    ax = plots.sparsity(system)
    fields = [label.get_text() for label in ax.get_xticklabels()]
    assert fields == ["V1", "V2", "W3", "N1", "N2", "M3"] * 3
    assert [label.get_text() for label in ax.get_yticklabels()] == fields
    for axis in ax.child_axes:
        labels = [*axis.get_xticklabels(), *axis.get_yticklabels()]
        assert [t.get_text() for t in labels if t.get_text() in ("crank", "coupler", "rocker")] == [
            "crank",
            "coupler",
            "rocker",
        ]
    borders = {line.get_xdata()[0] for line in ax.lines if line.get_color() == "0.4"} - {0.0}
    assert borders == {part.states.start - 0.5 for part in system.parts if part.states.start > 0}
    assert ax.yaxis_inverted()  # row 0 on top
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("column: state", "row: state")


def test_many_blocks_are_not_named(bar):
    d = ph.Diagram("chain")
    links = [d.add(ph.Beam(f"link {i}", bar, (i, 0.0), (i + 1.0, 0.0), elements=2)) for i in range(45)]
    d.pin(links[0].start, d.ground)
    for i in range(44):
        d.pin(links[i].end, links[i + 1].start)
    ax = plots.sparsity(d.compile())
    assert ax.child_axes == []
    assert "V1" not in [label.get_text() for label in ax.get_xticklabels()]


def test_draws_where_asked(system):
    _, ax = plt.subplots()
    assert plots.sparsity(system, ax=ax) is ax


@pytest.mark.parametrize("matrix", ["K", np.eye(3), np.zeros(4)])
def test_wrong_matrix(system, matrix):
    with pytest.raises(ph.errors.DataError):
        plots.sparsity(system, matrix)


def test_no_system(system):
    with pytest.raises(ph.errors.ArgumentTypeError):
        plots.sparsity(system.E)
