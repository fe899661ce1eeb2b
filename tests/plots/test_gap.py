"""Gaps on paper are those of the solution."""

import itertools

import numpy as np
import pytest

import phblocks as ph
from phblocks import plots
from phblocks.plots.gap import block_gaps


@pytest.fixture(scope="module")
def solution(four_bar):
    return ph.simulate(four_bar().compile(), t_end=0.5, dt=0.02)


def lines(ax):
    return {line.get_label(): line for line in ax.lines}


def test_joints(solution):
    drawn, gaps = lines(plots.gap(solution)), solution.closure()
    name = "coupler.end = rocker.start"
    line, floor = drawn[f"joint: {name}"], 1e-9 * max(g.max() for g in [*gaps.values(), *block_gaps(solution).values()])
    np.testing.assert_array_equal(line.get_ydata(), gaps[name][gaps[name] > floor])
    np.testing.assert_array_equal(line.get_xdata(), solution.t[gaps[name] > floor])
    assert line.get_linestyle() == "--"


def test_blocks(solution):
    ax = plots.gap(solution)
    for name in ("crank", "coupler", "rocker"):
        apart = [
            np.linalg.norm(solution.position(name, s, source="strain") - solution.position(name, s), axis=1)
            for s in np.linspace(0.0, 1.0, 21)
        ]
        assert lines(ax)[f"strain to position: {name}"].get_ydata()[-1] == np.max(apart, axis=0)[-1]
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_yscale()) == ("time (s)", "gap (m)", "log")


def test_gaps_fall_with_the_square_of_the_step(four_bar, solution):
    finer = ph.simulate(four_bar().compile(), t_end=0.5, dt=0.01)
    coarse, fine = (max(g[-1] for g in block_gaps(s).values()) for s in (solution, finer))
    assert coarse / fine == pytest.approx(4.0, rel=0.35)


def test_of_many_the_largest(bar):
    d = ph.Diagram("chain", gravity=(0.0, -9.81))
    links = [d.add(ph.Beam(f"link {i}", bar, (i, 0.0), (i + 1.0, 0.0), elements=2)) for i in range(9)]
    d.pin(links[0].start, d.ground)
    for left, right in itertools.pairwise(links):
        d.pin(left.end, right.start)
    solution = ph.simulate(d.compile(), t_end=0.2, dt=0.02)
    gaps = block_gaps(solution)
    drawn = [label for label in lines(plots.gap(solution)) if label.startswith("strain")]
    largest = sorted(gaps, key=lambda name: -gaps[name].max())[:6]
    assert drawn == [f"strain to position: {name}" for name in largest]
    assert "and 3 smaller" in lines(plots.gap(solution))


def test_nothing_to_measure(four_bar):
    d = ph.Diagram("circuit")
    resistor, capacitor = d.add(ph.Resistor("resistor", 1.0)), d.add(ph.Capacitor("capacitor", 1.0, voltage=1.0))
    earth = d.add(ph.Reference("earth"))
    d.connect(resistor.p, capacitor.p)
    d.connect(resistor.n, capacitor.n, earth.port)
    with pytest.raises(ph.errors.DataError, match="joint"):
        plots.gap(ph.simulate(d.compile(), t_end=0.2, dt=0.1))
    with pytest.raises(ph.errors.ArgumentTypeError):
        plots.gap(four_bar())
