"""Newton's method on a stage equation, with a stopping test in the energy norm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.solvers.linear import LinearSolver
from phblocks.triplets import Floats, Ints

#: An update of this relative size, that falls no more, is round-off if the residual is.
FLOOR = 1e-8
#: An update with an old factor that is this many times as large as the guess is not believed.
FAR = 100.0


class Equation(Protocol):
    """What is solved: a stage, or all stages of a step together.

    Attributes
    ----------
    left : float
        Size of the update that the next iteration would make, relative to the state: set where an iteration ends.
    missed : numpy.ndarray
        The last residual of an iteration that failed.
    """

    left: float
    missed: Floats

    @property
    def carrying(self) -> slice | Ints:
        """The unknowns with a rate."""
        ...

    def residual(self, z: Floats) -> Floats:
        """Evaluate the residual.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns.

        Returns
        -------
        numpy.ndarray
            Of the shape of z.
        """
        ...

    def evaluate(self, z: Floats) -> tuple[Floats, Floats]:
        """Evaluate residual and Jacobian.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns.

        Returns
        -------
        residual : numpy.ndarray
            Of the shape of z.
        jacobian : numpy.ndarray
            What the solver factorises.
        """
        ...

    def measure(self, z: Floats) -> float:
        """Measure unknowns, or an update of them, in one unit: the root of an energy.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns.

        Returns
        -------
        float
            Of those without energy the impulse counts.
        """
        ...

    def round_off(self, z: Floats) -> float:
        """Estimate the round-off in the residual at the last evaluation.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns.

        Returns
        -------
        float
            Of its Euclidean norm.
        """
        ...


#: An update of this relative size may be followed by one of its square times this.
CURVATURE = 10.0


@dataclass(frozen=True)
class Newton:
    """Options of Newton's method.

    The unknowns are scaled by the square root of the energy they carry, and those that carry none (constraint forces)
    by what their impulse over the step moves, so one relative tolerance suits forces of 1e8 N and velocities of
    1e-6 m/s alike.

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

    @np.errstate(all="ignore")  # numbers that are not finite end the iteration
    def solve(
        self, stage: Equation, solver: LinearSolver, guess: Floats, size: float, kept: bool = False
    ) -> tuple[Floats | None, int]:
        """Solve a stage equation that has begun.

        Parameters
        ----------
        stage : Equation
            With its data fixed.
        solver : LinearSolver
            For its pattern.
        guess : numpy.ndarray
            Shape (n,) or (n, stages), in scaled, reordered unknowns.
        size : float
            Measure of the state the tolerance is relative to.
        kept : bool, optional
            The solver holds a factor of a similar matrix. The exact Newton method has no use for it.

        Returns
        -------
        z : numpy.ndarray or None
            The solution; ``None`` if there was no convergence.
        iterations : int
            Number of linear solves.
        """
        z, progress = guess, _Progress(stage, size)
        for iteration in range(1, self.max_iterations + 1):
            residual, jacobian = stage.evaluate(z)
            stage.missed = residual
            if not solver.factorise(jacobian):
                return None, iteration
            update = solver.solve(residual)
            z = z - update
            if not progress.add(z, update):
                return None, iteration
            change, ratio = progress.change, progress.ratio
            # convergence is quadratic: the next update would be about change * ratio**2
            if change == 0.0 or (ratio < 0.1 and change * ratio**2 <= self.tolerance * progress.size):
                if iteration == 2 and CURVATURE * change**2 > self.tolerance * progress.size**2:
                    # a first update nearly all along linear directions tells nothing of how the others converge
                    update = solver.solve(stage.residual(z))
                    stage.left = progress.relative(stage.measure(update) ** 2 / change)
                    return z - update, iteration + 1
                stage.left = progress.relative(change * ratio**2 if change else 0.0)
                return z, iteration
            if ratio > 0.1 and progress.at_floor(z, residual):
                stage.left = progress.relative(change)
                return z, iteration
        return None, self.max_iterations


