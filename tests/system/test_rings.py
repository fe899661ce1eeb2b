"""Rings of parts that pass power on at once: refused by name if nothing determines them, solved if they are passive."""

import re

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ConstraintError, UndeterminedError


def ring(*ratios: float, kind=ph.Transformer) -> ph.Diagram:
    """Parts in a ring, each one's second port on the next one's first."""
    d = ph.Diagram("ring")
    parts = [d.add(kind(f"t{i}", ratio, ph.ELECTRICAL, ph.ELECTRICAL)) for i, ratio in enumerate(ratios)]
    for part, after in zip(parts, [*parts[1:], parts[0]], strict=True):
        d.connect(part.second, after.first)
    return d


def at_ports(d: ph.Diagram) -> str:
    with pytest.raises(UndeterminedError) as caught:
        d.compile()
    error = caught.value
    assert error.code == "PH307" and isinstance(error, ConstraintError)
    for name in d.network.blocks:
        assert name == "ground" or f"{name} (add at test_rings.py:" in error.where
    return error.got


@pytest.mark.parametrize("ratios", [(1.0, 1.0), (2.0, 0.5), (2.0, 0.25, 2.0), (-1.0, 4.0, -0.5, 0.5)])
def test_a_ring_of_transformers_whose_ratios_multiply_to_one(ratios):
    """Any voltage goes round unchanged, and any current: two vectors, told at the ports that give them."""
    got = at_ports(ring(*ratios))
    assert got.count("can be added to any solution") == 2
    amperes, volts = sorted(got.split("; and "))
    assert "voltage of" in volts and "current of" not in volts
    assert "current of" in amperes and "voltage of" not in amperes


def test_the_vector_has_the_ratios():
    """u_second = 2 u_first in t0, 1/4 in t1, 2 in t2: 0.5, 1, 0.25 round the ring wherever one gives."""
    got = at_ports(ring(2.0, 0.25, 2.0))
    values = {port: float(v) for port, v in re.findall(r"voltage of (\S+) (\S+?)(?=,| )", got)}
    at_junction = {
        "t0.first": 0.5,
        "t2.second": 0.5,
        "t0.second": 1.0,
        "t1.first": 1.0,
        "t1.second": 0.25,
        "t2.first": 0.25,
    }
    assert len(values) == 3
    scale = max(at_junction[name] for name in values)
    for name, value in values.items():
        assert value == pytest.approx(at_junction[name] / scale, abs=2e-3), got


@pytest.mark.parametrize("ratios", [(2.0, 3.0), (2.0, 2.0, 2.0)])
def test_another_ratio_holds_the_ring_still(ratios):
    solution = ph.simulate(ring(*ratios).compile(), t_end=0.1, dt=0.05)
    assert np.abs(solution.x).max() == 0.0


def test_gyrators_in_a_ring():
    """Back to back with opposite ratios they undo each other; with equal ones they do not."""
    d = ring(2.0, 2.0, kind=ph.Gyrator)
    assert "current of" in at_ports(d) and "voltage of" in at_ports(d)
    ring(2.0, -2.0, kind=ph.Gyrator).compile()
    ring(2.0, 3.0, kind=ph.Gyrator).compile()


def test_a_source_on_such_a_ring_has_no_solution():
    d = ring(2.0, 0.5)
    push = d.add(ph.Current("push", 1.0))
    parts = d.network.blocks
    d.network.joined.clear()
    d.network.junction_of.clear()
    d.connect(parts["t0"].second, parts["t1"].first, push.port)
    d.connect(parts["t1"].second, parts["t0"].first)
    with pytest.raises(UndeterminedError, match=r"t0 \(add at .*t1 \(add at"):
        d.compile()


def test_a_ring_beside_a_resistor_is_named_without_it():
    """A current round the ring never meets the resistor, so its loss does not help."""
    d = ph.Diagram()
    one, two = (d.add(ph.Transformer(n, 2.0, ph.ELECTRICAL, ph.ELECTRICAL)) for n in ("one", "two"))
    r, earth = d.add(ph.Resistor("r", 5.0)), d.add(ph.Reference("earth"))
    d.connect(one.first, two.first, r.p)
    d.connect(one.second, two.second)
    d.connect(r.n, earth.port)
    with pytest.raises(UndeterminedError) as caught:
        d.compile()
    assert "one" in caught.value.where and "two" in caught.value.where and "r (" not in caught.value.where
    assert "voltage" not in caught.value.got  # the resistor holds that


def test_gears_in_a_ring_on_shafts_that_turn():
    """Mechanical words; an inertia on the ring makes the two gears two constraints, of which one is redundant."""
    d = ph.Diagram()
    one, two = d.add(ph.Transformer("one", 3.0)), d.add(ph.Transformer("two", 3.0))
    d.connect(one.first, two.first)
    d.connect(one.second, two.second)
    with pytest.raises(UndeterminedError, match=r"moment of .* angular velocity of"):
        d.compile()
    d = ph.Diagram()
    one, two = d.add(ph.Transformer("one", 3.0, multiplier=True)), d.add(ph.Transformer("two", 3.0, multiplier=True))
    a, b = (d.add(ph.RigidBody(n, 1.0, 1.0, (0.0, 0.0))) for n in "ab")
    d.connect(one.first, two.first, a.centre.rotation)
    d.connect(one.second, two.second, b.centre.rotation)
    with pytest.raises(ConstraintError, match=r"PH302.*imply already"):
        d.compile()


