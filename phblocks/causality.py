"""Who gives and who takes at every junction.

Exactly one port of a junction gives the common quantity (velocity), the others take it and give the summed one
(force).  Blocks say what their ports are able to do and which choices depend on each other; the assignment with
the fewest switches inside beams is a 0/1 program.  If it has no solution, a second program finds the fewest
junctions that cannot be satisfied, so that an impossible diagram is answered with the junctions at fault.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from phblocks.blocks.block import PortChoice, Tie
from phblocks.errors import CausalityError
from phblocks.network import Junction, Network
from phblocks.ports import Port
from phblocks.triplets import Triplets


@dataclass(frozen=True)
class Assignment:
    """What one port gives and takes.

    Parameters
    ----------
    port : Port
        The port.
    gives : bool
        It gives the common quantity (velocity) and takes the summed one (force); otherwise the other way round.
    junction : Junction
        Where it is joined.
    fixed : bool
        The block leaves no choice.
    """

    port: Port
    gives: bool
    junction: Junction
    fixed: bool

    @property
    def given(self) -> str:
        """Name of the quantity the port gives."""
        domain = self.port.domain
        return (domain.common if self.gives else domain.summed).name

    @property
    def taken(self) -> str:
        """Name of the quantity the port takes."""
        domain = self.port.domain
        return (domain.summed if self.gives else domain.common).name


@dataclass(frozen=True)
class Conflict:
    """A junction at which not exactly one port can give.

    Parameters
    ----------
    junction : Junction
        The junction.
    text : str
        What is wrong, naming every port.
    """

    junction: Junction
    text: str


@dataclass(frozen=True)
class CausalityReport:
    """Result of checking a diagram.

    Parameters
    ----------
    assignments : tuple of Assignment
        One for each port, in the order of blocks and ports.
    conflicts : tuple of Conflict
        Empty if the diagram is causal.
    repairs : tuple of str
        What to change, one for each conflict.
    switches : tuple of str
        The switches inside blocks that the assignment needs.
    """

    assignments: tuple[Assignment, ...]
    conflicts: tuple[Conflict, ...]
    repairs: tuple[str, ...]
    switches: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """Whether every junction has exactly one giver."""
        return not self.conflicts

    def gives(self, block: str) -> Mapping[str, bool]:
        """Look up the assignment of a block.

        Parameters
        ----------
        block : str
            Its name.

        Returns
        -------
        mapping of str to bool
            For each of its ports whether it gives the common quantity.
        """
        return {a.port.name: a.gives for a in self.assignments if a.port.block.name == block}

    def __str__(self) -> str:
        """Format the assignments as a table, with conflicts, repairs and switches below it."""
        rows = [("port", "gives", "takes", "joined to")]
        for a in self.assignments:
            if a.port.block.shared:
                continue
            others = [p.path for p in a.junction.ports if p is not a.port]
            others += [f"outside {e.name!r}" for e in a.junction.exposures]
            rows.append((a.port.path, a.given, a.taken, ", ".join(others) or f"nothing: {a.taken} 0"))
        widths = [max(len(r[c]) for r in rows) for c in range(4)]
        lines = ["  ".join(cell.ljust(w) for cell, w in zip(r, widths, strict=True)).rstrip() for r in rows]
        lines.insert(1, "-" * max(map(len, lines)))
        lines += [f"switch: {text}" for text in self.switches]
        lines += [f"conflict: {c.text}" for c in self.conflicts]
        lines += [f"repair: {r}" for r in self.repairs]
        lines.append("causal" if self.ok else "not causal")
        return "\n".join(lines)

    def raise_if_impossible(self) -> None:
        """Raise if the diagram is not causal.

        Raises
        ------
        CausalityError
            Naming the junctions, every port on them, and what to change.
        """
        if not self.ok:
            raise CausalityError(
                "diagram",
                expected="exactly one port that gives the common quantity at every junction",
                got="; ".join(c.text for c in self.conflicts),
                fix=" ".join(dict.fromkeys(self.repairs)),
            )


def assign_causality(network: Network) -> CausalityReport:
    """Choose who gives at every junction, with the fewest switches.

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
    choices: dict[Port, PortChoice] = {}
    ties: list[Tie] = []
    for name in sorted(network.blocks):
        block_choices, block_ties = network.blocks[name].choices()
        choices |= {c.port: c for c in sorted(block_choices, key=lambda c: c.port.name)}
        ties += block_ties
    junctions = sorted(network.junctions(), key=lambda j: sorted(p.path for p in j.ports))
    solved = _solve(choices, ties, junctions) or _solve(choices, ties, junctions, violations=True)
    assert solved is not None  # the second program always has a solution
    gives, violated = solved
    held = [i for i, junction in enumerate(junctions) if _is_open_to_nothing(junction)]
    conflicts = tuple(_conflict(junctions[i], choices) for i in sorted({*violated, *held}))
    where = {port: j for j in network.junctions() for port in j.ports if not port.block.shared}
    assignments = tuple(
        Assignment(port, gives[port], where[port] if port in where else _alone(port), _is_fixed(choices[port]))
        for block in network.blocks.values()
        for port in block.ports.values()
    )
    switches = tuple(t.what for t in ties if t.broken(gives[t.first], gives[t.second]))
    repairs = tuple(_repair(c.junction, choices, ties) for c in conflicts)
    return CausalityReport(assignments, conflicts, repairs, switches)


def _alone(port: Port) -> Junction:
    return Junction((port,), "shared")


def _is_fixed(choice: PortChoice) -> bool:
    return not (choice.may_give and choice.may_take)


