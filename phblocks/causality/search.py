"""A good choice where there are too many ports for a proof: team by team at one junction after the other.

Once it is chosen which team gives at every junction, the rest follows: a port gives if its team does and its mate at
the other end of its block gives too; a junction at which there is no such port takes one switch. What is searched is
the choice of teams, by changing one at a time as long as that helps.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence

from phblocks.causality.problem import Problem

#: Rounds over all junctions; a handful is enough.
ROUNDS = 50


class TeamSearch:
    """Chooses the team that gives at every junction.

    Parameters
    ----------
    problem : Problem
        Ports, junctions and ties; every port to be chosen for is in one junction and has one tie with a price at most.
    values : sequence of bool or None
        What is decided.
    ports : sequence of int
        The ports to choose for, in order.
    saving : float
        What a port saves that gives what another gives already.
    never : float
        Price of a tie that cannot be broken.
    """

    def __init__(
        self, problem: Problem, values: Sequence[bool | None], ports: Sequence[int], saving: float, never: float
    ) -> None:
        self._saving, self._values = saving, values
        self._junction = {p: problem.junctions_of[p][0] for p in ports}
        self._mate: dict[int, int] = {}
        self._price: dict[int, float] = {}
        for p in ports:
            for t in problem.ties_of[p]:
                cost = problem.ties[t].cost
                if cost != 0.0:
                    a, b = problem.ends[t]
                    self._mate[p], self._price[p] = b if p == a else a, never if cost is None else cost
        self._teams: dict[int, dict[Hashable, list[int]]] = {}
        self._served: set[int] = set()
        for p in ports:
            j = self._junction[p]
            key = problem.teams[j].get(p, ("alone", p))
            self._teams.setdefault(j, {}).setdefault(key, []).append(p)
            if any(values[q] for q in problem.members[j]):
                self._served.add(j)
        self._key = {p: key for teams in self._teams.values() for key, members in teams.items() for p in members}

    def from_givers(self, gives: Mapping[int, bool]) -> dict[int, Hashable]:
        """Start from the teams that give in another choice, or the largest where there is none.

        Parameters
        ----------
        gives : mapping of int to bool
            The other choice; may be empty.

        Returns
        -------
        dict of int to hashable
            For each junction its team.
        """
        chosen = {j: max(teams, key=lambda k: (len(teams[k]), -teams[k][0])) for j, teams in self._teams.items()}
        return chosen | {self._junction[p]: self._key[p] for p, given in gives.items() if given}

    def improved(self, chosen: dict[int, Hashable]) -> tuple[float, dict[int, bool]]:
        """Change one team at a time until that does not help any more.

        Parameters
        ----------
        chosen : dict of int to hashable
            For each junction its team; changed in place.

        Returns
        -------
        cost : float
            Of switches, less what sharing saves.
        gives : dict of int to bool
            For each port.
        """
        mates = {j: [self._mate.get(p) for k in teams for p in teams[k]] for j, teams in self._teams.items()}
        around = {j: sorted({j, *(self._junction[m] for m in of_j if m in self._key)}) for j, of_j in mates.items()}
        for _ in range(ROUNDS):
            changed = False
            for j, teams in self._teams.items():
                best, now = chosen[j], self._cost(around[j], chosen)
                for key in teams:
                    chosen[j] = key
                    if (cost := self._cost(around[j], chosen)) < now - 1e-9:
                        best, now, changed = key, cost, True
                chosen[j] = best
            if not changed:
                break
        gives = dict.fromkeys(self._junction, False)
        for j in self._teams:
            for p in self._givers(j, chosen):
                gives[p] = True
        return self._cost(self._teams, chosen), gives

    def _free(self, p: int, chosen: Mapping[int, Hashable]) -> bool:
        """Whether giving breaks no tie."""
        mate = self._mate.get(p)
        if mate is None:
            return True
        return bool(self._values[mate]) if mate not in self._key else chosen[self._junction[mate]] == self._key[mate]

    def _givers(self, j: int, chosen: Mapping[int, Hashable]) -> list[int]:
        members = self._teams[j][chosen[j]]
        free = [p for p in members if self._free(p, chosen)]
        return free if free or j in self._served else [min(members, key=lambda p: (self._price[p], p))]

    def _cost(self, junctions: Sequence[int] | Mapping[int, object], chosen: Mapping[int, Hashable]) -> float:
        total = 0.0
        for j in junctions:
            givers = self._givers(j, chosen)
            total += sum(self._price[p] for p in givers if not self._free(p, chosen))
            total -= self._saving * (len(givers) - (j not in self._served))
        return total
