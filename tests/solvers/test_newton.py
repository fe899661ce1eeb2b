"""Newton's method on small equations with known solutions."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.results.recording import Recorder
from phblocks.solvers import compiled
from phblocks.solvers.linear import BandedSolver, linear_solver
from phblocks.solvers.newton import ModifiedNewton, Newton
from phblocks.solvers.stage import StageEquation


class Equations:
    """n equal scalar equations f(z) = 0 in the place of a stage equation."""

    carrying = slice(None)

    def __init__(self, f, df, n: int = 3) -> None:
        self.f, self.df, self.n = f, df, n
        self.evaluations = 0

    def evaluate(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        self.evaluations += 1
        return self.f(z), self.df(z)

    def measure(self, z: np.ndarray) -> float:
        return float(np.linalg.norm(z))

    def round_off(self, z: np.ndarray) -> float:
        return float(1e-16 * np.linalg.norm(z))

    def solver(self) -> BandedSolver:
        return BandedSolver(np.arange(self.n), np.arange(self.n), self.n)


def solve(equations: Equations, guess: float = 1.0, **options) -> tuple[np.ndarray | None, int]:
    start = np.full(equations.n, guess)
    return Newton(**options).solve(equations, equations.solver(), start, float(np.linalg.norm(start)))


def test_a_root_is_found_to_round_off():
    equations = Equations(lambda z: z**2 - 2.0, lambda z: 2.0 * z)
    z, iterations = solve(equations)
    np.testing.assert_allclose(z, np.sqrt(2.0), rtol=4e-16)
    assert iterations <= 6 and equations.evaluations == iterations


def test_a_linear_equation_takes_one_iteration_and_one_to_see_it():
    z, iterations = solve(Equations(lambda z: 3.0 * z - 6.0, lambda z: 3.0 + 0.0 * z))
    np.testing.assert_allclose(z, 2.0, rtol=1e-15)
    assert iterations <= 2


def test_starting_at_the_root_is_seen_at_once():
    z, iterations = solve(Equations(lambda z: z - 1.0, lambda z: 1.0 + 0.0 * z))
    assert iterations == 1 and (z == 1.0).all()


def test_the_guess_is_not_touched():
    equations, guess = Equations(lambda z: z**2 - 2.0, lambda z: 2.0 * z), np.ones(3)
    Newton().solve(equations, equations.solver(), guess, 1.0)
    assert (guess == 1.0).all()


@pytest.mark.parametrize(
    ("f", "df"),
    [
        (lambda z: z**2 + 1.0, lambda z: 2.0 * z),  # no root
        (lambda z: np.cbrt(z), lambda z: 1.0 / (3.0 * np.cbrt(z) ** 2)),  # runs away
        (lambda z: z**2, lambda z: 2.0 * z),  # a double root is approached by halves only
    ],
)
def test_no_convergence_is_never_accepted(f, df):
    assert solve(Equations(f, df))[0] is None


def test_too_few_iterations_are_no_convergence():
    equations = Equations(lambda z: z**3 - 20.0, lambda z: 3.0 * z**2)
    assert solve(equations, max_iterations=3) == (None, 3)
    assert solve(equations, max_iterations=20)[0] is not None


def test_a_singular_matrix_ends_the_iteration():
    assert solve(Equations(lambda z: z - 2.0, lambda z: 0.0 * z)) == (None, 1)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_values_that_are_not_finite_end_the_iteration(bad):
    z, iterations = solve(Equations(lambda z: z + bad, lambda z: 1.0 + 0.0 * z))
    assert z is None and iterations == 1


def test_the_round_off_floor_counts_as_convergence():
    """The residual cannot become smaller than the noise put on it: accepted, with what it is worth."""
    noise = np.random.default_rng(0)

    class Noisy(Equations):
        def round_off(self, z: np.ndarray) -> float:
            return 1e-12

    equations = Noisy(lambda z: z**2 - 2.0 + 1e-12 * noise.standard_normal(3), lambda z: 2.0 * z)
    z, iterations = solve(equations)
    np.testing.assert_allclose(z, np.sqrt(2.0), rtol=1e-11)
    assert iterations < 15


def test_a_looser_tolerance_takes_fewer_iterations():
    def equations() -> Equations:
        return Equations(lambda z: z**3 - 20.0, lambda z: 3.0 * z**2)

    (z, few), (_, many) = solve(equations(), tolerance=1e-4), solve(equations())
    assert few < many
    np.testing.assert_allclose(z, 20.0 ** (1 / 3), rtol=1e-4)


@pytest.mark.parametrize("tolerance", [0.0, 1.0, -1e-9, 2.0, np.nan, np.inf])
def test_tolerances_out_of_range(tolerance):
    with pytest.raises(DataError, match="Newton tolerance"):
        Newton(tolerance=tolerance)


@pytest.mark.parametrize("max_iterations", [0, -1])
def test_no_iterations_at_all(max_iterations):
    with pytest.raises(DataError, match="Newton max_iterations"):
        Newton(max_iterations=max_iterations)


# A factor that is kept


class Counting(Equations):
    """Counts how often a Jacobian is asked for."""

    def __init__(self, f, df, n: int = 3) -> None:
        super().__init__(f, df, n)
        self.residuals = 0

    def residual(self, z: np.ndarray) -> np.ndarray:
        self.residuals += 1
        return self.f(z)


def test_a_kept_factor_leads_to_the_same_root_with_fewer_jacobians():
    equations = Counting(lambda z: z**2 - 2.0, lambda z: 2.0 * z)
    solver = equations.solver()
    z, iterations = ModifiedNewton().solve(equations, solver, np.full(3, 1.4), 2.5)
    np.testing.assert_allclose(z, np.sqrt(2.0), rtol=1e-15)
    assert equations.evaluations == 1 and equations.residuals == iterations - 1
    near, again = ModifiedNewton().solve(equations, solver, np.full(3, 1.41), 2.5, kept=True)
    np.testing.assert_allclose(near, np.sqrt(2.0), rtol=1e-15)
    assert equations.evaluations == 2 and again <= iterations  # the old factor served the first iteration


def test_a_factor_is_made_anew_where_convergence_slows():
    equations = Counting(lambda z: z**3 - 20.0, lambda z: 3.0 * z**2)
    z, iterations = ModifiedNewton(slow=0.1).solve(equations, equations.solver(), np.full(3, 1.5), 3.0)
    np.testing.assert_allclose(z, 20.0 ** (1 / 3), rtol=1e-15)
    assert 2 <= equations.evaluations < iterations


def test_a_wrong_kept_factor_is_thrown_away():
    equations = Counting(lambda z: z**2 - 2.0, lambda z: 2.0 * z)
    solver = equations.solver()
    solver.factorise(np.full(3, 1e-20))
    z, _ = ModifiedNewton().solve(equations, solver, np.full(3, 1.4), 2.5, kept=True)
    np.testing.assert_allclose(z, np.sqrt(2.0), rtol=1e-15)


@pytest.mark.parametrize(
    ("f", "df"),
    [(lambda z: z**2 + 1.0, lambda z: 2.0 * z), (lambda z: z**2, lambda z: 2.0 * z)],
)
def test_a_kept_factor_never_accepts_what_does_not_converge(f, df):
    equations = Counting(f, df)
    assert ModifiedNewton().solve(equations, equations.solver(), np.ones(3), 2.0)[0] is None


@pytest.mark.parametrize("slow", [0.0, 1.0, -0.1, np.nan])
def test_ratios_out_of_range(slow):
    with pytest.raises(DataError, match="ModifiedNewton slow"):
        ModifiedNewton(slow=slow)
    with pytest.raises(ArgumentTypeError, match="ModifiedNewton slow"):
        ModifiedNewton(slow=str(slow))


# With a beam: a failed step is halved, counted and never accepted


def test_steps_that_need_more_iterations_are_halved(four_bar):
    system = four_bar().compile()
    free = ph.simulate(system, t_end=0.4, dt=0.02)
    strict = ph.simulate(system, t_end=0.4, dt=0.02, method=ph.Midpoint(ph.Newton(max_iterations=3)))
    assert free.statistics.halvings == 0 and free.statistics.newton_iterations.max() > 3
    assert strict.status.ok and strict.statistics.halvings > 0
    assert strict.statistics.steps == 20 + strict.statistics.halvings
    assert strict.statistics.newton_iterations.max() <= 3
    assert f"{strict.statistics.halvings} halvings" in str(strict.statistics)
    np.testing.assert_array_equal(strict.t, free.t)
    for solution in (free, strict):
        total = solution.energy.total
        assert np.abs(total - total[0]).max() < 1e-11 and solution.max_power_balance_error < 1e-11
    np.testing.assert_allclose(strict.position("coupler", 0.5), free.position("coupler", 0.5), atol=2e-3)


def test_a_soft_coupler_gets_through_with_its_energy_intact(four_bar):
    """E = 2.1e8 in the coupler and a step that is too long for it: full Newton fails on some steps."""
    rubber = ph.Section.rectangle(width=0.05, height=0.05, young=2.1e8, poisson=0.3, density=2710.0, shear_factor=1.0)
    system = four_bar((10, 6, 6), coupler=rubber).compile()
    full = ph.simulate(system, t_end=2.0, dt=0.04, method=ph.Midpoint(ph.Newton(), predict=False))
    assert full.statistics.halvings > 0
    modified = ph.simulate(system, t_end=2.0, dt=0.04)
    assert modified.statistics.halvings <= full.statistics.halvings
    for solution in (full, modified):
        assert solution.status.ok and solution.t[-1] == 2.0
        total = solution.energy.total
        assert np.abs(total - total[0]).max() < 1e-10 and solution.max_power_balance_error < 1e-11


def test_one_iteration_is_never_enough(four_bar):
    solution = ph.simulate(
        four_bar().compile(), t_end=0.2, dt=0.02, method=ph.Midpoint(ph.Newton(max_iterations=1)), max_halvings=4
    )
    assert solution.status.name == "step failed" and solution.statistics.halvings == 4 and solution.t.tolist() == [0.0]


@pytest.mark.parametrize(
    "options",
    [
        *({"tolerance": value} for value in ("1e-9", None, [1e-9], 1j)),
        *({"max_iterations": value} for value in (1.5, "15", None, True, np.nan)),
    ],
)
def test_options_that_are_no_numbers(options):
    with pytest.raises(ArgumentTypeError, match="Newton"):
        Newton(**options)


@pytest.mark.parametrize("newton", [None, 1, "newton", Newton])
def test_a_method_needs_newton_options(newton):
    with pytest.raises(ArgumentTypeError, match="Midpoint"):
        ph.Midpoint(newton)


def test_a_first_update_along_linear_directions_does_not_pass_for_convergence():
    """A spring of free length 0 shortens a soft bar: the first update is large and linear, the second small.

    Convergence taken from these two alone ends the first step with the balance off by 2e-11 of the energy.
    """
    d = ph.Diagram("collapse")
    soft = ph.Section(axial=3e4, shear=1e4, bending=1.0, mass=0.02, rotary=1e-3)
    bar = d.add(ph.Beam("bar", soft, (0.0, 0.0), (1.0, 0.0), elements=2))
    spring = d.add(ph.Spring("spring", 8.6e4, (0.0, 0.0), (1.0, 0.0), free_length=0.0))
    d.pin(d.ground, bar.start, spring.start)
    d.pin(bar.end, spring.end)
    d.expose(bar.end.translation, "push")
    solution = ph.simulate(d.compile(), 8 * 1.2e-3, 1.2e-3, inputs={"push": (0.0, 1.0)})
    assert solution.energy.total[0] == pytest.approx(4.3e4)
    assert max(solution.power.block_errors.values()) <= 1e-14 * 4.3e4


# What is left of an accepted step, and what a failed one says

RUBBER = ph.Section.rectangle(0.05, 0.05, young=2.1e7, poisson=0.3, density=2710.0, shear_factor=1.0)


@pytest.fixture(params=[True, False], ids=["compiled", "interpreted"])
def path(request, monkeypatch):
    """Both iterations, that of compiled code and that which can be read."""
    if request.param:
        pytest.importorskip("numba")
    else:
        monkeypatch.setattr(compiled, "find_spec", lambda _: None)


class Checked:
    """Solves each accepted midpoint step once more from where it ended: what one iteration more would do."""

    def __init__(self, system: ph.System, monkeypatch: pytest.MonkeyPatch) -> None:
        self.stage, self.updates = StageEquation(system), []
        self.solver = linear_solver(self.stage.rows, self.stage.columns, self.stage.n)
        self.x, self.theta = self.stage.pack(system.start.x), system.start.theta
        add = Recorder.add

        def watched(recorder, steps, at, saved):
            self.updates += [self.update(steps.row(i)) for i in range(len(steps))]
            add(recorder, steps, at, saved)

        monkeypatch.setattr(Recorder, "add", watched)

    def update(self, step) -> float:
        stage, rate = self.stage, 2.0 / step.dt
        stage.begin(rate, 0.5 * step.dt, self.theta, step.u[0], rate * stage.momentum(self.x))
        residual, jacobian = stage.evaluate(step.z[0])
        assert self.solver.factorise(jacobian)
        self.x, self.theta = step.x, step.theta
        return stage.measure(self.solver.solve(residual)) / stage.measure(step.z[0])


@pytest.mark.parametrize("newton", [ModifiedNewton(), Newton()], ids=lambda newton: type(newton).__name__)
@pytest.mark.parametrize("approximation", [None, ph.Approximation(shear=False, extension=False)], ids=["all", "EI"])
def test_no_step_is_accepted_with_more_left_than_is_said(path, four_bar, approximation, newton, monkeypatch):
    """One iteration more would change round-off only, in steps that were halved too."""
    system = four_bar((10, 6, 6), coupler=RUBBER).compile(approximation=approximation)
    checked = Checked(system, monkeypatch)
    run = ph.simulate(system, 1.0, 0.1, method=ph.Midpoint(newton))
    assert run.status.ok and run.statistics.residual.shape == (run.statistics.steps,)
    assert run.statistics.residual.max() <= 1e-8
    assert (np.array(checked.updates) <= 1e-14 + 10.0 * run.statistics.residual).all()


@pytest.mark.parametrize("method", [ph.Midpoint(), ph.Midpoint(Newton()), ph.GaussLegendre(2)], ids=str)
def test_a_failed_step_names_block_and_field(path, four_bar, method):
    """With all results up to there; the state is one of the system's, its block one of the diagram's."""
    run = ph.simulate(four_bar((10, 6, 6), coupler=RUBBER).compile(), 4.0, 0.1, method=method, max_halvings=0)
    status = run.status
    assert not status.ok and status.name == "step failed" and status.time == run.t[-1] > 0.0
    assert status.state in run.system.state_names
    assert status.block in ("crank", "coupler", "rocker") and status.field in ("V1", "V2", "W3", "N1", "N2", "M3")
    assert status.state.startswith(f"{status.block}.{status.field}[")
    assert f"the largest residual was that of {status.field} of {status.block!r}" in status.text
    assert np.isfinite(run.x).all() and run.statistics.steps == len(run.t) - 1


@pytest.mark.parametrize("spin", [1e-6, 1e-8, 1e-9, 1e-10, 1e-12, 1e-16])
@pytest.mark.parametrize("method", [ph.Midpoint(), ph.Midpoint(Newton()), ph.GaussLegendre(2)], ids=str)
def test_weights_that_hardly_move_are_solved(path, spin, method):
    """Three hanging bars that swing by next to nothing under joint forces of a thousand newtons: as a larger swing
    does, to the digits that velocities have beside the round-off of the forces' impulses.
    """
    section = ph.Section.rectangle(0.05, 0.05, young=2.1e11, poisson=0.3, density=2710.0, shear_factor=1.0)
    d = ph.Diagram("hanging", gravity=(0.0, -9.81))
    last = d.ground
    for i in range(3):
        rigid = ph.Approximation(flexible=False)
        bar = d.add(ph.Beam(f"bar {i}", section, (0.0, -8.0 * i), (0.0, -8.0 * i - 8.0), 1, approximation=rigid))
        d.pin(last, bar.start)
        last = bar.end
    system = d.compile()
    turning = [i for i, name in enumerate(system.state_names) if ".W3" in name]

    def swing(spin: float) -> np.ndarray:
        start = system.rigid_motion(spin=spin, about=(0.0, 0.0))
        run = ph.simulate(system, 1.0, 0.02, start=start, method=method, max_halvings=0)
        assert run.status.ok and run.statistics.residual.max() < 1e-11
        return run.x[:, turning]

    larger = swing(1e-4)
    assert np.ptp(larger) > 1e-5
    np.testing.assert_allclose(swing(spin), larger * (spin / 1e-4), rtol=0.0, atol=1e-6 * spin + 1e-14)
