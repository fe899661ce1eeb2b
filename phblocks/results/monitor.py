"""Sums over all steps of a run, saved or not, from which its health is told: they cost a few products a chunk."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from phblocks.results.books import Books, over_last
from phblocks.system import System
from phblocks.system.scaling import state_scale
from phblocks.triplets import Floats, Ints


@dataclass(repr=False)
class Sums:
    """What is known of all steps of a run together.

    Parameters
    ----------
    energy : numpy.ndarray
        Shape (4,), J: the largest energy that was stored, or moved by anything; the largest
        residual of the balance of any step; the largest residual since the start; weight times place at the start,
        whose round-off is in the residuals.
    when : numpy.ndarray
        Shape (2,), s: when these two residuals were met.
    held : numpy.ndarray
        Stored energy by block, mean of both ends of a step, integrated over time; shape (blocks,), J s. Energies that
        are not quadratic are left out. Of long runs one step in four counts, for all four; so in what follows.
    missed : numpy.ndarray
        How much less of it the stages of the steps have, shape (blocks,), J s.
    multipliers : numpy.ndarray
        States that are multipliers of constraints, shape (multipliers,).
    carried : numpy.ndarray
        Sum of the squares of each multiplier over the steps, shape (multipliers,), in units of :func:`state_scale`.
    alternating : numpy.ndarray
        Sum of the squares of ``(a - 2 b + c) / 4`` over all three steps in a row, shape (multipliers,), likewise.
    """

    energy: Floats
    when: Floats
    held: Floats
    missed: Floats
    multipliers: Ints
    carried: Floats
    alternating: Floats

    @classmethod
    def zero(cls, system: System) -> Sums:
        """Make those of no step.

        Parameters
        ----------
        system : System
            The system.

        Returns
        -------
        Sums
            Of zeros.
        """
        blocks, multipliers = np.zeros(len(system.parts)), multipliers_of(system)
        none = np.zeros(multipliers.size)
        weight = float(system.point_mass @ np.abs(system.start.points @ system.gravity))
        return cls(
            np.array([0.0, 0.0, 0.0, weight]), np.zeros(2), blocks, blocks.copy(), multipliers, none, none.copy()
        )

    @classmethod
    def of(cls, arrays: Mapping[str, Any]) -> Sums:
        """Take them out of arrays by name.

        Parameters
        ----------
        arrays : mapping of str to numpy.ndarray
            All of :data:`SUMS`, and others.

        Returns
        -------
        Sums
            Copies.
        """
        return cls(**{name: np.array(arrays[name]) for name in SUMS})

    def arrays(self) -> dict[str, Floats]:
        """Return all of them by name.

        Returns
        -------
        dict of str to numpy.ndarray
            :data:`SUMS`.
        """
        return {name: getattr(self, name) for name in SUMS}


#: What is summed.
SUMS = tuple(field.name for field in fields(Sums))

#: The energies at the stages are looked at in so many steps at first, then in one of so many.
ALL, FEW = 128, 4
#: Multiples of the golden ratio, here times 2^32 and modulo that, are evenly spread, and in step with no oscillation.
GOLDEN, LIMIT = np.uint32(2654435769), np.uint32(2**32 // FEW)
#: What of the ledger beside the stored energy tells how large the energies of a run are.
MOVED = ("potential", "supplied", "dissipated", "numerical", "projected")


class Monitor:
    """Takes in steps, chunk by chunk.

    Parameters
    ----------
    system : System
        The system.
    books : Books
        Of the system: energies of its states.
    weights : sequence of float
        Of the stages of the method.
    start : numpy.ndarray
        States at the start, shape (n,).

    Attributes
    ----------
    sums : Sums
        Of all steps so far.
    """

    def __init__(self, system: System, books: Books, weights: Sequence[float], start: Floats) -> None:
        self.sums, self._system, self._books, self._weights = Sums.zero(system), system, books, np.array(weights)
        self._unit = state_scale(system)[self.sums.multipliers] if self.sums.multipliers.size else np.zeros(0)
        self._last = np.zeros((0, self.sums.multipliers.size))
        self._before, self._t, self._residual = self._stored(start[None])[0], 0.0, 0.0
        self._count = 0
        self.sums.energy[0] = abs(float(self._before.sum()))

    @np.errstate(all="ignore")  # energies may be too large for a number: the run then ends with a status
    def add(
        self, dt: Floats, residual: Floats, stored: Floats, totals: Mapping[str, Floats], x: Floats, z: Floats
    ) -> None:
        """Take in steps.

        Parameters
        ----------
        dt : numpy.ndarray
            Their lengths, shape (steps,), s.
        residual : numpy.ndarray
            Of the balance of each, shape (steps,), J.
        stored : numpy.ndarray
            Stored energy by block after each, shape (steps, blocks), J.
        totals : mapping of str to numpy.ndarray
            The rest of the ledger after each, shape (steps, ...), J.
        x, z : numpy.ndarray
            States after each, shape (steps, n), and at all stages, shape (steps * stages, n).
        """
        sums, t, since = self.sums, self._t + np.cumsum(dt), self._residual + np.cumsum(residual)
        moved = [over_last(series) for series in (stored, *(totals[k] for k in MOVED))]
        sums.energy[0] = np.max([sums.energy[0], *(np.abs(series).max() for series in moved)])
        for place, values in ((1, np.abs(residual)), (2, np.abs(since))):
            worst = int(values.argmax())
            if not values[worst] <= sums.energy[place]:  # a value that is no number is the worst
                sums.energy[place], sums.when[place - 1] = values[worst], t[worst]
        number = np.arange(self._count, self._count + dt.size)
        some = np.flatnonzero((number < ALL) | (number.astype(np.uint32) * GOLDEN < LIMIT))
        share = np.where(number[some] < ALL, 1.0, FEW)
        ends = stored if self._system.quadratic else self._stored(x)
        mean = 0.5 * (ends + np.concatenate([self._before[None], ends[:-1]]))[some]
        stages = z[(some[:, None] * self._weights.size + np.arange(self._weights.size)).ravel()]
        span = share * dt[some]
        sums.held += span @ mean
        sums.missed += span @ (mean - self._weighted(self._stored(stages), some.size))
        self._before, self._t, self._residual = ends[-1], float(t[-1]), float(since[-1])
        self._count += dt.size
        if sums.multipliers.size:
            forces = self._weighted(z[:, sums.multipliers] / self._unit, dt.size)
            sums.carried += np.sum(forces**2, axis=0)
            forces = np.concatenate([self._last, forces])
            sums.alternating += np.sum(np.diff(forces, 2, axis=0) ** 2, axis=0) / 16.0
            self._last = forces[-2:]

    def _stored(self, x: Floats) -> Floats:
        """Energy by block that is quadratic, shape (times, blocks)."""
        return over_last(self._books.quadratic(x))

    def _weighted(self, values: Floats, steps: int) -> Floats:
        """Means over the stages of each step."""
        return np.asarray(np.einsum("s,tsi->ti", self._weights, values.reshape(steps, self._weights.size, -1)))

    def memory(self) -> dict[str, Floats]:
        """Return what it needs to go on.

        Returns
        -------
        dict of str to numpy.ndarray
            For :meth:`remember`.
        """
        return {
            **self.sums.arrays(),
            "last": self._last,
            "before": self._before,
            "at": np.array([self._t, self._residual]),
            "count": np.array(float(self._count)),
        }

    def remember(self, memory: Mapping[str, Floats]) -> None:
        """Go on from there.

        Parameters
        ----------
        memory : mapping of str to numpy.ndarray
            From :meth:`memory`.
        """
        self.sums = Sums.of(memory)
        self._last, self._before = memory["last"], memory["before"]
        self._t, self._residual = map(float, memory["at"])
        self._count = int(memory.get("count", ALL))


def multipliers_of(system: System) -> Ints:
    """Number the states that are multipliers of constraints.

    Parameters
    ----------
    system : System
        The system.

    Returns
    -------
    numpy.ndarray
        Shape (multipliers,); empty if there are none.
    """
    if not system.is_dae:
        return np.zeros(0, dtype=np.int64)
    place = {name: i for i, name in enumerate(system.state_names)}
    return np.array(sorted({place[name] for name in system.constraint_names}), dtype=np.int64)
