"""Exact pruning: the unknowns that are left, and the same answer as with all of them."""

from dataclasses import replace

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ConstraintError, DataError, PrunedError, UnknownNameError
from phblocks.triplets import Triplets

BAR = ph.Section.rectangle(width=0.05, height=0.05, young=2.1e11, poisson=0.3, density=2710.0, shear_factor=1.0)
SOFT = ph.Section(axial=1e5, shear=5e4, bending=50.0, mass=1.0, rotary=1e-3)


def fields(system):
    """Block and field of the components that are computed."""
    return {(e.block, e.name) for e in system.effects.select(status="kept") if e.name not in WHOLE}


WHOLE = ("orientation", "positions", "nonlinearity")


def assert_alike(diagram, t_end, dt, readings, outputs="all", **options):
    """The pruned run is the whole one, to 1e-12 of the largest value of each reading."""
    pruned, whole = diagram.compile(outputs), diagram.compile(outputs, effects="all")
    runs = [ph.simulate(s, t_end, dt, **options) for s in (pruned, whole)]
    assert all(run.status.ok for run in runs)
    energy = runs[1].energy
    about = max(float(np.abs(energy[kind]).max()) for kind in energy)
    assert about > 0.0
    assert runs[0].max_power_balance_error <= max(1e-12 * about, 2.0 * runs[1].max_power_balance_error)
    for read in readings:
        mine, theirs = (np.asarray(read(run)) for run in runs)
        assert mine.shape == theirs.shape and np.abs(theirs).max() > 0.0
        np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=1e-12 * np.abs(theirs).max())
    return pruned, whole, runs[0]


def pulled(force=(100.0, 0.0), elements=8, **options):
    d = ph.Diagram("pulled")
    bar = d.add(ph.Beam("bar", BAR, (0.0, 0.0), (2.0, 0.0), elements, **options))
    d.weld(d.ground, bar.start)
    d.connect(bar.end.translation, d.add(ph.Force("F", force)).port)
    return d, bar


@pytest.mark.parametrize("degree", [1, 2])
def test_a_bar_that_is_pulled_needs_two_fields(degree):
    d, bar = pulled(degree=degree)
    readings = [
        lambda s: s.position(bar, 0.7),
        lambda s: s.position(bar, 0.7, source="strain"),
        lambda s: s.velocity(bar.end),
        lambda s: s.force(bar, 0.3),
        lambda s: s.force(bar.start),
        lambda s: s.energy.total,
        lambda s: s.power.inputs["F.x"],
    ]
    pruned, whole, run = assert_alike(d, 2e-3, 2e-5, readings)
    assert fields(pruned) == {("bar", "V1"), ("bar", "N1")}
    assert (pruned.n, whole.n) == (whole.n // 3, 3 * pruned.n)
    assert pruned.linear and not whole.linear
    assert pruned.start.theta.size == 0
    # what is left out can be read all the same
    np.testing.assert_array_equal(run.moment(bar, 0.3), 0.0)
    np.testing.assert_array_equal(run.spin(bar, 0.3), 0.0)
    np.testing.assert_array_equal(run.angle(bar, 0.3), 0.0)
    np.testing.assert_array_equal(run.angle(bar.end), 0.0)
    np.testing.assert_array_equal(run.state("bar.M3[0]"), np.zeros(run.t.size))
    with pytest.raises(UnknownNameError, match=r"state: expected one of system\.state_names"):
        run.state("bar.M4[0]")
    assert max(gap.max() for gap in run.closure().values()) <= 1e-15


@pytest.mark.parametrize(
    "method",
    [ph.GaussLegendre(2), ph.LinearlyImplicit(), ph.ScipyIVP("Radau", 1e-13, 1e-13)],
    ids=lambda m: type(m).__name__,
)
def test_every_method_takes_what_is_left(method):
    d, bar = pulled(elements=2)
    runs = [ph.simulate(d.compile(effects=e), 2e-4, 1e-5, method=method) for e in ("auto", "all")]
    mine, theirs = (run.force(bar, 0.3) for run in runs)
    tolerance = 1e-8 if isinstance(method, ph.ScipyIVP) else 1e-12  # that one estimates errors by a norm of all states
    np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=tolerance * np.abs(theirs).max())


