"""The chain of reasons behind what a port gives, in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from phblocks.causality.problem import Problem
from phblocks.causality.propagation import CHOSEN, FIXED, GIVEN, LAST, Reason

#: Steps of a chain that are told; what lies further back is counted.
STEPS = 12


@dataclass(frozen=True)
class Explanation:
    """Why every port gives or takes.

    Parameters
    ----------
    problem : Problem
        Ports, junctions and ties.
    values : list of bool
        For each port whether it gives.
    reasons : list of Reason or None
        For each port.
    programs : mapping of int to str
        For ports that the program has chosen, what it was after.
    """

    problem: Problem
    values: list[bool]
    reasons: list[Reason | None]
    programs: Mapping[int, str]

    def chain(self, p: int) -> tuple[str, ...]:
        """Tell the reasons of a port, and theirs, the nearest first.

        Parameters
        ----------
        p : int
            Number of the port.

        Returns
        -------
        tuple of str
            One sentence a step.
        """
        told: list[str] = []
        queue, seen = [p], {p}
        while queue and len(told) < STEPS:
            port = queue.pop(0)
            told.append(self._sentence(port))
            reason = self.reasons[port]
            for parent in reason.parents if reason else ():
                if parent not in seen:
                    seen.add(parent)
                    queue.append(parent)
        if queue:
            told.append("and so on: ask explain() of the ports named last.")
        return tuple(told)

    def _does(self, p: int) -> str:
        port = self.problem.port(p)
        return f"{port.path} {'gives' if self.values[p] else 'takes'} {port.domain.common.name}"

    def _sentence(self, p: int) -> str:
        reason, does, port = self.reasons[p], self._does(p), self.problem.port(p)
        if reason is None or reason.kind == CHOSEN:
            return f"{does} because the program chose it: {self.programs.get(p, 'any choice would do')}."
        if reason.kind == FIXED:
            if port.block.shared:
                return f"{does}: it is the ground."
            return f"{does} because {type(port.block).__name__} {port.block.name!r} leaves no choice."
        assert reason.element is not None
        if reason.kind in (GIVEN, LAST):
            junction = self.problem.junctions[reason.element.number]
            where = f"junction [{junction.name}] ({junction.made_by})"
            if reason.kind == GIVEN:
                giver = [self.problem.port(q).path for q in reason.parents]
                giver += [f"outside {e.name!r}" for e in junction.exposures if e.gives and not giver]
                return f"{does} because {where} has its giver, {', '.join(giver)}."
            if len(junction.ports) == 1:
                common, summed = junction.domain.common.name, junction.domain.summed.name
                what = f"nothing else gives {common} there" if junction.exposures else f"it is free: {summed} 0"
                return f"{does} because {what} ({junction.made_by})."
            return f"{does} because nobody else is left to give at {where}."
        tie = self.problem.ties[reason.element.number]
        other = self.problem.port(reason.parents[0]).path
        word = "agree with" if tie.opposite else "differ from"
        return f"{does} because it cannot {word} {other}, that would be {tie.what}."
