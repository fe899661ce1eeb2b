"""Radau IIA: the equations of a step, and a loss that is that of theory, told to the last bit."""

import numpy as np
import pytest
from scipy.linalg import eigh

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, MethodError
from phblocks.solvers import compiled
from phblocks.solvers.coefficients import Collocation
from phblocks.system.constraints import find_constraints


@pytest.fixture(params=[2, 3])
def stages(request) -> int:
    return request.param


@pytest.fixture
def interpreted(monkeypatch):
    monkeypatch.setattr(compiled, "find_spec", lambda _: None)


def kept(w: float, stages: int) -> float:
    """Share of its energy that a mode keeps in a step: |P(i w)|^2, P the subdiagonal Pade approximation of exp."""
    z = 1j * w
    if stages == 2:
        return abs((1 + z / 3) / (1 - 2 * z / 3 + z**2 / 6)) ** 2
    return abs((1 + 2 * z / 5 + z**2 / 20) / (1 - 3 * z / 5 + 3 * z**2 / 20 - z**3 / 60)) ** 2


def test_coefficients_are_those_of_the_tables():
    two = Collocation.radau(2)
    np.testing.assert_allclose(two.c, [1 / 3, 1], rtol=1e-15)
    np.testing.assert_allclose(two.A, [[5 / 12, -1 / 12], [3 / 4, 1 / 4]], rtol=1e-14)
    np.testing.assert_allclose(two.loss, [-3 / 2, 1 / 2], rtol=1e-14)
    three, root = Collocation.radau(3), np.sqrt(6.0)
    np.testing.assert_allclose(three.c, [(4 - root) / 10, (4 + root) / 10, 1], rtol=1e-14)
    np.testing.assert_allclose(three.b, [(16 - root) / 36, (16 + root) / 36, 1 / 9], rtol=1e-13)
    np.testing.assert_allclose(three.A[-1], three.b, rtol=1e-13)
    for c in (two, three):
        np.testing.assert_array_equal(c.end, np.eye(c.c.size)[-1])
        # the loss by the matrix of algebraic stability
        weights = c.b[:, None] * c.A
        lost = np.outer(c.loss @ c.A, c.loss @ c.A)
        np.testing.assert_allclose(lost, weights + weights.T - np.outer(c.b, c.b), atol=1e-14)
    assert Collocation.gauss(2).loss is None and Collocation.gauss(3).loss is None
    assert Collocation.radau(2) is Collocation.radau(2)


@pytest.mark.parametrize("linear", [False, True])
def test_a_step_satisfies_its_equations(scene, stages, linear):
    system = scene.compile().small_motions() if linear else scene.compile()
    stepper, rng, dt = ph.RadauIIA(stages).prepare(system), np.random.default_rng(0), 0.004
    size = np.sqrt(system.E.diagonal())
    x0, theta0 = 0.1 * rng.standard_normal(system.n) / size, 0.1 * rng.standard_normal(system.start.theta.size)
    u = rng.standard_normal((stages, system.n_inputs))
    step = stepper.step(stepper.stage.pack(x0), theta0, dt, u)
    c, z, x1 = Collocation.radau(stages), stepper.stage.unpack(step.z), stepper.stage.unpack(step.x)
    forces = np.stack([system.force(z[i], step.theta_z[i], u[i]) for i in range(stages)])
    spins = np.stack([system.rates @ z[i] + system.input_rates @ u[i] for i in range(stages)])
    scale = abs(dt * forces / size).max()
    np.testing.assert_allclose((system.E @ (z - x0).T).T / size, dt * (c.A @ forces) / size, atol=1e-11 * scale)
    np.testing.assert_allclose(x1, z[-1], rtol=1e-13, atol=1e-13 * abs(x1).max())
    np.testing.assert_allclose(step.theta, theta0 + dt * (c.b @ spins), atol=1e-13)
    # by hand: 1/2 h^2 sum M_ij k_i . E k_j, with E k_i the forces
    weights = c.b[:, None] * c.A
    M = weights + weights.T - np.outer(c.b, c.b)
    rates = np.linalg.solve(system.E.toarray(), forces.T).T
    lost = 0.5 * dt**2 * np.einsum("ij,ia,ja->", M, rates, forces)
    assert system.energy(stepper.stage.unpack(step.damped)) == pytest.approx(lost, rel=1e-9)
    assert lost > 0.0


