"""Error and time of every combination; what a row knows; runs that fail."""

import itertools
import math
from statistics import median

import numpy as np
import pytest

import phblocks as ph
from phblocks.studies import WorkPrecisionStudy, measurement, work_precision
from tests.studies import scenes
from tests.studies.rows import make_run

MASS = ("position", "mass", (0.0, 0.0))
TIP = ("position", "beam", 1.0)


@pytest.fixture(scope="module")
def pendulum():
    methods = {"midpoint": ph.Midpoint(), "loose": {"method": ph.Midpoint(newton=ph.Newton(tolerance=1e-5))}}
    return work_precision(
        scenes.pendulum,
        methods,
        [0.01, 0.02],
        [{"elements": 2, "degree": 1}, {"elements": 2, "degree": 2}],
        quantity=TIP,
        t_end=0.2,
        repeats=3,
    )


def test_one_row_a_combination(pendulum):
    assert len(pendulum) == 8
    settings = [(row.method, row.mesh, row.dt) for row in pendulum]
    meshes = ("elements=2, degree=1", "elements=2, degree=2")
    assert settings == list(itertools.product(("midpoint", "loose"), meshes, (0.02, 0.01)))
    assert pendulum.column("steps") == [10, 20] * 4
    assert pendulum.column("states") == [17, 17, 29, 29] * 2
    assert not any(pendulum.column("shared_machine"))
    assert pendulum[0].settings.startswith("method=Midpoint(newton=ModifiedNewton(tolerance=1e-15")


def test_a_row_can_be_run_again(pendulum):
    row = pendulum[3]
    assert row.mesh_arguments == {"elements": 2, "degree": 2}
    solution = ph.simulate(scenes.pendulum(**row.mesh_arguments), row.t_end, row.dt)
    assert pendulum.reference.error_of(solution.position("beam", 1.0)[-1:]) == pytest.approx(row.error)


def test_arguments_of_a_mesh():
    assert make_run("a", 1.0, mesh="default").mesh_arguments == {}
    assert make_run("a", 1.0, mesh="elements=(10, 6, 6), kind='fine'").mesh_arguments == {
        "elements": (10, 6, 6),
        "kind": "fine",
    }
    with pytest.raises(ph.errors.DataError, match="among the meshes"):
        make_run("a", 1.0, mesh="section=Section(1.0)").mesh_arguments  # noqa: B018


def test_measured_columns(pendulum):
    """What the methods differ in shows: a loose tolerance saves iterations and loses energy, and nothing else."""
    exact, loose = (pendulum.filter(method=name) for name in ("midpoint", "loose"))
    assert max(exact.column("energy_error")) < 1e-13 < min(loose.column("energy_error"))
    assert sum(loose.column("newton_iterations")) < sum(exact.column("newton_iterations"))
    np.testing.assert_allclose(loose.column("error"), exact.column("error"), rtol=1e-2)
    np.testing.assert_allclose(loose.column("gap"), exact.column("gap"), rtol=1e-2)
    for row in pendulum:
        assert 0.0 < row.seconds_min <= row.seconds <= row.seconds_max
        assert row.repeats == 3 and row.ok


def test_gap_is_that_of_the_two_positions(pendulum):
    """At both ends: at degree 1 also the pinned one moves, in the mean over its element only held."""
    solution = ph.simulate(scenes.pendulum(2, 1), 0.2, 0.02)
    places = [[solution.position("beam", s, source=source) for s in (0.0, 1.0)] for source in ("strain", "velocity")]
    assert pendulum[0].gap == pytest.approx(np.linalg.norm(np.subtract(*places), axis=-1).max(), rel=1e-9)


