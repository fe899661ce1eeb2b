"""From a network to the report: forced choices first, then the cheapest for the rest, then what is impossible."""

from __future__ import annotations

from phblocks.causality.conflicts import Conflict, find_conflicts, held, least_violation
from phblocks.causality.explanation import Explanation
from phblocks.causality.problem import Problem
from phblocks.causality.program import choose
from phblocks.causality.propagation import CHOSEN, Reason, propagate
from phblocks.causality.report import Assignment, CausalityReport
from phblocks.network import Junction, Network


def assign_causality(network: Network) -> CausalityReport:
    """Choose who gives at every junction, at the least cost: a switch counts one, a port that shares states saves 0.4.

    Where ports can share and more than forty of them depend on each other, a good choice is searched for, without proof
    that it is the cheapest; :meth:`CausalityReport.explain` says so.

    Parameters
    ----------
    network : Network
        Blocks and junctions.

    Returns
    -------
    CausalityReport
        Also for a diagram that is not causal. It does not depend on the order in which blocks and junctions were
        added.
    """
    problem = Problem.of(network)
    forced = propagate(problem)
    values, reasons, programs = list(forced.values), list(forced.reasons), {}
    impossible: set[int] = set()
    if forced.clashes:
        impossible = {p for clash in forced.clashes for p in _ports(problem, clash)}
    open_ = [p for p, value in enumerate(values) if value is None]
    for ports in _groups(problem, open_):
        choice = None if impossible.intersection(ports) else choose(problem, values, ports)
        if choice is None:
            impossible.update(ports)
            continue
        aim = f"the {'cheapest' if choice.proven else 'cheapest found'} for the {len(ports)} ports left open here"
        aim += " (a switch counts 1, a port that shares its states -0.4)"
        for p, gives in choice.gives.items():
            values[p], reasons[p], programs[p] = gives, Reason(CHOSEN, None), aim
    conflicts: list[Conflict] = []
    if impossible:
        of_port, _ = problem.components()
        wrong = sorted({int(of_port[p]) for p in impossible if not problem.port(p).block.shared})
        for label in wrong:
            ports = [p for p in range(len(values)) if of_port[p] == label]
            for p, gives in least_violation(problem, ports).items():
                values[p] = gives
                if problem.fixed(p) is None:
                    reasons[p], programs[p] = Reason(CHOSEN, None), "as few junctions unsatisfied as can be"
            conflicts += find_conflicts(problem, [bool(v) for v in values], ports)
    conflicts += [c for c in held(problem) if all(c.junction is not other.junction for other in conflicts)]
    conflicts.sort(key=lambda c: c.junction.name)
    final = [bool(value) for value in values]
    gives_of = {choice.port: final[p] for p, choice in enumerate(problem.choices)}
    fixed = {choice.port: problem.fixed(p) is not None for p, choice in enumerate(problem.choices)}
    where = {port: j for j in problem.junctions for port in j.ports if not port.block.shared}
    assignments = tuple(
        Assignment(port, gives_of[port], where.get(port) or Junction((port,), "shared"), fixed[port])
        for block in network.blocks.values()
        for port in block.ports.values()
    )
    switches = tuple(
        t.what for t, (a, b) in zip(problem.ties, problem.ends, strict=True) if t.cost and t.broken(final[a], final[b])
    )
    explanation = Explanation(problem, final, reasons, programs)
    return CausalityReport(assignments, tuple(conflicts), switches, explanation, network)


def _ports(problem: Problem, clash: Reason) -> list[int]:
    """The ports that a clash concerns, shared ones left out."""
    ports = list(clash.parents)
    if clash.element and clash.element.kind == "junction":
        ports += problem.members[clash.element.number]
    return [p for p in ports if not problem.port(p).block.shared]


def _groups(problem: Problem, open_: list[int]) -> list[list[int]]:
    """Split the open ports into those that depend on each other, in the order of their names."""
    if not open_:
        return []
    label, _ = problem.components(open_)
    groups: dict[int, list[int]] = {}
    for p in open_:
        groups.setdefault(int(label[p]), []).append(p)
    return list(groups.values())
