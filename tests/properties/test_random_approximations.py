"""Random planar diagrams with random approximations: refused with a typed error, or structure and balance as ever."""

from collections import Counter

import pytest
from hypothesis import HealthCheck, Phase, given, note, settings
from hypothesis import strategies as st

import phblocks as ph
from tests.properties import planar
from tests.properties.properties import (
    STEPS,
    assert_balanced,
    assert_error_helps,
    assert_structure,
    describe,
    inputs_of,
    start_of,
)

FLAG = st.booleans()
APPROXIMATIONS = st.builds(
    ph.Approximation,
    large_rotation=st.sampled_from([True, False, "second-order"]),
    shear=FLAG,
    extension=FLAG,
    rotary_inertia=FLAG,
    flexible=st.sampled_from([True, True, True, False]),
    internal_damping=FLAG,
    gravity=FLAG,
    insist=st.just(True),
)


def check(diagram, approximation, seed, counter):
    """Of a diagram that is fine as it is, with something left out."""
    try:
        diagram.compile()
    except ph.PhblocksError:
        return
    counter["all"] += 1
    try:
        system = diagram.compile(approximation=approximation, effects="all")  # starts move everything
    except ph.PhblocksError as error:  # a redundant constraint, a body that is held twice
        counter[type(error).__name__] += 1
        assert_error_helps(error)
        assert isinstance(error, (ph.errors.ConstraintError, ph.errors.CausalityError))
        return
    counter["compiled"] += 1
    counter["linear"] += system.linear
    assert_structure(system, seed)
    try:
        solution = ph.simulate(
            system, STEPS * 1e-3, 1e-3, start=start_of(system, seed), inputs=inputs_of(diagram, seed), max_halvings=6
        )
    except ph.errors.ConstraintError:
        assert not system.quadratic
        return
    assert solution.status.name in ("success", "step failed")
    counter[solution.status.name] += 1
    change = abs(solution.statistics.start_energy_change)
    if system.energy(solution.x[0]) < 1e-12 * change:  # nothing is left to move: what remains is round-off of the start
        counter["held"] += 1
        assert solution.max_power_balance_error < 1e-12 * change
    else:
        assert_balanced(solution)


def draw_and_check(count):
    counter = Counter()

    @settings(max_examples=count, suppress_health_check=list(HealthCheck), phases=(Phase.generate,))
    @given(planar.diagrams(), APPROXIMATIONS, st.integers(0, 2**16))
    def run(diagram, approximation, seed):
        note(describe(diagram))
        check(diagram, approximation, seed, counter)

    run()
    assert counter["success"] > 0.9 * counter["all"] > 0.5 * count
    assert counter["linear"] > 0.05 * count


def test_random_approximations():
    """40 diagrams, the same in every run."""
    draw_and_check(40)


@pytest.mark.slow
def test_many_random_approximations():
    """Measured: of 366 that compile in full 359 do with something left out; the others are held more than once."""
    draw_and_check(400)
