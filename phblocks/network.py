"""A network: blocks, the junctions that join their ports, and the ports open to the outside.

This is the diagram as data, without the verbs that users call.  At a junction the common quantity (velocity) is
the same on all ports and the summed one (force) adds up to zero; a port that nobody joined is a junction of its
own.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from phblocks.blocks.block import Block
from phblocks.ports import Domain, Exposure, Port
from phblocks.space import Space
from phblocks.triplets import Floats

if TYPE_CHECKING:
    import networkx as nx

#: Anchors closer than this, relative to their coordinates, are in the same place.
GAP_TOLERANCE = 1e-9

_PACKAGE = os.path.dirname(os.path.abspath(__file__)) + os.sep
#: The entry of a file that is being drawn, if one is.
_ENTRY: ContextVar[str | None] = ContextVar("entry", default=None)


@dataclass(frozen=True, eq=False)
class Junction:
    """Ports that share their common quantity.

    Parameters
    ----------
    ports : tuple of Port
        At least one.
    made_by : str
        The call that made it, such as ``"pin at four_bar.py:12"``.
    exposures : tuple of Exposure
        Openings to the outside.
    """

    ports: tuple[Port, ...]
    made_by: str
    exposures: tuple[Exposure, ...] = ()

    @property
    def domain(self) -> Domain:
        """The pair of quantities."""
        return self.ports[0].domain

    @property
    def name(self) -> str:
        """The paths of all ports, and of the openings."""
        return " = ".join([p.path for p in self.ports] + [f"outside {e.name!r}" for e in self.exposures])


@dataclass
class Network:
    """Blocks and how they are joined.

    Parameters
    ----------
    name : str
        For titles and messages.
    gravity : numpy.ndarray or None
        Acceleration, shape (dimension,), m/s^2.
    space : Space
        Which components exist.
    blocks : dict of str to Block
        By name, in the order of adding; the ground included.
    joined : list of Junction
        In the order of making.
    exposed : list of Exposure
        In the order of making.
    junction_of : dict of Port to Junction
        Where each joined port is; the ground's ports, which may be in many, left out.
    added : dict of str to str
        The call that added each block, such as ``"add at four_bar.py:12"``, by name.
    """

    name: str
    gravity: Floats | None
    space: Space
    blocks: dict[str, Block] = field(default_factory=dict)
    joined: list[Junction] = field(default_factory=list)
    exposed: list[Exposure] = field(default_factory=list)
    junction_of: dict[Port, Junction] = field(default_factory=dict)
    added: dict[str, str] = field(default_factory=dict)

    def join(self, junction: Junction) -> None:
        """Add a junction.

        Parameters
        ----------
        junction : Junction
            Its ports are not joined yet.
        """
        self.joined.append(junction)
        self.junction_of |= {port: junction for port in junction.ports if not port.block.shared}

    def exposures(self) -> Sequence[Exposure]:
        """List all openings to the outside: those the user made, then those of sources.

        Returns
        -------
        sequence of Exposure
            In the order of making and adding.
        """
        brought = [
            replace(e, made_by=self.added.get(name, ""))
            for name, block in self.blocks.items()
            for e in block.exposures()
        ]
        return [*self.exposed, *brought]

    def junctions(self) -> Sequence[Junction]:
        """List all junctions, with the exposures at each; a port that nobody joined is one of its own.

        Returns
        -------
        sequence of Junction
            Those made by the user first, in their order.
        """
        at: dict[Port, list[Exposure]] = {}
        for exposure in self.exposures():
            at.setdefault(exposure.port, []).append(exposure)
        junctions = [
            Junction(j.ports, j.made_by, tuple(e for p in j.ports for e in at.get(p, ()))) for j in self.joined
        ]
        for block in self.blocks.values():
            if not block.shared:
                for port in block.ports.values():
                    if port not in self.junction_of:
                        call = self.added.get(block.name)
                        made_by = f"not joined; {call}" if call else "not joined"
                        junctions.append(Junction((port,), made_by, tuple(at.get(port, ()))))
        return junctions

    def graph(self) -> nx.MultiGraph[str]:
        """Make the bipartite graph of blocks and junctions.

        Returns
        -------
        networkx.MultiGraph
            Nodes are names of blocks (attribute ``block``) and ``".junction i"`` (attribute ``junction``); there is an
            edge for each port, with the port's path as key and the attribute ``port``.
        """
        import networkx as nx

        graph: nx.MultiGraph[str] = nx.MultiGraph(name=self.name)
        for name, block in self.blocks.items():
            graph.add_node(name, block=block)
        for i, junction in enumerate(self.joined):
            node = f".junction {i}"  # names of blocks have no dots
            graph.add_node(node, junction=junction)
            for port in junction.ports:
                graph.add_edge(node, port.block.name, key=port.path, port=port)
        return graph


def call_site() -> str:
    """Find the line of the user's code that is calling.

    Returns
    -------
    str
        ``"file:line"`` of the innermost frame outside this package; of what a file draws, the entry in the file.
    """
    entry = _ENTRY.get()
    if entry is not None:
        return entry
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
        frame = frame.f_back
    return f"{os.path.basename(frame.f_code.co_filename)}:{frame.f_lineno}"


@contextmanager
def drawn_by(entry: str) -> Iterator[None]:
    """Let calls within be those of an entry of a file, in messages.

    Parameters
    ----------
    entry : str
        Such as ``"file crane.json: junctions[2]"``.

    Yields
    ------
    None
        Nothing.
    """
    token = _ENTRY.set(entry)
    try:
        yield
    finally:
        _ENTRY.reset(token)