def test_reference_is_finer_than_all(pendulum):
    """Elements doubled, degree raised, step halved; its uncertainty covers what a much finer run says."""
    assert pendulum.reference.source == "Midpoint(), mesh elements=4, degree=3, dt = 0.005 s"
    truth = ph.simulate(scenes.pendulum(8, 4), 0.2, 0.001).position("beam", 1.0)[-1:]
    assert pendulum.reference.error_of(truth) <= pendulum.reference.uncertainty
    assert pendulum.reference.uncertainty < 0.3 * min(pendulum.column("error"))
    assert {row.reference_uncertainty for row in pendulum} == {pendulum.reference.uncertainty}


def test_the_method_of_highest_order_gives_the_reference():
    """In steps of its own, whatever else its entry asks for."""

    class Better(ph.Midpoint):
        order = 3

    methods = {"midpoint": ph.Midpoint(), "better": {"method": Better(), "max_halvings": 0}}
    study = work_precision(scenes.oscillator, methods, [0.1], quantity=MASS, t_end=1.0, repeats=1)
    assert study.reference.source == "Better(), mesh default, dt = 0.05 s"


def test_methods_without_an_order_give_no_reference():
    """Those choose their steps themselves: half the step would make them no better, and look certain."""
    with pytest.raises(ph.errors.StudyError, match="Give a reference"):
        work_precision(scenes.oscillator, {"own steps": object()}, [0.1], quantity=MASS, t_end=1.0)


def test_errors_against_a_reference_that_is_given():
    times = [0.5, 1.0]
    study = work_precision(
        scenes.oscillator,
        [ph.Midpoint()],
        [0.1, 0.05],
        quantity=MASS,
        t_end=1.0,
        times=times,
        reference=ph.studies.Reference([[scenes.exact(t), 0.0] for t in times], 1e-15, "by hand"),
        repeats=1,
    )
    expected = [max(abs(scenes.exact(t, dt) - scenes.exact(t)) for t in times) for dt in (0.1, 0.05)]
    np.testing.assert_allclose(study.column("error"), expected, rtol=1e-9)
    assert study[0].reference == "by hand" and study[0].method == "Midpoint()"


def test_runs_alternate_and_systems_are_made_once(monkeypatch):
    """Six timed runs of two settings, with the clock's median; a short run before each first one is not timed."""
    made, calls, clock = [], [], itertools.count()
    simulate = measurement.simulate

    def make(**mesh):
        made.append(mesh)
        return scenes.oscillator()

    def watched(system, t_end, dt, **arguments):
        calls.append((t_end, dt))
        return simulate(system, t_end, dt, **arguments)

    monkeypatch.setattr(measurement, "simulate", watched)
    monkeypatch.setattr(measurement, "perf_counter", lambda: float(next(clock) ** 2))
    study = work_precision(
        make, [ph.Midpoint()], [0.1, 0.05], quantity=MASS, t_end=1.0, reference=[[1.0, 0.0]], repeats=3
    )
    assert made == [{}]
    assert calls == [(0.1, 0.1), (1.0, 0.1), (0.05, 0.05), (1.0, 0.05)] + [(1.0, 0.1), (1.0, 0.05)] * 2
    # between calls 2k and 2k + 1 of the clock pass 4k + 1 seconds; the first setting has k = 0, 2, 4
    assert study[0].seconds == median((1.0, 9.0, 17.0)) and study[0].seconds_max == 17.0
    assert study[1].seconds == median((5.0, 13.0, 21.0))


@pytest.fixture(scope="module")
def own_steps():
    methods = {
        "equal": ph.GaussLegendre(),
        "adapted": {"method": ph.GaussLegendre(), "adaptive": ph.Adaptive(rtol=1.0, atol=0.5)},
        "Radau": ph.ScipyIVP("Radau"),
        "frozen": ph.LinearlyImplicit(),
    }
    meshes = [{"elements": 2, "degree": 2}, {"elements": 2, "degree": 3}]
    return work_precision(
        *(scenes.pendulum, methods, [0.02, 0.01], meshes),
        quantity=TIP,
        t_end=0.4,
        times=[0.16, 0.4],
        tolerances=[1e-2, 1e-4],
        repeats=1,
    )


