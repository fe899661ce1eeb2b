"""From what is asked for to the network that is assembled: who leaves what out, and what holds rigid parts together."""

from __future__ import annotations

from collections.abc import Mapping

from phblocks.approximation import Approximation, Requested
from phblocks.blocks.block import Block
from phblocks.causality.edits import rebuilt
from phblocks.causality.meetings import Meeting
from phblocks.causality.steps import held
from phblocks.effects.record import Effect
from phblocks.nesting import twin_of
from phblocks.network import Network
from phblocks.system import System


def approximated(network: Network, approximation: Requested | None = None) -> Network:
    """Tell every block that says nothing itself what to leave out.

    Parameters
    ----------
    network : Network
        As the user drew it; it is not changed.
    approximation : Approximation or mapping, optional
        Of the diagram, or of some blocks by their names.

    Returns
    -------
    Network
        With twins of the blocks that the diagram speaks for, and with joints by multipliers where a part that is taken
        for rigid meets others that can only give; the very same object if nothing is asked for.
    """
    if approximation is not None:
        silent = {b.name: b for b in network.blocks.values() if b.approximation is None and not b.shared}
        asked = approximation if isinstance(approximation, Mapping) else dict.fromkeys(silent, approximation)
        network = rebuilt(network, {name: _twin(silent[name], asked[name]) for name in silent if name in asked})
    if not any(block.held for block in network.blocks.values()):
        return network
    joints = [j for j in network.junctions() if any(port.block.held for port in j.ports)]
    meetings = [meeting for j in joints if (meeting := Meeting.at(network, j)) is not None]
    return held(network, meetings)


def _twin(block: Block, approximation: Approximation) -> Block:
    twin = twin_of(block, "")
    twin.approximation, twin.original = approximation, block.original
    return twin


def requested(system: System) -> tuple[Effect, ...]:
    """List what is left out on request.

    Parameters
    ----------
    system : System
        As assembled.

    Returns
    -------
    tuple of Effect
        By block, in the order of adding; none for effects that a block does not have.
    """
    return tuple(
        Effect(part.name, name, "approximated", states, f"{name}={getattr(part.block.kept, name)!r}")
        for part in system.parts
        for name, states in part.block.left_out(part.form).items()
    )
