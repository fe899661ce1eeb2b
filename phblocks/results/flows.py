"""Who feeds whom: the energies of the ledger as flows between blocks and the outside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from phblocks.triplets import Floats

if TYPE_CHECKING:
    from phblocks.results.solution import Solution


@dataclass(frozen=True)
class Node:
    """A block, an opening to the outside, or states that more than two blocks share.

    Parameters
    ----------
    kind : {"block", "outside", "shared"}
        Which.
    name : str
        Of the block or the opening; the names of all blocks that share.
    """

    kind: str
    name: str


@dataclass(frozen=True)
class Flow:
    """Energy that passed from one node to another.

    Parameters
    ----------
    source, target : Node
        Positive from the first into the second.
    energy : numpy.ndarray
        Since the start, shape (times,), J.
    """

    source: Node
    target: Node
    energy: Floats


def flows_of(solution: Solution) -> tuple[Flow, ...]:
    """Sum up the ledger by pairs of nodes.

    Parameters
    ----------
    solution : Solution
        Of a run.

    Returns
    -------
    tuple of Flow
        One for each pair between which anything passed. For every block what flows in is what the ledger calls
        received plus supplied.
    """
    blocks = [Node("block", part.name) for part in solution.system.parts]
    found: dict[tuple[Node, Node], Floats] = {}

    def add(source: Node, target: Node, energy: Floats) -> None:
        if (target, source) in found:
            source, target, energy = target, source, -energy
        found[source, target] = found.get((source, target), np.zeros(energy.size)) + energy

    ledger = solution.recording.ledger
    for number, (giving, taking) in enumerate(solution.system.connections.blocks):
        add(blocks[giving], blocks[taking], ledger.transferred[:, number])
    for group in solution.system.sharing.groups:
        if len(group) == 2:
            add(blocks[group[0]], blocks[group[1]], ledger.shared[:, group[1]])
            continue
        hub = Node("shared", " + ".join(blocks[b].name for b in group))
        for b in group:
            add(hub, blocks[b], ledger.shared[:, b])
    for source, b, energy in _supplies(solution):
        add(source, blocks[b], energy)
    return tuple(Flow(a, b, energy) for (a, b), energy in found.items() if energy.any())


def _supplies(solution: Solution) -> Sequence[tuple[Node, int, Floats]]:
    """From openings to blocks: told apart from the ends of the graph inwards; what is in a ring comes from a hub."""
    system, ledger = solution.system, solution.recording.ledger
    first = np.array([part.states.stop for part in system.parts])
    rows, columns, _ = system.connections.supply.indices
    acts = {
        (system.inputs[k].exposure, int(b))
        for b, k in zip(np.searchsorted(first, rows, side="right"), columns, strict=True)
    }
    given = {name: np.zeros(solution.t.size) for name, _ in acts}
    for k, entry in enumerate(system.inputs):
        if entry.exposure in given:
            given[entry.exposure] = given[entry.exposure] + ledger.supplied[:, k]
    taken = {b: ledger.supplied_to[:, b].copy() for _, b in acts}
    told = []
    while acts:
        names, targets = [name for name, _ in acts], [b for _, b in acts]
        ends = sorted(p for p in acts if targets.count(p[1]) == 1 or names.count(p[0]) == 1)
        if not ends:
            break
        name, b = ends[0]
        energy = taken[b] if targets.count(b) == 1 else given[name]
        given[name], taken[b] = given[name] - energy, taken[b] - energy
        told.append((Node("outside", name), b, energy))
        acts.remove((name, b))
    hub = Node("outside", " + ".join(sorted({name for name, _ in acts})))
    return told + [(hub, b, taken[b]) for b in sorted({b for _, b in acts})]
