"""What is suggested to be put in: its frequency is that of the repaired diagram, its size a decade above the rest."""

import itertools

import numpy as np
import pytest

import phblocks as ph
from phblocks.causality import Repair

SOFT = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)


def body(name: str, x: float, mass: float, inertia: float, **anchors: tuple[float, float]) -> ph.RigidBody:
    return ph.RigidBody(name, mass, inertia, (x, 0.0), anchors)


def added(d: ph.Diagram) -> tuple[Repair, ph.System]:
    """The repair that adds stiffness or mass, and the system it makes."""
    repair = next(r for r in d.check().repairs if r.cost.frequency is not None)
    return repair, repair.apply(d).compile()


def test_two_bodies_pinned_off_their_centres():
    """k (1/m + arm^2/I of both) across the arms, k (1/m of both) along them: both by hand, and in the modes."""
    d = ph.Diagram()
    a, b = d.add(body("a", 0.0, 1.0, 0.1, p=(0.5, 0.0))), d.add(body("b", 1.5, 2.0, 0.4, p=(0.5, 0.0)))
    d.pin(a["p"], b["p"])
    repair, system = added(d)
    along, across = 1.0 + 0.5, 1.0 + 0.5**2 / 0.1 + 0.5 + 1.0**2 / 0.4
    k = repair.cost.stiffness
    assert k == pytest.approx(1000.0**2 / along, rel=5e-3)  # nothing sets a scale: 1000 rad/s, rounded to 3 digits
    assert repair.cost.frequency == pytest.approx(np.sqrt(k * across), rel=1e-12)
    np.testing.assert_allclose(system.modes(5).frequencies, np.sqrt([k * along, k * across]), rtol=1e-10)


def test_the_arm_may_point_anywhere():
    """Turned by 0.7 rad, anchors in the body: the same frequencies."""
    c, s = np.cos(0.7), np.sin(0.7)
    d = ph.Diagram()
    a = d.add(ph.RigidBody("a", 1.0, 0.1, (0.0, 0.0), {"p": (0.5, 0.0)}, coordinates="body", angle=0.7))
    b = d.add(ph.RigidBody("b", 2.0, 0.4, (1.5 * c, 1.5 * s), {"p": (0.5 * c, 0.5 * s)}))
    d.pin(a["p"], b["p"])
    repair, system = added(d)
    assert repair.cost.frequency == pytest.approx(np.sqrt(repair.cost.stiffness * 6.5), rel=1e-12)
    assert system.modes(5).frequencies[-1] == pytest.approx(repair.cost.frequency, rel=1e-10)


@pytest.mark.parametrize("verb", ["pin", "weld"])
def test_a_body_on_the_ground(verb):
    """Welded, the stiffness against turning makes three frequencies; the slowest is the aim, the fastest is told."""
    d = ph.Diagram()
    a = d.add(body("a", 0.0, 2.0, 0.3, p=(0.4, 0.0)))
    getattr(d, verb)(a["p"], d.ground)
    repair, system = added(d)
    frequencies = system.modes(5).frequencies
    assert frequencies.size == (3 if verb == "weld" else 2)
    assert frequencies[0] == pytest.approx(1000.0, rel=1e-2)
    assert frequencies[-1] == pytest.approx(repair.cost.frequency, rel=1e-9)


def test_three_at_one_pin():
    d = ph.Diagram()
    a, b = d.add(body("a", 0.0, 1.0, 0.1, p=(0.5, 0.0))), d.add(body("b", 1.0, 2.0, 0.1, p=(0.5, 0.0)))
    m = d.add(ph.Mass("m", 0.3, (0.5, 0.0)))
    d.pin(a["p"], b["p"], m.centre)
    repair, system = added(d)
    frequencies = system.modes(9).frequencies
    assert frequencies.size == 4
    assert frequencies[0] == pytest.approx(1000.0, rel=1e-2)
    assert frequencies[-1] == pytest.approx(repair.cost.frequency, rel=1e-10)
    assert repair.what.startswith("put 2 bushings of ") and repair.what.endswith(
        "one between a.p and each of b.p, m.centre"
    )
    assert len([b for b in system.report.network.blocks.values() if isinstance(b, ph.Bushing)]) == 2