def discs(*stiffness: float) -> ph.System:
    """Discs of inertia 0.5 kg m^2 in a row, each on a torsion spring to the one before, the first to the ground."""
    d = ph.Diagram("discs")
    bodies = [d.add(ph.RigidBody(f"disc {i}", 1.0, 0.5, (0.0, 0.0))) for i in range(len(stiffness))]
    springs = [d.add(ph.TorsionSpring(f"spring {i}", k)) for i, k in enumerate(stiffness)]
    d.connect(d.ground.rotation, springs[0].first)
    for i, body in enumerate(bodies):
        d.connect(springs[i].second, body.centre.rotation, *[s.first for s in springs[i + 1 : i + 2]])
    return d.compile()


def moving(system: ph.System, values: np.ndarray) -> ph.State:
    return ph.State(values / np.sqrt(np.maximum(system.E.diagonal(), 1e-300)), system.start.theta, system.start.points)


@pytest.mark.parametrize("w", [0.05, 0.5, 5.0, 1e3, 1e6])
def test_the_loss_of_a_mode_is_that_of_theory(stages, w):
    """omega = sqrt(8 / 0.5) = 4 rad/s."""
    system = discs(8.0)
    turning = [name.startswith(("disc 0.W3", "spring")) for name in system.state_names]
    solution = ph.simulate(
        system, 3 * w / 4, w / 4, start=moving(system, np.array(turning, dtype=float)), method=ph.RadauIIA(stages)
    )
    total, share = solution.energy.total, kept(w, stages)
    assert total[0] > 0.9
    np.testing.assert_allclose(total[1:], total[0] * share ** np.arange(1, 4), rtol=1e-9, atol=1e-16)
    np.testing.assert_allclose(solution.energy.numerical_loss, total[0] - total, atol=1e-15)
    if w < 0.1:  # no more than the order says: w^(2 s) over 36 or 3600
        assert solution.energy.numerical_loss[-1] <= 3.001 * total[0] * w ** (2 * stages) / {2: 36, 3: 3600}[stages]
    if w >= 1e3:
        assert total[-1] < 1e-14 * total[0]


def test_an_unresolved_mode_goes_and_a_resolved_one_stays(stages):
    """Two discs, h omega = 0.05 and 1000: in three steps the fast mode is round-off, the slow one as it was."""
    system = discs(1.0, 1e9)
    own = np.flatnonzero((abs(system.J0) @ np.ones(system.n)) > 0.0)
    E, J = (matrix.toarray()[np.ix_(own, own)] for matrix in (system.E, system.J0))
    squares, modes = eigh(J.T @ np.linalg.solve(E, J), E)  # omega^2 in pairs
    slow, fast = np.sqrt(squares[0]), np.sqrt(squares[-1])
    start = np.zeros(system.n)
    start[own] = modes[:, 0] + modes[:, -1]
    dt = 0.05 / slow
    assert fast * dt > 1e3
    state = ph.State(start, system.start.theta, system.start.points)
    solution = ph.simulate(system, 3 * dt, dt, start=state, method=ph.RadauIIA(stages))
    parts = modes.T @ E @ solution.x[:, own].T  # E-orthonormal: energies are half the squares
    slow_energy = 0.5 * (parts[:2] ** 2).sum(axis=0)
    fast_energy = 0.5 * (parts[-2:] ** 2).sum(axis=0)
    assert fast_energy[-1] < 1e-14 * fast_energy[0]
    np.testing.assert_allclose(slow_energy[-1], slow_energy[0] * kept(0.05, stages) ** 3, rtol=1e-10)
    lost = solution.energy.numerical_loss
    np.testing.assert_allclose(lost, solution.energy.total[0] - solution.energy.total, atol=1e-14)
    assert lost[-1] == pytest.approx(0.5, rel=1e-6)


