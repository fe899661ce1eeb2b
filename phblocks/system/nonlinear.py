"""The equations of motion for other tools: in constant matrices, and as functions of one vector."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from phblocks.errors import StructureError
from phblocks.export.control import nonlinear_to_control
from phblocks.export.control import to_control as linear_to_control
from phblocks.export.nonlinear import NonlinearModel
from phblocks.system.linearization import coenergy_free
from phblocks.system.modulated import require_quadratic
from phblocks.system.parts import State
from phblocks.triplets import Floats, Ints, Triplets

if TYPE_CHECKING:
    from phblocks.system.system import System


def nonlinear_model(system: System, state: State | None = None) -> NonlinearModel:
    """Write the equations of motion in constant matrices; see :class:`NonlinearModel`.

    Parameters
    ----------
    system : System
        The system.
    state : State, optional
        Whose rotation states and positions are the start; the initial configuration by default.

    Returns
    -------
    NonlinearModel
        All of it, whatever the state.

    Raises
    ------
    StructureError
        If the energy is not quadratic: it comes with functions of the user's.
    """
    require_quadratic(system, "nonlinear model in matrices")
    at, n, f, acting = system.start if state is None else state, system.n, system.n_features, system.acting
    by_input = _picked(system.K_u, acting, system.n_inputs)
    lines = system.lines
    spans, place = lines.spans[lines.line], np.arange(lines.count)
    picked = [Triplets.of(place, spans[:, i], values=1.0).coo((lines.count, n)) for i in (0, 1)]
    return NonlinearModel(
        E=system.rate_matrix,
        J0=system.J0,
        R=system.R0,
        T=_unfolded(Triplets.from_coo(system.T), n, n, n),
        K=_unfolded(system.K, n, n, f),
        V=_unfolded(system.kinematics, n, n, f),
        Kg=system.K_g.coo((n, f)),
        G=system.G0[:, acting],
        Ku=_unfolded(by_input, n, acting.size, f),
        Vu=system.kinematics_u[:, acting],
        W=system.rates,
        Wu=system.input_rates[:, acting],
        alpha=system.angles.rows,
        beta=lines.frames.rows,
        gamma=system.point_angles.rows,
        r1=picked[0],
        r2=picked[1],
        stretch=lines.stretch[lines.line],
        points=system.point_velocity,
        theta0=at.theta,
        alpha0=system.angles.reference,
        beta0=lines.frames.reference,
        free=lines.free[lines.line],
        taut=lines.taut[lines.line].astype(np.float64),
        gamma0=system.point_angles.reference,
        points0=at.points,
        theta_names=system.theta_names,
        point_names=tuple(
            f"{part.name}[{i}]" for part in system.parts for i in range(part.points.stop - part.points.start)
        ),
    )


class Motion:
    """The equations of motion as ``w' = rates(w, u)``, ``y = outputs(w, u)``, with the states that have a rate as w.

    Parameters
    ----------
    system : System
        The system.

    Attributes
    ----------
    state_names : tuple of str
        Of w: energy states, then rotation states.
    input_names, output_names : tuple of str
        Of u and y: of the inputs that act.

    Raises
    ------
    StructureError
        If there are states without a rate, such as those of dampers and of joints with multipliers.
    """

    def __init__(self, system: System) -> None:
        self._system = system
        self._kept, self._rows, _ = coenergy_free(system, system.start.x, system.n)
        missing = [i for i in self._kept if system.algebraic[i]]
        if missing:
            names = ", ".join(system.state_names[i] for i in missing[:5]) + (", ..." if len(missing) > 5 else "")
            raise StructureError(
                f"nonlinear model of {system.name!r}",
                expected="an E that can be inverted: all states with a rate",
                got=f"none of {names}",
                fix="Take the linear model with eliminate=True, or simulate here.",
            )
        self._factor = splu(sp.csc_array(system.rate_matrix[self._rows][:, self._kept]))
        self.state_names = tuple(system.state_names[i] for i in self._kept) + system.theta_names
        self.input_names = tuple(system.input_names[i] for i in system.acting)
        self.output_names = tuple(system.output_names[i] for i in system.acting)

    def start(self, state: State | None = None) -> Floats:
        """Return w at a state.

        Parameters
        ----------
        state : State, optional
            The initial configuration by default.

        Returns
        -------
        numpy.ndarray
            Shape (k,).
        """
        at = self._system.start if state is None else state
        return np.concatenate([at.x[self._kept], at.theta])

    def rates(self, w: Floats, u: Floats) -> Floats:
        """Evaluate w'.

        Parameters
        ----------
        w : numpy.ndarray
            Shape (k,).
        u : numpy.ndarray
            Inputs, shape (m,).

        Returns
        -------
        numpy.ndarray
            Shape (k,).
        """
        (x, theta), acting = self._split(w), np.asarray(u)
        u = np.zeros(self._system.n_inputs)
        u[self._system.acting] = acting
        turning = self._system.rates @ x + self._system.input_rates @ u
        return np.concatenate([self._factor.solve(self._system.force(x, theta, u)[self._rows]), turning])

    def outputs(self, w: Floats, u: Floats) -> Floats:
        """Evaluate y.

        Parameters
        ----------
        w : numpy.ndarray
            Shape (k,).
        u : numpy.ndarray
            Inputs, shape (m,).

        Returns
        -------
        numpy.ndarray
            Shape (m,).
        """
        x, theta = self._split(w)
        return np.asarray(self._system.G(theta, x).T @ x)[self._system.acting]

    def _split(self, w: Floats) -> tuple[Floats, Floats]:
        x, w = np.zeros(self._system.n), np.asarray(w, dtype=float)
        x[self._kept] = w[: self._kept.size]
        return self._system.settled(x), w[self._kept.size :]


def to_control(system: System, state: State | None, u: Floats | None, nonlinear: bool, eliminate: bool) -> Any:
    """Make a model for python-control; see :meth:`System.to_control`.

    Parameters
    ----------
    system : System
        The system.
    state : State or None
        About which it is linear.
    u : numpy.ndarray or None
        Inputs there.
    nonlinear : bool
        The equations of motion at all states instead.
    eliminate : bool
        Eliminate states without a rate.

    Returns
    -------
    control.StateSpace or control.NonlinearIOSystem
        The model.
    """
    if not nonlinear:
        return linear_to_control(system.matrices(state, u), eliminate)
    motion = Motion(system)
    names = (motion.state_names, motion.input_names, motion.output_names)
    return nonlinear_to_control(system.name, motion.rates, motion.outputs, *names)


def _picked(entries: Triplets, second: Ints, size: int) -> Triplets:
    """Keep some indices of the second axis, and number them anew."""
    number = np.full(size, -1, dtype=np.int64)
    number[second] = np.arange(second.size)
    i, j, k = entries.indices
    kept = number[j] >= 0
    return Triplets((i[kept], number[j[kept]], k[kept]), entries.values[kept])


def _unfolded(entries: Triplets, rows: int, columns: int, last: int) -> sp.coo_array:
    """Put the second axis under the first, as reshape does by columns."""
    i, j, k = entries.indices
    row: Ints = i + rows * j
    return Triplets((row, k), entries.values).coo((rows * columns, last))
