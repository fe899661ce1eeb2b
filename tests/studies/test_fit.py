"""Orders of errors whose law is known."""

import math

import pytest

from phblocks.studies.fit import asymptotic_part, fit_line, pairwise_rates

STEPS = [0.1, 0.05, 0.02, 0.01]


def test_power_law():
    errors = [3.0 * h**4 for h in STEPS]
    slope, deviation, runs = fit_line("dt", STEPS, errors)
    assert slope == pytest.approx(4.0, rel=1e-12)
    assert deviation == pytest.approx(0.0, abs=1e-7) and runs == 4
    assert pairwise_rates("dt", STEPS, errors)[1:] == pytest.approx([4.0] * 3)
    assert asymptotic_part("dt", STEPS, errors, 0.0) == {0, 1, 2, 3}


def test_exponential_law():
    """A tenth a degree."""
    degrees, errors = [1.0, 2.0, 4.0], [1e-1, 1e-2, 1e-4]
    assert fit_line("degree", degrees, errors).slope == pytest.approx(-math.log(10.0))
    assert pairwise_rates("degree", degrees, errors)[1:] == pytest.approx([10.0, 10.0])


def test_deviation_of_the_slope():
    """Slope -1, 1 over 0, 1, 2: residuals 1/3, -2/3, 1/3, variance 2/3 over 1 degree of freedom and Sxx = 2."""
    fit = fit_line("degree", [0.0, 1.0, 2.0], [math.e, 1.0, math.e])
    assert fit.slope == pytest.approx(0.0, abs=1e-15)
    assert fit.deviation == pytest.approx(math.sqrt(1.0 / 3.0))


def test_coarse_runs_are_left_out():
    errors = [0.01, 0.011, 4e-4, 1e-4]
    assert asymptotic_part("dt", STEPS, errors, 0.0) == {2, 3}


def test_errors_below_the_floor_are_left_out():
    errors = [1e-2, 2.5e-3, 4e-4, 3.9e-4]
    assert asymptotic_part("dt", STEPS, errors, 3.95e-4) == {0, 1, 2}


def test_failed_and_vanishing_runs_are_left_out():
    errors = [1e-2, math.nan, 4e-4, 0.0]
    assert asymptotic_part("dt", STEPS, errors, 0.0) == {0, 2}
    assert all(map(math.isnan, pairwise_rates("dt", STEPS, errors)))


def test_nothing_to_fit():
    assert asymptotic_part("dt", STEPS, [math.nan] * 4, 0.0) == set()
    assert math.isnan(fit_line("dt", [0.1], [1.0]).slope)
