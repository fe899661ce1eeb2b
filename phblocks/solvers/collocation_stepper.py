"""Takes the steps of collocation methods, one after the other."""

from __future__ import annotations

import numpy as np

from phblocks.solvers.coefficients import Collocation
from phblocks.solvers.collocation import CollocationEquation, ModeSolver
from phblocks.solvers.compiled import CompiledStepper, compiled_stepper
from phblocks.solvers.linear_stepper import LinearStepper
from phblocks.solvers.newton import Newton
from phblocks.solvers.step import Step
from phblocks.system import System
from phblocks.triplets import Floats


def stepper_of(
    system: System, collocation: Collocation, newton: Newton
) -> LinearStepper | CollocationStepper | CompiledStepper:
    """Make a stepper.

    Parameters
    ----------
    system : System
        The system to integrate.
    collocation : Collocation
        Coefficients of the method.
    newton : Newton
        The iteration.

    Returns
    -------
    LinearStepper, CollocationStepper or CompiledStepper
        Ready for steps; the last where numba is installed.
    """
    if system.linear:
        return LinearStepper(system, collocation)
    fast = compiled_stepper(system, collocation, newton)
    return CollocationStepper(system, collocation, newton) if fast is None else fast


class CollocationStepper:
    """Takes steps of one system.

    Parameters
    ----------
    system : System
        The system to integrate.
    collocation : Collocation
        Coefficients of the method.
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

    def __init__(self, system: System, collocation: Collocation, newton: Newton) -> None:
        self.stage = CollocationEquation.of(system, collocation)
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
        stage.begin_step(x, theta, dt, u)
        guess, size = np.repeat(x[:, None], stages, axis=1), np.sqrt(stages) * stage.measure(x)
        z, iterations = self._newton.solve(stage, self.solver, guess, size, self._factored_for == dt)
        self._factored_for = None if z is None else dt
        if z is None:
            return None
        end = x + (z - x[:, None]) @ self._end
        end[stage.algebraic] = z[stage.algebraic] @ self._extrapolation
        rates = np.stack([stage.spin(z[:, i], u[i]) for i in range(stages)])
        turned = theta + dt * (self._collocation.A @ rates)
        theta_end, at_stages = theta + dt * (self._collocation.b @ rates), np.ascontiguousarray(z.T)
        lost = stage.lost(x, end[None], at_stages[None])
        damped = None if lost is None else lost[0]
        return Step(end, theta_end, at_stages, turned, u, dt, iterations, damped=damped, residual=stage.left)
