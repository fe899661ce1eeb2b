"""What every block promises.

A block has ports, says which side of each pair its ports can give (:class:`PortChoice`, :class:`Tie`), and, once
that is decided, reduces itself to one :class:`Form`: its matrices in its own coordinates.  Nothing later in the
pipeline asks what kind of block it was.
"""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import wraps
from typing import Any, ClassVar, Literal

import numpy as np

from phblocks.approximation import EXACT, Approximation
from phblocks.blocks.form import Form
from phblocks.blocks.reduction import reduced
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.ports import Anchor, Exposure, Place, Port, Ports
from phblocks.space import Space
from phblocks.triplets import Floats, Ints


@dataclass(frozen=True)
class PortChoice:
    """What a port is able to do.

    Parameters
    ----------
    port : Port
        The port.
    may_give : bool
        It can give the common quantity (velocity) and take the summed one (force).
    may_take : bool
        It can take the common quantity and give the summed one.
    shares : {"anchor", "fixed"} or None, optional
        What it gives are states of its own, one for each component, in the frame of its anchor or in the fixed one:
        several such ports whose frames keep their angle to each other can give at one junction, by being the same
        states.
    """

    port: Port
    may_give: bool
    may_take: bool
    shares: Literal["anchor", "fixed"] | None = None


@dataclass(frozen=True)
class Tie:
    """Two ports of a block whose choices depend on each other.

    Parameters
    ----------
    first, second : Port
        The ports.
    cost : float or None
        Price of choosing differently (0: no matter); ``None`` if they cannot differ.
    what : str
        What choosing differently means, for messages.
    opposite : bool
        They belong on opposite sides, one giving and one taking; choosing alike is then what has the price.
    """

    first: Port
    second: Port
    cost: float | None
    what: str
    opposite: bool = False

    def broken(self, first: bool, second: bool) -> bool:
        """Tell whether two choices are not those that cost nothing.

        Parameters
        ----------
        first, second : bool
            Whether the ports give.

        Returns
        -------
        bool
            True if they differ, or, for opposite ones, if they do not.
        """
        return (first != second) != self.opposite


@dataclass(frozen=True)
class Alternative:
    """Another version of a block, with the same ports.

    Parameters
    ----------
    block : Block
        Of the same name.
    what : str
        What is different, such as "let beam 'a' choose its ends".
    """

    block: Block
    what: str


@dataclass(frozen=True)
class Rigid:
    """What a block weighs that moves as one, for others to be welded to.

    Parameters
    ----------
    mass : float
        kg.
    inertia : float
        About the centre of mass, kg m^2; zero for a point.
    centre : numpy.ndarray
        Initial position of the centre of mass, shape (dimension,), m.
    angle : float or None
        Initial orientation, rad; ``None`` for a point, which has none.
    """

    mass: float
    inertia: float
    centre: Floats
    angle: float | None


@dataclass(frozen=True)
class Replacement:
    """One block in the place of two.

    Parameters
    ----------
    block : Block
        A new one, or one of the two.
    places : mapping of Port to Port
        Where ports of the two are now; what is joined to the others falls away.
    what : str
        The change in words, such as "make one body of 'a' and 'b'".
    """

    block: Block
    places: Mapping[Port, Port]
    what: str


