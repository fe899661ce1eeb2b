"""Whole steps of collocation methods in compiled code, where numba is installed (the extra ``fast``).

The same sums and the same iterations as in ``ModifiedNewton``, so the same results to round-off; what is saved are the
calls, some hundred of them a step.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phblocks.solvers.coefficients import Collocation
from phblocks.solvers.collocation import CollocationEquation
from phblocks.solvers.linear import WIDEST_BAND
from phblocks.solvers.newton import FAR, FLOOR, ModifiedNewton, Newton
from phblocks.solvers.past import Past
from phblocks.solvers.step import Step
from phblocks.system import System
from phblocks.triplets import Floats

#: Entries, columns and starts of rows of a sparse matrix.
Arrays = tuple[Floats, NDArray[np.int32], NDArray[np.int32]]


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
        ``None`` if numba is not installed, the iteration is not ``ModifiedNewton``, the system is linear, has matrices
        or energies that are functions of the user's, or a band that is too wide.
    """
    plain = not (system.linear or system.storages or system.modulations)
    if not plain or type(newton) is not ModifiedNewton or find_spec("numba") is None:
        return None
    equation = CollocationEquation.of(system, collocation)
    return CompiledStepper(equation, newton, predict) if equation.tables.width <= WIDEST_BAND else None


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

        self._kernels, self.stage = kernels, equation
        collocation, n = equation.collocation, equation.n
        self.nodes, self.weights = (tuple(map(float, v)) for v in (collocation.c, collocation.b))
        stages = len(self.nodes)
        lanes = {1: 1, 2: 2, 3: 4}[stages]
        tables = equation.tables
        self._equation, self._turn, self._inputs = tables.equation, tables.turn, tables.inputs
        A, inverse = np.ascontiguousarray(collocation.A), np.ascontiguousarray(collocation.inverse)
        self._method = (A, inverse, collocation.b, _modes(equation))
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
        self._known, self._driven, self._spin = room(turning, turning, turning)
        self._free = np.zeros((turning, lanes))
        self._momentum, self._force = np.zeros((n, 1)), np.zeros((n, lanes))
        self._alpha, self._kappa = np.zeros((angles, lanes)), np.zeros((pairs, lanes))
        self._kappa[:, :stages] = tables.inputs[0][:, None]
        values = equation.modes.values
        width, height = tables.width, 3 * tables.width + 1
        bands = [np.zeros((n if some else 0, height)) for some in ((values.imag == 0.0).any(), values.imag.any())]
        pivots = np.zeros((2, n), dtype=np.int64)
        self._factors = (
            (bands[0], bands[0][:0], pivots[0], width),
            (bands[1], bands[1].copy(), pivots[1], width),
            (np.zeros(n), np.zeros(n), np.zeros(n)),
            np.zeros((n, stages)),
        )
        self._kinds = np.zeros((2, n), dtype=bool)
        self._kinds[0, equation.carrying] = self._kinds[1, equation.impulsive] = True
        self._options = (newton.tolerance, newton.slow, FAR, FLOOR, float(newton.max_iterations))
        self._x, self._theta, self._z = np.zeros(n), np.zeros(turning), np.zeros((n, lanes))
        self._past, self._factored_for = Past() if predict else None, 0.0

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
        kernels, stages, n = self._kernels, len(self.weights), x.size
        self._x[:], self._theta[:] = x, theta  # what numba compiles for depends on flags of arrays
        if u.shape[1]:
            self._drive(u, dt)
        data = (self._alpha, self._kappa, self._momentum, self._force)
        kernels.begin(self._x, self._theta, self._driven, self._equation, self._turn, self._known, data)
        guesses = [np.repeat(x[:, None], stages, axis=1) if guess is None else np.ascontiguousarray(guess.T)]
        if self._past is not None and guess is None:
            predicted = self._past.middle(x, dt)
            guesses = guesses if predicted is None else [predicted[:, None], *guesses]
        size = float(np.sqrt(stages)) * kernels.measure(self._x[:, None], dt, self._kinds[1])
        count, how, left = 0, -1, np.inf
        for start in guesses:
            how, iterations, left = kernels.solve(
                self._z, start, size, self._factored_for == dt, dt, self._equation, self._method, data, self._work,
                self._room, self._factors, self._kinds, self._options,
            )  # fmt: skip
            count += iterations
            self._factored_for = dt if how == kernels.CONVERGED else 0.0
            if how == kernels.CONVERGED:
                break
        if how != kernels.CONVERGED:
            self.stage.missed = self._work[-1][:, :stages].copy()
            return None
        end, theta_end = np.empty(n), np.empty(theta.size)
        z, theta_z = np.empty((stages, n)), np.empty((stages, theta.size))
        out = (end, theta_end, z, theta_z, self._spin)
        kernels.finish(
            self._x, self._theta, self._z, dt, self._free, self._method, self._turn, self.stage.algebraic, out
        )
        step = Step(end, theta_end, z, theta_z, u, dt, count, damped=self.stage.lost(x, z.T), residual=left)
        if self._past is not None:
            self._past.add(step)
        return step

    def _drive(self, u: Floats, dt: float) -> None:
        """Take in the inputs."""
        kappa, by_kappa, force, rates = self._inputs
        stages = u.shape[0]
        self._kappa[:, :stages] = kappa[:, None] + by_kappa @ u.T
        self._force[:, :stages] = force @ u.T
        self._free[:, :stages] = rates @ u.T
        self._driven[:, :stages] = self._free[:, :stages] @ (dt * self._method[0].T)


def _modes(equation: CollocationEquation) -> tuple[Any, ...]:
    """Eigenvalue, weights into the mode and out of it, of the real mode and of the complex one."""
    none: tuple[Any, ...] = (0.0, np.zeros(equation.collocation.b.size), np.zeros(equation.collocation.b.size))
    real, paired = none, (0j, none[1] * 0j, none[2] * 0j)
    modes = equation.modes
    for value, left, right in zip(modes.values, modes.left, modes.right, strict=True):
        if value.imag:
            paired = (complex(value), left.copy(), right.copy())
        else:
            real = (float(value.real), left.real.copy(), right.real.copy())
    return (*real, *paired)
