"""Ports of one team at a junction: those that can give together, and do so where that is surely best.

Giving what another port of the junction gives already saves states, and costs a switch only if the port's mate at the
other end of its block takes. So two ends of a beam that can both give without keeping anybody else from giving do so:
most of a welded frame is decided here, port by port, and little is left to a program.
"""

from __future__ import annotations

from collections.abc import Sequence

from phblocks.causality.problem import Problem


def give_together(problem: Problem, values: list[bool | None], ports: Sequence[int]) -> dict[int, bool]:
    """Decide what no other choice could better.

    Parameters
    ----------
    problem : Problem
        Ports, junctions and ties.
    values : list of bool or None
        What is decided; changed in place.
    ports : sequence of int
        The ports to choose for, in order.

    Returns
    -------
    dict of int to bool
        The ports decided here.
    """
    decided: dict[int, bool] = {}

    def decide(p: int, gives: bool) -> None:
        values[p] = decided[p] = gives

    ports = [p for p in ports if _harmless(problem, values, p)]
    mates = {p: _mates(problem, p) for p in ports}
    eligible = {p for p in ports if mates[p] is not None}
    for p in ports:
        for q in mates[p] or ():
            if values[q] is None and q not in eligible:
                eligible.discard(p)
    for p in ports:
        if p in eligible and all(values[q] is not False for q in mates[p] or ()):
            decide(p, True)
    # what is left here has a mate that takes: it gives only where nobody else does
    left = [p for p in ports if p in eligible and values[p] is None]
    for p in left:
        (j,) = problem.junctions_of[p]
        if not any(values[q] for q in problem.members[j]):
            open_ = [q for q in problem.members[j] if values[q] is None]
            if any(q not in eligible for q in open_):
                continue
            decide(min(open_, key=lambda q: (_price(problem, q), q)), True)
    for p in left:
        (j,) = problem.junctions_of[p]
        if values[p] is None and any(values[q] for q in problem.members[j]):
            decide(p, False)
    return decided


def _harmless(problem: Problem, values: Sequence[bool | None], p: int) -> bool:
    """Whether nobody is kept from giving at the junction of a port by its giving there."""
    if len(problem.junctions_of[p]) != 1:
        return False
    (j,) = problem.junctions_of[p]
    rivals = [q for q in problem.members[j] if values[q] is not False]
    return p in problem.teams[j] and not problem.outside[j] and all(problem.together(j, p, q) for q in rivals)


def _mates(problem: Problem, p: int) -> list[int] | None:
    """The ports that a port is tied to at a price; None if the ties are not as simple as those of a beam."""
    ties = [t for t in problem.ties_of[p] if problem.ties[t].cost != 0.0]
    if len(ties) > 1 or any(problem.ties[t].opposite for t in ties):
        return None
    return [b if a == p else a for a, b in (problem.ends[t] for t in ties)]


def _price(problem: Problem, p: int) -> float:
    return sum(problem.ties[t].cost or 0.0 for t in problem.ties_of[p])
