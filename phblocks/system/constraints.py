"""Constraints between states: multipliers and loops that the states without energy imply.

With a for the states without energy and e for the others, rows a of the equations are ``0 = A_aa x_a + A_ae x_e +
G_a u``, where ``A = J - R``. Every vector n with ``n^T A_aa = 0`` leaves a constraint ``n^T (A_ae x_e + G_a u) = 0``
that the states with energy must satisfy from the start, and a multiplier that only its rate determines (index 2).
If there is no such vector the states without energy follow from the others (index 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, onenormest, splu

from phblocks.errors import ConstraintError
from phblocks.system.parts import State
from phblocks.system.scaling import state_scale
from phblocks.system.undetermined import made_by, require_determined
from phblocks.triplets import Floats, Triplets

if TYPE_CHECKING:
    from phblocks.system.system import System

#: What is smaller than this, relative to the largest, counts as zero in a rank.
RANK = 1e-10
#: Groups of more states without energy than this are first tried by a sparse factorisation.
LARGE = 60
#: Iterations of Newton's method when a start is projected whose energy is not quadratic.
MOST_PROJECTIONS = 50
#: A start that violates the constraints by less than this, relative, is left as it is.
CONSISTENT = 1e-13


@dataclass(frozen=True)
class Constraints:
    """The constraints at a state, ``rows x + N^T (gravity + G u) = 0``, in scaled states.

    Parameters
    ----------
    names : tuple of str
        For each constraint the state without energy that it is the row of, or that weighs most in it.
    rows : scipy.sparse.csr_array
        Shape (constraints, n), each of length one; they act on ``x / scale``.
    left : scipy.sparse.csr_array
        N^T, shape (constraints, n): what combines the equations of the states without energy.
    scale : numpy.ndarray
        Shape (n,), the size of each state.
    """

    names: tuple[str, ...]
    rows: sp.csr_array
    left: sp.csr_array
    scale: Floats


def find_constraints(system: System, state: State | None = None) -> Constraints:
    """Find the constraints at a state.

    Parameters
    ----------
    system : System
        The system.
    state : State, optional
        The initial configuration by default.

    Returns
    -------
    Constraints
        Those that hold nothing have a row of zeros.
    """
    at = system.start if state is None else state
    n, scale = system.n, state_scale(system)
    free = np.flatnonzero(system.algebraic & ~system.coenergy)
    units = sp.diags_array(scale)
    A = sp.csr_array(units @ (system.J(at.x, at.theta) - system.R_at(at.x)) @ units)
    among = sp.csr_array(A[free][:, free])
    among.eliminate_zeros()
    count, label = connected_components(among, directed=False)
    coupled = sp.csr_array((A @ sp.diags_array((system.carries_energy | system.coenergy).astype(float)))[free])
    left: list[Triplets] = []
    names: list[str] = []
    members: list[list[int]] = [[] for _ in range(count)]
    for i, group in enumerate(label):
        members[group].append(i)
    for group in members:
        block = among[group][:, group]
        if len(group) == 1:
            null = np.ones((1, 1)) if block.nnz == 0 else np.empty((1, 0))
        elif len(group) > LARGE and _regular(block):
            null = np.empty((len(group), 0))
        else:
            # each column of u beyond the rank combines the rows to zero
            u, size, _ = np.linalg.svd(block.toarray())
            null = _sorted(u[:, int((size > RANK * size[0]).sum()) :], coupled[group])
        for vector in null.T:
            left.append(Triplets.of(len(left), free[group], values=vector))
            names.append(system.state_names[free[group[int(np.abs(vector).argmax())]]])
    combine = Triplets.join(left).csr((len(left), n))
    rows = sp.csr_array(combine @ A @ sp.diags_array((system.carries_energy | system.coenergy).astype(float)))
    length = np.sqrt(np.asarray(rows.multiply(rows).sum(axis=1)).ravel())
    length[length <= RANK] = 0.0
    rows = sp.csr_array(sp.diags_array((length > 0.0).astype(float)) @ rows)
    unit = sp.diags_array(1.0 / np.where(length > 0.0, length, 1.0))
    return Constraints(tuple(names), sp.csr_array(unit @ rows), sp.csr_array(unit @ combine @ units), scale)


def _regular(block: sp.csr_array) -> bool:
    """Tell whether a sparse matrix has its full rank for sure, by an estimate of its condition."""
    try:
        factor = splu(sp.csc_array(block))
    except RuntimeError:
        return False
    inverse = LinearOperator(block.shape, factor.solve, lambda b: factor.solve(b, trans="T"), dtype=np.float64)
    return bool(onenormest(inverse) * abs(block).sum(axis=0).max() < 1e-3 / RANK)


def _sorted(null: Floats, coupled: sp.csr_array) -> Floats:
    """Turn vectors so that those that combine to nothing stand by themselves, if there are any."""
    used = np.unique(coupled.indices)
    rows = null.T @ coupled[:, used].toarray()
    if null.shape[1] < 2 or not used.size:
        return null
    turn, size, _ = np.linalg.svd(rows)
    return null if (size > RANK).sum() == null.shape[1] else np.asarray(null @ turn)


def require_independent(system: System, constraints: Constraints) -> None:
    """Check that no constraint follows from the others, and that none holds nothing.

    This is the rank at one state, the initial one. Joints that become redundant only away from there (a parallelogram
    that folds flat, a slider and a bar in line) cannot be seen here.

    Parameters
    ----------
    system : System
        The system, for the message.
    constraints : Constraints
        Of it.

    Raises
    ------
    ConstraintError
        Naming a constraint that is redundant and those it follows from.
    UndeterminedError
        Where a constraint holds nothing: what it would hold is not determined.
    """
    if not constraints.names:
        return
    require_determined(system, constraints)
    from scipy.linalg import qr, solve_triangular

    used = np.unique(constraints.rows.indices)
    matrix = constraints.rows[:, used].toarray().T
    upper, order = qr(matrix, mode="r", pivoting=True)
    diagonal = np.abs(np.diag(upper))
    rank = int((diagonal > RANK).sum())
    if rank == len(constraints.names):
        return
    name = constraints.names[order[rank]]
    weight = solve_triangular(upper[:rank, :rank], upper[:rank, rank])
    others = [constraints.names[order[i]] for i in np.flatnonzero(np.abs(weight) > 1e-6)]
    block = next(part.name for part in system.parts if name.startswith(f"{part.name}."))
    raise ConstraintError(
        f"{name}{made_by(system, block)} of system {system.name!r}",
        expected="constraints that do not follow from each other",
        got=f"one that {' and '.join(others)} imply already",
        fix="Take one of these joints away, or let it turn or slide.",
    )


def consistent_start(system: System, state: State, u: Floats) -> tuple[State, float]:
    """Project a start on the constraints in the energy norm: the least ``|x - x0|_E`` that satisfies them.

    Energy variables whose energy is not quadratic change as by impulses of the joints: ``x0 - N^T p`` with the p for
    which the constraints N on ``grad H`` hold.

    Parameters
    ----------
    system : System
        The system.
    state : State
        The start as given.
    u : numpy.ndarray
        Inputs at the start, shape (n_inputs,).

    Returns
    -------
    state : State
        The same object if it satisfies the constraints already.
    change : float
        Stored energy after less before, J.

    Raises
    ------
    ConstraintError
        If the start violates a constraint on states whose energy is not quadratic, and no impulses help.
    """
    found = find_constraints(system, state)
    if not found.names:
        return state, 0.0
    carries = system.carries_energy
    x = np.where(carries | system.coenergy, state.x, 0.0)
    outside = found.left @ (system.gravity_force(state.theta) + system.G(state.theta) @ u)
    scaled = x / found.scale
    defect = found.rows @ scaled + outside
    if np.abs(defect).max() <= CONSISTENT * (np.linalg.norm(scaled) + np.abs(outside).max()):
        return state, 0.0
    reach, before = _impulses(system, found), system.settled(state.x)
    if (abs(found.rows) @ system.coenergy.astype(float) > RANK).any():
        new = _settled_on(system, found, before, outside, reach)
    else:
        new = before + reach @ _multipliers(found.rows @ (reach / found.scale[:, None]), defect)
    return State(new, state.theta, state.points), system.energy(new) - system.energy(state.x)


def _impulses(system: System, constraints: Constraints) -> Floats:
    """What a unit of each multiplier does to the states in no time, shape (n, constraints)."""
    reach, used = np.zeros((system.n, len(constraints.names))), np.flatnonzero(system.carries_energy)
    units = sp.diags_array(constraints.scale[used])
    if used.size:
        factor = splu(sp.csc_array(units @ system.E[used][:, used] @ units))
        reach[used] = -(units @ factor.solve(constraints.rows[:, used].T.toarray()))
    for s in system.storages:
        reach[s.energy] = -(constraints.rows[:, s.coenergy].toarray() / constraints.scale[s.coenergy]).T
    return reach


def _multipliers(response: Floats, defect: Floats) -> Floats:
    """What takes a defect away, where the response to the multipliers is linear."""
    return np.asarray(np.linalg.lstsq(response, -defect, rcond=RANK)[0])


def _settled_on(system: System, constraints: Constraints, start: Floats, outside: Floats, reach: Floats) -> Floats:
    """Project with energies that are not quadratic: Newton's method for the multipliers, damped where need be.

    The states change as by impulses of the joints, which takes the least energy that impulses lead to: where the
    energy is quadratic, that is the least change in the energy norm.
    """
    rows, total, x = constraints.rows, np.zeros(len(constraints.names)), start
    defect = rows @ (x / constraints.scale) + outside
    for _ in range(MOST_PROJECTIONS):
        change = reach.copy()
        for s in system.storages:
            change[s.coenergy] = s.hessian(x[s.energy]) @ reach[s.energy]
        step, factor = _multipliers(rows @ (change / constraints.scale[:, None]), defect), 1.0
        while factor > 1e-6:
            new = system.settled(start + reach @ (total + factor * step))
            left = rows @ (new / constraints.scale) + outside
            if np.linalg.norm(left) < np.linalg.norm(defect):
                break
            factor /= 2.0
        else:
            break
        total, x, defect = total + factor * step, new, left
    after = State(x, system.start.theta, system.start.points)
    size = (abs(rows) @ np.abs(x / constraints.scale)).max() + np.abs(outside).max()
    # a G that depends on the state changes the constraints on the way
    moved = abs(find_constraints(system, after).rows - rows).max() if system.modulations else 0.0
    if not (np.abs(defect).max() <= 1e3 * CONSISTENT * size and moved <= RANK):
        name = constraints.names[int(np.abs(defect).argmax())]
        raise ConstraintError(
            f"start of system {system.name!r}",
            expected="a start that satisfies the constraints, or from where impulses of the joints lead to one",
            got=f"one that violates {name}, where a custom block takes part, and no impulses found",
            fix="Give a start that satisfies it.",
        )
    return x
