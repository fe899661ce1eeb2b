"""Two blocks become one because they say so: what moves with what, and where the ports are."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.blocks.block import Replacement
from phblocks.causality.edits import merged

SOFT = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)


def test_a_mass_on_a_body_moves_its_centre():
    """1 kg at 0 and 3 kg at 0.4 m: centre at 0.3 m, I = 0.2 + 1 0.3^2 + 3 0.1^2; the frame stays that of the body."""
    d = ph.Diagram()
    a = d.add(ph.RigidBody("a", 1.0, 0.2, (0.0, 0.0), {"p": (0.4, 0.0)}, angle=0.3))
    m = d.add(ph.Mass("m", 3.0, (0.4, 0.0)))
    d.pin(a["p"], m.centre)
    network, what = merged(d.network, "a", "m")
    whole = network.blocks["a-m"]
    assert what == "make one body of 'a' and 'm'" and set(network.blocks) == {"ground", "a-m"}
    assert (whole.mass, whole.angle) == (4.0, 0.3)
    assert whole.inertia == pytest.approx(0.2 + 0.09 + 0.03)
    np.testing.assert_allclose(whole.start, (0.3, 0.0))
    np.testing.assert_allclose(whole["a-p"].position, (0.4, 0.0), atol=1e-15)


def test_two_masses_make_a_mass():
    d = ph.Diagram()
    a, b = d.add(ph.Mass("a", 1.0, (0.4, 0.0))), d.add(ph.Mass("b", 3.0, (0.4, 0.0)))
    d.pin(a.centre, b.centre)
    network, _ = merged(d.network, "a", "b")
    whole = network.blocks["a-b"]
    assert whole.mass == 4.0 and [p.name for p in whole.ports.values()] == ["centre.translation"]


def test_bodies_that_may_turn_against_each_other_stay_two():
    d = ph.Diagram()
    a, b = (d.add(ph.RigidBody(n, 1.0, 0.2, (0.0, 0.0))) for n in "ab")
    d.pin(a.centre, b.centre)
    assert merged(d.network, "a", "b") is None


@pytest.mark.parametrize("follows", [False, True])
def test_a_load_that_would_lose_its_frame_keeps_them_two(follows):
    d = ph.Diagram()
    a = d.add(ph.RigidBody("a", 1.0, 0.2, (0.0, 0.0)))
    b = d.add(ph.RigidBody("b", 1.0, 0.2, (0.0, 0.0), {"p": (1.0, 0.0)}, angle=0.5))
    push = d.add(ph.Force("push", (1.0, 0.0), follows=follows))
    d.weld(a.centre, b.centre)
    d.connect(b["p"].translation, push.port)
    assert (merged(d.network, "a", "b") is None) == follows


def held() -> ph.Diagram:
    d = ph.Diagram()
    a = d.add(ph.RigidBody("a", 1.0, 0.2, (0.0, 0.0), {"p": (1.0, 0.0)}))
    d.weld(a.centre, d.ground)
    return d


def test_the_ground_takes_the_place_of_what_it_holds():
    d = held()
    beam = d.add(ph.Beam("b", SOFT, (1.0, 0.0), (2.0, 0.0), elements=2))
    d.weld(d.network.blocks["a"]["p"], beam.start)
    network, what = merged(d.network, "a", "ground")
    assert what == "leave out 'a', which cannot move, and attach to the ground what hangs on it"
    assert set(network.blocks) == {"ground", "b"}
    assert [j.name for j in network.joined] == [
        "ground.anchor.translation = b.start.translation",
        "ground.anchor.rotation = b.start.rotation",
    ]


def test_the_ground_does_not_take_the_last_block_nor_one_that_is_pushed():
    d = held()
    assert merged(d.network, "a", "ground") is None
    d.add(ph.Mass("m", 1.0, (3.0, 0.0)))
    assert merged(d.network, "a", "ground") is not None
    d.expose(d.network.blocks["a"]["p"].translation, "push", imposes="force")
    assert merged(d.network, "a", "ground") is None


@pytest.mark.parametrize("turned", [False, True])
def test_springs_in_series(turned):
    """Between the outer ends, whichever way round the two are."""
    d = ph.Diagram()
    m = d.add(ph.Mass("m", 1.0, (3.0, 4.0)))
    ends = ((0.0, 2.0), (0.0, 0.0)) if turned else ((0.0, 0.0), (0.0, 2.0))
    a, b = d.add(ph.Spring("a", 30.0, *ends, free_length=1.5)), d.add(ph.Spring("b", 60.0, (0.0, 2.0), (3.0, 4.0)))
    inner, outer = (a.start, a.end) if turned else (a.end, a.start)
    d.pin(inner, b.start)
    d.pin(outer, d.ground)
    d.pin(b.end, m.centre)
    network, what = merged(d.network, "a", "b")
    whole = network.blocks["a-b"]
    assert what == "make one spring of 'a' and 'b' in series"
    assert whole.stiffness == pytest.approx(20.0)
    assert whole.free_length == pytest.approx(1.5 + np.hypot(3.0, 2.0))
    np.testing.assert_allclose(whole.span, (3.0, 4.0))
    assert {j.name for j in network.joined} == {
        "a-b.start.translation = ground.anchor.translation",
        "a-b.end.translation = m.centre.translation",
    }


def test_springs_that_are_not_in_series_stay_two():
    def pair(second, third=None):
        d = ph.Diagram()
        a, b = d.add(ph.Spring("a", 30.0, (0, 0), (1, 0))), d.add(second)
        d.pin(a.end, b.start, *([d.add(third).start] if third else []))
        return d

    line = ((1.0, 0.0), (2.0, 0.0))
    assert merged(pair(ph.Spring("b", 60.0, *line)).network, "a", "b") is not None
    assert merged(pair(ph.Damper("b", 60.0, *line)).network, "a", "b") is None
    assert merged(pair(ph.Spring("b", 60.0, (1.0, 0.0), (0.0, 0.0))).network, "a", "b") is None  # ends meet
    third = ph.Spring("c", 1.0, (1.0, 0.0), (1.0, 1.0))
    assert merged(pair(ph.Spring("b", 60.0, *line), third).network, "a", "b") is None
    pushed = pair(ph.Spring("b", 60.0, *line))
    pushed.expose(pushed.network.blocks["a"].end.translation, "push", imposes="force")
    assert merged(pushed.network, "a", "b") is None


def test_a_block_of_the_users_own_may_merge_too():
    """Nothing in the pipeline asks for a class: the block says what it becomes."""

    class Weight(ph.RigidBody):
        def welded_to(self, other, name):
            here = self.centre.ports
            ports = {p: q for a in other.anchors.values() for p, q in zip(a.ports, here, strict=True)}
            return Replacement(self, {q: q for q in here} | ports, "let the weight swallow it")

    d = ph.Diagram()
    a = d.add(Weight("a", 1.0, 1.0, (0.0, 0.0)))
    b = d.add(ph.RigidBody("b", 2.0, 1.0, (1.0, 0.0), {"p": (0.0, 0.0)}))
    d.weld(a.centre, b["p"])
    first = d.check().repairs[0]
    assert first.what == "let the weight swallow it" and set(first.apply(d).network.blocks) == {"ground", "a"}


@pytest.mark.parametrize("turned", [False, True])
def test_torsion_springs_in_series(turned):
    """1/k = 1/20 + 1/30; twists of 0.5 and 0.3 rad add, that of a spring the other way round counts against."""
    d = ph.Diagram()
    a, b = d.add(ph.TorsionSpring("a", 20.0, twist=0.5)), d.add(ph.TorsionSpring("b", 30.0, twist=0.3))
    wheel = d.add(ph.RigidBody("wheel", 1.0, 0.1, (0.0, 0.0)))
    inner, outer = (a.first, a.second) if turned else (a.second, a.first)
    d.connect(inner, b.first)
    d.connect(outer, d.ground.rotation)
    d.connect(b.second, wheel.centre.rotation)
    repair = d.check().repairs[0]
    assert repair.what == "make one torsion spring of 'a' and 'b' in series"
    mended = repair.apply(d)
    assert mended.network.blocks["a-b"].twist == pytest.approx(-0.2 if turned else 0.8)
    system = mended.compile()
    np.testing.assert_allclose(mended.compile(effects="all").modes(1).frequencies, np.sqrt(12.0 / 0.1), rtol=1e-12)
    # wound up by `twist`, the wheel swings to the other side of where the spring is slack
    period = 2.0 * np.pi / np.sqrt(120.0)
    angle = ph.simulate(system, t_end=period / 2, dt=period / 2000).angle(wheel.centre)
    assert angle[-1] == pytest.approx(0.4 if turned else -1.6, abs=1e-4)


def test_torsion_dampers_in_series():
    d = ph.Diagram()
    a, b = d.add(ph.TorsionDamper("a", 1.0)), d.add(ph.TorsionDamper("b", 3.0))
    d.connect(a.first, d.ground.rotation)
    d.connect(a.second, b.first)
    d.connect(b.second, d.add(ph.RigidBody("wheel", 1.0, 0.1, (0.0, 0.0))).centre.rotation)
    whole = d.check().repairs[0].apply(d).network.blocks["a-b"]
    assert whole.damping == pytest.approx(0.75)
    d.connect(d.add(ph.TorsionSpring("s", 1.0)).first, d.add(ph.TorsionDamper("t", 1.0)).first)
    assert merged(d.network, "s", "t") is None
