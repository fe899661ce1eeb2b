"""Diagrams that cannot be: the exact conflict, the repairs in their order, and the first repair in motion."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import CausalityError, DanglingPortError, OverdeterminedError, UnderdeterminedError

SOFT = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)


def bodies_pinned() -> ph.Diagram:
    """Two rigid bodies, m 1 and 2 kg, I 0.1 kg m^2, pinned half a metre off both centres of mass."""
    d = ph.Diagram("two bodies", gravity=(0.0, -9.81))
    a = d.add(ph.RigidBody("a", 1.0, 0.1, (0.5, 0.0), {"right": (1.0, 0.0)}))
    b = d.add(ph.RigidBody("b", 2.0, 0.1, (1.5, 0.0), {"left": (1.0, 0.0)}))
    d.pin(a["right"], b["left"])
    return d


def spring_between_springs() -> ph.Diagram:
    """Springs of 10, 20 and 30 N/m in a row between two masses, stretched by half a metre altogether."""
    d = ph.Diagram("springs")
    m, n = d.add(ph.Mass("m", 1.0, (0.0, 0.0))), d.add(ph.Mass("n", 2.0, (3.5, 0.0)))
    a = d.add(ph.Spring("a", 10.0, (0.0, 0.0), (1.0, 0.0)))
    b = d.add(ph.Spring("b", 20.0, (1.0, 0.0), (2.0, 0.0)))
    c = d.add(ph.Spring("c", 30.0, (2.0, 0.0), (3.5, 0.0), free_length=1.0))
    d.pin(m.centre, a.start)
    d.pin(a.end, b.start)
    d.pin(b.end, c.start)
    d.pin(c.end, n.centre)
    return d


def loop_of_velocity_sources() -> ph.Diagram:
    """Ground, source, gear, source, ground: the gear ties the two angular velocities to each other."""
    d = ph.Diagram("loop")
    gear = d.add(ph.Transformer("gear", 2.0))
    one = d.add(ph.AngularVelocity("one", 1.0))
    two = d.add(ph.AngularVelocity("two", lambda t: 3.0 * np.sin(5.0 * t)))
    arm = d.add(ph.Beam("arm", SOFT, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(arm.start, d.ground)
    d.connect(one.port, gear.first)
    d.connect(gear.second, two.port, arm.start.rotation)
    return d


def only_a_switch() -> ph.Diagram:
    """A beam that takes velocity at both ends, one of them free: nothing gives there, unless it switches inside."""
    d = ph.Diagram("switch", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("beam", SOFT, (0.0, 0.0), (1.0, 0.0), elements=4, causality="pinned-pinned"))
    d.pin(beam.start, d.ground)
    return d


@dataclass(frozen=True)
class Case:
    make: Callable[[], ph.Diagram]
    error: type
    conflicts: list[tuple[set[str], set[str], set[str]]]  # junctions, ports without a choice, ties
    repairs: list[str]


CASES = [
    Case(
        bodies_pinned,
        OverdeterminedError,
        [({"a.right.translation = b.left.translation"}, {"a.right.translation", "b.left.translation"}, set())],
        [
            "put a bushing of 6.67e+05 N/m between a.right and b.left"
            " (states +4, stiffness 6.67e+05, frequency 2.08e+03 rad/s)",
            "hold a, b together by a multiplier (multiplier=True) (states +2, index +2)",
        ],
    ),
    Case(
        spring_between_springs,
        UnderdeterminedError,
        [
            ({"a.end.translation = b.start.translation"}, {"a.end.translation", "b.start.translation"}, set()),
            ({"b.end.translation = c.start.translation"}, {"b.end.translation", "c.start.translation"}, set()),
        ],
        [
            "make one spring of 'a' and 'b' in series, and make one spring of 'a-b' and 'c' in series (states -6)",
            "put a point mass of 0.03 kg at [a.end.translation = b.start.translation], "
            "and put a point mass of 0.0333 kg at [b.end.translation = c.start.translation]"
            " (states +4, mass 0.0333, frequency 38.7 rad/s)",
        ],
    ),
    Case(
        loop_of_velocity_sources,
        CausalityError,
        [
            (
                {
                    "one.port = gear.first = outside 'one'",
                    "gear.second = two.port = arm.start.rotation = outside 'two'",
                },
                set(),
                {"gear gives at both ports or at none"},
            )
        ],
        [
            "leave out 'one', which imposes angular velocity (states +0)",
            "leave out 'two', which imposes angular velocity (states +0)",
        ],
    ),
    Case(
        only_a_switch,
        DanglingPortError,
        [({"beam.end.translation"}, {"beam.end.translation"}, set())],
        [
            'let beam \'beam\' choose its ends (causality="auto", was "pinned-pinned") (states +2, switches +1)',
            "attach beam.end.translation to the ground (states +0)",
        ],
    ),
]
NAMED = pytest.mark.parametrize("case", CASES, ids=[c.make.__name__ for c in CASES])


@NAMED
def test_the_conflict_is_named_exactly(case):
    d = case.make()
    found = [
        ({j.name for j in c.junctions}, {p.path for p in c.fixed}, {t.what for t in c.ties})
        for c in d.check().conflicts
    ]
    assert found == case.conflicts
    assert {c.error for c in d.check().conflicts} == {case.error}
    with pytest.raises(case.error) as caught:
        d.compile()
    assert type(caught.value) is case.error and case.repairs[0].split(" (states")[0] in caught.value.fix


@NAMED
def test_the_repairs_come_in_this_order(case):
    assert [str(repair) for repair in case.make().check().repairs] == case.repairs


@NAMED
def test_the_first_repair_moves_with_exact_energy(case):
    d = case.make()
    mended = d.check().repairs[0].apply(d)
    assert mended.check().ok and not d.check().ok
    solution = ph.simulate(mended.compile(), t_end=1.0, dt=0.005)
    assert solution.status.name == "success"
    moved = float(np.ptp(solution.energy["kinetic"]))
    assert moved > 0.1
    assert solution.max_power_balance_error < 1e-11 * moved


def test_two_bodies_on_the_bushing_fall_as_if_pinned():
    """The bushing of the first repair follows the multiplier of the second; the free fall of the centre is exact."""
    d = bodies_pinned()
    soft, hard = (
        ph.simulate(s := r.apply(d).compile(), t_end=0.5, dt=0.001, start=s.rigid_motion(spin=2.0, blocks=["a"]))
        for r in d.check().repairs
    )
    for name in ("a", "b"):
        gap = np.abs(soft.position(name, (0.0, 0.0)) - hard.position(name, (0.0, 0.0))).max()
        assert 0.0 < gap < 3e-3


def test_springs_in_series_swing_as_one():
    """1/k = 1/10 + 1/20 + 1/30 between masses of 1 and 2 kg; all of the energy is that of 0.5 m of extension."""
    d = spring_between_springs()
    repaired = d.check().repairs[0].apply(d)
    k, reduced = 60.0 / 11.0, 2.0 / 3.0
    # across, the tension k 0.5 m over the length 3.5 m holds the masses in line
    expected = [np.sqrt(k * 0.5 / 3.5 / reduced), np.sqrt(k / reduced)]
    np.testing.assert_allclose(repaired.compile(effects="all").modes(2).frequencies, expected, rtol=1e-12)
    solution = ph.simulate(repaired.compile(), t_end=1.0, dt=0.001)
    np.testing.assert_allclose(solution.energy["total"], 0.5 * k * 0.5**2, rtol=1e-12)
    omega = np.sqrt(k / reduced)
    speed = 0.5 * omega * reduced * np.sin(omega * solution.t)
    np.testing.assert_allclose(solution.state("m.vx[0]"), speed, atol=1e-5)


def test_whichever_source_is_left_turns_the_arm():
    """Left alone, source two turns the arm at 3 sin 5t; source one, through the gear, at 2."""
    d = loop_of_velocity_sources()
    for repair, expected in zip(
        d.check().repairs, (lambda t: 3.0 * np.sin(5.0 * t), lambda t: 2.0 + 0.0 * t), strict=True
    ):
        solution = ph.simulate(repair.apply(d).compile(), t_end=0.3, dt=0.001)
        turned = np.cumsum(expected(solution.t[:-1] + 0.0005)) * 0.001
        np.testing.assert_allclose(solution.angle("arm", 0.0)[1:], turned, atol=1e-10)


def test_the_switch_is_where_the_report_says():
    d = only_a_switch()
    mended = d.check().repairs[0].apply(d)
    beam = mended.network.blocks["beam"]
    assert beam.end_names(mended.check().gives("beam")) == "pinned-free"
    assert mended.check().switches == ("a switch of translation inside beam 'beam'",)
