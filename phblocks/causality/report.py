"""The result of checking a diagram: who gives and who takes, why, what is wrong and what to do about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from phblocks.causality.conflicts import Conflict
from phblocks.causality.explanation import Explanation
from phblocks.causality.repairs import Repair, find_repairs
from phblocks.errors import ArgumentTypeError, CausalityError, UnknownNameError
from phblocks.network import Junction, Network
from phblocks.ports import Port


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
class CausalityReport:
    """Result of checking a diagram.

    Parameters
    ----------
    assignments : tuple of Assignment
        One for each port, in the order of blocks and ports.
    conflicts : tuple of Conflict
        Empty if the diagram is causal.
    switches : tuple of str
        The switches inside blocks that the assignment needs.
    explanation : Explanation
        The reason of every choice; read it with :meth:`explain`.
    network : Network
        What was checked.
    """

    assignments: tuple[Assignment, ...]
    conflicts: tuple[Conflict, ...]
    switches: tuple[str, ...]
    explanation: Explanation = field(repr=False)
    network: Network = field(repr=False)

    @property
    def ok(self) -> bool:
        """Whether every junction has exactly one giver, or several that share their states."""
        return not self.conflicts

    @cached_property
    def shared(self) -> tuple[tuple[Port, ...], ...]:
        """The ports that give together, being the same states: two or more of each such junction.

        In the order of their names, whatever the order of adding: the states of the first are those that are kept.
        """
        gives = {a.port: a.gives for a in self.assignments}
        givers = ([p for p in j.ports if gives[p]] for j in self.network.junctions())
        return tuple(tuple(sorted(g, key=lambda p: p.path)) for g in givers if len(g) > 1)

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

    @cached_property
    def repairs(self) -> tuple[Repair, ...]:
        """Changes after each of which the diagram is causal, the cheapest first; found when first asked for."""
        return find_repairs(self)

    def explain(self, port: Port | str) -> str:
        """Say why a port gives what it gives.

        Parameters
        ----------
        port : Port or str
            The port, or its path such as ``"crank.start.translation"``.

        Returns
        -------
        str
            One line for each step, the nearest reason first.

        Raises
        ------
        UnknownNameError
            If there is no such port.
        ArgumentTypeError
            If it is neither a port nor a text.
        """
        if not isinstance(port, (Port, str)):
            raise ArgumentTypeError("explain", expected="a port or its path", got=repr(port), fix="Give a port.")
        path = port if isinstance(port, str) else port.path
        for p, choice in enumerate(self.explanation.problem.choices):
            if choice.port is port or choice.port.path == path:
                return "\n".join(self.explanation.chain(p))
        raise UnknownNameError(
            "explain", expected="a port of the diagram", got=repr(path), fix="Write block.anchor.translation."
        )

    def __str__(self) -> str:
        """Format the assignments as a table, with conflicts, repairs and switches below it."""
        rows = [("port", "gives", "takes", "joined to")]
        for a in self.assignments:
            if a.port.block.shared:
                continue
            others = [p.path for p in a.junction.ports if p is not a.port]
            others += [f"outside {e.name!r}" for e in a.junction.exposures]
            none = "free" if a.junction.made_by.startswith("free") else "nothing"
            rows.append((a.port.path, a.given, a.taken, ", ".join(others) or f"{none}: {a.taken} 0"))
        widths = [max(len(r[c]) for r in rows) for c in range(4)]
        lines = ["  ".join(cell.ljust(w) for cell, w in zip(r, widths, strict=True)).rstrip() for r in rows]
        lines.insert(1, "-" * max(map(len, lines)))
        lines += [f"switch: {text}" for text in self.switches]
        lines += [f"shared states: {', '.join(p.path for p in ports)}" for ports in self.shared if self.ok]
        lines += [f"conflict: {c.text}" for c in self.conflicts]
        lines += [f"repair: {r}" for r in self.repairs] or [f"advice: {c.advice}" for c in self.conflicts]
        lines.append("causal" if self.ok else "not causal")
        return "\n".join(lines)

    def raise_if_impossible(self) -> None:
        """Raise if the diagram is not causal.

        Raises
        ------
        CausalityError
            Naming the junctions, every port on them, and what to change. Of a class of its own where all is of one
            kind: ``DanglingPortError``, ``OverdeterminedError``, ``UnderdeterminedError`` or
            ``HeldPortError``.
        """
        if self.ok:
            return
        kinds = {c.error for c in self.conflicts}
        error = kinds.pop() if len(kinds) == 1 else CausalityError
        advice = [c.advice for c in self.conflicts]
        advice += [f"report.repairs[{i}]: {repair.what}." for i, repair in enumerate(self.repairs)]
        raise error(
            "diagram",
            expected="exactly one port that gives the common quantity at every junction",
            got="; ".join(c.text for c in self.conflicts),
            fix=" ".join(dict.fromkeys(advice)),
        )
