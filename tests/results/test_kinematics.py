"""Positions from velocity and from strain, closure of joints, parts that hang on nothing."""

import itertools
import math

import numpy as np
import pytest

import phblocks as ph
from phblocks.blocks.beam.ends import ENDS

STIFF = ph.Section(axial=4e7, shear=2e7, bending=6e4, mass=1.2, rotary=2e-3)
PLACES = (0.0, 0.3, 0.5, 1.0)


def arc_point(beam: ph.Beam, place: float) -> np.ndarray:
    """On the circle through both ends, or on the line."""
    s, k, a = place * beam.length, beam.curvature, beam.start.angle
    if k == 0.0:
        return beam.start.position + s * np.array([math.cos(a), math.sin(a)])
    return beam.start.position + np.array([math.sin(a + k * s) - math.sin(a), math.cos(a) - math.cos(a + k * s)]) / k


def test_both_positions_begin_with_the_geometry(solution, scenes, name):
    curved = name in ("frame", "shaken")  # strain is integrated by quadrature
    for block in scenes[name].network.blocks.values():
        if isinstance(block, ph.Beam):
            for place in PLACES:
                here = arc_point(block, place)
                np.testing.assert_allclose(
                    solution.position(block, place, source="strain")[0], here, atol=1e-6 if curved else 1e-12
                )
                np.testing.assert_allclose(
                    solution.position(block, place, source="velocity")[0], here, atol=1e-6 if curved else 1e-12
                )
                angle = block.start.angle + block.curvature * block.length * place
                assert solution.angle(block, place)[0] == pytest.approx(angle, abs=1e-12)


@pytest.mark.parametrize(("start", "end"), list(itertools.product(ENDS, repeat=2)))
@pytest.mark.parametrize("curvature", [0.0, 0.6])
def test_in_every_causality(start, end, curvature):
    """Ends that take are held by the outside, at rest; ends that give are free."""
    d = ph.Diagram()
    b = d.add(ph.Beam("b", STIFF, (0.3, 0.1), (-0.6, 0.9), 5, degree=3, causality=(start, end), curvature=curvature))
    signals = {}
    for anchor, gives in ((b.start, ENDS[start]), (b.end, ENDS[end])):
        for port, give in zip(anchor.ports, gives, strict=True):
            if not give:
                label = port.path.replace(".", " ")
                d.expose(port, label)
                signals[label] = (0.0, 0.0) if port is anchor.translation else 0.0
    solution = ph.simulate(d.compile(), t_end=0.02, dt=0.01, inputs=signals)
    for place in PLACES:
        here = arc_point(b, place)
        for source, close in (("strain", 1e-9), ("velocity", 1e-9)):
            path = solution.position(b, place, source=source)
            np.testing.assert_allclose(path, np.tile(here, (3, 1)), atol=close)  # at rest it stays
        assert solution.angle(b, place) == pytest.approx(
            np.full(3, b.start.angle + curvature * b.length * place), abs=1e-12
        )
    for gap in solution.closure().values():
        np.testing.assert_allclose(gap, 0.0, atol=1e-9)


def test_joints_begin_closed(solution, name):
    for source in ("strain", "velocity"):
        gaps = solution.closure(source)
        assert set(gaps) == {site.name for site in solution.system.sites}
        for gap in gaps.values():
            close = 1e-6 if name in ("frame", "shaken") else 1e-12
            assert gap.shape == solution.t.shape and gap[0] <= close


def test_gaps_are_the_distances_of_what_is_joined(solutions):
    solution = solutions["four-bar"]
    for source in ("strain", "velocity"):
        gap = solution.closure(source)["coupler.end = rocker.start"]
        ends = [solution.position(b, s, source=source) for b, s in (("coupler", 1.0), ("rocker", 0.0))]
        np.testing.assert_allclose(gap, np.linalg.norm(ends[0] - ends[1], axis=1), atol=1e-15)
        foot = solution.closure(source)["rocker.end = ground.anchor"]
        away = solution.position("rocker", 1.0, source=source) - [2.5, 0.5]
        np.testing.assert_allclose(foot, np.linalg.norm(away, axis=1), atol=1e-14)
    # from strain, gaps of a loop are at the joint that closes it only
    strain = solution.closure("strain")
    assert sorted(gap.max() > 1e-12 for gap in strain.values()) == [False, False, False, True]


def test_gaps_shrink_with_the_square_of_the_step(four_bar):
    system = four_bar().compile()
    worst = []
    for dt in (0.02, 0.01):
        gaps = ph.simulate(system, t_end=1.0, dt=dt).closure("strain")
        worst.append(max(gap.max() for gap in gaps.values()))
    assert worst[0] < 2e-3 and worst[0] / worst[1] == pytest.approx(4.0, rel=0.3)


def spun(dt: float, spin: float = 3.0, t_end: float = 2.0, length: float = 2.0):
    """A stiff beam about a pin, its root turned from outside at constant speed, started in steady rotation."""
    d = ph.Diagram()
    b = d.add(
        ph.Beam("b", STIFF, (0.5, -0.2), (0.5 + length * math.cos(0.7), -0.2 + length * math.sin(0.7)), 3, degree=2)
    )
    d.pin(b.start, d.ground)
    d.expose(b.start.rotation, "drive", imposes="angular velocity")
    system = d.compile()
    start = system.rigid_motion(spin=spin, about=(0.5, -0.2))
    return b, ph.simulate(system, t_end=t_end, dt=dt, inputs={"drive": spin}, start=start)


