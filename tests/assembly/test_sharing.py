"""Welded ends that all give velocity are the same states: ordinary finite-element assembly."""

import itertools

import numpy as np
import pytest

import phblocks as ph
from phblocks.results import books

KINDS = ("translation", "rotation")


@pytest.fixture(scope="module")
def section():
    return ph.Section(axial=3e4, shear=1e4, bending=50.0, mass=1.2, rotary=3e-3)


def straight(section, cuts, causality="free-free", gravity=(0.0, -9.81), **options):
    """A beam along a slope in as many pieces as there are cuts and one; elements of equal length."""
    d = ph.Diagram("straight", gravity=gravity)
    edges = [0.0, *cuts, 1.0]
    pieces = []
    for i, (a, b) in enumerate(itertools.pairwise(edges)):
        place = [(0.6 * s, 0.8 * s) for s in (a, b)]
        elements = round(8 * (b - a))
        pieces.append(
            d.add(ph.Beam(f"b{i}", section, *place, elements=elements, degree=2, causality=causality, **options))
        )
    for left, right in itertools.pairwise(pieces):
        d.weld(left.end, right.start)
    return d, pieces


def ordering(whole, cut):
    """For each state of the whole beam the same one of the beam in pieces, by field and place."""

    def keys(system):
        first = {f"b{i}": s for i, s in enumerate((0.0, 0.5, 0.75))}
        rows = []
        for name, s in zip(system.state_names, system.state_positions, strict=True):
            block, field = name.split("[")[0].split(".")
            rows.append((field, round(s + (first[block] if len(system.parts) > 2 else 0.0), 9)))
        return rows

    a, b = keys(whole), keys(cut)
    order = []
    taken: set[int] = set()
    for key in a:  # discontinuous fields have two states at a place, in the order of elements
        i = next(i for i, other in enumerate(b) if other == key and i not in taken)
        taken.add(i)
        order.append(i)
    return np.array(order)


def test_pieces_of_a_beam_are_the_beam(section):
    """E, J0, T, K_g and the motion of three welded pieces are those of the beam they were cut from."""
    whole, _ = straight(section, [])
    cut, pieces = straight(section, [0.5, 0.75])
    a, b = whole.compile(), cut.compile()
    assert a.n == b.n and b.sharing.expansion.shape == (a.n + 6, a.n)
    order = ordering(a, b)
    for name in ("E", "J0", "R"):
        mine, theirs = getattr(a, name).toarray(), getattr(b, name).toarray()[np.ix_(order, order)]
        np.testing.assert_allclose(theirs, mine, rtol=0, atol=1e-13 * np.abs(mine).max(initial=1.0))
    T, U = a.T.toarray(), b.T.toarray()[np.ix_(order, order, order)]
    np.testing.assert_allclose(U, T, rtol=0, atol=1e-13 * np.abs(T).max())
    np.testing.assert_allclose(b.gravity_force()[order], a.gravity_force(), atol=1e-12)

    start_a, start_b = (s.rigid_motion(velocity=(0.3, 0.1), spin=2.0, about=(0.1, 0.7)) for s in (a, b))
    np.testing.assert_allclose(start_b.x[order], start_a.x, atol=1e-14)
    run_a, run_b = (ph.simulate(s, 0.4, 0.01, start=x) for s, x in ((a, start_a), (b, start_b)))
    assert np.abs(run_a.recording.x[-1]).max() > 1.0  # it bends while it flies
    np.testing.assert_allclose(
        run_b.recording.x[:, order], run_a.recording.x, atol=1e-8 * np.abs(run_a.recording.x).max()
    )
    tip_a = run_a.position(whole.network.blocks["b0"], 1.0)
    np.testing.assert_allclose(run_b.position(pieces[2], 1.0), tip_a, atol=1e-9)
    np.testing.assert_allclose(run_b.position(pieces[1], 1.0), run_b.position(pieces[2], 0.0), atol=1e-12)
    np.testing.assert_allclose(run_b.angle(pieces[0], 1.0), run_b.angle(pieces[1], 0.0), atol=1e-14)
    np.testing.assert_allclose(run_b.velocity(pieces[0], 1.0), run_b.velocity(pieces[1], 0.0), atol=1e-12)


def frame(section, causality="auto", n=4, degree=2, gravity=(0.0, -9.81), **how):
    """A triangle of welded beams, free in space."""
    corners = [(0.0, 0.0), (1.0, 0.0), (0.3, -0.8)]
    d = ph.Diagram("triangle", gravity=gravity)
    beams = [
        d.add(ph.Beam(name, section, a, b, elements=n, degree=degree, causality=causality))
        for name, (a, b) in zip("abc", [(corners[i], corners[(i + 1) % 3]) for i in range(3)], strict=True)
    ]
    for i in range(3):
        d.weld(beams[i].end, beams[(i + 1) % 3].start, **how)
    return d, beams


