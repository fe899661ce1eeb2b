"""An order of the unknowns in which the Newton matrix has a narrow band."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order, connected_components, reverse_cuthill_mckee

from phblocks.triplets import Ints


def narrow_order(rows: Ints, columns: Ints, n: int) -> Ints:
    """Order unknowns by reverse Cuthill-McKee, started at a far end of each connected part.

    SciPy starts at a node of least degree, which in a chain of beams may lie in the middle and doubles the band. A
    far end is found by two breadth-first searches and made the start by hanging one extra node of degree one on it.

    Parameters
    ----------
    rows, columns : numpy.ndarray
        Places of the entries of the matrix.
    n : int
        Number of unknowns.

    Returns
    -------
    numpy.ndarray
        Shape (n,): the unknown that comes i-th.

    Notes
    -----
    A. George, J. W. H. Liu, An implementation of a pseudoperipheral node finder, doi:10.1145/355841.355845.
    """
    graph = sp.csr_matrix((np.ones(rows.size, dtype=np.int8), (rows, columns)), shape=(n, n))
    count, label = connected_components(graph, directed=False)
    first = np.unique(label, return_index=True)[1]
    ends = [breadth_first_order(graph, i, directed=False, return_predecessors=False)[-1] for i in first]
    ends = [breadth_first_order(graph, i, directed=False, return_predecessors=False)[-1] for i in ends]
    extra = n + np.arange(count)
    hung = sp.csr_matrix(
        (
            np.ones(2 * rows.size + 2 * count, dtype=np.int8),
            (np.concatenate([rows, columns, extra, ends]), np.concatenate([columns, rows, ends, extra])),
        ),
        shape=(n + count, n + count),
    )
    order = np.asarray(reverse_cuthill_mckee(hung, symmetric_mode=True), dtype=np.int64)
    return order[order < n]
