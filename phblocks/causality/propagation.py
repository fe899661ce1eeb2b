"""Unit propagation: what follows without a choice, with the reason of each step.

Whether the others of a giver's team give too is a choice: propagation leaves it open.

Every port is decided once and every junction scanned at most twice, so the time is that of reading the diagram.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, field

from phblocks.causality.problem import Element, Problem

GIVEN = "given"  # the junction has its giver
LAST = "last"  # nobody else is left to give
FIXED = "fixed"  # the block leaves no choice
TIED = "tied"  # another port of the block has chosen
CHOSEN = "chosen"  # the program has chosen


@dataclass(frozen=True)
class Reason:
    """Why a port gives or takes.

    Parameters
    ----------
    kind : str
        One of the words above.
    element : Element or None
        The requirement it follows from; ``None`` for a choice of the program.
    parents : tuple of int
        Ports it follows from.
    """

    kind: str
    element: Element | None
    parents: tuple[int, ...] = ()


@dataclass
class Propagation:
    """What is decided, and why.

    Parameters
    ----------
    values : list of bool or None
        For each port whether it gives; ``None`` where that is open.
    reasons : list of Reason or None
        For each decided port.
    clashes : list of Reason
        Requirements that cannot hold with what was decided; the parents are at odds with it.
    """

    values: list[bool | None]
    reasons: list[Reason | None]
    clashes: list[Reason] = field(default_factory=list)

    def origin(self, reason: Reason) -> set[Element]:
        """Collect all requirements that a reason goes back to.

        Parameters
        ----------
        reason : Reason
            Of a decision or a clash.

        Returns
        -------
        set of Element
            The element of the reason, and those of its parents, and of theirs.
        """
        elements = {reason.element} if reason.element else set()
        seen, stack = set(reason.parents), list(reason.parents)
        while stack:
            step = self.reasons[stack.pop()]
            if step is None:
                continue
            if step.element:
                elements.add(step.element)
            new = [p for p in step.parents if p not in seen]
            seen.update(new)
            stack += new
        return elements


def propagate(problem: Problem, only: Collection[Element] | None = None) -> Propagation:
    """Decide what follows from the requirements.

    Parameters
    ----------
    problem : Problem
        Ports, junctions and ties.
    only : collection of Element, optional
        The requirements that count; all by default.

    Returns
    -------
    Propagation
        With every clash that was met; the requirement that clashed is passed over.
    """
    return _Run(problem, problem.elements if only is None else only).result


class _Run:
    """One propagation."""

    def __init__(self, problem: Problem, only: Collection[Element]) -> None:
        self.problem = problem
        n = len(problem.choices)
        self.result = Propagation([None] * n, [None] * n)
        self.queue: deque[int] = deque()
        elements = sorted(only)
        self.open = {e.number: len(problem.members[e.number]) for e in elements if e.kind == "junction"}
        self.giver: dict[int, tuple[int, ...]] = {}
        self.ties = {e.number for e in elements if e.kind == "tie"}
        for kind, number in elements:
            if kind == "choice":
                self._decide(number, bool(problem.fixed(number)), Reason(FIXED, Element(kind, number)))
        for j in self.open:
            if problem.outside[j] > 1:
                self.result.clashes.append(Reason(GIVEN, Element("junction", j)))
            elif problem.outside[j]:
                self._has_giver(j, ())
            elif self.open[j] == 1:
                self._last(j)
        while self.queue:
            self._follow(self.queue.popleft())

    def _decide(self, p: int, gives: bool, reason: Reason) -> None:
        known = self.result.values[p]
        if known is None:
            self.result.values[p], self.result.reasons[p] = gives, reason
            self.queue.append(p)
        elif known != gives:
            self.result.clashes.append(Reason(reason.kind, reason.element, (*reason.parents, p)))

    def _follow(self, p: int) -> None:
        gives = bool(self.result.values[p])
        for t in self.problem.ties_of[p]:
            if t in self.ties:
                a, b = self.problem.ends[t]
                other = b if p == a else a
                self._decide(other, gives != self.problem.ties[t].opposite, Reason(TIED, Element("tie", t), (p,)))
        for j in self.problem.junctions_of[p]:
            if j not in self.open:
                continue
            self.open[j] -= 1
            if gives:
                self._has_giver(j, (p,))
            elif j not in self.giver and self.open[j] <= 1:
                self._last(j)

    def _has_giver(self, j: int, giver: tuple[int, ...]) -> None:
        element = Element("junction", j)
        if j in self.giver:
            if self.giver[j] == giver:  # the ground named twice
                self.result.clashes.append(Reason(GIVEN, element, giver))
            return  # otherwise the first giver has clashed with this one already, or they give together
        self.giver[j] = giver
        for p in self.problem.members[j]:
            if (p,) != giver and not (giver and self.problem.together(j, p, giver[0])):
                self._decide(p, False, Reason(GIVEN, element, giver))

    def _last(self, j: int) -> None:
        values, members = self.result.values, self.problem.members[j]
        left = [p for p in members if values[p] is None]
        if any(values[p] for p in members) or len(left) > 1:
            return  # decided, and waiting in the queue
        reason = Reason(LAST, Element("junction", j), tuple(p for p in members if p not in left))
        if left:
            self._decide(left[0], True, reason)
        elif self.open[j] == 0:
            self.result.clashes.append(reason)