def test_what_passes_through_shared_states_is_what_multipliers_transmit(section):
    """The ledger defines it as what each beam misses; with joints that have forces of their own it can be measured.

    The same triangle, its corners held by multipliers: there each corner transmits force times velocity.
    """
    received, runs = [], []
    for multiplier in (False, True):
        d, _ = frame(section, causality="free-free", multiplier=multiplier)
        system = d.compile()
        assert (len(system.sharing.groups), system.is_dae) == ((0, True) if multiplier else (1, False))
        start = system.rigid_motion(velocity=(0.5, 2.0), spin=6.0)
        runs.append(ph.simulate(system, 0.2, 0.002, start=start))
        received.append(np.stack([runs[-1].power.blocks[x]["received"] for x in "abc"]))
    scale = runs[0].energy.kinetic.max()
    assert not runs[0].power.connections and np.abs(received[0]).max(axis=1).min() > 0.05 * scale
    np.testing.assert_allclose(received[0], received[1], rtol=0, atol=1e-12 * scale)
    of_joints = runs[1].power.connections
    corners = [sum(of_joints[f"{x}.end.{k}", f"weld {x} {y}.first.{k}"] for k in KINDS) for x, y in ("ab", "bc", "ca")]
    for i in range(3):  # in through one corner, out through the next
        np.testing.assert_allclose(received[0][i], corners[i - 1] - corners[i], rtol=0, atol=1e-12 * scale)


def test_blocks_that_share_have_one_balance(section):
    """Of one of them alone there is nothing to be tested, and the ledger does not claim it."""
    d, _ = frame(section, n=2)
    d.add(ph.Mass("stone", 1.0, (5.0, 5.0)))
    system = d.compile()
    power = ph.simulate(system, 0.1, 0.01).power
    assert list(power.block_errors) == ["ground", "a + b + c", "stone"]
    assert max(power.block_errors.values()) < 1e-12
    table = {line.split("  ")[0]: line.split()[-1] for line in str(power).splitlines()[1:]}
    assert {x: table[x] for x in "abc"} == dict.fromkeys("abc", "shares")
    assert table["a + b + c"] == f"{power.block_errors['a + b + c']:.2e}"


def test_the_balance_of_those_that_share_can_fail(section, monkeypatch):
    """Books that miss a thousandth of the gravity of one beam: seen in the balance of all three."""
    d, _ = frame(section, n=2)
    system = d.compile()
    true = books.Books.potential

    def wrong(self, points):
        values = true(self, points)
        values[:, 1] *= 1.001
        return values

    monkeypatch.setattr(books.Books, "potential", wrong)
    with pytest.warns(ph.errors.HealthWarning, match=r"energy balance, worst step: .* \(a \+ b \+ c, t = "):
        power = ph.simulate(system, 0.1, 0.01).power
    assert power.block_errors["a + b + c"] > 1e-5 and power.worst[0] == "a + b + c"


def test_a_welded_frame_shares_by_itself(section):
    d, _ = frame(section)
    report = d.check()
    assert report.ok and not report.switches
    assert {frozenset(p.path for p in team) for team in report.shared} == {
        frozenset({f"{a}.end.{kind}", f"{b}.start.{kind}"})
        for a, b in ("ab", "bc", "ca")
        for kind in ("translation", "rotation")
    }
    assert "shared states: a.end.translation, b.start.translation" in str(report)
    system = d.compile()
    alone = [ph.Beam("x", section, (0, 0), (1, 0), elements=4, degree=2, causality="free-free")]
    of_one = alone[0].form({p: True for p in alone[0].ports}).size
    assert system.n == 3 * of_one - 9


def test_sharing_and_choosing_agree_when_the_mesh_is_refined(section):
    """Frequencies of the triangle: all ends sharing, against one shared corner and switches elsewhere."""

    def frequencies(n, causality):
        d, _ = frame(section, n=n, gravity=None)
        if causality == "mixed":
            d2 = ph.Diagram("mixed")
            corners = [(0.0, 0.0), (1.0, 0.0), (0.3, -0.8)]
            kinds = ("free-clamped",) * 3
            beams = [
                d2.add(ph.Beam(x, section, corners[i], corners[(i + 1) % 3], elements=n, degree=2, causality=kinds[i]))
                for i, x in enumerate("abc")
            ]
            for i in range(3):
                d2.weld(beams[i].end, beams[(i + 1) % 3].start)
            assert not d2.check().shared
            d = d2
        return d.compile().modes(3).frequencies

    shared, switched = frequencies(12, "auto"), frequencies(12, "mixed")
    np.testing.assert_allclose(shared, switched, rtol=2e-5)
    assert np.abs(frequencies(4, "auto") / shared - 1.0).max() < 1e-2


