"""Loads distributed over the length of a beam."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from phblocks.blocks.checks import require_flag
from phblocks.blocks.form import FIXED, AngleRows, MaterialPoints, Piece
from phblocks.blocks.sources import Signal
from phblocks.errors import ArgumentTypeError, DataError, DuplicateNameError, SpaceError
from phblocks.ports import Domain, Quantity
from phblocks.space import Space
from phblocks.triplets import Floats, Ints, Triplets, real_array

#: What a line load and the beam exchange: the answer is the velocity integrated over the length.
LINE = Domain("line load", Quantity("velocity times length", "m^2/s"), Quantity("line load", "N/m"), "translation")


@dataclass(frozen=True, eq=False)
class LineLoad:
    """A force per length, the same all along a beam; its energy stands under its name in ``solution.power.inputs``.

    A signal given to ``simulate(inputs={name: ...})`` replaces that of the load.

    Parameters
    ----------
    name : str
        Unique in the diagram among loads, sources and exposed ports.
    force : array_like or callable
        (x, y), N/m, in space (x, y, z), or a function of time, s, that returns it; per initial length.
    follows : bool, optional
        The components are along and across the cross sections and turn with them (a follower load such as a
        pressure); by default they are in the fixed frame (a dead load such as weight).

    Raises
    ------
    DataError
        If the name is empty or has dots, or a constant has the wrong shape or is not finite.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    name: str
    force: Signal
    follows: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise ArgumentTypeError("name of a LineLoad", expected="a text", got=repr(self.name), fix="Choose a name.")
        if not self.name or "." in self.name:
            raise DataError(
                "name of a LineLoad",
                expected="a non-empty text without dots",
                got=repr(self.name),
                fix="Choose another.",
            )
        require_flag(f"LineLoad {self.name!r} follows", self.follows)
        if callable(self.force):
            return
        where, expected = f"LineLoad {self.name!r}", "two numbers (in space three), or a function of time"
        array = real_array(self.force)
        if array is None:
            raise ArgumentTypeError(where, expected=expected, got=repr(self.force), fix="Give N/m.")
        if array.shape not in ((2,), (3,)) or not np.isfinite(array).all():
            raise DataError(where, expected=expected, got=repr(self.force), fix="Give finite numbers, N/m.")
        object.__setattr__(self, "force", array)


def require_loads(where: str, loads: object, space: Space) -> tuple[LineLoad, ...]:
    """Return loads if they are loads of different names.

    Parameters
    ----------
    where : str
        For messages.
    loads : object
        One load or a sequence of them.
    space : Space
        Of the beam.

    Returns
    -------
    tuple of LineLoad
        The loads.

    Raises
    ------
    ArgumentTypeError
        If they are something else.
    DuplicateNameError
        If two have the same name.
    SpaceError
        If a constant has the components of another space.
    """
    several = (loads,) if isinstance(loads, LineLoad) else loads
    if not isinstance(several, (tuple, list)) or not all(isinstance(load, LineLoad) for load in several):
        raise ArgumentTypeError(
            where,
            expected="a LineLoad or several",
            got=repr(loads),
            fix='Write for instance loads=ph.LineLoad("snow", (0.0, -500.0)).',
        )
    names = [load.name for load in several]
    if len(set(names)) < len(names):
        raise DuplicateNameError(where, expected="names of their own", got=repr(names), fix="Choose other names.")
    for load in several:
        if not callable(load.force) and np.size(load.force) != space.dimension:
            raise SpaceError(
                f"{where} {load.name!r}",
                expected=f"{space.dimension} components on a {space.name} beam",
                got=str(np.size(load.force)),
                fix="Give a component for each coordinate of the ends.",
            )
    return tuple(several)


def load_pieces(load: LineLoad, points: MaterialPoints, lengths: Floats) -> Sequence[Piece]:
    """Say how a load enters the state equations: the velocity of each point times the length it stands for.

    Parameters
    ----------
    load : LineLoad
        The load.
    points : MaterialPoints
        Where it acts: the same points, in the same frames, as gravity.
    lengths : numpy.ndarray
        Length that each point stands for, shape (points,), m.

    Returns
    -------
    sequence of Piece
        One for each point, in its frame; of a follower load, which needs no rotation, one for all of them.
    """
    d = points.start.shape[1]
    row, state = points.velocity.indices
    point, component = row // d, row % d
    values = points.velocity.values * lengths[point]
    if load.follows:
        together = Triplets.of(component, state, values=values).csr((d, int(state.max()) + 1)).tocoo()
        return (Piece(Triplets.from_coo(together), FIXED),)
    angle_point, theta = points.angle.rows.indices
    n = points.angle.reference.size
    pieces = []
    for reference, here, turning in zip(points.angle.reference, _by(point, n), _by(angle_point, n), strict=True):
        rows = Triplets.of(0, theta[turning], values=points.angle.rows.values[turning])
        frame = AngleRows(rows, np.array([reference]))
        pieces.append(Piece(Triplets((component[here], state[here]), values[here]), frame))
    return tuple(pieces)


def _by(numbers: Ints, n: int) -> Sequence[Ints]:
    """Places of the entries of each number from 0 to n - 1."""
    order = np.argsort(numbers, kind="stable")
    return np.split(order, np.searchsorted(numbers[order], np.arange(1, n)))