class Linear(ph.Beam):
    """A beam without its products."""

    def form(self, gives):
        return replace(super().form(gives), T=Triplets.empty(3))


def test_linear_transverse_vibration_needs_four_fields():
    def shaken(follows):
        d = ph.Diagram("across")
        beam = d.add(Linear("beam", SOFT, (0.0, 0.0), (1.0, 0.0), 6))
        d.weld(d.ground, beam.start)
        d.connect(beam.end.translation, d.add(ph.Force("F", (0.0, 1.0), follows=follows)).port)
        readings = [lambda s: s.velocity(beam.end), lambda s: s.moment(beam, 0.2), lambda s: s.angle(beam, 0.9)]
        return assert_alike(d, 0.05, 1e-3, readings)

    pruned, whole, _ = shaken(follows=True)
    assert fields(pruned) == {("beam", f) for f in ("V2", "W3", "N2", "M3")}
    assert 3 * pruned.n == 2 * whole.n and pruned.linear
    # a force that stays vertical has a part along the cross section as soon as that turns
    assert len(fields(shaken(follows=False)[0])) == 6


def test_the_bar_stretches_as_the_wave_equation_says():
    """Static elongation F L / EA is the mean, twice that the largest: a rod that is pulled suddenly."""
    d, bar = pulled(elements=40)
    solution = ph.simulate(d.compile(), t_end=8e-4, dt=2e-7 * 20)
    stretch = solution.position(bar.end, source="strain")[:, 0] - 2.0
    assert stretch.max() == pytest.approx(2.0 * 100.0 * 2.0 / (2.1e11 * 0.05**2), rel=0.02)


@pytest.mark.parametrize("way", [(0.0, -2.0), (1.2, -1.6)])
def test_a_bar_that_hangs_is_only_stretched(way):
    """Along gravity, also where the two only agree to round-off."""
    g = 9.81 * np.array(way) / 2.0
    d = ph.Diagram("hanging", gravity=g)
    bar = d.add(ph.Beam("bar", BAR, (0.0, 0.0), way, 6))
    d.weld(d.ground, bar.start)
    pruned, whole, _ = assert_alike(
        d, 2e-3, 2e-5, [lambda s: s.position(bar, 1.0), lambda s: s.energy.gravity, lambda s: s.force(bar, 0.2)]
    )
    assert fields(pruned) == {("bar", "V1"), ("bar", "N1")} and pruned.linear
    assert 3 * pruned.n == whole.n


def test_gravity_across_calls_for_everything():
    d = ph.Diagram("across", gravity=(0.0, -9.81))
    bar = d.add(ph.Beam("bar", SOFT, (0.0, 0.0), (1.0, 0.0), 4))
    d.weld(d.ground, bar.start)
    system = d.compile()
    # linear in V2 W3 N2 M3; V1 and N1 follow through products, so that exactness keeps them
    assert fields(system) == {("bar", f) for f in ("V1", "V2", "W3", "N1", "N2", "M3")}
    reason = system.effects.select(block="bar", name="N1")[0].reason
    assert "times" in reason and "gravity (0, -9.81)" in reason


def torsion(discs=4):
    """A chain of discs; each spring hangs between two of them."""
    d = ph.Diagram("torsion")
    wheels = [d.add(ph.RigidBody(f"disc{i}", 2.0, 0.5 + 0.1 * i, (float(i), 0.0))) for i in range(discs)]
    springs = [d.add(ph.TorsionSpring(f"spring{i}", 40.0 + i)) for i in range(discs)]
    d.connect(d.ground.rotation, springs[0].first)
    for wheel, left, right in zip(wheels, springs, [*springs[1:], None], strict=True):
        d.connect(wheel.centre.rotation, left.second, *([] if right is None else [right.first]))
    d.expose(wheels[-1].centre.rotation, "moment")
    return d, wheels, springs


