"""The stability card against numbers worked out by hand and by dense linear algebra."""

import json

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, UnknownNameError
from phblocks.system import stability
from phblocks.system.stability import newton_condition, newton_matrix


def oscillator(k: float = 100.0, m: float = 4.0) -> ph.System:
    d = ph.Diagram("oscillator")
    disc = d.add(ph.RigidBody("disc", 1.0, m, (0.0, 0.0), {"axle": (0.0, 0.0)}))
    spring = d.add(ph.TorsionSpring("spring", k))
    d.connect(disc["axle"].rotation, spring.first)
    d.connect(spring.second, d.ground.rotation)
    return d.compile()


def chain(elements: int, bar: ph.Section) -> ph.System:
    d = ph.Diagram("chain")
    left = d.add(ph.Beam("left", bar, (0.0, 0.0), (1.0, 0.0), elements=elements))
    right = d.add(ph.Beam("right", bar, (1.0, 0.0), (2.0, 0.0), elements=elements))
    d.pin(d.ground, left.start)
    d.pin(left.end, right.start)
    return d.compile()


def test_one_oscillator():
    """omega = sqrt(100 / 4) = 5 rad/s; the scaled Newton matrix is [[2/h, -5], [5, 2/h]]: condition in closed form."""
    card = oscillator().stability_card(0.1)
    assert card.h_omega_max == pytest.approx(0.5, rel=1e-12)
    assert (card.modes, card.unresolved, card.unresolved_share) == (1, 0, 0.0)
    inverse = (20.0 + 5.0) / (20.0**2 + 5.0**2)
    assert card.condition == pytest.approx(25.0 * inverse, rel=1e-12)
    assert card.round_off == pytest.approx(card.condition * 2.0**-52, rel=1e-12)
    assert (card.index, card.without_energy, card.constraints, card.gap) == (0, 0, (), 0.0)
    long = oscillator().stability_card(0.3)
    assert (long.h_omega_max, long.unresolved) == (pytest.approx(1.5), 1)