def test_a_spinning_beam_draws_circles():
    spin, length = 3.0, 2.0
    stretch = 1.2 * spin**2 * length**2 / (3.0 * 4e7)  # from its own centrifugal force, relative
    errors = []
    for dt in (0.02, 0.01):
        b, solution = spun(dt)
        for source in ("velocity", "strain"):
            for place in (0.5, 1.0):
                radius = np.linalg.norm(solution.position(b, place, source=source) - b.start.position, axis=1)
                chord = (spin * dt) ** 2 / 24.0
                limit = 5e-6 if source == "strain" else 3.0 * chord
                np.testing.assert_allclose(radius, place * length, rtol=limit)
                if source == "velocity" and place == 1.0:
                    errors.append(np.abs(radius / length - 1.0).max())
        angle = 0.7 + spin * solution.t
        tip = b.start.position + length * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        np.testing.assert_allclose(solution.position(b, 1.0, source="strain"), tip, atol=2e-4)
        np.testing.assert_allclose(solution.angle(b.end), angle, atol=1e-4)
        np.testing.assert_allclose(solution.angle(b.start), angle, atol=1e-13)
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05) and stretch < 5e-6


@pytest.mark.parametrize("ends", ["clamped-free", "clamped-clamped"])
def test_an_arc_keeps_its_shape_while_it_turns(ends):
    """Half a turn of a stiff quarter circle about its start, whatever V is continuous in."""
    d = ph.Diagram()
    b = d.add(ph.Beam("b", STIFF, (0.0, 0.0), (1.0, 1.0), 3, degree=3, curvature=1.0))
    d.pin(b.start, d.ground)
    d.expose(b.start.rotation, "drive", imposes="angular velocity")
    inputs = {"drive": math.pi}
    if ends == "clamped-clamped":  # the end is driven along as well
        d.expose(b.end.translation, "lead", imposes="velocity")
        d.expose(b.end.rotation, "turn", imposes="angular velocity")
        inputs["turn"] = math.pi
        inputs["lead"] = lambda t: (
            math.pi * np.array([-np.sin(math.pi * t) - np.cos(math.pi * t), np.cos(math.pi * t) - np.sin(math.pi * t)])
        )
    system = d.compile()
    assert b.end_names(system.report.gives("b")) == ends
    solution = ph.simulate(system, 1.0, 0.01, start=system.rigid_motion(spin=math.pi), inputs=inputs)
    for place in PLACES:
        for source in ("velocity", "strain"):
            end = solution.position(b, place, source=source)[-1]
            np.testing.assert_allclose(end, -arc_point(b, place), atol=1e-3)


def test_what_hangs_on_nothing_starts_from_its_centre_of_mass():
    """A free beam thrown with a spin: its centre flies on a parabola, its ends turn about it."""
    d = ph.Diagram(gravity=(0.0, -10.0))
    b = d.add(ph.Beam("b", STIFF, (0.0, 0.0), (1.0, 0.0), 4, degree=2))
    system = d.compile()
    start = system.rigid_motion(velocity=(1.0, 3.0), spin=2.0, about=(0.5, 0.0))
    solution = ph.simulate(system, t_end=1.0, dt=0.01, start=start)
    t = solution.t
    centre = np.stack([0.5 + t, 3.0 * t - 5.0 * t**2], axis=1)
    mean = np.einsum("tmd,m->td", solution.recording.points, system.point_mass) / system.point_mass.sum()
    np.testing.assert_allclose(mean, centre, atol=1e-3)  # momentum is kept to second order in dt only
    half = 0.5 * np.stack([np.cos(2.0 * t), np.sin(2.0 * t)], axis=1)
    for place, sign in ((0.0, -1.0), (0.5, 0.0), (1.0, 1.0)):
        for source in ("strain", "velocity"):
            np.testing.assert_allclose(solution.position(b, place, source=source), mean + sign * half, atol=2e-4)


def test_a_chain_that_hangs_on_nothing_is_followed_through_its_joints(solutions):
    solution = solutions["free"]
    first, second = (solution.position(b, s, source="strain") for b, s in (("first", 1.0), ("second", 0.0)))
    np.testing.assert_allclose(first, second, atol=1e-14)
    for b, s in (("first", 0.0), ("second", 1.0)):
        both = [solution.position(b, s, source=source) for source in ("strain", "velocity")]
        assert np.abs(both[0] - both[0][0]).max() > 0.02
        np.testing.assert_allclose(both[0], both[1], atol=3e-3)


def test_an_imposed_velocity_carries_the_position_along(solutions):
    solution = solutions["shaken"]
    moved = solution.recording.input_integral[:, :2]
    assert np.abs(moved).max() > 0.01
    np.testing.assert_allclose(solution.position("lower", 0.0, source="strain"), moved, atol=1e-14)
    np.testing.assert_allclose(solution.position("lower", 0.0, source="velocity"), moved, atol=5e-3)


def test_a_welded_corner_keeps_its_angle(solutions):
    for name, pairs in {"frame": [("left", "top"), ("top", "right")], "shaken": [("lower", "upper")]}.items():
        solution = solutions[name]
        for a, b in pairs:
            between = solution.angle(b, 0.0) - solution.angle(a, 1.0)
            assert np.ptp(solution.angle(a, 1.0)) > 1e-3
            np.testing.assert_allclose(between, between[0], atol=2e-3)
