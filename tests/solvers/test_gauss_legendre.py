"""Gauss-Legendre steps: their definition, balance, symmetry and cost."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, MethodError
from phblocks.solvers.coefficients import Collocation
from phblocks.solvers.linear import BandedSolver
from phblocks.solvers.stage import StageEquation

DT = 0.004


@pytest.fixture(params=["full", "small motions"])
def system(request, scene) -> ph.System:
    system = scene.compile()
    return system.small_motions() if request.param == "small motions" else system


@pytest.fixture(params=[2, 3])
def stages(request) -> int:
    return request.param


def take(stepper, system: ph.System, dt: float = DT):
    """A step from a random state, with the inputs it was taken with."""
    rng = np.random.default_rng(0)
    x = 0.1 * rng.standard_normal(system.n) / np.sqrt(system.E.diagonal())
    theta = 0.1 * rng.standard_normal(system.start.theta.size)
    u = rng.standard_normal((len(stepper.nodes), system.n_inputs))
    step = stepper.step(stepper.stage.pack(x), theta, dt, u)
    assert step is not None
    return x, theta, u, step


def test_coefficients_are_those_of_the_tables():
    two, root = Collocation.gauss(2), np.sqrt(3.0)
    np.testing.assert_allclose(two.c, [0.5 - root / 6, 0.5 + root / 6], rtol=1e-15)
    np.testing.assert_allclose(two.A, [[0.25, 0.25 - root / 6], [0.25 + root / 6, 0.25]], rtol=1e-13)
    np.testing.assert_allclose(two.end, [-root, root], rtol=1e-13)
    three = Collocation.gauss(3)
    np.testing.assert_allclose(three.b, [5 / 18, 8 / 18, 5 / 18], rtol=1e-14)
    np.testing.assert_allclose(three.end, [5 / 3, -4 / 3, 5 / 3], rtol=1e-13)
    for q in range(3):
        np.testing.assert_allclose(three.A @ three.c**q, three.c ** (q + 1) / (q + 1), rtol=1e-13)
        assert three.extrapolation @ three.c**q == pytest.approx(1.0, rel=1e-13)


def test_a_step_satisfies_its_equations(system, stages):
    stepper = ph.GaussLegendre(stages).prepare(system)
    x0, theta0, u, step = take(stepper, system)
    c = Collocation.gauss(stages)
    z, x1 = stepper.stage.unpack(step.z), stepper.stage.unpack(step.x)
    size = 1.0 / np.sqrt(system.E.diagonal())
    forces = np.stack([system.force(z[i], step.theta_z[i], u[i]) for i in range(stages)])
    spins = np.stack([system.rates @ z[i] + system.input_rates @ u[i] for i in range(stages)])
    scale = abs(size * DT * forces).max()
    np.testing.assert_allclose(size * (system.E @ (z - x0).T).T, size * DT * (c.A @ forces), atol=1e-11 * scale)
    np.testing.assert_allclose(size * (system.E @ (x1 - x0)), size * DT * (c.b @ forces), atol=1e-11 * scale)
    np.testing.assert_allclose(step.theta_z, theta0 + DT * (c.A @ spins), atol=1e-13)
    np.testing.assert_allclose(step.theta, theta0 + DT * (c.b @ spins), atol=1e-13)
    np.testing.assert_allclose(stepper.nodes, c.c)
    assert step.dt == DT
    np.testing.assert_array_equal(step.u, u)


def test_energy_changes_by_what_is_supplied(system, stages):
    stepper = ph.GaussLegendre(stages).prepare(system)
    x0, _, u, step = take(stepper, system)
    z = stepper.stage.unpack(step.z)
    powers = [
        u[i] @ (system.G(step.theta_z[i]).T @ z[i]) + z[i] @ system.gravity_force(step.theta_z[i])
        for i in range(stages)
    ]
    change = system.energy(stepper.stage.unpack(step.x)) - system.energy(x0)
    assert change == pytest.approx(DT * np.dot(stepper.weights, powers), abs=2e-13 * max(1.0, system.energy(x0)))


def test_a_step_back_leads_to_where_it_began(system, stages):
    stepper = ph.GaussLegendre(stages).prepare(system)
    x0, theta0, u, there = take(stepper, system)
    back = stepper.step(there.x, there.theta, -DT, u[::-1])
    assert back is not None
    energy = np.sqrt(2.0 * system.energy(x0))
    np.testing.assert_allclose(back.x, stepper.stage.pack(x0), atol=1e-11 * energy)
    np.testing.assert_allclose(back.theta, theta0, atol=1e-12)


@pytest.mark.parametrize("newton", [ph.Newton(max_iterations=30), ph.ModifiedNewton(slow=0.01)])
def test_the_iteration_does_not_change_the_result(scenes, stages, newton):
    system = scenes["four-bar"].compile()
    runs = [ph.simulate(system, 0.2, 0.02, method=ph.GaussLegendre(stages, n)) for n in (ph.ModifiedNewton(), newton)]
    size = np.sqrt(system.E.diagonal())
    np.testing.assert_allclose(size * runs[0].x, size * runs[1].x, atol=1e-11 * abs(size * runs[0].x).max())


def test_a_step_without_convergence_is_none_and_halved(scenes, stages):
    system = scenes["four-bar"].compile()
    method = ph.GaussLegendre(stages, ph.ModifiedNewton(max_iterations=5))
    stepper = method.prepare(system)
    x = stepper.stage.pack(system.rigid_motion(spin=5.0).x)
    assert stepper.step(x, system.start.theta, 0.1, np.zeros((stages, 0))) is None
    solution = ph.simulate(system, 0.2, 0.02, method=method, max_halvings=20, limits=ph.Limits(halvings=1.0))
    assert solution.status.ok and solution.statistics.halvings > 0
    assert np.abs(solution.energy.total - solution.energy.total[0]).max() < 1e-10


@pytest.fixture
def factorisations(monkeypatch) -> list[tuple[str, int]]:
    """Kind of the entries and half-bandwidth of every factorisation."""
    found: list[tuple[str, int]] = []
    true_factorise = BandedSolver.factorise

    def factorise(self, data):
        found.append((np.asarray(data).dtype.kind, self.width))
        return true_factorise(self, data)

    monkeypatch.setattr(BandedSolver, "factorise", factorise)
    return found


def test_one_complex_factor_for_two_stages_and_the_band_of_one(scenes, factorisations, without_numba, stages):
    system = scenes["free"].compile().small_motions()
    ph.simulate(system, 1.0, 0.01, method=ph.GaussLegendre(stages))
    stage = StageEquation(system)
    width = abs(stage.rows - stage.columns).max()
    assert sorted(factorisations) == ([("c", width)] if stages == 2 else [("c", width), ("f", width)])


def test_a_linear_oscillator_turns_by_the_pade_angle(stages):
    """Phase of R(i w dt), R the diagonal Pade approximation of the exponential; amplitude unchanged."""
    d = ph.Diagram()
    disc, spring = d.add(ph.RigidBody("disc", 1.0, 0.5, (0.0, 0.0))), d.add(ph.TorsionSpring("spring", 8.0))
    d.connect(disc.centre.rotation, spring.second)
    d.connect(spring.first, d.ground.rotation)
    system = d.compile()
    frequency, dt = 4.0, 0.3
    start = ph.State(np.where(np.arange(system.n) == system.n - 1, 1.0, 0.0), system.start.theta, system.start.points)
    solution = ph.simulate(system, 50 * dt, dt, start=start, method=ph.GaussLegendre(stages))
    w = 1j * frequency * dt
    top = 1 + w / 2 + w**2 / 12 if stages == 2 else 1 + w / 2 + w**2 / 10 + w**3 / 120
    phase = 50 * np.angle(top / np.conj(top))
    moving = np.flatnonzero(abs(solution.x).max(axis=0) > 1e-9)
    other = moving[0] if moving[1] == system.n - 1 else moving[1]
    assert solution.x[-1, -1] == pytest.approx(np.cos(phase), abs=1e-11)
    amplitude = np.sqrt(system.E[system.n - 1, system.n - 1] / system.E[other, other])
    assert abs(solution.x[-1, other]) == pytest.approx(amplitude * abs(np.sin(phase)), rel=1e-9)


def test_elongation_and_span_of_a_spring_change_alike(stages):
    """The same energy from the force of the spring and from the distance of its ends, over 500 steps."""
    d = ph.Diagram("elastic pendulum", gravity=(0.0, -9.81))
    mass = d.add(ph.Mass("mass", 1.0, (1.0, 0.0)))
    spring = d.add(ph.Spring("spring", 40.0, (0.0, 0.0), (1.0, 0.0), free_length=0.9))
    d.pin(spring.start, d.ground)
    d.pin(spring.end, mass.centre)
    solution = ph.simulate(d.compile(), 10.0, 0.02, method=ph.GaussLegendre(stages))
    system = solution.system
    spans = solution.x[:, system.lines.spans[0]]
    np.testing.assert_allclose(np.hypot(*spans.T), system.lines.lengths(solution.x.T)[0], atol=1e-12)
    assert np.abs(solution.energy.total - solution.energy.total[0]).max() < 1e-12 * 40.0
    assert solution.statistics.halvings == 0


@pytest.fixture(scope="module")
def driven() -> ph.System:
    """A disc behind a gear with a multiplier, a spring and a damper: states without energy."""
    d = ph.Diagram("discs")
    one, two = (d.add(ph.RigidBody(name, 1.0, inertia, (0.0, 0.0))) for name, inertia in (("one", 2.0), ("two", 1.0)))
    gear = d.add(ph.Transformer("gear", -2.0, multiplier=True))
    spring, damper = d.add(ph.TorsionSpring("spring", 8.0)), d.add(ph.TorsionDamper("damper", 1.5))
    d.connect(d.ground.rotation, spring.first, damper.first)
    d.connect(one.centre.rotation, gear.first, spring.second, damper.second)
    d.connect(gear.second, two.centre.rotation)
    d.expose(one.centre.rotation, "drive")
    return d.compile()


def test_states_without_energy(driven, stages):
    """6 w' = u - M - 1.5 w, M' = 8 w with u = sin t: order 2 s in the states with energy, s or more in the others."""

    def run(dt):
        return ph.simulate(driven, 2.0, dt, inputs={"drive": np.sin}, method=ph.GaussLegendre(stages)).x[-1]

    exact, steps = run(0.002), np.array([0.25, 0.125, 0.0625])
    errors = np.array([np.abs(run(dt) - exact) for dt in steps])
    rated = errors[:, ~driven.algebraic].max(axis=1)
    others = errors[:, driven.algebraic].max(axis=1)
    assert driven.algebraic.any() and driven.constraint_names
    assert np.polyfit(np.log(steps), np.log(rated), 1)[0] == pytest.approx(2 * stages, abs=0.15)
    assert np.polyfit(np.log(steps), np.log(others), 1)[0] >= stages - 0.15


def test_energies_that_are_not_quadratic_are_refused_by_name():
    block = ph.CustomBlock(
        "cubic",
        2,
        lambda x: x @ x / 2 + x[0] ** 4,
        lambda x: np.array([x[0] + 4 * x[0] ** 3, x[1]]),
        lambda x: np.diag([1 + 12 * x[0] ** 2, 1]),
        J=[[0, 1], [-1, 0]],
        start=[1, 0],
    )
    d = ph.Diagram("duffing")
    d.add(block)
    with pytest.raises(MethodError, match=r"GaussLegendre for system 'duffing'.*'cubic'.*ph\.DiscreteGradient\(\)"):
        ph.simulate(d.compile(), 1.0, 0.1, method=ph.GaussLegendre())


@pytest.mark.parametrize("stages", [1, 4, 0, -2])
def test_numbers_of_stages_out_of_range(stages):
    with pytest.raises(DataError, match="GaussLegendre stages"):
        ph.GaussLegendre(stages)


@pytest.mark.parametrize("options", [{"stages": 2.0}, {"stages": "2"}, {"stages": True}, {"newton": None}])
def test_options_of_the_wrong_kind(options):
    with pytest.raises(ArgumentTypeError, match="GaussLegendre"):
        ph.GaussLegendre(**options)