def test_torsion_needs_spins_and_moments_only():
    d, wheels, springs = torsion()
    readings = [
        lambda s: s.angle(wheels[0].centre),
        lambda s: s.spin(wheels[-1].centre),
        lambda s: s.state("spring1.M3[0]"),
        lambda s: s.energy.total,
    ]
    pruned, whole, run = assert_alike(d, 2.0, 0.01, readings, inputs={"moment": lambda t: np.sin(3.0 * t)})
    assert fields(pruned) == {*((w.name, "W3") for w in wheels), *((s.name, "M3") for s in springs)}
    assert (pruned.n, whole.n) == (8, 16) and pruned.linear
    np.testing.assert_array_equal(run.position(wheels[1].centre), np.tile([1.0, 0.0], (run.t.size, 1)))


def test_what_nothing_joins_to_what_moves_stays_at_rest():
    """A whole mechanism beside the one that is driven: none of its states, joints and angles are computed."""
    d, bar = pulled()
    a = d.add(ph.Beam("a", SOFT, (0.0, 1.0), (1.0, 1.0), 3))
    b = d.add(ph.Beam("b", SOFT, (1.0, 1.0), (1.0, 2.0), 3))
    spring = d.add(ph.Spring("spring", 100.0, (1.0, 2.0), (3.0, 3.0)))
    d.pin(d.ground, a.start)
    d.pin(a.end, b.start)
    d.pin(b.end, spring.start)
    d.pin(spring.end, d.ground)
    pruned, _, run = assert_alike(d, 1e-4, 1e-5, [lambda s: s.position(bar.end), lambda s: s.position(b, 0.5)])
    assert {block for block, _ in fields(pruned)} == {"bar"}
    assert pruned.start.theta.size == 0 and pruned.linear and pruned.lines.count == 0
    np.testing.assert_allclose(run.position(b, 0.5)[-1], [1.0, 1.5], rtol=1e-15)
    np.testing.assert_array_equal(run.force(b.end), 0.0)
    assert max(gap.max() for gap in run.closure().values()) < 1e-12
    assert run.power.blocks["spring"]["stored"][-1] == 0.0


def test_the_line_of_a_spring_turns_what_is_across():
    """Along the spring only: nothing across it. With the mass pushed across, or the spring slanted, both."""

    def sprung(end, push):
        d = ph.Diagram("sprung")
        mass = d.add(ph.Mass("mass", 1.0, (2.0, 0.0)))
        spring = d.add(ph.Spring("spring", 50.0, (0.0, 0.0) if end is None else end, (2.0, 0.0)))
        d.pin(spring.start, d.ground)
        force = d.add(ph.Force("push", push))
        d.connect(spring.end.translation, mass.centre.translation, force.port)
        return assert_alike(d, 1.0, 0.01, [lambda s: s.position(mass.centre), lambda s: s.energy.total])[0]

    along = sprung(None, (3.0, 0.0))
    assert {f for b, f in fields(along) if b == "mass"} == {"vx"}
    assert {f for b, f in fields(sprung(None, (0.0, 3.0))) if b == "mass"} == {"vx", "vy"}
    assert {f for b, f in fields(sprung((0.0, 1.0), (3.0, 0.0))) if b == "mass"} == {"vx", "vy"}


def test_a_prestressed_spring_is_an_excitation():
    d = ph.Diagram("released")
    mass = d.add(ph.Mass("mass", 1.0, (2.0, 0.0)))
    spring = d.add(ph.Spring("spring", 50.0, (0.0, 0.0), (2.0, 0.0), free_length=1.5))
    d.pin(spring.start, d.ground)
    d.pin(spring.end, mass.centre)
    pruned, whole, _ = assert_alike(d, 1.0, 0.01, [lambda s: s.position(mass.centre), lambda s: s.energy.strain])
    assert (pruned.n, whole.n) == (4, 5)
    assert "spring" in pruned.effects.select(block="mass", name="vx")[0].reason
    assert "its start" in pruned.effects.select(block="mass", name="vx")[0].reason