class Block(ABC):
    """A part of a diagram.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    """

    #: Whether its ports may be joined more than once.
    shared = False
    #: What is left out in this block; ``None`` leaves the choice to the diagram.
    approximation: Approximation | None = None
    #: All kinds of blocks by name, with the module for those that are not of this package.
    kinds: ClassVar[dict[str, type[Block]]] = {}
    #: Names of class methods that make a block of this kind from arguments of their own.
    makers: ClassVar[tuple[str, ...]] = ()
    #: The class method that made it, if it was one of those.
    maker: str | None = None

    def __init_subclass__(cls) -> None:
        """Register the kind, and keep the arguments that each block is made with."""
        super().__init_subclass__()
        cls.kind = cls.__name__ if cls.__module__.startswith("phblocks.") else f"{cls.__module__}.{cls.__qualname__}"
        if not cls.__name__.startswith("_"):
            Block.kinds[cls.kind] = cls
        if "__init__" in vars(cls):
            cls.__init__ = _keeping(cls.__init__)  # type: ignore[method-assign]

    #: Name of the kind, as in files.
    kind: ClassVar[str] = "Block"
    _given: tuple[tuple[Any, ...], dict[str, Any]] = ((), {})

    def __init__(self, name: str) -> None:
        if not isinstance(name, str):
            raise ArgumentTypeError("name of a block", expected="a text", got=repr(name), fix="Choose a name.")
        if not name or "." in name:
            raise DataError(
                "name of a block",
                expected="a non-empty text without dots",
                got=repr(name),
                fix="Choose another.",
            )
        self.name = name
        #: The block of the user's diagram that this one stands for.
        self.original: Block = self

    @property
    @abstractmethod
    def anchors(self) -> Mapping[str, Anchor]:
        """The places on the block where others can be attached, by name."""

    @property
    @abstractmethod
    def space(self) -> Space | None:
        """The components of the block, or ``None`` if it fits any space."""

    @abstractmethod
    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say what each port is able to do, and which choices depend on each other.

        Returns
        -------
        choices : sequence of PortChoice
            One for each port.
        ties : sequence of Tie
            May be empty.
        """

    @abstractmethod
    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the block to its matrices for a given causality.

        Parameters
        ----------
        gives : mapping of str to bool
            For each port whether it gives the common quantity (velocity).

        Returns
        -------
        Form
            The block in its own coordinates.
        """

    @property
    def held(self) -> bool:
        """Whether its ports only give because of an approximation: multipliers hold them where others give too."""
        return False

    @property
    def kept(self) -> Approximation:
        """What is kept and left out here: everything is kept unless something was said."""
        return self.approximation or EXACT

    def reduced_form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the block to its matrices, without the effects that are left out.

        Parameters
        ----------
        gives : mapping of str to bool
            For each port whether it gives the common quantity (velocity).

        Returns
        -------
        Form
            That of :meth:`form` if everything is kept.
        """
        angles = {p.anchor.name: p.anchor.angle for p in self.ports.values() if p.anchor is not None}
        return reduced(self.form(gives), self.kept, angles)

    def effects(self, form: Form) -> Mapping[str, Ints]:
        """List the effects that the block has and could leave out.

        Parameters
        ----------
        form : Form
            What :meth:`reduced_form` made of the block.

        Returns
        -------
        mapping of str to numpy.ndarray
            Name of the effect -> the states that carry its energy; none for effects that are no storages.
        """
        none = np.empty(0, dtype=np.int64)
        found = {}
        if (form.T.values.size or form.rotation_states.size or form.lines) and not form.frozen:
            found["large_rotation"] = none
        if form.points is not None and form.points.weighs and form.points.mass.any():
            found["gravity"] = none
        return found

    def left_out(self, form: Form) -> Mapping[str, int]:
        """List the effects that the block would have and that are left out on request.

        Parameters
        ----------
        form : Form
            What :meth:`reduced_form` made of the block.

        Returns
        -------
        mapping of str to int
            Name of the effect -> number of states that belong to it.
        """
        found = {}
        if form.frozen:
            found["large_rotation"] = 0
        if not self.kept.gravity and form.points is not None:
            found["gravity"] = 0
        return found

    def alternatives(self) -> Sequence[Alternative]:
        """List other versions of the block whose ports have more choice, for repairs.

        Returns
        -------
        sequence of Alternative
            None unless the block says otherwise.
        """
        return ()

    @property
    def rigid(self) -> Rigid | None:
        """What the block weighs if it is one rigid body or point, ``None`` for all others."""
        return None

    def welded_to(self, other: Block, name: str) -> Replacement | None:
        """Make one block of this one and another that cannot move against it, for repairs.

        Parameters
        ----------
        other : Block
            What it is welded to; a point mass may be pinned.
        name : str
            Of the new block, if there is one.

        Returns
        -------
        Replacement or None
            ``None`` unless the block says otherwise.
        """
        return None

    def in_series_with(self, other: Block, name: str, inner: tuple[Port, Port]) -> Replacement | None:
        """Make one block of this one and another through which the same force passes, for repairs.

        Parameters
        ----------
        other : Block
            The other one.
        name : str
            Of the new block.
        inner : (Port, Port)
            The ports, of this block and of the other, that are joined to each other and to nothing else.

        Returns
        -------
        Replacement or None
            ``None`` unless the block says otherwise.
        """
        return None

    @property
    def coarsest(self) -> Block:
        """The same part on the coarsest mesh: how stiff, heavy and fast it is as a whole, for repairs.

        Ports and anchors have the same names. The block itself, unless it has a mesh.
        """
        return self

    def exposures(self) -> Sequence[Exposure]:
        """List the openings to the outside that the block brings along: those of a source, or of loads.

        Returns
        -------
        sequence of Exposure
            None for all but sources and loaded blocks. A port that is not among :attr:`ports` cannot be joined and
            is answered by ``Form.loads``.
        """
        return ()

    def prefix(self, prefix: str) -> None:
        """Put a prefix before the name, and before the names of what the block opens to the outside.

        Parameters
        ----------
        prefix : str
            Of a copy in a diagram that is nested in another.
        """
        self.name = prefix + self.name

    @property
    def arguments(self) -> dict[str, Any]:
        """The arguments that make an equal block: those of the constructor, or of :attr:`maker`, that were given."""
        args, keywords = self._given
        maker = type(self).__init__ if self.maker is None else getattr(type(self), self.maker).__func__
        return {**_by_name(maker, args, keywords), "name": self.name}

    def made_from(self, arguments: Mapping[str, Any]) -> Block:
        """Make another block of this kind.

        Parameters
        ----------
        arguments : mapping of str to object
            As of :attr:`arguments`.

        Returns
        -------
        Block
            Made in the same way.
        """
        make = type(self) if self.maker is None else getattr(type(self), self.maker)
        block: Block = make(**arguments)
        return block

    def _made_by(self, maker: str, *args: Any, **keywords: Any) -> None:
        """Note that a class method made the block, from other arguments than the constructor's."""
        self.maker, self._given = maker, (_copied(args), _copied(keywords))

    @property
    def ports(self) -> Mapping[str, Port]:
        """All ports by name."""
        return Ports(self.name, (port for anchor in self.anchors.values() for port in anchor.ports))

    def __repr__(self) -> str:
        """Return kind and name."""
        return f"<{type(self).__name__} {self.name!r}>"