@pytest.mark.parametrize("fast", [True, False])
def test_the_four_bar_balances(four_bar, stages, fast, request):
    """Of the whole and of every block, whoever takes the steps; the loss never falls."""
    if not fast:
        request.getfixturevalue("interpreted")
    solution = ph.simulate(four_bar().compile(), 0.5, 0.02, method=ph.RadauIIA(stages))
    energy, ledger = solution.energy, solution.recording.ledger
    scale = np.abs(energy.gravity).max()
    assert (np.diff(ledger.numerical, axis=0) >= 0.0).all()
    assert energy.numerical_loss[-1] > 1e-5 * scale
    np.testing.assert_allclose(energy.total + energy.numerical_loss, energy.total[0], atol=1e-12 * scale)
    assert solution.max_power_balance_error < 1e-12 * scale
    assert solution.power.worst[1] < 1e-11 * scale
    for row in solution.power.blocks.values():
        gained = row["received"] + row["supplied"] - row["dissipated"] - row["numerical_loss"]
        np.testing.assert_allclose(row["stored"] + row["gravity"], gained, atol=1e-10 * scale)
    assert "numerical loss" in str(solution.power)


def test_it_vanishes_with_the_step(four_bar):
    """A stiff start from rest in the soft four-bar: what is lost falls with the step, and the motions agree."""
    system = four_bar().compile()
    lost = [ph.simulate(system, 0.2, dt, method=ph.RadauIIA(3)).energy.numerical_loss[-1] for dt in (2e-3, 2.5e-4)]
    assert lost[1] < 0.6 * lost[0]


@pytest.mark.parametrize("dt", [2.0, 20.0])
def test_steps_beyond_all_bounds_run_quietly(stages, dt):
    """A cantilever with h omega_max = 1e6 and more: after its waves are gone it is at rest, bent by its weight."""
    bar = ph.Section.rectangle(0.05, 0.05, young=2.1e11, poisson=0.3, density=2710.0, shear_factor=1.0)
    d = ph.Diagram("cantilever", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("beam", bar, (0.0, 0.0), (1.0, 0.0), elements=4, degree=2))
    d.weld(beam.start, d.ground)
    system = d.compile()
    assert abs(np.linalg.eigvals(np.linalg.solve(system.E.toarray(), system.J0.toarray()))).max() * dt > 1e6
    solution = ph.simulate(system, 10 * dt, dt, method=ph.RadauIIA(stages))
    assert solution.status.ok and solution.statistics.halvings == 0
    energy = solution.energy
    np.testing.assert_allclose(energy.total + energy.numerical_loss, energy.total[0], atol=1e-9 * energy.strain[-1])
    assert energy.kinetic[-1] < 1e-12 * energy.strain[-1]
    weight = 2710.0 * 0.05**2 * 9.81
    sag = weight / (8 * 2.1e11 * 0.05**4 / 12) + weight / (2 * 2.1e11 / 2.6 * 0.05**2)
    assert solution.position(beam, 1.0, "strain")[-1, 1] == pytest.approx(-sag, rel=1e-4)


def pendulum() -> ph.System:
    d = ph.Diagram("pendulum", gravity=(0.0, -9.81))
    bar = d.add(ph.RigidBody("bar", 2.0, 0.3, (0.5, 0.0), {"hook": (0.0, 0.0)}))
    d.pin(bar["hook"], d.ground, multiplier=True)
    return d.compile()


