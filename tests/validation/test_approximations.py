"""What approximations change in scenes whose numbers are known: the spinning beam, the four-bar, small motions."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.linalg import eigh
from scipy.sparse.linalg import spsolve

import phblocks as ph

A = ph.Approximation
SPIN, LAG, RATE = 6.0, 4.511, 4.645  # rad/s, rad/s, 1/s: specified


# The spinning beam


@pytest.fixture(scope="module")
def blade(references):
    """The spin-up beam, its root pinned and turned from outside: from an approximation to the system."""
    b = references["spin_up"]["beam"]
    section = ph.Section(axial=b["EA"], shear=b["kGA"], bending=b["EI"], mass=b["rhoA"], rotary=b["rhoI"])

    def build(approximation):
        d = ph.Diagram("spin")
        beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (b["L"], 0.0), elements=6, degree=3))
        d.pin(beam.start, d.ground)
        d.expose(beam.start.rotation, "root", imposes="angular velocity")
        return d.compile(approximation=approximation)

    return build


def steady_spin(system):
    """The state of steady spin, by Newton's method from the unstressed one, and the input."""
    state, u = system.rigid_motion(spin=SPIN), np.array([SPIN])
    x = state.x.copy()
    for _ in range(10):
        A = system.linearize(ph.State(x, state.theta, state.points), u).A
        change = spsolve(A.tocsc()[: system.n, : system.n], -system.force(x, state.theta, u))
        x += change
        if np.abs(change).max() < 1e-9 * np.abs(x).max():
            return ph.State(x, state.theta, state.points), u
    raise AssertionError("no steady state found")


def ritz(references, stiffening):
    """Square of the first lag frequency by hand: EI w'''' - (F w')' + rhoA w'' = Omega^2 rhoA w, Ritz, 8 polynomials.

    F = rhoA Omega^2 (L^2 - x^2) / 2 is the axial force of the spin.
    """
    b = references["spin_up"]["beam"]
    L = b["L"]
    w = [Polynomial([0.0] * k + [1.0 / L**k]) for k in range(2, 10)]
    force = Polynomial([L**2, 0.0, -1.0]) * (b["rhoA"] * SPIN**2 / 2.0) * stiffening

    def integral(f):
        return f.integ()(L) - f.integ()(0.0)

    K = [[integral(b["EI"] * p.deriv(2) * q.deriv(2) + force * p.deriv() * q.deriv()) for q in w] for p in w]
    M = [[integral(b["rhoA"] * p * q) for q in w] for p in w]
    return eigh(np.array(K), np.array(M), eigvals_only=True)[0] - SPIN**2


def test_what_is_true_of_the_spinning_beam(references):
    """By hand: stable with the axial force of the spin, divergent without."""
    assert ritz(references, 1.0) ** 0.5 == pytest.approx(LAG, rel=1e-3)
    assert (-ritz(references, 0.0)) ** 0.5 == pytest.approx(RATE, rel=1e-3)


@pytest.mark.parametrize(
    ("approximation", "specified"),
    [
        (A(), 1e-3),
        (A(large_rotation="second-order"), 1e-3),
        (A(extension=False), 1e-3),
        (A(extension=False, shear=False, rotary_inertia=False), 1e-3),
    ],
    ids=["full", "second-order", "inextensible", "elastica"],
)
def test_lag_frequency_of_the_spinning_beam(blade, approximation, specified):
    """Measured: full 4.51144, second-order 4.51189, inextensible 4.51215 rad/s."""
    system = blade(approximation)
    modes = system.modes(1, *steady_spin(system))
    assert modes.frequencies[0] == pytest.approx(LAG, rel=specified)
    assert abs(modes.growth[0]) < 1e-9 and not modes.diverging.size


def test_second_order_knows_the_axial_force_of_the_spin(blade):
    """N1 at the root, rhoA omega^2 L^2 / 2 without the extension that second order leaves out: to round-off."""
    for approximation, tolerance in ((A(), 1e-3), (A(large_rotation="second-order"), 1e-9)):
        system = blade(approximation)
        state, _ = steady_spin(system)
        root = state.x[system.state_names.index("beam.N1[0]")]
        assert root == pytest.approx(1.2 * SPIN**2 * 10.0**2 / 2.0, rel=tolerance)


