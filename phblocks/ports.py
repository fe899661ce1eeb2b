"""Ports: where a block exchanges power, and with which pair of quantities.

The product of the two quantities of a domain is a power.  At a junction the *common* one (a velocity) is the
same on all ports and the *summed* one (a force) adds up to zero.  A port **gives** one of the two and **takes**
the other.  Power counts as positive into the block: force on the block times velocity of the block.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NoReturn

from numpy.typing import ArrayLike

from phblocks.errors import ArgumentTypeError, DataError, UnknownNameError
from phblocks.space import Space
from phblocks.triplets import Floats

if TYPE_CHECKING:
    from phblocks.blocks.block import Block


#: A place on a block: a fraction of the length of a beam, coordinates in the frame of a rigid body.
Place = float | tuple[float, ...]


@dataclass(frozen=True)
class Quantity:
    """A physical quantity.

    Parameters
    ----------
    name : str
        As in messages and tables.
    unit : str
        SI unit.

    Raises
    ------
    ArgumentTypeError
        If one of them is not a text.
    """

    name: str
    unit: str

    def __post_init__(self) -> None:
        """Check the kinds of the arguments."""
        _require_kind("Quantity", str, "texts", self.name, self.unit)


@dataclass(frozen=True)
class Domain:
    """A pair of quantities whose product is a power in watt.

    Parameters
    ----------
    name : str
        As in messages and tables.
    common : Quantity
        The one that all ports of a junction share (velocity, angular velocity, voltage).
    summed : Quantity
        The one that adds up to zero over a junction (force, moment, current).
    turns_with : {"translation", "rotation"} or None
        Which components of space the values are; ``None`` for scalars, which no rotation touches.

    Raises
    ------
    ArgumentTypeError
        If the name is not a text or one of the two not a quantity.
    DataError
        If ``turns_with`` is something else.
    """

    name: str
    common: Quantity
    summed: Quantity
    turns_with: str | None = None

    def __post_init__(self) -> None:
        """Check the kinds of the arguments."""
        _require_kind("Domain name", str, "a text", self.name)
        _require_kind(f"Domain {self.name!r}", Quantity, "a Quantity for each of both sides", self.common, self.summed)
        if self.turns_with not in (None, "translation", "rotation"):
            raise DataError(
                f"Domain {self.name!r} turns_with",
                expected='"translation", "rotation" or None',
                got=repr(self.turns_with),
                fix="Leave it out for scalars.",
            )

    def components(self, space: Space) -> tuple[int, ...]:
        """Return the components that a port of this domain has.

        Parameters
        ----------
        space : Space
            The components of the model.

        Returns
        -------
        tuple of int
            Indices of directions; ``(0,)`` for a scalar.
        """
        if self.turns_with is None:
            return (0,)
        return space.translation if self.turns_with == "translation" else space.rotation


def _require_kind(where: str, kind: type, expected: str, *values: object) -> None:
    for value in values:
        if not isinstance(value, kind):
            raise ArgumentTypeError(where, expected=expected, got=repr(value)[:60], fix="Correct it.")


TRANSLATION = Domain("translation", Quantity("velocity", "m/s"), Quantity("force", "N"), "translation")
ROTATION = Domain("rotation", Quantity("angular velocity", "rad/s"), Quantity("moment", "N m"), "rotation")
ELECTRICAL = Domain("electrical", Quantity("voltage", "V"), Quantity("current", "A"))
HYDRAULIC = Domain("hydraulic", Quantity("pressure", "Pa"), Quantity("volume flow", "m^3/s"))


@dataclass(frozen=True, eq=False)
class Port:
    """One place where a block exchanges power.

    Parameters
    ----------
    block : Block
        The owner.
    name : str
        Unique in the block, such as ``"start.translation"``.
    domain : Domain
        The pair of quantities.
    anchor : Anchor or None
        The place on the block that the port belongs to, for mechanical ports.
    """

    block: Block
    name: str
    domain: Domain
    anchor: Anchor | None = None

    @property
    def path(self) -> str:
        """Block and port, as in messages: ``"crank.start.translation"``."""
        return f"{self.block.name}.{self.name}"

    def __repr__(self) -> str:
        """Return the path and the pair of quantities."""
        return f"<{self.path}: {self.domain.summed.name}/{self.domain.common.name}>"


class Ports(dict[str, Port]):
    """Ports of a block by name.

    Parameters
    ----------
    block : str
        Name of the block, for messages.
    ports : iterable of Port
        Its ports.

    Raises
    ------
    UnknownNameError
        On look-up of a port that the block does not have.
    """

    def __init__(self, block: str, ports: Iterable[Port]) -> None:
        super().__init__({port.name: port for port in ports})
        self.block = block

    def __missing__(self, name: object) -> NoReturn:
        raise UnknownNameError(
            f"block {self.block!r}",
            expected=f"one of its ports {', '.join(self) or '(there are none)'}",
            got=repr(name),
            fix="Check the name.",
        )


@dataclass(frozen=True, eq=False)
class Anchor:
    """A place on a block with its mechanical ports.

    Parameters
    ----------
    block : Block
        The owner.
    name : str
        Unique in the block, such as ``"start"``.
    position : numpy.ndarray or None
        Initial place, shape (dimension,), m; ``None`` if it is wherever it is needed (the ground).
    angle : float
        Initial orientation of the material frame in the plane, rad.
    place : Place
        Where on the block, in the coordinate by which its read-outs know places (a beam: fraction of length; a rigid
        body: coordinates in its frame).
    turns : bool
        It has an orientation: a port of rotation beside that of translation.
    frame : numpy.ndarray or None
        Initial orientation of the material frame in space, its axes as columns, shape (3, 3); ``None`` in the plane.

    Attributes
    ----------
    translation : Port
        Force and velocity.
    rotation : Port
        Moment and angular velocity.
    """

    block: Block
    name: str
    position: Floats | None
    angle: float = 0.0
    place: Place = 0.0
    turns: bool = True
    frame: Floats | None = None
    translation: Port = field(init=False)
    rotation: Port = field(init=False)

    def __post_init__(self) -> None:
        """Make the two ports."""
        object.__setattr__(self, "translation", Port(self.block, f"{self.name}.translation", TRANSLATION, self))
        object.__setattr__(self, "rotation", Port(self.block, f"{self.name}.rotation", ROTATION, self))

    @property
    def ports(self) -> Sequence[Port]:
        """Both ports, translation and rotation, or that of translation alone."""
        return (self.translation, self.rotation) if self.turns else (self.translation,)

    @property
    def path(self) -> str:
        """Block and anchor, as in messages: ``"crank.start"``."""
        return f"{self.block.name}.{self.name}"

    def __repr__(self) -> str:
        """Return the path."""
        return f"<anchor {self.path}>"


@dataclass(frozen=True)
class Exposure:
    """A port open to the outside: one input and the conjugate output.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    port : Port
        The port, or one of the ports of the junction that is exposed.
    gives : bool
        The outside gives the common quantity (velocity) and takes the summed one.
    follows : bool
        Components are in the frame of the anchor of the port, or if that is nowhere in particular of the anchor that
        is acted on, and turn with it; otherwise in the fixed frame.
    signal : callable, array_like or None
        What is imposed if the simulation is given nothing else, as a constant or a function of time.
    made_by : str
        The call that made it, such as ``"expose at four_bar.py:12"``, or added the block that brings it along.
    """

    name: str
    port: Port
    gives: bool
    follows: bool = False
    signal: Callable[[float], ArrayLike] | ArrayLike | None = field(default=None, compare=False)  # arrays: by entry
    made_by: str = ""
