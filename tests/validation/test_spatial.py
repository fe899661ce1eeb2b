"""Beams in space against what is known of them: frequencies, the plane, momentum, order of convergence."""

from itertools import pairwise

import numpy as np
import pytest

import phblocks as ph

SECTION = ph.Section(axial=2e3, shear=(1e3, 1.2e3), bending=(10.0, 15.0), mass=1.0, rotary=(2e-2, 3e-2), torsion=8.0)
#: Roots of cos(x) cosh(x) = -1.
ROOTS = np.array([1.8751040687119611, 4.694091132974175, 7.854757438237613])


def ramp(t):
    return np.sin(np.pi * min(t / 0.5, 1.0)) ** 2


def loaded(elements=2, degree=2, split=False, end=(1.0, 0.0, 0.0)):
    """A cantilever that is pushed in both planes and twisted; in one beam or in two that are welded."""
    d = ph.Diagram("loaded")
    whole = ph.Beam("beam", SECTION, (0.0, 0.0, 0.0), end, elements, degree=degree)
    parts = [d.add(part) for part in (whole.split(0.5) if split else (whole,))]
    d.weld(d.ground, parts[0].start)
    for one, two in pairwise(parts):
        d.weld(one.end, two.start)
    last = parts[-1].end
    push = ph.Force("F", lambda t: (3.0 * ramp(t), 10.0 * ramp(t), 6.0 * ramp(t)), follows=True)
    twist = ph.Moment("M", lambda t: (2.0 * ramp(t), ramp(t), 0.5 * ramp(t)), follows=True)
    d.connect(last.translation, d.add(push).port)
    d.connect(last.rotation, d.add(twist).port)
    return d, parts


def tip(run, parts):
    """What is read at both ends."""
    foot, last = parts[0].start, parts[-1].end
    return np.concatenate(
        [
            run.velocity(last, frame="material")[-1],
            run.spin(last)[-1],
            run.force(foot)[-1] / 10.0,
            run.moment(foot)[-1] / 5.0,
        ]
    )


@pytest.mark.parametrize("degree", [1, 2])
def test_modes_of_a_cantilever(degree):
    """Bending about 2 and about 3 (Euler-Bernoulli of a slender beam), axial and torsional waves of a rod."""
    section = ph.Section(axial=1e4, shear=1e6, bending=(0.5, 1.0), mass=1.0, rotary=1e-7, torsion=2.0, polar=1e-4)
    end = np.array([1.0, 2.0, -2.0]) / 3.0

    def errors(elements):
        d = ph.Diagram("modes")
        beam = d.add(ph.Beam("beam", section, (0.0, 0.0, 0.0), end, elements, degree=degree, normal=(0.3, 0.1, 1.0)))
        d.weld(beam.start, d.ground)
        found = d.compile().modes(60).frequencies
        wave = np.pi * (np.arange(2) + 0.5)
        exact = {
            "about 2": ROOTS**2 * np.sqrt(0.5),
            "about 3": ROOTS**2,
            "axial": wave * np.sqrt(1e4),
            "torsion": wave * np.sqrt(2.0 / 1e-4),
        }
        return {kind: np.array([np.abs(found / w - 1.0).min() for w in known]) for kind, known in exact.items()}

    coarse, fine = errors(8), errors(16)
    # what Timoshenko's theory differs by from Euler-Bernoulli's, relative: EI / kGA and rotary inertia, about 1e-5
    theory = 3e-5
    for kind, error in fine.items():
        for was, now in zip(coarse[kind], error, strict=True):
            assert now <= max(1.3 * was / 4.0**degree, theory)
            assert now < (3e-2 if degree == 1 else 1e-3)


