"""Changes of a network: blocks replaced, bodies merged. Each returns a new network."""

from __future__ import annotations

from collections.abc import Mapping

from phblocks.blocks.block import Block
from phblocks.blocks.joints import RigidJoint
from phblocks.network import Junction, Network
from phblocks.ports import TRANSLATION, Anchor, Exposure, Port


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
        if moved == junction.ports or len(moved) > 1:
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
    # a load would lose the frame it turns with, or act on what is held
    if any((e.follows or found.block.shared) and e.port.block in (a, b) for e in network.exposures()):
        return None
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
    return result, found.what


def held_together(network: Network, ports: tuple[Port, ...]) -> Network | None:
    """Hold parts that all give velocity together by multipliers instead of a joint of which one gives.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    ports : tuple of Port
        Of the junction of translation: the parts hang on the first that can only give.

    Returns
    -------
    Network or None
        A new one, with a block :class:`RigidJoint` for each of the others that can only give; ``None`` if there are
        none, or the parts are joined in another way than by a pin or a weld.
    """
    stiff = [p for p in ports if _only_gives(p) and p.anchor is not None]
    joints = [j for j in network.joined if set(j.ports) == set(ports)]
    if ports[0].domain is not TRANSLATION or len(stiff) < 2 or len(joints) != 1:
        return None
    hub, *others = sorted(stiff, key=lambda p: (not p.block.shared, p.path))
    # a weld if the rotations meet in one junction too
    turns = [p.anchor.rotation for p in (hub, *others) if p.anchor is not None and p.anchor.turns]
    welds = [j for j in network.joined if len(turns) == len(stiff) and set(turns) <= set(j.ports)]
    result = rebuilt(network, {})
    result.joined.clear()
    result.junction_of.clear()
    for junction in network.joined:
        if junction not in (*joints, *welds):
            result.join(junction)
    mounted = {joints[0]: [hub], **{w: [turns[0]] for w in welds}}
    for other in others:
        name = f"pin {hub.block.name} {other.block.name}"
        while name in result.blocks:
            name += " again"
        joint = RigidJoint(name, turns=not welds)
        result.blocks[name] = joint
        result.join(Junction((other, joint.second), joints[0].made_by))
        mounted[joints[0]].append(joint.first)
        for weld in welds:
            assert other.anchor is not None
            result.join(Junction((other.anchor.rotation, joint.second_rotation), weld.made_by))
            mounted[weld].append(joint.first_rotation)
    gone = {*others, *turns}
    for junction, hung in mounted.items():
        takers = [p for p in junction.ports if p not in gone and p not in hung]
        result.join(Junction((*hung, *takers), junction.made_by))
    return result


def _only_gives(port: Port) -> bool:
    choices, _ = port.block.choices()
    return next(not c.may_take for c in choices if c.port is port)


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
