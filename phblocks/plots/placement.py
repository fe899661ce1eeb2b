"""Where to put the nodes of a graph on paper, so that boxes do not overlap and few lines cross."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from itertools import combinations

import networkx as nx
import numpy as np

from phblocks.triplets import Floats

#: Free space around every node, inch.
MARGIN = 0.12
#: The sheet should not have to be reduced to fit into this, inch.
SHEET = (11.0, 8.0)
#: Above this number of nodes only one layout is tried; above the second, the model's places are taken as they are.
MANY, TOO_MANY = 80, 150

Node = Hashable
Places = dict[Node, Floats]
Sizes = Mapping[Node, tuple[float, float]]


def place_nodes(graph: nx.Graph[Node], sizes: Sizes, start: Mapping[Node, Floats] | None) -> Places:
    """Place nodes of given sizes by the Kamada-Kawai method, pieces that are not connected side by side.

    Several starts are tried, and the result with the fewest crossings that needs no large sheet is taken. Nothing
    is left to chance.

    Parameters
    ----------
    graph : networkx.Graph
        Edges carry their wanted ``length``, inch, and ``drawn``: whether there is a line that should cross no other.
    sizes : mapping
        Width and height of each node, inch.
    start : mapping or None
        Where the nodes are in the model, each of shape (2,), in any unit: tried first, to keep the resemblance.

    Returns
    -------
    dict
        Middle of each node, shape (2,), inch.
    """
    places: Places = {}
    right = 0.0
    for members in nx.connected_components(graph):
        piece = graph.subgraph([node for node in graph if node in members])
        found = _place_piece(piece, sizes, start)
        left = min(found[node][0] - 0.5 * sizes[node][0] for node in piece)
        shift = np.array([right - left, 0.0])
        places |= {node: place + shift for node, place in found.items()}
        right = max(places[node][0] + 0.5 * sizes[node][0] for node in piece) + 4.0 * MARGIN
    return places


def _place_piece(graph: nx.Graph[Node], sizes: Sizes, start: Mapping[Node, Floats] | None) -> Places:
    if len(graph) == 1:
        return {node: np.zeros(2) for node in graph}
    end = min(graph, key=graph.degree)
    ring: Places = nx.circular_layout(list(nx.dfs_preorder_nodes(graph, end)))
    starts = [ring] if start is None else [_untangled({node: start[node] for node in graph})]
    few = len(graph) <= MANY
    if few:
        starts.append(ring)
        planar, _ = nx.check_planarity(graph)
        if planar:
            starts.append(_untangled(nx.planar_layout(graph)))
    if len(graph) <= TOO_MANY:
        starts = [nx.kamada_kawai_layout(graph, pos=s, weight="length") for s in starts]
    results = [_spread(_sized(graph, places), sizes) for places in (starts if not few else [*starts, ring])]
    return min(results, key=lambda places: _cost(graph, places, sizes)) if few else results[0]


def _untangled(places: Mapping[Node, Floats]) -> Places:
    """Move coinciding and collinear nodes a little, always in the same way."""
    points = np.array(list(places.values()), dtype=float)
    size = float(np.ptp(points, axis=0).max()) or 1.0
    noise = np.random.default_rng(0).uniform(-1.0, 1.0, points.shape)
    return dict(zip(places, points + 0.03 * size * noise, strict=True))


def _sized(graph: nx.Graph[Node], places: Places) -> Places:
    """Scale to the size at which edges have their wanted lengths on average."""
    ratios = [d["length"] / max(np.linalg.norm(places[a] - places[b]), 1e-9) for a, b, d in graph.edges(data=True)]
    factor = float(np.median(ratios))
    return {node: factor * place for node, place in places.items()}


def _spread(places: Places, sizes: Sizes) -> Places:
    """Enlarge until no nodes overlap."""
    middles = np.array(list(places.values()))
    half = 0.5 * np.array([sizes[node] for node in places]) + 0.5 * MARGIN
    first, second = np.triu_indices(len(places), k=1)
    distance = np.abs(middles[first] - middles[second])
    needed = half[first] + half[second]
    with np.errstate(divide="ignore"):
        factor = np.min(needed / np.maximum(distance, 1e-6), axis=1)  # apart in x or in y is enough
    return dict(zip(places, max(1.0, float(factor.max(initial=1.0))) * middles, strict=True))


def _cost(graph: nx.Graph[Node], places: Places, sizes: Sizes) -> float:
    """Crossings, and how far the drawing has to be reduced to fit onto the sheet."""
    extent = np.ptp(np.array(list(places.values())), axis=0)
    reduction = max(1.0, *(extent / SHEET))
    return float(_crossings(graph, places, sizes) + 4.0 * (reduction - 1.0))


def _crossings(graph: nx.Graph[Node], places: Places, sizes: Sizes) -> int:
    """Count lines that cross lines, and lines that run through the boxes of others."""
    edges = [(a, b) for a, b, drawn in graph.edges(data="drawn") if drawn]
    count = sum(
        _cross(places[a], places[b], places[c], places[d])
        for (a, b), (c, d) in combinations(edges, 2)
        if len({a, b, c, d}) == 4
    )
    for node in graph:
        corner = 0.5 * np.array(sizes[node])
        diagonals = ((corner, -corner), (corner * (1, -1), corner * (-1, 1)))
        for a, b in edges:
            if node not in (a, b):
                middle = places[node]
                count += any(_cross(places[a], places[b], middle + p, middle + q) for p, q in diagonals)
    return count


def _cross(a: Floats, b: Floats, c: Floats, d: Floats) -> bool:
    def side(p: Floats, q: Floats, r: Floats) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0
