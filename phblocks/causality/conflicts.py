"""What cannot hold together: the smallest set of junctions, fixed choices and ties that contradicts itself."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from phblocks.blocks.block import Tie
from phblocks.causality.problem import Element, Problem
from phblocks.causality.program import choose, solve
from phblocks.causality.propagation import GIVEN, propagate
from phblocks.errors import (
    CausalityError,
    DanglingPortError,
    HeldPortError,
    OverdeterminedError,
    UnderdeterminedError,
)
from phblocks.network import Junction
from phblocks.ports import Port

#: Checks spent on making a set smaller; more are needed only for sets of hundreds that are irreducible already.
CHECKS = 1000


@dataclass(frozen=True)
class Conflict:
    """Requirements that cannot hold together; without any one of them, the others can.

    Parameters
    ----------
    junction : Junction
        The one at which not exactly one port gives in what was assigned nevertheless.
    junctions : tuple of Junction
        All that take part.
    fixed : tuple of Port
        Ports that take part and whose block leaves no choice.
    ties : tuple of Tie
        Ports that take part and cannot differ (or cannot agree).
    text : str
        What is wrong, naming all of them and the calls that made them.
    advice : str
        What to do about it, in words.
    error : type
        The class of the error to raise.
    """

    junction: Junction
    junctions: tuple[Junction, ...]
    fixed: tuple[Port, ...]
    ties: tuple[Tie, ...]
    text: str
    advice: str
    error: type[CausalityError]


def find_conflicts(problem: Problem, values: Sequence[bool], ports: Collection[int]) -> list[Conflict]:
    """Find what is wrong in a component that has no solution, one set after the other.

    Parameters
    ----------
    problem : Problem
        Ports, junctions and ties.
    values : sequence of bool
        The assignment with the fewest junctions unsatisfied.
    ports : collection of int
        The ports of the component.

    Returns
    -------
    list of Conflict
        Each leaves out the junctions blamed by those before it, until the rest can hold.
    """
    here = set(ports)
    junctions = {j for p in here for j in problem.junctions_of[p] if not problem.port(p).block.shared}
    around = here | {p for j in junctions for p in problem.members[j]}
    where = {
        "choice": around,
        "junction": junctions,
        "tie": {t for p in here for t in problem.ties_of[p]},
    }
    elements = [e for e in problem.elements if e.number in where[e.kind]]
    unsatisfied = {j for j in junctions if not problem.satisfied(j, values)}
    conflicts = []
    blamed: set[Element] = set()
    while core := _core(problem, [e for e in elements if e not in blamed]):
        of_core = [e for e in core if e.kind == "junction"]
        blame = next((e for e in of_core if e.number in unsatisfied), of_core[0])
        blamed.add(blame)
        conflicts.append(_conflict(problem, blame.number, core))
    return conflicts


def held(problem: Problem) -> list[Conflict]:
    """Find openings to the outside that act on nothing, because the ground or another opening holds the junction.

    Parameters
    ----------
    problem : Problem
        Ports, junctions and ties.

    Returns
    -------
    list of Conflict
        One for each junction.
    """
    conflicts = []
    for j, junction in enumerate(problem.junctions):
        if len(junction.exposures) > problem.outside[j] and (
            problem.outside[j] or any(p.block.shared for p in junction.ports)
        ):
            advice = (
                f"[{junction.name}] is held: expose it without the ground, or read what holds it from the solution."
            )
            text = _at(problem, j)
            conflicts.append(Conflict(junction, (junction,), (), (), text, advice, HeldPortError))
    return conflicts


def _core(problem: Problem, elements: Sequence[Element]) -> list[Element]:
    """Return an irreducible subset that cannot hold; empty if all can."""
    start = _contradiction(problem, elements)
    if start is None:
        return []
    core = sorted(start)
    checks, size = 0, max(1, len(core) // 2)
    while True:  # leave out many at a time, then fewer, then one by one
        i = 0
        while i < len(core) and checks < CHECKS:
            checks += 1
            rest = core[:i] + core[i + size :]
            smaller = _contradiction(problem, rest)
            if smaller is None:
                i += size
            else:
                i = sum(e in smaller for e in core[:i])
                core = sorted(smaller)
        if size == 1 or checks >= CHECKS:
            return core
        size //= 2


def _contradiction(problem: Problem, elements: Collection[Element]) -> set[Element] | None:
    """Return requirements among these that cannot hold together, if there are any."""
    found = propagate(problem, elements)
    if found.clashes:
        return min((found.origin(clash) for clash in found.clashes), key=lambda s: (len(s), sorted(s)))
    rigid = [e.number for e in elements if e.kind == "tie"]
    if not rigid:
        return None  # junctions without ties: propagation is complete
    part = _restricted(problem, elements)
    values = found.values
    open_ = [p for p in range(len(part.choices)) if values[p] is None and part.junctions_of[p]]
    label, _ = part.components(open_)
    groups: dict[int, list[int]] = {}
    for p in open_:
        groups.setdefault(int(label[p]), []).append(p)
    for group in groups.values():
        if choose(part, values, group) is None:
            numbers = {j for p in group for j in part.junctions_of[p]}
            names = {part.junctions[j] for j in numbers}
            core = {e for e in elements if e.kind == "junction" and problem.junctions[e.number] in names}
            core |= {e for e in elements if e.kind == "tie" and set(problem.ends[e.number]) & set(group)}
            for j in numbers:
                for p in part.members[j]:
                    reason = found.reasons[p]
                    core |= found.origin(reason) if reason else set()
            return core
    return None


def _restricted(problem: Problem, elements: Collection[Element]) -> Problem:
    """Keep only these junctions and ties; ports keep their numbers."""
    junctions = sorted(e.number for e in elements if e.kind == "junction")
    ties = sorted(e.number for e in elements if e.kind == "tie")
    return Problem(
        problem.choices,
        [problem.junctions[j] for j in junctions],
        [problem.members[j] for j in junctions],
        [problem.outside[j] for j in junctions],
        [problem.ties[t] for t in ties],
        [problem.ends[t] for t in ties],
        [problem.teams[j] for j in junctions],
    )


def least_violation(problem: Problem, ports: Sequence[int]) -> dict[int, bool]:
    """Assign a component that has no solution, with as few junctions unsatisfied as can be.

    Parameters
    ----------
    problem : Problem
        Ports, junctions and ties.
    ports : sequence of int
        The ports of the component.

    Returns
    -------
    dict of int to bool
        For each port whether it gives.
    """
    fixed = [problem.fixed(p) for p in range(len(problem.choices))]
    choice = solve(problem, fixed, ports, violations=True)
    if choice is None:  # the search was cut short: take what is given
        return {p: fixed[p] is not False for p in ports}
    return dict(choice.gives)


def _conflict(problem: Problem, blame: int, core: Sequence[Element]) -> Conflict:
    numbers = [e.number for e in core if e.kind == "junction"]
    numbers.sort(key=lambda j: j != blame)
    fixed = tuple(problem.port(e.number) for e in core if e.kind == "choice")
    ties = tuple(problem.ties[e.number] for e in core if e.kind == "tie")
    text = "; ".join(_at(problem, j) for j in numbers)
    for t in ties:
        word = "agree" if t.opposite else "differ"
        text += f"; {t.first.path} and {t.second.path} cannot {word} (that would be {t.what})"
    junction = problem.junctions[blame]
    if len(numbers) == 1 and not ties:
        if len(junction.ports) == 1 and not junction.exposures:
            error: type[CausalityError] = DanglingPortError
        else:
            clash = propagate(problem, core).clashes[0]
            error = OverdeterminedError if clash.kind == GIVEN else UnderdeterminedError
    else:
        error = CausalityError
    advice = _advice(problem, blame, ties)
    return Conflict(junction, tuple(problem.junctions[j] for j in numbers), fixed, ties, text, advice, error)


def _at(problem: Problem, j: int) -> str:
    """Say what every port at a junction is able to do, and which calls made it."""
    junction = problem.junctions[j]
    common = junction.domain.common.name
    of = {problem.port(p): problem.choices[p] for p in problem.members[j]}
    parts = []
    for port in junction.ports:
        able = (
            "can only take"
            if not of[port].may_give
            else "can only give"
            if not of[port].may_take
            else "may give or take"
        )
        parts.append(f"{port.path} {able} {common}")
    for e in junction.exposures:
        call = f" ({e.made_by})" if e.made_by else ""
        parts.append(f"outside {e.name!r} {'gives' if e.gives else 'takes'} {common}{call}")
    return f"junction [{junction.name}] ({junction.made_by}): {', '.join(parts)}"


def _advice(problem: Problem, blame: int, ties: Sequence[Tie]) -> str:
    """Say what to change so that exactly one port of the junction gives."""
    junction = problem.junctions[blame]
    choices = {problem.port(p): problem.choices[p] for p in problem.members[blame]}
    common, summed = junction.domain.common.name, junction.domain.summed.name
    if ties:
        names = sorted({t.first.block.name for t in ties})
        return f"Let the ports of {', '.join(names)} choose for themselves (a beam: at least two elements)."
    able = [p for p in junction.ports if choices[p].may_give]
    if not able:
        names = [p.path for p in junction.ports]
        if len(names) == 1 and not junction.exposures:
            ways = ["join it", *(["attach it to the ground"] if junction.domain.turns_with else [])]
            ways.append(f'expose it with imposes="{common}"')
            ways += [other.what for other in junction.ports[0].block.alternatives()[:1]]
            return f"{names[0]} takes {common} and nothing gives it: {', '.join(ways[:-1])}, or {ways[-1]}."
        pushed = [f" Or let outside {e.name!r} impose {common}." for e in junction.exposures]
        return f'Let one of {", ".join(names)} give {common} (for a beam: causality="auto").' + "".join(pushed)
    imposed = [f"outside {e.name!r}" for e in junction.exposures if e.gives]
    fixed = [p.path for p in able if not choices[p].may_take]
    beams = ' (for a beam: causality="auto", or a pinned or clamped end)' if fixed else ""
    also = f" Or leave out {' or '.join(imposed)}, or impose {summed} there." if imposed else ""
    several = ", ".join([*fixed, *imposed] or [p.path for p in able])
    return f"Let all but one of {several} take {common} and give {summed}{beams}.{also}"
