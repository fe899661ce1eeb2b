"""Which states blocks share, found from an assignment in which several ports of a junction give."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.sparse.csgraph import connected_components

from phblocks.frames import Orientation
from phblocks.network import Network
from phblocks.ports import Port
from phblocks.system import Sharing
from phblocks.triplets import Ints, Triplets

Team = Sequence[Port]


def same_turns(teams: Iterable[Team], coordinates: Callable[[Port], Ints], theta_states: Ints) -> Ints:
    """Find rotation states that are the same because their angular velocities are.

    Parameters
    ----------
    teams : iterable of sequence of Port
        Ports that give together.
    coordinates : callable
        From a port to the coordinates that it gives.
    theta_states : numpy.ndarray
        The coordinate that each rotation state is the time integral of.

    Returns
    -------
    numpy.ndarray
        For each rotation state the one that stands for it.
    """
    pairs = [pair for team in teams for pair in pairwise(int(coordinates(p)[0]) for p in team)]
    root = _roots(pairs, range(int(theta_states.max(initial=-1)) + 1))
    first: dict[int, int] = {}
    return np.array([first.setdefault(int(root[s]), i) for i, s in enumerate(theta_states)], dtype=np.int64)


def same_states(teams: Iterable[Team], coordinates: Callable[[Port], Ints]) -> dict[int, int]:
    """Find the first states of ports that are the same for all of a team, but for a constant rotation.

    Parameters
    ----------
    teams : iterable of sequence of Port
        Ports of rotation that give together.
    coordinates : callable
        From a port to the coordinates that it gives.

    Returns
    -------
    dict of int to int
        From the first coordinate of a port to that of the first port of its team.
    """
    firsts = [[int(coordinates(port)[0]) for port in team] for team in teams]
    return {other: first for first, *others in firsts for other in others}


def share(
    teams: Iterable[Team],
    pieces: Callable[[Port], Sequence[tuple[Orientation | int, Triplets]]],
    network: Network,
    n: int,
) -> Sharing:
    """Number the states of a system whose blocks share some.

    Parameters
    ----------
    teams : iterable of sequence of Port
        Ports that give together.
    pieces : callable
        From a port to what it gives, with its frame, as rows over all coordinates.
    network : Network
        The blocks.
    n : int
        Number of coordinates of all blocks.

    Returns
    -------
    Sharing
        The states of the first port of a team stand for those of the others.
    """
    equal: list[tuple[int, int]] = []
    rank = np.zeros(n, dtype=np.int64)
    order = {name: i for i, name in enumerate(sorted(network.blocks))}
    turned: list[Triplets] = []
    number = {name: i for i, name in enumerate(network.blocks)}
    blocks: list[tuple[int, int]] = []
    for first, *others in teams:
        ((to, master),) = pieces(first)
        rank[master.indices[1]] = order[first.block.name]
        for port in others:
            ((of, slave),) = pieces(port)
            blocks.append((number[first.block.name], number[port.block.name]))
            (_, i), (_, j) = slave.indices, master.indices
            rank[i] = order[port.block.name]
            assert not isinstance(of, int) and not isinstance(to, int)
            angle = to.minus(of)  # type: ignore[arg-type]  # both of one space
            if not network.space.turns(port.domain.turns_with) or angle.none:
                equal += zip(j.tolist(), i.tolist(), strict=True)
            else:
                row, column = np.nonzero(matrix := angle.matrix())
                turned.append(Triplets.of(i[row], j[column], values=matrix[row, column]))
    root = _roots(equal, rank)
    follow = np.flatnonzero(root != np.arange(n))
    shared = Triplets.join([Triplets.of(follow, root[follow], values=1.0), *turned])
    label = _roots(blocks, range(len(number)))
    groups = [np.flatnonzero(label == g).tolist() for g in np.unique(label[[b for pair in blocks for b in pair]])]
    return Sharing.of(n, shared, groups)


def _roots(pairs: Sequence[tuple[int, int]], rank: ArrayLike) -> Ints:
    """For each thing that of the lowest rank among those that pairs say are the same."""
    rank = np.asarray(rank)
    if not pairs:
        return np.arange(rank.size)
    rows, columns = np.array(pairs, dtype=np.int64).T
    graph = sp.coo_array((np.ones(rows.size), (rows, columns)), shape=(rank.size, rank.size))
    label = connected_components(graph, directed=False)[1]
    order = np.argsort(rank, kind="stable")
    return np.asarray(order[np.unique(label[order], return_index=True)[1]][label], dtype=np.int64)
