"""Changes of a network: blocks replaced, merged, put in between. Each returns a new network."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

from phblocks.blocks.block import Block
from phblocks.network import Junction, Network
from phblocks.ports import Anchor, Exposure, Port


def rebuilt(network: Network, blocks: Mapping[str, Block | None], ports: Mapping[Port, Port] | None = None) -> Network:
    """Replace blocks.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    blocks : mapping of str to Block or None
        By the name of the block replaced; ``None`` takes it out.
    ports : mapping of Port to Port, optional
        Where ports of replaced blocks are now; by default the port of the same name.

    Returns
    -------
    Network
        A new one. Junctions of which one port is left are left out.
    """
    place = dict(ports or {})
    result = Network(network.name, network.gravity, network.space)
    for name, block in network.blocks.items():
        new = blocks.get(name, block)
        if new is not None:
            result.blocks[new.name] = new
            result.added[new.name] = network.added.get(name, "")
            if new is not block:
                place = {p: new.ports[key] for key, p in block.ports.items() if key in new.ports} | place
    for junction in network.joined:
        moved = tuple(dict.fromkeys(place.get(p, p) for p in junction.ports))
        moved = tuple(p for p in moved if result.blocks.get(p.block.name) is p.block)
        if len(moved) > 1 or len(moved) == len(junction.ports):
            result.join(Junction(moved, junction.made_by))
    for e in network.exposed:
        port = place.get(e.port, e.port)
        if result.blocks.get(port.block.name) is port.block:
            result.exposed.append(Exposure(e.name, port, e.gives, e.follows, e.signal, e.made_by))
    return result


def merged(network: Network, first: str, second: str) -> tuple[Network, str] | None:
    """Make one block of two, if they say that they can be one.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    first, second : str
        Names of blocks: two that cannot move against each other, or two through which the same force passes.

    Returns
    -------
    (Network, str) or None
        A new one, and the change in words; ``None`` if the two stay two.
    """
    a, b = network.blocks[first], network.blocks[second]
    name = f"{first}-{second}"
    while name in network.blocks:
        name += "-merged"
    found = None
    if any(_rigid(network, p, q) for p in a.anchors.values() for q in b.anchors.values()):
        found = a.welded_to(b, name) or b.welded_to(a, name)
    if found is None and (inner := _in_series(network, a, b)) is not None:
        found = a.in_series_with(b, name, inner)
    if found is None:
        return None
    for junction in network.junctions():
        ours = [p for p in junction.ports if p.block in (a, b) and not p.block.shared]
        if ours and any(e.follows or found.block.shared for e in junction.exposures):
            return None  # a load would lose the frame it turns with, or act on what is held
    blocks: dict[str, Block | None] = {block.name: None for block in (a, b) if block is not found.block}
    if found.block not in (a, b):
        blocks[first] = found.block
    # what meets at one joint keeps one of the two ports; the other anchor is in the same place
    place = dict(found.places)
    for junction in network.joined:
        ours = [q for q in junction.ports if q in place]
        place |= {q: place[ours[0]] for q in ours}
    result = rebuilt(network, blocks, place)
    result.joined = [j for j in result.joined if not all(p.block.shared for p in j.ports)]
    return None if all(b.shared for b in result.blocks.values()) else (result, found.what)


def grounded(network: Network, path: str) -> Network | None:
    """Attach a loose port to the ground.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    path : str
        Of the port: it is found by name, since another change may have put another block in the place of its own.

    Returns
    -------
    Network or None
        A new one; ``None`` if the port is not loose, may give by itself, or the ground has no port of its domain.
    """
    junction = next((j for j in network.junctions() if [p.path for p in j.ports] == [path]), None)
    if junction is None or any(c.may_give for p in junction.ports for c in p.block.choices()[0] if c.port is p):
        return None
    grounds = [p for b in network.blocks.values() if b.shared for p in b.ports.values() if p.domain == junction.domain]
    if not grounds:
        return None
    result = rejoined(network, [j for j in network.joined if j.ports != junction.ports])
    result.join(Junction((*junction.ports, grounds[0]), junction.made_by))
    return result


def rejoined(network: Network, joined: Iterable[Junction]) -> Network:
    """Keep all blocks and join them otherwise.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    joined : iterable of Junction
        What is joined now.

    Returns
    -------
    Network
        A new one.
    """
    result = rebuilt(network, {})
    result.joined, result.junction_of = [], {}
    for junction in joined:
        result.join(junction)
    return result


def without_opening(network: Network, name: str) -> Network | None:
    """Leave out an opening to the outside, or the source that brings it along.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    name : str
        Of the opening.

    Returns
    -------
    Network or None
        A new one; ``None`` if the opening belongs to a block with other ports.
    """
    opening = next(e for e in network.exposures() if e.name == name)
    if opening in network.exposed:
        result = rebuilt(network, {})
        result.exposed.remove(opening)
        return result
    return rebuilt(network, {opening.port.block.name: None}) if len(opening.port.block.ports) == 1 else None


def turned_round(network: Network, name: str) -> Network | None:
    """Let an opening impose the other quantity: a force instead of a velocity.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    name : str
        Of the opening.

    Returns
    -------
    Network or None
        A new one; ``None`` if the opening has a signal, which would be in the wrong unit.
    """
    opening = next(e for e in network.exposures() if e.name == name)
    if opening not in network.exposed or opening.signal is not None:
        return None
    turned = replace(opening, gives=not opening.gives)
    result = rebuilt(network, {})
    result.exposed = [turned if e is opening else e for e in network.exposed]
    return result


def off_the_ground(network: Network, ports: Collection[Port]) -> Network:
    """Take the ground out of a junction.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    ports : collection of Port
        Of the junction.

    Returns
    -------
    Network
        A new one, where the other ports are still joined to each other; the same if the junction is not there.
    """
    junction = _junction(network, ports)
    if junction is None:
        return network
    left = tuple(p for p in junction.ports if not p.block.shared)
    result = rejoined(network, [other for other in network.joined if other is not junction])
    if len(left) > 1:
        result.join(Junction(left, junction.made_by))
    return result


def hung_on(network: Network, ports: Collection[Port], block: Block, port: Port) -> Network:
    """Join a block at a junction.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    ports : collection of Port
        Of the junction.
    block : Block
        A new one.
    port : Port
        The port of the block that is joined there.

    Returns
    -------
    Network
        A new one; the same if the junction is not there.
    """
    junction = _junction(network, ports)
    if junction is None:
        return network
    more = Junction((*junction.ports, port), junction.made_by)
    result = rejoined(network, [more if other is junction else other for other in network.joined])
    result.blocks[block.name], result.added[block.name] = block, junction.made_by
    return result


def _junction(network: Network, ports: Collection[Port]) -> Junction | None:
    """The junction of ports of these names: another change may have put other blocks in the place of theirs."""
    paths = {p.path for p in ports}
    return next((j for j in network.joined if {p.path for p in j.ports} == paths), None)


def _in_series(network: Network, first: Block, second: Block) -> tuple[Port, Port] | None:
    """The ports at which two blocks are joined to each other and to nothing else, if that is one place."""
    opened = {e.port for e in network.exposures()}
    pairs = [
        (p, q)
        for p in first.ports.values()
        if (j := network.junction_of.get(p)) is not None and len(j.ports) == 2 and not opened & set(j.ports)
        for q in j.ports
        if q.block is second and first is not second
    ]
    return pairs[0] if len(pairs) == 1 else None


def _rigid(network: Network, first: Anchor, second: Anchor) -> bool:
    """Whether two anchors cannot move against each other, nor turn if both can."""
    pairs = list(zip(first.ports, second.ports, strict=False))
    return all((j := network.junction_of.get(p)) is not None and q in j.ports for p, q in pairs)
