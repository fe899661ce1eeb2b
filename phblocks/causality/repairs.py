"""Changes that make an impossible diagram causal, the cheapest first; each is tried before it is offered."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING

from phblocks.causality.conflicts import Conflict
from phblocks.causality.edits import held_together, merged, rebuilt
from phblocks.network import Network
from phblocks.ports import Port

if TYPE_CHECKING:
    from phblocks.causality.report import CausalityReport
    from phblocks.diagram import Diagram

#: Changes tried for one conflict.
TRIES = 12


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
        Frequency that the added stiffness brings, rad/s.
    """

    states: int
    switches: int = 0
    index: int = 0
    stiffness: float | None = None
    frequency: float | None = None


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
        if self.cost.frequency is not None:
            cost.append(f"frequency {self.cost.frequency:.3g} rad/s")
        return f"{self.what} ({', '.join(cost)})"


@dataclass(frozen=True)
class _Step:
    """A change of one conflict, not tried yet."""

    what: str
    change: Callable[[Network], Network]
    index: int = 0
    stiffness: float | None = None
    frequency: float | None = None


def find_repairs(report: CausalityReport) -> tuple[Repair, ...]:
    """Try what could mend a diagram.

    Parameters
    ----------
    report : CausalityReport
        Of a diagram that is not causal.

    Returns
    -------
    tuple of Repair
        All that do; the cheapest first: least index, then no stiffness, then fewest states and switches.
    """
    if report.ok:
        return ()
    found = []
    for step in _steps(report):
        steps = _completed(report, step)
        if steps is None:
            continue
        network = _all_of(steps)(report.network)
        after = _checked(network)
        cost = Cost(
            states=_states(after) - _states(report),
            switches=len(after.switches) - len(report.switches),
            index=max(s.index for s in steps),
            stiffness=max((s.stiffness for s in steps if s.stiffness is not None), default=None),
            frequency=max((s.frequency for s in steps if s.frequency is not None), default=None),
        )
        found.append(Repair(", and ".join(s.what for s in steps), cost, _all_of(steps)))
    key = {id(r): (r.cost.index, r.cost.stiffness or 0.0, r.cost.states, r.cost.switches, r.what) for r in found}
    return tuple(sorted(found, key=lambda r: key[id(r)]))


def _completed(report: CausalityReport, step: _Step) -> list[_Step] | None:
    """Go on with the first steps that help until the diagram is causal; None if that does not happen."""
    steps = [step]
    while True:
        after = _checked(step.change(report.network))
        if after.ok:
            return steps
        if len(after.conflicts) >= len(report.conflicts):
            return None
        for step in _steps(after):
            if len(_checked(step.change(after.network)).conflicts) < len(after.conflicts):
                break
        else:
            return None
        steps.append(step)
        report = after


def _checked(network: Network) -> CausalityReport:
    from phblocks.causality.assignment import assign_causality

    return assign_causality(network)


def _all_of(steps: Sequence[_Step]) -> Callable[[Network], Network]:
    def change(network: Network) -> Network:
        for step in steps:
            network = step.change(network)
        return network

    return change


def _states(report: CausalityReport) -> int:
    """Count the states of all blocks."""
    gives: dict[str, dict[str, bool]] = {}
    for a in report.assignments:
        gives.setdefault(a.port.block.name, {})[a.port.name] = a.gives
    blocks = report.network.blocks
    return sum(blocks[name].form(of_block).size for name, of_block in gives.items())


def _steps(report: CausalityReport) -> list[_Step]:
    """List changes for the first conflict that has any."""
    for conflict in report.conflicts:
        steps = [*_alternatives(conflict), *_merges(report.network, conflict), *_multipliers(report.network, conflict)][
            :TRIES
        ]
        if steps:
            return steps
    return []


def _alternatives(conflict: Conflict) -> Iterator[_Step]:
    """Other versions of the blocks that have no choice in the conflict."""
    blocks = {p.block.name: p.block for p in conflict.fixed}
    blocks |= {t.first.block.name: t.first.block for t in conflict.ties}
    for name in sorted(blocks):
        for other in blocks[name].alternatives():

            def change(network: Network, name: str = name, what: str = other.what) -> Network:
                block = next(o.block for o in network.blocks[name].alternatives() if o.what == what)
                return rebuilt(network, {name: block})

            yield _Step(other.what, change)


def _merges(network: Network, conflict: Conflict) -> Iterator[_Step]:
    """One block instead of two that cannot move against each other, or through which the same force passes."""
    names = sorted({p.block.name for j in conflict.junctions for p in j.ports})
    for first, second in combinations(names, 2):
        found = merged(network, first, second)
        if found is not None:

            def join(network: Network, first: str = first, second: str = second) -> Network:
                again = merged(network, first, second)
                return network if again is None else again[0]

            yield _Step(found[1], join)


def _multipliers(network: Network, conflict: Conflict) -> Iterator[_Step]:
    """A joint force of its own for parts that all give velocity."""
    places = {a.translation: None for p in conflict.junction.ports if (a := p.anchor) is not None}
    for junction in network.joined:
        ports = junction.ports
        if set(places) & {p for p in ports if not p.block.shared} and held_together(network, ports) is not None:

            def hold(network: Network, ports: tuple[Port, ...] = ports) -> Network:
                return held_together(network, ports) or network

            names = ", ".join(sorted({p.block.name for p in ports}))
            yield _Step(f"hold {names} together by a multiplier (multiplier=True)", hold, index=2)