def test_tolerances_in_place_of_steps(own_steps):
    """Runs that choose their steps are judged at the same times as the others, once a tolerance."""
    settings = [(row.mesh[-1], row.method, row.dt, row.rtol) for row in own_steps]
    for mesh in "23":
        assert [s[1:] for s in settings if s[0] == mesh] == [
            ("equal", 0.02, 0.0),
            ("equal", 0.01, 0.0),
            ("adapted", 0.02, 1e-2),
            ("adapted", 0.02, 1e-4),
            ("Radau", 0.02, 1e-2),
            ("Radau", 0.02, 1e-4),
            ("frozen", 0.02, 0.0),
            ("frozen", 0.01, 0.0),
        ]
    assert all(row.ok for row in own_steps)
    for method in ("adapted", "Radau"):
        loose, tight = own_steps.filter(method=method, mesh="elements=2, degree=3")
        assert tight.steps > loose.steps
    assert "rtol=0.0001, atol=5e-05," in own_steps.filter(method="adapted", rtol=1e-4)[0].settings
    assert "rtol = 0.0001: error" in str(own_steps.filter(method="adapted", rtol=1e-4)[0])
    assert own_steps.reference.source == "GaussLegendre(), mesh elements=4, degree=4, dt = 0.005 s"


def test_errors_at_named_times_follow_the_tolerance():
    """Against the solution by hand, beside equal steps."""
    times = [0.37, 1.0]
    study = work_precision(
        scenes.oscillator,
        {"equal": ph.GaussLegendre(), "adapted": {"adaptive": ph.Adaptive()}, "Radau": ph.ScipyIVP("Radau")},
        [0.01],
        quantity=MASS,
        t_end=1.0,
        times=times,
        tolerances=[1e-2, 1e-4, 1e-6],
        reference=[[scenes.exact(t), 0.0] for t in times],
        repeats=1,
    )
    assert study.column("rtol") == [0.0, *[1e-2, 1e-4, 1e-6] * 2]
    assert study[0].error < 1e-9
    for method in ("adapted", "Radau"):
        errors = study.filter(method=method).column("error")
        assert errors[0] > 5.0 * errors[1] > 25.0 * errors[2] > 0.0 and errors[2] < 1e-5


def test_a_row_with_a_tolerance_can_be_run_again(own_steps):
    row = own_steps.filter(method="adapted", rtol=1e-2, mesh="elements=2, degree=3")[0]
    adaptive = ph.Adaptive(row.rtol, atol=5e-3)
    solution = ph.simulate(
        *(scenes.pendulum(2, 3), 0.4, row.dt, ph.GaussLegendre()), adaptive=adaptive, times=[0.16, 0.4]
    )
    assert own_steps.reference.error_of(solution.position("beam", 1.0)[1:]) == pytest.approx(row.error, rel=1e-9)
    assert (solution.statistics.steps, solution.statistics.rejections) == (row.steps, row.rejections)


def test_energy_is_judged_at_all_steps_of_such_a_run(own_steps):
    row = own_steps.filter(method="Radau", rtol=1e-2)[0]
    solution = ph.simulate(
        *(scenes.pendulum(2, 2), 0.4, 0.02, ph.ScipyIVP("Radau", 1e-2, 1e-2)), times=[0.16, 0.4], save_every=1
    )
    assert measurement.energy_error(solution) == pytest.approx(row.energy_error, rel=1e-9)
    assert row.energy_error > 1e3 * max(own_steps.filter(method="adapted").column("energy_error"))


