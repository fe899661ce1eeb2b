"""What could be changed about a conflict: every kind of repair, not tried yet."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import chain, combinations, islice
from typing import TYPE_CHECKING

import numpy as np

from phblocks.blocks.block import Block
from phblocks.blocks.body import Mass
from phblocks.blocks.bushing import Bushing
from phblocks.blocks.form import Form
from phblocks.blocks.joints import RigidJoint
from phblocks.blocks.torsion import TorsionSpring
from phblocks.blocks.transformer import Transformer
from phblocks.causality.compliance import Forms, suggest_mass, suggest_stiffness
from phblocks.causality.conflicts import Conflict
from phblocks.causality.edits import (
    grounded,
    hung_on,
    merged,
    off_the_ground,
    rebuilt,
    turned_round,
    without_opening,
)
from phblocks.causality.meetings import Meeting, mounted
from phblocks.causality.wording import enumerated
from phblocks.network import Network
from phblocks.ports import ROTATION, TRANSLATION, Port
from phblocks.space import PLANAR

if TYPE_CHECKING:
    from phblocks.causality.report import CausalityReport

#: Changes tried for one conflict.
TRIES = 16
#: Kinds of changes that only add: many can be made at once, one for each conflict.
ADDITIVE = {"compliance", "mass", "multiplier", "ground"}
#: Kinds of changes that put in parts of the plane.
FLAT = {"compliance", "mass", "multiplier"}


@dataclass(frozen=True)
class Step:
    """A change of one conflict, not tried yet.

    Parameters
    ----------
    kind : str
        Of several conflicts, the same kind of change is tried first.
    what : str
        The change in words.
    change : callable
        From a network to one with the change.
    where : tuple of Port
        Of the junction that is changed, if it is one.
    index, stiffness, frequency, mass, demands
        As in :class:`Cost`.
    """

    kind: str
    what: str
    change: Callable[[Network], Network]
    where: tuple[Port, ...] = ()
    index: int = 0
    stiffness: float | None = None
    frequency: float | None = None
    mass: float | None = None
    demands: int = 0


def steps_for(report: CausalityReport, known: Collection[str]) -> list[Step]:
    """List changes for the first conflict that has any.

    Parameters
    ----------
    report : CausalityReport
        Of a diagram that is not causal.
    known : collection of str
        Names of the blocks of the user, which set the scale of what is added.

    Returns
    -------
    list of Step
        Changes that give up nothing first.
    """
    forms = _forms(report)
    for conflict in report.conflicts:
        kinds = _kinds(report.network, forms, conflict, known)
        steps = list(islice(chain.from_iterable(make() for make in kinds.values()), TRIES))
        if steps:
            return steps
    return []


def steps_alike(report: CausalityReport, kind: str, known: Collection[str]) -> list[Step]:
    """List one change of the same kind for each conflict, if they do not get in each other's way.

    Parameters
    ----------
    report : CausalityReport
        Of a diagram that is not causal.
    kind : str
        Of the changes.
    known : collection of str
        Names of the blocks of the user, which set the scale of what is added.

    Returns
    -------
    list of Step
        None for a kind that replaces blocks.
    """
    if kind not in ADDITIVE:
        return []
    forms = _forms(report)
    found: dict[tuple[str, tuple[Port, ...]], Step] = {}
    for conflict in report.conflicts:
        step = next(_kinds(report.network, forms, conflict, known)[kind](), None)
        if step is not None:
            found.setdefault((step.what, step.where), step)
    return list(found.values())


def _kinds(
    network: Network, forms: Forms, conflict: Conflict, known: Collection[str]
) -> dict[str, Callable[[], Iterator[Step]]]:
    """For each kind of change what makes those for a conflict, when it is asked for."""
    kinds: dict[str, Callable[[], Iterator[Step]]] = {
        "alternative": lambda: _alternatives(conflict),
        "merge": lambda: _merges(network, conflict),
        "compliance": lambda: _compliances(network, forms, conflict, known),
        "mass": lambda: _masses(network, forms, conflict, known),
        "multiplier": lambda: _multipliers(network, conflict),
        "opening": lambda: _openings(network, conflict),
        "ground": lambda: _groundings(network, conflict),
    }
    return {
        kind: make if network.space == PLANAR or kind not in FLAT else lambda: iter(()) for kind, make in kinds.items()
    }


def _forms(report: CausalityReport) -> Forms:
    """From a block to its form, made when it is first asked for."""

    @cache
    def meshed(block: Block) -> Form:
        return block.form(report.gives(block.name))

    @cache
    def coarsest(block: Block) -> Form:
        coarse = block.coarsest
        return meshed(block) if coarse is block else coarse.form(report.gives(block.name))

    return Forms(meshed, coarsest)


def _alternatives(conflict: Conflict) -> Iterator[Step]:
    """Other versions of the blocks that have no choice in the conflict."""
    blocks = {p.block.name: p.block for p in conflict.fixed}
    blocks |= {t.first.block.name: t.first.block for t in conflict.ties}
    for name in sorted(blocks):
        for other in blocks[name].alternatives():

            def change(network: Network, name: str = name, what: str = other.what) -> Network:
                block = next(o.block for o in network.blocks[name].alternatives() if o.what == what)
                return rebuilt(network, {name: block})

            yield Step("alternative", other.what, change)


def _merges(network: Network, conflict: Conflict) -> Iterator[Step]:
    """One block instead of two that cannot move against each other, or through which the same force passes."""
    names = sorted({p.block.name for j in conflict.junctions for p in j.ports})
    for first, second in combinations(names, 2):
        found = merged(network, first, second)
        if found is not None:

            def join(network: Network, first: str = first, second: str = second) -> Network:
                again = merged(network, first, second)
                return network if again is None else again[0]

            yield Step("merge", found[1], join)


def _meetings(network: Network, conflict: Conflict) -> Iterator[tuple[Meeting, Callable[[Network], Meeting | None]]]:
    """Where parts that all give meet at the junction of a conflict, and how to find that again.

    After another step it may not be there any more: what joins translations takes the rotations of a weld along.
    """
    places = set(conflict.junction.ports)
    places |= {a.translation for p in conflict.junction.ports if (a := p.anchor) is not None}
    for junction in network.junctions():
        ports = junction.ports
        if places & {p for p in ports if not p.block.shared} and (meeting := Meeting.of(network, ports)) is not None:

            def again(network: Network, paths: frozenset[str] = frozenset(p.path for p in ports)) -> Meeting | None:
                # by name: a step before may have put other blocks in the place of these
                here = (j.ports for j in network.junctions() if {p.path for p in j.ports} == paths)
                return next((m for ports in here if (m := Meeting.of(network, ports)) is not None), None)

            yield meeting, again


def _compliances(network: Network, forms: Forms, conflict: Conflict, known: Collection[str]) -> Iterator[Step]:
    """An elastic joint of no length between parts that all give velocity."""
    for meeting, again in _meetings(network, conflict):
        found = suggest_stiffness(network, forms, meeting, known)
        if found is None:
            continue
        stiffness = np.zeros(3)
        stiffness[: found.weights.size] = found.value * found.weights
        turns = meeting.joint.domain is ROTATION

        def make(name: str, k: float = found.value, matrix: object = np.diag(stiffness), turns: bool = turns) -> Block:
            return TorsionSpring(name, k) if turns else Bushing(name, matrix)  # type: ignore[arg-type]  # an array

        def soften(
            network: Network,
            again: Callable[[Network], Meeting | None] = again,
            make: Callable[[str], Block] = make,
        ) -> Network:
            meeting = again(network)
            return network if meeting is None else mounted(network, [meeting], lambda _, name: make(name))

        kind, unit = ("torsion spring", "N m/rad") if turns else ("bushing", "N/m")
        size = f"{found.value:.3g} {unit}"
        if found.weights.size == 3:
            size += f" and {stiffness[2]:.3g} N m/rad"
        hub, *names = [
            (p.anchor or p).path if isinstance(p, Port) else f"outside {p.name!r}"
            for p in (meeting.hub, *meeting.others)
        ]
        what = f"put a {kind} of {size} between {hub} and {names[0]}"
        if len(names) > 1:
            each = enumerated(names, ", ", "parts")
            what = f"put {len(names)} {kind}s of {size}, one between {hub} and each of {each}"
        yield Step("compliance", what, soften, meeting.joint.ports, stiffness=found.value, frequency=found.frequency)


def _masses(network: Network, forms: Forms, conflict: Conflict, known: Collection[str]) -> Iterator[Step]:
    """A point mass where only parts without mass meet."""
    junction = conflict.junction
    position = next((p.anchor.position for p in junction.ports if p.anchor and p.anchor.position is not None), None)
    gives = any(c.may_give for p in junction.ports for c in p.block.choices()[0] if c.port is p)
    if gives or junction.domain is not TRANSLATION or position is None or len(junction.ports) < 2:
        return
    found = suggest_mass(network, forms, junction, known)
    if found is None:
        return

    def weigh(network: Network) -> Network:
        name, count = "mass", 1
        while name in network.blocks:
            count += 1
            name = f"mass {count}"
        mass = Mass(name, found.value, position)
        return hung_on(network, junction.ports, mass, mass.centre.translation)

    what = f"put a point mass of {found.value:.3g} kg at [{junction.name}]"
    yield Step("mass", what, weigh, junction.ports, frequency=found.frequency, mass=found.value)


def held(network: Network, meetings: Sequence[Meeting]) -> Network:
    """Hold parts that all give velocity together, by joints with multipliers.

    Parameters
    ----------
    network : Network
        The network; it is not changed.
    meetings : sequence of Meeting
        The parts, at different joints.

    Returns
    -------
    Network
        A new one.
    """

    def make(meeting: Meeting, name: str) -> Block:
        if meeting.joint.domain is ROTATION:
            return Transformer(name, 1.0, multiplier=True)
        return RigidJoint(name, turns=meeting.weld is None)

    return mounted(network, meetings, make)


def _multipliers(network: Network, conflict: Conflict) -> Iterator[Step]:
    """A joint force of its own for parts that all give velocity."""
    for meeting, again in _meetings(network, conflict):

        def hold(network: Network, again: Callable[[Network], Meeting | None] = again) -> Network:
            meeting = again(network)
            if meeting is None:
                return network
            return held(network, [meeting])

        names = enumerated(sorted(set(meeting.names)), ", ", "parts")
        what = f"hold {names} together by a multiplier (multiplier=True)"
        yield Step("multiplier", what, hold, meeting.joint.ports, index=2)


def _groundings(network: Network, conflict: Conflict) -> Iterator[Step]:
    """The ground for a loose end of a mechanical part that can only take: a demand that nobody made."""
    junction = conflict.junction
    alone = len(junction.ports) == 1 and not junction.exposures and junction.domain.turns_with is not None
    if not alone or grounded(network, junction.ports[0].path) is None:
        return
    path = junction.ports[0].path

    def change(network: Network) -> Network:
        return grounded(network, path) or network

    yield Step("ground", f"attach {path} to the ground", change, junction.ports, demands=1)


def _openings(network: Network, conflict: Conflict) -> Iterator[Step]:
    """One demand less: an opening left out, or turned round, or the ground left to what moves it."""
    openings = {e.name: e for j in conflict.junctions for e in j.exposures}
    for name in sorted(openings):
        e = openings[name]
        pair = (e.port.domain.common.name, e.port.domain.summed.name)
        imposed, other = pair if e.gives else pair[::-1]
        for edit, what in (
            (without_opening, f"leave out {name!r}, which imposes {imposed}"),
            (turned_round, f"let {name!r} impose {other} instead of {imposed}"),
        ):
            if edit(network, name) is not None:

                def change(
                    network: Network, name: str = name, edit: Callable[[Network, str], Network | None] = edit
                ) -> Network:
                    return edit(network, name) or network

                yield Step("opening", what, change, demands=1)
    for junction in conflict.junctions:
        moving = [e for e in junction.exposures if e.gives]
        if moving and any(p.block.shared for p in junction.ports):

            def release(network: Network, ports: tuple[Port, ...] = junction.ports) -> Network:
                return off_the_ground(network, ports)

            held = ", ".join(p.path for p in junction.ports if not p.block.shared)
            yield Step("opening", f"take {held} off the ground: {moving[0].name!r} moves it", release, demands=1)
