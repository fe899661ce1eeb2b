"""The setting to use, out of rows made by hand."""

import pytest

from phblocks import errors
from phblocks.studies import WorkPrecisionStudy, best_within, cheapest
from tests.studies.rows import make_run


@pytest.fixture
def study():
    return WorkPrecisionStudy(
        (
            make_run("rough", 0.1, 1e-2),
            make_run("fair", 0.5, 1e-3, reference_uncertainty=2e-4),
            make_run("fine", 2.0, 1e-5),
            make_run("wasteful", 3.0, 1e-3),
            make_run("failed", 0.01),
        )
    )


def test_cheapest(study):
    assert cheapest(study, 2e-2).method == "rough"
    assert cheapest(study, 2e-3).method == "fair"
    assert cheapest(study, 1e-5).method == "fine"


def test_uncertainty_of_the_reference_counts(study):
    assert cheapest(study, 1.21e-3).method == "fair"
    assert cheapest(study, 1.1e-3).method == "fine"


def test_best_within(study):
    assert best_within(study, 0.1).method == "rough"
    assert best_within(study, 1.0).method == "fair"
    assert best_within(study, 10.0).method == "fine"


def test_none_is_accurate_enough(study):
    with pytest.raises(errors.UnreachedError, match=r"at most 1e-06 m, got at best fine.*error 1e-05 m in 2 s"):
        cheapest(study, 1e-6)


def test_none_is_fast_enough(study):
    with pytest.raises(errors.UnreachedError, match=r"at most 0.05 s, got at best rough"):
        best_within(study, 0.05)


def test_all_failed(study):
    for choose in (cheapest, best_within):
        with pytest.raises(errors.UnreachedError, match="none of 1"):
            choose(study.filter(method="failed"), 1.0)


@pytest.mark.parametrize("choose", [cheapest, best_within])
def test_arguments(study, choose):
    with pytest.raises(errors.ArgumentTypeError, match="a study"):
        choose([1, 2], 1.0)
    with pytest.raises(errors.ArgumentTypeError, match="real number"):
        choose(study, "1e-3")
    for bound in (0.0, -1.0, float("nan")):
        with pytest.raises(errors.DataError, match="> 0"):
            choose(study, bound)


def test_front(study):
    assert study.front.column("method") == ["rough", "fair", "fine"]
