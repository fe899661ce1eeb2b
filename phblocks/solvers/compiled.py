"""The iteration for the stages of a step in compiled code, where numba is installed (the extra ``fast``)."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from phblocks.solvers.collocation import CollocationEquation, ModeSolver
from phblocks.solvers.newton import ModifiedNewton, Newton
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
        from phblocks.solvers import kernels

        self._kernels, self._newton, self._equation, self._solver = kernels, newton, equation, solver
        n, stages = equation.n, equation.collocation.c.size
        self._matrices = equation.matrices
        self._sizes, self._line = equation.sizes, equation.line_arrays
        parts, summed, _, _ = self._matrices
        rows = parts[2].size - 1
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
        kernels, newton = self._kernels, self._newton
        z, progress, age, done = self._start(guess), np.array([0.0, 0.0, np.inf, size, size, float(kept)]), int(kept), 0
        step = stage.step_arrays
        while done < newton.max_iterations:
            if not age:
                _, matrices = stage.evaluate(z[:, : self._stages].copy())
                if not solver.factorise(matrices):
                    return None, done + 1
                progress[5] = 0.0
            options = newton.tolerance, newton.slow, newton.max_iterations - done
            equation = self._matrices, step, self._sizes, self._line, self._work
            how, count = kernels.iterate(z, self._stages, equation, *solver.arrays, self._change, self._carrying, progress, options)
            done += count
            if how == kernels.CONVERGED:
                return z[:, : self._stages].copy(), done
            if how == kernels.DIVERGED:
                if not kept:
                    return None, done
                z, progress, kept = self._start(guess), np.array([0.0, 0.0, np.inf, size, size, 0.0]), False
                age = 0
                continue
            if how == kernels.FLOOR:
                whole = z[:, : self._stages].copy()
                if np.linalg.norm(stage.residual(whole)) <= 1e3 * stage.round_off(whole):
                    return whole, done
                age = 0 if progress[2] > newton.slow else 1
                continue
            age = 0
        return None, done

    def _start(self, guess: Floats) -> Floats:
        self._z[:, : self._stages] = guess
        return self._z
