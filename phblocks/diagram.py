"""The diagram as users draw it: add blocks, join their ports, check, compile."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike

from phblocks.approximation import Requested, require_request
from phblocks.assembly import Effects, Outputs, assemble, revalued
from phblocks.assembly.approximation import approximated
from phblocks.assembly.justification import justified
from phblocks.blocks.block import Block
from phblocks.blocks.checks import is_one_of, require_flag
from phblocks.blocks.ground import Ground
from phblocks.blocks.joints import RigidJoint
from phblocks.causality import CausalityReport, assign_causality
from phblocks.description import describe, draw, read_file, write_file
from phblocks.errors import (
    ArgumentTypeError,
    DataError,
    DuplicateNameError,
    ForeignBlockError,
    GapError,
    NestingError,
    PortInUseError,
    PortTypeError,
)
from phblocks.nesting import Nested, prefixed
from phblocks.network import GAP_TOLERANCE, Junction, Network, call_site
from phblocks.ports import TRANSLATION, Anchor, Exposure, Port
from phblocks.space import PLANAR
from phblocks.system import System
from phblocks.triplets import Floats, real_array

if TYPE_CHECKING:
    import networkx as nx

B = TypeVar("B", bound=Block)


class Diagram:
    """A block diagram: blocks with power ports, joined without signs or arrows.

    Parameters
    ----------
    name : str, optional
        For titles and messages.
    gravity : array_like, optional
        Acceleration of gravity, shape (2,), m/s^2; none by default.

    Raises
    ------
    DataError
        If gravity is not two finite components.
    ArgumentTypeError
        If gravity is not numbers, or the name not a text.
    """

    def __init__(self, name: str = "diagram", gravity: ArrayLike | None = None) -> None:
        if not isinstance(name, str):
            raise ArgumentTypeError("name of a diagram", expected="a text", got=repr(name), fix="Choose a name.")
        acceleration = None if gravity is None else _acceleration(f"Diagram {name!r} gravity", gravity)
        ground = Ground()
        self.network = Network(name, acceleration, PLANAR, blocks={ground.name: ground})
        self._ground = ground
        self._inner: tuple[Diagram, ...] = ()

    def __repr__(self) -> str:
        """Count blocks and junctions."""
        network = self.network
        return f"<Diagram {self.name!r}: {len(network.blocks)} blocks, {len(network.junctions())} junctions>"

    @property
    def name(self) -> str:
        """For titles and messages."""
        return self.network.name

    @property
    def ground(self) -> Anchor:
        """The anchor of the ground: at rest, and wherever it is needed."""
        return self._ground.anchor

    @property
    def blocks(self) -> Mapping[str, Block]:
        """All blocks by name, in the order of adding; the ground included."""
        return MappingProxyType(self.network.blocks)

    @property
    def graph(self) -> nx.MultiGraph[str]:
        """The bipartite networkx graph of blocks and junctions."""
        return self.network.graph()

    @overload
    def add(self, block: B) -> B: ...

    @overload
    def add(self, block: Diagram, name: str | None = None) -> Nested: ...

    def add(self, block: Block | Diagram, name: str | None = None) -> Block | Nested:
        """Add a block, or all of another diagram.

        Parameters
        ----------
        block : Block or Diagram
            The block. Of a diagram, a copy as it is now is taken: its block "crank" is called "inner/crank" here,
            its joints and exposed ports come along under such names, and its ground is that of this diagram. The
            same diagram can be added many times under different names.
        name : str, optional
            Of a diagram here, without dots; its own by default.

        Returns
        -------
        Block or Nested
            The same block, for assigning it to a name. For a diagram, what its blocks are found by:
            ``arm = outer.add(inner)``, then ``arm[crank].end`` or ``arm["crank"]``; the blocks of the inner diagram
            themselves stay there.

        Raises
        ------
        DuplicateNameError
            If the diagram has a block or exposed port of that name.
        NestingError
            If a diagram would be inside itself, or has a gravity of its own that is another.
        DataError
            If the name of a diagram is empty or has dots.
        ArgumentTypeError
            If it is not a block or a diagram, or a block is given another name.
        """
        if isinstance(block, Diagram):
            return self._nest(block, block.name if name is None else name)
        if not isinstance(block, Block) or name is not None:
            raise ArgumentTypeError(
                "Diagram.add",
                expected="a block such as ph.Beam, or a diagram and its name",
                got=repr(block) if name is None else f"{block!r} and the name {name!r}",
                fix="Make a block first; it has a name of its own.",
            )
        self._require_new([block.name], [e.name for e in block.exposures()])
        self._put("add", block)
        return block

    def pin(self, *anchors: Anchor, multiplier: bool = False) -> None:
        """Join anchors with a revolute joint: same velocity, forces sum to zero, free rotation.

        Parameters
        ----------
        *anchors : Anchor
            Two or more, in the same place.
        multiplier : bool, optional
            Hold the first and each of the others together by a joint force of its own (a block :class:`RigidJoint`):
            all anchors then give velocity, and the system has constraints. For rigid bodies.

        Raises
        ------
        GapError
            If they are not in the same place.
        PortInUseError
            If the translation of one of them is joined already.
        PortTypeError
            If one of them has no port of translation.
        ForeignBlockError
            If the block of one of them is not in the diagram.
        ArgumentTypeError
            If one of them is not an anchor.
        """
        self._require_together("pin", anchors)
        if require_flag("pin multiplier", multiplier):
            self._hold("pin", anchors, turns=True)
        else:
            self._join("pin", [anchor.translation for anchor in anchors])

    def weld(self, *anchors: Anchor, multiplier: bool = False) -> None:
        """Join anchors rigidly: same velocity and angular velocity, forces and moments sum to zero.

        Parameters
        ----------
        *anchors : Anchor
            Two or more, in the same place; they keep their initial angle to each other.
        multiplier : bool, optional
            Hold the first and each of the others together by a joint force and moment of its own, as in :meth:`pin`.

        Raises
        ------
        GapError
            If they are not in the same place.
        PortInUseError
            If a port of one of them is joined already.
        PortTypeError
            If one of them has no port of translation, or none of rotation.
        ForeignBlockError
            If the block of one of them is not in the diagram.
        ArgumentTypeError
            If one of them is not an anchor.
        """
        self._require_together("weld", anchors)
        for anchor in anchors:
            if not anchor.turns:
                raise PortTypeError(
                    f"weld {anchor.path}",
                    expected="an anchor with orientation",
                    got="that of a point",
                    fix="Use pin(), or a RigidBody instead of a point mass.",
                )
        self._require_unused([port for anchor in anchors for port in anchor.ports])
        if require_flag("weld multiplier", multiplier):
            self._hold("weld", anchors, turns=False)
            return
        self._join("weld", [anchor.translation for anchor in anchors])
        self._join("weld", [anchor.rotation for anchor in anchors])

    def connect(self, *ports: Port, apart: bool = False) -> None:
        """Join ports of one domain: the common quantity is the same, the summed one adds up to zero.

        Parameters
        ----------
        *ports : Port
            Two or more, such as ``beam.start.rotation``.
        apart : bool, optional
            Ports of translation may be in different places: they have the same velocity there, as the feet of a frame
            that is shaken; the distances between them stay as they are.

        Raises
        ------
        PortTypeError
            If their domains differ, or one of them is not a port of its block.
        PortInUseError
            If one of them is joined already.
        ForeignBlockError
            If the block of one of them is not in the diagram.
        ArgumentTypeError
            If one of them is not a port.
        GapError
            If ports of translation are not in the same place and ``apart`` is not set.
        """
        self._join("connect", ports, require_flag("connect apart", apart))

    def free(self, *places: Anchor | Port) -> None:
        """Declare that nothing is joined to ports, now or later: force and moment are zero there.

        A port that nobody joined is free anyway if it may give velocity; saying so keeps it from being joined by
        mistake, and shows in the table of :meth:`check`.

        Parameters
        ----------
        *places : Anchor or Port
            Anchors, with all their ports, or single ports.

        Raises
        ------
        PortInUseError
            If one of them is joined already.
        ForeignBlockError
            If the block of one of them is not in the diagram.
        DataError
            If one of them is the ground's.
        ArgumentTypeError
            If one of them is neither an anchor nor a port.
        """
        ports = [port for place in places for port in (place.ports if isinstance(place, Anchor) else (place,))]
        for port in ports:
            self._require_port("free", port)
            if port.block.shared:
                raise DataError(
                    f"free {port.path}",
                    expected="a port of a block that can move",
                    got=f"one of {port.block!r}",
                    fix="The ground needs no declaration.",
                )
        self._require_unused(ports)
        for port in ports:
            self.network.join(Junction((port,), f"free at {call_site()}"))

    def with_network(self, network: Network) -> Diagram:
        """Make a diagram of another network, such as one with a repair.

        Parameters
        ----------
        network : Network
            Blocks and junctions; its ground is that of this diagram.

        Returns
        -------
        Diagram
            A new one; this one is not changed.
        """
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other.network = network
        return other

    def expose(self, port: Port, name: str, imposes: str | None = None) -> None:
        """Open a port to the outside: one input and its power-conjugate output.

        Vectors are in the fixed frame of the diagram. A port that is joined is exposed together with its
        junction: a force from outside acts on the joint.

        Parameters
        ----------
        port : Port
            Such as ``beam.end.translation``.
        name : str
            Of input and output, without dots; components get ".x", ".y".
        imposes : str, optional
            What the outside imposes, by name, such as "force" or "velocity"; by default the summed quantity
            (force, moment), unless the port, and all it is joined to by now, can only take the common one (velocity).

        Raises
        ------
        DuplicateNameError
            If the name is in use.
        DataError
            If the domain of the port has no such quantity, the name has a dot, or the port is the ground's.
        ForeignBlockError
            If the block is not in the diagram.
        ArgumentTypeError
            If it is not a port, or the name not a text.
        """
        self._require_port("expose", port)
        where = f"expose {port.path} name"
        if not isinstance(name, str):
            raise ArgumentTypeError(where, expected="a text", got=repr(name), fix="Choose a name.")
        if not name or "." in name:
            raise DataError(where, expected="a non-empty text without dots", got=repr(name), fix="Choose another.")
        if port.block.shared:
            raise DataError(
                f"expose {port.path}",
                expected="a port of a block that can move",
                got=f"one of {port.block!r}",
                fix="Expose the port of the block that is attached there, or impose a velocity instead of the ground.",
            )
        if any(e.name == name for e in self.network.exposures()):
            raise DuplicateNameError(
                f"diagram {self.name!r}",
                expected="a name not in use",
                got=repr(name),
                fix="Choose another name.",
            )
        common, summed = port.domain.common.name, port.domain.summed.name
        if not is_one_of(imposes, (None, common, summed)):
            raise DataError(
                f"expose {port.path}",
                expected=f'imposes="{summed}" or imposes="{common}"',
                got=repr(imposes),
                fix="Name one of the two quantities of the port.",
            )
        if imposes is None:
            # where nobody at the junction can give, the outside does
            at = self.network.junction_of.get(port)
            ports = (port,) if at is None else at.ports
            gives = not any(c.may_give for p in ports for c in p.block.choices()[0] if c.port is p)
        else:
            gives = imposes == common
        self.network.exposed.append(Exposure(name, port, gives, made_by=f"expose at {call_site()}"))

    def check(self) -> CausalityReport:
        """Find out who gives and who takes at every junction.

        Returns
        -------
        CausalityReport
            Also for a diagram that is not causal; it prints as a table.
        """
        return assign_causality(approximated(self.network))

    def compile(
        self, outputs: Outputs = "all", effects: Effects = "auto", approximation: Requested | None = None
    ) -> System:
        """Assemble the diagram.

        Parameters
        ----------
        outputs : {"all", None}, optional
            "all" keeps orientations and positions of all blocks for reading; ``None`` keeps only what the
            physics needs (orientations where frames turn against each other, positions where gravity acts).
        effects : {"auto", "all"}, optional
            "auto" leaves out what is proven to stay zero, whatever happens to what is exposed: components of fields
            that nothing excites, angles that nothing turns. ``system.effects`` says what and why. "all" computes
            everything, as for a start that moves something else, or modes that nothing excites. A diagram that
            nothing excites is computed as a whole.
        approximation : Approximation or mapping, optional
            What is left out in blocks that do not say so themselves, in all of them or by the name of the block;
            nothing by default.

        Returns
        -------
        System
            Matrices, names and units.

        Raises
        ------
        DataError
            If the diagram has no blocks.
        CausalityError
            If the diagram is not causal.
        StructureError
            If the matrices violate the port-Hamiltonian structure.
        ConstraintError
            If a constraint follows from others, or holds nothing.
        GapError
            If what is joined to a slider is not in the place that it was given.
        ApproximationError
            If large rotations are left out in a block that is driven too fast for that.
        """
        if all(block.shared for block in self.network.blocks.values()):
            raise DataError(
                f"diagram {self.name!r}", expected="blocks", got="none but the ground", fix="Call add() first."
            )
        names = [name for name, block in self.network.blocks.items() if not block.shared]
        network = approximated(self.network, require_request("compile approximation", approximation, names))
        report = assign_causality(network)
        report.raise_if_impossible()
        now = replace(  # what is drawn later is no part of it
            self.network,
            blocks=dict(self.network.blocks),
            joined=list(self.network.joined),
            exposed=list(self.network.exposed),
            junction_of=dict(self.network.junction_of),
        )
        again = partial(_compiled_with, now, outputs, effects, approximation)
        return replace(justified(assemble(network, report, outputs, effects)), remake=again)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the diagram to a JSON file, which :func:`load` reads and editors may write.

        Blocks of nested diagrams are written under their long names. See ``docs/diagram-json.md``.

        Parameters
        ----------
        path : str or os.PathLike
            Such as ``"crane.json"``; a file of this name is replaced.

        Returns
        -------
        pathlib.Path
            The file.

        Raises
        ------
        ExportError
            If an argument of a block is a function (a signal of time, a Hamiltonian that is not of sympy), or the file
            cannot be written.
        ArgumentTypeError
            If it is not a path.
        """
        return write_file(describe(self.network, self._ground.name), path)

    def _nest(self, inner: Diagram, name: str) -> Nested:
        where = f"add diagram {name!r} to {self.name!r}"
        if not isinstance(name, str):
            raise ArgumentTypeError("name of a nested diagram", expected="a text", got=repr(name), fix="Choose a name.")
        if not name or "." in name:
            raise DataError(where, expected="a non-empty name without dots", got=repr(name), fix="Give another name.")
        if self is inner or self in inner._within():
            raise NestingError(
                where,
                expected="a diagram that does not contain this one",
                got="one that does" if self is not inner else "this one itself",
                fix="Build the part that is repeated as a diagram of its own.",
            )
        if inner.network.gravity is not None and not np.array_equal(inner.network.gravity, self._gravity):
            raise NestingError(
                where,
                expected=f"no gravity of its own, or that of {self.name!r}: {self._gravity.tolist()}",
                got=str(inner.network.gravity.tolist()),
                fix="Gravity is a matter of the outermost diagram: leave it out of the inner one.",
            )
        network, nested = prefixed(inner.network, name, self._ground)
        self._require_new(list(network.blocks), [e.name for e in network.exposures()])
        self.network.blocks |= network.blocks
        self.network.exposed += network.exposed
        self.network.added |= {block: f"{call}, nested at {call_site()}" for block, call in network.added.items()}
        for junction in network.joined:
            self.network.join(junction)
        self._inner += (inner,)
        return nested

    @property
    def _gravity(self) -> Floats:
        return np.zeros(2) if self.network.gravity is None else self.network.gravity

    def _within(self) -> set[Diagram]:
        """All diagrams nested in this one, at any depth."""
        return {d for inner in self._inner for d in (inner, *inner._within())}

    def _require_new(self, blocks: Sequence[str], exposures: Sequence[str]) -> None:
        """Refuse names of blocks, or of ports that they expose, which are in use."""
        exposed = {e.name for e in self.network.exposures()} if exposures else set()
        for kind, names, used in (("block", blocks, self.network.blocks), ("exposed port", exposures, exposed)):
            taken = [name for name in names if name in used]
            if taken:
                raise DuplicateNameError(
                    f"diagram {self.name!r}",
                    expected=f"a name that no {kind} has",
                    got=repr(taken[0]),
                    fix=f"Choose another name than {', '.join(used)}.",
                )

    def _put(self, verb: str, block: Block) -> None:
        self.network.blocks[block.name] = block
        self.network.added[block.name] = f"{verb} at {call_site()}"

    def _hold(self, verb: str, anchors: Sequence[Anchor], turns: bool) -> None:
        """Join anchors by blocks with multipliers: a hub, and one joint to each of the others."""
        if len(anchors) < 2:
            raise DataError(verb, expected="at least two", got=str(len(anchors)), fix="Name all that meet there.")
        self._require_unused([anchor.translation for anchor in anchors])
        hub, *others = anchors
        joints = []
        for other in others:
            name = wanted = f"{verb} {hub.block.name} {other.block.name}"
            count = 1
            while name in self.network.blocks:
                count += 1
                name = f"{wanted} {count}"
            joints.append(RigidJoint(name, turns))
            self._put(verb, joints[-1])
        self._join(verb, [hub.translation, *(joint.first for joint in joints)])
        for other, joint in zip(others, joints, strict=True):
            self._join(verb, [other.translation, joint.second])
        if not turns:
            self._join(verb, [hub.rotation, *(joint.first_rotation for joint in joints)])
            for other, joint in zip(others, joints, strict=True):
                self._join(verb, [other.rotation, joint.second_rotation])

    def _join(self, verb: str, ports: Sequence[Port], apart: bool = False) -> None:
        for port in ports:
            self._require_port(verb, port)
        if len(ports) < 2:
            raise DataError(verb, expected="at least two", got=str(len(ports)), fix="Name all that meet there.")
        first = ports[0]
        for port in ports[1:]:
            if port.domain != first.domain:
                raise PortTypeError(
                    f"{verb} {first.path} to {port.path}",
                    expected=f"a port of {first.domain.summed.name}/{first.domain.common.name}",
                    got=f"one of {port.domain.summed.name}/{port.domain.common.name}",
                    fix="Join ports of the same domain; weld() joins both ports of two anchors.",
                )
        self._require_unused(ports)
        if first.domain == TRANSLATION and not apart:
            hint = "" if verb != "connect" else " Ports apart have the same velocity with connect(..., apart=True)."
            _require_same_place(verb, [p.anchor for p in ports if p.anchor is not None], hint)
        self.network.join(Junction(tuple(ports), f"{verb} at {call_site()}"))

    def _require_port(self, verb: str, port: object) -> None:
        if not isinstance(port, Port):
            hint = " Name one of its ports, .translation or .rotation." if isinstance(port, Anchor) else ""
            raise ArgumentTypeError(
                verb,
                expected="a port such as beam.end.translation",
                got=repr(port),
                fix="Give a port." + hint,
            )
        self._require_member(port.block, port.path)
        if port.block.ports.get(port.name) is not port:
            raise PortTypeError(
                f"{verb} {port.path}",
                expected=f"one of the ports of {port.block!r}: {', '.join(port.block.ports)}",
                got="one it does not have",
                fix="A shaft such as that of a motor is joined with connect(), not with pin() or weld().",
            )

    def _require_member(self, block: Block, path: str) -> None:
        if self.network.blocks.get(block.name) is not block:
            raise ForeignBlockError(
                path,
                expected=f"a block of diagram {self.name!r}",
                got=f"{block!r}, which is not in it",
                fix="Call add() first; of a nested diagram, take the block from what add() returned.",
            )

    def _require_unused(self, ports: Sequence[Port]) -> None:
        used = self.network.junction_of
        for i, port in enumerate(ports):
            if port in ports[:i] or (port in used and not port.block.shared):
                raise PortInUseError(
                    port.path,
                    expected="a port that is not joined yet",
                    got=f"one joined in [{used[port].name}] ({used[port].made_by})" if port in used else "it twice",
                    fix="Where more than two parts meet, name them all in one call: pin(a, b, c).",
                )

    def _require_together(self, verb: str, anchors: Sequence[Anchor]) -> None:
        for anchor in anchors:
            if not isinstance(anchor, Anchor):
                raise ArgumentTypeError(
                    verb,
                    expected="an anchor such as beam.end",
                    got=repr(anchor),
                    fix="Give anchors, not blocks.",
                )
            self._require_member(anchor.block, anchor.path)
        _require_same_place(verb, anchors)


