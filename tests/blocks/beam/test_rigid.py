"""A beam that does not bend is a rigid body with the ports of the beam."""

import itertools

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import UnknownNameError

RIGID = ph.Approximation(flexible=False)
SOFT = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)
PLACES = ((0.0, 0.5), (2.0, 1.5), (3.5, 1.5), (2.5, 0.5))


@pytest.fixture(scope="module")
def bodies(bar):
    """The four-bar of rigid bodies and joints with multipliers, written by hand: (system, coupler)."""
    d = ph.Diagram("rigid four-bar", gravity=(0.0, -9.81))
    links = []
    for name, *ends in zip(("crank", "coupler", "rocker"), PLACES, PLACES[1:], strict=False):
        start, end = np.array(ends)
        length = np.hypot(*(end - start))
        inertia = bar.mass * length**3 / 12.0 + bar.rotary[1] * length
        angle = np.arctan2(*(end - start)[::-1])
        anchors = {"start": start, "end": end}
        links.append(d.add(ph.RigidBody(name, bar.mass * length, inertia, (start + end) / 2.0, anchors, angle=angle)))
    d.pin(links[0]["start"], d.ground, multiplier=True)
    for left, right in itertools.pairwise(links):
        d.pin(left["end"], right["start"], multiplier=True)
    d.pin(links[2]["end"], d.ground, multiplier=True)
    return d.compile(), links[1]


def test_a_four_bar_is_that_of_rigid_bodies(four_bar, bodies):
    """Asked for: 1e-12 over 5 s; measured 2e-14 m."""
    system, coupler = bodies
    other = four_bar().compile(approximation=RIGID)
    assert other.n == system.n == 3 * 3 + 4 * 2
    a, b = (ph.simulate(s, t_end=5.0, dt=0.01) for s in (system, other))
    difference = a.position(coupler, (0.0, 0.0)) - b.position("coupler", 0.5)
    assert np.abs(difference).max() < 1e-12
    assert b.max_power_balance_error < 1e-11
    np.testing.assert_allclose(b.position("crank", 1.0), b.position("coupler", 0.0), rtol=0, atol=1e-3)


def test_it_does_not_depend_on_the_mesh(four_bar):
    coarse, fine = (
        four_bar(elements=n, degree=k).compile(approximation=RIGID) for n, k in (((1, 1, 1), 1), ((9,) * 3, 3))
    )
    assert (coarse.E != fine.E).nnz == 0 and (coarse.J0 != fine.J0).nnz == 0


@pytest.fixture(scope="module")
def arc():
    """A curved beam on a pin with drag and loads, rigid and very stiff: the two solutions."""

    def swing(approximation, factor):
        section = ph.Section(axial=4e4 * factor, shear=2e4 * factor, bending=60.0 * factor, mass=1.2, rotary=2e-3)
        d = ph.Diagram("arc", gravity=(0.0, -9.81))
        b = d.add(
            ph.Beam(
                "b",
                section,
                (0.1, 0.2),
                (1.0, 0.4),
                elements=6,
                degree=3,
                curvature=1.7,
                damping=ph.Damping(viscous=0.6, rotary=0.05),
                loads=[ph.LineLoad("wind", (3.0, 1.0)), ph.LineLoad("thrust", (2.0, -5.0), follows=True)],
                approximation=approximation,
            )
        )
        d.pin(b.start, d.ground)
        return ph.simulate(d.compile(), t_end=1.0, dt=0.001)

    return swing(RIGID, 1.0), swing(None, 1e5)


@pytest.mark.parametrize("s", [0.0, 0.3, 1.0])
def test_read_outs_are_those_of_a_stiff_beam(arc, s):
    """Compliances 1e5 times smaller: what is left is of that size, and the error of the steps in rotation."""
    rigid, stiff = arc
    for source in ("velocity", "strain"):
        np.testing.assert_allclose(rigid.position("b", s, source), stiff.position("b", s, source), rtol=0, atol=2e-5)
    np.testing.assert_allclose(rigid.angle("b", s), stiff.angle("b", s), rtol=0, atol=2e-5)
    for frame in ("fixed", "material"):
        np.testing.assert_allclose(rigid.velocity("b", s, frame), stiff.velocity("b", s, frame), rtol=0, atol=2e-3)
    np.testing.assert_allclose(rigid.spin("b", s), stiff.spin("b", s), rtol=0, atol=2e-3)


def test_losses_and_work_of_loads_are_those_of_a_stiff_beam(arc):
    rigid, stiff = arc
    assert stiff.energy["dissipated"][-1] > 0.1
    for kind in ("dissipated", "supplied", "kinetic"):
        assert rigid.energy[kind][-1] == pytest.approx(stiff.energy[kind][-1], rel=2e-4)
    assert rigid.max_power_balance_error < 1e-13


