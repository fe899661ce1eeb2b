"""Natural frequencies of linear systems with known answers, by all four roads."""

import numpy as np
import pytest
import scipy.sparse as sp

import phblocks as ph
from phblocks import modes as module
from phblocks.errors import DataError
from phblocks.modes import find_modes

N, MASS, STIFFNESS = 40, 0.3, 5e4


def chain(damping: float = 0.0, fixed: bool = True) -> tuple[sp.csr_array, sp.csr_array]:
    """Equal masses on equal springs, to a wall at one end or at none: E w' = A w in velocities and forces."""
    springs = N if fixed else N - 1
    pull = sp.lil_array((springs, N))  # extension rates
    for i in range(springs):
        left, right = (i - 1, i) if fixed else (i, i + 1)
        pull[i, right] = 1.0
        if left >= 0:
            pull[i, left] = -1.0
    E = sp.diags_array(np.concatenate([np.full(N, MASS), np.full(springs, 1.0 / STIFFNESS)]))
    A = sp.block_array([[-damping * MASS * sp.eye_array(N), -pull.T], [pull, sp.csr_array((springs, springs))]])
    return sp.csr_array(E), sp.csr_array(A)


def frequencies(fixed: bool = True) -> np.ndarray:
    j = np.arange(1, N + 1)
    half = (2 * j - 1) * np.pi / (2 * (2 * N + 1)) if fixed else j[:-1] * np.pi / (2 * N)
    return 2.0 * np.sqrt(STIFFNESS / MASS) * np.sin(half)


@pytest.fixture(params=["dense", "sparse"])
def road(request, monkeypatch) -> str:
    if request.param == "sparse":
        monkeypatch.setattr(module, "DENSE", 10)
    return request.param


@pytest.mark.parametrize("fixed", [True, False])
def test_a_chain(road, fixed):
    E, A = chain(fixed=fixed)
    modes = find_modes(E, A, 6)  # the rigid motion of a free chain is left out
    np.testing.assert_allclose(modes.frequencies, frequencies(fixed)[:6], rtol=1e-9)
    np.testing.assert_allclose(modes.growth, 0.0, atol=1e-7)
    np.testing.assert_allclose(modes.hertz, modes.frequencies / (2 * np.pi), rtol=1e-15)
    energy = 0.5 * modes.shapes.conj().T @ (E @ modes.shapes)
    np.testing.assert_allclose(energy, np.eye(6), atol=1e-7)  # unit energy, and orthogonal
    for shape, frequency in zip(modes.shapes.T, modes.frequencies, strict=True):
        np.testing.assert_allclose(A @ shape, 1j * frequency * (E @ shape), atol=1e-7 * abs(A @ shape).max())


@pytest.mark.parametrize("damping", [0.5, 20.0])
def test_a_damped_chain(road, damping):
    """Decay at half the damping of the masses, lower frequency; what does not swing is left out."""
    E, A = chain(damping)
    undamped = frequencies()
    swinging = undamped[undamped > damping / 2.0]
    modes = find_modes(E, A, 5)
    np.testing.assert_allclose(modes.frequencies, np.sqrt(swinging[:5] ** 2 - damping**2 / 4.0), rtol=1e-7)
    np.testing.assert_allclose(modes.growth, -damping / 2.0, rtol=1e-6)


def test_more_modes_than_there_are(road):
    E, A = chain()
    assert find_modes(E, A, 1000).frequencies.size >= (N if road == "dense" else N - 1)


def test_a_beam_by_both_roads(scenes, monkeypatch):
    for name in ("frame", "shaken", "free"):
        system = scenes[name].compile()
        dense = system.modes(5)
        monkeypatch.setattr(module, "DENSE", 10)
        sparse = system.modes(5)
        monkeypatch.undo()
        np.testing.assert_allclose(sparse.frequencies, dense.frequencies, rtol=1e-7)
        np.testing.assert_allclose(sparse.growth, dense.growth, atol=1e-6 * dense.frequencies[0])


def test_modes_about_another_state(bar):
    """A beam spinning about its pinned root swings more slowly or faster than one at rest, but never the same."""
    d = ph.Diagram()
    b = d.add(ph.Beam("b", bar, (0.0, 0.0), (1.0, 0.0), 4))
    d.weld(b.start, d.ground)
    system = d.compile()
    still = system.modes(2).frequencies
    spinning = system.modes(2, system.rigid_motion(spin=20.0)).frequencies
    assert np.abs(spinning / still - 1.0).max() > 1e-4


@pytest.mark.parametrize("n", [0, -3, 2.0, "2", None, True])
def test_numbers_of_modes(n):
    with pytest.raises(DataError, match="modes n: expected a positive integer"):
        find_modes(*chain(), n)


@pytest.fixture
def heavy_bar() -> ph.Section:
    return ph.Section.rectangle(width=0.05, height=0.05, young=2.1e11, poisson=0.3, density=2710.0)


def test_rigid_motions_under_gravity_are_no_modes(heavy_bar):
    """Zero is a defective eigenvalue there, which round-off scatters to 1e-4 rad/s."""
    found = []
    for gravity in (None, (0.0, -9.81)):
        free = ph.Diagram(gravity=gravity)
        free.add(ph.Beam("bar", heavy_bar, (0.0, 0.0), (1.0, 0.0), elements=8))
        found.append(free.compile().modes(3).frequencies)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-4)


def test_a_chain_of_beams_under_gravity(heavy_bar):
    chain = ph.Diagram(gravity=(0.0, -9.81))
    last = chain.ground
    for i in range(20):
        beam = chain.add(ph.Beam(f"bar{i}", heavy_bar, (i, 0.0), (i + 1.0, 0.0), elements=2))
        chain.pin(last, beam.start)
        last = beam.end
    assert chain.compile().modes(3).frequencies.min() > 100.0


@pytest.mark.parametrize("up", [1.0, -1.0])
def test_a_pendulum_swings_or_falls(heavy_bar, up):
    """A stiff bar pinned at its end: sqrt(3 g / (2 L)) as a frequency below the pin, as a growth rate above it."""
    pendulum = ph.Diagram(gravity=(0.0, -9.81))
    beam = pendulum.add(ph.Beam("bar", heavy_bar, (0.0, 0.0), (0.0, up), elements=8))
    pendulum.pin(beam.start, pendulum.ground)
    modes = pendulum.compile(effects="all").modes(1)
    rate = modes.diverging[0] if up > 0 else modes.frequencies[0]
    assert abs(rate / np.sqrt(1.5 * 9.81) - 1.0) < 1e-3
    assert modes.diverging.size == (1 if up > 0 else 0)
