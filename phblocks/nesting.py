"""Diagrams inside diagrams: the blocks of the inner one are copied under longer names, and joined as they were.

The copy of block "crank" of a diagram nested as "left" is called "left/crank", at any depth. Copies are shallow:
only what refers to the block itself, its anchors and ports, is made anew.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import copy
from dataclasses import replace
from typing import Any, TypeVar, overload

from phblocks.blocks.block import Block
from phblocks.errors import UnknownNameError
from phblocks.network import Junction, Network
from phblocks.ports import Anchor, Port

B = TypeVar("B", bound=Block)

#: Between the name of a nested diagram and that of a block or an exposed port in it.
SEPARATOR = "/"


class Nested:
    """A diagram inside another: what ``outer.add(inner)`` returns, for reaching the copies of its blocks.

    Parameters
    ----------
    name : str
        Of the inner diagram in the outer one.
    copies : mapping of Block to Block
        The block in the outer diagram, by that of the inner one.
    """

    def __init__(self, name: str, copies: Mapping[Block, Block]) -> None:
        self.name = name
        self._copies = copies
        self._named = {block.name: twin for block, twin in copies.items()}

    @overload
    def __getitem__(self, block: str) -> Block: ...

    @overload
    def __getitem__(self, block: B) -> B: ...

    def __getitem__(self, block: object) -> Block:
        """Return the copy of a block, named by the block of the inner diagram or by its name there."""
        found = self._named.get(block) if isinstance(block, str) else None
        found = self._copies.get(block) if isinstance(block, Block) else found
        if found is None:
            raise UnknownNameError(
                f"nested diagram {self.name!r}",
                expected=f"one of its blocks {', '.join(self._named)}, as they were when it was added",
                got=repr(block),
                fix="Name a block of the inner diagram.",
            )
        return found

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the blocks in the inner diagram."""
        return iter(self._named)

    def __repr__(self) -> str:
        """Return the name and the blocks."""
        return f"<Nested {self.name!r}: {', '.join(self)}>"


def twin_of(block: B, prefix: str) -> B:
    """Copy a block under another name.

    Parameters
    ----------
    block : Block
        It is not changed.
    prefix : str
        Of the name of the copy, and of the names of its loads.

    Returns
    -------
    Block
        With anchors and ports of its own; all else is shared.
    """
    twin = copy(block)
    made: dict[int, Any] = {id(block): twin}

    def moved(value: Any) -> Any:
        if id(value) in made:
            return made[id(value)]
        if isinstance(value, (Anchor, Port)):
            made[id(value)] = new = copy(value)
            new.__dict__.update({key: moved(part) for key, part in vars(value).items()})
            return new
        if type(value) is dict:
            return {key: moved(part) for key, part in value.items()}
        if type(value) in (list, tuple):
            return type(value)(moved(part) for part in value)
        return value

    twin.__dict__.update({key: moved(part) for key, part in vars(block).items()})
    twin.prefix(prefix)
    return twin


def prefixed(network: Network, name: str, ground: Block) -> tuple[Network, Nested]:
    """Copy a network under longer names.

    Parameters
    ----------
    network : Network
        The inner one; it is not changed.
    name : str
        Put before the names of its blocks and exposed ports.
    ground : Block
        What stands for its ground.

    Returns
    -------
    Network
        The copy, without a ground of its own.
    Nested
        Which block became which.
    """
    own = network.blocks[ground.name]
    copies = {b: twin_of(b, f"{name}{SEPARATOR}") for b in network.blocks.values() if b is not own}
    both: dict[Block, Block] = {own: ground, **copies}
    result = Network(network.name, network.gravity, network.space, blocks={b.name: b for b in copies.values()})

    def moved(port: Port) -> Port:
        return both[port.block].ports[port.name]

    for junction in network.joined:
        result.join(Junction(tuple(moved(port) for port in junction.ports), junction.made_by))
    result.exposed = [replace(e, name=f"{name}{SEPARATOR}{e.name}", port=moved(e.port)) for e in network.exposed]
    result.added = {twin.name: network.added.get(block.name, "") for block, twin in copies.items()}
    return result, Nested(name, copies)