def test_the_newton_matrix_is_the_one_that_steps_factorise(four_bar):
    """At a state in motion, orientations eliminated: against finite differences of the residual of a step."""
    system = four_bar().compile()
    run = ph.simulate(system, 0.2, 0.02)
    state, dt = run.at(0.2), 0.01
    scale = stability.state_scale(system)
    turned = system.rates

    def residual(z: np.ndarray) -> np.ndarray:
        x = z * scale
        theta = state.theta + 0.5 * dt * (turned @ (x - state.x))
        return scale * (2.0 / dt * (system.rate_matrix @ x) - system.force(x, theta))

    z = state.x / scale
    size = 1e-5 * np.linalg.norm(z)
    columns = [(residual(z + e) - residual(z - e)) / (2.0 * size) for e in size * np.eye(system.n)]
    expected = np.stack(columns, axis=1)
    np.testing.assert_allclose(newton_matrix(system, dt, state).toarray(), expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("dt", [1e-6, 1e-2, 10.0])
def test_condition_against_a_dense_one(four_bar, dt):
    system = four_bar((6, 6, 6)).compile()
    assert system.n > stability.SMALL
    exact = float(np.linalg.cond(newton_matrix(system, dt, system.start).toarray(), 1))
    assert exact / 3.0 <= newton_condition(system, dt, system.start) <= exact * (1.0 + 1e-9)


def test_modes_against_dense_eigenvalues(bar):
    """All of the skew J in the metric of E, without rigid motions."""
    system = chain(4, bar)
    E, J = system.E.toarray(), system.J().toarray()
    root = np.linalg.cholesky(E)
    omega = np.sort(np.abs(np.linalg.eigvals(np.linalg.solve(root, np.linalg.solve(root, J).T).T).imag))[::-2]
    omega = omega[omega > 1e-6 * omega[0]]
    dt = 1.0 / np.median(omega)
    card = system.stability_card(dt)
    assert card.h_omega_max == pytest.approx(dt * omega[0], rel=1e-9)
    assert card.modes == omega.size and card.unresolved == (dt * omega > 1.0).sum() > 3


def test_large_systems_are_counted_without_dense_algebra(bar, monkeypatch):
    """Lanczos for the highest frequency and inertia for the counts, against dense eigenvalues of the same system."""
    system = chain(30, bar)
    dense = [system.stability_card(dt) for dt in (1e-7, 1e-5, 1e-4, 1e-2)]
    monkeypatch.setattr(stability, "DENSE", 10)
    for card in dense:
        sparse = system.stability_card(card.dt)
        assert sparse.h_omega_max == pytest.approx(card.h_omega_max, rel=1e-4)
        assert (sparse.modes, sparse.unresolved) == (card.modes, card.unresolved)
    assert {card.unresolved for card in dense} >= {0} and len({card.unresolved for card in dense}) == 4


def test_what_is_not_counted_is_said(bar, monkeypatch):
    monkeypatch.setattr(stability, "DENSE", 1)
    d = ph.Diagram("pinned", gravity=(0.0, -9.81))
    body = d.add(ph.RigidBody("body", 2.0, 0.3, (0.5, 0.0), {"pin": (0.0, 0.0)}))
    d.pin(body["pin"], d.ground, multiplier=True)
    card = d.compile().stability_card(0.01)
    assert card.h_omega_max is card.modes is card.unresolved is card.unresolved_share is None
    assert card.findings["modes"].verdict == "unknown" and "Not counted" in str(card)


def test_index_and_states_without_energy():
    """A damper is of index 1, a pin with multipliers of index 2."""
    d = ph.Diagram("damped")
    disc = d.add(ph.RigidBody("disc", 1.0, 4.0, (0.0, 0.0), {"axle": (0.0, 0.0)}))
    damper = d.add(ph.TorsionDamper("damper", 2.0))
    d.connect(disc["axle"].rotation, damper.first)
    d.connect(damper.second, d.ground.rotation)
    card = d.compile().stability_card(0.1)
    assert (card.index, card.without_energy, card.constraints) == (1, 1, ())
    d = ph.Diagram("pinned", gravity=(0.0, -9.81))
    body = d.add(ph.RigidBody("body", 2.0, 0.3, (0.5, 0.0), {"pin": (0.0, 0.0)}))
    d.pin(body["pin"], d.ground, multiplier=True)
    card = d.compile().stability_card(0.1)
    assert card.index == card.without_energy == 2
    assert card.constraints == ("pin body ground.force x[0]", "pin body ground.force y[0]")
    assert "pin body ground.force x[0]" in str(card)


def test_the_gap_that_is_told_is_the_gap_that_opens():
    """Steady spin at omega dt = 0.2: (omega dt)^2 / 12 of the length."""
    soft = ph.Section(axial=4e6, shear=2e6, bending=6e3, mass=1.2, rotary=2e-3)
    d = ph.Diagram("spin")
    beam = d.add(ph.Beam("beam", soft, (0.0, 0.0), (1.0, 0.0), elements=2, degree=2))
    d.pin(beam.start, d.ground)
    system = d.compile()
    start, dt = system.rigid_motion(spin=6.0), 0.2 / 6.0
    card = system.stability_card(dt, start)
    assert card.spin == pytest.approx(6.0) and card.gap == pytest.approx(0.04 / 12.0)
    measured = ph.simulate(system, 3.0, dt, start=start).health["gap of strain and configuration"].value
    assert measured == pytest.approx(card.gap, rel=0.1)
    fast = system.stability_card(0.5 / 6.0, start)
    assert fast.findings["expected gap over length, (spin dt)^2 / 12"].verdict == "over"


def test_a_condition_that_leaves_nothing_is_over(bar):
    """h omega_max = 2e16 beside rigid motions: all but the largest frequencies are below round-off."""
    system = chain(2, bar)
    dt = 2e16 / system.stability_card(1.0).omega_max
    card = system.stability_card(dt)
    assert card.findings["condition of the Newton matrix"].verdict == "over" and card.condition > 1e15
    assert card.round_off > 0.1 and not card.findings.ok and "Little of a step is left" in str(card)


def test_an_energy_that_is_not_quadratic():
    """A block of H = x^2 / 2 + p^2 / 2 + x^4 / 4: about x = 0 the frequency is 1 rad/s."""
    block = ph.CustomBlock(
        "duffing",
        2,
        lambda x: 0.5 * x @ x + 0.25 * x[0] ** 4,
        lambda x: np.array([x[0] + x[0] ** 3, x[1]]),
        lambda x: np.diag([1.0 + 3.0 * x[0] ** 2, 1.0]),
        J=[[0.0, 1.0], [-1.0, 0.0]],
    )
    d = ph.Diagram("duffing")
    d.add(block)
    card = d.compile().stability_card(0.5)
    assert card.h_omega_max == pytest.approx(0.5, rel=1e-9) and card.index == 0


def test_the_table_and_its_record(bar):
    card = chain(2, bar).stability_card(1e-3)
    lines = str(card).splitlines()
    assert lines[0] == f"chain: {card.states} states, dt = 0.001 s"
    assert lines[1].split() == ["what", "value", "limit", "verdict", "where"]
    assert repr(card) == str(card)
    record = json.loads(json.dumps(card.to_json()))
    assert record["dt"] == 1e-3 and record["findings"][0]["value"] == card.h_omega_max
    assert card.findings.ok and card.findings[:2]["modes"] == card.findings[1]
    with pytest.raises(UnknownNameError, match="'modes'"):
        card.findings["mode"]


def test_what_is_refused(bar):
    system = chain(2, bar)
    for wrong in (0.0, -1.0, np.inf):
        with pytest.raises(DataError, match="stability_card dt"):
            system.stability_card(wrong)
    with pytest.raises(ArgumentTypeError, match="stability_card dt"):
        system.stability_card("long")
    with pytest.raises(ArgumentTypeError, match="stability_card state"):
        system.stability_card(0.1, np.zeros(3))


def test_the_spin_is_told_in_space_too():
    """20 rad/s and 0.02 s: (0.4)^2 / 12 of the length, in the plane and in space."""
    section = ph.Section(axial=2.8e7, shear=1e7, bending=1.4e4, mass=1.2, rotary=6e-4, torsion=1e4)
    for more, spin in (((), 20.0), ((0.0,), (0.0, 0.0, 20.0))):
        d = ph.Diagram("free")
        d.add(ph.Beam("beam", section, (0.0, 0.0, *more), (3.0, 0.0, *more), elements=4, degree=2))
        system = d.compile()
        card = system.stability_card(0.02, system.rigid_motion(spin=spin))
        assert card.spin == pytest.approx(20.0)
        gap = card.findings["expected gap over length, (spin dt)^2 / 12"]
        assert gap.value == pytest.approx(0.16 / 12.0) and gap.verdict == "over"
    solution = ph.simulate(system, 0.02, 0.001)
    unknown = [finding.name for finding in solution.health.findings if finding.verdict == "unknown"]
    assert "linear momentum of free bodies" in unknown and len(unknown) == 4
