"""Gauss-Legendre collocation with two or three stages."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.solvers.collocation import CollocationEquation, ModeSolver
from phblocks.solvers.compiled import CompiledStepper, compiled_stepper
from phblocks.solvers.newton import ModifiedNewton, Newton
from phblocks.solvers.options import require_newton, require_quadratic
from phblocks.solvers.step import Step
from phblocks.system import System
from phblocks.triplets import Floats


@dataclass(frozen=True)
class GaussLegendre:
    """Gauss-Legendre collocation: order 4 with two stages, 6 with three.

    With the coefficients A, b of the method it solves ``E (z_i - x_n) = dt sum_j A_ij f(z_j, theta_j)`` for all
    stages together, orientations eliminated, and sets ``x_{n+1} = x_n + sum_j d_j (z_j - x_n)`` with ``d = b^T A^-1``.

    Conserved: the balance of energies that are quadratic in the states, whatever the step; elongation and length of
    springs change alike. Cost of a step: a complex banded factorisation for each pair of stages and a real one for
    the odd stage, all of the band of the midpoint rule, and 6 to 11 residuals of all stages with their
    back-substitutions; three to four times a midpoint step. If the system is linear, back-substitutions only.
    With numba installed (``pip install "phblocks[fast]"``) steps run in compiled code: the same results to round-off.

    States without energy (multipliers, the states of stateless parts) have no rate: their value at the end of a step
    is that of the polynomial through the stages, of order ``stages`` at most. It does not act back on the run.

    Parameters
    ----------
    stages : int, optional
        2 or 3.
    newton : Newton, optional
        The iteration: with one linearisation for all stages, so that convergence is linear with ``Newton`` too.

    Raises
    ------
    DataError
        If the number of stages is another one.
    ArgumentTypeError
        If an option is of the wrong kind.

    Notes
    -----
    E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., II.1.3 and IV.2,
    doi:10.1007/3-540-30666-8.
    """

    stages: int = 2
    newton: Newton = field(default_factory=ModifiedNewton)

    def __post_init__(self) -> None:
        """Check the options."""
        if isinstance(self.stages, bool) or not isinstance(self.stages, (int, np.integer)):
            raise ArgumentTypeError("GaussLegendre stages", expected="2 or 3", got=repr(self.stages), fix="Use 2.")
        if self.stages not in (2, 3):
            raise DataError(
                "GaussLegendre stages", expected="2 or 3", got=repr(self.stages), fix="One stage is ph.Midpoint()."
            )
        require_newton("GaussLegendre", self.newton)

    @property
    def order(self) -> int:
        """Order of convergence on smooth solutions."""
        return 2 * int(self.stages)

    def prepare(self, system: System) -> GaussLegendreStepper | CompiledStepper:
        """Do once what does not change during a run.

        Parameters
        ----------
        system : System
            The system to integrate.

        Returns
        -------
        GaussLegendreStepper or CompiledStepper
            Ready for steps; the second where numba is installed.

        Raises
        ------
        MethodError
            If the energy is not quadratic.
        """
        require_quadratic("GaussLegendre", system)
        fast = compiled_stepper(system, int(self.stages), self.newton)
        return GaussLegendreStepper(system, int(self.stages), self.newton) if fast is None else fast


class GaussLegendreStepper:
    """Takes steps of one system.

    Parameters
    ----------
    system : System
        The system to integrate.
    stages : int
        Of the method.
    newton : Newton
        The iteration.

    Attributes
    ----------
    stage : CollocationEquation
        Changes states to the unknowns that ``step`` works with and back.
    solver : ModeSolver
        Holds the last factors.
    nodes, weights : tuple of float
        Where in a step the inputs are evaluated, as fractions of it, and the weights of the stages.
    """

    def __init__(self, system: System, stages: int, newton: Newton) -> None:
        self.stage = CollocationEquation.of(system, stages)
        collocation = self.stage.collocation
        self.solver = ModeSolver(self.stage.rows, self.stage.columns, self.stage.n, self.stage.modes)
        self.nodes, self.weights = (tuple(map(float, v)) for v in (collocation.c, collocation.b))
        self._newton, self._collocation = newton, collocation
        self._end, self._extrapolation = collocation.end, collocation.extrapolation
        self._factored_for: float | None = None

    def step(self, x: Floats, theta: Floats, dt: float, u: Floats) -> Step | None:
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
            Inputs at the nodes, shape (stages, n_inputs).

        Returns
        -------
        Step or None
            ``None`` if Newton's method did not converge.
        """
        stage, stages = self.stage, len(self.weights)
        kept = self._factored_for == dt
        if stage.constant:
            z, iterations = self._solve_linear(x, dt, u, kept)
        else:
            stage.begin_step(x, theta, dt, u)
            guess, size = np.repeat(x[:, None], stages, axis=1), np.sqrt(stages) * stage.measure(x)
            z, iterations = self._newton.solve(stage, self.solver, guess, size, kept)
        self._factored_for = None if z is None else dt
        if z is None:
            return None
        end = x + (z - x[:, None]) @ self._end
        end[stage.algebraic] = z[stage.algebraic] @ self._extrapolation
        rates = np.stack([stage.spin(z[:, i], u[i]) for i in range(stages)])
        turned = theta + dt * (self._collocation.A @ rates)
        theta_end, at_stages = theta + dt * (self._collocation.b @ rates), np.ascontiguousarray(z.T)
        return Step(end, theta_end, at_stages, turned, u, dt, iterations, residual=stage.left)

    def _solve_linear(self, x: Floats, dt: float, u: Floats, kept: bool) -> tuple[Floats | None, int]:
        """One back-substitution with factors that are kept as long as the step stays the same."""
        if not kept:
            matrices = np.stack([self.stage.matrix(1.0 / (dt * value)) for value in self.stage.modes.values])
            if not self.solver.factorise(matrices):
                return None, 0
        z = x[:, None] + self.solver.solve(self.stage.force(x, u.T))
        return (z, 0) if np.isfinite(z).all() else (None, 0)
