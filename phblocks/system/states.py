"""States given by users: starts that move, and checks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.system.parts import State
from phblocks.triplets import Floats, real_array

if TYPE_CHECKING:
    from phblocks.system.system import System


def rigid_motion(
    system: System,
    velocity: ArrayLike | None,
    spin: ArrayLike | None,
    about: ArrayLike | None,
    blocks: Sequence[str] | None,
) -> State:
    """Make a start that moves as a rigid body; see :meth:`System.rigid_motion`.

    Parameters
    ----------
    system : System
        The system.
    velocity : array_like or None
        Of the point ``about``, shape (dimension,), m/s, in the fixed frame; zero if ``None``.
    spin : array_like or None
        Angular velocity, rad/s, shape () in the plane and (3,) in space; zero if ``None``.
    about : array_like or None
        A point, shape (dimension,), m; the origin if ``None``.
    blocks : sequence of str or None
        Names of the blocks that move; all if ``None``.

    Returns
    -------
    State
        For ``simulate(..., start=...)``.

    Raises
    ------
    DataError
        If a value is not finite or has the wrong shape.
    ArgumentTypeError
        If an argument is of the wrong kind.
    UnknownNameError
        If there is no such block.
    PrunedError
        If it moves what is left out (``system.effects``).
    """
    v, c, w = (
        np.zeros(shape) if value is None else _require(f"rigid_motion {name}", value, shape)
        for name, value, shape in (
            ("velocity", velocity, (system.dimension,)),
            ("about", about, (system.dimension,)),
            ("spin", spin, (3,) if system.space.turns("rotation") else ()),
        )
    )
    if blocks is not None and (isinstance(blocks, str) or not isinstance(blocks, Sequence)):
        raise ArgumentTypeError(
            "rigid_motion blocks", expected="a sequence of names", got=repr(blocks), fix='Write for instance ["crank"].'
        )
    x = system.sharing.expand(system.start.x).copy()
    for part in system.parts if blocks is None else [system.part(name) for name in blocks]:
        x[part.states] += part.form.moving(v, w, c)
    states = system.pruning.restricted(system, x[system.pruning.coordinates], "rigid_motion")
    return State(states, system.start.theta, system.start.points)


def _require(where: str, value: object, shape: tuple[int, ...]) -> Floats:
    array = real_array(value)
    if array is None:
        raise ArgumentTypeError(where, expected="numbers", got=repr(value), fix="Give numbers in SI units.")
    if array.shape != shape or not np.isfinite(array).all():
        raise DataError(where, expected=f"finite numbers of shape {shape}", got=repr(array.tolist()), fix="Correct it.")
    return array


def require_state(system: System, state: State, where: str) -> State:
    """Return a state if it fits a system.

    Parameters
    ----------
    system : System
        The system.
    state : State
        The candidate.
    where : str
        What it is, for the message.

    Returns
    -------
    State
        With arrays of floats.

    Raises
    ------
    ArgumentTypeError
        If it is not a state, or not of numbers.
    DataError
        If an array has the wrong shape, or a value or the energy is not finite.
    PrunedError
        If it moves what the system leaves out.
    """
    if not isinstance(state, State):
        raise ArgumentTypeError(where, expected="a State", got=type(state).__name__, fix="Make a ph.State.")
    arrays = []
    pruning = system.pruning
    for name, whole in (("x", pruning.states), ("theta", pruning.rotations), ("points", None)):
        given, shape = getattr(state, name), getattr(system.start, name).shape
        value = real_array(given)
        if whole is not None and value is not None and value.shape == whole.shape and whole.shape != shape:
            shape = whole.shape  # those of the system with nothing left out
        if value is None:
            raise ArgumentTypeError(
                f"{where}.{name}",
                expected=f"numbers of shape {shape}",
                got=type(given).__name__,
                fix="Start from system.start and change what differs.",
            )
        if value.shape != shape or not np.isfinite(value).all():
            raise DataError(
                f"{where}.{name}",
                expected=f"finite numbers of shape {shape}",
                got=f"shape {value.shape}" if value.shape != shape else "numbers that are not finite",
                fix="Start from system.start and change what differs.",
            )
        arrays.append(value)
    x, theta, points = arrays
    if x.size != system.n:
        x = pruning.restricted(system, x, where)
    if theta.size != system.start.theta.size:
        theta = pruning.turned(theta, where)
    pruning.require_held(system, x, where)
    with np.errstate(all="ignore"):
        energy = x @ (system.E @ x)
    if not np.isfinite(energy):
        raise DataError(
            f"{where}.x",
            expected="a state with a finite energy",
            got="one whose energy is too large for floating-point numbers",
            fix="Correct its largest value.",
        )
    return State(x, theta, points)


def require_input(system: System, u: object, where: str) -> Floats:
    """Return a vector of inputs if it fits a system.

    Parameters
    ----------
    system : System
        The system.
    u : object
        The candidate.
    where : str
        What it is, for the message.

    Returns
    -------
    numpy.ndarray
        Shape (n_inputs,).

    Raises
    ------
    ArgumentTypeError
        If it is not made of numbers.
    DataError
        If it has the wrong shape or a value is not finite.
    PrunedError
        If an input is not zero that was taken to be.
    """
    values = _require(where, u, (system.n_inputs,))
    system.pruning.require_quiet(system, values, where)
    return values
