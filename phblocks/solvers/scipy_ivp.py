"""SciPy's integrators on the same system, for comparison."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from phblocks.errors import ArgumentTypeError, DataError, MethodError
from phblocks.frames import rotate
from phblocks.inputs import Drive
from phblocks.solvers.coefficients import Collocation
from phblocks.solvers.method import Booked
from phblocks.solvers.schedule import Schedule
from phblocks.solvers.stage import StageEquation
from phblocks.solvers.step import Step, StepFailed, Steps
from phblocks.system import State, System
from phblocks.triplets import Floats

if TYPE_CHECKING:
    from scipy.integrate import OdeSolver

#: Names in ``scipy.integrate``.
METHODS = ("Radau", "BDF", "DOP853")
IMPLICIT = ("Radau", "BDF")


@dataclass(frozen=True)
class ScipyIVP:
    """An integrator of ``scipy.integrate`` on the same equations: steps of its own, energy not kept.

    States, orientations and positions are integrated together, states in units of the energy they carry. The implicit
    methods are given the exact Jacobian, sparse. States at the times that are saved come from SciPy's dense output,
    as accurate as the steps themselves only to its order. The energy ledger is a quadrature of the powers over each
    accepted step (three Gauss points of the dense output): its errors, and those of the energy, are reported as they
    are. E must not be singular. ``dt`` of ``simulate`` is the distance of the saved times, not of the steps.

    Conserved: nothing. Cost of a step: SciPy's, for Radau and BDF an evaluation of the Jacobian and a sparse
    factorisation (Radau: a real and a complex one) without a band where those before serve no longer, for DOP853 twelve
    evaluations of the rates. The Jacobian has the inverse of E, full for each beam: meant for a few thousand states.

    Parameters
    ----------
    method : str, optional
        "Radau" (order 5, implicit), "BDF" (order 1 to 5, implicit) or "DOP853" (order 8, explicit: for soft systems).
    rtol, atol : float, optional
        Tolerances; the absolute one in J^(1/2) for states, rad and m.

    Raises
    ------
    DataError
        If the method is unknown or a tolerance out of its range.
    ArgumentTypeError
        If a tolerance is not a number.

    Notes
    -----
    E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., doi:10.1007/978-3-642-05221-7.
    """

    method: str = "Radau"
    rtol: float = 1e-6
    atol: float = 1e-6

    def __post_init__(self) -> None:
        """Check the options."""
        if not isinstance(self.method, str) or self.method not in METHODS:
            raise DataError(
                "ScipyIVP method", expected=f"one of {', '.join(METHODS)}", got=repr(self.method), fix='Use "Radau".'
            )
        for name in ("rtol", "atol"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
                raise ArgumentTypeError(f"ScipyIVP {name}", expected="a number", got=repr(value), fix="Use 1e-6.")
            if not 1e-14 <= value < 1.0:
                raise DataError(f"ScipyIVP {name}", expected="a number in [1e-14, 1)", got=repr(value), fix="Use 1e-6.")

    def integrate(self, system: System, drive: Drive, start: State, schedule: Schedule) -> ScipyWalk:
        """Prepare a run.

        Parameters
        ----------
        system : System
            The system to integrate.
        drive : Drive
            The inputs.
        start : State
            Where it starts.
        schedule : Schedule
            Its times.

        Returns
        -------
        ScipyWalk
            The way through time.

        Raises
        ------
        MethodError
            If states have no rate.
        """
        if system.algebraic.any():
            names = [name for name, found in zip(system.state_names, system.algebraic, strict=True) if found]
            raise MethodError(
                f"ScipyIVP for system {system.name!r}",
                expected="a rate for every state, E regular",
                got=f"none for {', '.join(names[:5])}{', ...' if len(names) > 5 else ''}",
                fix="Use ph.Midpoint() or ph.GaussLegendre().",
            )
        return ScipyWalk(RateEquation(system), drive, start, schedule, self)


class RateEquation(StageEquation):
    """The equations of motion solved for the rates of states, orientations and positions.

    Parameters
    ----------
    system : System
        The system; E must be regular.
    """

    def __init__(self, system: System) -> None:
        super().__init__(system)
        n_angles, lines = system.angles.reference.size, system.lines.count
        turning = np.flatnonzero(self._feature > 0)
        number = self._feature[turning] - 1
        along = number - 2 * n_angles
        angle = np.where(along < 0, number % max(1, n_angles), n_angles + along % max(1, lines))
        pick = sp.csr_array((np.ones(turning.size), (turning, angle)), shape=(self._feature.size, n_angles + lines))
        self._by_theta = sp.csr_array(pick @ self._alpha_rows)
        self._factor = splu(sp.csc_array(self._mass_matrix))
        inverse = self._factor.solve(np.eye(self.n))
        inverse[np.abs(inverse) < 1e-12 * np.abs(inverse).max()] = 0.0  # for the Jacobian only
        self._inverse = sp.csr_array(inverse)
        self._velocities = sp.csr_array(system.point_velocity[:, self.order] @ sp.diags_array(self.scale))
        self._ends = np.cumsum([self.n, system.start.theta.size])

    def join(self, state: State) -> Floats:
        """Make one vector of a state.

        Parameters
        ----------
        state : State
            The state.

        Returns
        -------
        numpy.ndarray
            Unknowns, rotation states and positions.
        """
        return np.concatenate([self.pack(state.x), state.theta, state.points.ravel()])

    def split(self, y: Floats) -> tuple[Floats, Floats, Floats]:
        """Take such a vector apart.

        Parameters
        ----------
        y : numpy.ndarray
            Shape (size,).

        Returns
        -------
        unknowns, theta, points : numpy.ndarray
            Shapes (n,), (n_theta,) and (n_points, dimension).
        """
        x, theta, points = np.split(y, self._ends)
        return x, theta, points.reshape(-1, self.system.dimension)

    def rates(self, y: Floats, u: Floats) -> Floats:
        """Evaluate the rates.

        Parameters
        ----------
        y : numpy.ndarray
            Shape (size,).
        u : numpy.ndarray
            Inputs, shape (n_inputs,).

        Returns
        -------
        numpy.ndarray
            Shape (size,).
        """
        x, theta, points = self.split(y)
        self.begin(0.0, 0.0, theta, u, np.zeros(self.n))
        velocity = (self._velocities @ x).reshape(points.shape)
        moved = rotate(self.system.point_angles.at(theta), velocity)
        return np.concatenate([self._factor.solve(-self.residual(x)), self.spin(x, u), moved.ravel()])

    def jacobian(self, y: Floats, u: Floats) -> sp.csc_array:
        """Evaluate their derivatives.

        Parameters
        ----------
        y : numpy.ndarray
            Shape (size,).
        u : numpy.ndarray
            Inputs, shape (n_inputs,).

        Returns
        -------
        scipy.sparse.csc_array
            Shape (size, size).
        """
        x, theta, points = self.split(y)
        self.begin(0.0, 0.0, theta, u, np.zeros(self.n))
        entries = self.evaluate(x)[1]
        slopes = self._features(x, self._alpha)[1]
        kappa = self._kappa @ x + self._kappa_known
        by_theta = self._collect @ sp.diags_array(kappa * slopes[self._feature]) @ self._by_theta
        angle, d = self.system.point_angles.at(theta), self.system.dimension
        turns = [rotate(angle, np.tile(e, (angle.size, 1))) for e in np.eye(d)]
        frames = sp.block_diag(list(np.stack(turns, axis=-1)), format="csr") if angle.size else sp.csr_array((0, 0))
        across = rotate(angle + 0.5 * np.pi, (self._velocities @ x).reshape(points.shape)).ravel()
        swept = sp.diags_array(across) @ sp.csr_array(np.repeat(self.system.point_angles.rows.toarray(), d, axis=0))
        return sp.csc_array(
            sp.block_array(
                [
                    [-self._inverse @ self._matrix(entries), self._inverse @ by_theta, None],
                    [self._rates, sp.csr_array((theta.size, theta.size)), None],
                    [frames @ self._velocities, swept, sp.csr_array((points.size, points.size))],
                ]
            )
        )


class ScipyWalk:
    """Goes through a schedule in the steps of a SciPy integrator.

    Parameters
    ----------
    equation : RateEquation
        The equations.
    drive : Drive
        The inputs.
    start : State
        Where it starts.
    schedule : Schedule
        Its times.
    options : ScipyIVP
        Method and tolerances.

    Attributes
    ----------
    stage : RateEquation
        The equations.
    weights, nodes : tuple of float
        Of the Gauss points at which the ledger evaluates powers.
    steps, halvings, rejections : int
        Accepted steps; SciPy does not tell the others.
    """

    halvings = rejections = 0

    def __init__(
        self, equation: RateEquation, drive: Drive, start: State, schedule: Schedule, options: ScipyIVP
    ) -> None:
        gauss = Collocation.gauss(3)
        self.stage, self.weights = equation, tuple(map(float, gauss.b))
        self.nodes = tuple(map(float, gauss.c))
        self.steps = 0
        self._drive, self._schedule, self._options = drive, schedule, options
        self._t, self._y = 0.0, equation.join(start)
        self._first_step: float | None = None
        self._solver: OdeSolver | None = None

    def __iter__(self) -> Iterator[Booked]:
        """Go; see :class:`~phblocks.solvers.method.Walk`. A step is booked in pieces that end at saved times."""
        from scipy import integrate  # half of what loading the library would cost

        options, equation = self._options, self.stage

        def rates(t: float, y: Floats) -> Floats:
            return equation.rates(y, self._drive.at([t])[0])

        def jacobian(t: float, y: Floats) -> sp.csc_array:
            return equation.jacobian(y, self._drive.at([t])[0])

        extra: dict[str, Any] = {"jac": jacobian} if options.method in IMPLICIT else {}
        if self._first_step is not None:
            extra["first_step"] = min(self._first_step, self._schedule.t_end - self._t)
        solver = self._solver = getattr(integrate, options.method)(
            rates, self._t, self._y, self._schedule.t_end, rtol=options.rtol, atol=options.atol, **extra
        )
        t, dense = self._t, cast(Callable[[float], Floats], None)  # set by the first step
        for _, target in self._schedule.targets():
            while t < target:
                if t >= solver.t:
                    message = solver.step()
                    if solver.status == "failed":
                        raise StepFailed(solver.t, abs(solver.h_abs), f"SciPy's {options.method} failed ({message})")
                    self.steps += 1
                    dense = solver.dense_output()
                end = min(target, solver.t)
                times = t + np.array(self.nodes) * (end - t)
                z = [equation.split(dense(at)) for at in times]
                x, theta, points = equation.split(solver.y if end == solver.t else dense(end))
                step = Step(
                    x=x,
                    theta=theta,
                    z=np.stack([part[0] for part in z]),
                    theta_z=np.stack([part[1] for part in z]),
                    u=self._drive.at([float(at) for at in times]),
                    dt=end - t,
                    iterations=0,
                    points=points,
                )
                self._t = t = end
                yield Steps.of(step), np.array([t]), np.array([t == target])

    def mark(self) -> dict[str, Floats] | None:
        """Return where it is; see :class:`~phblocks.solvers.method.Resumable`. There SciPy's method starts anew.

        Returns
        -------
        dict of str to numpy.ndarray or None
            For :meth:`resume`; ``None`` where it cannot be left.
        """
        solver = self._solver
        if solver is not None and self._t < solver.t:
            return None
        times = [] if solver is None else [self._t]
        return {
            "counts": np.array([self.steps], dtype=np.int64),
            "t": np.array([self._t, np.nan if solver is None else abs(solver.h_abs)]),
            "y": self._y if solver is None else solver.y,
            "input_times": np.array(times),
            "inputs": self._drive.at(times),
        }

    def resume(self, mark: Mapping[str, Floats]) -> None:
        """Go there; see :class:`~phblocks.solvers.method.Resumable`.

        Parameters
        ----------
        mark : mapping of str to numpy.ndarray
            From :meth:`mark`.
        """
        (self.steps,) = map(int, mark["counts"])
        self._t, step = map(float, mark["t"])
        self._first_step = None if np.isnan(step) else step
        self._y = mark["y"]
