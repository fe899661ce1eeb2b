"""What is exported: shapes, names and numbers are checked before anything is written."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
import scipy.sparse as sp

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.export import CONVENTION


def test_holds_the_matrices_of_the_system(system, beam):
    for key, expected in {"E": system.E, "J": system.J(), "R": system.R, "Q": system.Q, "G": system.G()}.items():
        assert (getattr(beam, key) != expected).nnz == 0
    assert beam.state_names == system.state_names
    assert beam.convention == CONVENTION


def test_convention_needs_no_escapes():
    assert CONVENTION.isascii() and CONVENTION.isprintable()
    assert not set('"\\') & set(CONVENTION)


def test_absent_matrices_are_zero(beam):
    n, m = beam.G.shape
    for key, shape in {"P": (n, m), "S": (m, m), "N": (m, m)}.items():
        assert getattr(beam, key).shape == shape
        assert getattr(beam, key).nnz == 0


def test_copies(beam):
    """Neither what is given nor what is kept changes with the other."""
    E = beam.E.copy()
    x0 = beam.x0.copy()
    kept = replace(beam, E=E, x0=x0)
    E.data[:] = 0.0
    x0[:] = 1.0
    assert (kept.E != beam.E).nnz == 0
    np.testing.assert_array_equal(kept.x0, beam.x0)


@pytest.mark.parametrize(
    "convert", [sp.coo_array, sp.csc_matrix, lambda a: a.toarray(), lambda a: a.toarray().tolist()]
)
def test_takes_any_form(beam, convert):
    np.testing.assert_array_equal(replace(beam, R=convert(beam.E)).R.toarray(), beam.E.toarray())


def test_entries_are_canonical(beam):
    n = beam.E.shape[0]
    given = sp.coo_array(([1.0, 2.0, 0.0, 3], ([0, 0, 1, 0], [1, 1, 1, 0])), shape=(n, n))
    R = replace(beam, R=given).R
    assert R.data.tolist() == [3.0, 3.0]
    assert R.indices.tolist() == [0, 1]


def test_is_frozen(beam):
    with pytest.raises(FrozenInstanceError):
        beam.E = beam.R


@pytest.mark.parametrize(
    ("change", "error", "says"),
    [
        (lambda b: {"J": b.J[:-1]}, DataError, r"J: expected shape \(\d+, \d+\), got shape"),
        (lambda b: {"G": b.G.T}, DataError, "G: expected shape"),
        (lambda b: {"P": b.G[:, :1]}, DataError, "P: expected shape"),
        (lambda b: {"S": np.zeros((1, 2))}, DataError, "S: expected shape"),
        (lambda b: {"R": 1j * b.R}, DataError, "real numbers, got dtype complex"),
        (lambda b: {"R": b.R.toarray() * np.nan}, DataError, "R: expected finite entries"),
        (lambda b: {"R": "R"}, DataError, "R: expected"),
        (lambda b: {"R": None}, DataError, "R: expected"),
        (lambda b: {"R": np.zeros(3)}, DataError, "R: expected"),
        (lambda b: {"R": [[1.0], [2.0, 3.0]]}, DataError, "R: expected a matrix"),
        (lambda b: {"x0": b.x0[1:]}, DataError, "x0: expected shape"),
        (lambda b: {"f0": b.x0 + np.inf}, DataError, "f0: expected finite"),
        (lambda b: {"f0": "none"}, DataError, "f0: expected"),
        (lambda b: {"state_positions": b.x0 + np.inf}, DataError, "state_positions: expected finite"),
        (lambda b: {"state_units": b.state_units[1:]}, DataError, "state_units: expected"),
        (lambda b: {"output_names": ()}, DataError, "output_names: expected 2 of them, got 0"),
        (lambda b: {"state_names": "names"}, ArgumentTypeError, "state_names: expected strings"),
        (lambda b: {"input_units": ("N", 1)}, ArgumentTypeError, "input_units: expected strings"),
        (lambda b: {"input_units": None}, ArgumentTypeError, "input_units: expected strings"),
        (lambda b: {"input_names": ("a", "b\0")}, DataError, "input_names: expected text"),
        (lambda b: {"input_names": ("a", "\ud800")}, DataError, "input_names: expected text"),
        (lambda b: {"about": None}, ArgumentTypeError, "about"),
        (lambda b: {"tangent": b.E}, ArgumentTypeError, "tangent: expected a Tangent"),
    ],
)
def test_refuses(beam, change, error, says):
    with pytest.raises(error, match=says):
        replace(beam, **change(beam))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda t: {"A": t.A[1:]}, "A: expected shape"),
        (lambda t: {"B": t.C}, "B: expected shape"),
        (lambda t: {"E": t.D}, "E: expected shape"),
        (lambda t: {"state_units": ()}, "state_units: expected"),
    ],
)
def test_tangent_refuses(full, change, says):
    with pytest.raises(DataError, match="tangent: " + says):
        replace(full.tangent, **change(full.tangent))


def test_tangent_has_the_same_inputs(full, closed):
    with pytest.raises(DataError, match="expected 2 inputs and outputs"):
        replace(full, tangent=closed.tangent)


def test_other_states_are_the_same_system(beam, response):
    """The response, the energy and the load of any combination of states."""
    n = beam.E.shape[0]
    rng = np.random.default_rng(5)
    T = np.eye(n) + 0.3 * rng.standard_normal((n, n)) / np.sqrt(n)
    x0 = rng.standard_normal(n)
    given = replace(beam, x0=x0)
    m = given.with_states(T, [f"s{i}" for i in range(n)], ["1"] * n)
    assert m.state_names[3] == "s3" and m.tangent is None and np.isnan(m.state_positions).all()
    expected = response(beam.E, beam.J, beam.R, beam.Q, beam.G, 300.0j)
    np.testing.assert_allclose(response(m.E, m.J, m.R, m.Q, m.G, 300.0j), expected, rtol=1e-7)
    assert m.x0 @ (m.Q.T @ m.E) @ m.x0 == pytest.approx(x0 @ (beam.Q.T @ beam.E) @ x0)
    assert (m.Q @ m.x0) @ m.f0 == pytest.approx((beam.Q @ x0) @ beam.f0)


def test_a_permutation_moves_states_and_their_places(beam):
    n = beam.E.shape[0]
    order = np.random.default_rng(6).permutation(n)
    m = beam.with_states(np.eye(n)[order], [beam.state_names[i] for i in order], [beam.state_units[i] for i in order])
    np.testing.assert_array_equal(m.state_positions, beam.state_positions[order])
    for key in ("E", "J", "R", "Q"):
        np.testing.assert_array_equal(getattr(m, key).toarray(), getattr(beam, key).toarray()[np.ix_(order, order)])
    np.testing.assert_array_equal(m.G.toarray(), beam.G.toarray()[order])


@pytest.mark.parametrize("change", [np.zeros((3, 3)), "x", np.full((2, 2), np.nan)])
def test_a_change_that_is_none_is_refused(beam, change):
    with pytest.raises(DataError, match="change"):
        beam.with_states(change, beam.state_names, beam.state_units)


def test_a_singular_change_is_refused(beam):
    T = np.eye(beam.E.shape[0])
    T[1] = T[0]
    with pytest.raises(DataError, match="invertible"):
        beam.with_states(T, beam.state_names, beam.state_units)