def _keeping(init: Callable[..., None]) -> Callable[..., None]:
    """Wrap a constructor; the outermost one keeps what it is given."""

    @wraps(init)
    def keeping(self: Block, *args: Any, **keywords: Any) -> None:
        if "_given" not in vars(self):
            self._given = (_copied(args), _copied(keywords))
        init(self, *args, **keywords)

    return keeping


def _copied(value: Any) -> Any:
    """Copy what can change later: arrays, lists and dictionaries."""
    if isinstance(value, np.ndarray):
        return value.copy()
    if type(value) in (list, tuple):
        return type(value)(_copied(part) for part in value)
    return {key: _copied(part) for key, part in value.items()} if type(value) is dict else value


def _by_name(function: Callable[..., Any], args: tuple[Any, ...], keywords: dict[str, Any]) -> dict[str, Any]:
    """Bind arguments to the names of parameters; ``**options`` are names like all others."""
    signature = inspect.signature(function)
    bound = dict(signature.bind(None, *args, **keywords).arguments)
    bound.pop(next(iter(signature.parameters)))  # self, or cls
    for parameter in signature.parameters.values():
        if parameter.kind is parameter.VAR_KEYWORD:
            bound |= bound.pop(parameter.name, {})
    return bound


@dataclass(frozen=True, eq=False)
class BlockPoint:
    """A point of a block, for reading results.

    Parameters
    ----------
    block : Block
        The block.
    place : Place
        Where on it.
    """

    block: Block
    place: Place
