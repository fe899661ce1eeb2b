"""The assignment as a problem in numbers: ports, junctions and ties, sorted by name.

At each junction one port gives, or several that can be the same states: a *team*. Sorting is what makes the result
independent of the order in which blocks and junctions were added.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from phblocks.blocks.block import PortChoice, Tie
from phblocks.network import Junction, Network
from phblocks.ports import Port
from phblocks.triplets import Ints


class Element(NamedTuple):
    """One of the requirements that together make the problem.

    Parameters
    ----------
    kind : {"choice", "tie", "junction"}
        A choice its block has fixed, two ports that cannot differ (or cannot agree), or one giver at a junction.
    number : int
        Of the port, tie or junction.
    """

    kind: str
    number: int


@dataclass(frozen=True)
class Problem:
    """Ports that give or take, junctions at which one gives, and ties between ports.

    Parameters
    ----------
    choices : sequence of PortChoice
        What each port is able to do; a port is known by its place here.
    junctions : sequence of Junction
        One giver each.
    members : sequence of sequence of int
        Ports of each junction.
    outside : sequence of int
        Number of openings at each junction through which the outside gives.
    ties : sequence of Tie
        Of all blocks.
    ends : sequence of (int, int)
        The two ports of each tie.
    teams : sequence of mapping of int to int
        For each junction the ports that may give together with others, and the number of their team.

    Attributes
    ----------
    ties_of, junctions_of : list of list of int
        Ties and junctions of each port.
    """

    choices: Sequence[PortChoice]
    junctions: Sequence[Junction]
    members: Sequence[Sequence[int]]
    outside: Sequence[int]
    ties: Sequence[Tie]
    ends: Sequence[tuple[int, int]]
    teams: Sequence[Mapping[int, int]]
    ties_of: list[list[int]] = field(init=False, default_factory=list)
    junctions_of: list[list[int]] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        """List the ties and junctions of each port."""
        self.ties_of.extend([] for _ in self.choices)
        self.junctions_of.extend([] for _ in self.choices)
        for t, (a, b) in enumerate(self.ends):
            self.ties_of[a].append(t)
            self.ties_of[b].append(t)
        for j, ports in enumerate(self.members):
            for p in ports:
                self.junctions_of[p].append(j)

    @classmethod
    def of(cls, network: Network) -> Problem:
        """Number the ports, junctions and ties of a network.

        Parameters
        ----------
        network : Network
            Blocks and junctions.

        Returns
        -------
        Problem
            The same for any order of adding.
        """
        choices: list[PortChoice] = []
        ties: list[Tie] = []
        for name in sorted(network.blocks):
            of_block, ties_of_block = network.blocks[name].choices()
            choices += sorted(of_block, key=lambda c: c.port.name)
            ties += ties_of_block
        ties.sort(key=lambda t: (t.first.path, t.second.path))
        number = {c.port: p for p, c in enumerate(choices)}
        junctions = sorted(network.junctions(), key=lambda j: sorted(p.path for p in j.ports))
        return cls(
            choices,
            junctions,
            [sorted(number[p] for p in j.ports) for j in junctions],
            [sum(e.gives for e in j.exposures) for j in junctions],
            ties,
            [(number[t.first], number[t.second]) for t in ties],
            [_teams({number[p]: _frame(choices[number[p]], network) for p in j.ports}) for j in junctions],
        )

    def port(self, p: int) -> Port:
        """Return a port.

        Parameters
        ----------
        p : int
            Its number.

        Returns
        -------
        Port
            The port.
        """
        return self.choices[p].port

    def together(self, j: int, p: int, q: int) -> bool:
        """Tell whether two ports can both give at a junction.

        Parameters
        ----------
        j : int
            Number of the junction.
        p, q : int
            Numbers of the ports.

        Returns
        -------
        bool
            They are of one team.
        """
        team = self.teams[j]
        return p in team and team[p] == team.get(q)

    def satisfied(self, j: int, values: Sequence[bool | None]) -> bool:
        """Tell whether one port gives at a junction, or several of one team.

        Parameters
        ----------
        j : int
            Number of the junction.
        values : sequence of bool or None
            For each port whether it gives.

        Returns
        -------
        bool
            True if so.
        """
        givers = [p for p in self.members[j] if values[p]]
        if self.outside[j]:
            return self.outside[j] == 1 and not givers
        return bool(givers) and all(self.together(j, givers[0], p) for p in givers[1:])

    def fixed(self, p: int) -> bool | None:
        """Tell what the block has fixed.

        Parameters
        ----------
        p : int
            Number of the port.

        Returns
        -------
        bool or None
            Whether it gives, ``None`` if it may choose.
        """
        choice = self.choices[p]
        return None if choice.may_give and choice.may_take else choice.may_give

    @cached_property
    def elements(self) -> tuple[Element, ...]:
        """All requirements: choices, ties, junctions."""
        return (
            *(Element("choice", p) for p in range(len(self.choices)) if self.fixed(p) is not None),
            *(Element("tie", t) for t, tie in enumerate(self.ties) if tie.cost is None),
            *(Element("junction", j) for j in range(len(self.junctions))),
        )

    def components(self, free: Collection[int] | None = None) -> tuple[Ints, Ints]:
        """Find out which ports and junctions depend on each other, over junctions and ties.

        Parameters
        ----------
        free : collection of int, optional
            Ports through which a dependence can pass; by default all but those of shared blocks (the ground).

        Returns
        -------
        of_port, of_junction : numpy.ndarray
            Number of the component of each.
        """
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        n, m = len(self.choices), len(self.junctions)
        passes = np.array([not c.port.block.shared for c in self.choices], dtype=bool)
        if free is not None:
            passes = np.zeros(n, dtype=bool)
            passes[list(free)] = True
        pairs = [(p, n + j) for j, ports in enumerate(self.members) for p in ports if passes[p]]
        pairs += [(a, b) for a, b in self.ends if passes[a] and passes[b]]
        rows, columns = np.array(pairs, dtype=int).reshape(-1, 2).T
        graph = coo_array((np.ones(rows.size), (rows, columns)), shape=(n + m, n + m))
        label = connected_components(graph, directed=False)[1].astype(np.int64)
        return label[:n], label[n:]


def _frame(choice: PortChoice, network: Network) -> Hashable:
    """What must be equal for ports of one junction to be the same states; None for a port that has none of its own."""
    port = choice.port
    if choice.shares is None or not choice.may_give:
        return None
    if port.domain.turns_with != "translation":
        return port.domain
    if choice.shares == "fixed":
        return choice.shares
    # frames of anchors keep their angle to each other if the anchors are joined in rotation too
    return None if port.anchor is None else network.junction_of.get(port.anchor.rotation)


def _teams(frames: Mapping[int, Hashable]) -> dict[int, int]:
    members: dict[Hashable, list[int]] = {}
    for p in sorted(frames):
        if frames[p] is not None:
            members.setdefault(frames[p], []).append(p)
    teams = [ports for ports in members.values() if len(ports) > 1]
    return {p: number for number, ports in enumerate(teams) for p in ports}
