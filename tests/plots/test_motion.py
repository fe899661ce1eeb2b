"""Snapshots and paths on paper are the positions of the solution."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest

import phblocks as ph
from phblocks import plots


@pytest.fixture(scope="module")
def diagram(four_bar):
    return four_bar()


@pytest.fixture(scope="module")
def coupler(diagram):
    return diagram.network.blocks["coupler"]


@pytest.fixture(scope="module")
def solution(diagram):
    return ph.simulate(diagram.compile(), t_end=1.0, dt=0.02)


def lines(ax):
    return {line.get_label(): line for line in ax.lines}


def test_snapshots(solution):
    ax = plots.motion(solution, times=[0.5, 1.0])
    drawn = lines(ax)
    assert [label for label in drawn if not label.startswith("_")] == ["start", "t = 0.5 s", "t = 1 s", "ground"]
    for label, i in (("start", 0), ("t = 0.5 s", 25), ("t = 1 s", 50)):
        pieces = [
            [*(solution.position(name, s)[i] for s in np.linspace(0.0, 1.0, 21)), np.full(2, np.nan)]
            for name in ("crank", "coupler", "rocker")
        ]
        np.testing.assert_array_equal(drawn[label].get_xydata(), np.concatenate(pieces))
    assert drawn["start"].get_linestyle() == "--"
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x (m)", "y (m)")
    assert ax.get_aspect() == 1.0


def test_ground_and_joints(solution):
    ax = plots.motion(solution, times=1.0)
    ground = lines(ax)["ground"]
    np.testing.assert_array_equal(ground.get_xydata(), [[0.0, 0.5], [2.5, 0.5]])
    [joints] = [line for line in ax.lines if line.get_marker() == "o"]
    places = [("crank", 0.0), ("crank", 1.0), ("coupler", 1.0), ("rocker", 1.0)]
    np.testing.assert_array_equal(joints.get_xydata(), [solution.position(*place)[-1] for place in places])


def test_bent_shapes(bar):
    """A clamped beam under a load is drawn through its middle, not as a chord."""
    d = ph.Diagram("cantilever")
    beam = d.add(ph.Beam("beam", bar, (0.0, 0.0), (3.0, 0.0), elements=4, degree=2))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "load")
    solution = ph.simulate(d.compile(), t_end=0.05, dt=0.005, inputs={"load": (0.0, -2e4)})
    shape = lines(plots.motion(solution, times=0.05))["t = 0.05 s"].get_xydata()[:21]
    chord = shape[0] + (shape[-1] - shape[0]) * np.linspace(0.0, 1.0, 21)[:, None]
    assert np.abs(shape - chord).max() > 0.01


def test_paths(solution, coupler):
    drawn = lines(plots.motion(solution, path=[coupler.at(0.5), coupler.end]))
    np.testing.assert_array_equal(drawn["path of coupler at 0.5"].get_xydata(), solution.position(coupler, 0.5))
    np.testing.assert_array_equal(drawn["path of coupler.end"].get_xydata(), solution.position(coupler, 1.0))
    assert "path of coupler at 0.5" in lines(plots.motion(solution, path=coupler.at(0.5)))


def test_times_by_default_and_nearest(solution):
    def shown(ax):
        return [label for label in lines(ax) if label.startswith("t = ")]

    assert len(shown(plots.motion(solution))) == 6
    assert shown(plots.motion(solution, times=[0.213])) == ["t = 0.22 s"]


def test_draws_where_asked(solution):
    _, ax = plt.subplots()
    assert plots.motion(solution, ax=ax) is ax


def test_without_tracked_positions(bar):
    """Positions come from strain then; the ends of an imposed motion are not the ground."""
    d = ph.Diagram("driven")
    beam = d.add(ph.Beam("beam", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.expose(beam.start.translation, "hand", imposes="velocity")
    system = d.compile()
    solution = ph.simulate(system, t_end=0.1, dt=0.05, inputs={"hand": (1.0, 0.0)})
    drawn = lines(plots.motion(solution, times=0.1))
    assert "ground" not in drawn
    np.testing.assert_allclose(drawn["t = 0.1 s"].get_xydata()[0], (0.1, 0.0), atol=1e-3)


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({"times": [2.0]}, ph.errors.DataError),
        ({"times": [-0.1]}, ph.errors.DataError),
        ({"times": [float("nan")]}, ph.errors.DataError),
        ({"times": "soon"}, ph.errors.ArgumentTypeError),
        ({"path": "coupler"}, ph.errors.ArgumentTypeError),
        ({"path": ["coupler"]}, ph.errors.ArgumentTypeError),
        ({"path": 3.0}, ph.errors.ArgumentTypeError),
    ],
)
def test_wrong_arguments(solution, arguments, error):
    with pytest.raises(error):
        plots.motion(solution, **arguments)


def test_no_solution(diagram):
    with pytest.raises(ph.errors.ArgumentTypeError):
        plots.motion(diagram)


def test_nothing_to_draw(solution):
    empty = replace(solution, system=replace(solution.system, parts=(), sites=()))
    with pytest.raises(ph.errors.DataError, match="extension"):
        plots.motion(empty)
