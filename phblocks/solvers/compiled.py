"""Whole steps of collocation methods in compiled code, where numba is installed (the extra ``fast``).

The same sums and the same iterations as in ``ModifiedNewton``, so the same results to round-off; what is saved are the
calls, some hundred of them a step.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phblocks.solvers.bands import BandFactors, modes_of
from phblocks.solvers.coefficients import Collocation
from phblocks.solvers.collocation import CollocationEquation
from phblocks.solvers.linear import is_narrow
from phblocks.solvers.newton import FAR, FLOOR, ModifiedNewton, Newton
from phblocks.solvers.past import FARTHEST, KEPT, Past
from phblocks.solvers.step import SAFE, Step, Steps
from phblocks.system import System
from phblocks.triplets import Floats

#: Entries, columns and starts of rows of a sparse matrix.
Arrays = tuple[Floats, NDArray[np.int32], NDArray[np.int32]]


def installed() -> bool:
    """Say whether numba is.

    Returns
    -------
    bool
        Whether there can be compiled code.
    """
    return find_spec("numba") is not None


def compiled_stepper(
    system: System, collocation: Collocation, newton: Newton, predict: bool = False
) -> CompiledStepper | None:
    """Make a stepper in compiled code, where that is possible.

    Parameters
    ----------
    system : System
        The system to integrate.
    collocation : Collocation
        Coefficients of the method.
    newton : Newton
        The iteration.
    predict : bool, optional
        Extrapolate the last two steps for a first guess; for one stage only.

    Returns
    -------
    CompiledStepper or None
        ``None`` if numba is not installed, the iteration is not ``ModifiedNewton``, or the system has matrices or
        energies that are functions of the user's, or a band that is too wide.
    """
    plain = not (system.storages or system.modulations)
    if not plain or type(newton) is not ModifiedNewton or not installed():
        return None
    equation = CollocationEquation.of(system, collocation)
    return CompiledStepper(equation, newton, predict) if is_narrow(equation.rows, equation.columns) else None


class CompiledStepper:
    """Takes steps of one system in compiled code; see :class:`~phblocks.solvers.method.Stepper`.

    Parameters
    ----------
    equation : CollocationEquation
        Of the stages.
    newton : ModifiedNewton
        Options of the iteration.
    predict : bool, optional
        Extrapolate the last two steps for a first guess; for one stage only.

    Attributes
    ----------
    stage : CollocationEquation
        Changes states to the unknowns that ``step`` works with and back.
    nodes, weights : tuple of float
        Where in a step the inputs are evaluated, as fractions of it, and the weights of the stages.
    """

    def __init__(self, equation: CollocationEquation, newton: ModifiedNewton, predict: bool = False) -> None:
        from phblocks.solvers import _kernels as kernels

        self._kernels: Any = kernels
        self.stage = equation
        collocation, n = equation.collocation, equation.n
        self.nodes, self.weights = (tuple(map(float, v)) for v in (collocation.c, collocation.b))
        stages = len(self.nodes)
        lanes = {1: 1, 2: 2, 3: 4}[stages]
        tables = equation.tables
        A, inverse = np.ascontiguousarray(collocation.A), np.ascontiguousarray(collocation.inverse)
        method = (A, inverse, collocation.b, modes_of(equation))
        angles, pairs = tables.turn[1].size, tables.equation[3].size
        products, features = tables.equation[2].shape[1], equation.system.n_features
        turning, size = equation.system.input_rates.shape[0], equation.mass.size

        def room(*counts: int, width: int = lanes) -> tuple[Floats, ...]:
            return tuple(np.zeros((count, width)) for count in counts)

        self._work = room(tables.equation[0][2].size - 1, angles, pairs, features, products + pairs, n)
        means = n + features + (3 * pairs if tables.equation[5][2].size else 0)
        self._room = (
            *room(n, angles, features, width=1),
            np.zeros(features),
            np.zeros((3, features)),
            *room(means, pairs, size, size, width=1),
        )
        alpha, kappa, force = room(angles, pairs, n)
        kappa[:, :stages] = tables.inputs[0][:, None]
        data = (alpha, kappa, np.zeros((n, 1)), force)
        buffers = (*room(turning, turning, turning, turning, equation.system.n_inputs, n), np.zeros((n, stages)))
        self._constants = (tables.equation, method, tables.turn, tables.inputs, data, buffers)
        factors = BandFactors(equation)
        self._factors = (*factors.arrays, (np.zeros(n), np.zeros(n), np.zeros(n)), np.zeros((n, stages)))
        self._kinds = np.zeros((2, n), dtype=bool)
        self._kinds[0, equation.carrying] = self._kinds[1, equation.impulsive] = True
        self._options = (newton.tolerance, newton.slow, FAR, FLOOR, float(newton.max_iterations))
        self._predict, self._past, self._factored_for = predict, Past(), 0.0

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
            Inputs at the nodes, shape (stages, n_inputs).
        guess : numpy.ndarray, optional
            First guess of the stages, shape (stages, n); by default what the past predicts, or x.

        Returns
        -------
        Step or None
            ``None`` if Newton's method did not converge.
        """
        steps = self._march(x, theta, dt, u[None], guess)
        return None if steps is None else steps.last

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
            Those before the first for which Newton's method does not converge, or that starts from a state too large
            to be sure of.
        """
        return self._march(x, theta, dt, u, None)

    def _march(self, x: Floats, theta: Floats, dt: float, u: Floats, guess: Floats | None) -> Steps | None:
        (count, stages, _), n, turning = u.shape, x.size, theta.size
        guesses = [np.repeat(x[:, None], stages, axis=1) if guess is None else guess.T]
        before, limits = x, (0.0, FARTHEST, SAFE)
        if self._predict and guess is None:
            if (predicted := self._past.middle(x, dt)) is not None:
                guesses = [predicted[:, None], *guesses]
            if known := self._past.before(x):
                before, limits = known[-1].z[-1], (known[-1].dt, FARTHEST, SAFE)
        out: tuple[Any, ...] = (
            np.empty((count, n)),
            np.empty((count, turning)),
            np.empty((count, stages, n)),
            np.empty((count, stages, turning)),
            np.zeros(count, dtype=np.int64),
            np.zeros(count),
        )
        taken, how = self._kernels.march(
            # what numba compiles for depends on flags of arrays
            *(np.array(array) for array in (x, theta)), dt, np.array(u), np.array(guesses), np.array(before), limits,
            self._factored_for == dt, self._predict, *self._constants, self._work, self._room,
            self._factors, self._kinds, self._options, self.stage.algebraic, out,
        )  # fmt: skip
        self._factored_for = dt if how == self._kernels.CONVERGED else 0.0
        if how != self._kernels.CONVERGED:
            self.stage.missed = self._work[-1][:, :stages].copy()
        if not taken:
            return None
        ends, thetas, z, theta_z, iterations, left = (array[:taken] for array in out)
        lengths, damped = np.full(taken, dt), self.stage.lost(x, ends, z)
        steps = Steps(ends, thetas, z, theta_z, u[:taken], lengths, iterations, left, np.zeros(taken), damped=damped)
        if self._predict:
            for i in range(max(0, taken - KEPT), taken - 1):
                self._past.add(steps.row(i))
            self._past.add(steps.last)
        return steps
