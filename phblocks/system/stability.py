"""What a time step will meet, told before any run: frequencies, condition, index, gap.

All of it is of the midpoint rule and of the linearisation about one state. With the frequencies omega of the modes
there, a mode is *resolved* if ``dt omega <= 1``: the midpoint rule then takes at least six steps a period and is off by
less than 8 % in its frequency. Modes above are stable, but what they do is not the motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, eigsh, onenormest, splu

from phblocks.blocks.checks import require_real
from phblocks.errors import DataError
from phblocks.modes import DENSE
from phblocks.system.findings import Finding, Findings
from phblocks.system.scaling import state_scale
from phblocks.system.states import require_state

if TYPE_CHECKING:
    from phblocks.system.parts import State
    from phblocks.system.system import System

EPS = float(np.finfo(float).eps)
#: A condition above this leaves less than three digits of a step.
CONDITION = 1e13
#: Up to this size inverses are made to know a norm exactly.
SMALL = 60
#: Frequencies below this part of the largest are rigid motions.
ZERO = 1e-9
#: How often a shift is tried, and how far from it, relative.
TRIES, NEXT = 8, 1e-7
#: The largest gap of steady spin that is expected without a word, relative to the length.
GAP = 0.01


@dataclass(frozen=True, repr=False)
class StabilityCard:
    """What a step of a length will meet; see ``system.stability_card(dt)``.

    Parameters
    ----------
    name : str
        Of the system.
    dt : float
        The step, s.
    states : int
        Unknowns of a step.
    omega_max : float or None
        The highest frequency, rad/s; ``None`` if it was not found.
    modes, unresolved : int or None
        How many frequencies above zero there are, and how many of them above 1/dt; ``None`` if they were not counted.
    condition : float
        Estimate of the condition of the midpoint rule's Newton matrix, 1-norm, in the units of
        ``phblocks.system.scaling.state_scale``.
    index : int
        0 without states without energy, 1 if these follow from the others, 2 with multipliers of constraints.
    without_energy : int
        States without energy.
    constraints : tuple of str
        The constraints, by the state without energy that each belongs to.
    spin : float
        The largest angular velocity in the state, rad/s.
    """

    name: str
    dt: float
    states: int
    omega_max: float | None
    modes: int | None
    unresolved: int | None
    condition: float
    index: int
    without_energy: int
    constraints: tuple[str, ...]
    spin: float

    @property
    def h_omega_max(self) -> float | None:
        """The step times the highest frequency."""
        return None if self.omega_max is None else self.dt * self.omega_max

    @property
    def unresolved_share(self) -> float | None:
        """The part of all modes that the step does not resolve."""
        return None if self.unresolved is None or self.modes is None else self.unresolved / max(self.modes, 1)

    @property
    def round_off(self) -> float:
        """Relative error of a step that round-off may leave: the condition times 2.2e-16."""
        return EPS * self.condition

    @property
    def gap(self) -> float:
        """Gap of strain and configuration over the length in steady spin, ``(spin dt)^2 / 12``: of order dt^2."""
        return (self.spin * self.dt) ** 2 / 12.0

    @property
    def findings(self) -> Findings:
        """All of it as a table, each line with a verdict."""
        higher = "The midpoint rule is stable at every step; modes above 1/dt are kept, not resolved."
        multipliers = ", ".join(self.constraints[:3]) + (", ..." if len(self.constraints) > 3 else "")
        unknown = f"Not counted: more than {DENSE} states, some of them without energy or of an energy of its own."
        return Findings(
            [
                Finding("h omega_max", self.h_omega_max, advice=unknown if self.omega_max is None else higher),
                Finding("modes", _number(self.modes), advice=unknown),
                Finding("unresolved modes, h omega > 1", _number(self.unresolved), advice=unknown),
                Finding("share of modes unresolved", self.unresolved_share, advice=unknown),
                Finding(
                    "condition of the Newton matrix",
                    self.condition,
                    limit=CONDITION,
                    advice="Little of a step is left above round-off. Look for stiffnesses or masses many decades "
                    "apart, for joints that are nearly redundant here, or take a smaller dt.",
                ),
                Finding("round-off of a step, relative", self.round_off, limit=EPS * CONDITION),
                Finding(
                    "index",
                    float(self.index),
                    where=multipliers,
                    advice="Multipliers: the start is projected on the constraints; imposed velocities must not jump.",
                ),
                Finding("states without energy", float(self.without_energy)),
                Finding(
                    "expected gap over length, (spin dt)^2 / 12",
                    self.gap,
                    limit=GAP,
                    advice=f"Positions from strain and from velocity part by this at {self.spin:.3g} rad/s; by a "
                    "quarter of it at half the step.",
                ),
            ]
        )

    def to_json(self) -> dict[str, object]:
        """Describe it by texts and numbers.

        Returns
        -------
        dict
            Name, step and findings.
        """
        return {"name": self.name, "dt": self.dt, "states": self.states, "findings": self.findings.to_json()}

    def __str__(self) -> str:
        """Format it as a table."""
        return f"{self.name}: {self.states} states, dt = {self.dt:g} s\n{self.findings}"

    def __repr__(self) -> str:
        """Return the table."""
        return str(self)


def stability_card(system: System, dt: float, state: State | None) -> StabilityCard:
    """Find what a step will meet; see ``system.stability_card(dt)``.

    Parameters
    ----------
    system : System
        The system.
    dt : float
        The step, s.
    state : State or None
        About which it is linearised; the start if ``None``.

    Returns
    -------
    StabilityCard
        With all that could be found.

    Raises
    ------
    DataError
        If the step is not positive, the state does not fit, or nothing is in the system.
    ArgumentTypeError
        If an argument is of another kind.
    """
    step = require_real("stability_card dt", dt)
    if not 0.0 < step < np.inf:
        raise DataError("stability_card dt", expected="a time > 0 s", got=repr(dt), fix="Correct it.")
    if system.n == 0:
        raise DataError(
            f"stability_card of {system.name!r}",
            expected="a system with states",
            got="one without",
            fix="Add a block that can move or store something.",
        )
    at = system.start if state is None else require_state(system, state, "stability_card state")
    omega_max, modes, unresolved = _counted(system, at, step)
    spins = at.x[[unit == "rad/s" for unit in system.state_units]]
    idle = int((system.algebraic & ~system.coenergy).sum())
    constraints = system.constraint_names
    return StabilityCard(
        name=system.name,
        dt=step,
        states=system.n,
        omega_max=omega_max,
        modes=modes,
        unresolved=unresolved,
        condition=newton_condition(system, step, at),
        index=2 if constraints else 1 if idle else 0,
        without_energy=idle,
        constraints=constraints,
        spin=float(np.abs(spins).max(initial=0.0)),
    )


def newton_condition(system: System, dt: float, state: State) -> float:
    """Estimate the condition of the midpoint rule's Newton matrix at a state, without inputs.

    Parameters
    ----------
    system : System
        The system.
    dt : float
        The step, s.
    state : State
        Where.

    Returns
    -------
    float
        In the 1-norm, of ``2/dt E - (J - R) - ...`` in scaled unknowns with orientations eliminated; infinite where it
        is singular. Hager's estimate, a lower bound that is rarely off by more than a factor of three; exact for up to
        60 states.
    """
    matrix = newton_matrix(system, dt, state)
    if system.n <= SMALL:
        return float(np.linalg.cond(matrix.toarray(), 1))
    try:
        factor = splu(matrix)
    except RuntimeError:  # exactly singular
        return float("inf")
    n = system.n
    inverse = LinearOperator((n, n), factor.solve, lambda b: factor.solve(b, trans="T"), dtype=np.float64)
    return float(onenormest(inverse) * abs(matrix).sum(axis=0).max())


def newton_matrix(system: System, dt: float, state: State) -> sp.csc_array:
    """Make the midpoint rule's Newton matrix at a state.

    Parameters
    ----------
    system : System
        The system.
    dt : float
        The step, s.
    state : State
        Where.

    Returns
    -------
    scipy.sparse.csc_array
        Shape (n, n), in the units of :func:`state_scale`.
    """
    linear, n = system.linearize(state), system.n
    A = sp.csr_array(linear.A)
    whole = sp.csr_array(2.0 / dt * linear.E - A)
    # an orientation turns by dt/2 times its rate, without an equation of its own
    matrix = whole[:n, :n] - 0.5 * dt * A[:n, n:] @ A[n:, :n] if linear.E.shape[0] > n else whole
    units = sp.diags_array(state_scale(system))
    return sp.csc_array(units @ matrix @ units)


def _counted(system: System, at: State, dt: float) -> tuple[float | None, int | None, int | None]:
    """The highest frequency, how many there are above zero, and how many above 1/dt."""
    if system.n <= DENSE:
        frequencies = system.excited_modes(system.n + at.theta.size, at).frequencies
        highest = float(frequencies[-1]) if frequencies.size else 0.0  # nothing oscillates
        return highest, int(frequencies.size), int((dt * frequencies > 1.0).sum())
    if not system.quadratic or (system.algebraic & ~system.configuration).any():
        return None, None, None
    kept = np.flatnonzero(system.carries_energy)
    E = sp.csc_array(system.E[kept][:, kept])
    J = sp.csc_array(system.J(at.x, at.theta)[kept][:, kept])
    J.eliminate_zeros()
    start = np.random.default_rng(0).standard_normal(kept.size).astype(complex)
    (highest,) = eigsh(-1j * J, 1, M=E.astype(complex), which="LA", v0=start, tol=1e-6, return_eigenvectors=False)
    return float(highest), _count_above(E, J, ZERO * highest), _count_above(E, J, 1.0 / dt)


def _count_above(E: sp.csc_array, J: sp.csc_array, shift: float) -> int | None:
    """How many eigenvalues of ``-1j J w = omega E w`` exceed a shift: Sylvester's law of inertia.

    ``None`` where factorisations leave the diagonal, on which a pivot may vanish; next to the shift it does not.
    """
    for attempt in range(TRIES):
        factor = splu(
            sp.csc_array(-1j * J - (1.0 + NEXT * attempt) * shift * E),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        if np.array_equal(factor.perm_r, factor.perm_c):
            return int((factor.U.diagonal().real > 0.0).sum())
    return None


def _number(count: int | None) -> float | None:
    return None if count is None else float(count)
