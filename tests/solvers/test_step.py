"""Steps in arrays: taken apart and put together again."""

import dataclasses

import numpy as np

from phblocks.solvers.step import Step, Steps


def step(k: float, **options) -> Step:
    """A step of two unknowns, one orientation, two stages and one input."""
    z = np.full((2, 2), k)
    return Step(np.full(2, k), np.full(1, k), z, z[:, :1], z[:, 1:], 0.1 * k, int(k), **options)


def test_one_step_there_and_back():
    one = step(3.0, lag=0.2, residual=1e-3, damped=np.ones(2), points=np.ones((1, 2)))
    steps = Steps.of(one)
    assert len(steps) == 1 and steps.last is steps.last
    for name, value in dataclasses.asdict(one).items():
        np.testing.assert_array_equal(getattr(steps.last, name), value)
    assert isinstance(steps.last.dt, float) and isinstance(steps.last.iterations, int)


def test_what_is_missing_in_a_part_means_nothing():
    """Nothing was taken, nothing was added, the structure was that of the stages."""
    shift = np.ones((1, 2))
    parts = [Steps.of(step(1.0)), Steps.of(step(2.0, damped=np.full(2, 7.0), before=np.full(2, 5.0), shift=shift))]
    whole = Steps.join(parts)
    assert len(whole) == 2 and whole.frozen is None and whole.points is None
    np.testing.assert_array_equal(whole.damped, [[0.0, 0.0], [7.0, 7.0]])
    np.testing.assert_array_equal(whole.before, [[1.0, 1.0], [5.0, 5.0]])
    np.testing.assert_array_equal(whole.shift, [[[0.0, 0.0]], [[1.0, 1.0]]])
    frozen = Steps.join([Steps.of(step(1.0)), Steps.of(step(2.0, frozen=np.zeros((2, 2))))]).frozen
    np.testing.assert_array_equal(frozen, [np.ones((2, 2)), np.zeros((2, 2))])
    assert Steps.join(parts[:1]) is parts[0]
