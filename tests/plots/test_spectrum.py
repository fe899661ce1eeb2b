"""Frequencies and damping on paper are those of the modes."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import phblocks as ph
from phblocks import plots


def system(damping=0.0):
    d = ph.Diagram("oscillator")
    mass = d.add(ph.Mass("mass", 2.0, (1.0, 0.0)))
    spring = d.add(ph.Spring("spring", 200.0, (0.0, 0.0), (1.0, 0.0)))
    d.pin(spring.start, d.ground)
    anchors = [spring.end, mass.centre]
    if damping:
        damper = d.add(ph.Damper("damper", damping, (0.0, 0.0), (1.0, 0.0)))
        d.pin(damper.start, d.ground)
        anchors.append(damper.end)
    d.pin(*anchors)
    return d.compile()


def test_frequencies_of_a_beam(bar):
    d = ph.Diagram("cantilever")
    beam = d.add(ph.Beam("beam", bar, (0.0, 0.0), (2.0, 0.0), elements=4, degree=2))
    d.weld(beam.start, d.ground)
    modes = d.compile().modes(6)
    ax = plots.spectrum(modes)
    np.testing.assert_allclose(ax.collections[0].get_offsets(), np.stack([np.arange(1, 7), modes.hertz], axis=1))
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_yscale()) == ("mode", "frequency (Hz)", "log")
    assert len(ax.figure.axes) == 1  # nothing damped, no colour bar


def test_damping_ratio_is_the_colour():
    """c / (2 sqrt(k m)) = 8 / (2 sqrt(400)) = 0.2 at omega = 10 sqrt(1 - 0.04) rad/s."""
    ax = plots.spectrum(system(8.0).modes(1))
    dots = ax.collections[0]
    assert np.asarray(dots.get_array()) == pytest.approx([0.2])
    assert dots.get_offsets()[0, 1] == pytest.approx(10.0 * np.sqrt(0.96) / (2.0 * np.pi))
    assert ax.figure.axes[1].get_ylabel() == "damping ratio"


def test_lines_of_a_step():
    ax = plots.spectrum(system().modes(1), dt=0.01)
    levels = [line.get_ydata()[0] for line in ax.lines]
    assert levels == pytest.approx([0.1 / (0.02 * np.pi), 1.0 / (0.02 * np.pi), 50.0])
    assert [t.get_text() for t in ax.texts] == ["hω = 0.1", "hω = 1", "hω = π"]


def test_motions_that_diverge_are_counted(four_bar):
    modes = four_bar().compile().modes(3)
    assert modes.diverging.size == 1  # it falls
    assert plots.spectrum(modes).get_title() == "1 more diverge without oscillating"


def test_wrong_arguments():
    with pytest.raises(ph.errors.ArgumentTypeError, match="Modes"):
        plots.spectrum(system())
    with pytest.raises(ph.errors.DataError):
        plots.spectrum(system().modes(1), dt=0.0)
    nothing = ph.Diagram("nothing")
    nothing.add(ph.Mass("mass", 1.0, (0.0, 0.0)))
    with pytest.raises(ph.errors.DataError, match="mode"):
        plots.spectrum(nothing.compile().modes(1))


def test_draws_where_asked():
    _, ax = plt.subplots()
    assert plots.spectrum(system().modes(1), ax=ax) is ax
