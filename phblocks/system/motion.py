"""Starts that move."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from phblocks.errors import DataError
from phblocks.system.parts import State

if TYPE_CHECKING:
    from phblocks.system.system import System


def rigid_motion(
    system: System, velocity: ArrayLike, spin: float, about: ArrayLike, blocks: Sequence[str] | None
) -> State:
    """Make a start that moves as a rigid body; see :meth:`System.rigid_motion`.

    Parameters
    ----------
    system : System
        The system.
    velocity : array_like
        Of the point ``about``, shape (dimension,), m/s, in the fixed frame.
    spin : float
        Angular velocity, rad/s.
    about : array_like
        A point, shape (dimension,), m.
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
    UnknownNameError
        If there is no such block.
    """
    v, c = (np.array(a, dtype=np.float64) for a in (velocity, about))
    for name, value, shape in (
        ("velocity", v, (system.dimension,)),
        ("about", c, (system.dimension,)),
        ("spin", np.asarray(spin), ()),
    ):
        if value.shape != shape or not np.isfinite(value).all():
            raise DataError(
                f"rigid_motion {name}",
                expected=f"finite numbers of shape {shape}",
                got=repr(value.tolist()),
                fix="Correct it.",
            )
    x = system.start.x.copy()
    for part in system.parts if blocks is None else [system.part(name) for name in blocks]:
        x[part.states] = part.form.moving(v, float(spin), c)
    return State(x, system.start.theta, system.start.points)