def welded(way, force, elements=3):
    """Two bars that share the states of their weld; the second goes another way."""
    d = ph.Diagram("welded")
    end = np.array([1.0, 0.0]) + way
    a = d.add(ph.Beam("a", SOFT, (0.0, 0.0), (1.0, 0.0), elements, causality="free-free"))
    b = d.add(ph.Beam("b", SOFT, (1.0, 0.0), end, elements, causality="free-free"))
    d.weld(a.end, b.start)
    d.connect(b.end.translation, d.add(ph.Force("F", force)).port)
    readings = [lambda s: s.position(b, 0.7), lambda s: s.position(a, 0.2), lambda s: s.energy.total]
    pruned, whole, run = assert_alike(d, 0.1, 1e-3, readings)
    assert pruned.sharing.groups
    return pruned, whole, run, a


def test_welded_bars_share_and_are_pruned_together():
    pruned, whole, run, a = welded((1.0, 0.0), (5.0, 0.0))
    assert pruned.n == 4 + 4 + 3 + 3 - 1 and whole.n == 3 * pruned.n and pruned.linear
    np.testing.assert_array_equal(run.moment(a, 0.5), 0.0)
    # at an angle, what is along one is across the other
    for way, force in (((0.0, 1.0), (0.0, 5.0)), ((0.6, 0.8), (5.0, 0.0))):
        assert len(fields(welded(way, force)[0])) == 12


def test_a_load_that_is_added_brings_back_what_it_excites():
    d, bar = pulled()
    before = d.compile()
    d.connect(bar.end.rotation, d.add(ph.Moment("twist", 1.0)).port)
    after = d.compile()
    assert len(fields(before)) == 2 and len(fields(after)) == 6 and not after.linear
    assert_alike(d, 2e-4, 1e-5, [lambda s: s.position(bar.end), lambda s: s.moment(bar, 0.5)])


def test_custom_energy_at_rest_is_pruned_and_prestressed_is_not():
    def duffing(start, constant=0.0):
        d, _ = pulled()
        d.add(
            ph.CustomBlock(
                "duffing",
                2,
                lambda x: 0.5 * x[1] ** 2 + 0.25 * x[0] ** 4 + constant,
                gradient=lambda x: np.array([x[0] ** 3, x[1]]),
                hessian=lambda x: np.diag([3.0 * x[0] ** 2, 1.0]),
                J=np.array([[0.0, 1.0], [-1.0, 0.0]]),
                start=start,
            )
        )
        return d

    rest, whole = (duffing((0.0, 0.0)).compile(effects=e) for e in ("auto", "all"))
    assert rest.quadratic and not whole.quadratic and whole.n == 3 * rest.n + 4
    for d in (duffing((1.0, 0.0)), duffing((0.0, 0.0), constant=2.0)):
        system = d.compile()
        assert not system.quadratic and "duffing" in {b for b, _ in fields(system)}
        energy = ph.simulate(system, 1e-3, 1e-4).energy.total
        assert energy[0] == pytest.approx(ph.simulate(d.compile(effects="all"), 1e-3, 1e-4).energy.total[0])


def test_what_is_redundant_is_refused_also_where_nothing_moves():
    def idle(pins):
        d, _ = pulled()
        a, b = (d.add(ph.RigidBody(n, 1.0, 0.1, (9.0, 0.0), {"p": (0.0, 0.5)})) for n in "ab")
        d.pin(a.centre, b.centre, multiplier=True)
        if pins == 2:
            d.weld(a["p"], b["p"], multiplier=True)
        return d

    assert idle(1).compile().n == pulled()[0].compile().n
    for effects in ("auto", "all"):
        with pytest.raises(ConstraintError, match="expected constraints that do not follow from each other"):
            idle(2).compile(effects=effects)


# --- starts and inputs that would move what is left out ---------------------------------------------------------------