def test_a_body_that_may_move_and_not_turn():
    d = ph.Diagram()
    a = d.add(body("a", 0.0, 1.0, 0.1))
    d.connect(a.centre.rotation, d.ground.rotation)
    repair, system = added(d)
    expected = np.sqrt(repair.cost.stiffness / 0.1)
    assert "torsion spring" in repair.what
    assert repair.cost.frequency == pytest.approx(expected, rel=1e-12)
    np.testing.assert_allclose(system.modes(5).frequencies, [expected], rtol=1e-10)


@pytest.mark.parametrize(("k", "scale"), [(40.0, 100.0), (4e6, np.sqrt(3.5 * 4e6))])
def test_a_spring_beside_sets_the_scale(k, scale):
    """Across a's arm to the spring, 1/m + arm^2/I = 3.5; slowest along the arms, a decade above sqrt(3.5 k).

    A soft spring does not make the joint soft: it stays at 1000 rad/s.
    """
    d = ph.Diagram()
    a = d.add(body("a", 0.0, 1.0, 0.1, p=(0.5, 0.0), q=(-0.5, 0.0)))
    b = d.add(body("b", 1.0, 2.0, 0.1, p=(0.5, 0.0)))
    spring = d.add(ph.Spring("s", k, (-0.5, 1.0), (-0.5, 0.0)))
    d.pin(a["p"], b["p"])
    d.pin(spring.start, d.ground)
    d.pin(spring.end, a["q"])
    repair, system = added(d)
    assert repair.cost.stiffness == pytest.approx((10.0 * scale) ** 2 / 1.5, rel=5e-3)
    frequencies = system.modes(9).frequencies
    assert frequencies[-1] == pytest.approx(repair.cost.frequency, rel=1e-3)  # the spring adds its little
    assert frequencies[frequencies > 9.0 * scale].size == 2


@pytest.mark.parametrize("inductance", [1e-2, 1e-8])
def test_a_motor_is_no_scale_for_a_bearing(inductance):
    """k^2 / (L I) of the shaft, 10 or 10000 rad/s, says nothing about how stiff the bearing must be."""
    d = ph.Diagram()
    rotor, frame = (
        d.add(body("rotor", 0.5, 1.0, 0.01, p=(0.0, 0.0))),
        d.add(body("frame", -0.5, 2.0, 0.1, p=(0.0, 0.0))),
    )
    motor, earth = d.add(ph.DCMotor("motor", 1.0, 0.1, inductance)), d.add(ph.Reference("earth"))
    supply = d.add(ph.Voltage("supply", 12.0))
    d.connect(motor.p, supply.port)
    d.connect(motor.n, earth.port)
    d.connect(motor.shaft, rotor.centre.rotation)
    d.connect(motor.stator, d.ground.rotation)
    d.pin(rotor["p"], frame["p"])
    repair, _ = added(d)
    assert repair.cost.stiffness == pytest.approx(1000.0**2 / 1.5, rel=5e-3)


def test_a_beam_with_fixed_ends_counts_as_it_is_meshed():
    """The joint is faster than all waves the mesh of the beam can carry."""
    d = ph.Diagram()
    beam = d.add(ph.Beam("beam", SOFT, (0.0, 0.0), (1.0, 0.0), elements=4, causality="free-free"))
    free = ph.Diagram()
    free.add(ph.Beam("beam", SOFT, (0.0, 0.0), (1.0, 0.0), elements=4, causality="free-free"))
    d.pin(beam.start, d.ground)
    repair, system = added(d)
    waves = free.compile().modes(500).frequencies[-1]
    assert repair.cost.frequency > 2.0 * waves
    assert system.modes(500).frequencies[-1] == pytest.approx(repair.cost.frequency, rel=0.1)


@pytest.mark.parametrize("verb", ["pin", "weld"])
def test_a_refined_beam_keeps_its_joint(verb):
    """One stiffness for all meshes, the frequency of each; what the repaired diagram does converges in order four."""
    lowest, stiffness = [], set()
    for elements in (4, 8, 16):
        d = ph.Diagram()
        beam = d.add(ph.Beam("b", SOFT, (0.0, 0.0), (1.0, 0.0), elements=elements, degree=2, causality="free-free"))
        tip = d.add(ph.RigidBody("tip", 0.5, 0.02, (1.0, 0.0)))
        getattr(d, verb)(beam.start, d.ground)
        d.pin(beam.end, tip.centre)
        repair, system = added(d)
        frequencies = system.modes(500).frequencies
        assert 0.95 * frequencies[-1] < repair.cost.frequency < frequencies[-1]
        stiffness.add(repair.what)
        lowest.append(frequencies[frequencies > 1.0][0])
    assert len(stiffness) == 1
    coarse, fine = np.abs(np.diff(lowest))
    assert coarse / fine == pytest.approx(16.0, rel=0.05)
    # the joint adds little to what the beam gives way
    held = ph.Diagram()
    beam = held.add(ph.Beam("b", SOFT, (0.0, 0.0), (1.0, 0.0), elements=16, degree=2))
    tip = held.add(ph.Mass("tip", 0.5, (1.0, 0.0)))
    getattr(held, verb)(beam.start, held.ground)
    held.pin(beam.end, tip.centre)
    rigid = held.compile().modes(500).frequencies
    assert lowest[-1] == pytest.approx(rigid[rigid > 1.0][0], rel=3e-3)