# Passive rings are solved


def test_currents_of_a_bridge_by_hand():
    """Five resistors, every node in a loop of resistors: node voltages from Kirchhoff's laws, solved as 2 by 2."""
    d = ph.Diagram()
    source, earth = d.add(ph.Voltage("v", 10.0)), d.add(ph.Reference("earth"))
    r = {n: d.add(ph.Resistor(f"r{n}", float(n))) for n in range(1, 6)}
    d.connect(source.port, r[1].p, r[2].p)
    d.connect(r[1].n, r[3].p, r[5].p)
    d.connect(r[2].n, r[4].p, r[5].n)
    d.connect(r[3].n, earth.port)
    d.connect(r[4].n, earth.port)
    solution = ph.simulate(d.compile(), t_end=0.2, dt=0.1)
    # (1/1 + 1/3 + 1/5) a - b/5 = 10/1,  -a/5 + (1/2 + 1/4 + 1/5) b = 10/2
    det = (23 / 15) * (19 / 20) - 1 / 25
    a, b = (10 * 19 / 20 + 5 / 5) / det, (5 * 23 / 15 + 10 / 5) / det
    for n, drop in {1: 10 - a, 2: 10 - b, 3: a, 4: b, 5: a - b}.items():
        np.testing.assert_allclose(solution.state(f"r{n}.current[0]")[1:], drop / n, rtol=1e-12)
    lost = sum(drop**2 / n for n, drop in {1: 10 - a, 2: 10 - b, 3: a, 4: b, 5: a - b}.items())
    np.testing.assert_allclose(solution.energy["dissipated"][-1], 0.2 * lost, rtol=1e-12)


def feedthrough(name: str, matrix: list[list[float]], gives: str) -> ph.SystemBlock:
    """y = D u with ports a and b that both give voltage, or both current."""
    D = np.array(matrix)
    none = np.zeros((0, 0))
    ports = {key: ph.SystemPort(ph.ELECTRICAL, [i], gives=gives) for i, key in enumerate("ab")}
    return ph.SystemBlock(name, J=none, G=np.zeros((0, 2)), S=(D + D.T) / 2, N=(D - D.T) / 2, ports=ports)


@pytest.mark.parametrize("turn", [0.0, 0.7, -3.0])
def test_a_ring_of_feedthrough_with_a_loss_is_solved_whatever_its_skew_part(turn):
    """v = D1 i, i + D2 v = i0 with D + D^T > 0 in both: i = (1 + D2 D1)^-1 i0, which exists for every skew part."""
    D1, D2 = np.array([[2.0, turn], [-turn, 1.0]]), np.array([[1.0, -turn], [turn, 0.5]])
    d = ph.Diagram()
    one, two = d.add(feedthrough("one", D1.tolist(), "voltage")), d.add(feedthrough("two", D2.tolist(), "current"))
    push = [d.add(ph.Current(f"push {k}", i)) for k, i in zip("ab", (1.0, -2.0), strict=True)]
    for key, source in zip("ab", push, strict=True):
        d.connect(one[key], two[key], source.port)
    solution = ph.simulate(d.compile(), t_end=0.1, dt=0.05)
    current = np.linalg.solve(np.eye(2) + D2 @ D1, [1.0, -2.0])
    supplied = 0.1 * float(np.array([1.0, -2.0]) @ D1 @ current)
    np.testing.assert_allclose(solution.energy["supplied"][-1], supplied, rtol=1e-12)
    np.testing.assert_allclose(solution.energy["dissipated"][-1], supplied, rtol=1e-12)
    for k, v in zip("ab", D1 @ current, strict=True):
        np.testing.assert_allclose(solution.state(f"one.given{'ab'.index(k)}[0]")[1:], v, rtol=1e-12)


def test_the_same_ring_without_loss_is_refused_where_it_is_singular():
    """1 + D2 D1 = 0 for D1 = D2 = a quarter turn: nothing is lost, nothing is determined."""
    quarter = [[0.0, 1.0], [-1.0, 0.0]]
    for factor in (1.0, 2.0):
        d = ph.Diagram()
        one, two = (
            feedthrough("one", quarter, "voltage"),
            feedthrough("two", [[0.0, factor], [-factor, 0.0]], "current"),
        )
        d.add(one), d.add(two)
        d.connect(one["a"], two["a"])
        d.connect(one["b"], two["b"])
        if factor == 1.0:
            got = at_ports(d)
            assert "voltage of one." in got and "current of two." in got
        else:
            d.compile()


def test_a_ring_beside_beams_that_share_their_states():
    """The vectors are of states, the ports of blocks: two beams that share come first here."""
    section = ph.Section(axial=1e4, shear=1e4, bending=10.0, mass=1.0, rotary=1e-3)
    d = ph.Diagram()
    a, b = (d.add(ph.Beam(n, section, (i, 0.0), (i + 1, 0.0), elements=2)) for n, i in (("a", 0.0), ("b", 1.0)))
    d.weld(a.end, b.start)
    gears = [d.add(ph.Transformer(f"gear {i}", 1.0, multiplier=True)) for i in range(2)]
    shaft = d.add(ph.RigidBody("shaft", 1.0, 1.0, (5.0, 0.0)))
    d.connect(gears[0].first, gears[1].first, shaft.centre.rotation)
    d.connect(gears[0].second, gears[1].second, d.ground.rotation)
    with pytest.raises((UndeterminedError, ConstraintError), match="gear"):
        d.compile()
    assert d.check().shared
