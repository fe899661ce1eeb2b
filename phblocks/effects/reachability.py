"""What can differ from zero: closure of what is excited under the pattern of who acts on whom.

Nodes are quantities that are identically zero until something reaches them: components of fields, angles that turn,
directions that change, inputs, gravity. An *edge* ``a -> c`` stands for a term of the equation of c that is linear in
a; a *product* ``(a, b) -> c`` for one that is zero unless both a and b differ from zero. What the closure of the
excitations does not reach satisfies equations without any term of what it reaches: it stays zero exactly, whatever
the values of the entries, and all the rest does not notice that it is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import breadth_first_order

from phblocks.triplets import Ints, Triplets


@dataclass(frozen=True)
class Pattern:
    """Who acts on whom.

    Parameters
    ----------
    size : int
        Number of nodes.
    edges : numpy.ndarray
        Shape (2, edges): from which node to which.
    products : numpy.ndarray
        Shape (3, products): two factors, and the node they act on together.
    """

    size: int
    edges: Ints
    products: Ints


@dataclass
class PatternBuilder:
    """Collects a pattern; the same place may be named many times.

    Parameters
    ----------
    size : int, optional
        Number of nodes so far.
    """

    size: int = 0
    _edges: list[Ints] = field(default_factory=list)
    _products: list[Ints] = field(default_factory=list)

    def add_nodes(self, count: int) -> int:
        """Add nodes.

        Parameters
        ----------
        count : int
            How many.

        Returns
        -------
        int
            Number of the first.
        """
        first = self.size
        self.size += count
        return first

    def add_edges(self, sources: ArrayLike, targets: ArrayLike) -> None:
        """Let nodes act on others.

        Parameters
        ----------
        sources, targets : array_like of int
            Broadcast against each other.
        """
        self._edges.append(_stacked(sources, targets))

    def add_products(self, first: ArrayLike, second: ArrayLike, targets: ArrayLike) -> None:
        """Let pairs of nodes act on others.

        Parameters
        ----------
        first, second, targets : array_like of int
            Broadcast against each other.
        """
        self._products.append(_stacked(first, second, targets))

    def add_matrix(self, entries: Triplets, component: Ints, targets: Ints | None = None) -> None:
        """Let columns of a matrix, or pairs of columns of a tensor, act on rows.

        Parameters
        ----------
        entries : Triplets
            Of order two or three; the first axis counts rows. Zeros do not act.
        component : numpy.ndarray
            Node of each column.
        targets : numpy.ndarray, optional
            Node of each row; the same by default.
        """
        acting = entries.values != 0.0
        places = [axis[acting] for axis in entries.indices]
        nodes = [component[place] for place in places[1:]]
        nodes.append((component if targets is None else targets)[places[0]])
        if len(nodes) == 2:
            self._edges.append(np.stack(nodes))
        else:
            self._products.append(np.stack(nodes))

    def pattern(self) -> Pattern:
        """Return what was collected, each place once.

        Returns
        -------
        Pattern
            Ready for :func:`reach`.
        """
        edges, products = (
            np.concatenate([np.empty((k, 0), dtype=np.int64), *parts], axis=1)
            for k, parts in ((2, self._edges), (3, self._products))
        )
        return Pattern(self.size, edges, products)


def _stacked(*nodes: ArrayLike) -> Ints:
    return np.stack([np.ravel(a) for a in np.broadcast_arrays(*nodes)]).astype(np.int64)


@dataclass(frozen=True)
class Reached:
    """What a closure reaches, and on which way.

    Parameters
    ----------
    pattern : Pattern
        The pattern.
    mask : numpy.ndarray
        Shape (size,): whether each node is reached.
    before : numpy.ndarray
        Shape (size,): the node that each was reached from, -1 for what is excited and for what is not reached.
    """

    pattern: Pattern
    mask: NDArray[np.bool_]
    before: Ints

    def path(self, node: int) -> Sequence[int]:
        """Return the way to a node.

        Parameters
        ----------
        node : int
            One that is reached.

        Returns
        -------
        sequence of int
            From the node back to what is excited.
        """
        path = [node]
        while self.before[path[-1]] >= 0:
            path.append(int(self.before[path[-1]]))
        return path


def reach(pattern: Pattern, excited: NDArray[np.bool_]) -> Reached:
    """Close over a pattern.

    Parameters
    ----------
    pattern : Pattern
        Who acts on whom.
    excited : numpy.ndarray
        Shape (size,): what differs from zero to begin with.

    Returns
    -------
    Reached
        Everything that may differ from zero.

    Notes
    -----
    Breadth-first search along edges; then products of which one factor is reached are edges from the other, and the
    search goes on, until nothing is new.
    """
    n, (sources, targets), (a, b, c) = pattern.size, pattern.edges, pattern.products
    mask, before = excited.copy(), np.full(n, -1, dtype=np.int64)
    while True:
        count = int(mask.sum())
        started = np.flatnonzero(mask)  # from a node n of their own
        rows = np.concatenate([sources, b[mask[a]], a[mask[b]], np.full(started.size, n)])
        columns = np.concatenate([targets, c[mask[a]], c[mask[b]], started])
        graph = sp.csr_matrix((np.ones(rows.size, dtype=np.int8), (rows, columns)), shape=(n + 1, n + 1))
        graph.data[:] = 1  # many at one place would overflow
        order, predecessors = breadth_first_order(graph, n)
        new = order[1:][~mask[order[1:]]]
        before[new], mask[new] = predecessors[new], True
        if int(mask.sum()) == count:
            return Reached(pattern, mask, before)
