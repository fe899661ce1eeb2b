"""The same system with other values of its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from phblocks.assembly.interconnection import Outputs, assemble
from phblocks.blocks.block import Block
from phblocks.blocks.parameter import parameters_in, with_values
from phblocks.causality import assign_causality
from phblocks.network import Junction, Network
from phblocks.ports import Port
from phblocks.system import System


def remake(network: Network, outputs: Outputs, values: Mapping[str, float]) -> System:
    """Assemble a network with other values of its parameters.

    Parameters
    ----------
    network : Network
        It is not changed.
    outputs : {"all", None}
        As of :meth:`Diagram.compile`.
    values : mapping of str to float
        By the name of the parameter.

    Returns
    -------
    System
        The other system.
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
    report = assign_causality(other)
    report.raise_if_impossible()
    return assemble(other, report, outputs)


def _twin(block: Block, values: Mapping[str, float]) -> Block:
    """The block with other values, or the same one if it has no parameters."""
    arguments = block.arguments
    if not any(True for _ in parameters_in(arguments)):
        return block
    return block.made_from(with_values(arguments, values))
