"""A system at a state as plain matrices with names, for the writers of files."""

from __future__ import annotations

from typing import TYPE_CHECKING

from phblocks.export import Matrices, Tangent
from phblocks.system.parts import State
from phblocks.triplets import Floats

if TYPE_CHECKING:
    from phblocks.system.system import System


def matrices_at(system: System, state: State | None = None, u: Floats | None = None) -> Matrices:
    """Evaluate all matrices at a state, and the tangent there.

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
    """
    linear = system.linearize(state, u)
    turned = tuple(system.theta_names[i] for i in linear.theta)
    about = "the initial configuration, at rest" if state is None else "a state given by the user"
    at = system.start if state is None else state
    return Matrices(
        name=system.name,
        about=about,
        E=system.E,
        J=system.J(at.x, at.theta),
        R=system.R,
        Q=system.Q,
        G=system.G(at.theta, at.x),
        x0=at.x,
        f0=system.gravity_force(at.theta),
        state_names=system.state_names,
        state_units=system.state_units,
        state_positions=system.state_positions,
        input_names=system.input_names,
        input_units=tuple(i.imposed.unit for i in system.inputs),
        output_names=system.output_names,
        output_units=tuple(i.answered.unit for i in system.inputs),
        tangent=Tangent(
            A=linear.A,
            B=linear.B,
            C=linear.C,
            D=linear.D,
            E=linear.E,
            state_names=system.state_names + turned,
            state_units=system.state_units + ("rad",) * len(turned),
        ),
    )
