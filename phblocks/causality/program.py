"""What propagation leaves open: the choice with the fewest switches.

Where every open port has at most one tie, as the ends of beams, the choice is a matching: a tie whose two ports both
give serves two junctions at no cost, every junction left over takes its cheapest other giver. That is solved exactly
in polynomial time (Edmonds' blossoms). Everything else is a 0/1 program.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from phblocks.causality.problem import Problem
from phblocks.triplets import Triplets

#: Price of a requirement that cannot be met, above all switches.
NEVER = 1e6
#: Nodes of the search for the fewest unsatisfied junctions, which needs no proof of being the fewest.
NODES = 2000


@dataclass(frozen=True)
class Choice:
    """A choice of the program.

    Parameters
    ----------
    gives : mapping of int to bool
        For each open port.
    cost : float
        Of the switches.
    """

    gives: Mapping[int, bool]
    cost: float


def choose(problem: Problem, values: Sequence[bool | None], open_: Collection[int]) -> Choice | None:
    """Choose for ports that depend on each other, at the least cost.

    Parameters
    ----------
    problem : Problem
        Ports, junctions and ties.
    values : sequence of bool or None
        What is decided.
    open_ : collection of int
        The ports to choose for: a component of those that are open.

    Returns
    -------
    Choice or None
        ``None`` if there is none.
    """
    ports = sorted(open_)
    here = set(ports)
    ties = sorted({t for p in ports for t in problem.ties_of[p] if problem.ties[t].cost != 0.0})
    simple = all(len(problem.junctions_of[p]) == 1 for p in ports)
    simple &= not any(problem.ties[t].opposite for t in ties)
    simple &= all(sum(problem.ties[t].cost != 0.0 for t in problem.ties_of[p]) <= 1 for p in ports)
    if not simple:
        return solve(problem, values, ports)
    return _match(problem, values, here, ties)


def _match(problem: Problem, values: Sequence[bool | None], here: set[int], ties: Sequence[int]) -> Choice | None:
    """Match junctions by ties; a junction that stays alone takes the cheapest giver of its own."""
    junction = {p: problem.junctions_of[p][0] for p in here}
    alone: dict[int, tuple[float, int]] = {}  # for each junction the cheapest giver of its own
    pairs: list[tuple[int, int]] = []
    base = 0.0
    tied: dict[int, float] = {}  # what giving costs more than taking
    for t in ties:
        a, b = problem.ends[t]
        cost = problem.ties[t].cost
        price = NEVER if cost is None else cost
        if a in here and b in here:
            tied[a] = tied[b] = price
            if junction[a] != junction[b]:
                pairs.append((a, b))
        else:
            p, other = (a, b) if a in here else (b, a)
            base += price if values[other] else 0.0
            tied[p] = -price if values[other] else price
    for p in sorted(here):
        alone[junction[p]] = min(alone.get(junction[p], (np.inf, -1)), (tied.get(p, 0.0), p))
    mate = _matching([(junction[a], junction[b]) for a, b in pairs], {j: c for j, (c, _) in alone.items()})
    gives = dict.fromkeys(sorted(here), False)
    cost = base
    by_pair: dict[frozenset[int], tuple[int, int]] = {}
    for a, b in pairs:
        by_pair.setdefault(frozenset((junction[a], junction[b])), (a, b))
    for pair in mate:
        for p in by_pair[pair]:
            gives[p] = True
    matched = {j for pair in mate for j in pair}
    for j, (price, p) in alone.items():
        if j not in matched:
            gives[p] = True
            cost += price
    return Choice(gives, cost) if cost < 0.5 * NEVER else None


def _matching(pairs: Sequence[tuple[int, int]], price: Mapping[int, float]) -> set[frozenset[int]]:
    """Find the matching that saves most: each matched junction saves the price of staying alone."""
    import networkx as nx

    graph: nx.Graph[int] = nx.Graph()
    for a, b in pairs:
        if price[a] + price[b] > 0.0:
            graph.add_edge(a, b)
    mate = _leaves(graph, price)
    for a, b in graph.edges:
        graph[a][b]["weight"] = price[a] + price[b]
    for a, b in nx.max_weight_matching(graph):
        mate.add(frozenset((a, b)))
    return mate


def _leaves(graph: object, price: Mapping[int, float]) -> set[frozenset[int]]:
    """Match junctions with one neighbour first, and take both out: no matching is better where all prices are alike.

    Of a neighbour that could be matched elsewhere instead, the saving would be the same.
    """
    mate: set[frozenset[int]] = set()
    leaves = sorted((j for j in graph if graph.degree(j) == 1), reverse=True)  # type: ignore[attr-defined]
    while leaves:
        leaf = leaves.pop()
        if leaf not in graph or graph.degree(leaf) != 1:  # type: ignore[operator,attr-defined]
            continue
        (other,) = graph[leaf]  # type: ignore[index]
        beyond = [j for j in graph[other] if j != leaf]  # type: ignore[index]
        if any(price[j] > price[leaf] for j in beyond):
            continue  # a dearer one may need the neighbour
        mate.add(frozenset((leaf, other)))
        graph.remove_nodes_from((leaf, other))  # type: ignore[attr-defined]
        leaves += sorted((j for j in beyond if graph.degree(j) == 1), reverse=True)  # type: ignore[attr-defined]
    return mate


def solve(
    problem: Problem,
    values: Sequence[bool | None],
    ports: Sequence[int],
    violations: bool = False,
) -> Choice | None:
    """Choose by a 0/1 program, with the least cost of switches or the fewest junctions that stay unsatisfied.

    Parameters
    ----------
    problem : Problem
        Ports, junctions and ties.
    values : sequence of bool or None
        What is decided.
    ports : sequence of int
        The ports to choose for, in order.
    violations : bool, optional
        Junctions may have too few or too many givers, at a price of one each; switches are free.

    Returns
    -------
    Choice or None
        ``None`` if there is none.
    """
    from scipy.optimize import Bounds, LinearConstraint, milp

    column = {p: i for i, p in enumerate(ports)}
    junctions = sorted({j for p in ports for j in problem.junctions_of[p]})
    ties = sorted({t for p in ports for t in problem.ties_of[p] if problem.ties[t].cost != 0.0})
    if violations:
        ties = [t for t in ties if problem.ties[t].cost is None]
    n, k, m = len(ports), len(ties), len(junctions)
    at, wanted = [], np.zeros(m)
    for row, j in enumerate(junctions):
        decided = [p for p in problem.members[j] if p not in column]
        wanted[row] = 1 - problem.outside[j] - sum(bool(values[p]) for p in decided)
        at += [(row, column[p]) for p in problem.members[j] if p in column]
    entries = [Triplets.of(*np.array(at, dtype=int).reshape(-1, 2).T, values=1.0)]
    rows = np.arange(m)
    entries += [Triplets.of(rows, n + k + rows, values=1.0), Triplets.of(rows, n + k + m + rows, values=-1.0)]
    # a tie is broken if first - second or second - first is 1, with second turned round for an opposite one
    high = np.concatenate([wanted, np.zeros(2 * k)])
    for i, t in enumerate(ties):
        for sign, row in ((1.0, m + i), (-1.0, m + k + i)):
            entries.append(Triplets.of([row], [n + i], values=-1.0))
            opposite = problem.ties[t].opposite
            for p, factor in zip(problem.ends[t], (sign, sign if opposite else -sign), strict=True):
                if p in column:
                    entries.append(Triplets.of([row], [column[p]], values=factor))
                else:
                    high[row] -= factor * bool(values[p])
            high[row] += sign if opposite else 0.0
    price = np.array([0.0 if violations or c is None else c for c in (problem.ties[t].cost for t in ties)])
    result = milp(
        np.concatenate([np.zeros(n), price, np.full(2 * m, 1.0)]),
        integrality=np.concatenate([np.ones(n), np.zeros(k + 2 * m)]),
        bounds=Bounds(
            np.concatenate([[float(problem.fixed(p) is True) for p in ports], np.zeros(k + 2 * m)]),
            np.concatenate(
                [
                    [float(problem.fixed(p) is not False) for p in ports],
                    [float(problem.ties[t].cost is not None) for t in ties],
                    np.full(2 * m, np.inf if violations else 0.0),
                ]
            ),
        ),
        constraints=LinearConstraint(
            Triplets.join(entries).csr((m + 2 * k, n + k + 2 * m)).tocsc(),
            np.concatenate([wanted, np.full(2 * k, -np.inf)]),
            high,
        ),
        options={"node_limit": NODES} if violations else None,
    )
    if result.x is None:
        return None
    return Choice({p: bool(result.x[i] > 0.5) for p, i in column.items()}, float(price @ result.x[n : n + k]))