def test_energy_and_order_of_a_run_with_all_twelve_fields():
    d, parts = loaded()
    system = d.compile()
    assert system.n == 12 * (2 * 2 + 2 - 1) and not system.linear
    exact = tip(ph.simulate(system, 0.4, 1e-3, method=ph.GaussLegendre(2)), parts)
    assert (np.abs(exact) > 1e-2).all()  # all of them take part
    errors = []
    for dt in (1e-3, 5e-4, 2.5e-4):
        run = ph.simulate(system, 0.4, dt)
        errors.append(np.abs(tip(run, parts) - exact).max())
        gained = run.energy.total - run.energy.supplied
        assert np.abs(gained).max() <= 1e-13 * run.energy.total.max() * run.statistics.steps
        assert run.max_power_balance_error <= 1e-14 * run.energy.total.max()
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.1)
    assert errors[-1] < 1e-4


def test_two_welded_beams_are_one_along_any_direction():
    runs = []
    for split, end in ((False, (1.0, 0.0, 0.0)), (True, (1.0, 0.0, 0.0)), (True, (2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0))):
        d, parts = loaded(elements=4, degree=1, split=split, end=end)
        system = d.compile()
        runs.append((system.n, tip(ph.simulate(system, 0.3, 5e-3), parts)))
    (n, whole), (m, halves), (k, turned) = runs
    assert n == m == k  # states are shared at the weld
    np.testing.assert_allclose(halves, whole, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(turned, whole, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("causality", ["auto", "clamped-free"])
def test_frames_of_a_round_section_turned_about_the_beam_change_nothing(causality):
    """The second of two beams has its axes 2 and 3 turned; states shared by the turned weld, or given and taken."""
    round_ = ph.Section(axial=2e3, shear=1e3, bending=10.0, mass=1.0, rotary=2e-2, torsion=8.0)
    runs = []
    for normal in ((0.0, 0.0, 1.0), (0.0, np.sin(0.7), np.cos(0.7))):
        d = ph.Diagram("turned")
        first = d.add(ph.Beam("first", round_, (0.0, 0.0, 0.0), (0.5, 0.0, 0.0), 2, degree=2))
        second = d.add(
            ph.Beam("second", round_, (0.5, 0.0, 0.0), (1.0, 0.0, 0.0), 2, 2, causality=causality, normal=normal)
        )
        d.weld(d.ground, first.start)
        d.weld(first.end, second.start)
        d.expose(first.end.translation, "push", follows=True)
        d.expose(first.end.rotation, "twist", follows=True)
        system = d.compile()
        inputs = {"push": lambda t: (1.0, 8.0 * ramp(t), 6.0 * ramp(t)), "twist": (1.0, 0.5, -0.2)}
        run = ph.simulate(system, 0.3, 5e-3, inputs=inputs)
        assert max(run.power.connection_errors.values(), default=0.0) <= 1e-15
        assert run.max_power_balance_error <= 1e-14 * run.energy.total.max()
        runs.append((system.n, run.force(first, 0.25), run.moment(first.end), run.moment(second.start)))
    (n, force, before, after), (m, force_, before_, after_) = runs
    assert n == m
    np.testing.assert_allclose(force_, force, rtol=0.0, atol=1e-11 * np.abs(force).max())
    np.testing.assert_allclose(before_, before, rtol=0.0, atol=1e-11 * np.abs(before).max())
    c, s = np.cos(0.7), np.sin(0.7)
    axes = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])  # of the second beam, axis 3 along its normal
    np.testing.assert_allclose(after_ @ axes, after, rtol=0.0, atol=1e-11 * np.abs(after).max())


def rotations(vectors):
    """exp of the cross product with each vector, shape (m, 3, 3)."""
    size = np.linalg.norm(vectors, axis=1)[:, None, None]
    cross = np.zeros((len(vectors), 3, 3))
    cross[:, [2, 0, 1], [1, 2, 0]] = vectors
    cross -= cross.transpose(0, 2, 1)
    return np.eye(3) + np.sin(size) / size * cross + (1.0 - np.cos(size)) / size**2 * cross @ cross