def test_a_start_that_moves_what_is_left_out_is_refused():
    d, bar = pulled()
    system = d.compile()
    with pytest.raises(PrunedError, match=r"rigid_motion: V2 of 'bar': expected zero.* got 3 m/s.*effects=\"all\""):
        system.rigid_motion((0.0, 3.0))
    whole = d.compile(effects="all")
    full = whole.rigid_motion((2.0, 0.0))  # in all coordinates: nothing moves but what is computed
    a = ph.simulate(system, 1e-4, 1e-5, start=full)
    b = ph.simulate(whole, 1e-4, 1e-5, start=full)
    np.testing.assert_allclose(a.position(bar.end), b.position(bar.end), rtol=0.0, atol=1e-12)
    assert a.x[0].max() == 2.0
    with pytest.raises(PrunedError, match=r"simulate start: V2 of 'bar'"):
        ph.simulate(system, 1e-4, 1e-5, start=whole.rigid_motion((0.0, 3.0)))
    turned = ph.State(whole.start.x, whole.start.theta + 0.1, whole.start.points)
    with pytest.raises(PrunedError, match=r"start\.theta: expected zero for what nothing in the diagram turns"):
        ph.simulate(system, 1e-4, 1e-5, start=turned)
    with pytest.raises(PrunedError, match="linearize state: V2"):
        system.linearize(whole.rigid_motion((0.0, 3.0)))
    with pytest.raises(DataError, match=r"simulate start\.x: expected finite numbers of shape"):
        ph.simulate(system, 1e-4, 1e-5, start=ph.State(np.zeros(5), system.start.theta, system.start.points))


def test_a_span_that_nothing_moves_stays_where_it_is():
    d = ph.Diagram("sprung")
    mass = d.add(ph.Mass("mass", 1.0, (2.0, 0.0)))
    spring = d.add(ph.Spring("spring", 50.0, (0.0, 0.0), (2.0, 0.0), free_length=1.5))
    d.pin(spring.start, d.ground)
    d.pin(spring.end, mass.centre)
    system = d.compile()
    x = system.start.x.copy()
    x[system.state_names.index("spring.ry[0]")] = 0.1
    with pytest.raises(PrunedError, match=r"start: spring\.ry\[0\]: expected 0, where the diagram has it"):
        ph.simulate(system, 1.0, 0.1, start=ph.State(x, system.start.theta, system.start.points))


def test_another_signal_than_that_of_the_source_is_refused_where_it_counts():
    d, bar = pulled()
    system = d.compile()
    np.testing.assert_array_equal(
        ph.simulate(system, 1e-4, 1e-5, inputs={"F": lambda t: (100.0, 0.0)}).x, ph.simulate(system, 1e-4, 1e-5).x
    )
    for signal in ((0.0, 1.0), lambda t: (1.0, 1e-9 * t)):
        with pytest.raises(PrunedError, match=r"simulate inputs.*\['F\.y'\]: expected zero, as its source says"):
            ph.simulate(system, 1e-4, 1e-5, inputs={"F": signal})
    with pytest.raises(PrunedError, match=r"linearize u\['F\.y'\]"):
        system.linearize(u=np.array([0.0, 1.0]))
    # a source that is silent where everything moves anyway may say anything
    d.expose(bar.end.translation, "tip")
    system = d.compile()
    assert ph.simulate(system, 1e-4, 1e-5, inputs={"F": (0.0, 1.0)}).status.ok


def test_a_drive_that_stands_still_may_not_turn():
    """Its orientation is not integrated, though all that it acts on moves."""
    d = ph.Diagram("held", gravity=(0.0, -9.81))
    arm = d.add(ph.Beam("arm", SOFT, (0.0, 0.0), (1.0, 0.0), 3))
    d.pin(d.ground, arm.start)
    d.connect(arm.start.rotation, d.add(ph.AngularVelocity("drive", 0.0)).port)
    readings = [lambda s: s.position(arm.end), lambda s: s.moment(arm, 0.5), lambda s: s.energy.gravity]
    pruned, whole, run = assert_alike(d, 0.05, 1e-3, readings)
    assert pruned.n == whole.n and pruned.start.theta.size == whole.start.theta.size - 1
    np.testing.assert_array_equal(run.angle(arm.start), 0.0)
    with pytest.raises(PrunedError, match=r"simulate inputs\['drive'\]: expected zero, as its source says"):
        ph.simulate(pruned, 0.05, 1e-3, inputs={"drive": 1.0})


