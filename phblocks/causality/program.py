"""What propagation leaves open: the choice of the least cost, one a switch, less a part of it for states shared.

Where every open port has at most one tie, as the ends of beams, the choice is a matching: a tie whose two ports both
give serves two junctions at no cost, every junction left over takes its cheapest other giver. That is solved exactly
in polynomial time (Edmonds' blossoms). Everything else is a 0/1 program.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from phblocks.causality.problem import Problem
from phblocks.causality.search import TeamSearch
from phblocks.causality.teams import give_together
from phblocks.triplets import Floats, Triplets

#: Price of a requirement that cannot be met, above all switches.
NEVER = 1e6
#: What a port saves that gives what another gives already, being the same states; a switch costs one.
SAVING = 0.4
#: Ports up to which the cheapest choice is proven to be that where ports can give together.
PROVEN = 40
#: Nodes of the search for the fewest unsatisfied junctions, which needs no proof of being the fewest.
NODES = 2000


@dataclass(frozen=True)
class Choice:
    """A choice of the program.

    Parameters
    ----------
    gives : mapping of int to bool
        For each open port.
    proven : bool, optional
        There is none of less cost.
    """

    gives: Mapping[int, bool]
    proven: bool = True


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
    values = list(values)
    together = give_together(problem, values, sorted(open_))
    ports = [p for p in sorted(open_) if values[p] is None]
    if len(ports) < len(open_):
        rest = _choose(problem, values, ports) if ports else Choice({})
        return rest and Choice({**rest.gives, **together}, rest.proven)
    return _choose(problem, values, ports)


def _choose(problem: Problem, values: Sequence[bool | None], ports: Sequence[int]) -> Choice | None:
    here = set(ports)
    ties = sorted({t for p in ports for t in problem.ties_of[p] if problem.ties[t].cost != 0.0})
    simple = all(len(problem.junctions_of[p]) == 1 for p in ports)
    simple &= not any(problem.ties[t].opposite for t in ties)
    simple &= all(sum(problem.ties[t].cost != 0.0 for t in problem.ties_of[p]) <= 1 for p in ports)
    teams = any(p in problem.teams[j] for p in ports for j in problem.junctions_of[p])
    if not simple or (teams and len(ports) <= PROVEN):
        return solve(problem, values, ports)
    if not teams:
        return _match(problem, values, here, ties)
    search = TeamSearch(problem, values, ports, SAVING, NEVER)
    served = {j for p in ports for j in problem.junctions_of[p] if any(values[q] for q in problem.members[j])}
    held = list(values)
    for p in ports:
        if problem.junctions_of[p][0] in served:
            held[p] = False
    rest = {p for p in ports if held[p] is None}
    tied = sorted({t for p in rest for t in problem.ties_of[p] if problem.ties[t].cost != 0.0})
    alone = _match(problem, held, rest, tied) if rest else None
    starts = [{}] if alone is None else [alone.gives, {}]
    cost, gives = min((search.improved(search.from_givers(start)) for start in starts), key=lambda found: found[0])
    return Choice(gives, proven=False) if cost < 0.5 * NEVER else solve(problem, values, ports)


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
    return Choice(gives) if cost < 0.5 * NEVER else None


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
    program = _Program()
    column = {p: program.column(0.0, low=problem.fixed(p) is True, high=problem.fixed(p) is not False) for p in ports}
    for t in sorted({t for p in ports for t in problem.ties_of[p]}):
        tie, (a, b) = problem.ties[t], problem.ends[t]
        if tie.cost is None or not (violations or tie.cost == 0.0):
            broken = program.column(tie.cost or 0.0, high=tie.cost is not None)
            # broken >= first - second and second - first, with second turned round for an opposite one
            for sign in (1.0, -1.0):
                second, least = (sign, sign) if tie.opposite else (-sign, 0.0)
                given = [(p, f) for p, f in ((a, sign), (b, second)) if p not in column]
                terms = [(column[p], f) for p, f in ((a, sign), (b, second)) if p in column]
                known = sum(f * bool(values[p]) for p, f in given)
                program.row([*terms, (broken, -1.0)], high=least - known)
    for j in sorted({j for p in ports for j in problem.junctions_of[p]}):
        many = np.inf if violations else 0.0
        terms = [(program.column(1.0, high=many), 1.0), (program.column(1.0, high=many), -1.0)]
        wanted = 1.0 - problem.outside[j]
        teams: dict[int, list[int]] = {}
        for p in problem.members[j]:
            if p in problem.teams[j]:
                teams.setdefault(problem.teams[j][p], []).append(p)
            elif p in column:
                terms.append((column[p], 1.0))
            else:
                wanted -= bool(values[p])
        for team in teams.values():
            # a team gives if any of its ports does; each further one saves states
            saving = 0.0 if violations else SAVING
            gives = program.column(saving, low=any(values[p] for p in team if p not in column))
            for p in team:
                if p in column:
                    program.price[column[p]] -= saving
                    program.row([(column[p], 1.0), (gives, -1.0)], high=0.0)
            if not any(values[p] for p in team if p not in column):
                program.row([(gives, 1.0), *((column[p], -1.0) for p in team if p in column)], high=0.0)
            terms.append((gives, 1.0))
        program.row(terms, low=wanted, high=wanted)
    found = program.solved(NODES if violations else None)
    if found is None:
        return None
    return Choice({p: bool(found[i] > 0.5) for p, i in column.items()})


class _Program:
    """A linear program in numbers from 0 to 1, most of them whole, as it is written down."""

    def __init__(self) -> None:
        self.price: list[float] = []
        self._bounds: list[tuple[float, float]] = []
        self._rows: list[tuple[float, float]] = []
        self._entries: list[tuple[int, int, float]] = []

    def column(self, price: float, low: float = 0.0, high: float = 1.0) -> int:
        """Add an unknown; return its number."""
        self.price.append(price)
        self._bounds.append((float(low), float(high)))
        return len(self.price) - 1

    def row(self, terms: Sequence[tuple[int, float]], low: float = -np.inf, high: float = np.inf) -> None:
        """Add a sum of unknowns with its bounds."""
        self._entries += [(len(self._rows), column, factor) for column, factor in terms]
        self._rows.append((low, high))

    def solved(self, nodes: int | None) -> Floats | None:
        """Solve, in whole numbers; None if there is no solution."""
        from scipy.optimize import Bounds, LinearConstraint, milp

        rows, columns, factors = (np.array(c) for c in zip(*self._entries, strict=True))
        matrix = Triplets.of(rows, columns, values=factors).csr((len(self._rows), len(self.price))).tocsc()
        result = milp(
            np.array(self.price),
            integrality=np.ones(len(self.price)),
            bounds=Bounds(*np.array(self._bounds).T),
            constraints=LinearConstraint(matrix, *np.array(self._rows).T),
            options={} if nodes is None else {"node_limit": nodes},
        )
        return None if result.x is None else np.asarray(result.x)
