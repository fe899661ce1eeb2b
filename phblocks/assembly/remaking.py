"""The same network with other values of its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from phblocks.blocks.block import Block
from phblocks.blocks.parameter import parameters_in, with_values
from phblocks.network import Junction, Network
from phblocks.ports import Port


def revalued(network: Network, values: Mapping[str, float]) -> Network:
    """Give the parameters of blocks other values.

    Parameters
    ----------
    network : Network
        It is not changed.
    values : mapping of str to float
        By the name of the parameter.

    Returns
    -------
    Network
        With new blocks in the place of those that have one of them.
    """
    twins = {block: _twin(block, values) for block in network.blocks.values()}

    def moved(port: Port) -> Port:
        twin = twins[port.block]
        return port if twin is port.block else twin.ports[port.name]

    other = replace(
        network,
        blocks={block.name: block for block in twins.values()},
        joined=[],
        junction_of={},
        exposed=[replace(e, port=moved(e.port)) for e in network.exposed],
    )
    for junction in network.joined:
        other.join(Junction(tuple(moved(port) for port in junction.ports), junction.made_by))
    return other


def _twin(block: Block, values: Mapping[str, float]) -> Block:
    """The block with other values, or the same one if it has no parameters."""
    arguments = block.arguments
    if not any(True for _ in parameters_in(arguments)):
        return block
    return block.made_from(with_values(arguments, values))
