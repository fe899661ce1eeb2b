"""Steps of linear systems: factors are kept, a step is one back-substitution for each mode of the method."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from phblocks.solvers.bands import BandFactors, modes_of
from phblocks.solvers.coefficients import Collocation
from phblocks.solvers.collocation import CollocationEquation, ModeSolver, arrays_of
from phblocks.solvers.compiled import installed
from phblocks.solvers.linear import band_places, is_narrow
from phblocks.solvers.step import SAFE, Step, Steps
from phblocks.system import System
from phblocks.triplets import Floats, Ints


class LinearStepper:
    """Takes steps of a linear system; see :class:`~phblocks.solvers.method.Marching`.

    Parameters
    ----------
    system : System
        The system to integrate, with ``system.linear``.
    collocation : Collocation
        Coefficients of the method.

    Attributes
    ----------
    stage : CollocationEquation
        Changes states to the unknowns that ``step`` works with and back.
    nodes, weights : tuple of float
        Where in a step the inputs are evaluated, as fractions of it, and the weights of the stages.
    """

    def __init__(self, system: System, collocation: Collocation) -> None:
        self.stage = equation = CollocationEquation.of(system, collocation)
        self.nodes, self.weights = (tuple(map(float, v)) for v in (collocation.c, collocation.b))
        fast = equation.n > 0 and installed() and is_narrow(equation.rows, equation.columns)
        self._recursion: Recursion = CompiledRecursion(equation) if fast else PlainRecursion(equation)
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
            ``None`` if the matrix is singular, or numbers are too large.
        """
        stage, method = self.stage, self.stage.collocation
        z, ends = stage.loads(u)[None], np.empty((1, stage.n))
        if not (self._is_ready(dt) and self._recursion.run(x, z, ends) and np.isfinite(z).all()):
            return None
        turning = dt * stage.spins(z[0], u) if theta.size else np.zeros((len(u), 0))
        lost = stage.lost(x, ends, z)
        damped = None if lost is None else lost[0]
        return Step(ends[0], theta + method.b @ turning, z[0], theta + method.A @ turning, u, dt, 0, damped=damped)

    def march(self, x: Floats, theta: Floats, dt: float, u: Floats) -> Steps | None:
        """Take several steps; see :class:`~phblocks.solvers.method.Marching`.

        Parameters
        ----------
        x : numpy.ndarray
            Unknowns at the start of the first, shape (n,), scaled and reordered.
        theta : numpy.ndarray
            Rotation states there, shape (n_theta,), rad.
        dt : float
            Their length, s.
        u : numpy.ndarray
            Inputs at the nodes of each, shape (steps, stages, n_inputs).

        Returns
        -------
        Steps or None
            Up to the first that ends in a state too large to be sure of; ``None`` if the first has no solution.
        """
        stage, method = self.stage, self.stage.collocation
        if not self._is_ready(dt):
            return None
        z, ends = stage.loads(u), np.empty((len(u), stage.n))
        count = self._recursion.run(x, z, ends)
        if count and not (np.isfinite(z[count - 1]).all() and np.isfinite(ends[count - 1]).all()):
            count -= 1
        if not count:
            return None
        u, z, ends = u[:count], z[:count], ends[:count]
        turning = dt * stage.spins(z, u)
        thetas = np.cumsum(np.concatenate([theta[None], method.b @ turning]), axis=0)
        theta_z, lengths = thetas[:-1, None] + method.A @ turning, np.full(count, dt)
        iterations, residual, lag = np.zeros(count, dtype=np.int64), np.zeros(count), np.zeros(count)
        damped = stage.lost(x, ends, z)
        return Steps(ends, thetas[1:], z, theta_z, u, lengths, iterations, residual, lag, damped=damped)

    def _is_ready(self, dt: float) -> bool:
        """Whether there are factors for steps of a length; they are kept as long as it stays the same."""
        if self._factored_for != dt:
            self._factored_for = dt if self._recursion.factorise(dt) else None
        return self._factored_for is not None


class Recursion(Protocol):
    """Goes from step to step, with factors that are kept."""

    def factorise(self, dt: float) -> bool:
        """Prepare for steps of a length; return False if a matrix is singular.

        Parameters
        ----------
        dt : float
            The length, s.

        Returns
        -------
        bool
            Whether it is ready.
        """
        ...

    def run(self, x: Floats, z: Floats, ends: Floats) -> int:
        """Take steps.

        Parameters
        ----------
        x : numpy.ndarray
            Unknowns at the start, shape (n,).
        z : numpy.ndarray
            Loads at the stages, shape (steps, stages, n), replaced by the unknowns there.
        ends : numpy.ndarray
            Taken by the unknowns at the ends, shape (steps, n).

        Returns
        -------
        int
            How many steps there were: up to the first that ends in a state too large to be sure of.
        """
        ...