def test_a_frame_in_large_motion_balances_and_stays_closed(section):
    d, beams = frame(section)
    system = d.compile()
    random = np.random.default_rng(3)
    J = system.J(random.standard_normal(system.n), random.standard_normal(system.start.theta.size))
    assert abs(J + J.T).max() <= 1e-12 * abs(J).max()
    start = system.rigid_motion(velocity=(0.5, 2.0), spin=6.0)
    solution = ph.simulate(system, 0.5, 0.005, start=start)
    energy = solution.energy.total
    assert np.ptp(energy) < 1e-11 * solution.energy.kinetic.max()
    for i in range(3):
        gap = solution.position(beams[i], 1.0, source="strain") - solution.position(
            beams[(i + 1) % 3], 0.0, source="strain"
        )
        assert np.abs(gap).max() < 2e-3  # closed in velocity: bounded by the order of the step
        np.testing.assert_allclose(
            solution.velocity(beams[i], 1.0, frame="fixed"),
            solution.velocity(beams[(i + 1) % 3], 0.0, frame="fixed"),
            atol=1e-10,
        )


def test_forces_and_exposed_ports_act_once_where_ends_are_shared(section):
    """A force on a shared corner accelerates the frame by what its mass says."""
    d, beams = frame(section, gravity=None)
    d.expose(beams[0].end.translation, "push")
    system = d.compile()
    G = system.G().toarray()
    v = system.rigid_motion(velocity=(1.0, 0.0)).x
    assert v @ G == pytest.approx([1.0, 0.0])
    w = system.rigid_motion(spin=1.0).x
    assert w @ G == pytest.approx([0.0, 1.0])  # the corner is at (1, 0)
    mass = v @ system.E @ v
    assert mass == pytest.approx(1.2 * sum(b.length for b in beams))
    solution = ph.simulate(system, 0.2, 0.01, inputs={"push": (3.0, 0.0)})
    momentum = solution.recording.x @ (system.E @ v)
    assert solution.max_power_balance_error < 1e-13
    assert solution.energy.supplied[-1] > 0.0
    assert momentum[1] == pytest.approx(3.0 * 0.01, rel=1e-2)


def test_masses_in_one_place_are_one_mass():
    d = ph.Diagram("masses", gravity=(0.0, -9.81))
    a, b = d.add(ph.Mass("a", 2.0, (0.0, 0.0))), d.add(ph.Mass("b", 3.0, (0.0, 0.0)))
    c = d.add(ph.Mass("c", 1.0, (0.0, -1.0)))
    s = d.add(ph.Spring("s", 80.0, (0.0, 0.0), (0.0, -1.0)))
    d.pin(a.centre, b.centre, s.start)
    d.pin(s.end, c.centre)
    system = d.compile()
    assert [sorted(system.parts[i].name for i in group) for group in system.sharing.groups] == [["a", "b"]]
    assert d.compile(effects="all").modes(1).frequencies[-1] == pytest.approx(np.sqrt(80.0 * (1 / 5 + 1)))
    solution = ph.simulate(system, 1.0, 0.01)
    np.testing.assert_allclose(solution.position(a.centre), solution.position(b.centre), atol=1e-13)
    assert solution.position(a.centre)[-1, 1] == pytest.approx(-0.5 * 9.81, rel=1e-9)
    assert solution.power.blocks["b"]["received"][-1] == pytest.approx(0.0, abs=1e-11)  # they fall together


def test_a_beam_shares_the_spin_of_a_body(section):
    """Welded to a body off its centre, a beam takes the velocity there and shares the angular velocity."""
    d = ph.Diagram("hub")
    hub = d.add(ph.RigidBody("hub", 2.0, 0.1, (0.0, 0.0), {"rim": (0.2, 0.0)}))
    arm = d.add(ph.Beam("arm", section, (0.2, 0.0), (1.2, 0.0), elements=4, degree=2, causality="auto"))
    d.weld(hub["rim"], arm.start)
    report = d.check()
    assert [sorted(p.path for p in team) for team in report.shared] == [["arm.start.rotation", "hub.rim.rotation"]]
    system = d.compile()
    solution = ph.simulate(system, 0.5, 0.005, start=system.rigid_motion(spin=3.0))
    np.testing.assert_allclose(solution.angle(hub["rim"]), solution.angle(arm, 0.0), atol=1e-13)
    assert np.ptp(solution.energy.total) < 1e-12 * solution.energy.total[0]


def test_the_same_whatever_the_order_of_adding(section):
    def build(order):
        corners = {"a": ((0, 0), (1, 0)), "b": ((1, 0), (0.3, -0.8)), "c": ((0.3, -0.8), (0, 0))}
        d = ph.Diagram("triangle")
        beams = {x: d.add(ph.Beam(x, section, *corners[x], elements=3)) for x in order}
        for x, y in ("ab", "bc", "ca"):
            d.weld(beams[x].end, beams[y].start)
        return d

    first = build("abc")
    for order in ("bca", "cab", "cba"):
        other = build(order)
        assert {a.port.path: a.gives for a in other.check().assignments} == {
            a.port.path: a.gives for a in first.check().assignments
        }
        np.testing.assert_allclose(
            other.compile().modes(3).frequencies, first.compile().modes(3).frequencies, rtol=1e-9
        )
