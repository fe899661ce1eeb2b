"""Orders of scenes whose errors are known."""

import math

import numpy as np
import pytest

import phblocks as ph
from phblocks.studies import ConvergenceStudy, convergence
from tests.studies import scenes

STEPS = [0.2, 0.1, 0.05, 0.025]
MASS = ("position", "mass", (0.0, 0.0))


@pytest.fixture(scope="module")
def steps():
    return convergence(scenes.oscillator, "dt", STEPS, quantity=MASS, t_end=1.0, reference=[[scenes.exact(1.0), 0.0]])


def test_errors_in_time_are_those_of_the_midpoint_rule(steps):
    """By hand: it turns by 2 atan(omega dt / 2) a step."""
    expected = [abs(scenes.exact(1.0, dt) - scenes.exact(1.0)) for dt in STEPS]
    np.testing.assert_allclose(steps.column("error"), expected, rtol=1e-9)


def test_order_in_time(steps):
    assert steps.order == pytest.approx(2.0, abs=0.01)
    assert steps.column("rate")[1:] == pytest.approx([2.0] * 3, abs=0.02)
    assert all(steps.column("fitted"))
    assert "Fitted order over 4 runs: 1.99" in str(steps) or "Fitted order over 4 runs: 2.00" in str(steps)


def test_what_a_row_says(steps):
    row = steps[1]
    assert (row.over, row.value, row.size, row.dt, row.steps) == ("dt", "0.1", 0.1, 0.1, 10)
    assert (row.status, row.unit, row.method, row.repeats) == ("success", "m", "default", 1)
    assert row.quantity == "position of 'mass' at (0.0, 0.0)"
    assert row.numpy == np.__version__ and row.cores >= 1 and row.seconds > 0.0
    assert row.energy_error < 1e-12
    assert math.isnan(row.reference_uncertainty)


def test_reference_from_the_study_itself():
    """Measured: it is off by 1.6e-7 m, says 2.6e-6 m, and the finest run is off by 3.8e-5 m."""
    study = convergence(scenes.oscillator, "dt", STEPS[::-1], quantity=MASS, t_end=1.0)
    truth = np.array([[scenes.exact(1.0), 0.0]])
    assert study.reference.error_of(truth) <= study.reference.uncertainty < 0.1 * study[-1].error
    assert study.order == pytest.approx(2.0, abs=0.02)
    assert study.column("value") == [str(h) for h in STEPS]  # from coarse to fine


def test_several_times_and_a_function():
    times = [0.4, 1.0]
    study = convergence(
        scenes.oscillator,
        "dt",
        STEPS[:3],
        quantity=scenes.place_of_mass,
        unit="m",
        t_end=1.0,
        times=times,
        reference=[scenes.exact(t) for t in times],
    )
    expected = [max(abs(scenes.exact(t, dt) - scenes.exact(t)) for t in times) for dt in STEPS[:3]]
    np.testing.assert_allclose(study.column("error"), expected, rtol=1e-9)
    assert study[0].quantity == "place_of_mass" and study[0].unit == "m"


def test_order_in_the_elements(references):
    """Frequencies converge with order 2 k (the beam: references.json); measured 1.98."""
    study = convergence(
        scenes.cantilever,
        "elements",
        [16, 32, 64],
        quantity=scenes.first_frequency,
        unit="rad/s",
        t_end=1e-3,
        dt=1e-3,
        mesh={"degree": 1},
        reference=references["timoshenko_frequencies_rad_s"]["modes"]["clamped-free"][0],
    )
    assert study.order == pytest.approx(2.0, abs=0.03)
    assert study.column("size") == [1 / 16, 1 / 32, 1 / 64]
    assert study[2].mesh == "degree=1, elements=64"


def test_over_the_degree(references):
    study = convergence(
        scenes.cantilever,
        "degree",
        [1, 2, 3],
        quantity=scenes.first_frequency,
        t_end=1e-3,
        dt=1e-3,
        mesh={"elements": 2},
        reference=references["timoshenko_frequencies_rad_s"]["modes"]["clamped-free"][0],
    )
    assert study.rate > 10.0
    assert study[2].rate == pytest.approx(study[1].error / study[2].error)
    assert "falls by" in str(study)
    with pytest.raises(ph.errors.StudyError, match=r"study\.rate"):
        study.order  # noqa: B018


def test_no_rate_over_steps(steps):
    with pytest.raises(ph.errors.StudyError, match=r"study\.order"):
        steps.rate  # noqa: B018


def test_two_runs_are_no_proof(steps):
    assert "do not rely on it" not in str(steps)
    assert "do not rely on it" in str(steps.filter(lambda row: row.dt <= 0.05))


def test_csv_keeps_the_fit(steps, tmp_path):
    again = ConvergenceStudy.from_csv(steps.to_csv(tmp_path / "steps.csv"))
    assert again.order == steps.order
    assert again.column("error") == steps.column("error")


def test_a_run_that_fails_is_a_row():
    study = convergence(scenes.picky, "elements", [4, 5, 6, 8], quantity=("position", "beam", 1.0), t_end=0.1, dt=0.02)
    assert study.column("status") == ["success", "ValueError", "success", "success"]
    assert math.isnan(study[1].error) and study[1].status_text == "five is right out"
    assert "five is right out" in str(study)


def test_too_few_runs_for_a_reference():
    with pytest.raises(ph.errors.StudyError, match="five is right out"):
        convergence(scenes.picky, "elements", [4, 5, 6], quantity=("position", "beam", 1.0), t_end=0.1, dt=0.02)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"over": "mass"}, ph.errors.DataError, '"dt", "elements" or "degree"'),
        ({"values": [0.1, 0.05]}, ph.errors.DataError, "3 or more"),
        ({"values": [0.1, 0.1, 0.05]}, ph.errors.DataError, "different"),
        ({"values": [0.1, 0.05, -0.1]}, ph.errors.DataError, "> 0"),
        ({"values": 0.1}, ph.errors.ArgumentTypeError, "list"),
        ({"dt": 0.1}, ph.errors.DataError, "none over dt"),
        ({"over": "degree", "values": [1, 2, 3]}, ph.errors.DataError, "a step over anything else"),
        ({"over": "degree", "values": [1, 2, 2.5]}, ph.errors.DataError, "integers"),
        ({"over": "elements", "values": [1, 2, 2.5]}, ph.errors.ArgumentTypeError, "elements"),
        ({"quantity": ("speed", "mass", 0.0)}, ph.errors.DataError, "position"),
        ({"quantity": "position"}, ph.errors.ArgumentTypeError, "a function of a Solution"),
        ({"times": [2.0]}, ph.errors.DataError, "from 0 to 1 s"),
        ({"make_system": 3}, ph.errors.ArgumentTypeError, "a function that returns a System"),
        ({"adaptive": ph.Adaptive()}, ph.errors.DataError, "equal steps, got Adaptive"),
        ({"method": ph.ScipyIVP()}, ph.errors.DataError, "equal steps, got ScipyIVP"),
        ({"save_evry": 2}, ph.errors.UnknownNameError, "save_every"),
        ({"reference": [0.0]}, ph.errors.DataError, "shape of the quantity"),
        ({"executor": "processes"}, ph.errors.ArgumentTypeError, "concurrent.futures"),
    ],
)
def test_arguments(change, error, message):
    given = {"make_system": scenes.oscillator, "over": "dt", "values": STEPS, "quantity": MASS, "t_end": 1.0, **change}
    with pytest.raises(error, match=message):
        convergence(**given)
