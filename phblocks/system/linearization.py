"""Linear models of a system: about a state, and for small motions about the initial configuration."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from phblocks.system.angles import Angles
from phblocks.system.modulated import modulation_slopes, require_quadratic
from phblocks.system.parts import State
from phblocks.triplets import Floats, Ints, Triplets

if TYPE_CHECKING:
    from phblocks.system.system import System


@dataclass(frozen=True)
class Linearization:
    """A linear descriptor system ``E w' = A w + B u``, ``y = C w + D u`` for deviations from a state.

    Parameters
    ----------
    E, A : scipy.sparse.csr_array
        Shape (m, m); m is n, or n + n_theta where the right-hand side depends on the orientation.
    B : scipy.sparse.csr_array
        Shape (m, k), a column for each of ``inputs``.
    C : scipy.sparse.csr_array
        Shape (k, m).
    D : scipy.sparse.csr_array
        Shape (k, k).
    theta : numpy.ndarray
        The rotation states among w, after the states x: those that the right-hand side or an output depends on.
    inputs : numpy.ndarray
        The inputs of the system that u has: all, but those that pruning takes to be zero (``system.acting``).
    """

    E: sp.csr_array
    A: sp.csr_array
    B: sp.csr_array
    C: sp.csr_array
    D: sp.csr_array
    theta: Ints
    inputs: Ints

    def __repr__(self) -> str:
        """Count states and inputs."""
        return f"<Linearization: {self.n} states, {self.theta.size} rotations, {self.B.shape[1]} inputs>"

    @property
    def n(self) -> int:
        """How many of the states w are states x of the system."""
        return int(self.E.shape[0] - self.theta.size)


def linearize(system: System, state: State | None = None, u: Floats | None = None) -> Linearization:
    """Linearise the equations of motion about a state; see :meth:`System.linearize`.

    Parameters
    ----------
    system : System
        The system.
    state : State, optional
        The initial configuration at rest by default.
    u : numpy.ndarray, optional
        Inputs there, shape (n_inputs,); zero by default.

    Returns
    -------
    Linearization
        Its states are x, and theta where the right-hand side depends on it.
    """
    state = system.start if state is None else state
    u = np.zeros(system.n_inputs) if u is None else u
    x = followed(system, state, u)
    shape, tensor = (system.n, system.n), Triplets.from_coo(system.T)
    swapped = Triplets((tensor.indices[0], tensor.indices[2], tensor.indices[1]), tensor.values)
    phi = system.features(state.theta, x)
    moving = system.kinematics.contracted(phi).csr(shape)
    A = system.J(x, state.theta) - system.R_at(x) + moving + swapped.contracted(x).csr(shape)
    A = A + modulation_slopes(system, x) if system.modulations else A
    for s in system.storages:
        rows, columns = np.meshgrid(s.energy, s.energy, indexing="ij")
        A = A - Triplets.of(rows.ravel(), columns.ravel(), values=np.ravel(s.hessian(x[s.energy]))).csr(shape)
    # kappa[i, f]: what multiplies feature f in equation i; its slope times d alpha / d theta is the derivative
    kappa = _kappa(system, x, u)
    by_theta, by_x = _slopes(system, state.theta, x)
    outputs = _output_slopes(system, x)
    turning, C_theta = sp.csc_array(kappa @ by_theta), sp.csc_array(outputs @ by_theta)
    A = A + kappa @ by_x
    C = system.G(state.theta, x).T + outputs @ by_x
    G, acting = system.G(state.theta, x) + system.kinematics_u, system.acting
    none = sp.csr_array((acting.size, acting.size))
    used = np.flatnonzero((abs(turning).sum(axis=0) + abs(C_theta).sum(axis=0)) > 0.0)
    if not used.size:
        B, C = sp.csr_array(G)[:, acting], sp.csr_array(C)[acting]
        return Linearization(system.rate_matrix, sp.csr_array(A), B, C, none, used, acting)
    stay = sp.csr_array((used.size, used.size))
    return Linearization(
        sp.csr_array(sp.block_diag([system.rate_matrix, sp.eye_array(used.size)])),
        sp.csr_array(sp.block_array([[A, turning[:, used]], [system.rates[used], stay]])),
        sp.csr_array(sp.vstack([G, system.input_rates[used]]))[:, acting],
        sp.csr_array(sp.hstack([C, C_theta[:, used]]))[acting],
        none,
        used,
        acting,
    )


def followed(system: System, state: State, u: Floats) -> Floats:
    """Set states that follow from others: gradients of energies, inputs and outputs of matrices that vary.

    Multipliers of constraints do not follow from a state; where there are any, all states without energy stay as given.

    Parameters
    ----------
    system : System
        The system.
    state : State
        As given.
    u : numpy.ndarray
        Inputs, shape (n_inputs,).

    Returns
    -------
    numpy.ndarray
        Shape (n,).
    """
    x = system.settled(state.x)
    free = system.algebraic & ~system.coenergy
    if not any(free[m.on].any() for m in system.modulations) or system.constraint_names:
        return x
    x[free] = 0.0
    A = sp.csc_array((system.J(x, state.theta) - system.R_at(x))[free][:, free])
    x[free] = -splu(A).solve(system.force(x, state.theta, u)[free])
    return x


def coenergy_free(system: System, x: Floats, size: int) -> tuple[Ints, Ints, sp.csr_array]:
    """Return what leaves the co-energy variables of energies that are not quadratic out.

    Parameters
    ----------
    system : System
        The system.
    x : numpy.ndarray
        States, shape (n,).
    size : int
        Number of states: n, or those of a linearisation.

    Returns
    -------
    kept : numpy.ndarray
        The states that are left.
    rows : numpy.ndarray
        For each of them the equation that has its rate.
    right : scipy.sparse.csr_array
        Shape (size, kept): small departures of all states, of those that are left.
    """
    kept, rows = np.setdiff1d(np.arange(size), np.flatnonzero(system.coenergy)), np.arange(size)
    right = sp.eye_array(size, format="lil")
    for s in system.storages:
        rows[s.energy] = s.coenergy
        right[np.ix_(s.coenergy, s.energy)] = s.hessian(x[s.energy])
    return kept, rows[kept], sp.csr_array(sp.csr_array(right)[:, kept])


def energy_variables(system: System, state: State, size: int) -> tuple[sp.csr_array, sp.csr_array]:
    """Return what takes the co-energy variables of energies that are not quadratic out of a linearisation.

    Parameters
    ----------
    system : System
        The system.
    state : State
        What it was linearised about.
    size : int
        Number of states of the linearisation.

    Returns
    -------
    left, right : scipy.sparse.csr_array
        ``left E right`` and ``left A right`` are those of the states that are left, of which ``right`` makes all;
        ``left E right`` is the Hessian for energy variables where that is positive definite, and the identity else.
    """
    kept, _, right = coenergy_free(system, state.x, size)
    left = sp.eye_array(size, format="lil")
    for s in system.storages:
        hessian = s.hessian(state.x[s.energy])
        left[s.energy, s.energy] = 0.0
        stable = float(np.linalg.eigvalsh(hessian).min()) > 0.0
        left[np.ix_(s.energy, s.coenergy)] = hessian if stable else np.eye(s.energy.size)
    return sp.csr_array(left)[kept], right


def small_motions(system: System) -> System:
    """Drop the products of states and hold all angles; see :meth:`System.small_motions`.

    Parameters
    ----------
    system : System
        The system.

    Returns
    -------
    System
        With constant matrices and the same names.

    Raises
    ------
    StructureError
        If the energy is not quadratic.
    """
    require_quadratic(system, "small motions")
    phi = system.features(system.start.theta, system.start.x)
    a, b, g = system.kinematics.indices
    spans = Triplets((a, b, np.zeros_like(g)), system.kinematics.values * phi[g])
    i, f = system.K_g.indices
    weight = Triplets((i, np.zeros_like(f)), system.K_g.values * phi[f])
    a, b, g = system.connections.entries.indices
    flows = Triplets((a, b, np.zeros_like(g)), system.connections.entries.values * phi[g])
    a, b, g = system.connections.supply.indices
    supply = Triplets((a, b, np.zeros_like(g)), system.connections.supply.values * phi[g])
    fixed = system.point_angles.at(system.start.theta)
    return replace(
        system,
        J0=system.J(system.start.x),
        T=sp.coo_array(system.T.shape),
        G0=system.G(),
        K=Triplets.empty(3),
        K_u=Triplets.empty(3),
        kinematics=spans,
        K_g=weight,
        angles=Angles(sp.csr_array((0, system.start.theta.size)), np.empty(0)),
        lines=replace(
            system.lines, line=system.lines.line[:0], frames=Angles(system.lines.frames.rows[:0], np.empty(0))
        ),
        connections=replace(
            system.connections,
            entries=flows,
            supply=supply,
            exchange=system.connections.exchange.held(system.lines, system.start.theta, system.start.x),
        ),
        point_angles=Angles(sp.csr_array(system.point_angles.rows.shape), fixed),
        remake=None,
    )


def _kappa(system: System, x: Floats, u: Floats) -> sp.csr_array:
    """K x + K_g + K_u u, shape (n, n_features)."""
    moving = Triplets.join([system.K, system.kinematics], order=3)
    i, j, f = moving.indices
    k, m, g = system.K_u.indices
    parts = [
        Triplets((i, f), moving.values * x[j]),
        system.K_g,
        Triplets((k, g), system.K_u.values * u[m]),
    ]
    return Triplets.join(parts).csr((system.n, system.n_features))


def _slopes(system: System, theta: Floats, x: Floats) -> tuple[sp.csr_array, sp.csr_array]:
    """Derivatives of all features with respect to theta and to x."""
    lines = system.lines
    e = lines.directions(theta, x)
    first, second = np.split(e, 2)
    turned = sp.vstack([sp.diags_array(second) @ lines.frames.rows, -sp.diags_array(first) @ lines.frames.rows])
    by_theta = sp.vstack([system.angles.slopes(theta), turned])
    n_other = system.n_features - e.size
    return sp.csr_array(by_theta), sp.csr_array(
        sp.vstack([sp.csr_array((n_other, system.n)), _span_slopes(system, theta, x)])
    )


def _span_slopes(system: System, theta: Floats, x: Floats) -> sp.csr_array:
    """Derivatives of the directions with respect to the states, shape (2 n_directions, n)."""
    lines, count = system.lines, system.lines.count
    length, e = lines.lengths(x)[lines.line], lines.directions(theta, x).reshape(2, count)
    alpha, d = lines.frames.at(theta), np.arange(count)
    lam = np.array([[np.cos(alpha), np.sin(alpha)], [-np.sin(alpha), np.cos(alpha)]])  # Lambda^T
    unit = x[lines.spans[lines.line]].T / length
    loose = ~lines.taut[lines.line]
    parts = [
        Triplets.of(b * count + d, lines.spans[lines.line, a], values=(lam[b, a] - loose * e[b] * unit[a]) / length)
        for b in range(2)
        for a in range(2)
    ]
    stretch = lines.stretch[lines.line].tocoo()
    row, column = (np.asarray(c, dtype=np.int64) for c in stretch.coords)
    parts += [
        Triplets.of(b * count + row, column, values=-(stretch.data * (e[b] / length * ~loose)[row])) for b in range(2)
    ]
    return Triplets.join(parts).csr((2 * count, system.n))


def _output_slopes(system: System, x: Floats) -> sp.csr_array:
    """x^T K_u, shape (n_inputs, n_features)."""
    i, m, f = system.K_u.indices
    return Triplets((m, f), system.K_u.values * x[i]).csr((system.n_inputs, system.n_features))
