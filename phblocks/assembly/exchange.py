"""The ports on both sides of each connection, as the blocks give them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from phblocks.assembly.layout import Layout
from phblocks.frames import NO_TURN, Attitude, Turn
from phblocks.ports import Port
from phblocks.system import Angles, Exchange
from phblocks.triplets import Ints, Triplets


def find_exchange(
    layout: Layout, pairs: Sequence[tuple[Port, Port]], place: Ints, n_theta: int, lines: Ints
) -> Exchange:
    """List what the ports of all connections give.

    Parameters
    ----------
    layout : Layout
        Numbering and orientations.
    pairs : sequence of (Port, Port)
        The giving and the taking port of each connection.
    place : numpy.ndarray
        New number of each rotation state, negative if dropped or zero.
    n_theta : int
        How many are kept.
    lines : numpy.ndarray
        New number of each line, -1 if it is not kept: no force is along it then.

    Returns
    -------
    Exchange
        In coordinates of blocks.
    """
    space = layout.network.space
    outputs: list[Triplets] = []
    turns: list[Turn] = []
    along: list[int] = []
    members: tuple[list[tuple[int, int]], list[tuple[int, int]]] = ([], [])
    for number, pair in enumerate(pairs):
        for port, member in zip(pair, members, strict=True):
            for points, output in layout.pieces(port):
                member.append((number, len(turns)))
                # both sides turn alike in space, so they can be compared as they stood at the start
                seen = _seen_at_start(points, output) if isinstance(points, Attitude) else output
                outputs.append(seen.shifted(len(turns) * space.dimension, 0))
                along.append(int(lines[points]) if isinstance(points, int) else -1)
                turns.append(points if isinstance(points, Turn) and space.turns(port.domain.turns_with) else NO_TURN)
    rows = [(p, place[i], w) for p, t in enumerate(turns) for i, w in zip(t.places, t.weights, strict=True)]
    kept = np.array([row for row in rows if row[1] >= 0]).reshape(-1, 3)
    giving, taking = (
        Triplets.of(*np.array(m, dtype=np.int64).reshape(-1, 2).T, values=1.0).csr((len(pairs), len(turns)))
        for m in members
    )
    return Exchange(
        outputs=Triplets.join(outputs).csr((len(turns) * space.dimension, layout.n)),
        frames=Angles(
            Triplets.of(kept[:, 0], kept[:, 1], values=kept[:, 2]).csr((len(turns), n_theta)),
            np.array([t.reference for t in turns]),
        ),
        line=np.array(along, dtype=np.int64),
        giving=giving,
        taking=taking,
    )


def _seen_at_start(frame: Attitude, output: Triplets) -> Triplets:
    """What a port gives, in the fixed frame as long as nothing has turned."""
    component, state = output.indices
    values = frame.start[:, component] * output.values
    row, entry = np.nonzero(values)
    return Triplets.of(row, state[entry], values=values[row, entry])
