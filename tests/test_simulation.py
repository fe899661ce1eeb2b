"""The time loop: times, saving, statuses, halving, and everything it refuses."""

import dataclasses
import math

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, UnknownNameError
from phblocks.solvers.midpoint import MidpointStepper


@pytest.fixture(scope="module")
def system(bar) -> ph.System:
    """A pendulum of one beam with a force at its tip."""
    d = ph.Diagram("pendulum", gravity=(0.0, -9.81))
    b = d.add(ph.Beam("b", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(b.start, d.ground)
    d.expose(b.end.translation, "tip")
    return d.compile()


def run(system: ph.System, **options) -> ph.Solution:
    return ph.simulate(system, **({"t_end": 0.2, "dt": 0.02} | options))


# Times


def test_every_step_is_saved_at_its_time(system):
    solution = run(system)
    np.testing.assert_array_equal(solution.t, [*(k * 0.02 for k in range(10)), 0.2])
    assert solution.x.shape == (11, system.n)
    assert solution.status.ok and solution.status.name == "success" and solution.status.time is None
    assert solution.statistics.steps == 10 == solution.statistics.newton_iterations.size
    assert solution.statistics.halvings == 0


def test_the_last_step_is_shorter_if_dt_does_not_divide_the_duration(system):
    solution = run(system, t_end=0.07, dt=0.02)
    np.testing.assert_allclose(solution.t, [0.0, 0.02, 0.04, 0.06, 0.07], rtol=1e-15)
    # the same as two runs, the second with the short step
    first = run(system, t_end=0.06, dt=0.02)
    state = ph.State(first.x[-1], first.recording.theta[-1], first.recording.points[-1])
    second = run(system, t_end=0.01, dt=0.01, start=state)
    np.testing.assert_allclose(solution.x[-1], second.x[-1], rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize(("t_end", "dt", "steps"), [(0.3, 0.1, 3), (0.1, 0.1, 1), (0.7, 0.1, 7), (1e-3, 1e-3 / 3, 3)])
def test_round_off_makes_no_extra_step(system, t_end, dt, steps):
    solution = run(system, t_end=t_end, dt=dt)
    assert solution.statistics.steps == steps and solution.t[-1] == t_end


@pytest.mark.parametrize(
    ("save_every", "saved"), [(1, range(11)), (3, (0, 3, 6, 9, 10)), (5, (0, 5, 10)), (10, (0, 10)), (99, (0, 10))]
)
def test_saving_less_keeps_the_same_run(system, save_every, saved):
    everything, some = run(system), run(system, save_every=save_every)
    np.testing.assert_array_equal(some.t, everything.t[list(saved)])
    np.testing.assert_array_equal(some.x, everything.x[list(saved)])
    np.testing.assert_array_equal(some.recording.points, everything.recording.points[list(saved)])
    assert some.statistics.steps == 10
    assert some.max_power_balance_error == everything.max_power_balance_error
    for name, series in everything.energy.items():
        np.testing.assert_allclose(some.energy[name], series[list(saved)], rtol=1e-13, atol=1e-13)


def test_inputs_are_evaluated_in_the_middle_of_each_step(system):
    times: list[float] = []

    def tip(t: float) -> tuple[float, float]:
        times.append(t)
        return 0.0, 0.0

    run(system, inputs={"tip": tip})
    np.testing.assert_allclose(times[1:], 0.01 + 0.02 * np.arange(10), rtol=1e-14)  # and once before, for its shape
    assert times[0] == 0.0


def test_two_runs_are_the_same(system):
    np.testing.assert_array_equal(run(system).x, run(system).x)


# Starts


def test_a_start_is_where_the_run_begins(system):
    start = dataclasses.replace(system.start, x=system.rigid_motion(spin=1.0).x)
    solution = run(system, start=start)
    np.testing.assert_array_equal(solution.x[0], start.x)
    assert solution.energy.kinetic[0] == pytest.approx(system.energy(start.x), rel=1e-14)
    assert solution.energy.kinetic[0] == pytest.approx(0.5 * 6.775 / 3, rel=0.05)  # two elements of degree 1
    np.testing.assert_array_equal(system.start.x, 0.0)  # the system is not touched


def test_a_start_may_be_lists_and_whole_numbers(system):
    start = system.start
    lists = ph.State(start.x.tolist(), start.theta.tolist(), start.points.tolist())
    whole = ph.State(start.x.astype(int), start.theta.astype(int), start.points)
    for same in (lists, whole):
        np.testing.assert_array_equal(run(system, start=same).x, run(system).x)


@pytest.mark.parametrize("name", ["x", "theta", "points"])
def test_starts_of_wrong_shape_or_value(system, name):
    good = getattr(system.start, name)
    for wrong, got in (
        (good[:-1], "shape"),
        (good.ravel()[None], "shape"),
        (np.full(good.shape, np.nan), "not finite"),
    ):
        with pytest.raises(DataError, match=rf"simulate start\.{name}.*{got}.*Start from system\.start"):
            run(system, start=dataclasses.replace(system.start, **{name: wrong}))
    for kind in ("a", None, [[1.0], [1.0, 2.0]], good + 0j):
        with pytest.raises(ArgumentTypeError, match=rf"simulate start\.{name}"):
            run(system, start=dataclasses.replace(system.start, **{name: kind}))


@pytest.mark.parametrize("start", [1, "rest", np.zeros(3), {}])
def test_starts_that_are_none(system, start):
    with pytest.raises(ArgumentTypeError, match=r"simulate start: expected a State.*ph\.State"):
        run(system, start=start)


# Bad arguments


@pytest.mark.parametrize("dt", [0.0, 1e-250, -0.01, math.nan, math.inf, -math.inf])
def test_steps_that_are_none(system, dt):
    with pytest.raises(DataError, match="simulate dt: expected a time > 0 s"):
        run(system, dt=dt)


@pytest.mark.parametrize("t_end", [0.0, -1.0, 0.019, math.nan, math.inf])
def test_durations_shorter_than_a_step(system, t_end):
    with pytest.raises(DataError, match=r"simulate t_end: expected at least one step, 0\.02 s"):
        run(system, t_end=t_end)


@pytest.mark.parametrize("name", ["dt", "t_end"])
@pytest.mark.parametrize("value", ["0.1", None, True, 1j, np.complex128(1.0), [0.1], np.array([0.1])])
def test_times_that_are_no_numbers(system, name, value):
    with pytest.raises(ArgumentTypeError, match=f"simulate {name}: expected a number, s"):
        run(system, **{name: value})


@pytest.mark.parametrize(("name", "least", "more"), [("save_every", 1, ()), ("max_halvings", 0, (None,))])
def test_whole_numbers(system, name, least, more):
    assert run(system, **{name: np.int64(least + 1)}).status.ok
    with pytest.raises(DataError, match=rf"simulate {name}: expected an integer >= {least}"):
        run(system, **{name: least - 1})
    for value in (1.5, "1", True, *more):
        with pytest.raises(ArgumentTypeError, match=f"simulate {name}"):
            run(system, **{name: value})


@pytest.mark.parametrize("method", ["midpoint", 1, ph.Midpoint, ph.Newton()])
def test_methods_that_are_none(system, method):
    with pytest.raises(ArgumentTypeError, match=r"simulate method.*ph\.Midpoint\(\)"):
        run(system, method=method)


@pytest.mark.parametrize("thing", [None, 1, ph.Diagram()])
def test_systems_that_are_none(thing):
    with pytest.raises(ArgumentTypeError, match=r"expected a System.*compile\(\)"):
        ph.simulate(thing, t_end=1.0, dt=0.1)


def test_inputs_are_checked_before_the_run(system):
    with pytest.raises(UnknownNameError, match="got 'top'"):
        run(system, inputs={"top": (0.0, 0.0)})
    with pytest.raises(DataError, match=r"shape \(2,\), got shape \(3,\)"):
        run(system, inputs={"tip": lambda t: (0.0, 0.0, 0.0)})


# Runs that end early


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_signal_that_is_not_finite_stops_the_run_with_the_results_so_far(system, bad):
    solution = run(system, inputs={"tip": lambda t: (0.0, bad if t > 0.1 else 1.0)})
    status = solution.status
    assert not status.ok and status.name == "input not finite"
    assert status.time == pytest.approx(0.11)
    assert "'tip'" in status.text and "t = 0.11 s" in status.text and "kept" in str(status)
    np.testing.assert_allclose(solution.t, 0.02 * np.arange(6))
    good = run(system, t_end=0.1, inputs={"tip": (0.0, 1.0)})
    np.testing.assert_allclose(solution.x, good.x, rtol=1e-12, atol=1e-12)
    assert np.isfinite(solution.position("b", 1.0)).all()
    assert solution.max_power_balance_error < 1e-12


def test_a_signal_that_is_not_finite_at_once_leaves_the_start(system):
    solution = run(system, inputs={"tip": lambda t: (math.nan, 0.0)})
    assert not solution.status.ok and solution.t.tolist() == [0.0] and solution.statistics.steps == 0
    np.testing.assert_allclose(solution.position("b", 1.0), [[1.0, 0.0]], atol=1e-14)
    assert "0 steps" in str(solution.statistics) and solution.max_power_balance_error == 0.0


@pytest.mark.parametrize(
    ("method", "adaptive"),
    [
        (ph.Midpoint(), None),
        (ph.GaussLegendre(), None),
        (ph.Midpoint(), ph.Adaptive(1e-3, atol=1.0)),
        (ph.ScipyIVP(), None),
    ],
)
def test_an_exception_of_the_users_function_ends_the_run_with_the_results_so_far(system, method, adaptive):
    def broken(t: float) -> tuple[float, float]:
        if t > 0.1:
            raise RuntimeError("sensor lost")
        return 0.0, 1.0

    solution = run(system, inputs={"tip": broken}, method=method, adaptive=adaptive)
    status = solution.status
    assert not status.ok and status.name == "input failed" and 0.1 < status.time < 0.2
    assert "'tip'" in status.text and f"t = {status.time:.9g} s: RuntimeError: sensor lost" in status.text
    assert isinstance(status.error, RuntimeError) and status.error.__traceback__ is not None
    assert 0.05 < solution.t[-1] < status.time and np.isfinite(solution.position("b", 1.0)).all()
    if method == ph.Midpoint() and adaptive is None:
        good = run(system, t_end=0.1, inputs={"tip": (0.0, 1.0)})
        np.testing.assert_allclose(solution.x, good.x, rtol=1e-12, atol=1e-12)


def test_a_signal_that_changes_its_shape_ends_the_run_likewise(system):
    solution = run(system, inputs={"tip": lambda t: (0.0, 1.0) if t < 0.1 else 1.0})
    assert solution.status.name == "input failed" and isinstance(solution.status.error, DataError)
    assert solution.t[-1] == pytest.approx(0.1) and "got shape ()" in solution.status.text


def test_a_start_that_violates_constraints_and_an_input_that_fails(bar):
    """The first thing that needs the input is the projection of the start; the first step says what is wrong."""
    d = ph.Diagram("pendulum")
    body = d.add(ph.RigidBody("body", 1.0, 0.1, (1.0, 0.0), {"pin": (0.0, 0.0)}))
    d.pin(body["pin"], d.ground, multiplier=True)
    d.expose(body.centre.translation, "push")
    calls = []

    def push(t: float) -> tuple[float, float]:
        calls.append(t)
        if len(calls) > 1:
            raise ValueError("once only")
        return 0.0, 1.0

    solution = ph.simulate(d.compile(), 0.1, 0.01, inputs={"push": push})
    assert solution.status.name == "input failed" and solution.t.tolist() == [0.0]


def test_a_stop_by_hand_comes_through(system):
    def stopped(t: float) -> tuple[float, float]:
        if t > 0.1:
            raise KeyboardInterrupt
        return 0.0, 0.0

    with pytest.raises(KeyboardInterrupt):
        run(system, inputs={"tip": stopped})


# Halving, with a stepper that refuses long steps


@pytest.fixture
def longest(monkeypatch, without_numba) -> dict[str, float]:
    """Make steps longer than ``limit["dt"]`` fail; ``limit`` also collects what was tried and taken."""
    limit = {"dt": math.inf, "tried": [], "taken": []}
    true_step = MidpointStepper.step

    def step(self, x, theta, dt, u, guess=None):
        limit["tried"].append(dt)
        if dt > limit["dt"] * (1 + 1e-12):
            return None
        limit["taken"].append(dt)
        return true_step(self, x, theta, dt, u, guess)

    monkeypatch.setattr(MidpointStepper, "step", step)
    return limit


def test_a_failed_step_is_halved_and_counted(system, longest):
    longest["dt"] = 0.01
    solution = run(system, t_end=0.08, dt=0.04)
    assert solution.status.ok
    # each 0.04 fails, 0.02 fails, it goes on in steps of 0.01, and the second half is tried at 0.02 again
    assert solution.statistics.halvings == 6
    np.testing.assert_allclose(longest["taken"], [0.01] * 8)
    assert solution.statistics.steps == 8
    np.testing.assert_array_equal(solution.t, [0.0, 0.04, 0.08])  # what was asked for
    np.testing.assert_allclose(solution.x[-1], run(system, t_end=0.08, dt=0.01).x[-1], rtol=1e-12, atol=1e-9)
    assert len(longest["tried"]) == 14 + 8


def test_what_is_left_is_tried_in_longer_steps_again(system, longest, monkeypatch):
    longest["dt"] = 0.02
    true_step = MidpointStepper.step

    def step(self, *arguments):
        taken = true_step(self, *arguments)
        longest["dt"] = math.inf  # only the very beginning is difficult
        return taken

    monkeypatch.setattr(MidpointStepper, "step", step)
    longest["dt"] = 0.01
    solution = run(system, t_end=0.08, dt=0.08)
    np.testing.assert_allclose(longest["taken"], [0.04, 0.04])
    assert solution.statistics.halvings == 1


def test_halving_that_does_not_help_ends_the_run_with_the_results_so_far(system, longest):
    longest["dt"] = 0.0
    solution = run(system, max_halvings=3)
    status = solution.status
    assert not status.ok and status.name == "step failed" and status.time == 0.0
    np.testing.assert_allclose(longest["tried"], [0.02, 0.01, 0.005, 0.0025])
    assert "halved to 0.0025 s" in status.text and "max_halvings" in status.text
    assert solution.t.tolist() == [0.0] and solution.statistics.halvings == 3 and solution.statistics.steps == 0


def test_no_halving_if_none_is_allowed(system, longest):
    longest["dt"] = 0.01
    solution = run(system, max_halvings=0)
    assert solution.status.name == "step failed" and longest["tried"] == [0.02]


def test_what_was_saved_before_a_failure_is_kept(system, longest, monkeypatch):
    true_step = MidpointStepper.step

    def step(self, *arguments):
        if len(longest["taken"]) == 4:
            longest["dt"] = 0.0
        return true_step(self, *arguments)

    monkeypatch.setattr(MidpointStepper, "step", step)
    solution = run(system, max_halvings=2)
    np.testing.assert_allclose(solution.t, 0.02 * np.arange(5))
    assert solution.status.time == pytest.approx(0.08)
    assert solution.energy.total[-1] == pytest.approx(solution.energy.total[0], abs=1e-11)


def test_a_progress_bar_only_if_asked_for(system, capsys):
    run(system, progress=False)
    assert capsys.readouterr().err == ""


def test_a_system_without_states_is_refused():
    d = ph.Diagram("nothing that moves")
    force = d.add(ph.Force("push", (1.0, 0.0)))
    d.connect(force.port, d.ground.translation)
    with pytest.raises(ph.PhblocksError):
        ph.simulate(d.compile(), 1.0, 0.1)


def test_a_start_whose_energy_is_no_number_is_refused():
    """1e300 m/s is a number, half its square is not."""
    d = ph.Diagram("fast")
    d.add(ph.Mass("mass", 1.0, (0.0, 0.0)))
    system = d.compile()
    with pytest.raises(ph.errors.DataError, match="finite energy"):
        ph.simulate(system, 1.0, 0.1, start=system.rigid_motion((1e300, 0.0)))


def test_an_energy_that_grows_past_all_numbers_ends_the_run():
    """2e153 N give 1 kg some 1.3e154 m/s in 6.7 s: the square of that is no number any more."""
    d = ph.Diagram("fast")
    mass = d.add(ph.Mass("mass", 1.0, (0.0, 0.0)))
    force = d.add(ph.Force("force", (2e153, 0.0)))
    d.connect(mass.centre.translation, force.port)
    run = ph.simulate(d.compile(), 10.0, 0.1)
    assert run.status.name == "step failed" and 6.0 < run.status.time < 7.0
    assert "too large" in run.status.text
    assert np.isfinite(run.x).all() and np.isfinite(run.energy.total).all()


@pytest.mark.parametrize(("t_end", "dt"), [(10**400, 0.1), (1.0, 10**400)])
def test_whole_numbers_too_large_for_floats(t_end, dt):
    d = ph.Diagram("mass")
    d.add(ph.Mass("mass", 1.0, (0.0, 0.0)))
    with pytest.raises(ph.errors.DataError):
        ph.simulate(d.compile(), t_end, dt)
