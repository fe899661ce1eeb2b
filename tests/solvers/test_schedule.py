"""Times of a run, and the steps between them."""

import itertools

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.solvers.past import Past
from phblocks.solvers.schedule import Schedule, together
from phblocks.solvers.step import Step


@pytest.mark.parametrize(
    ("schedule", "ends", "saved"),
    [
        (Schedule(0.3, 0.1), [0.1, 0.2, 0.3], [0.1, 0.2, 0.3]),
        (Schedule(0.25, 0.1), [0.1, 0.2, 0.25], [0.1, 0.2, 0.25]),
        (Schedule(0.5, 0.1, 2), [0.1, 0.2, 0.3, 0.4, 0.5], [0.2, 0.4, 0.5]),
        (Schedule(0.3, 0.1, 1, (0.05, 0.2, 0.3)), [0.05, 0.125, 0.2, 0.3], [0.05, 0.2, 0.3]),
        (Schedule(0.3, 0.1, 1, (0.05, 0.2, 0.3), True), [0.05, 0.125, 0.2, 0.3], [0.05, 0.125, 0.2, 0.3]),
        (
            Schedule(0.3, 0.1, 3, (0.05, 0.3), True),
            [0.05, 0.05 + 0.25 / 3, 0.05 + 0.5 / 3, 0.3],
            [0.05, 0.05 + 0.5 / 3, 0.3],
        ),
    ],
)
def test_steps_and_saved_times(schedule, ends, saved):
    steps = list(schedule.intervals())
    np.testing.assert_allclose([t1 for _, _, t1, _ in steps], ends, rtol=1e-14)
    np.testing.assert_allclose([t0 + h for t0, h, _, _ in steps], ends, rtol=1e-14)
    np.testing.assert_allclose([t1 for _, _, t1, save in steps if save], saved, rtol=1e-14)
    np.testing.assert_allclose([end for _, end in schedule.targets()], saved, rtol=1e-14)
    assert max(h for _, h, _, _ in steps) <= schedule.dt * (1 + 1e-12)


def test_equal_steps_have_the_very_same_length():
    assert {h for _, h, _, _ in Schedule(1.0, 0.01).intervals()} == {0.01}
    assert {h for _, h, _, _ in Schedule(1.0, 0.01, 1, (0.3, 0.7, 1.0)).intervals()} == {0.01}


@pytest.mark.parametrize("longest", [1, 3, 4096])
@pytest.mark.parametrize(
    "schedule",
    [
        Schedule(1.05, 0.1, 3),
        Schedule(1.0, 0.1, 1, (0.3, 0.35, 0.7, 1.0), True),
        Schedule(1.0, 0.1, 4, tuple(np.linspace(0.1, 1.0, 10).tolist())),
    ],
)
def test_stretches_are_the_same_intervals(schedule, longest):
    """Of one length each, as long as allowed; from the middle as from the start."""
    whole = list(schedule.intervals())
    for first in (0, 4, len(whole) - 1, len(whole)):
        rows = []
        for begin, length, end, saved in schedule.stretches(first, longest):
            assert 1 <= begin.size <= longest
            rows += zip(begin.tolist(), [length] * begin.size, end.tolist(), saved.tolist(), strict=True)
        assert rows == whole[first:]
    pairs = list(itertools.pairwise(schedule.stretches(0, longest)))
    assert all(a[1] != b[1] or a[0].size + b[0].size > longest for a, b in pairs)


def test_times_asked_for_at_every_step_make_one_stretch():
    times = tuple(np.linspace(0.1, 1.0, 10).tolist())
    assert [begin.size for begin, *_ in Schedule(1.0, 0.1, 1, times).stretches()] == [10]


def test_long_chunks_are_cut_into_equal_stretches():
    assert together(26) == 4096 and together(10**6) == 1
    assert together(200, 1000) == 500 and together(26, 1000) == 1000 and together(7000, 40) == 14


