"""Changes that make an impossible diagram causal, the cheapest first; each is tried before it is offered."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from phblocks.causality.steps import Step, steps_alike, steps_for
from phblocks.causality.wording import enumerated
from phblocks.network import Network

if TYPE_CHECKING:
    from phblocks.causality.report import CausalityReport
    from phblocks.diagram import Diagram


@dataclass(frozen=True)
class Cost:
    """What a repair costs.

    Parameters
    ----------
    states : int
        States added; negative if there are fewer.
    switches : int
        Switches inside blocks added.
    index : int
        Differential index added: 0 if no constraint is.
    stiffness : float or None
        Stiffness added, N/m or N m/rad; ``None`` if the parts stay as stiff as they were.
    frequency : float or None
        Highest frequency that the added stiffness or mass brings, rad/s, each joint for itself; see
        ``phblocks.causality.compliance`` for how both are chosen.
    mass : float or None
        Mass added, kg; ``None`` if the parts weigh what they did.
    demands : int
        How many of the user's requirements are given up: openings left out or turned round, attachments undone;
        or of ours made: a loose end attached to the ground.
    """

    states: int
    switches: int = 0
    index: int = 0
    stiffness: float | None = None
    frequency: float | None = None
    mass: float | None = None
    demands: int = 0


@dataclass(frozen=True)
class Repair:
    """A change after which the diagram is causal.

    Parameters
    ----------
    what : str
        The change in words.
    cost : Cost
        What it costs.
    change : callable
        From a network to one with the change, the given one untouched.
    """

    what: str
    cost: Cost
    change: Callable[[Network], Network] = field(repr=False)

    def apply(self, diagram: Diagram) -> Diagram:
        """Make the change.

        Parameters
        ----------
        diagram : Diagram
            The diagram that was checked; it is not changed.

        Returns
        -------
        Diagram
            A new one that is causal. Blocks that did not change are the same objects in both.
        """
        return diagram.with_network(self.change(diagram.network))

    def __str__(self) -> str:
        """Return the change and its cost."""
        cost = [f"states {self.cost.states:+d}"]
        cost += [f"switches {self.cost.switches:+d}"] if self.cost.switches else []
        cost += [f"index +{self.cost.index}"] if self.cost.index else []
        if self.cost.stiffness is not None:
            cost.append(f"stiffness {self.cost.stiffness:.3g}")
        if self.cost.mass is not None:
            cost.append(f"mass {self.cost.mass:.3g}")
        if self.cost.frequency is not None:
            cost.append(f"frequency {self.cost.frequency:.3g} rad/s")
        return f"{self.what} ({', '.join(cost)})"


def find_repairs(report: CausalityReport) -> tuple[Repair, ...]:
    """Try what could mend a diagram.

    Parameters
    ----------
    report : CausalityReport
        Of a diagram that is not causal.

    Returns
    -------
    tuple of Repair
        All that do; the best first: those that give up nothing the user asked for, then least index, then no
        stiffness or mass added, then fewest states and switches.
    """
    if report.ok:
        return ()
    found: dict[tuple[str, ...], Repair] = {}
    known = frozenset(report.network.blocks)
    for step in steps_for(report, known):
        steps = _completed(report, step, known)
        if steps is None:
            continue
        after = _checked(_all_of(steps)(report.network))
        cost = Cost(
            states=_states(after) - _states(report),
            switches=len(after.switches) - len(report.switches),
            index=max(s.index for s in steps),
            stiffness=max((s.stiffness for s in steps if s.stiffness is not None), default=None),
            frequency=max((s.frequency for s in steps if s.frequency is not None), default=None),
            mass=max((s.mass for s in steps if s.mass is not None), default=None),
            demands=sum(s.demands for s in steps),
        )
        found.setdefault(tuple(s.what for s in steps), Repair(_told(steps), cost, _all_of(steps)))
    return tuple(sorted(found.values(), key=_rank))


def _told(steps: Sequence[Step]) -> str:
    """All steps in words; of many of one kind the first."""
    kinds = dict.fromkeys(s.kind for s in steps)
    return ", and ".join(enumerated([s.what for s in steps if s.kind == k], ", and ", "of the kind") for k in kinds)


def _rank(repair: Repair) -> tuple[float | str, ...]:
    cost = repair.cost
    return (
        cost.demands,
        cost.index,
        cost.stiffness is not None or cost.mass is not None,
        cost.states,
        cost.switches,
        repair.what,
    )


def _completed(report: CausalityReport, step: Step, known: Collection[str]) -> list[Step] | None:
    """Go on with steps that help, of the same kind if there are, until the diagram is causal."""
    steps = [step]
    after = _checked(step.change(report.network))
    while not after.ok:
        if len(after.conflicts) >= len(report.conflicts):
            return None
        report = after
        more, after = _more(report, step.kind, known)
        steps += more
    return steps


def _more(report: CausalityReport, kind: str, known: Collection[str]) -> tuple[list[Step], CausalityReport]:
    """Mend all other conflicts in the same way at once, or the next one; none if that is not possible."""
    alike = steps_alike(report, kind, known)
    if len(alike) > 1 and (after := _checked(_all_of(alike)(report.network))).ok:
        return alike, after
    for step in sorted(steps_for(report, known), key=lambda s: s.kind != kind):
        after = _checked(step.change(report.network))
        if len(after.conflicts) < len(report.conflicts):
            return [step], after
    return [], report


def _checked(network: Network) -> CausalityReport:
    from phblocks.causality.assignment import assign_causality

    return assign_causality(network)


def _all_of(steps: Sequence[Step]) -> Callable[[Network], Network]:
    def change(network: Network) -> Network:
        for step in steps:
            network = step.change(network)
        return network

    return change


def _states(report: CausalityReport) -> int:
    """Count the states of all blocks, those that are shared once."""
    gives: dict[str, dict[str, bool]] = {}
    for a in report.assignments:
        gives.setdefault(a.port.block.name, {})[a.port.name] = a.gives
    network = report.network
    wrong = {p for conflict in report.conflicts for p in conflict.junction.ports}
    alike = sum(
        (len(ports) - 1) * len(ports[0].domain.components(network.space))
        for ports in report.shared
        if not wrong.intersection(ports)
    )
    return sum(network.blocks[name].form(of_block).size for name, of_block in gives.items()) - alike