class PlainRecursion:
    """Step by step with LAPACK or SuperLU.

    Parameters
    ----------
    equation : CollocationEquation
        Of the stages.
    """

    def __init__(self, equation: CollocationEquation) -> None:
        self._equation, self._free = equation, equation.free
        self._solver = ModeSolver(equation.rows, equation.columns, equation.n, equation.modes)
        self._end, self._extrapolation = equation.collocation.end, equation.collocation.extrapolation

    def factorise(self, dt: float) -> bool:
        """Prepare for steps of a length; see :class:`Recursion`.

        Parameters
        ----------
        dt : float
            The length, s.

        Returns
        -------
        bool
            Whether it is ready.
        """
        values = self._equation.modes.values
        return self._solver.factorise(np.stack([self._equation.matrix(1.0 / (dt * value)) for value in values]))

    def run(self, x: Floats, z: Floats, ends: Floats) -> int:
        """Take steps; see :class:`Recursion`.

        Parameters
        ----------
        x : numpy.ndarray
            Unknowns at the start, shape (n,).
        z : numpy.ndarray
            Loads at the stages, shape (steps, stages, n), replaced by the unknowns there.
        ends : numpy.ndarray
            Taken by the unknowns at the ends, shape (steps, n).

        Returns
        -------
        int
            How many steps there were.
        """
        algebraic = self._equation.algebraic
        for k in range(len(z)):
            change = self._solver.solve((self._free @ x + z[k]).T).T
            z[k] = x + change
            ends[k] = x + self._end @ change
            ends[k, algebraic] = self._extrapolation @ z[k][:, algebraic]
            x = ends[k]
            if not max(x.max(initial=0.0), -x.min(initial=0.0)) < SAFE:
                return k + 1
        return len(z)


class CompiledRecursion:
    """The same in compiled code, where numba is installed (the extra ``fast``) and the band is not too wide.

    Parameters
    ----------
    equation : CollocationEquation
        Of the stages.
    """

    def __init__(self, equation: CollocationEquation) -> None:
        from phblocks.solvers import _kernels as kernels

        n, method, values = equation.n, equation.collocation, equation.modes.values
        self._kernels, self._equation, self._factors = kernels, equation, BandFactors(equation).arrays
        self._real, self._complex = (np.flatnonzero(kind) for kind in (values.imag == 0.0, values.imag != 0.0))
        self._place = band_places(equation.rows, equation.columns)[1]
        self._constants = (arrays_of(equation.free), modes_of(equation), *self._factors)
        self._room = tuple(np.zeros(n) for _ in range(4))
        self._end = (method.end, method.extrapolation, equation.algebraic)

    def factorise(self, dt: float) -> bool:
        """Prepare for steps of a length; see :class:`Recursion`.

        Parameters
        ----------
        dt : float
            The length, s.

        Returns
        -------
        bool
            Whether it is ready.
        """
        values, kernels, (real, paired) = self._equation.modes.values, self._kernels, self._factors
        for mode in self._real:
            _fill(real[0], self._place, self._equation.matrix(1.0 / (dt * values[mode].real)))
        for mode in self._complex:
            matrix = self._equation.matrix(1.0 / (dt * values[mode]))
            _fill(paired[0], self._place, matrix.real)
            _fill(paired[1], self._place, matrix.imag)
        ready = not self._real.size or kernels.eliminate_real(real)
        return bool(ready and (not self._complex.size or kernels.eliminate_complex(paired)))

    def run(self, x: Floats, z: Floats, ends: Floats) -> int:
        """Take steps; see :class:`Recursion`.

        Parameters
        ----------
        x : numpy.ndarray
            Unknowns at the start, shape (n,).
        z : numpy.ndarray
            Loads at the stages, shape (steps, stages, n), replaced by the unknowns there.
        ends : numpy.ndarray
            Taken by the unknowns at the ends, shape (steps, n).

        Returns
        -------
        int
            How many steps there were.
        """
        start = np.array(x)  # what numba compiles for depends on flags of arrays
        return int(self._kernels.march_linear(start, z, ends, *self._constants, self._room, self._end, SAFE**2))


def _fill(band: Floats, places: Ints, entries: Floats) -> None:
    band[:] = 0.0
    band.ravel()[places] = entries
