"""Newton's method on a stage equation, with a stopping test in the energy norm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.solvers.linear import LinearSolver
from phblocks.solvers.stage import StageEquation
from phblocks.triplets import Floats

#: States with energy that are smaller than this, relative to the forces of joints, are round-off.
HELD = 1e-12

#: An update of this relative size may be followed by one of its square times this.
CURVATURE = 10.0


@dataclass(frozen=True)
class Newton:
    """Options of Newton's method.

    The unknowns are scaled by the square root of the energy they carry, so one relative tolerance suits forces of
    1e8 N and velocities of 1e-6 m/s alike.

    Parameters
    ----------
    tolerance : float, optional
        Size of the error that the next iteration would still correct, relative to the state.
    max_iterations : int, optional
        A step that needs more has failed.

    Raises
    ------
    DataError
        If a value is out of its range.
    ArgumentTypeError
        If a value is not a number of the right kind.
    """

    tolerance: float = 1e-15
    max_iterations: int = 15

    def __post_init__(self) -> None:
        """Check the values."""
        tolerance, limit = self.tolerance, self.max_iterations
        if isinstance(tolerance, bool) or not isinstance(tolerance, (int, float, np.floating)):
            raise ArgumentTypeError("Newton tolerance", expected="a number", got=repr(tolerance), fix="Use 1e-15.")
        if not 0.0 < tolerance < 1.0:
            raise DataError("Newton tolerance", expected="a number in (0, 1)", got=repr(tolerance), fix="Use 1e-15.")
        if isinstance(limit, bool) or not isinstance(limit, (int, np.integer)):
            raise ArgumentTypeError("Newton max_iterations", expected="an integer", got=repr(limit), fix="Use 15.")
        if limit < 1:
            raise DataError("Newton max_iterations", expected="at least 1", got=repr(limit), fix="Use 15.")

    def solve(
        self, stage: StageEquation, solver: LinearSolver, guess: Floats, size: float
    ) -> tuple[Floats | None, int]:
        """Solve a stage equation that has begun.

        Parameters
        ----------
        stage : StageEquation
            With its data fixed by ``begin``.
        solver : LinearSolver
            For its pattern.
        guess : numpy.ndarray
            Shape (n,), in scaled, reordered unknowns.
        size : float
            Norm of the state the tolerance is relative to.

        Returns
        -------
        z : numpy.ndarray or None
            The solution; ``None`` if there was no convergence.
        iterations : int
            Number of linear solves.
        """
        z, last, last_moved, carrying, least = guess, 0.0, 0.0, stage.carrying, size
        for iteration in range(1, self.max_iterations + 1):
            residual, jacobian = stage.evaluate(z)
            if not solver.factorise(jacobian):
                return None, iteration
            update = solver.solve(residual)
            z = z - update
            change = float(np.linalg.norm(update))
            # states without energy follow from the others: a large first correction of them, which their guess may
            # need, says nothing about how fast the others converge
            moved = float(np.linalg.norm(update[carrying]))
            if not np.isfinite(change):
                return None, iteration
            size = max(least, float(np.linalg.norm(z[carrying])))
            ratio = max(change / last, moved / last_moved if last_moved > 0.0 else 0.0) if iteration > 1 else np.inf
            # convergence is quadratic: the next update would be about change * ratio**2
            if change == 0.0 or (ratio < 0.1 and change * ratio**2 <= self.tolerance * size):
                if iteration == 2 and CURVATURE * change**2 > self.tolerance * size**2:
                    # a first update nearly all along linear directions tells nothing of how the others converge
                    return z - solver.solve(stage.evaluate(z)[0]), iteration + 1
                return z, iteration
            # where joints hold everything, the states with energy are nothing but round-off of the joints' forces
            whole = float(np.linalg.norm(z))
            near = change <= 1e-8 * (whole if size <= HELD * whole else size)
            if near and ratio > 0.1 and np.linalg.norm(residual) <= 1e3 * stage.round_off(z):
                return z, iteration  # the round-off floor: no further iteration can improve it
            last, last_moved = change, moved
        return None, self.max_iterations