def _solve(
    choices: Mapping[Port, PortChoice],
    ties: Sequence[Tie],
    junctions: Sequence[Junction],
    violations: bool = False,
) -> tuple[dict[Port, bool], list[int]] | None:
    """Find 0/1 choices (1: the port gives) with the least cost of switches, or with the fewest violated junctions.

    Unknowns are the choices, whether each tie differs, and how many givers each junction has too few or too many.
    """
    from scipy.optimize import Bounds, LinearConstraint, milp

    number = {port: i for i, port in enumerate(choices)}
    n, k, m = len(choices), len(ties), len(junctions)
    i, j = np.arange(k), np.arange(m)
    first, second = (np.array([number[p] for p in ends], dtype=int) for ends in _ends(ties))
    opposite = np.array([t.opposite for t in ties], dtype=float)
    side = 1.0 - 2.0 * opposite
    at = np.array([(row, number[port]) for row, junction in enumerate(junctions) for port in junction.ports], dtype=int)
    at = at.reshape(-1, 2)
    matrix = Triplets.join(
        [
            # one giver at each junction, the outside counted
            Triplets.of(at[:, 0], at[:, 1], values=1.0),
            Triplets.of(j, n + k + j, values=1.0),
            Triplets.of(j, n + k + m + j, values=-1.0),
            # a tie differs if first - second or second - first is 1; for an opposite one second is 1 - second
            *(Triplets.of(m + i, column, values=v) for column, v in ((first, 1.0), (second, -side), (n + i, -1.0))),
            *(Triplets.of(m + k + i, column, values=v) for column, v in ((first, -1.0), (second, side), (n + i, -1.0))),
        ]
    ).csr((m + 2 * k, n + k + 2 * m))
    wanted = np.array([1.0 - sum(e.gives for e in junction.exposures) for junction in junctions])
    cost_of_ties = np.array([0.0 if violations or t.cost is None else t.cost for t in ties])
    result = milp(
        np.concatenate([np.zeros(n), cost_of_ties, np.full(2 * m, 1.0)]),
        integrality=np.concatenate([np.ones(n), np.zeros(k + 2 * m)]),
        bounds=Bounds(
            np.concatenate([[0.0 if c.may_take else 1.0 for c in choices.values()], np.zeros(k + 2 * m)]),
            np.concatenate(
                [
                    [1.0 if c.may_give else 0.0 for c in choices.values()],
                    [0.0 if t.cost is None else 1.0 for t in ties],
                    np.full(2 * m, np.inf if violations else 0.0),
                ]
            ),
        ),
        options={"mip_rel_gap": 0.0},
        constraints=LinearConstraint(
            matrix.tocsc(),
            np.concatenate([wanted, np.full(2 * k, -np.inf)]),
            np.concatenate([wanted, opposite, -opposite]),
        ),
    )
    if result.x is None:
        return None
    gives = {port: bool(result.x[i] > 0.5) for port, i in number.items()}
    excess = result.x[n + k : n + k + m] + result.x[n + k + m :]
    return gives, [int(row) for row in np.flatnonzero(excess > 0.5)]


def _ends(ties: Sequence[Tie]) -> tuple[list[Port], list[Port]]:
    return [t.first for t in ties], [t.second for t in ties]


def _is_open_to_nothing(junction: Junction) -> bool:
    """Whether an exposed quantity could not act: the junction is held, by the ground or by another exposure."""
    held = any(port.block.shared for port in junction.ports)
    giving = sum(e.gives for e in junction.exposures)
    return len(junction.exposures) > giving and (held or giving > 0)


def _conflict(junction: Junction, choices: Mapping[Port, PortChoice]) -> Conflict:
    common = junction.domain.common.name
    parts = []
    for port in junction.ports:
        choice = choices[port]
        able = (
            "can only take" if not choice.may_give else "can only give" if not choice.may_take else "may give or take"
        )
        parts.append(f"{port.path} {able} {common}")
    parts += [f"outside {e.name!r} {'gives' if e.gives else 'takes'} {common}" for e in junction.exposures]
    return Conflict(junction, f"junction [{junction.name}] ({junction.made_by}): {', '.join(parts)}")


def _repair(junction: Junction, choices: Mapping[Port, PortChoice], ties: Sequence[Tie]) -> str:
    """Say what to change so that exactly one port of the junction gives."""
    if _is_open_to_nothing(junction):
        return f"[{junction.name}] is held: expose it without the ground, or read what holds it from the solution."
    able = [p for p in junction.ports if choices[p].may_give]
    common, summed = junction.domain.common.name, junction.domain.summed.name
    stiff = [t for t in ties if t.cost is None and {t.first, t.second} & set(junction.ports)]
    if stiff:
        names = sorted({t.first.block.name for t in stiff})
        return f"Give {', '.join(names)} at least two elements, so that the ends can choose differently."
    if not able:
        names = [p.path for p in junction.ports]
        if len(names) == 1 and not junction.exposures:
            return (
                f"{names[0]} takes {common} and nothing gives it: join it, attach it to the ground, "
                f'expose it with imposes="{common}", or let its block choose (causality="auto").'
            )
        return f'Let one of {", ".join(names)} give {common} (for a beam: causality="auto").'
    fixed = [p.path for p in able if not choices[p].may_take]
    fixed += [f"outside {e.name!r}" for e in junction.exposures if e.gives]
    return (
        f"Let all but one of {', '.join(fixed or [p.path for p in able])} take {common} and give {summed} "
        '(for a beam: causality="auto", or a pinned or clamped end).'
    )
