"""Diagrams nest: the same matrices as built flat, the same diagram many times, and what cannot be nested."""

import itertools

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import (
    ArgumentTypeError,
    DataError,
    DuplicateNameError,
    ForeignBlockError,
    NestingError,
    PortInUseError,
    UnknownNameError,
)

BAR = ph.Section(axial=1e5, shear=4e4, bending=50.0, mass=0.7, rotary=1e-3)


def assert_equal_by_names(nested: ph.System, flat: ph.System) -> None:
    """E, J, R and G are equal after ordering states, rotation states and inputs by name, at a random state."""
    assert nested.n == flat.n and set(nested.state_names) == set(flat.state_names)
    assert set(nested.input_names) == set(flat.input_names)
    states = [nested.state_names.index(name) for name in flat.state_names]
    turns = [nested.theta_names.index(name) for name in flat.theta_names]
    inputs = [nested.input_names.index(name) for name in flat.input_names]
    rng = np.random.default_rng(5)
    x, theta = rng.standard_normal(flat.n), rng.standard_normal(len(turns))
    y, phi = np.empty_like(x), np.empty_like(theta)
    y[states], phi[turns] = x, theta
    at = np.ix_(states, states)
    np.testing.assert_array_equal(nested.E.toarray()[at], flat.E.toarray())
    np.testing.assert_array_equal(nested.R.toarray()[at], flat.R.toarray())
    J = flat.J(x, theta).toarray()
    np.testing.assert_allclose(nested.J(y, phi).toarray()[at], J, rtol=0.0, atol=1e-14 * np.abs(J).max())
    G = flat.G(theta).toarray()
    np.testing.assert_allclose(nested.G(phi).toarray()[np.ix_(states, inputs)], G, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(nested.gravity_force(phi)[states], flat.gravity_force(theta), rtol=1e-13, atol=1e-13)


def four_bar(d: ph.Diagram, prefix: str = "", feet=None) -> list[ph.Beam]:
    """Three bars on two feet, which are the ground's if none are given."""
    places = ((0.0, 0.5), (2.0, 1.5), (3.5, 1.5), (2.5, 0.5))
    names = ("crank", "coupler", "rocker")
    bars = [
        d.add(ph.Beam(prefix + name, BAR, *ends, elements=3))
        for name, ends in zip(names, itertools.pairwise(places), strict=True)
    ]
    for left, right in itertools.pairwise(bars):
        d.pin(left.end, right.start)
    d.expose(bars[1].end.rotation, prefix + "moment")
    return bars


def frame(d: ph.Diagram, crank: ph.Beam, rocker: ph.Beam) -> None:
    """A beam that the linkage stands on, clamped to the ground at one end and sprung at the other."""
    base = d.add(ph.RigidBody("base", 3.0, 0.4, (1.0, 0.0), {"left": (0.0, 0.5), "right": (2.5, 0.5), "foot": (1, -1)}))
    spring = d.add(ph.Spring("spring", 1e3, (1.0, -2.0), (1.0, -1.0)))
    d.pin(base["left"], crank.start)
    d.pin(base["right"], rocker.end)
    d.pin(spring.end, base["foot"])
    d.pin(d.ground, spring.start)


@pytest.mark.parametrize("outside_first", [True, False])
def test_a_four_bar_in_a_frame(outside_first):
    inner, outer, flat = (ph.Diagram(name, gravity=(0.0, -9.81)) for name in ("linkage", "machine", "machine"))
    bars = four_bar(inner)
    if outside_first:
        outer.add(ph.Mass("ballast", 2.0, (9.0, 9.0)))
    linkage = outer.add(inner)
    if not outside_first:
        outer.add(ph.Mass("ballast", 2.0, (9.0, 9.0)))
    assert list(linkage) == ["crank", "coupler", "rocker"]
    assert linkage["crank"] is linkage[bars[0]] and linkage[bars[0]].name == "linkage/crank"
    frame(outer, linkage[bars[0]], linkage[bars[2]])
    flat.add(ph.Mass("ballast", 2.0, (9.0, 9.0)))
    crank, _, rocker = four_bar(flat, "linkage/")
    frame(flat, crank, rocker)
    assert_equal_by_names(outer.compile(), flat.compile())
    nested = outer.compile(effects="all")  # the ballast only falls; spun, it moves sideways too
    start = nested.rigid_motion(spin=0.5)
    solution = ph.simulate(nested, 0.05, 0.005, start=start, inputs={"linkage/moment": 3.0})
    assert solution.status.ok and solution.max_power_balance_error < 1e-11
    assert solution.position(linkage[bars[1]], 0.5).shape == (11, 2)


@pytest.mark.parametrize("seed", range(6))
def test_a_random_chain_nested_at_random_depths(seed):
    """Links of all kinds; runs of them in diagrams inside diagrams, the joints inside or outside."""
    rng = np.random.default_rng(seed)
    flat = ph.Diagram("flat", gravity=(1.0, -2.0))
    place, count = np.zeros(2), 0

    def link(d, prefix):
        nonlocal place, count
        end = place + rng.uniform(0.3, 1.0, 2)
        name, kind = f"link {count}", rng.integers(3)
        made = []
        for diagram, called in ((d, name), (flat, prefix + name)):
            beam = ph.Beam(called, BAR, place, end, elements=2 + int(kind))
            made.append(diagram.add(beam))
            if kind == 1:
                diagram.expose(beam.end.rotation, f"{called} turned")
            if kind == 2:
                force = diagram.add(ph.Moment(f"{called} motor", 2.0))
                diagram.connect(force.port, beam.end.rotation)
        place, count = end, count + 1
        return made

    def grow(d, prefix, depth):
        """Chain of items of d; first and last beam of the chain, here and flat."""
        ends = []
        for i in range(rng.integers(1, 4)):
            if depth and rng.random() < 0.6:
                inner = ph.Diagram(f"part {i}")
                first, last = grow(inner, f"{prefix}part {i}/", depth - 1)
                nested = d.add(inner)
                ends.append(((nested[first[0]], first[1]), (nested[last[0]], last[1])))
            else:
                beam = link(d, prefix)
                ends.append((beam, beam))
        for (_, left), (right, _) in itertools.pairwise(ends):
            d.pin(left[0].end, right[0].start)
            flat.pin(left[1].end, right[1].start)
        return ends[0][0], ends[-1][1]

    outer = ph.Diagram("outer", gravity=(1.0, -2.0))
    (first, flat_first), _ = grow(outer, "", 3)
    outer.pin(first.start, outer.ground)
    flat.pin(flat_first.start, flat.ground)
    assert_equal_by_names(outer.compile(), flat.compile())


def test_the_same_diagram_twice_and_blocks_of_every_kind():
    """Copies have states, sources and joints of their own; the ground is one."""
    inner = ph.Diagram("unit")
    body = inner.add(ph.RigidBody("body", 1.0, 0.1, (0.0, 0.0), {"foot": (0.0, -1.0), "side": (1.0, 0.0)}))
    mass = inner.add(ph.Mass("mass", 1.0, (2.0, 0.0)))
    spring = inner.add(ph.Spring("spring", 10.0, (1.0, 0.0), (2.0, 0.0)))
    push = inner.add(ph.Force("push", (1.0, 0.0)))
    torsion = inner.add(ph.TorsionSpring("torsion", 4.0))
    matrices = inner.add(ph.SystemBlock("matrices", E=np.eye(1), J=np.zeros((1, 1)), R=np.eye(1)))
    inner.pin(body["foot"], inner.ground, multiplier=True)
    inner.pin(body["side"], spring.start)
    inner.pin(spring.end, mass.centre)
    inner.connect(push.port, body.centre.translation)
    inner.connect(torsion.first, body.centre.rotation)
    inner.connect(torsion.second, inner.ground.rotation)
    outer = ph.Diagram("outer")
    left, right = outer.add(inner, "left"), outer.add(inner, "right")
    assert left[body] is not right[body] and left[matrices].name == "left/matrices"
    alone, system = inner.compile(), outer.compile()
    assert system.n == 2 * alone.n
    assert system.constraint_names == tuple(f"{side}/{c}" for side in ("left", "right") for c in alone.constraint_names)
    assert list(inner.network.blocks) == [
        *("ground", "body", "mass", "spring", "push", "torsion", "matrices", "pin body ground")
    ]
    one = ph.simulate(alone, 0.2, 0.01)
    both = ph.simulate(system, 0.2, 0.01, inputs={"right/push": (0.0, 0.0)})
    path = one.position(mass.centre)
    np.testing.assert_allclose(both.position(left[mass].centre), path, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(both.position(right[mass].centre), np.tile((2.0, 0.0), (21, 1)), rtol=0.0, atol=1e-12)
    assert np.abs(path - (2.0, 0.0)).max() > 1e-4


def test_loads_of_the_same_diagram_twice_have_names_of_their_own():
    """A hanging bar under its own dead load, twice: each copy is driven by the input of its own name."""
    inner = ph.Diagram("unit")
    bar = inner.add(ph.Beam("bar", BAR, (0.0, 0.0), (0.0, -1.0), elements=2, loads=ph.LineLoad("wind", (2.0, 0.0))))
    inner.pin(bar.start, inner.ground)
    outer = ph.Diagram("outer")
    left, right = outer.add(inner, "left"), outer.add(inner, "right")
    assert bar.loads[0].name == "wind"
    system = outer.compile()
    assert system.input_names == ("left/wind.x", "left/wind.y", "right/wind.x", "right/wind.y")
    solution = ph.simulate(system, 0.1, 0.01, inputs={"right/wind": (-2.0, 0.0)})
    there, back = (solution.position(twin[bar].end)[-1] for twin in (left, right))
    # 2 N/m on a bar of 1 m and 0.7 kg/m: angular acceleration (2 / 2) / (0.7 / 3), so x = 0.0214 m after 0.1 s for a
    # rigid one
    assert there[0] == pytest.approx(0.0214, rel=0.05)
    assert back[0] == pytest.approx(-there[0], rel=1e-9)


def test_a_nested_circuit_keeps_its_reference():
    """RL: the current after one time constant is (1 - 1/e) u / R in the copy too."""
    inner = ph.Diagram("circuit")
    earth, source = inner.add(ph.Reference("earth")), inner.add(ph.Voltage("battery", 12.0))
    r, coil = inner.add(ph.Resistor("r", 4.0)), inner.add(ph.Inductor("coil", 2.0))
    inner.connect(source.port, r.p)
    inner.connect(r.n, coil.p)
    inner.connect(coil.n, earth.port)
    outer = ph.Diagram("outer")
    outer.add(inner, "left")
    outer.add(inner, "right")
    solution = ph.simulate(outer.compile(), 0.5, 0.005)
    for side in ("left", "right"):
        assert solution.state(f"{side}/coil.current[0]")[-1] == pytest.approx(3.0 * (1.0 - np.exp(-1.0)), rel=1e-4)


def test_the_inner_diagram_is_taken_as_it_is_and_not_changed():
    inner, outer = ph.Diagram("inner"), ph.Diagram("outer")
    beam = inner.add(ph.Beam("beam", BAR, (0.0, 0.0), (1.0, 0.0), elements=2))
    nested = outer.add(inner)
    later = inner.add(ph.Mass("later", 1.0, (1.0, 0.0)))
    inner.pin(beam.end, later.centre)
    assert "inner/later" not in outer.network.blocks
    with pytest.raises(UnknownNameError, match=r"PH202.*beam, as they were"):
        nested[later]
    outer.pin(nested[beam].end, outer.ground)
    with pytest.raises(ForeignBlockError, match="take the block from what add"):
        outer.pin(beam.start, outer.ground)
    assert len(outer.compile().state_names) > 0
    assert "nested at test_nesting.py" in outer.network.added["inner/beam"]


def test_a_repair_of_a_nested_diagram():
    inner, outer = ph.Diagram("inner"), ph.Diagram("outer")
    beam = inner.add(ph.Beam("beam", BAR, (0.0, 0.0), (1.0, 0.0), elements=1))
    nested = outer.add(inner)
    outer.weld(nested[beam].start, outer.ground)
    report = outer.check()
    assert report.repairs[0].apply(outer).compile().n > 0


def test_what_cannot_be_nested():
    a, b, c = (ph.Diagram(name) for name in "abc")
    with pytest.raises(NestingError, match=r"PH207.*itself"):
        a.add(a)
    a.add(b)
    b.add(c)
    with pytest.raises(NestingError, match=r"PH207.*one that does"):
        c.add(a)
    with pytest.raises(NestingError, match="gravity"):
        ph.Diagram("outer").add(ph.Diagram("inner", gravity=(0.0, -9.81)))
    with pytest.raises(DataError, match="without dots"):
        ph.Diagram("outer").add(ph.Diagram("v1.0"))
    with pytest.raises(ArgumentTypeError, match="a text"):
        ph.Diagram("outer").add(ph.Diagram("inner"), 3)
    with pytest.raises(ArgumentTypeError, match="a name of its own"):
        ph.Diagram("outer").add(ph.Mass("mass", 1.0, (0.0, 0.0)), "other")
    inner, outer = ph.Diagram("inner"), ph.Diagram("outer")
    mass = inner.add(ph.Mass("mass", 1.0, (0.0, 0.0)))
    inner.pin(mass.centre, inner.add(ph.Spring("spring", 1.0, (0.0, 0.0), (1.0, 0.0))).start)
    nested = outer.add(inner)
    before = list(outer.network.blocks)
    with pytest.raises(DuplicateNameError, match="inner/mass"):
        outer.add(inner)
    assert list(outer.network.blocks) == before
    with pytest.raises(PortInUseError):
        outer.pin(nested[mass].centre, outer.ground)
