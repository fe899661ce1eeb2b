"""Natural frequencies of the linear Timoshenko beam: order, accuracy, no locking."""

from functools import cache

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

import phblocks as ph

ENDS = ("free-free", "clamped-free", "clamped-clamped", "pinned-pinned", "clamped-pinned", "pinned-free")
REFERENCE_SLENDERNESS = 10.0


def properties(slenderness):
    """A square bar of length 1 with L/h as given, in units of EI = rhoA = 1; nu = 0.3, shear factor 5/6."""
    axial = 12.0 * slenderness**2  # EI = EA h^2 / 12
    return {
        "axial": axial,
        "shear": 5 / 6 / 2.6 * axial,
        "bending": 1.0,
        "mass": 1.0,
        "rotary": 1.0 / axial,
    }


def bending_frequencies(ends, elements, degree, count, slenderness=REFERENCE_SLENDERNESS):
    """Frequencies of the assembled beam whose shapes bend; those that only stretch it are left out."""
    d = ph.Diagram("beam")
    beam = d.add(ph.Beam("beam", ph.Section(**properties(slenderness)), (0.0, 0.0), (1.0, 0.0), elements, degree))
    for anchor, kind in zip((beam.start, beam.end), ends.split("-"), strict=True):
        if kind != "free":
            (d.weld if kind == "clamped" else d.pin)(anchor, d.ground)
    system = d.compile()
    modes = system.modes(2 * count + 6)
    axial = np.array([name.split(".")[1][:2] in ("V1", "N1") for name in system.state_names])
    E = system.E.toarray()[np.ix_(axial, axial)]
    energy = 0.5 * np.einsum("im,ij,jm->m", modes.shapes[axial].conj(), E, modes.shapes[axial]).real
    assert np.minimum(energy, 1.0 - energy).max() <= 1e-9  # of 1 J: a straight beam stretches or bends, never both
    frequencies = modes.frequencies[energy < 0.5]
    assert frequencies.size >= count
    return frequencies[:count]


@cache
def exact_frequencies(ends, top, slenderness=REFERENCE_SLENDERNESS):
    """Solve the frequency equation of Timoshenko's beam up to a frequency.

    (w, phi, M, Q)' = A(omega) (w, phi, M, Q); what vanishes at the end, as a function of what is free at the start,
    is singular at a natural frequency.
    """
    p = properties(slenderness)
    vanishing = {"free": (2, 3), "pinned": (0, 2), "clamped": (0, 1)}
    at_start, at_end = (vanishing[kind] for kind in ends.split("-"))
    free = [i for i in range(4) if i not in at_start]

    def determinant(omega):
        A = np.zeros((4, 4))
        A[0, 1], A[0, 3] = 1.0, 1.0 / p["shear"]
        A[1, 2] = 1.0 / p["bending"]
        A[2, 1], A[2, 3] = -p["rotary"] * omega**2, -1.0
        A[3, 0] = -p["mass"] * omega**2
        return np.linalg.det(expm(A)[np.ix_(at_end, free)])

    grid = np.linspace(0.5, top, max(20, int(top)))
    values = [determinant(omega) for omega in grid]
    pairs = [(a, b) for a, b, u, v in zip(grid, grid[1:], values, values[1:], strict=False) if u * v < 0.0]
    return np.array([brentq(determinant, a, b, xtol=1e-12, rtol=1e-14) for a, b in pairs])


@pytest.fixture(scope="module")
def exact(references):
    modes = references["timoshenko_frequencies_rad_s"]["modes"]
    assert sorted(modes) == sorted(ENDS)
    return {ends: np.array(frequencies) for ends, frequencies in modes.items()}


def test_reference_beam(references):
    """The beam of the table is the square bar of slenderness 10 of this file."""
    beam = references["timoshenko_frequencies_rad_s"]["beam"]
    p = properties(REFERENCE_SLENDERNESS)
    ours = {"L": 1, "EI": p["bending"], "EA": p["axial"], "kGA": p["shear"], "rhoA": p["mass"], "rhoI": p["rotary"]}
    assert ours == pytest.approx(beam, rel=1e-14)


def test_section_of_the_reference_beam():
    """A square of 0.1 m with E I = rho A = 1, nu = 0.3 and the shear factor 5/6 that is the default."""
    section = ph.Section.rectangle(0.1, 0.1, young=1.2e5, poisson=0.3, density=100.0)
    p = properties(REFERENCE_SLENDERNESS)
    got = (section.axial, section.shear, section.bending[1], section.mass, section.rotary[1])
    assert got == pytest.approx((p["axial"], p["shear"], p["bending"], p["mass"], p["rotary"]), rel=1e-14)


@pytest.mark.parametrize("ends", ENDS)
def test_frequency_equation_of_this_file(exact, ends):
    """It gives the six frequencies of the table (14 digits) to 2e-12, measured 6e-13: good enough to judge by."""
    own = exact_frequencies(ends, 285.0)[:6]
    assert np.abs(own / exact[ends] - 1.0).max() <= 2e-12


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("ends", ENDS)
def test_relative_error_falls_with_order_two_k(exact, ends, degree):
    """Slope of log error over log h, for each mode from 1 to 6, between two meshes of which one is twice as fine.

    Taken are the two finest of the meshes whose errors are above round-off, 1e-11 here: a line through coarser ones
    would measure where the asymptotic range begins. Measured: 1.99 to 2.05, 3.92 to 4.00, 5.93 to 6.00.
    """
    meshes = {1: (32, 64), 2: (16, 32), 3: (8, 16, 32)}[degree]
    errors = np.array([np.abs(bending_frequencies(ends, n, degree, 6) / exact[ends] - 1.0) for n in meshes])
    for of_mode in errors.T:
        coarse, fine = of_mode[of_mode > 1e-11][-2:]
        assert abs(np.log2(coarse / fine) - 2 * degree) <= 0.1
    # the last errors, absolutely: 1.2 times the worst of all ends and modes
    assert errors[-1].max() <= {1: 9.3e-3, 2: 2.6e-4, 3: 7.6e-7}[degree]


@pytest.mark.parametrize("ends", ENDS)
def test_thirty_two_elements_of_degree_three(exact, ends):
    """Below 2e-6 in all modes from 1 to 6, as specified; measured: 6.3e-7 at worst."""
    assert np.abs(bending_frequencies(ends, 32, 3, 6) / exact[ends] - 1.0).max() < 2e-6


@pytest.mark.parametrize(("elements", "degree"), [(8, 1), (4, 2), (2, 3)])
@pytest.mark.parametrize("ends", ENDS)
def test_no_locking(ends, elements, degree):
    """Relative error of mode 1 for L/h = 10 to 1e5: specified is a factor of 2 between largest and smallest.

    Measured: 1.02 to 1.17. The meshes are coarse on purpose, errors from 4e-6 to 2e-2: at L/h = 1e5 the spectrum
    spans 1e10 and round-off alone moves the lowest frequency by 7e-7.
    """
    errors = []
    for slenderness in (10.0, 1e2, 1e3, 1e4, 1e5):
        expected = exact_frequencies(ends, 25.0, slenderness)[0]
        errors.append(abs(bending_frequencies(ends, elements, degree, 1, slenderness)[0] / expected - 1.0))
    assert max(errors) < 1.5 * min(errors)
    assert min(errors) > 1e-6  # above round-off
    assert max(errors) < {1: 2.5e-2, 2: 4e-3, 3: 2.2e-3}[degree]
