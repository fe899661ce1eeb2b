"""Points on paper are the rows of the study."""

from textwrap import fill

import matplotlib.pyplot as plt
import numpy as np
import pytest

import phblocks as ph
from phblocks import plots
from tests.studies import scenes
from tests.studies.rows import make_run

STEPS = [0.2, 0.1, 0.05, 0.025]
MASS = ("position", "mass", (0.0, 0.0))


@pytest.fixture(scope="module")
def study():
    return ph.studies.work_precision(
        scenes.pendulum,
        {"midpoint": ph.Midpoint(), "loose": ph.Midpoint(newton=ph.Newton(tolerance=1e-5))},
        [0.04, 0.02],
        [{"elements": 2, "degree": 1}, {"elements": 2, "degree": 2}],
        quantity=("position", "beam", 1.0),
        t_end=0.2,
        repeats=1,
    )


@pytest.fixture(scope="module")
def orders():
    truth = [[scenes.exact(1.0), 0.0]]
    return ph.studies.convergence(scenes.oscillator, "dt", STEPS, quantity=MASS, t_end=1.0, reference=truth)


def points(ax):
    """Of all lines with markers."""
    lines = [line for line in ax.lines if line.get_marker() != "None"]
    return {(x, y) for line in lines for x, y in zip(line.get_xdata(), line.get_ydata(), strict=True)}


def test_work_precision(study):
    figure = plots.work_precision(study)
    error, energy, gap = figure.axes
    for ax, name in ((error, "error"), (energy, "energy_error"), (gap, "gap")):
        assert points(ax) == {(row.seconds, getattr(row, name)) for row in study}
        assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert error.get_ylabel() == "error of position of 'beam' at 1.0 (m)"
    assert error.get_xlabel() == gap.get_xlabel() == "wall time of simulate (s)"
    assert "(relative)" in energy.get_ylabel() and "(m)" in gap.get_ylabel()
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names[:4] == ["midpoint", "loose", "elements=2, degree=1", "elements=2, degree=2"]


def test_front(study):
    line = plots.work_precision(study).axes[0].lines[0]
    np.testing.assert_array_equal(line.get_xdata(), study.front.column("seconds"))
    np.testing.assert_array_equal(line.get_ydata(), study.front.column("error"))


def test_colour_is_the_method_and_marker_the_mesh(study):
    lines = plots.work_precision(study).axes[0].lines[1:]
    assert [line.get_color() for line in lines[:2]] != [line.get_color() for line in lines[2:]]
    assert len({line.get_color() for line in lines[:2]}) == 1
    assert [line.get_marker() for line in lines] == ["o", "s"] * 2


def tick_labels(axis):
    """Boxes of those that are seen."""
    low, high = sorted(axis.get_view_interval())
    labels = [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
    return [label.get_window_extent() for label in labels if label.get_visible() and label.get_text()]


@pytest.mark.parametrize("decades", [0.0, 0.25, 0.6, 1.8, 3.1, 6.0])
@pytest.mark.parametrize("start", [1.7e-4, 0.8])
def test_tick_labels(decades, start):
    """There are some, and none covers another, whatever the range."""
    top = start * 10.0**decades
    rows = (
        make_run("a", start, top, energy_error=start, gap=top),
        make_run("a", top, start, energy_error=top, gap=start),
    )
    figure = plots.work_precision(ph.studies.WorkPrecisionStudy(rows))
    figure.draw_without_rendering()
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            boxes = tick_labels(axis)
            hidden = ax is figure.axes[1] and axis is ax.xaxis
            assert hidden or boxes
            assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


def test_shared_machines_and_failures_are_told():
    rows = (make_run("a", 1.0, 0.1, shared_machine=True), make_run("a", 2.0, 0.01), make_run("b", 1.0))
    error = plots.work_precision(ph.studies.WorkPrecisionStudy(rows)).axes[0]
    assert "on a shared machine" in error.get_xlabel()
    assert error.get_title() == "1 of 3 runs failed and are not shown"
    with pytest.raises(ph.errors.DataError, match="none of 1"):
        plots.work_precision(ph.studies.WorkPrecisionStudy(rows[2:]))


def test_convergence(orders):
    ax = plots.convergence(orders)
    assert points(ax) == set(zip(STEPS, orders.column("error"), strict=True))
    [line] = [line for line in ax.lines if line.get_label().startswith("order")]
    assert line.get_label() == f"order {orders.order:.2f}"
    np.testing.assert_allclose(line.get_ydata(), orders.column("error"), rtol=0.01)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("step (s)", "error of position of 'mass' at (0.0, 0.0) (m)")


def test_convergence_over_the_degree():
    study = ph.studies.convergence(
        scenes.cantilever, "degree", [1, 2, 3, 4], quantity=scenes.first_frequency, t_end=1e-3, dt=1e-3
    )
    ax = plots.convergence(study)
    assert (ax.get_xscale(), ax.get_yscale(), ax.get_xlabel()) == ("linear", "log", "degree")
    assert any("a degree" in line.get_label() for line in ax.lines)


def test_a_study_draws_itself(study, orders):
    assert len(study.plot().axes) == 3
    _, ax = plt.subplots()
    assert orders.plot(ax=ax) is ax


def test_effects():
    """A point a row that came to its end, filled if within the tolerance, which is a line."""
    candidates = {
        "shear": {"beam": ph.Approximation(shear=False)},
        "bending": {"beam": ph.Approximation(flexible=False)},
        "unknown": {"rod": ph.Approximation(shear=False)},
    }
    study = ph.studies.effects(
        pendulum, ("position", "beam", 1.0), 1e-3, t_end=0.3, steps=(0.02, 0.01), candidates=candidates, repeats=1
    )
    ax = study.plot()
    done = [row for row in study if row.status == "success"]
    assert points(ax) == {(row.time_saved, row.error) for row in done} and len(done) < len(study)
    filled = {x.get_label(): x.get_markerfacecolor() != "none" for x in ax.lines if x.get_marker() != "None"}
    names = ["full system" if row.left_out == "nothing" else f"without {row.left_out}" for row in done]
    assert filled == {fill(name, 36): row.within for name, row in zip(names, done, strict=True)}
    assert len(set(filled.values())) == 2
    assert 1e-3 in [line.get_ydata()[0] for line in ax.lines if line.get_marker() == "None"]


def pendulum(approximation):
    d = ph.Diagram("pendulum", gravity=(0.0, -9.81))
    section = ph.Section.circle(0.01, 5e6, 0.3, 1000.0)
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.0), elements=3, degree=2))
    d.pin(beam.start, d.ground)
    return d.compile(approximation=approximation)


@pytest.mark.parametrize("draw", [plots.work_precision, plots.convergence, plots.effects])
def test_no_study(draw):
    with pytest.raises(ph.errors.ArgumentTypeError, match="int"):
        draw(3)
