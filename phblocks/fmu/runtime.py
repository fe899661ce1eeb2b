"""What runs inside an FMU: the steps of ``simulate``, one communication step after the other, with their energies."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from phblocks.diagram import load
from phblocks.inputs import Drive
from phblocks.simulation import MOST_STEPS
from phblocks.solvers.discrete_gradient import DiscreteGradient
from phblocks.solvers.midpoint import Midpoint
from phblocks.system import State, consistent_start

#: How often a step that fails is halved.
HALVINGS = 12


class Runtime:
    """A system that is stepped from outside with inputs held over each communication step.

    Parameters
    ----------
    path : pathlib.Path
        Of the diagram.
    longest_step : float
        Of the time method, s.

    Attributes
    ----------
    u : numpy.ndarray
        Inputs, shape (n_inputs,): those of sources with a constant at the start, else zero.
    time : float
        Since the start, s.
    energy : dict of str to float
        Stored, of gravity (relative to the start), supplied and dissipated, and the largest error of the balance of any
        step, J.
    """

    def __init__(self, path: Path, longest_step: float) -> None:
        self.system = load(path).compile(effects="all")  # who drives it may set any input
        self.longest_step = longest_step
        self.u = np.zeros(self.system.n_inputs)
        constants = {i.exposure: i.signal for i in self.system.inputs if i.signal is not None}
        given = {i.exposure for i in self.system.inputs if i.common and i.signal is None}
        zero = {name: np.zeros(sum(i.exposure == name for i in self.system.inputs)) for name in given}
        if self.system.n_inputs:
            self.u = np.array(Drive(self.system, {**zero, **constants}).at([0.0])[0], dtype=float)
        self.begin()

    def begin(self) -> None:
        """Go to the start, with the inputs as they are now: constraints are satisfied by a projection."""
        system = self.system
        state = State(system.settled(system.start.x), system.start.theta, system.start.points)
        if system.is_dae:
            state, _ = consistent_start(system, state, self.u)
        self._stepper = (Midpoint() if system.quadratic else DiscreteGradient()).prepare(system)
        self._x, self._theta, self.time = state.x, state.theta, 0.0
        self.energy = dict.fromkeys(("gravity", "supplied", "dissipated", "error"), 0.0)
        self.energy["stored"] = system.energy(state.x)

    def outputs(self) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        """Evaluate the outputs at the present state.

        Returns
        -------
        numpy.ndarray
            Shape (n_inputs,).
        """
        return np.asarray(self.system.G(self._theta, self._x).T @ self._x)

    def advance(self, duration: float) -> bool:
        """Take a communication step.

        Parameters
        ----------
        duration : float
            s.

        Returns
        -------
        bool
            Whether it was taken, else all is as before; steps of the time method that fail are halved, and given up
            after 12 halvings.
        """
        if not (self.longest_step > 0.0 and 0.0 <= duration < MOST_STEPS * self.longest_step):
            return False
        if not np.isfinite(self.u).all():
            return False
        count = math.ceil(duration / self.longest_step - 1e-9)
        before = (self._x, self._theta, self.time, dict(self.energy))
        taken = all(self._step(duration / count, HALVINGS) for _ in range(count))
        if not taken:
            self._x, self._theta, self.time, self.energy = before
        return taken

    def _step(self, dt: float, halvings: int) -> bool:
        stage, system = self._stepper.stage, self.system
        step = self._stepper.step(stage.pack(self._x), self._theta, dt, self.u[None])
        if step is None:
            return halvings > 0 and all(self._step(dt / 2.0, halvings - 1) for _ in range(2))
        z, theta = stage.unpack(step.z[0]), step.theta_z[0]
        supplied = dt * float(self.u @ (system.G(theta, z).T @ z))
        dissipated = dt * float(z @ (system.R_at(z) @ z))
        work = dt * float(z @ system.gravity_force(theta))
        self._x, self._theta, self.time = stage.unpack(step.x), step.theta, self.time + dt
        stored = system.energy(self._x)
        error = abs(stored - self.energy["stored"] - supplied + dissipated - work)
        self.energy["error"] = max(self.energy["error"], error)
        for key, change in (("supplied", supplied), ("dissipated", dissipated), ("gravity", -work)):
            self.energy[key] += change
        self.energy["stored"] = stored
        return True
