"""The iteration for the stages of a step in compiled code, where numba is installed (the extra ``fast``).

The same sums in the same order of iterations as in ``ModifiedNewton``, so the same results to round-off; what is saved
are the calls. Matrices are made and factorised as ever.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from phblocks.solvers.collocation import CollocationEquation, ModeSolver
from phblocks.solvers.newton import FAR, ModifiedNewton, Newton
from phblocks.triplets import Floats

if TYPE_CHECKING:
    pass


def compiled(newton: Newton, equation: CollocationEquation, solver: ModeSolver) -> Newton | CompiledNewton:
    """Replace an iteration by the same one in compiled code, where that is possible.

    Parameters
    ----------
    newton : Newton
        The iteration.
    equation : CollocationEquation
        What it will solve.
    solver : ModeSolver
        With what.

    Returns
    -------
    Newton or CompiledNewton
        The given one if numba is not installed, the band is too wide for LAPACK's banded factors, the equation is
        linear, or it is not ``ModifiedNewton``.
    """
    suits = type(newton) is ModifiedNewton and not equation.constant and solver.banded
    if not suits or find_spec("numba") is None:
        return newton
    return CompiledNewton(newton, equation, solver)  # type: ignore[arg-type]  # it is a ModifiedNewton


class CompiledNewton:
    """``ModifiedNewton`` in compiled code: the same iterations, the same result to round-off.

    Parameters
    ----------
    newton : ModifiedNewton
        Its options.
    equation : CollocationEquation
        What it solves.
    solver : ModeSolver
        Factorises.
    """

    def __init__(self, newton: ModifiedNewton, equation: CollocationEquation, solver: ModeSolver) -> None:
        from phblocks.solvers import _kernels as kernels

        self._kernels, self._newton, self._equation, self._solver = kernels, newton, equation, solver
        n, stages = equation.n, equation.collocation.c.size
        self._matrices = equation.matrices
        self._sizes, self._line = equation.sizes, equation.line_arrays
        rows = self._matrices[0][2].size - 1
        counts = rows, self._sizes[0], equation.system.n_features, equation.products, n
        self._work = tuple(np.zeros((count, kernels.LANES)) for count in counts)
        self._stages, self._z, self._change = stages, np.zeros((n, kernels.LANES)), np.zeros((n, stages))
        self._carrying = np.zeros(n, dtype=bool)
        self._carrying[equation.carrying] = True

    def solve(
        self, stage: CollocationEquation, solver: ModeSolver, guess: Floats, size: float, kept: bool = False
    ) -> tuple[Floats | None, int]:
        """Solve the equations of a step that has begun; see ``Newton.solve``.

        Parameters
        ----------
        stage : CollocationEquation
            The equation, with its data fixed.
        solver : ModeSolver
            For its pattern.
        guess : numpy.ndarray
            Shape (n, stages).
        size : float
            Norm of the state the tolerance is relative to.
        kept : bool, optional
            The solver holds a factor of a similar matrix.

        Returns
        -------
        z : numpy.ndarray or None
            The solution; ``None`` if there was no convergence.
        iterations : int
            Number of linear solves.
        """
        newton, codes = self._newton, self._kernels
        z, progress, done = self._start(guess), _fresh(size), 0
        if kept:  # an old factor serves one iteration, if that does not lead far away
            progress[5] = 1.0
            how, done = self._iterate(progress, 1)
            if how == codes.CONVERGED:
                return self._stages_of(z), done
            if how == codes.DIVERGED or progress[0] > FAR * float(np.linalg.norm(guess)):
                z, progress = self._start(guess), _fresh(size)
        while done < newton.max_iterations:
            _, matrices = stage.evaluate(self._stages_of(z))
            if not solver.factorise(matrices):
                return None, done + 1
            progress[5] = 0.0
            how, count = self._iterate(progress, newton.max_iterations - done)
            done += count
            if how == codes.CONVERGED:
                return self._stages_of(z), done
            if how == codes.DIVERGED:
                return None, done
            if how == codes.FLOOR:
                found = self._stages_of(z)
                if np.linalg.norm(stage.residual(found)) <= 1e3 * stage.round_off(found):
                    return found, done
        return None, done

    def _iterate(self, progress: Floats, most: int) -> tuple[int, int]:
        """Iterate with the factor at hand; say how that ended, and after how many iterations."""
        equation = self._matrices, self._equation.step_arrays, self._sizes, self._line, self._work
        options = self._newton.tolerance, self._newton.slow, most
        factors = self._solver.arrays
        how, count = self._kernels.iterate(
            self._z, self._stages, equation, *factors, self._change, self._carrying, progress, options
        )
        return int(how), int(count)

    def _start(self, guess: Floats) -> Floats:
        self._z[:, : self._stages] = guess
        return self._z

    def _stages_of(self, z: Floats) -> Floats:
        return z[:, : self._stages].copy()


def _fresh(size: float) -> Floats:
    """Progress before the first iteration."""
    return np.array([0.0, 0.0, np.inf, size, size, 0.0])