@pytest.mark.parametrize("curvature", [None, 1.5])
def test_the_coarsest_beam_has_the_same_ends(curvature):
    beam = ph.Beam("b", SOFT, (0.0, 0.0), (1.0, 0.0), elements=(0.0, 0.1, 1.0), degree=3, curvature=curvature)
    coarse = beam.coarsest
    assert (coarse.elements, coarse.degree, coarse.length) == (2, 1, beam.length) and coarse.coarsest is not beam
    assert {p.path for p in coarse.ports.values()} == {p.path for p in beam.ports.values()}
    assert coarse.end.angle == beam.end.angle and ph.Mass("m", 1.0, (0.0, 0.0)).coarsest.name == "m"


def test_a_mass_at_the_ends_of_beams_does_not_depend_on_their_meshes():
    masses = []
    for elements in (2, 9):
        d = ph.Diagram()
        ends = [((0.0, 0.0), (1.0, 0.0)), ((1.0, 0.0), (1.0, 1.0))]
        beams = [
            d.add(ph.Beam(f"b{i}", SOFT, *e, elements=elements, causality="pinned-pinned")) for i, e in enumerate(ends)
        ]
        d.pin(beams[0].end, beams[1].start)
        d.pin(beams[0].start, d.ground)
        d.pin(beams[1].end, d.ground)
        repair = next(r for r in d.check().repairs if r.cost.mass is not None)
        masses.append(repair.cost.mass)
    assert masses[0] == masses[1] > 0.0


def test_later_joints_do_not_climb_on_earlier_ones():
    """A chain of three bodies: the second bushing is as stiff as the first, not a decade stiffer."""
    d = ph.Diagram()
    bodies = [d.add(body(n, x, 1.0, 0.1, l=(x - 0.5, 0.0), r=(x + 0.5, 0.0))) for x, n in enumerate("abc")]
    d.pin(bodies[0]["r"], bodies[1]["l"])
    d.pin(bodies[1]["r"], bodies[2]["l"])
    repair, system = added(d)
    assert repair.what.count("put a bushing of 5e+05 N/m") == 2
    assert repair.cost.frequency < system.modes(9).frequencies[-1] < np.sqrt(2.0) * repair.cost.frequency


def test_of_many_joints_three_are_told():
    d = ph.Diagram()
    bodies = [d.add(body(f"b{x}", x, 1.0, 0.1, l=(x - 0.5, 0.0), r=(x + 0.5, 0.0))) for x in range(31)]
    for left, right in itertools.pairwise(bodies):
        d.pin(left["r"], right["l"])
    repair, system = added(d)
    assert repair.what.endswith(" ... and 27 more of the kind") and len(repair.what) < 250
    assert len([b for b in system.report.network.blocks.values() if isinstance(b, ph.Bushing)]) == 30
    assert all(len(r.what) < 250 for r in d.check().repairs)


def test_a_velocity_imposed_on_a_body_may_pull_on_a_bushing():
    d = ph.Diagram()
    a = d.add(body("a", 0.0, 2.0, 0.3, p=(0.4, 0.0)))
    d.expose(a["p"].translation, "drive", imposes="velocity")
    first, second, *_ = d.check().repairs
    assert "between outside 'drive' and a.p" in first.what and second.cost.index == 2
    followed = []
    for repair in (first, second):
        solution = ph.simulate(
            repair.apply(d).compile(), t_end=0.5, dt=5e-4, inputs={"drive": lambda t: (0.0, np.sin(4.0 * t))}
        )
        assert solution.max_power_balance_error < 1e-11 * np.abs(solution.energy["supplied"]).max()
        followed.append(solution.position("a", (0.4, 0.0)))
    np.testing.assert_allclose(followed[1][:, 1], (1.0 - np.cos(4.0 * solution.t)) / 4.0, atol=1e-4)
    assert 0.0 < np.abs(followed[0] - followed[1]).max() < 1e-3