def momenta(dt):
    """Linear and angular momentum of a free beam, with frames followed here, from its spins alone."""
    elements, t_end = 3, 0.6
    d = ph.Diagram("free")
    beam = d.add(ph.Beam("beam", SECTION, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), elements, degree=2))
    system = d.compile()
    start = system.rigid_motion((0.3, 0.5, -0.2), (2.0, 3.0, 4.0), (0.2, 0.0, 0.0))
    run = ph.simulate(system, t_end, dt, start=start)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    places = ((np.arange(elements)[:, None] + 0.5 * (nodes + 1.0)) / elements).ravel()
    weights = np.tile(0.5 * weights / elements, elements)
    V = np.stack([run.velocity(beam, s, frame="material") for s in places])
    W = np.stack([run.spin(beam, s) for s in places])
    inertia = SECTION.coefficients(beam.space)
    frames, r = np.tile(np.eye(3), (places.size, 1, 1)), np.outer(places, [1.0, 0.0, 0.0])
    found = []
    for k in range(run.t.size):
        v = np.einsum("pij,pj->pi", frames, V[:, k])
        h = np.einsum("pij,pj->pi", frames, inertia[3:6] * W[:, k])
        found.append(np.concatenate([inertia[0] * weights @ v, weights @ (inertia[0] * np.cross(r, v) + h)]))
        if k + 1 < run.t.size:
            turn = 0.5 * dt * (W[:, k] + W[:, k + 1])
            middle = frames @ rotations(0.5 * turn)
            r = r + 0.5 * dt * np.einsum("pij,pj->pi", middle, V[:, k] + V[:, k + 1])
            frames = frames @ rotations(turn)
    assert np.ptp(run.energy.total) <= 1e-13 * run.energy.total[0] * run.t.size
    assert (np.abs(run.moment(beam, 0.5)).max(axis=0) > 1e-6).all()  # it bends in both planes, and twists a little
    return np.array(found)


def test_momentum_of_a_free_beam_drifts_with_the_square_of_the_step():
    drifts = []
    for dt in (0.02, 0.01, 0.005):
        found = momenta(dt)
        drifts.append([np.abs(part - part[0]).max() / np.linalg.norm(part[0]) for part in np.split(found, 2, axis=1)])
    orders = np.log2(np.array(drifts[:-1]) / drifts[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.1)
    assert max(drifts[-1]) < 1e-3


def test_a_beam_turned_about_z_is_the_planar_one():
    """An imposed spin in the frame of the end: stiffening, Coriolis and lag are those of the plane."""
    runs = []
    for flat in (True, False):
        d = ph.Diagram("spin")
        ends = [p[:2] if flat else p for p in ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))]
        beam = d.add(ph.Beam("beam", SECTION, *ends, 3, degree=2))
        d.pin(d.ground, beam.start)
        spin = (lambda t: 6.0 * ramp(t)) if flat else (lambda t: (0.0, 0.0, 6.0 * ramp(t)))
        d.connect(beam.start.rotation, d.add(ph.AngularVelocity("drive", spin, follows=True)).port)
        run = ph.simulate(d.compile(outputs=None), 0.5, 5e-3)
        runs.append((run.velocity(beam.end, frame="material"), run.moment(beam.start), run.force(beam.start), run))
    (v, m, n, flat), (v_, m_, n_, run) = runs
    assert np.abs(m).max() > 1.0
    np.testing.assert_allclose(v_[:, :2], v, rtol=0.0, atol=1e-12 * np.abs(v).max())
    np.testing.assert_allclose(n_[:, :2], n, rtol=0.0, atol=1e-12 * np.abs(n).max())
    np.testing.assert_allclose(m_[:, 2], m, rtol=0.0, atol=1e-12 * np.abs(m).max())
    np.testing.assert_allclose(run.energy.supplied, flat.energy.supplied, rtol=0.0, atol=1e-12)


