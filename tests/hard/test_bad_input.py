"""Bad input: a typed error or a correct run, never a raw error from inside, never NaN in a run that succeeded.

``faults`` makes diagrams with wrong numbers and kinds in them; those of ``tests/properties`` are right, and are
compiled and run with wrong options, states and signals.
"""

import os
import warnings
from collections import Counter
from random import Random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.hard.faults import play
from tests.properties import planar

NO_HURRY = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much]
#: How often a value is wrong; at zero almost all that is refused is a diagram that cannot work.
SHARES = [0.0, 0.005, 0.02, 0.1]


def play_made(count: int, **options: object) -> Counter[str]:
    counter: Counter[str] = Counter()

    @settings(max_examples=count, suppress_health_check=NO_HURRY, **options)
    @given(st.integers(0, 2**32 - 1), st.sampled_from(SHARES))
    def run(seed: int, wrong: float) -> None:
        counter["all"] += 1
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # 1e300 times 1e300 on the way to an error
            play(Random(seed), wrong, counter)

    run()
    return counter


def play_drawn(count: int, **options: object) -> Counter[str]:
    counter: Counter[str] = Counter()

    @settings(max_examples=count, suppress_health_check=NO_HURRY, **options)
    @given(planar.diagrams(), st.integers(0, 2**32 - 1), st.sampled_from([0.02, 0.1]))
    def run(diagram: object, seed: int, wrong: float) -> None:
        counter["all"] += 1
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            play(Random(seed), wrong, counter, diagram)

    run()
    return counter


def assert_all_happened(counter: Counter[str]) -> None:
    """Else the property would be about errors only, or about none."""
    assert counter["refused"] > 0.2 * counter["all"], counter
    assert counter["compiled"] > 0.1 * counter["all"], counter
    assert counter["success"] > 0.05 * counter["all"], counter


def test_bad_input() -> None:
    """A hundred and thirty examples, the same in every run."""
    counter = play_made(100) + play_drawn(30)
    assert_all_happened(counter)


@pytest.mark.slow
def test_much_bad_input() -> None:
    """Two thousand and more; different ones in every run, but for CI, where a change is judged by what it changes."""
    same = "CI" in os.environ
    counter = play_made(1700, derandomize=same, database=None) + play_drawn(400, derandomize=same, database=None)
    assert counter["all"] >= 2000
    assert_all_happened(counter)
