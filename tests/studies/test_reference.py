"""References: extrapolation of sequences whose limit is known, refinement, checks."""

import numpy as np
import pytest

from phblocks import errors
from phblocks.studies import Reference
from phblocks.studies.reference import extrapolate, given, refined

LIMIT, SLOPE = np.array([[1.0, -2.0], [0.5, 3.0]]), np.array([[3.0, 4.0], [0.0, 1.0]])


@pytest.mark.parametrize("order", [1.0, 2.0, 3.7, 6.0])
@pytest.mark.parametrize("sizes", [(0.4, 0.2, 0.1), (0.3, 0.2, 0.15)])
def test_a_power_law_is_extrapolated_exactly(order, sizes):
    values = [LIMIT + SLOPE * h**order for h in sizes]
    found = extrapolate(sizes, values)
    np.testing.assert_allclose(found.value, LIMIT, atol=1e-11)
    # without a fourth run: how far it was extrapolated, 5 being the norm of the largest row of SLOPE
    assert found.uncertainty == pytest.approx(5.0 * sizes[-1] ** order)


def test_a_fourth_run_tells_the_uncertainty():
    """h^2 + 0.1 h^4 is not one power: the uncertainty bounds the error, and is below that of the finest run."""
    sizes = (0.4, 0.2, 0.1, 0.05)
    found = extrapolate(sizes, [LIMIT + SLOPE * (h**2 + 0.1 * h**4) for h in sizes])
    assert found.error_of(LIMIT) <= found.uncertainty < 0.1 * 5.0 * 0.05**2


def test_differences_that_do_not_fall():
    values = [np.array([v]) for v in (0.0, 1.0, 3.0)]
    found = extrapolate((0.4, 0.2, 0.1), values)
    assert found.value == 3.0 and found.uncertainty == 2.0
    assert "do not fall" in found.source


def test_runs_that_agree():
    found = extrapolate((0.4, 0.2, 0.1), [np.array([1.0])] * 3)
    assert found.value == 1.0 and found.uncertainty == 0.0


def test_norm_of_the_error():
    """Euclidean over components, largest over times."""
    assert Reference(LIMIT).error_of(LIMIT + SLOPE) == pytest.approx(5.0)
    assert Reference([1.0, 2.0]).error_of(np.array([1.5, 1.0])) == 1.0
    assert np.isnan(Reference(LIMIT).error_of(None))


def test_checks():
    assert np.isnan(given([1.0]).uncertainty)
    assert given(Reference([1.0], 0.1)).uncertainty == 0.1
    for wrong in ([np.nan], []):
        with pytest.raises(errors.DataError, match="finite"):
            given(wrong)
    with pytest.raises(errors.DataError, match=">= 0"):
        Reference([1.0], -1.0)
    with pytest.raises(errors.ArgumentTypeError):
        given("good")
    with pytest.raises(errors.DataError, match=r"shape of the quantity, \(1, 2\)"):
        Reference(LIMIT).error_of(np.zeros((1, 2)))


def test_refined():
    assert refined({"elements": 4}) == ({"elements": 8}, {"elements": 4})
    assert refined({"elements": (2, 3), "degree": 1}) == (
        {"elements": (4, 6), "degree": 2},
        {"elements": (4, 6), "degree": 1},
    )
    assert refined({"degree": 2}) == ({"degree": 3}, {"degree": 2})
    assert refined({}) == ({},)
    assert refined({"elements": (0.0, 0.3, 1.0)}) == ({"elements": (0.0, 0.3, 1.0)},)