def test_modes_are_those_of_all_states_or_refused():
    d, _ = pulled()
    with pytest.raises(PrunedError, match=r"modes of system 'pulled': expected all states.*V2 of 'bar', W3 of 'bar'"):
        d.compile().modes(2)
    # bending comes first; along the bar alone it would be the wrong answer
    assert d.compile(effects="all").modes(1).frequencies[0] < 200.0


def test_matrices_are_the_same_from_input_to_output():
    """What is left out is neither moved by the inputs nor seen by the outputs."""
    d, _ = pulled()
    found = []
    for effects in ("auto", "all"):
        m = d.compile(effects=effects).matrices()
        s = 2j * np.pi * 300.0
        found.append(m.G.T @ np.linalg.solve((s * m.E - m.J + m.R).toarray(), m.G[:, [0]].toarray()))
    assert found[0].shape == (1, 1) and found[1].shape == (2, 1)
    np.testing.assert_allclose(found[0][0], found[1][0], rtol=1e-9)


# --- bookkeeping: orientations and positions --------------------------------------------------------------------------


def four_bar(gravity):
    d = ph.Diagram("four-bar", gravity=gravity)
    places = [(0.0, 0.5), (2.0, 1.5), (3.5, 1.5), (2.5, 0.5)]
    bars = [d.add(ph.Beam(n, BAR, p, q, 4)) for n, p, q in zip("abc", places, places[1:], strict=False)]
    for first, second in zip([d.ground, *(b.end for b in bars)], [*(b.start for b in bars), d.ground], strict=True):
        d.pin(first, second)
    d.expose(bars[0].start.rotation, "moment")
    return d


def test_positions_are_kept_for_gravity_and_outputs_only():
    assert four_bar(None).compile(outputs=None).start.points.size == 0
    heavy = four_bar((0.0, -9.81)).compile(outputs=None)
    assert heavy.start.points.shape == (24, 2)
    assert {e.reason for e in heavy.effects.select(name="positions")} == {"gravity acts"}
    for e in four_bar(None).compile(outputs=None).effects.select(name="positions"):
        assert e.status == "pruned" and e.states == 16 and e.reason == "no gravity and no output needs them"


def test_orientations_are_kept_where_frames_turn_against_each_other():
    """Of each beam only the angles at its joints, not those along it; without gravity."""
    for gravity, count in ((None, 4), ((0.0, -9.81), 15)):
        system = four_bar(gravity).compile(outputs=None)
        assert system.start.theta.size == count


@pytest.mark.parametrize("pinned", [False, True])
def test_a_beam_that_swings_alone_needs_no_angle(pinned):
    d = ph.Diagram("swing")
    beam = d.add(ph.Beam("beam", SOFT, (0.0, 0.0), (1.0, 0.5), 4))
    if pinned:
        d.pin(beam.start, d.ground)
    system = d.compile(outputs=None)
    assert system.start.theta.size == 0 and system.start.points.size == 0
    assert system.effects.select(name="orientation")[0].reason == "no joint, load, gravity or output needs it"
    whole = d.compile()
    assert whole.start.theta.size >= 5 and whole.n == system.n
    about = (0.0, 0.0) if pinned else (0.3, 0.1)
    a, b = (ph.simulate(s, 0.1, 1e-3, start=s.rigid_motion(spin=4.0, about=about)) for s in (system, whole))
    np.testing.assert_allclose(a.x, b.x, rtol=0.0, atol=1e-10 * np.abs(b.x).max())


# --- how it is asked for ----------------------------------------------------------------------------------------------


def test_a_diagram_that_nothing_excites_is_computed_as_a_whole():
    d = ph.Diagram("rest")
    beam = d.add(ph.Beam("beam", SOFT, (0.0, 0.0), (1.0, 0.0), 4))
    d.weld(d.ground, beam.start)
    system = d.compile()
    assert system.n == d.compile(effects="all").n and system.modes(1).frequencies[0] > 0.0
    assert {e.reason for e in system.effects if e.name == "V1"} == {
        "nothing excites the diagram: computed as a whole, for a start or for modes"
    }


