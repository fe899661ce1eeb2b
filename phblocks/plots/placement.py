"""Where to put the nodes of a graph on paper, so that boxes do not overlap and few lines cross."""

from __future__ import annotations

from collections.abc import Hashable, Mapping

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from phblocks.triplets import Floats, Ints

#: Free space around every node, inch.
MARGIN = 0.12
#: The sheet should not have to be reduced to fit into this, inch.
SHEET = (11.0, 8.0)
#: Above this number of nodes only one layout is tried by its forces; above the second, none.
MANY, TOO_MANY = 80, 150
#: A piece this many times as long as wide is bent into rows, if it has more nodes than the second number.
SLENDER, FEW = 3.0, 24
#: Rounds of pushing apart what overlaps.
ROUNDS = 400

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
        Edges carry their wanted ``length``, inch, ``drawn``: whether there is a line that should cross no other, and
        may carry ``label``: width and height, inch, of what is written in the middle of the line.
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
    model = None if start is None else _untangled({node: start[node] for node in graph})
    starts = [ring] if model is None else [model]
    if len(graph) <= MANY:
        starts.append(ring)
        planar, _ = nx.check_planarity(graph)
        if planar:
            starts.append(_untangled(nx.planar_layout(graph)))
    if len(graph) <= TOO_MANY:
        starts = [nx.kamada_kawai_layout(graph, pos=s, weight="length") for s in starts]
    candidates = [_sized(graph, places) for places in [*starts, ring]]
    if len(graph) > FEW:  # a long piece is folded like a carpenter's rule: as it is in the model, or as found
        straight = [*candidates] if start is None else [_sized(graph, {n: start[n] for n in graph}), *candidates]
        candidates += straight[:1] + [bent for places in straight if (bent := _bent(places)) is not None]
    results = [_spread(_relaxed(graph, places, sizes), sizes) for places in candidates]
    return min(results, key=lambda places: _cost(graph, places, sizes))


def _bent(places: Places) -> Places | None:
    """Bend a long and narrow layout into rows, with half circles between them; None if it is not narrow."""
    points = np.array(list(places.values()))
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    axes[0] *= np.sign(axes[0][np.abs(axes[0]).argmax()])
    axes[1] = (-axes[0][1], axes[0][0])
    s, n = ((points - middle) @ axes.T).T
    s, n = s - s.min(), n - 0.5 * (n.min() + n.max())
    length, width = float(np.ptp(s)), float(np.ptp(n))
    if length < SLENDER * max(width, 1e-9):
        return None
    pitch = width + 0.9  # from row to row
    rows = max(1, round(float(np.sqrt(length * SHEET[1] / (SHEET[0] * pitch)))))
    if rows == 1:
        return None
    radius = 0.5 * pitch
    straight = (length - (rows - 1) * np.pi * radius) / rows
    if straight <= 0.0:
        return None
    period = straight + np.pi * radius
    row = np.minimum(np.floor(s / period), rows - 1)
    along = s - row * period
    turn = np.clip((along - straight) / radius, 0.0, np.pi)
    x = np.minimum(along, straight) + (radius + n) * np.sin(turn)
    y = -row * pitch - radius + (radius + n) * np.cos(turn)
    odd = row % 2 == 1
    # odd rows run back: mirrored, and their outer side is the other one
    x_odd = straight - np.minimum(along, straight) - (radius - n) * np.sin(turn)
    y_odd = -row * pitch - radius + (radius - n) * np.cos(turn)
    return dict(zip(places, np.stack([np.where(odd, x_odd, x), np.where(odd, y_odd, y)], axis=1), strict=True))


def _relaxed(graph: nx.Graph[Node], places: Places, sizes: Sizes) -> Places:
    """Push apart what overlaps: nodes, and what is written on lines, each by as little as is needed."""
    names = list(places)
    number = {node: i for i, node in enumerate(names)}
    middles = np.array([places[node] for node in names], dtype=float)
    lines = [(number[a], number[b], *size) for a, b, size in graph.edges(data="label") if size is not None]
    ends = np.array([line[:2] for line in lines], dtype=np.int64).reshape(-1, 2)
    own = 0.5 * np.array([sizes[node] for node in names])
    half = np.concatenate([own, 0.5 * np.array([line[2:] for line in lines]).reshape(-1, 2)])
    half = half + 0.25 * MARGIN
    half[: len(names)] += 0.25 * MARGIN
    first, second = np.triu_indices(len(half), k=1)
    for _ in range(ROUNDS):
        boxes = np.concatenate([middles, _label_middles(middles, own, ends)])
        apart = boxes[second] - boxes[first]
        over = half[first] + half[second] - np.abs(apart)
        hit = np.flatnonzero((over > 1e-6).all(axis=1))
        if not hit.size:
            break
        axis = over[hit].argmin(axis=1)
        push = np.zeros((hit.size, 2))
        side = np.where(apart[hit, axis] >= 0.0, 1.0, -1.0)
        push[np.arange(hit.size), axis] = 0.25 * side * over[hit, axis]
        moved = np.zeros_like(boxes)
        np.add.at(moved, first[hit], -push)
        np.add.at(moved, second[hit], push)
        middles = middles + moved[: len(names)]
        np.add.at(middles, ends[:, 0], moved[len(names) :])
        np.add.at(middles, ends[:, 1], moved[len(names) :])
    return dict(zip(names, middles, strict=True))


def _label_middles(middles: Floats, half: Floats, ends: Ints) -> Floats:
    """Middles of the visible parts of lines, shape (lines, 2)."""
    a, b = middles[ends[:, 0]], middles[ends[:, 1]]
    along = np.maximum(np.abs(b - a), 1e-9)
    inside = [np.minimum((half[ends[:, k]] / along).min(axis=1), 0.5) for k in (0, 1)]
    return np.asarray(a + (0.5 * (1.0 + inside[0] - inside[1]))[:, None] * (b - a))


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
    number = {node: i for i, node in enumerate(places)}
    middles = np.array(list(places.values()))
    half = 0.5 * np.array([sizes[node] for node in places])
    ends = np.array([(number[a], number[b]) for a, b, drawn in graph.edges(data="drawn") if drawn], dtype=np.int64)
    ends = ends.reshape(-1, 2)
    first, second = np.triu_indices(len(ends), k=1)
    strangers = (ends[first][:, :, None] != ends[second][:, None, :]).all(axis=(1, 2))
    a, b = (middles[ends[first[strangers], k]] for k in (0, 1))
    c, d = (middles[ends[second[strangers], k]] for k in (0, 1))
    count = int(_cross(a, b, c, d).sum())
    line, node = (part.ravel() for part in np.meshgrid(np.arange(len(ends)), np.arange(len(middles)), indexing="ij"))
    others = (ends[line] != node[:, None]).all(axis=1)
    a, b, centre, corner = (v[others] for v in (*middles[ends[line]].transpose(1, 0, 2), middles[node], half[node]))
    mirrored = corner * (1.0, -1.0)
    through = _cross(a, b, centre - corner, centre + corner) | _cross(a, b, centre - mirrored, centre + mirrored)
    return count + int(through.sum())


def _cross(a: Floats, b: Floats, c: Floats, d: Floats) -> NDArray[np.bool_]:
    """Whether segments from a to b cross those from c to d, each of shape (m, 2)."""

    def side(p: Floats, q: Floats, r: Floats) -> Floats:
        return np.asarray((q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0]))

    return np.asarray((side(a, b, c) * side(a, b, d) < 0.0) & (side(c, d, a) * side(c, d, b) < 0.0))
