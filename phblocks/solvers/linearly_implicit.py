"""The linearly implicit midpoint rule: one linear solve a step, energy kept."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.solvers.coefficients import Collocation
from phblocks.solvers.linear_stepper import LinearStepper
from phblocks.solvers.midpoint import MidpointStepper
from phblocks.solvers.newton import ModifiedNewton, Newton
from phblocks.solvers.options import require_newton, require_quadratic
from phblocks.solvers.stage import StageEquation
from phblocks.solvers.step import Step
from phblocks.system import System
from phblocks.triplets import Floats


@dataclass(frozen=True)
class LinearlyImplicit:
    """Midpoint rule with the structure taken at an extrapolated state: second order, one linear solve a step.

    It solves ``2/dt E (z - x_n) = (J(x*, theta*) - R) z + gravity(theta*) + G(theta*) u`` for the mean z. x* is
    extrapolated from means of steps before, ``3/2 z_{n-1} - 1/2 z_{n-3}`` for equal steps, which does not amplify what
    alternates from step to step; extrapolated states do, and the run is lost. ``theta* = theta_n + dt/2 theta'(x*)``.
    ``J(x*, theta*)`` is as skew as any, gravity and positions take the same theta*: the balance of energy is exact.
    The first three steps of a run are steps of the midpoint rule.

    Conserved: the balance of energies that are quadratic in the states, whatever the step. Not conserved, other than
    by the midpoint rule: that elongation and length of springs change alike; they separate to second order. Cost of
    a step: one evaluation of the structure, one banded factorisation, two back-substitutions (the second takes the
    round-off off), no iteration. How far x* was from z, ``statistics.lag``, tells whether the step was short enough:
    energy does not. Where stiff waves are not resolved, steps must be shorter than those of the midpoint rule, or be
    corrected.

    Parameters
    ----------
    corrections : int, optional
        How often the solve is repeated with x* = z. Each result keeps the energy; they converge to the midpoint rule.
    newton : Newton, optional
        The iteration of the first steps.

    Raises
    ------
    DataError
        If the number of corrections is negative.
    ArgumentTypeError
        If an option is of the wrong kind.

    Notes
    -----
    A. Brugnoli, D. Matignon, J. Morlier, A linearly-implicit energy-momentum preserving scheme for geometrically
    nonlinear mechanics, 2025, arXiv:2503.04695.
    """

    corrections: int = 0
    newton: Newton = field(default_factory=ModifiedNewton)

    #: Order of convergence on smooth solutions.
    order = 2

    def __post_init__(self) -> None:
        """Check the options."""
        count, where = self.corrections, "LinearlyImplicit corrections"
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)):
            raise ArgumentTypeError(where, expected="an integer", got=repr(count), fix="Use 0 or 1.")
        if count < 0:
            raise DataError(where, expected="an integer >= 0", got=repr(count), fix="Use 0 or 1.")
        require_newton("LinearlyImplicit", self.newton)

    def prepare(self, system: System) -> LinearStepper | LinearlyImplicitStepper:
        """Do once what does not change during a run.

        Parameters
        ----------
        system : System
            The system to integrate.

        Returns
        -------
        LinearStepper or LinearlyImplicitStepper
            Ready for steps.

        Raises
        ------
        MethodError
            If the energy is not quadratic.
        """
        require_quadratic("LinearlyImplicit", system)
        if system.linear:
            return LinearStepper(system, Collocation.gauss(1))
        return LinearlyImplicitStepper(system, self.newton, int(self.corrections))


class FrozenEquation(StageEquation):
    """The right-hand side with its structure taken at a given state: affine, with a skew J.

    Parameters
    ----------
    system : System
        The system to integrate.
    """

    @cached_property
    def _skew_part(self) -> sp.csr_array:
        return self._skew.csr(self._cubic.shape)

    def freeze(self, at: Floats, theta: Floats, u: Floats) -> tuple[Floats, Floats]:
        """Evaluate it.

        Parameters
        ----------
        at : numpy.ndarray
            Unknowns that fix the structure, shape (n,).
        theta : numpy.ndarray
            Rotation states that do, shape (n_theta,), rad.
        u : numpy.ndarray
            Inputs, shape (n_inputs,).

        Returns
        -------
        structure : numpy.ndarray
            ``J - R``, entries on the pattern.
        known : numpy.ndarray
            Gravity and inputs, shape (n,).
        """
        features = self._features(at, self._alpha_reference + self._alpha_rows @ theta)[0]
        known = (self._kappa_gravity + self._kappa_input @ u) * features[self._feature]
        structure = self._rest + self._skew_part @ at + self._modulation_parts[0] @ features
        return structure, np.asarray(self._inputs @ u + self._collect @ known)


class LinearlyImplicitStepper(MidpointStepper):
    """Takes linearly implicit steps of one system, and midpoint steps where there is no past.

    Parameters
    ----------
    system : System
        The system to integrate.
    newton : Newton
        The iteration of the first steps.
    corrections : int
        How often the solve is repeated.
    """

    def __init__(self, system: System, newton: Newton, corrections: int) -> None:
        super().__init__(system, newton)
        self._solves = 1 + corrections
        self.stage: FrozenEquation = FrozenEquation.of(system)

    def step(self, x: Floats, theta: Floats, dt: float, u: Floats, guess: Floats | None = None) -> Step | None:
        """Take one step; see ``MidpointStepper``. A guess takes the place of the extrapolation."""
        z = self._past.middle(x, dt, back=2) if guess is None else guess[0]
        if z is None:
            return super().step(x, theta, dt, u)
        stage, momentum, self._factored_for = self.stage, (2.0 / dt) * self.stage.momentum(x), None
        for _ in range(self._solves):
            at, turned = z, theta + 0.5 * dt * stage.spin(z, u[0])
            structure, known = stage.freeze(at, turned, u[0])
            matrix = (2.0 / dt) * stage.mass - structure
            if not self.solver.factorise(matrix):
                return None
            z = x
            for _ in range(2):  # the second time takes the round-off off
                z = z - self.solver.solve(stage.apply(matrix, z) - known - momentum)
        if not np.isfinite(z).all():
            return None
        end = 2.0 * z - x
        end[stage.algebraic] = z[stage.algebraic]
        size = float(np.linalg.norm(z[stage.carrying]))
        lag = float(np.linalg.norm((z - at)[stage.carrying])) / size if size else 0.0
        final = theta + dt * stage.spin(z, u[0])
        step = Step(end, final, z[None], turned[None], u, dt, self._solves, frozen=at[None], lag=lag)
        self._past.add(step)
        return step
