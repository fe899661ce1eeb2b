"""Loops of blocks that do not close any more, and the displacement that closes them with the least strain energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from phblocks.blocks.form import FIXED, NO_ENERGY, AngleRows, History, Piece
from phblocks.errors import MethodError
from phblocks.frames import Attitude, rotate
from phblocks.ports import Port
from phblocks.system import Part, State, System
from phblocks.system.scaling import state_scale
from phblocks.triplets import Floats

#: Inertia counts as it does when a displacement takes this many times the fastest time of the system.
SLOW = 1e6
#: What is smaller than this, relative, counts as zero in a rank.
RANK = 1e-9
#: A gap that is not closed any further, relative to the size of the diagram.
CLOSED = 1e-13
#: A gap that comes from the round-off of coordinates, relative to the largest.
ROUND_OFF = 8.0 * float(np.finfo(float).eps)
MOST_ITERATIONS = 8
#: Kinds of energy of what moves, and of what is strained by it.
MOVING, STRAINED = "kinetic", "strain"


@dataclass(frozen=True)
class Closure:
    """A configuration in which loops are closed.

    Parameters
    ----------
    state : State
        The configuration; velocities are those that were there.
    gap : float
        The largest gap before, m.
    left : float
        And after, m.
    """

    state: State
    gap: float
    left: float


@dataclass(frozen=True)
class _Gate:
    """A port where what a loop misses is let in, and the way it acts there."""

    part: Part
    port: Port
    factor: float


class Loops:
    """The loops of a system, and where each can be closed.

    From strain and orientation every block knows the vectors between its places, its *chords*. Around a loop they add
    up to zero as long as it is closed; what is missing is distributed, by least squares, over the ports that take
    velocity, as jumps between the port and what it is joined to.

    Parameters
    ----------
    system : System
        The system.

    Attributes
    ----------
    count : int
        How many independent loops there are.
    size : float
        Extent of the diagram, wherever its origin is, m.

    Raises
    ------
    MethodError
        If a loop has no joint where it could be closed, or the diagram is spatial.
    """

    def __init__(self, system: System) -> None:
        from scipy.linalg import null_space

        if system.dimension != 2:
            raise MethodError(
                f"Projection for system {system.name!r}",
                expected="a planar diagram",
                got="a spatial one, whose joints do not turn",
                fix="Leave out the projection: joints of a linear scene open by round-off only.",
            )
        self.system = system
        self._parts = {part.name: part for part in system.parts}
        self._places = [
            (i, name, place)
            for i, site in enumerate(system.sites)
            for name, place in site.places
            if name in self._parts
        ]
        self._gates, opened = self._find_gates()
        names = sorted({name for _, name, _ in self._places})
        free = [i for i, site in enumerate(system.sites) if not site.known]
        known = np.zeros((len(self._places), len(names) + len(free)))
        for row, (i, name, _) in enumerate(self._places):
            known[row, names.index(name)] = 1.0
            if i in free:
                known[row, len(names) + free.index(i)] = -1.0
        around = null_space(known.T, rcond=RANK).T if self._places else np.zeros((0, 0))
        self.count, through = len(around), around @ opened
        if self.count and np.linalg.matrix_rank(through, RANK) < self.count:
            raise MethodError(
                f"Projection for system {system.name!r}",
                expected="a joint in every loop that blocks do not share",
                got=f"none in a loop through {', '.join(names)}",
                fix="Weld one of its corners with multiplier=True, or leave out the projection.",
            )
        self.size, self._furthest = self._extent()
        self._distribute = np.zeros((len(self._gates), len(self._places)))
        if self.count:
            self._distribute = np.linalg.pinv(through, rcond=RANK) @ around
        self._inner = self._mechanical()

    def allowed(self, part: float) -> float:
        """Return how large a gap may be: relative to the size, beside what is lost in round-off of coordinates.

        Parameters
        ----------
        part : float
            Of the size.

        Returns
        -------
        float
            Gap, m.
        """
        return part * self.size + ROUND_OFF * self._furthest

    def gaps(self, state: State, moved: Floats) -> Floats:
        """Find what is missing around loops, distributed over the joints.

        Parameters
        ----------
        state : State
            The configuration.
        moved : numpy.ndarray
            Time integrals of the inputs, shape (n_inputs,).

        Returns
        -------
        numpy.ndarray
            Jumps, shape (gates, dimension), m.
        """
        chords = np.zeros((len(self._places), self.system.dimension))
        histories: dict[str, History] = {}
        for row, (i, name, place) in enumerate(self._places):
            part, site = self._parts[name], self.system.sites[i]
            if name not in histories:
                x = self.system.sharing.of_block(state.x[None], part.states)
                histories[name] = History(x, part.turned(state.theta[None]), None)
            if place != part.form.base:
                chords[row] = part.form.chord(histories[name], part.form.base, place)[0]
            if site.known:
                chords[row] -= site.held(moved)
        return np.asarray(self._distribute @ chords)

    def unaccounted(self, start: State) -> float:
        """Measure what imposed motions before the start may have opened: how far they had come is in no state.

        Parameters
        ----------
        start : State
            Where a run is to start.

        Returns
        -------
        float
            The part of the gaps that displacements of imposed motions cause, beyond that of the initial
            configuration, m; zero where no loop goes through an imposed motion.
        """
        sites = self.system.sites
        driven = sorted({sites[i].inputs for i, _, _ in self._places if sites[i].inputs})
        members = np.array([[sites[i].inputs == inputs for inputs in driven] for i, _, _ in self._places], dtype=float)
        if not driven or not self.count:
            return 0.0
        nowhere = np.zeros(self.system.n_inputs)
        gap = self.gaps(start, nowhere) - self.gaps(self.system.start, nowhere)
        vectors, sizes, _ = np.linalg.svd(self._distribute @ members, full_matrices=False)
        caused = vectors[:, sizes > RANK * max(float(sizes.max()), 1.0)]
        return float(np.linalg.norm(caused @ (caused.T @ gap), axis=1).max(initial=0.0))

    def close(self, state: State, moved: Floats) -> Closure:
        """Close all loops.

        Parameters
        ----------
        state : State
            The configuration.
        moved : numpy.ndarray
            Time integrals of the inputs, shape (n_inputs,).

        Returns
        -------
        Closure
            Where the least gap was found.
        """
        jumps = self.gaps(state, moved)
        first = least = float(np.linalg.norm(jumps, axis=1).max(initial=0.0))
        best = state
        for _ in range(MOST_ITERATIONS):
            if least <= self.allowed(CLOSED):
                break
            state = self._displaced(state, jumps)
            jumps = self.gaps(state, moved)
            gap = float(np.linalg.norm(jumps, axis=1).max(initial=0.0))
            if not gap < 0.5 * least:
                break
            best, least = state, gap
        return Closure(best, first, least)

    def _displaced(self, state: State, jumps: Floats) -> State:
        """Move everything by the displacement of least strain energy that takes the jumps away."""
        system, inner, scale = self.system, self._inner, self._scale
        resting = np.where(self._moves, 0.0, state.x)
        let_in = np.zeros(system.sharing.expansion.shape[0])
        for gate, jump in zip(self._gates, jumps, strict=True):
            for piece in gate.part.form.ports[gate.port.name].pieces:
                local = rotate(-self._angle(gate, piece, state.theta), gate.factor * jump)
                entries = piece.output.csr((system.dimension, gate.part.form.size))
                let_in[gate.part.states] += entries.T @ local
        units = sp.diags_array(scale)
        J = units @ system.J(resting, state.theta)[inner][:, inner] @ units
        slow = SLOW / float(abs(J).sum(axis=1).max())
        b = scale * np.asarray(system.sharing.expansion.T @ let_in)[inner]
        E = units @ system.E[inner][:, inner] @ units
        displacement = np.zeros(system.n)
        displacement[inner] = scale * splu(sp.csc_array(E / slow - J)).solve(b)
        strained = np.where(self._strains, displacement / slow, 0.0)
        phi = system.features(state.theta, state.x)
        strained += system.kinematics.contracted(phi).csr(system.J0.shape) @ displacement
        shift = (system.point_velocity @ displacement).reshape(state.points.shape)
        points = state.points + rotate(system.point_angles.at(state.theta), shift)
        return State(state.x + strained, state.theta + system.rates @ displacement, points)

    def _extent(self) -> tuple[float, float]:
        """The largest difference of coordinates between what takes part, and the largest coordinate of a site, m."""
        sites = np.array([site.start for site in self.system.sites])
        if not sites.size:
            return 0.0, 0.0
        points = [part.form.points.start for part in self._parts.values() if part.form.points is not None]
        return float(np.ptp(np.vstack([sites, *points]), axis=0).max()), float(np.abs(sites).max())

    def _mechanical(self) -> np.ndarray:
        """The states that take part: velocities, strains, and forces of joints that do not lose anything."""
        system = self.system
        kinds, of_state = np.array(system.energy_kinds), system.energy_kind_of_state
        kind = kinds[of_state] if of_state.size else np.empty(0, dtype=str)
        self._moves, self._strains = kind == MOVING, (kind == STRAINED) & system.carries_energy
        lossless = system.R.diagonal() == 0.0
        used = self._moves | (kind == STRAINED) | ((kind == NO_ENERGY) & lossless)
        inner = np.flatnonzero(used)
        self._scale = state_scale(system)[inner]
        return inner

    def _angle(self, gate: _Gate, piece: Piece, theta: Floats) -> Floats:
        """Orientation of the frame of a piece."""
        frame = gate.port.anchor if piece.frame is None else piece.frame
        if frame is None or frame is FIXED:
            return np.zeros(())
        if isinstance(frame, AngleRows):
            rows = frame.rows.csr((frame.reference.size, gate.part.theta.size))
            return np.asarray((frame.reference + rows @ gate.part.turned(theta[None])[0])[0])
        assert not isinstance(frame, Attitude)  # of space
        places, weights, reference = self.system.anchor_angles[frame.path]
        return np.asarray(reference if gate.part.form.frozen else reference + theta[places] @ weights)

    def _find_gates(self) -> tuple[list[_Gate], Floats]:
        """Ports that take velocity, and the places that a jump there displaces, shape (places, gates)."""
        giver = {taking: giving for giving, taking in self.system.connections.names}
        junctions: list[str] = []
        gates: list[_Gate] = []
        rows: list[list[int]] = []
        for row, (i, name, place) in enumerate(self._places):
            part, paths = self._parts[name], self.system.sites[i].name.split(" = ")
            anchors = [a for a in part.block.anchors.values() if a.place == place and a.path in paths]
            port = anchors[0].translation
            gives = part.form.ports[port.name].gives
            junctions.append(port.path if gives else giver.get(port.path, ""))
            if not gives:
                gates.append(_Gate(part, port, -1.0))
                rows.append([row])
        for part in self.system.parts:
            for hold in part.form.holds:
                for port in (part.block.ports[hold.second], part.block.ports[hold.first]):
                    members = [row for row, junction in enumerate(junctions) if junction == giver.get(port.path)]
                    if hold.complete and members:
                        gates.append(_Gate(part, port, 1.0))
                        rows.append(members)
                        break
        opened = np.zeros((len(self._places), len(gates)))
        for gate, members in enumerate(rows):
            opened[members, gate] = 1.0
        return gates, opened