def _compiled_with(
    network: Network, outputs: Outputs, effects: Effects, approximation: Requested | None, values: Mapping[str, float]
) -> System:
    """Compile a network with other values of its parameters."""
    other = approximated(revalued(network, values), approximation)
    report = assign_causality(other)
    report.raise_if_impossible()
    return justified(assemble(other, report, outputs, effects))


def load(path: str | os.PathLike[str]) -> Diagram:
    """Read a diagram from a JSON file that :meth:`Diagram.save` or an editor wrote; nothing in it is executed.

    Parameters
    ----------
    path : str or os.PathLike
        The file.

    Returns
    -------
    Diagram
        Its blocks are ``diagram.blocks["crank"]``.

    Raises
    ------
    ExportError
        If it cannot be read, is not a diagram or of a later version, or says something that is not known.
    PhblocksError
        As the same calls in Python: a number out of its range, a port that does not exist or is joined already.
    """
    file, data = read_file(path)
    diagram = Diagram(data["name"], data.get("gravity"))
    draw(data, diagram, f"file {file}")
    return diagram


def _require_same_place(verb: str, anchors: Sequence[Anchor], hint: str = "") -> None:
    placed = [(a, a.position) for a in anchors if a.position is not None]
    for anchor, position in placed[1:]:
        first, here = placed[0]
        distance = float(np.linalg.norm(position - here))
        if distance > GAP_TOLERANCE * (1.0 + float(np.abs(here).max())):
            raise GapError(
                f"{verb} {first.path} and {anchor.path}",
                expected="anchors in the same place",
                got=f"{here.tolist()} and {position.tolist()}, {distance:.6g} m apart",
                fix="Correct the coordinates." + hint,
            )


def _acceleration(where: str, gravity: ArrayLike) -> Floats:
    fix = "Write for instance gravity=(0.0, -9.81); this version builds planar diagrams only."
    acceleration = real_array(gravity)
    if acceleration is None:
        raise ArgumentTypeError(where, expected="two numbers, m/s^2", got=repr(gravity), fix=fix)
    if acceleration.shape != (2,) or not np.isfinite(acceleration).all():
        raise DataError(where, expected="two finite components, m/s^2", got=repr(gravity), fix=fix)
    return acceleration