@dataclass(frozen=True)
class ModifiedNewton(Newton):
    """Newton's method with a factor that is kept until convergence slows.

    A factor from the step before serves the first iteration; a new one, made where that led, all others, unless
    updates fall too slowly or grow: then the last one is undone and another factor made. More iterations than
    ``Newton``, but most of them cost a residual and a back-substitution only. The result is the same to round-off: the
    error that is left is estimated from the linear convergence of the last two updates.

    Parameters
    ----------
    tolerance : float, optional
        Size of the error that the next iterations would still correct, relative to the state.
    max_iterations : int, optional
        A step that needs more has failed.
    slow : float, optional
        Ratio of two updates above which the matrix is factorised anew.

    Raises
    ------
    DataError
        If a value is out of its range.
    ArgumentTypeError
        If a value is not a number of the right kind.
    """

    max_iterations: int = 40
    slow: float = 0.3

    def __post_init__(self) -> None:
        """Check the values."""
        super().__post_init__()
        slow = self.slow
        if isinstance(slow, bool) or not isinstance(slow, (int, float, np.floating)):
            raise ArgumentTypeError("ModifiedNewton slow", expected="a number", got=repr(slow), fix="Use 0.3.")
        if not 0.0 < slow < 1.0:
            raise DataError("ModifiedNewton slow", expected="a number in (0, 1)", got=repr(slow), fix="Use 0.3.")

    @np.errstate(all="ignore")  # numbers that are not finite end the iteration
    def solve(
        self, stage: Equation, solver: LinearSolver, guess: Floats, size: float, kept: bool = False
    ) -> tuple[Floats | None, int]:
        """Solve a stage equation that has begun; see ``Newton``. A factor the solver holds is tried first."""
        z, progress, age = guess, _Progress(stage, size), 1 if kept else 0
        for iteration in range(1, self.max_iterations + 1):
            if age:
                residual = stage.residual(z)
            else:
                residual, jacobian = stage.evaluate(z)
                if not solver.factorise(jacobian):
                    stage.missed = residual
                    return None, iteration
            age += 1
            update = solver.solve(residual)
            before, z = z, z - update
            finite = progress.add(z, update)
            if kept and not (finite and progress.falling and progress.change <= FAR * stage.measure(guess)):
                z, progress, age, kept = guess, _Progress(stage, size), 0, False  # an old factor proves nothing
                continue
            stage.missed = residual
            if not finite:
                return None, iteration
            change, ratio, goal = progress.change, progress.ratio, self.tolerance * progress.size
            # convergence is linear: what is left is the sum of a geometric series
            if change == 0.0 or (ratio < 0.5 and change * ratio <= goal * (1.0 - ratio)):
                stage.left = progress.relative(change * ratio if change else 0.0)
                return z, iteration
            if ratio > 0.5 and progress.at_floor(z, residual):
                stage.left = progress.relative(change)
                return z, iteration
            if kept and iteration == 1:
                age = 0  # measured: an old factor is worth one iteration, then a new one nearer the solution pays
            elif age > 1 and not progress.falling:
                z, age = before, 0
            elif ratio > self.slow and age > 1 and change * ratio**3 > goal:
                age = 0
            kept = kept and iteration == 1
        return None, self.max_iterations


class _Progress:
    """Sizes of the last update, and how they fell."""

    def __init__(self, stage: Equation, size: float) -> None:
        self._stage, self._carrying, self._least = stage, stage.carrying, size
        self.change, self._moved, self.ratio, self.size = 0.0, 0.0, np.inf, size

    def add(self, z: Floats, update: Floats) -> bool:
        """Take in an update that led to z; say whether it is finite."""
        last, last_moved, self.change = self.change, self._moved, self._stage.measure(update)
        # states without energy follow from the others: a large first correction of them, which their guess may
        # need, says nothing about how fast the others converge
        self._moved = float(np.linalg.norm(update[self._carrying]))
        self.size = max(self._least, self._stage.measure(z))
        if last > 0.0:
            self.ratio = max(self.change / last, self._moved / last_moved if last_moved > 0.0 else 0.0)
        return bool(np.isfinite(self.change))

    @property
    def falling(self) -> bool:
        """Whether the last update was smaller than the one before; true of the first."""
        return self.ratio < 1.0 or self.ratio == np.inf

    def relative(self, update: float) -> float:
        """Divide the size of an update by that of the state."""
        return update / self.size if self.size else 0.0

    def at_floor(self, z: Floats, residual: Floats) -> bool:
        """Say whether the residual is round-off: no further iteration can improve z."""
        near = self.change <= FLOOR * self.size
        return near and bool(np.linalg.norm(residual) <= 1e3 * self._stage.round_off(z))
