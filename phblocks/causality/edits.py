"""Changes of a network: blocks replaced, bodies merged. Each returns a new network."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from phblocks.blocks.block import Block
from phblocks.blocks.body import Mass, RigidBody
from phblocks.blocks.ground import Ground
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


def merged(network: Network, first: str, second: str) -> Network | None:
    """Make one body of two that cannot move against each other.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    first, second : str
        Names of rigid bodies or point masses.

    Returns
    -------
    Network or None
        A new one; ``None`` if they are no bodies, or not joined rigidly.
    """
    a, b = network.blocks.get(first), network.blocks.get(second)
    if not isinstance(a, (Mass, RigidBody)) or not isinstance(b, (Mass, RigidBody)):
        return None
    if not any(_rigid(network, p, q) for p in a.anchors.values() for q in b.anchors.values()):
        return None
    if any(e.follows and e.port.block in (a, b) for e in network.exposures()):
        return None  # the frame that the load turns with would be another
    name = f"{first}-{second}"
    while name in network.blocks:
        name += "-merged"
    anchors = {(p, k): f"{p.name}-{k}" for p in (a, b) for k in p.anchors}
    mass = a.mass + b.mass
    if isinstance(a, Mass) and isinstance(b, Mass):
        body: Mass | RigidBody = Mass(name, mass, a.start)
        place = {q: body.centre.translation for p in (a, b) for q in p.ports.values()}
        return rebuilt(network, {first: body, second: None}, place)
    centre = (a.mass * a.start + b.mass * b.start) / mass
    inertia = sum(
        (p.inertia if isinstance(p, RigidBody) else 0.0) + p.mass * float(np.sum((p.start - centre) ** 2))
        for p in (a, b)
    )
    positions = {key: p.anchors[k].position for (p, k), key in anchors.items()}
    angle = next(p.angle for p in (a, b) if isinstance(p, RigidBody))
    whole = RigidBody(name, mass, inertia, centre, positions, angle=angle)  # type: ignore[arg-type]  # bodies have places
    place = {}
    for (p, k), key in anchors.items():
        place |= {q: r for q, r in zip(p.anchors[k].ports, whole[key].ports, strict=False)}
    # what meets at one joint keeps one of the two ports; the other anchor is in the same place
    for junction in network.joined:
        ours = [q for q in junction.ports if q.block in (a, b)]
        place |= {q: place[ours[0]] for q in ours}
    return rebuilt(network, {first: whole, second: None}, place)


def merge_into_ground(network: Network, name: str) -> Network | None:
    """Take out a body that cannot move, and attach to the ground what hangs on it.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    name : str
        Of a rigid body or point mass.

    Returns
    -------
    Network or None
        A new one; ``None`` if it is no body, or not fixed to the ground.
    """
    body = network.blocks.get(name)
    ground = next(block for block in network.blocks.values() if isinstance(block, Ground)).anchor
    if not isinstance(body, (Mass, RigidBody)) or not any(_rigid(network, p, ground) for p in body.anchors.values()):
        return None
    if any(e.port.block is body for e in network.exposures()):
        return None
    place = {q: r for p in body.anchors.values() for q, r in zip(p.ports, ground.ports, strict=False)}
    result = rebuilt(network, {name: None}, place)
    result.joined = [j for j in result.joined if not all(p.block.shared for p in j.ports)]
    return result


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


def _rigid(network: Network, first: Anchor, second: Anchor) -> bool:
    """Whether two anchors cannot move against each other, nor turn if both can."""
    pairs = list(zip(first.ports, second.ports, strict=False))
    return all((j := network.junction_of.get(p)) is not None and q in j.ports for p, q in pairs)
