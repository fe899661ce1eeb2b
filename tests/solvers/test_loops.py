"""Loops that have opened, and the displacement of least strain energy that closes them, by hand."""

import itertools

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import MethodError
from phblocks.solvers.loops import Loops

NOTHING = np.zeros(0)


def section(axial: float = 2e5) -> ph.Section:
    return ph.Section(axial=axial, shear=8e4, bending=40.0, mass=1.5, rotary=1e-3)


def changed(system: ph.System, field: str, value: float) -> ph.State:
    """The start with one field of states set to a value."""
    x = system.start.x.copy()
    x[[i for i, name in enumerate(system.state_names) if field in name]] = value
    return ph.State(x, system.start.theta, system.start.points)


@pytest.mark.parametrize("multiplier", [False, True])
def test_a_tie_rod_gives_up_its_strain(multiplier):
    """Pinned at both ends, all joints in one line: N1 = 100 N opens L N1 / EA, and only N1 = 0 closes it."""
    d = ph.Diagram("tie")
    rod = d.add(ph.Beam("rod", section(), (0.0, 0.0), (2.0, 0.0), elements=3, degree=2))
    d.pin(rod.start, d.ground)
    d.pin(rod.end, d.ground, multiplier=multiplier)
    system = d.compile()
    loops, state = Loops(system), changed(system, "rod.N1", 100.0)
    assert loops.count == 1
    gaps = loops.gaps(state, NOTHING)
    assert np.abs(gaps).sum() == pytest.approx(2.0 * 100.0 / 2e5, rel=1e-12)
    closure = loops.close(state, NOTHING)
    assert closure.left < 1e-12 and closure.gap == pytest.approx(np.linalg.norm(gaps, axis=1).max())
    size = np.sqrt(system.E.diagonal())
    np.testing.assert_allclose(size * closure.state.x, 0.0, atol=1e-6 * np.abs(size * state.x).max())
    assert system.energy(state.x) == pytest.approx(0.5 * 100.0**2 * 2.0 / 2e5)


def test_two_rods_share_the_strain_as_springs_in_a_row():
    """Stiffness EA / L of 2e5 and 1e5 N/m, one load N: a gap of 3 mm is 1 mm and 2 mm, both by 200 N."""
    d = ph.Diagram("ties")
    stiff = d.add(ph.Beam("stiff", section(2e5), (0.0, 0.0), (1.0, 0.0), elements=2))
    soft = d.add(ph.Beam("soft", section(1e5), (1.0, 0.0), (2.0, 0.0), elements=2))
    d.weld(stiff.start, d.ground)
    d.weld(stiff.end, soft.start)
    d.weld(soft.end, d.ground)
    system = d.compile()
    state = changed(system, "soft.N1", 300.0)
    closure = Loops(system).close(state, NOTHING)
    assert closure.left < 1e-12
    taken = state.x - closure.state.x
    names = [i for i, name in enumerate(system.state_names) if ".N1" in name]
    np.testing.assert_allclose(taken[names], 200.0, rtol=1e-6)
    # nothing but axial force, and orthogonal in the energy norm to what is left: least
    np.testing.assert_allclose(taken @ (system.E @ closure.state.x), 0.0, atol=1e-6 * system.energy(state.x))


def frame(**options) -> ph.System:
    """Three rigid bars on four pins: a mechanism with one degree of freedom."""
    d = ph.Diagram("bars", gravity=(0.0, -9.81))
    corners = np.array([(0.0, 0.0), (0.3, 1.0), (1.5, 1.2), (1.8, 0.1)])
    bars = []
    for i, (a, b) in enumerate(itertools.pairwise(corners)):
        ends = {"a": a, "b": b}
        bars.append(d.add(ph.RigidBody(f"bar {i}", 1.0 + i, 0.1, (a + b) / 2, ends, **options)))
    d.pin(bars[0]["a"], d.ground, multiplier=True)
    d.pin(bars[0]["b"], bars[1]["a"], multiplier=True)
    d.pin(bars[1]["b"], bars[2]["a"], multiplier=True)
    d.pin(bars[2]["b"], d.ground, multiplier=True)
    return d.compile()