@pytest.fixture(scope="module")
def system(bar) -> ph.System:
    d = ph.Diagram("pendulum", gravity=(0.0, -9.81))
    d.pin(d.add(ph.Beam("b", bar, (0.0, 0.0), (1.0, 0.0), elements=2)).start, d.ground)
    return d.compile()


def test_a_run_saves_at_the_times_asked_for(system):
    solution = ph.simulate(system, 0.3, 0.02, times=[0.1, 0.2])
    np.testing.assert_array_equal(solution.t, [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_array_equal(solution.x, ph.simulate(system, 0.3, 0.02, save_every=5).x)
    odd = ph.simulate(system, 0.3, 0.02, times=np.array([0.0123, 0.3]))
    np.testing.assert_array_equal(odd.t, [0.0, 0.0123, 0.3])
    assert odd.statistics.steps == 1 + 15 and np.abs(odd.energy.total - odd.energy.total[0]).max() < 1e-12


def test_times_and_steps_are_saved(system):
    both = ph.simulate(system, 0.3, 0.1, times=[0.15], save_every=1)
    np.testing.assert_allclose(both.t, [0.0, 0.075, 0.15, 0.225, 0.3], rtol=1e-14)
    adapted = {"adaptive": ph.Adaptive(rtol=1e-2), "times": [0.123]}
    few, all_steps = (ph.simulate(system, 0.3, 0.01, save_every=every, **adapted) for every in (None, 1))
    np.testing.assert_array_equal(few.t, [0.0, 0.123, 0.3])
    assert all_steps.t.size == 1 + all_steps.statistics.steps // 2 > 5
    np.testing.assert_array_equal(all_steps.x[np.isin(all_steps.t, few.t)], few.x)
    scipys = ph.simulate(system, 0.3, 0.1, method=ph.ScipyIVP("Radau", 1e-3, 1e-3), times=[0.15], save_every=1)
    np.testing.assert_allclose(scipys.t, both.t, rtol=1e-14)


@pytest.mark.parametrize("times", [[0.2, 0.1], [0.0, 0.1], [0.1, 0.5], [-0.1], [np.nan], [[0.1], [0.2]], [0.1, 0.1]])
def test_times_out_of_range(system, times):
    with pytest.raises(DataError, match="simulate times"):
        ph.simulate(system, 0.3, 0.02, times=times)


def test_times_that_are_none(system):
    with pytest.raises(ArgumentTypeError, match="simulate times"):
        ph.simulate(system, 0.3, 0.02, times="all")


# The past


def straight(t0: float, dt: float) -> Step:
    """A step along z = 1 + 2 t."""
    value = np.array([1.0 + 2.0 * (t0 + 0.5 * dt)])
    return Step(np.array([t0 + dt]), np.empty(0), value[None], np.empty((1, 0)), np.empty((1, 0)), dt, 0)


@pytest.mark.parametrize("back", [1, 2])
def test_straight_lines_are_continued_exactly(back):
    past, t = Past(), 0.0
    for dt in (0.1, 0.3, 0.2):
        last = straight(t, dt)
        past.add(last)
        t += dt
    assert past.middle(last.x, 0.15, back)[0] == pytest.approx(1.0 + 2.0 * (t + 0.075), rel=1e-14)
    past.add(straight(t, 0.15))  # rejected: the run goes on from where it was
    assert past.middle(last.x, 0.1, back)[0] == pytest.approx(1.0 + 2.0 * (t + 0.05), rel=1e-14)


def test_there_is_no_past_elsewhere():
    past = Past()
    assert past.middle(np.zeros(1), 0.1) is None
    steps = [straight(0.1 * k, 0.1) for k in range(3)]
    for step in steps:
        past.add(step)
    assert past.middle(steps[-1].x, 10.0) is None  # too far to extrapolate
    assert past.middle(steps[-1].x.copy(), 0.1) is None  # another run
    assert past.middle(steps[-1].x, 0.1) is None  # which has made us forget
