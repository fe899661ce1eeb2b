"""Loads along beams: dead ones against gravity, following ones against statics, and their energy."""

import numpy as np
import pytest

import phblocks as ph

SECTION = ph.Section(axial=1200.0, shear=384.6153846153846, bending=1.0, mass=2.0, rotary=2.0 / 1200.0)


def cantilever(loads=(), gravity=None, **kwargs):
    """A beam clamped at its start."""
    d = ph.Diagram("cantilever", gravity=gravity)
    kwargs = {"elements": 4, "degree": 2, "start": (0.0, 0.0), "end": (0.8, 0.6)} | kwargs
    beam = d.add(ph.Beam("beam", SECTION, loads=loads, **kwargs))
    d.weld(beam.start, d.ground)
    return d, beam


def supplied(solution, name):
    """Energy from one load."""
    return solution.power.inputs[f"{name}.x"] + solution.power.inputs[f"{name}.y"]


@pytest.mark.parametrize("curvature", [None, 0.7])
def test_dead_load_is_gravity(curvature):
    g = np.array([0.3, -4.0])
    loaded, beam = cantilever(ph.LineLoad("weight", SECTION.mass * g), curvature=curvature)
    heavy, _ = cantilever(gravity=g, curvature=curvature)
    ours, theirs = (ph.simulate(d.compile(), 1.0, 0.01) for d in (loaded, heavy))
    np.testing.assert_allclose(ours.x, theirs.x, atol=1e-11 * np.abs(theirs.x).max())
    np.testing.assert_allclose(supplied(ours, "weight"), -theirs.energy.gravity, atol=1e-12)
    assert np.ptp(ours.angle(beam.at(1.0))) > 0.5


@pytest.mark.parametrize("follows", [False, True])
@pytest.mark.parametrize("ends", ["auto", "clamped-free", "pinned-free", "clamped-clamped"])
def test_energy_of_a_load_that_changes_is_that_of_the_beam(follows, ends):
    def force(t):
        return (np.sin(5.0 * t), -8.0 * t)

    if ends in ("auto", "clamped-free"):
        d, beam = cantilever(ph.LineLoad("wind", force, follows), causality=ends)
    else:
        d = ph.Diagram("two joints")
        beam = d.add(ph.Beam("beam", SECTION, (0, 0), (1, 0), 4, 2, ends, loads=ph.LineLoad("wind", force, follows)))
        if ends == "clamped-clamped":
            d.weld(beam.start, d.ground)
            d.weld(beam.end, d.ground)
        else:
            d.pin(beam.start, d.ground)
    solution = ph.simulate(d.compile(), 1.0, 0.01)
    work = supplied(solution, "wind")
    stored = solution.power.blocks["beam"]["stored"]
    assert np.abs(work).max() > 1e-3
    np.testing.assert_allclose(stored, work, atol=1e-12 * max(1.0, np.abs(work).max()))


def test_load_that_follows_holds_the_beam_bent_by_itself():
    q = np.array([0.5, -4.0])
    d, beam = cantilever(
        ph.LineLoad("pressure", q, follows=True), damping=ph.Damping(viscous=12.0, internal=0.2), elements=6, degree=3
    )
    solution = ph.simulate(d.compile(), 20.0, 0.05)
    assert np.abs(solution.velocity(beam.at(1.0))[-1]).max() < 1e-6
    s, weights = np.polynomial.legendre.leggauss(24)
    s, weights = (s + 1.0) / 2.0, weights / 2.0
    angle = np.array([solution.angle(beam.at(p))[-1] for p in s])
    place = np.array([solution.position(beam.at(p), source="strain")[-1] for p in s])
    density = np.stack([np.cos(angle) * q[0] - np.sin(angle) * q[1], np.sin(angle) * q[0] + np.cos(angle) * q[1]], 1)
    root = solution.force(beam.start, frame="fixed")[-1]  # what the part towards the end does to the root
    np.testing.assert_allclose(root, weights @ density, rtol=1e-3)
    moment = weights @ (place[:, 0] * density[:, 1] - place[:, 1] * density[:, 0])
    assert solution.moment(beam.start)[-1] == pytest.approx(moment, rel=1e-3)
    assert angle[-1] < np.arctan2(0.6, 0.8) - 0.5


def test_dead_and_following_loads_add_up_where_nothing_turns():
    loads = [ph.LineLoad("a", (30.0, 0.0)), ph.LineLoad("b", (20.0, 0.0), follows=True)]
    tips = []
    for several in (loads, ph.LineLoad("c", (50.0, 0.0))):
        d, beam = cantilever(several, end=(1.0, 0.0))
        tips.append(ph.simulate(d.compile(), 0.3, 0.01).velocity(beam.at(1.0)))
    np.testing.assert_allclose(*tips, atol=1e-12)


def test_signal_of_the_simulation_replaces_that_of_the_load():
    d, _ = cantilever(ph.LineLoad("wind", (0.0, -9.0)))
    system = d.compile()
    assert system.input_names == ("wind.x", "wind.y")
    assert np.abs(ph.simulate(system, 0.1, 0.01).x).max() > 0.1
    assert np.abs(ph.simulate(system, 0.1, 0.01, inputs={"wind": (0.0, 0.0)}).x).max() == 0.0


def test_halves_of_a_beam_carry_the_load_on():
    whole, beam = cantilever(ph.LineLoad("snow", (0.0, -1.0)))
    halves = beam.split(0.5)
    assert [half.loads[0].name for half in halves] == ["snow-1", "snow-2"]
    d = ph.Diagram("halves")
    for half in halves:
        d.add(half)
    d.weld(halves[0].start, d.ground)
    d.weld(halves[0].end, halves[1].start)
    one, two = (ph.simulate(x.compile(), 0.5, 0.01) for x in (whole, d))
    np.testing.assert_allclose(two.velocity(halves[1].at(1.0)), one.velocity(beam.at(1.0)), atol=2e-2)


@pytest.mark.parametrize(
    ("args", "error"),
    [
        (("", (0.0, 1.0)), ph.errors.DataError),
        (("a.b", (0.0, 1.0)), ph.errors.DataError),
        ((1, (0.0, 1.0)), ph.errors.ArgumentTypeError),
        (("a", 1.0), ph.errors.DataError),
        (("a", (0.0, float("inf"))), ph.errors.DataError),
        (("a", "strong"), ph.errors.ArgumentTypeError),
    ],
)
def test_loads_of_the_wrong_kind_are_refused(args, error):
    with pytest.raises(error, match="LineLoad"):
        ph.LineLoad(*args)


def test_names_of_loads_are_unique():
    load = ph.LineLoad("a", (0.0, 1.0))
    with pytest.raises(ph.errors.DuplicateNameError):
        cantilever([load, load])
    d, _ = cantilever(load)
    with pytest.raises(ph.errors.DuplicateNameError, match="'a'"):
        d.add(ph.Beam("other", SECTION, (0, 0), (1, 0), 4, loads=load))
    with pytest.raises(ph.errors.ArgumentTypeError, match="loads"):
        cantilever((0.0, -1.0))