def test_the_linear_model_of_the_spinning_beam_is_refused(blade):
    system = blade(A(large_rotation=False))  # nothing pulls it along: V1 and N1 are left out
    first = system.excited_modes(1).frequencies[0]
    assert np.sqrt(SPIN**2 - first**2) == pytest.approx(RATE, rel=1e-3)
    with pytest.raises(ph.errors.ApproximationError, match=f"{RATE} 1/s"):
        ph.simulate(system, 1.0, 0.01, inputs={"root": SPIN})


def test_second_order_in_motion(references, blade):
    """The spin-up itself: largest lag -0.5738 m at 6.75 s, to the tolerance of the full model there."""
    system = blade(A(large_rotation="second-order"))

    def spin(t):
        return 6 / 15 * (t - 15 / (2 * np.pi) * np.sin(2 * np.pi * t / 15))

    solution = ph.simulate(system, 8.0, 0.01, inputs={"root": spin})
    x, y = solution.position("beam", 1.0, source="strain").T
    angle = solution.angle("beam", 0.0)
    lag = np.cos(angle) * y - np.sin(angle) * x
    time, value = references["spin_up"]["largest_lag_u2"]
    assert lag.min() == pytest.approx(value, rel=2e-3)
    assert solution.t[lag.argmin()] == pytest.approx(time, abs=0.1)
    assert solution.max_power_balance_error < 1e-9 * solution.energy["kinetic"].max()


def test_a_tensioned_beam_is_a_string_that_bends():
    """Pinned at both ends under an axial force F: omega^2 = (EI k^4 + F k^2) / rhoA, k = pi / L; linear: no F."""
    section = ph.Section(axial=1e9, shear=1e9, bending=100.0, mass=2.0, rotary=1e-9)
    k, force = np.pi / 3.0, 400.0
    found = {}
    for kept in (True, "second-order", False):
        d = ph.Diagram("string")
        b = d.add(ph.Beam("b", section, (0, 0), (3, 0), elements=6, degree=3))
        d.pin(b.start, d.ground)
        d.pin(b.end, d.ground)
        system = d.compile(approximation=A(large_rotation=kept))
        x = np.array([force if ".N1[" in name else 0.0 for name in system.state_names])
        state = ph.State(x, system.start.theta, system.start.points)
        found[kept] = system.modes(1, state).frequencies[0]
    loose, tight = (np.sqrt((100.0 * k**4 + f * k**2) / 2.0) for f in (0.0, force))
    assert found[True] == pytest.approx(tight, rel=1e-5)
    assert found["second-order"] == pytest.approx(tight, rel=1e-5)
    assert found[False] == pytest.approx(loose, rel=1e-5)


@pytest.mark.parametrize("kept", [True, "second-order"])
@pytest.mark.parametrize("velocity", [(50.0, 0.0), (0.0, 50.0)], ids=["along", "across"])
def test_a_flying_beam_vibrates_as_at_rest(references, kept, velocity):
    """Without K V1 and its mirror the first frequency, 24.161 rad/s, would be 23.328 rad/s at 50 m/s along the axis."""
    b = references["spin_up"]["beam"]
    section = ph.Section(axial=b["EA"], shear=b["kGA"], bending=b["EI"], mass=b["rhoA"], rotary=b["rhoI"])
    d = ph.Diagram("flying")
    d.add(ph.Beam("b", section, (0, 0), (10, 0), elements=8, degree=3))
    system = d.compile(None, approximation=A(large_rotation=kept))
    flying = system.modes(4, system.rigid_motion(velocity))
    np.testing.assert_allclose(flying.frequencies, system.modes(4).frequencies, rtol=1e-9)
    assert np.abs(flying.growth).max() < 1e-9


# Linear scenes


def test_modes_of_a_linear_four_bar_are_those_of_the_linearised_one():
    """Specified 1e-10; without gravity, whose weight turns with the parts and is the linear theory's to leave out."""
    d = four_bar_diagram()
    full = d.compile(approximation=A(gravity=False))
    linear = d.compile(approximation=A(gravity=False, large_rotation=False))
    assert linear.linear and not full.linear
    expected = full.modes(300).frequencies
    np.testing.assert_allclose(linear.modes(300).frequencies, expected, rtol=1e-10)


