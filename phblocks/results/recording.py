"""What is kept of a run: states at the times asked for, and where the energy went, step by step.

Steps are collected in chunks and evaluated together, so that positions, energies and the power ledger cost a few
matrix products per chunk and nothing per step.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phblocks.results.books import Books, over_last
from phblocks.results.changes import added_by_projection, taken_by_method
from phblocks.results.middles import Middles
from phblocks.results.monitor import Monitor, Sums
from phblocks.solvers.method import Booked, Unknowns
from phblocks.solvers.schedule import together
from phblocks.solvers.step import Steps
from phblocks.system import State, System
from phblocks.triplets import Floats, Ints

#: At least so many steps are evaluated together.
CHUNK = 128
#: Numbers that all arrays of such an evaluation hold together, about.
LARGEST = 2**21
#: What the ledger knows at every saved time.
SERIES = (
    "stored",
    "potential",
    "transferred",
    "supplied",
    "supplied_to",
    "shared",
    "dissipated",
    "numerical",
    "projected",
)
#: What is kept at every saved time, and of every step.
STATES = ("t", "x", "theta", "points", "input_integral")
ROWS = (*STATES, *SERIES, "balance_error")
STEPS = ("newton_iterations", "lag", "residual")
#: What is kept of a whole run: the largest residuals, and sums.
RESIDUALS = ("block_error", "connection_error")


@dataclass(repr=False)
class Ledger:
    """Energies since the start at the saved times, and how well each step balances.

    Parameters
    ----------
    stored : numpy.ndarray
        Stored energy by block and kind, shape (times, blocks, kinds), J.
    potential : numpy.ndarray
        Potential energy of gravity by block, shape (times, blocks), J; zero at the start.
    transferred : numpy.ndarray
        Through each connection from the giving to the taking block, shape (times, connections), J.
    supplied : numpy.ndarray
        Through each input, shape (times, inputs), J.
    supplied_to : numpy.ndarray
        From outside, by block, shape (times, blocks), J.
    shared : numpy.ndarray
        Through states that are shared with other blocks, by block, shape (times, blocks), J. Defined as what each of
        them misses otherwise: the balance of one such block holds by definition, and what is tested is that of all
        that share, whose sum here is zero but for round-off.
    dissipated : numpy.ndarray
        By block, shape (times, blocks), J.
    numerical : numpy.ndarray
        What the time method took away, by block, shape (times, blocks), J: not of the equations, and zero for a
        method that keeps energies.
    projected : numpy.ndarray
        What closing loops added, by block, shape (times, blocks), J.
    balance_error : numpy.ndarray
        Largest residual of the balance of the whole system over the steps up to each saved time since the one
        before, shape (times,), J.
    block_error : numpy.ndarray
        Largest residual of the balance of each block in any step, shape (blocks,), J; of blocks that share states the
        residual of all of them together, the same for each.
    connection_error : numpy.ndarray
        Largest difference, in any step, between the energy that the matrices carry across each connection and that
        of force times velocity at its ports (:class:`~phblocks.system.exchange.Exchange`), shape (connections,), J.
    """

    stored: Floats
    potential: Floats
    transferred: Floats
    supplied: Floats
    supplied_to: Floats
    shared: Floats
    dissipated: Floats
    numerical: Floats
    projected: Floats
    balance_error: Floats
    block_error: Floats
    connection_error: Floats


@dataclass(repr=False)
class Recording:
    """Arrays at the saved times.

    Parameters
    ----------
    t : numpy.ndarray
        Shape (times,), s.
    x, theta, points : numpy.ndarray
        States, rotation states and positions of material points, shapes (times, n), (times, n_theta) and
        (times, n_points, dimension).
    input_integral : numpy.ndarray
        Time integrals of the inputs, shape (times, n_inputs).
    ledger : Ledger
        Energies.
    sums : Sums
        Of all steps, saved or not.
    begun : State, optional
        Where the run started, of a recording that was sliced.
    """

    t: Floats
    x: Floats
    theta: Floats
    points: Floats
    input_integral: Floats
    ledger: Ledger
    sums: Sums
    begun: State | None = None

    @property
    def start(self) -> State:
        """Where the run started."""
        return self.begun or State(self.x[0], self.theta[0], self.points[0])

    @classmethod
    def of(cls, series: Mapping[str, Floats], worst: Mapping[str, Floats]) -> Recording:
        """Put series together.

        Parameters
        ----------
        series : mapping of str to numpy.ndarray
            :data:`ROWS`.
        worst : mapping of str to numpy.ndarray
            The largest residuals of blocks and connections, and the sums.

        Returns
        -------
        Recording
            Of these.
        """
        of_run = {key: worst[key] for key in RESIDUALS}
        ledger = Ledger(**{key: series[key] for key in (*SERIES, "balance_error")}, **of_run)
        t, x, theta, points, integral = (series[key] for key in STATES)
        return cls(t, x, theta, points, integral, ledger, Sums.of(worst))

    def sliced(self, times: Ints) -> Recording:
        """Keep some of the saved times.

        Parameters
        ----------
        times : numpy.ndarray
            Their numbers.

        Returns
        -------
        Recording
            The largest residuals and the sums stay those of the whole run.
        """
        of_run = {name: getattr(self.ledger, name) for name in RESIDUALS}
        ledger = Ledger(**{name: getattr(self.ledger, name)[times] for name in (*SERIES, "balance_error")}, **of_run)
        t, x, theta, points, integral = (getattr(self, name)[times] for name in STATES)
        return Recording(t, x, theta, points, integral, ledger, self.sums, self.start)


@dataclass
class Recorder:
    """Collects steps and turns them into a recording.

    Parameters
    ----------
    system : System
        The system that is integrated.
    stage : Unknowns
        For changing unknowns to states.
    weights, nodes : tuple of float
        Of the stages of the method: what they count, and where in a step they are.
    t : float
        Time of the start, s.
    start : State
        Saved as the first.
    """

    system: System
    stage: Unknowns
    weights: tuple[float, ...]
    nodes: tuple[float, ...]
    t: float
    start: State
    _steps: list[Booked] = field(default_factory=list)
    _losses: list[list[Floats]] = field(default_factory=list)
    _count: int = 0
    _saved: dict[str, list[Any]] = field(default_factory=dict)
    _handed_over: bool = False

    def __post_init__(self) -> None:
        """Save the start."""
        _keep_memory()
        self._books = Books.of(self.system)
        self._points = self.start.points
        self._stored = self._books.stored(self.start.x[None])
        self._totals = self._books.zero()
        self._worst = [np.zeros(len(self.system.parts)), np.zeros(len(self.system.connections.names))]
        self._room = max(CHUNK, together(self.system.n))
        self._unsaved: tuple[tuple[Floats, Floats, Floats, Floats, Floats], dict[str, Floats]] | None = None
        self._error_since = 0.0
        self._integral = np.zeros(self.system.n_inputs)
        self._middles, self._open = Middles(self.system, self.nodes), True
        self._monitor = Monitor(self.system, self._books, self.weights, self.start.x)
        self._keep(
            np.array([self.t]),
            self.start.x[None].copy(),
            self.start.theta[None],
            self.start.points[None],
            self._integral[None],
            self._stored,
            {k: v[None] for k, v in self._totals.items()},
            np.zeros(1),
        )
        self._saved |= {"newton_iterations": [np.zeros(0, dtype=np.int64)], "lag": [np.zeros(0)]}
        self._saved["residual"] = [np.zeros(0)]

    def add(self, steps: Steps, at: Floats, saved: NDArray[np.bool_]) -> None:
        """Take in accepted steps.

        Parameters
        ----------
        steps : Steps
            The steps.
        at : numpy.ndarray
            Times of their ends, shape (steps,), s.
        saved : numpy.ndarray
            Which ends are to be saved, shape (steps,).

        Raises
        ------
        StructureError
            If a matrix of the user's is not what it must be at a stage; the steps are not taken in.
        """
        losses = self._verified(steps)
        if self._count >= self._room:
            self._flush()
        self._steps.append((steps, at, saved))
        self._losses.append(losses)
        self._count += len(steps)

    def _verified(self, steps: Steps) -> list[Floats]:
        """R(x) of each modulation at the stages, shape (stages, a, a), after a look at J(x) and R(x)."""
        if not self.system.modulations:
            return []
        z = self.stage.unpack(steps.z.reshape(-1, steps.x.shape[1]))
        return [m.verified(z[:, m.by])[1] for m in self.system.modulations]

    def save_last(self, t: float) -> None:
        """Save the last accepted step after all, for a run that ends early.

        Parameters
        ----------
        t : float
            Time of its end, s.
        """
        if self._steps:
            _, at, saved = self._steps[-1]
            if not saved[-1]:
                at[-1], saved[-1] = t, True
        elif self._unsaved:
            arrays, totals = self._unsaved
            self._keep(np.array([t]), *arrays, totals, np.array([self._error_since]))
            self._unsaved, self._open = None, True

    def finish(self) -> tuple[Recording, dict[str, Floats]]:
        """Evaluate what is left.

        Returns
        -------
        recording : Recording
            All saved times.
        steps : dict of str to numpy.ndarray
            :data:`STEPS` of all steps, shape (steps,).
        """
        series = self.drain(last=True)
        return Recording.of(series, self.worst), {key: series[key] for key in STEPS}

    def drain(self, last: bool = False) -> dict[str, Floats]:
        """Evaluate what is left and hand over, once, what has been saved.

        Parameters
        ----------
        last : bool, optional
            No step follows. Otherwise a row is held back in which the next step will set states without a rate.

        Returns
        -------
        dict of str to numpy.ndarray
            :data:`ROWS` of new saved times and :data:`STEPS` of new steps.
        """
        self._flush()
        saved = {key: np.concatenate(parts) for key, parts in self._saved.items()}
        held = 0 if last or not (self._open and self._middles.waiting) else 1
        rows = saved["t"].size - held
        self._saved = {key: [array[rows:] if key in ROWS else array[:0]] for key, array in saved.items()}
        self._handed_over = self._handed_over or rows > 0
        return {key: array[:rows] if key in ROWS else array for key, array in saved.items()}

    @property
    def worst(self) -> dict[str, Floats]:
        """The largest residuals so far, of blocks and of connections, and the sums."""
        return dict(zip(RESIDUALS, self._worst, strict=True)) | self._monitor.sums.arrays()

    def memory(self) -> dict[str, Floats]:
        """Return what it needs to go on, after :meth:`drain`.

        Returns
        -------
        dict of str to numpy.ndarray
            For :meth:`remember`.
        """
        own = {
            "points": self._points,
            "stored": self._stored,
            "error_since": np.array(self._error_since),
            "integral": self._integral,
            "open": np.array(float(self._open)),
            "handed_over": np.array(float(self._handed_over)),
        }
        parts = {
            "totals": self._totals,
            "worst": dict(zip(RESIDUALS, self._worst, strict=True)),
            "monitor": self._monitor.memory(),
            "middles": self._middles.memory(),
            "held": {key: parts[0] for key, parts in self._saved.items()},
        }
        return own | {f"{part}.{key}": array for part, arrays in parts.items() for key, array in arrays.items()}

    def remember(self, memory: Mapping[str, Floats]) -> None:
        """Go on from there.

        Parameters
        ----------
        memory : mapping of str to numpy.ndarray
            From :meth:`memory`.
        """

        def part(name: str) -> dict[str, Floats]:
            return {key.removeprefix(f"{name}."): a for key, a in memory.items() if key.startswith(f"{name}.")}

        self._points, self._stored, self._integral = (memory[key] for key in ("points", "stored", "integral"))
        self._error_since = float(memory["error_since"])
        self._open, self._handed_over = bool(memory["open"]), bool(memory["handed_over"])
        self._totals, worst, self._saved = part("totals"), part("worst"), {k: [a] for k, a in part("held").items()}
        self._worst = [worst[key] for key in RESIDUALS]
        self._monitor.remember(part("monitor"))
        self._middles.remember(part("middles"))

    def _flush(self) -> None:
        if not self._steps:
            return
        parts, times, wanted = zip(*self._steps, strict=True)
        steps, at, kept = Steps.join(parts), np.concatenate(times), np.concatenate(wanted)
        dt = steps.dt
        weight = (dt[:, None] * np.array(self.weights)).ravel()
        z, theta_z, u = (a.reshape(weight.size, a.shape[2]) for a in (steps.z, steps.theta_z, steps.u))
        z, x = self.stage.unpack(z), self.stage.unpack(steps.x)
        self._complete(dt, z, x)
        losses = [np.concatenate(of_one) for of_one in zip(*self._losses, strict=True)]
        frozen = z if steps.frozen is None else self.stage.unpack(steps.frozen.reshape(z.shape))
        per_step = len(self.weights)

        def by_step(values: Floats) -> Floats:
            """Integrate values at the stages, shape (stages of all steps, ...), over each step."""
            weighted: Floats = values.reshape(weight.size, -1) * weight[:, None]
            return weighted if per_step == 1 else weighted.reshape(len(steps), per_step, -1).sum(axis=1)

        moving = self._books.moving
        moved = by_step(self._books.velocities(z, theta_z))
        if steps.shift is not None:
            moved = moved + _flat(steps.shift)[:, moving]
        if steps.points is not None:  # the method integrates them itself
            moved = np.diff(_flat(np.concatenate([self._points[None], steps.points]))[:, moving], axis=0)
        way = np.cumsum(moved, axis=0)
        integral = self._integral + np.cumsum(by_step(u), axis=0)
        rates = self._books.rates(theta_z, z, frozen, u, losses)
        flows = {key: by_step(rate) for key, rate in rates.items()}
        between_ports = flows.pop("between_ports")
        blocks = self._books.n_blocks
        flows["numerical"] = taken_by_method(steps, self._energies, blocks)
        flows["projected"] = added_by_projection(steps, self._energies, self._lifted, blocks)
        flows["potential"] = self._books.potential(moved)
        stored = self._books.stored(x)
        ends = over_last(stored)
        change = np.diff(np.concatenate([over_last(self._stored), ends]), axis=0) + flows["potential"]
        lost = flows["dissipated"] + flows["numerical"] - flows["projected"]
        gain = flows["supplied_to"] - lost + self._books.received(flows["transferred"])
        missing = change - gain
        block_error = np.abs(self._books.of_groups(missing))
        flows["shared"] = missing * self._books.sharing
        residual = over_last(change) - over_last(flows["supplied"]) + over_last(lost)
        error = np.abs(residual)
        self._worst[0] = np.maximum(self._worst[0], block_error.max(axis=0, initial=0.0))
        connection_error = np.abs(flows["transferred"] - between_ports)
        self._worst[1] = np.maximum(self._worst[1], connection_error.max(axis=0, initial=0.0))
        totals = {key: _summed_up(self._totals[key], flow) for key, flow in flows.items()}
        self._monitor.add(dt, residual, ends, totals, x, z)

        saved = np.flatnonzero(kept)
        error[0] = np.maximum(self._error_since, error[0])
        after = int(saved[-1]) + 1 if saved.size else 0
        # the largest up to each saved time since the one before
        errors = np.maximum.reduceat(error[:after], np.append(0, saved[:-1] + 1)) if saved.size else np.zeros(0)
        self._error_since = float(error[after:].max(initial=0.0))
        self._keep(
            at[saved],
            x[saved],
            steps.theta[saved],
            self._at(way[saved]),
            integral[saved],
            stored[saved],
            {k: v[saved] for k, v in totals.items()},
            errors,
        )
        for key, told in zip(STEPS, (steps.iterations, steps.lag, steps.residual), strict=True):
            self._saved[key].append(told)
        self._open = bool(kept[-1])
        self._stored, self._points, self._integral = stored[-1:], self._at(way[-1:])[0], integral[-1]
        self._totals = {key: total[-1] for key, total in totals.items()}
        self._unsaved = None
        if not kept[-1]:
            states = (x[-1:], steps.theta[-1:], self._points[None], integral[-1:], stored[-1:])
            self._unsaved = states, {key: total[-1:] for key, total in totals.items()}
        self._steps.clear()
        self._losses.clear()
        self._count = 0

    def _energies(self, unknowns: Floats) -> Floats:
        """Stored energy by block, shape (m, blocks)."""
        return np.asarray(self._books.stored(self.stage.unpack(unknowns)).sum(axis=2))

    def _lifted(self, shift: Floats) -> Floats:
        """Potential energy of gravity of displacements of all material points, shape (m, blocks)."""
        return self._books.potential(_flat(shift)[:, self._books.moving])

    def _at(self, way: Floats) -> Floats:
        """Positions of the material points after displacements of what moves, shape (m, n_points, dimension)."""
        points = np.tile(self._points.ravel(), (len(way), 1))
        points[:, self._books.moving] += way
        return points.reshape(len(way), *self._points.shape)

    def _complete(self, dt: Floats, z: Floats, x: Floats) -> None:
        """Fill in the states without a rate, also in the rows of the start and of the last step before."""
        states = self._middles.states
        if not states.size:
            return
        start, before, ends = self._middles.add(dt, z.reshape(dt.size, -1, z.shape[1]))
        if before is not None and self._open:
            self._saved["x"][-1][-1, states] = before
        if start is not None and not self._handed_over:
            self._saved["x"][0][0, states] = start
        if ends is not None:
            x[:, states] = ends

    def _keep(
        self,
        t: Floats,
        x: Floats,
        theta: Floats,
        points: Floats,
        integral: Floats,
        stored: Floats,
        totals: dict[str, Floats],
        errors: Floats,
    ) -> None:
        arrays = {
            "t": t,
            "x": x,
            "theta": theta,
            "points": points,
            "input_integral": integral,
            "stored": stored,
        }
        for key, value in (arrays | totals | {"balance_error": errors}).items():
            self._saved.setdefault(key, []).append(value)


def _flat(points: Floats) -> Floats:
    """Positions or displacements, point by point in a row, shape (m, n_points * dimension)."""
    return points.reshape(len(points), math.prod(points.shape[1:]))


def _summed_up(before: Floats, flow: Floats) -> Floats:
    """What has flowed up to the end of each step, shape (steps, ...); most runs have kinds of flows that are zero."""
    return np.asarray(before + np.cumsum(flow, axis=0) if flow.any() else np.broadcast_to(before, flow.shape))


@cache
def _keep_memory() -> None:
    """Let what is evaluated together be where it was the time before, instead of fetched page by page from the system.

    The C library of Linux gives free memory back at once, unless a larger block was freed before: mallopt(3),
    M_MMAP_THRESHOLD. Elsewhere it does nothing. Once for a process.
    """
    np.empty(LARGEST)