def test_constraints_hold_at_the_end_of_each_step(stages):
    """And the force of the joint there is that of a physical pendulum, to order s."""
    system, errors = pendulum(), []
    for dt in (0.02, 0.01):
        solution = ph.simulate(system, 1.0, dt, method=ph.RadauIIA(stages))
        for t in solution.t:
            found = find_constraints(system, solution.at(t))
            assert np.abs(found.rows @ (solution.at(t).x / found.scale)).max() < 1e-12
        angle, spin = solution.angle("bar", (0.0, 0.0)), solution.spin("bar", (0.0, 0.0))
        along, across = (np.stack(pair) for pair in ((np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))))
        faster = -2.0 * 9.81 * 0.5 * np.cos(angle) / (0.3 + 2.0 * 0.5**2)
        needed = 2.0 * 0.5 * (across * faster - along * spin**2) + [[0.0], [2.0 * 9.81]]
        errors.append(np.abs(solution.x[1:, system.algebraic] - needed.T[1:]).max())
    assert errors[0] < {2: 0.08, 3: 2e-3}[stages]
    assert errors[0] / errors[1] == pytest.approx(2.0**stages, rel=0.1)


def test_multipliers_do_not_alternate(stages):
    """From a start that violates the joint: the midpoint rule swings for ever, Radau is over it after a step."""
    system = pendulum()
    x = system.start.x.copy()
    x[np.flatnonzero(system.carries_energy)[0]] = 0.1
    found, forces = find_constraints(system), {}
    assert np.abs(found.rows @ (x / found.scale)).max() > 0.01
    for method in (ph.Midpoint(), ph.RadauIIA(stages)):
        stepper = method.prepare(system)
        state, theta, rows = stepper.stage.pack(x), system.start.theta, []
        for _ in range(12):
            step = stepper.step(state, theta, 0.005, np.zeros((len(stepper.nodes), 0)))
            state, theta = step.x, step.theta
            rows.append(stepper.stage.unpack(step.x)[system.algebraic][0])
        forces[type(method)] = np.abs(np.diff(rows[2:]))
    assert forces[ph.Midpoint].min() > 10.0
    assert forces[ph.RadauIIA].max() < 1.0


def test_with_steps_adapted(four_bar, stages):
    solution = ph.simulate(
        four_bar().compile(), 0.1, 0.01, method=ph.RadauIIA(stages), adaptive=ph.Adaptive(1e-2, atol=1e-3)
    )
    energy = solution.energy
    assert solution.status.ok and energy.numerical_loss[-1] > 0.0
    np.testing.assert_allclose(energy.total + energy.numerical_loss, energy.total[0], atol=1e-10)


def test_energies_that_are_not_quadratic_are_refused_by_name():
    x4 = {"gradient": lambda x: np.array([x[0] ** 3, x[1]]), "hessian": lambda x: np.diag([3 * x[0] ** 2, 1.0])}
    x4 |= {"J": [[0, 1], [-1, 0]], "start": [1, 0]}
    d = ph.Diagram("duffing")
    d.add(ph.CustomBlock("quartic", 2, lambda x: x[0] ** 4 / 4 + x[1] ** 2 / 2, **x4))
    with pytest.raises(MethodError, match=r"RadauIIA for system 'duffing'.*'quartic'.*ph\.DiscreteGradient\(\)"):
        ph.simulate(d.compile(), 1.0, 0.1, method=ph.RadauIIA())


@pytest.mark.parametrize("stages", [1, 4, 0])
def test_numbers_of_stages_out_of_range(stages):
    with pytest.raises(DataError, match="RadauIIA stages"):
        ph.RadauIIA(stages)


@pytest.mark.parametrize("options", [{"stages": 2.0}, {"stages": True}, {"newton": None}])
def test_options_of_the_wrong_kind(options):
    with pytest.raises(ArgumentTypeError, match="RadauIIA"):
        ph.RadauIIA(**options)
