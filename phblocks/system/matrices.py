"""A system at a state as plain matrices with names, for users and for the writers of files."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from phblocks.errors import StructureError
from phblocks.export import Matrices, Tangent
from phblocks.system.energy_form import in_energy_variables
from phblocks.system.linearization import coenergy_free, followed
from phblocks.system.parts import State
from phblocks.triplets import Floats, Triplets

if TYPE_CHECKING:
    from phblocks.system.system import System


def matrices_at(system: System, state: State | None = None, u: Floats | None = None) -> Matrices:
    """Evaluate all matrices at a state, and the tangent there; see :meth:`System.matrices`.

    Parameters
    ----------
    system : System
        The system.
    state : State, optional
        The initial configuration at rest by default.
    u : numpy.ndarray, optional
        Inputs there, shape (n_inputs,); zero by default. They enter the tangent only.

    Returns
    -------
    Matrices
        With names, units and a description of the state.

    Raises
    ------
    StructureError
        If the Hessian of an energy that is not quadratic is not positive semidefinite at the state.
    """
    linear = system.linearize(state, u)
    about = "the initial configuration, at rest" if state is None else "a state given by the user"
    at = system.start if state is None else state
    x = followed(system, at, np.zeros(system.n_inputs) if u is None else u)
    kept, rows, right = coenergy_free(system, x, linear.E.shape[0])
    x0, hessians, note = _second_order(system, x)
    names = (*system.state_names, *(system.theta_names[i] for i in linear.theta))
    units = system.state_units + ("rad",) * linear.theta.size
    own = kept < system.n
    states, equations = kept[own], rows[own]
    rated = [Triplets.of(s.coenergy, s.energy, values=1.0) for s in system.storages]
    E = sp.csr_array(system.E + Triplets.join(rated).csr(system.E.shape))
    return Matrices(
        name=system.name,
        about=about + note,
        E=E[equations][:, states],
        J=system.J(x, at.theta)[equations][:, equations],
        R=system.R_at(x)[equations][:, equations],
        Q=hessians[states][:, states],
        G=system.G(at.theta, x)[equations][:, linear.inputs],
        x0=x0[states],
        f0=system.gravity_force(at.theta)[equations],
        state_names=tuple(system.state_names[i] for i in states),
        state_units=tuple(system.state_units[i] for i in states),
        state_positions=system.state_positions[states],
        input_names=tuple(system.input_names[i] for i in linear.inputs),
        input_units=tuple(system.inputs[i].imposed.unit for i in linear.inputs),
        output_names=tuple(system.output_names[i] for i in linear.inputs),
        output_units=tuple(system.inputs[i].answered.unit for i in linear.inputs),
        tangent=Tangent(
            A=linear.A[rows] @ right,
            B=linear.B[rows],
            C=linear.C @ right,
            D=linear.D,
            E=linear.E[rows] @ right,
            state_names=tuple(names[i] for i in kept),
            state_units=tuple(units[i] for i in kept),
        ),
    )


def energy_form(system: System, matrices: Matrices) -> Matrices:
    """Write matrices of a system in energy variables, with names and units.

    Parameters
    ----------
    system : System
        The system.
    matrices : Matrices
        What :func:`matrices_at` found.

    Returns
    -------
    Matrices
        With E = 1. Energy variables of the user's own keep their names; ``E x`` of a state x in m/s is in J/(m/s).

    Raises
    ------
    StructureError
        If states without energy do not follow from the others.
    """
    own = {system.state_names[i] for s in system.storages for i in s.energy}
    names = [x if x in own else f"E {x}" for x in matrices.state_names]
    units = [
        unit if x in own else f"J/{unit}" if unit.isalpha() else f"J/({unit})"
        for x, unit in zip(matrices.state_names, matrices.state_units, strict=True)
    ]
    return in_energy_variables(matrices, names, units)


def _second_order(system: System, x: Floats) -> tuple[Floats, sp.csr_array, str]:
    """States at which ``Q x`` are the co-energy variables, Q, and what to say about them."""
    Q, x, notes = sp.eye_array(system.n, format="lil"), x.copy(), []
    names = [p.name for p in system.parts if p.form.storage is not None]
    for name, s in zip(names, system.storages, strict=True):
        at, gradient, hessian = x[s.energy], x[s.coenergy], np.asarray(s.hessian(x[s.energy]))
        scaled = hessian * np.outer(s.size, s.size)
        least, size = float(np.linalg.eigvalsh(scaled).min()), float(np.abs(scaled).max())
        shifted = s.size * np.linalg.lstsq(scaled, s.size * gradient, rcond=1e-12)[0]
        miss = np.abs(s.size * (hessian @ shifted - gradient)).max()
        if least < -1e-12 * size or miss > 1e-9 * np.abs(s.size * gradient).max():
            raise StructureError(
                f"matrices of {name!r} at x = {at.tolist()}",
                expected="an energy with a minimum to second order: a positive semidefinite Hessian that makes the "
                "gradient",
                got=f"the smallest eigenvalue {least:.3g}, in units where the energy is of order one",
                fix="Choose another state, or use linearize().",
            )
        Q[np.ix_(s.energy, s.energy)], x[s.energy] = (hessian + hessian.T) / 2.0, shifted
        notes.append(
            f"; the energy of {name!r} to second order about its x = {at.tolist()}, with states shifted to Q^-1 grad H "
            f"there, by {(shifted - at).tolist()}"
        )
    return x, sp.csr_array(Q), "".join(notes)