def four_bar_diagram(young=2.1e11, elements=(4, 3, 3), degree=2):
    """The reference scene as a diagram; its coupler is the block "coupler"."""
    bar = ph.Section.rectangle(0.05, 0.05, young=young, poisson=0.3, density=2710.0, shear_factor=1.0)
    d = ph.Diagram("four-bar", gravity=(0.0, -9.81))
    places = ((0.0, 0.5), (2.0, 1.5), (3.5, 1.5), (2.5, 0.5))
    names = ("crank", "coupler", "rocker")
    crank, coupler, rocker = (
        d.add(ph.Beam(name, bar, *places[i : i + 2], elements[i], degree)) for i, name in enumerate(names)
    )
    d.pin(crank.start, d.ground)
    d.pin(crank.end, coupler.start)
    d.pin(coupler.end, rocker.start)
    d.pin(rocker.end, d.ground)
    return d


def test_a_linear_four_bar_near_rest():
    """One factor for all steps, energy to round-off, and the fall of the true one at first."""
    d = four_bar_diagram()
    linear, full = (d.compile(approximation=a) for a in (A(large_rotation=False), None))
    stepper = ph.Midpoint().prepare(linear)
    assert stepper.stage.constant
    a, b = (ph.simulate(s, 0.08, 0.001) for s in (linear, full))
    assert not a.statistics.newton_iterations.any()  # one back-substitution a step
    assert a.max_power_balance_error < 1e-12 and b.max_power_balance_error < 1e-12
    fall = b.position("coupler", 0.5)[-1] - b.position("coupler", 0.5)[0]
    difference = np.abs(a.position("coupler", 0.5) - b.position("coupler", 0.5)).max()
    assert np.abs(fall).max() > 0.01 and difference < 0.03 * np.abs(fall).max()


def test_a_linear_timoshenko_cantilever(references):
    """Frequencies of the references, and those of the linearised full model; released from a load it loses nothing."""
    r = references["timoshenko_frequencies_rad_s"]
    b = r["beam"]
    section = ph.Section(axial=b["EA"], shear=b["kGA"], bending=b["EI"], mass=b["rhoA"], rotary=b["rhoI"])
    d = ph.Diagram("cantilever")
    beam = d.add(ph.Beam("b", section, (0, 0), (1, 0), elements=16, degree=3))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "tip")
    system, full = (d.compile(approximation=a) for a in (A(large_rotation=False), None))
    assert system.linear and not full.linear
    found = system.modes(30).frequencies
    np.testing.assert_allclose(found, full.modes(30).frequencies, rtol=1e-10)
    for frequency in r["modes"]["clamped-free"][:3]:
        assert np.abs(found / frequency - 1.0).min() < 1e-6
    solution = ph.simulate(system, 2.0, 0.01, inputs={"tip": lambda t: (0.0, -0.05 if t < 0.5 else 0.0)})
    assert not solution.statistics.newton_iterations.any()
    assert solution.max_power_balance_error < 1e-12 * solution.energy["total"].max()
    assert solution.energy["total"][-1] == pytest.approx(solution.energy["supplied"][-1], rel=1e-12)


# The four-bar


def change(approximation):
    """Of P(1) against the full model, m: Gauss-Legendre of order four at dt 0.01."""
    d = four_bar_diagram()
    paths = []
    for a in (None, approximation):
        solution = ph.simulate(d.compile(approximation=a), t_end=1.0, dt=0.01, method=ph.GaussLegendre(2))
        assert solution.status.ok and solution.max_power_balance_error < 1e-8
        paths.append(solution.position("coupler", 0.5)[-1])
    return float(np.abs(paths[1] - paths[0]).max())


