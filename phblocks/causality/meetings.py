"""Parts that can only give and meet at one joint: who they are, and blocks put between them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

from phblocks.blocks.block import Block
from phblocks.causality.edits import rejoined
from phblocks.network import Junction, Network
from phblocks.ports import ROTATION, Exposure, Port


@dataclass(frozen=True)
class Meeting:
    """Parts that can only give, where one may: all but one are to be held by joints of their own.

    Parameters
    ----------
    hub : Port or Exposure
        What stays: of the outside, if that gives; of the ground, if it is among them; else of the first part.
    others : tuple of Port
        Of the other parts.
    joint : Junction
        Where they meet.
    weld : Junction or None
        That of their rotations, if they may not turn against each other.
    """

    hub: Port | Exposure
    others: tuple[Port, ...]
    joint: Junction
    weld: Junction | None = None

    @classmethod
    def of(cls, network: Network, ports: Collection[Port]) -> Meeting | None:
        """Find out who meets at a junction of translation, or of rotation alone.

        Parameters
        ----------
        network : Network
            The network.
        ports : collection of Port
            All ports of the junction.

        Returns
        -------
        Meeting or None
            ``None`` if there are not two that can only give, or the junction is one of another domain, or the
            rotations of a weld.
        """
        joints = [j for j in network.junctions() if set(j.ports) == set(ports)]
        return cls.at(network, joints[0]) if len(joints) == 1 else None

    @classmethod
    def at(cls, network: Network, joint: Junction) -> Meeting | None:
        """Find out who meets at a junction; see :meth:`of`.

        Parameters
        ----------
        network : Network
            The network.
        joint : Junction
            One of its junctions, with its openings.

        Returns
        -------
        Meeting or None
            ``None`` as there.
        """
        if not joint.domain.turns_with:
            return None
        stiff = sorted((p for p in joint.ports if _only_gives(p)), key=lambda p: (not p.block.shared, p.path))
        imposed = [e for e in joint.exposures if e.gives]
        if imposed:
            held = not stiff or stiff[0].block.shared or len(imposed) > 1
            return None if held else cls(imposed[0], tuple(stiff), joint)
        if len(stiff) < 2:
            return None
        anchors = [p.anchor for p in stiff if p.anchor is not None]
        if joint.domain is ROTATION:
            placed = [a.translation for a in anchors]
            welded = len(placed) == len(stiff) and _joining(network, placed) is not None
            return None if welded else cls(stiff[0], tuple(stiff[1:]), joint)
        turns = [a.rotation for a in anchors if a.turns]
        return cls(stiff[0], tuple(stiff[1:]), joint, _joining(network, turns) if len(turns) == len(stiff) else None)

    @property
    def names(self) -> tuple[str, ...]:
        """What the parts are called: blocks, or the opening to the outside."""
        first = self.hub.block.name if isinstance(self.hub, Port) else self.hub.name
        return (first, *(p.block.name for p in self.others))

    @property
    def junctions(self) -> tuple[Junction, ...]:
        """The joint, and that of the rotations of a weld."""
        return (self.joint,) if self.weld is None else (self.joint, self.weld)

    def ports_of(self, part: Port | Exposure) -> tuple[Port, ...]:
        """List the ports of one of the parts that are held.

        Parameters
        ----------
        part : Port or Exposure
            At the joint.

        Returns
        -------
        tuple of Port
            That port, and for a weld the one of rotation; none of the outside.
        """
        if not isinstance(part, Port):
            return ()
        return (part,) if self.weld is None or part.anchor is None else (part, part.anchor.rotation)


def mounted(network: Network, meetings: Sequence[Meeting], make: Callable[[Meeting, str], Block]) -> Network:
    """Put blocks between parts that meet, instead of a joint of which one gives.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    meetings : sequence of Meeting
        The parts, at different joints.
    make : callable
        From a meeting and a name to a block with two ports of the domain of the joint, and two of rotation for a weld.
        Ports of rotation that are not needed are attached to the ground: a pin passes no moment on.

    Returns
    -------
    Network
        A new one, with such a block for each part but the hub. Ports that take stay with the hub, or, if that is the
        ground or the outside, with the first of the other parts: what acts on that part goes through its joint.
    """
    sites = {j.ports for m in meetings for j in m.junctions}
    result = rejoined(network, [j for j in network.joined if j.ports not in sites])
    for meeting in meetings:
        _mount(result, meeting, make)
    return result


def _mount(result: Network, meeting: Meeting, make: Callable[[Meeting, str], Block]) -> None:
    """Join the parts of a meeting, which are not joined yet, by blocks."""
    junctions = meeting.junctions
    gone = {q for p in meeting.others for q in meeting.ports_of(p)}
    moves = isinstance(meeting.hub, Port) and not meeting.hub.block.shared
    hub = meeting.ports_of(meeting.hub) if isinstance(meeting.hub, Port) else (meeting.hub.port,)
    staying = [port for port in hub if port not in gone]  # of the outside: a source, or a part that takes
    kept = {*gone, *staying}
    takers = {j: [p for p in j.ports if p not in kept] for j in junctions}
    at_hub: dict[Junction, list[Port]] = {j: [] for j in junctions}
    for junction, port in zip(junctions, staying, strict=False):
        at_hub[junction].append(port)
    for other, part in zip(meeting.others, meeting.names[1:], strict=True):
        name = f"{'pin' if meeting.weld is None else 'weld'} {meeting.names[0]} {part}"
        while name in result.blocks:
            name += " again"
        block = make(meeting, name)
        result.blocks[name], result.added[name] = block, meeting.joint.made_by
        free = dict.fromkeys(block.ports.values())
        for junction, port in zip(junctions, meeting.ports_of(other), strict=True):
            first, second = (p for p in free if p.domain == junction.domain)
            del free[first], free[second]
            at_hub[junction].append(first)
            hanging = takers[junction] if not moves and other is meeting.others[0] else ()
            result.join(Junction((port, second, *hanging), junction.made_by))
        if free:
            result.join(Junction((_still(result), *free), meeting.joint.made_by))
    for junction, hung in at_hub.items():
        at = [*hung, *(takers[junction] if moves else ())]
        if len(at) > 1:
            result.join(Junction(tuple(at), junction.made_by))
    result.exposed = [
        replace(e, port=at_hub[meeting.joint][0]) if e == meeting.hub and e.port in gone else e for e in result.exposed
    ]


def _still(network: Network) -> Port:
    """The rotation of the ground."""
    return next(p for b in network.blocks.values() if b.shared for p in b.ports.values() if p.domain is ROTATION)


def _joining(network: Network, ports: Sequence[Port]) -> Junction | None:
    """The junction that joins all of these ports, of which one at least is not the ground's."""
    found = next((j for p in ports if (j := network.junction_of.get(p)) is not None), None)
    return found if found is not None and set(ports) <= set(found.ports) else None


def _only_gives(port: Port) -> bool:
    choices, _ = port.block.choices()
    return next(not c.may_take for c in choices if c.port is port)