def test_lag_and_rejections_are_columns_where_there_are_any(own_steps, pendulum):
    header = str(own_steps).splitlines()[0]
    assert "rtol" in header and "lag" in header
    assert not any(word in str(pendulum).splitlines()[0] for word in ("rtol", "lag", "rejections", "halvings"))
    frozen = own_steps.filter(method="frozen")
    run = ph.simulate(scenes.pendulum(2, 2), 0.4, 0.02, ph.LinearlyImplicit())
    assert frozen[0].lag == pytest.approx(run.statistics.lag.max(), rel=1e-9)
    assert all(lag > 0.0 for lag in frozen.column("lag"))
    assert not any(own_steps.filter(lambda row: row.method != "frozen").column("lag"))
    hurried = work_precision(
        scenes.pendulum,
        {"adapted": {"adaptive": ph.Adaptive(1e-4)}},
        [0.2],
        quantity=TIP,
        t_end=0.2,
        reference=[[0.0, 0.0]],
        repeats=1,
    )
    assert hurried[0].rejections + hurried[0].halvings > 0
    assert ("rejections" in str(hurried)) is (hurried[0].rejections > 0)


def test_failed_runs_are_rows():
    """Newton's method is not given the iterations it needs at large steps."""
    study = work_precision(
        scenes.picky,
        {"hasty": ph.Midpoint(newton=ph.Newton(max_iterations=3)), "midpoint": ph.Midpoint()},
        [0.1, 0.001],
        [{"elements": 5}, {"elements": 4}],
        quantity=TIP,
        t_end=0.1,
        reference=[[1.0, 0.0]],
        repeats=2,
        max_halvings=0,
    )
    assert study.filter(mesh="elements=5").column("status") == ["ValueError"] * 4
    by_setting = {(row.method, row.dt): row for row in study.filter(mesh="elements=4")}
    failed = by_setting["hasty", 0.1]
    assert failed.status == "step failed" and "Newton" in failed.status_text
    assert math.isnan(failed.error) and not failed.ok
    assert all(row.ok for setting, row in by_setting.items() if setting != ("hasty", 0.1))
    assert len(study.front) and all(row.ok for row in study.front)


def test_times_that_are_not_saved():
    study = work_precision(
        scenes.oscillator, [None], [0.3], quantity=MASS, t_end=0.9, times=[0.5], reference=[[1.0, 0.0]], repeats=1
    )
    assert study[0].status == "DataError" and "Use steps that divide them" in study[0].status_text


def test_a_reference_that_fails():
    with pytest.raises(ph.errors.StudyError, match="five is right out"):
        work_precision(scenes.picky, [None], [0.05], [{"elements": 5}], quantity=TIP, t_end=0.1)


def test_csv(pendulum, tmp_path):
    again = WorkPrecisionStudy.from_csv(pendulum.to_csv(tmp_path / "study.csv"))
    assert again == pendulum and again.reference is None


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"methods": [ph.Midpoint(), ph.Midpoint()]}, ph.errors.DataError, "different names"),
        ({"methods": []}, ph.errors.DataError, "one or more"),
        ({"methods": ph.Midpoint()}, ph.errors.ArgumentTypeError, "a list of methods"),
        ({"methods": {"a": {"metod": 1}}}, ph.errors.UnknownNameError, "method"),
        ({"steps": []}, ph.errors.DataError, "1 or more"),
        ({"meshes": {"elements": 4}}, ph.errors.ArgumentTypeError, "a list of dicts"),
        ({"meshes": []}, ph.errors.DataError, "one or more"),
        ({"repeats": -1}, ph.errors.DataError, ">= 0"),
        ({"t_end": "1"}, ph.errors.ArgumentTypeError, "real number"),
        ({"tolerances": []}, ph.errors.DataError, "1 or more"),
        ({"tolerances": [1e-3, -1e-4]}, ph.errors.DataError, "> 0"),
        (
            {"tolerances": [1e-3], "methods": {"a": {"adaptive": ph.Adaptive(rtol=0.0, atol=1.0)}}},
            ph.errors.DataError,
            "rtol > 0",
        ),
    ],
)
def test_arguments(change, error, message):
    given = {"methods": [None], "steps": [0.1], "quantity": MASS, "t_end": 1.0, **change}
    with pytest.raises(error, match=message):
        work_precision(scenes.oscillator, **given)