@pytest.mark.parametrize(
    ("approximation", "measured"),
    [
        (A(extension=False), 1.11e-4),
        (A(shear=False), 1.4e-6),
        (A(shear=False, extension=False), 1.115e-4),
        (A(rotary_inertia=False), 5.32e-4),
        (A(large_rotation="second-order"), 7.0e-6),
        (A(flexible=False), 7.63e-4),
    ],
    ids=["extension", "shear", "both", "rotary_inertia", "second-order", "flexible"],
)
def test_change_of_the_path(approximation, measured):
    """As in docs/approximations.md."""
    assert change(approximation) == pytest.approx(measured, rel=0.1)


def test_rigid_links_against_an_independent_code(references):
    """P(t) of rigid links by an independent code (DOP853 at 1e-12), t <= 5 s."""
    system = four_bar_diagram().compile(approximation=A(flexible=False))
    solution = ph.simulate(system, t_end=5.0, dt=0.005, method=ph.GaussLegendre(2))
    P = solution.position("coupler", 0.5)
    for t in range(1, 6):
        expected = references["four_bar"]["P_rigid_t"][str(t)]
        assert np.abs(P[200 * t] - expected).max() < 2e-5


def test_a_stiff_four_bar_is_the_rigid_one():
    """E = 2.1e14 Pa, a thousand times steel: specified about 1e-3 over the path, measured 1.6e-4 m."""
    rigid, stiff = (
        ph.simulate(d.compile(approximation=a), t_end=5.0, dt=0.005).position("coupler", 0.5)
        for d, a in ((four_bar_diagram(), A(flexible=False)), (four_bar_diagram(young=2.1e14), None))
    )
    assert np.abs(rigid - stiff).max() < 1e-3


def axial_share(system):
    """Frequencies of all modes, and the part of their energy in V1 and N1."""
    modes = system.modes(system.n)
    axial = [i for i, name in enumerate(system.state_names) if name.split(".")[1][:2] in ("V1", "N1")]
    shapes = modes.shapes[axial]
    E = system.E[axial][:, axial]
    return modes.frequencies, 0.5 * np.einsum("im,im->m", shapes.conj(), E @ shapes).real


def test_axial_and_shear_waves_have_left_the_spectrum():
    """With both strains 19 of 64 modes have most of their energy in V1 and N1; without, 20 modes and none of these."""
    d = four_bar_diagram()
    gravity = {"gravity": False}
    full, share = axial_share(d.compile(approximation=A(**gravity)))
    left, rest = axial_share(d.compile(approximation=A(extension=False, shear=False, **gravity)))
    assert (share > 0.5).sum() == 19 and (rest > 0.5).sum() == 0
    assert len(left) == 20 and len(full) == 64
    assert left.max() < 0.4 * full.max()
    np.testing.assert_allclose(left[:3], full[:3], rtol=5e-3)  # bending stays


@pytest.mark.slow
def test_constraint_forces_over_ten_thousand_steps():
    """What alternates of the forces of an inextensible and unshearable four-bar, 50 s at dt 0.005.

    What alternates from step to step is the second difference: of N1 rms 53 N of 1041 N in the first 5 s and 79 N of
    1010 N in the last. In the full model it grows from 73 to 586 N, as energy creeps into axial waves that the steps do
    not resolve: the inextensible beam has none.
    """
    rough = {}
    for name, approximation in (("full", None), ("inextensible", A(shear=False, extension=False))):
        system = four_bar_diagram(elements=(10, 6, 6), degree=1).compile(approximation=approximation)
        solution = ph.simulate(system, t_end=50.0, dt=0.005, limits=ph.Limits.none())
        assert solution.status.ok and len(solution.t) == 10001 and not solution.statistics.halvings
        assert solution.max_power_balance_error < 1e-11
        for field in ("N1", "N2"):
            forces = solution.x[:, [i for i, n in enumerate(system.state_names) if f".{field}[" in n]]
            for part, times in (("first", slice(2, 1000)), ("last", slice(9001, 10000))):
                f = forces[times]
                rough[name, field, part] = (f[2:] - 2.0 * f[1:-1] + f[:-2]).std() / 4.0 / f.std()
    for field, most in (("N1", 0.12), ("N2", 0.4)):
        assert rough["inextensible", field, "last"] < most
        assert rough["inextensible", field, "last"] < 2.0 * rough["inextensible", field, "first"]
    assert rough["full", "N1", "last"] > 4.0 * rough["inextensible", "N1", "last"]