def test_rigid_bars_turn():
    """The middle bar turned by 0.01 rad about its start: its end is where the chord says, until all three turn."""
    system = frame()
    theta = np.where(np.arange(3) == 1, 0.01, 0.0)
    state = ph.State(system.start.x, theta, system.start.points)
    loops = Loops(system)
    chord, turned = np.array([1.2, 0.2]), np.array([[np.cos(0.01), -np.sin(0.01)], [np.sin(0.01), np.cos(0.01)]])
    missing = turned @ chord - chord
    assert np.linalg.norm(loops.gaps(state, NOTHING), axis=1).sum() == pytest.approx(np.linalg.norm(missing), rel=1e-9)
    closure = loops.close(state, NOTHING)
    assert closure.left < 1e-12
    places = [np.zeros(2)]
    for angle, chord in zip(closure.state.theta, [(0.3, 1.0), (1.2, 0.2), (0.3, -1.1)], strict=True):
        c, s = np.cos(angle), np.sin(angle)
        places.append(places[-1] + np.array([[c, -s], [s, c]]) @ np.array(chord))
    np.testing.assert_allclose(places[-1], [1.8, 0.1], atol=1e-12)
    np.testing.assert_array_equal(closure.state.x, state.x)
    # least mass: the displacement is orthogonal, in the mass, to the motion of the mechanism, to the order of the gap
    step, about = closure.state.theta - theta, np.array(places[:-1])
    motion = null_motion(about)
    masses, shift = np.array([1.0, 2.0, 3.0]), closure.state.points - state.points
    centres = 0.5 * (about + np.array(places[1:]))
    speed = velocities(motion, about, centres)
    product = np.sum(masses[:, None] * shift * speed) + 0.1 * step @ motion
    size = np.sqrt(np.sum(masses[:, None] * shift**2) + 0.1 * step @ step)
    assert abs(product) < 0.02 * size * np.sqrt(np.sum(masses[:, None] * speed**2) + 0.1 * motion @ motion)


def null_motion(about: np.ndarray) -> np.ndarray:
    """Angular velocities with which the end of the chain stays where it is."""
    ends = np.vstack([about[1:], [1.8, 0.1]])
    turned = np.stack([about[:, 1] - ends[:, 1], ends[:, 0] - about[:, 0]])
    return np.linalg.svd(turned)[2][-1]


def velocities(motion: np.ndarray, about: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Of places, one on each bar of the chain."""
    found, base = [], np.zeros(2)
    for i, spin in enumerate(motion):
        found.append(base + spin * np.array([about[i, 1] - places[i, 1], places[i, 0] - about[i, 0]]))
        after = about[i + 1] if i < 2 else np.array([1.8, 0.1])
        base = base + spin * np.array([about[i, 1] - after[1], after[0] - about[i, 0]])
    return np.array(found)


def test_gaps_are_those_of_the_solution(four_bar):
    """One loop: what four joints share is what the solution reports where its tree of blocks ends."""
    system = four_bar().compile()
    solution = ph.simulate(system, 0.5, 0.02)
    loops = Loops(system)
    for t in (0.1, 0.3, 0.5):
        shared = np.linalg.norm(loops.gaps(solution.at(t), NOTHING), axis=1).sum()
        i = int(np.abs(solution.t - t).argmin())
        assert shared == pytest.approx(max(gap[i] for gap in solution.closure().values()), rel=1e-9)


def test_a_support_that_moves():
    """The other end of a rod is where its input has brought it."""
    d = ph.Diagram("pulled")
    rod = d.add(ph.Beam("rod", section(), (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(rod.start, d.ground)
    d.connect(rod.end.translation, d.add(ph.Velocity("drive", (0.0, 0.0))).port)
    system = d.compile()
    loops = Loops(system)
    moved = np.array([0.001, 0.0])
    assert np.abs(loops.gaps(system.start, moved)).sum() == pytest.approx(0.001)
    closure = loops.close(system.start, moved)
    names = [i for i, name in enumerate(system.state_names) if ".N1" in name]
    np.testing.assert_allclose(closure.state.x[names], 200.0, rtol=1e-6)


def test_no_loops_no_gates():
    d = ph.Diagram("pendulum")
    beam = d.add(ph.Beam("beam", section(), (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(beam.start, d.ground)
    system = d.compile()
    loops, state = Loops(system), changed(system, "beam.N1", 100.0)
    assert loops.count == 0
    assert loops.close(state, NOTHING).state is state


def test_a_ring_of_shared_states_is_refused():
    corners = [(0.0, 0.0), (1.0, 0.0), (0.5, 0.8)]
    d = ph.Diagram("ring")
    sides = [
        d.add(ph.Beam(f"side {i}", section(), corners[i], corners[(i + 1) % 3], elements=2, causality="free-free"))
        for i in range(3)
    ]
    for one, other in zip(sides, [*sides[1:], sides[0]], strict=True):
        d.weld(one.end, other.start)
    with pytest.raises(MethodError, match=r"Projection for system 'ring'.*side 0"):
        Loops(d.compile())


@pytest.mark.parametrize("far", [0.0, 1e4, 1e6])
def test_tolerances_do_not_depend_on_the_origin(far):
    """The extent is 2 m wherever the rod lies; beside it 8 eps of the largest coordinate."""
    d = ph.Diagram("tie")
    rod = d.add(ph.Beam("rod", section(), (far, far), (far + 2.0, far), elements=3, degree=2))
    d.pin(rod.start, d.ground)
    d.pin(rod.end, d.ground)
    system = d.compile()
    loops = Loops(system)
    assert loops.size == pytest.approx(2.0, rel=1e-9)
    assert loops.allowed(1e-8) == pytest.approx(2e-8 + 8.0 * 2.0**-52 * (far + 2.0), rel=1e-9)
    closure = loops.close(changed(system, "rod.N1", 100.0), NOTHING)
    assert closure.gap > 1e-4 and closure.left < 4.0 * 2.0**-52 * (far + 2.0) + 1e-13
