"""Energies and balances on paper are those of the solution."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import phblocks as ph
from phblocks import plots


@pytest.fixture(scope="module")
def solution(four_bar):
    return ph.simulate(four_bar().compile(), t_end=0.5, dt=0.02)


@pytest.fixture(scope="module")
def pushed(bar):
    """Without gravity, from outside."""
    d = ph.Diagram("pushed")
    beam = d.add(ph.Beam("beam", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(beam.start, d.ground)
    d.expose(beam.end.translation, "push")
    return ph.simulate(d.compile(), t_end=0.2, dt=0.01, inputs={"push": (0.0, 50.0)})


def lines(ax):
    return {line.get_label(): line for line in ax.lines}


def test_series(solution):
    ax = plots.energy(solution)
    drawn = lines(ax)
    assert list(drawn) == ["kinetic", "strain", "gravity", "total"]
    for name, line in drawn.items():
        np.testing.assert_array_equal(line.get_xdata(), solution.t)
        np.testing.assert_array_equal(line.get_ydata(), solution.energy[name])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time (s)", "energy (J)")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == list(drawn)


def test_what_is_zero_throughout_is_left_out(pushed):
    assert list(lines(plots.energy(pushed))) == ["kinetic", "strain", "supplied", "total"]


def test_increments(solution):
    ax = plots.energy(solution, increments=True)
    error = solution.recording.ledger.balance_error[1:]
    steps = lines(ax)["each step"]
    np.testing.assert_array_equal(steps.get_ydata(), error[error > 0.0])
    np.testing.assert_array_equal(steps.get_xdata(), solution.t[1:][error > 0.0])
    assert ax.get_yscale() == "log"
    assert ax.get_ylabel() == "|ΔH − supplied + losses| (J)"
    [level] = set(lines(ax)["round-off of largest energy"].get_ydata())
    assert level == np.finfo(float).eps * np.abs(list(solution.energy.values())).max()


def test_nothing_moves(four_bar):
    """No energy has no logarithm."""
    still = ph.simulate(four_bar(gravity=None).compile(), t_end=0.1, dt=0.05)
    assert list(lines(plots.energy(still))) == ["total"]
    ax = plots.energy(still, increments=True)
    ax.figure.draw_without_rendering()
    assert ax.get_yscale() == "linear"


def test_draws_where_asked(solution):
    _, ax = plt.subplots()
    assert plots.energy(solution, ax=ax) is ax


def test_no_solution(four_bar):
    with pytest.raises(ph.errors.ArgumentTypeError, match="System"):
        plots.energy(four_bar().compile())
