"""The implicit midpoint rule."""

from __future__ import annotations

from dataclasses import dataclass, field

from phblocks.solvers.coefficients import Collocation
from phblocks.solvers.compiled import CompiledStepper, compiled_stepper
from phblocks.solvers.linear import LinearSolver, linear_solver
from phblocks.solvers.linear_stepper import LinearStepper
from phblocks.solvers.newton import ModifiedNewton, Newton
from phblocks.solvers.options import require_flag, require_newton, require_quadratic
from phblocks.solvers.past import Past
from phblocks.solvers.stage import StageEquation
from phblocks.solvers.step import Step
from phblocks.system import System
from phblocks.triplets import Floats


@dataclass(frozen=True)
class Midpoint:
    """Implicit midpoint rule: second order, keeps the balance of quadratic energies exactly.

    With ``z = (x_n + x_{n+1}) / 2`` it solves ``2/dt E (z - x_n) = (J(z, theta_mid) - R) z + ...`` and sets
    ``x_{n+1} = 2 z - x_n``, so that ``H_{n+1} - H_n = dt (y^T u - z^T R z)`` whatever the step. Orientations,
    ``theta_mid = theta_n + dt/2 theta'(z)``, are eliminated from the unknowns. States without energy (multipliers,
    the states of stateless parts) have no rate: a step knows their value in its middle, and what is reported at its
    end is the mean with the next one.

    Conserved: the balance of energies that are quadratic in the states, whatever the step; elongation and length of
    springs change alike. Momenta to second order only. Cost of a step: one evaluation of the Jacobian, one banded
    factorisation, and 3 to 9 residuals with their back-substitutions; with ``newton=ph.Newton()`` 3 to 5 of each. One
    back-substitution if the system is linear.

    Parameters
    ----------
    newton : Newton, optional
        The iteration: ``ModifiedNewton()`` by default, which is faster; the result is the same to round-off.
    predict : bool, optional
        Start the iteration from the extrapolation of the last two steps; otherwise from the last state.
    allow_energy_error : bool, optional
        Also integrate systems whose energy is not quadratic, where the balance holds to second order only.

    Raises
    ------
    ArgumentTypeError
        If the options are not those of Newton's method.

    Notes
    -----
    Brugnoli, Kinon, Sanfedino, Betsch, section 3.3; E. Hairer, C. Lubich, G. Wanner, Geometric Numerical
    Integration, 2nd ed., IV.2, doi:10.1007/3-540-30666-8.
    """

    newton: Newton = field(default_factory=ModifiedNewton)
    predict: bool = True
    allow_energy_error: bool = False

    def __post_init__(self) -> None:
        """Check the options."""
        require_newton("Midpoint", self.newton)
        require_flag("Midpoint predict", self.predict)

    #: Order of convergence on smooth solutions.
    order = 2

    def prepare(self, system: System) -> LinearStepper | MidpointStepper | CompiledStepper:
        """Do once what does not change during a run.

        Parameters
        ----------
        system : System
            The system to integrate.

        Returns
        -------
        LinearStepper, MidpointStepper or CompiledStepper
            Ready for steps; the last where numba is installed.

        Raises
        ------
        MethodError
            If the energy is not quadratic and ``allow_energy_error`` not set.
        """
        if system.linear:
            return LinearStepper(system, Collocation.gauss(1))
        if not self.allow_energy_error:
            require_quadratic("Midpoint", system, ", or accept the drift with ph.Midpoint(allow_energy_error=True)")
        fast = compiled_stepper(system, Collocation.gauss(1), self.newton, self.predict)
        return MidpointStepper(system, self.newton, self.predict) if fast is None else fast


class MidpointStepper:
    """Takes midpoint steps of one system.

    Parameters
    ----------
    system : System
        The system to integrate.
    newton : Newton
        The iteration.
    predict : bool, optional
        Extrapolate the last two steps for a first guess.
    discrete : bool, optional
        Energies that are not quadratic act by their discrete gradients.

    Attributes
    ----------
    stage : StageEquation
        Changes states to the unknowns that ``step`` works with and back.
    solver : LinearSolver
        Holds the last factor of the Newton matrix.
    """

    #: Where in a step the inputs are evaluated, as fractions of it, and the weights of the stages.
    nodes = (0.5,)
    weights = (1.0,)

    def __init__(self, system: System, newton: Newton, predict: bool = False, discrete: bool = False) -> None:
        self.stage = StageEquation.of(system)
        self._predict, self._past = predict, Past()
        self._newton, self._discrete = newton, discrete
        self.solver: LinearSolver = linear_solver(self.stage.rows, self.stage.columns, self.stage.n)
        self._factored_for: float | None = None

    def step(self, x: Floats, theta: Floats, dt: float, u: Floats, guess: Floats | None = None) -> Step | None:
        """Take one step.

        Parameters
        ----------
        x : numpy.ndarray
            Unknowns at the start of the step, shape (n,), scaled and reordered.
        theta : numpy.ndarray
            Rotation states at the start, shape (n_theta,), rad.
        dt : float
            Step, s.
        u : numpy.ndarray
            Inputs at the nodes, shape (1, n_inputs).
        guess : numpy.ndarray, optional
            First guess of the stage, shape (1, n); by default what the past predicts, or x.

        Returns
        -------
        Step or None
            ``None`` if Newton's method did not converge.
        """
        stage = self.stage
        before = x if self._discrete else None
        stage.begin(2.0 / dt, 0.5 * dt, theta, u[0], (2.0 / dt) * stage.momentum(x), before)
        z, iterations = self._solve(x, dt, guess)
        if z is None:
            return None
        turn = dt * stage.spin(z, u[0])
        end = 2.0 * z - x
        end[stage.algebraic] = z[stage.algebraic]
        stage.settle(end)
        step = Step(end, theta + turn, z[None], (theta + 0.5 * turn)[None], u, dt, iterations, residual=stage.left)
        self._past.add(step)
        return step

    def _solve(self, x: Floats, dt: float, guess: Floats | None) -> tuple[Floats | None, int]:
        """Newton's method from the first of the guesses that leads to convergence."""
        predicted = self._past.middle(x, dt) if self._predict else None
        guesses = [x if guess is None else guess[0]] if predicted is None or guess is not None else [predicted, x]
        count, size = 0, self.stage.measure(x)
        for start in guesses:
            z, iterations = self._newton.solve(self.stage, self.solver, start, size, self._factored_for == dt)
            self._factored_for, count = None if z is None else dt, count + iterations
            if z is not None:
                break
        return z, count