def test_forces_are_known_at_the_ends_and_nowhere_else(four_bar):
    """At an end it is what the joint transmits. Inside a rigid beam there is no stress to be read."""
    solution = ph.simulate(four_bar().compile(approximation=RIGID), t_end=0.5, dt=0.01)
    crank = solution.system.part("crank").block
    pin = np.stack([solution.state(f"pin ground crank.force {axis}[0]") for axis in "xy"], axis=1)
    # the multiplier is the force of the second side, the crank, on the joint; N at the start points into the beam
    np.testing.assert_allclose(solution.force(crank.start, frame="fixed"), pin, rtol=0, atol=1e-9)
    assert np.abs(pin[1:]).max() > 50.0
    assert not solution.moment(crank.end).any()
    for name in ("N1", "M3"):
        with pytest.raises(UnknownNameError, match="keep flexible=True"):
            solution.system.part("crank").form.value(None, name, 0.5)


def test_a_rigid_beam_between_flexible_ones_needs_no_multiplier():
    d = ph.Diagram("chain", gravity=(0.0, -9.81))
    first = d.add(ph.Beam("first", SOFT, (-1, 0), (0, 0), elements=2))
    coupler = d.add(ph.Beam("stiff", SOFT, (0, 0), (1, 0), elements=2, approximation=RIGID))
    last = d.add(ph.Beam("last", SOFT, (1, 0), (2, 0), elements=2))
    d.pin(first.start, d.ground)
    d.weld(first.end, coupler.start)
    d.pin(coupler.end, last.start)
    assert d.check().ok
    system = d.compile()
    assert not system.constraint_names
    assert ph.simulate(system, 0.5, 0.005).max_power_balance_error < 1e-11


def test_welded_and_driven_ones_are_held():
    """An L of two rigid beams, turned from outside at 2 rad/s: the tip is where it must be."""
    d = ph.Diagram("L")
    a = d.add(ph.Beam("a", SOFT, (0, 0), (1, 0), elements=2, approximation=RIGID))
    b = d.add(ph.Beam("b", SOFT, (1, 0), (1, 1), elements=2, approximation=RIGID))
    d.pin(a.start, d.ground)
    d.weld(a.end, b.start)
    d.expose(a.start.rotation, "drive", imposes="angular velocity")
    system = d.compile()
    solution = ph.simulate(system, 1.0, 0.001, inputs={"drive": 2.0})
    turned = 2.0 + np.pi / 4.0
    np.testing.assert_allclose(
        solution.position(b, 1.0)[-1], np.sqrt(2.0) * np.array([np.cos(turned), np.sin(turned)]), rtol=0, atol=3e-6
    )
    assert solution.angle(b, 1.0)[-1] == pytest.approx(np.pi / 2.0 + 2.0, abs=1e-12)


def test_a_frame_that_is_held_more_than_once_is_refused(scenes):
    """Clamped at both feet a rigid frame is statically indeterminate: bending says what its forces are."""
    with pytest.raises(ph.errors.ConstraintError, match="do not follow from each other"):
        scenes["frame"].compile(approximation=RIGID)


def test_a_straight_one_has_the_inertia_of_a_rod():
    block = ph.Beam("b", SOFT, (1.0, 2.0), (4.0, 6.0), elements=3, approximation=RIGID)
    weight = block.rigid
    assert weight.mass == pytest.approx(1.2 * 5.0, rel=1e-14)
    assert weight.inertia == pytest.approx(1.2 * 5.0**3 / 12.0 + 2e-3 * 5.0, rel=1e-13)
    assert weight.centre.tolist() == pytest.approx([2.5, 4.0], rel=1e-14)
    neither = ph.Approximation(flexible=False, rotary_inertia=False)
    thin = ph.Beam("b", SOFT, (1.0, 2.0), (4.0, 6.0), elements=3, approximation=neither)
    assert thin.rigid.inertia == pytest.approx(1.2 * 5.0**3 / 12.0, rel=1e-13)
    assert ph.Beam("b", SOFT, (1.0, 2.0), (4.0, 6.0), elements=3).rigid is None


def test_an_arc_has_the_centre_of_an_arc():
    """A half circle of radius 1: 2/pi from its centre, about which the inertia is m (1 - 4/pi^2)."""
    weight = ph.Beam("b", SOFT, (1.0, 0.0), (-1.0, 0.0), elements=3, curvature=1.0, approximation=RIGID).rigid
    assert weight.centre == pytest.approx([0.0, 2.0 / np.pi], abs=1e-13)
    assert weight.inertia == pytest.approx(1.2 * np.pi * (1.0 - 4.0 / np.pi**2) + 2e-3 * np.pi, rel=1e-12)