def test_a_ball_joint_with_the_ground_passes_no_moment():
    d = ph.Diagram("ball")
    beam = d.add(ph.Beam("beam", SECTION, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 3, degree=2))
    d.pin(d.ground, beam.start)
    system = d.compile(effects="all")
    run = ph.simulate(system, 0.3, 5e-3, start=system.rigid_motion(spin=(1.0, 2.0, 3.0)))
    assert not run.moment(beam.start).any() and not run.velocity(beam.start, frame="material").any()
    assert np.abs(run.force(beam.start)).max() > 1.0  # it holds what turns
    assert np.ptp(run.energy.total) <= 1e-12 * run.energy.total[0]


def test_a_linear_frame_in_space_sags_as_beam_theory_says():
    """A bent of two bars at a right angle, loaded at its tip out of its plane: bending of both and torsion of one."""
    force, a, b = 1e-3, 1.0, 0.5
    d = ph.Diagram("bent")
    first = d.add(ph.Beam("first", SECTION, (0.0, 0.0, 0.0), (a, 0.0, 0.0), 4, 2, damping=ph.Damping(10.0, 0.2)))
    second = d.add(ph.Beam("second", SECTION, (a, 0.0, 0.0), (a, b, 0.0), 4, 2, damping=ph.Damping(10.0, 0.2)))
    d.weld(d.ground, first.start)
    d.weld(first.end, second.start)
    d.connect(
        second.end.translation,
        d.add(ph.Force("F", lambda t: (0.0, 0.0, force * np.sin(0.5 * np.pi * min(t / 10.0, 1.0)) ** 2))).port,
    )
    system = d.compile(approximation=ph.Approximation(large_rotation=False))
    assert system.linear
    run = ph.simulate(system, 40.0, 0.02)  # to rest
    bend, shear, torsion = SECTION.bending[0], SECTION.shear[1], SECTION.torsion
    sag = force * (a**3 / (3.0 * bend) + b**3 / (3.0 * bend) + a * b**2 / torsion + (a + b) / shear)
    place = run.position(second.end)
    np.testing.assert_allclose(place[-1] - (a, b, 0.0), (0.0, 0.0, sag), rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(run.position(second.end, source="strain"), place, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(run.force(first.start, frame="fixed")[-1], (0.0, 0.0, force), rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(run.moment(first.start)[-1], (force * b, -force * a, 0.0), rtol=1e-6, atol=1e-12)
    assert max(gap.max() for gap in run.closure().values()) <= 1e-12


def test_weight_of_a_linear_beam_in_space():
    """Gravity along a slanted direction: the reaction is the weight, and energy is kept with that of gravity."""
    gravity = np.array([0.02, -0.03, -0.05])
    d = ph.Diagram("weight", gravity=gravity)
    beam = d.add(ph.Beam("beam", SECTION, (0.0, 0.0, 0.0), (0.6, 0.0, 0.8), 4, 2))
    d.weld(d.ground, beam.start)
    system = d.compile(approximation=ph.Approximation(large_rotation=False))
    run = ph.simulate(system, 2.0, 5e-3)
    assert np.abs(run.energy.gravity).max() > 1e-6
    assert np.abs(run.energy.total).max() <= 1e-12 * np.abs(run.energy.gravity).max() * 400
    nodes, weights = np.polynomial.legendre.leggauss(3)
    places = ((np.arange(4)[:, None] + 0.5 * (nodes + 1.0)) / 4.0).ravel()
    momentum = sum(w * run.velocity(beam, s)[-1] for s, w in zip(places, np.tile(weights / 8.0, 4), strict=True))
    impulse = np.trapezoid(run.force(beam.start, frame="fixed"), run.t, axis=0)
    np.testing.assert_allclose(gravity * run.t[-1] - impulse, momentum, rtol=0.0, atol=1e-13)
    assert np.abs(momentum).min() > 1e-6
