"""Runs side by side: what is drawn is the difference of their arrays."""

import numpy as np
import pytest

import phblocks as ph
from phblocks import plots


@pytest.fixture(scope="module")
def diagram(four_bar):
    return four_bar()


@pytest.fixture(scope="module")
def runs(diagram, four_bar):
    return {
        "fine": ph.simulate(diagram.compile(), t_end=0.4, dt=0.01),
        "coarse": ph.simulate(diagram.compile(), t_end=0.4, dt=0.02),
        "more elements": ph.simulate(four_bar((8, 6, 6)).compile(), t_end=0.4, dt=0.02),
    }


def lines(ax):
    return {line.get_label(): line for line in ax.lines}


def test_a_path(runs, diagram):
    """Looked up by name, so that another mesh has it too."""
    left, right = plots.comparison(runs, diagram.network.blocks["coupler"].at(0.5)).axes
    for name, solution in runs.items():
        np.testing.assert_array_equal(lines(left)[name].get_xydata(), solution.position("coupler", 0.5))
    assert list(lines(right)) == ["coarse", "more elements"]
    fine = runs["fine"].position("coupler", 0.5)[::2]
    for name, line in lines(right).items():
        apart = np.linalg.norm(runs[name].position("coupler", 0.5) - fine, axis=1)
        np.testing.assert_array_equal(line.get_ydata(), apart[apart > 0.0])
        np.testing.assert_array_equal(line.get_xdata(), runs[name].t[apart > 0.0])
    assert (left.get_xlabel(), left.get_ylabel()) == ("x (m)", "y (m)")
    assert right.get_ylabel() == "distance from 'fine' (m)"


@pytest.mark.parametrize(("quantity", "unit"), [("strain", "J"), ("crank.V1[0]", "m/s")])
def test_energies_and_states(runs, quantity, unit):
    two = {name: runs[name] for name in ("fine", "coarse")}
    left, right = plots.comparison(two, quantity, unit="" if unit == "J" else unit).axes
    a, b = (s.energy[quantity] if quantity == "strain" else s.state(quantity) for s in two.values())
    np.testing.assert_array_equal(lines(left)["fine"].get_ydata(), a)
    apart = np.abs(b - a[::2])
    np.testing.assert_array_equal(lines(right)["coarse"].get_ydata(), apart[apart > 0.0])
    assert left.get_ylabel() == f"{quantity} ({unit})"


def test_a_function(runs):
    two = {name: runs[name] for name in ("fine", "coarse")}
    left, right = plots.comparison(two, lambda s: s.velocity("coupler", 0.5), unit="m/s").axes
    assert len(left.lines) == 4  # two components each
    apart = np.linalg.norm(runs["coarse"].velocity("coupler", 0.5) - runs["fine"].velocity("coupler", 0.5)[::2], axis=1)
    np.testing.assert_array_equal(lines(right)["coarse"].get_ydata(), apart[apart > 0.0])
    assert right.get_ylabel() == "distance from 'fine' (m/s)"


def test_the_same_twice(runs):
    """No distance has no logarithm."""
    figure = plots.comparison({"a": runs["fine"], "b": runs["fine"]}, "strain")
    figure.draw_without_rendering()
    assert figure.axes[1].get_yscale() == "linear"


def test_wrong_arguments(runs, diagram):
    point = diagram.network.blocks["coupler"].at(0.5)
    with pytest.raises(ph.errors.DataError, match="two solutions"):
        plots.comparison({"fine": runs["fine"]}, point)
    with pytest.raises(ph.errors.ArgumentTypeError):
        plots.comparison(list(runs.values()), point)
    with pytest.raises(ph.errors.ArgumentTypeError):
        plots.comparison(runs, 3.0)
    with pytest.raises(ph.errors.ArgumentTypeError, match="Solution"):
        plots.comparison({"a": runs["fine"], "b": diagram}, point)
    with pytest.raises(ph.errors.UnknownNameError):
        plots.comparison(runs, "heat")
    with pytest.raises(ph.errors.DataError, match="shape"):
        plots.comparison(runs, lambda s: 1.0)
    elsewhere = ph.simulate(diagram.compile(), t_end=0.033, dt=0.007)
    with pytest.raises(ph.errors.DataError, match="in common"):
        plots.comparison({"fine": runs["fine"], "other": elsewhere}, "strain")