def test_effects_are_two():
    with pytest.raises(DataError, match=r"compile effects: expected \"auto\" or \"all\", got 'some'"):
        pulled()[0].compile(effects="some")
    assert {e.reason for e in pulled()[0].compile(effects="all").effects.select(name="V2")} == {
        'asked for with effects="all"'
    }


def test_matrices_have_no_inputs_whose_motion_is_not_computed(tmp_path):
    """Never a silent column of zeros: what F.y alone would move is left out, so F.y is."""
    d, _ = pulled(elements=2)
    system, whole = d.compile(), d.compile(effects="all")
    assert system.input_names == ("F.x", "F.y") and system.acting.tolist() == [0] and whole.acting.tolist() == [0, 1]
    linear, matrices, all_ = system.linearize(), system.matrices(), whole.matrices()
    assert linear.inputs.tolist() == [0] and linear.B.shape == (6, 1) and linear.C.shape == (1, 6)
    assert matrices.input_names == ("F.x",) and matrices.output_names == ("F.x velocity",)
    assert all_.input_names == ("F.x", "F.y") and abs(all_.G[:, [1]]).sum() > 0.0
    s = 100.0j

    def transfer(m):
        t = m.tangent
        return (t.C @ np.linalg.solve(s * t.E.toarray() - t.A.toarray(), t.B.toarray()) + t.D)[0, 0]

    assert transfer(matrices) == pytest.approx(transfer(all_), rel=1e-10)
    assert [str(u) for u in system.symbolic().u] == ["u_F_x"]
    (file,) = system.export(tmp_path / "pulled.npz")
    with np.load(file) as stored:
        assert [str(name) for name in stored["input_names"]] == ["F.x"]


def test_control_gets_the_inputs_that_act_only():
    pytest.importorskip("control")
    system = pulled()[0].compile()
    model, moving = system.to_control(), system.to_control(nonlinear=True)
    assert model.ninputs == moving.ninputs == moving.noutputs == 1
    x, u = np.linspace(1.0, 2.0, moving.nstates), np.array([3.0])
    np.testing.assert_allclose(
        moving.dynamics(0.0, x, u)[: model.nstates], model.A @ x[: model.nstates] + model.B @ u, rtol=1e-9
    )


@pytest.mark.parametrize("quarter", range(5))
def test_a_pull_along_an_axis_may_have_round_off_across(quarter):
    """cos(pi/2) is 6e-17: no component of a force, as it is none of a direction."""
    e = np.array([np.cos(quarter * np.pi / 2), np.sin(quarter * np.pi / 2)])
    d = ph.Diagram("pulled")
    bar = d.add(ph.Beam("bar", BAR, (0.0, 0.0), tuple(2.0 * e), 4))
    d.weld(d.ground, bar.start)
    d.connect(bar.end.translation, d.add(ph.Force("F", 100.0 * e)).port)
    system = d.compile()
    assert system.n == 10 and system.acting.size == 1
    solution = ph.simulate(system, 1e-3, 1e-4)
    whole = ph.simulate(d.compile(effects="all"), 1e-3, 1e-4)
    np.testing.assert_allclose(solution.position(bar, 1.0), whole.position(bar, 1.0), rtol=1e-13, atol=1e-13)


def test_a_start_from_a_whole_run_has_its_round_off():
    """A bar that hangs moves across by 1e-17 m/s in the whole run: nothing beside its weight."""
    d = ph.Diagram("hanging", gravity=(0.0, -9.81))
    bar = d.add(ph.Beam("bar", BAR, (0.0, 0.0), (0.0, -1.0), 4))
    d.pin(d.ground, bar.start)
    whole = ph.simulate(d.compile(effects="all"), 2.0, 0.01)
    across = np.abs(whole.velocity(bar.end)[:, 0]).max()
    assert 0.0 < across < 1e-12
    system = d.compile()
    assert ph.simulate(system, 0.1, 0.01, start=whole.at(1.0)).status.ok
    moved = d.compile(effects="all").rigid_motion((1e-8, 0.0))
    with pytest.raises(ph.errors.PrunedError):
        ph.simulate(system, 0.1, 0.01, start=moved)