def test_a_mass_between_springs_held_at_their_other_ends():
    """sqrt((k1 + k2) / m) exactly; with nothing moving around it, at 1000 rad/s."""
    d = ph.Diagram()
    a, b = d.add(ph.Spring("a", 10.0, (0.0, 0.0), (1.0, 0.0))), d.add(ph.Spring("b", 20.0, (1.0, 0.0), (2.0, 0.0)))
    c = d.add(ph.Spring("c", 5.0, (1.0, 1.0), (1.0, 0.0)))
    d.pin(a.start, d.ground)
    d.pin(a.end, b.start, c.end)
    d.pin(b.end, d.ground)
    d.pin(c.start, d.ground)
    (repair,) = d.check().repairs
    system = repair.apply(d).compile()
    assert repair.cost.mass == pytest.approx(30.0 / 1000.0**2)
    np.testing.assert_allclose(system.modes(3).frequencies, [np.sqrt(5.0 / repair.cost.mass), 1000.0], rtol=1e-10)
    assert repair.cost.frequency == pytest.approx(1000.0) and repair.cost.states == 2


def test_a_mass_is_a_decade_above_the_masses_around_it():
    d = ph.Diagram()
    m = d.add(ph.Mass("m", 4.0, (2.0, 0.0)))
    a, b = d.add(ph.Spring("a", 10.0, (0.0, 0.0), (1.0, 0.0))), d.add(ph.Damper("b", 3.0, (0.0, 1.0), (1.0, 0.0)))
    c = d.add(ph.Spring("c", 90.0, (1.0, 0.0), (2.0, 0.0)))
    d.pin(a.start, d.ground)
    d.pin(b.start, d.ground)
    d.pin(a.end, b.end, c.start)
    d.pin(c.end, m.centre)
    (repair,) = d.check().repairs
    assert repair.cost.mass == pytest.approx(100.0 / (100.0 * 90.0 / 4.0), rel=5e-3)


def test_dampers_alone_suggest_no_mass():
    d = ph.Diagram()
    a, b = d.add(ph.Damper("a", 1.0, (0.0, 0.0), (1.0, 0.0))), d.add(ph.Damper("b", 3.0, (1.0, 0.0), (2.0, 0.0)))
    d.pin(a.start, d.ground)
    d.pin(a.end, b.start)
    d.pin(b.end, d.ground)
    (repair,) = d.check().repairs
    whole = repair.apply(d).network.blocks["a-b"]
    assert repair.what == "make one damper of 'a' and 'b' in series" and whole.damping == pytest.approx(0.75)


def test_repairs_of_a_weld_in_conflict_in_both_domains():
    """Translations and rotations of a weld are in conflict; what joins the translations takes the rotations along."""
    d = ph.Diagram()
    ends = [
        ph.Beam(n, SOFT, (0.0, 0.0), e, elements=1, causality="free-free") for n, e in (("a", (1, 0)), ("b", (0, 1)))
    ]
    a, b = (d.add(beam) for beam in ends)
    d.weld(a.start, b.start, d.ground)
    report = d.check()
    assert len(report.conflicts) == 2
    assert {r.cost.stiffness is not None for r in report.repairs} == {True, False}
    for repair in report.repairs:
        system = repair.apply(d).compile()
        solution = ph.simulate(system, 0.02, 0.002, start=system.rigid_motion(velocity=(0.0, 0.1)))
        assert solution.max_power_balance_error < 1e-11 * max(1.0, solution.energy.total.max())


def test_no_stiffness_is_suggested_that_is_no_number():
    """A beam of 1.7e308 N on the ground would want a spring that is stiffer than any number."""
    section = ph.Section(axial=25.0, shear=1.7e308, bending=12.6, mass=11.0, rotary=54.0)
    d = ph.Diagram("stiff")
    beam = d.add(ph.Beam("beam", section, (1.5, -0.5), (0.3, 1.0), 1, 1, causality="free-free"))
    d.pin(beam.start, d.ground)
    with np.errstate(all="ignore"):
        report = d.check()
    assert not report.ok and not any("spring" in str(repair) for repair in report.repairs)
