"""The books of a run: energies and powers as sums over entries that belong to a block, a connection or an input."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from phblocks.frames import rotate
from phblocks.system import System
from phblocks.triplets import Floats, Ints, Triplets


class Coordinates:
    """The coordinates of blocks that are not zero all the time, from the states.

    Parameters
    ----------
    system : System
        The system.

    Attributes
    ----------
    number : numpy.ndarray
        Their numbers among those of all blocks, shape (coordinates,).
    """

    def __init__(self, system: System) -> None:
        sharing = system.sharing
        self.number = np.flatnonzero((np.diff(sharing.expansion.indptr) > 0) | (sharing.constant != 0.0))
        self._place = np.full(sharing.constant.size, -1)
        self._place[self.number] = np.arange(self.number.size)
        self._expansion, self._constant = sp.csr_array(sharing.expansion[self.number]), sharing.constant[self.number]
        self._states = np.array_equal(self.number, sharing.kept)

    def at(self, x: Floats) -> Floats:
        """Evaluate them.

        Parameters
        ----------
        x : numpy.ndarray
            States, shape (times, n).

        Returns
        -------
        numpy.ndarray
            Shape (times, coordinates); the same array if they are the states.
        """
        return x if self._states else np.asarray((self._expansion @ x.T).T) + self._constant

    def of(self, entries: Triplets, axes: Sequence[int]) -> tuple[Triplets, Ints]:
        """Leave out the entries that multiply a coordinate that is zero.

        Parameters
        ----------
        entries : Triplets
            In coordinates of all blocks.
        axes : sequence of int
            Which of their indices count coordinates.

        Returns
        -------
        entries : Triplets
            In these coordinates.
        kept : numpy.ndarray
            Which there still are.
        """
        indices = [self._place[i] if axis in axes else i for axis, i in enumerate(entries.indices)]
        kept = np.flatnonzero(np.all([indices[axis] >= 0 for axis in axes], axis=0))
        return Triplets(tuple(i[kept] for i in indices), entries.values[kept]), kept


class Books:
    """Sums over entries that belong to a block, a kind of energy, a connection or an input.

    Parameters
    ----------
    system : System
        The system.

    Attributes
    ----------
    n_blocks, n_kinds : int
        Of energy, the kinds.
    sharing : numpy.ndarray
        Which blocks share states with others, shape (blocks,).
    moving : numpy.ndarray or slice
        The components of the positions of material points that anything moves, numbered point by point.
    """

    @classmethod
    def of(cls, system: System) -> Books:
        """Make them, or find those that a run before made.

        Parameters
        ----------
        system : System
            The system.

        Returns
        -------
        Books
            Kept with the system.
        """
        known = system.prepared.get("books")
        if not isinstance(known, cls):
            known = system.prepared["books"] = cls(system)
        return known

    def __init__(self, system: System) -> None:
        self.system, self._coordinates = system, Coordinates(system)
        self.n_blocks, self.n_kinds = len(system.parts), len(system.energy_kinds)
        self._block = np.repeat(np.arange(self.n_blocks), [p.states.stop - p.states.start for p in system.parts])
        number, kinds = self._coordinates.number, system.energy_kind_of_coordinate
        block, kind = self._block[number], kinds[number]
        self._energy_sum = _summing(block * self.n_kinds + kind, self.n_blocks * self.n_kinds)
        E, R = (sp.csr_array(matrix[number][:, number]) for matrix in _of_blocks(system))
        self._E = E
        connections = system.connections
        self._flow, kept = self._coordinates.of(connections.entries, (0, 1))
        self._flow_sum = _summing(connections.number[kept], len(connections.names))
        exchange = connections.exchange
        self._exchange = replace(exchange, outputs=sp.csr_array(exchange.outputs[:, number]))
        ends = np.arange(len(connections.names))
        giving, taking = connections.blocks.T
        self._receive = Triplets.join(
            [Triplets.of(taking, ends, values=1.0), Triplets.of(giving, ends, values=-1.0)]
        ).csr((self.n_blocks, ends.size))
        self._input, _ = self._coordinates.of(connections.supply, (0,))
        self._input_sum = _summing(self._input.indices[1], system.n_inputs)
        self._input_block_sum = _summing(block[self._input.indices[0]], self.n_blocks)
        self._modulated = bool(self._flow.indices[2].any() or self._input.indices[2].any())
        self._damping = R.tocoo()
        self._damping_sum = _summing(block[self._damping.coords[0]], self.n_blocks)
        self._prepare_points()

        groups = system.sharing.groups
        group = np.arange(self.n_blocks)
        for blocks in groups:
            group[list(blocks)] = blocks[0]
        self._group, self._group_sum = group, _summing(group, self.n_blocks)
        self.sharing = np.isin(np.arange(self.n_blocks), [b for blocks in groups for b in blocks])

    def _prepare_points(self) -> None:
        """Find the components of positions that anything moves, their velocities, and what gravity does there."""
        system, d = self.system, self.system.dimension
        moved = np.diff(system.point_velocity.indptr).reshape(-1, d) > 0
        turns, angles = np.diff(system.point_angles.rows.indptr) > 0, system.point_angles.reference
        away = moved.any(axis=1) & (turns | (angles != 0.0))
        moved[away] = True  # a frame that is not the fixed one mixes the components
        moving, place = np.flatnonzero(moved.ravel()), np.cumsum(moved.ravel()).reshape(moved.shape) - 1
        self.moving: Ints | slice = moving if moving.size < moved.size else slice(None)
        self._turning = np.flatnonzero(away & turns)
        self._turned = place[self._turning]
        tilted = np.flatnonzero(away & ~turns)
        axes = rotate(angles[tilted, None], np.broadcast_to(np.eye(d), (tilted.size, d, d)))
        rows, columns = np.tile(place[tilted], d), np.repeat(place[tilted], d, axis=1)  # of the image of each axis
        others = np.setdiff1d(np.arange(moving.size), place[tilted])
        frames = Triplets.join(
            [
                Triplets.of(others, others, values=1.0),
                Triplets.of(rows.ravel(), columns.ravel(), values=axes.ravel()),
            ]
        ).csr((moving.size, moving.size))
        self._velocity = sp.csr_array(frames @ system.point_velocity[moving])
        points = [p.points.stop - p.points.start for p in system.parts]
        block = np.repeat(np.arange(self.n_blocks), points)[moving // d]
        weight = -(system.point_mass[:, None] * system.gravity).ravel()[moving]
        heavy = np.flatnonzero(weight)
        self._weight = Triplets.of(block[heavy], heavy, values=weight[heavy]).csr((self.n_blocks, moving.size))

    def zero(self) -> dict[str, Floats]:
        """Return totals at the start.

        Returns
        -------
        dict of str to numpy.ndarray
            Zeros.
        """
        of_blocks = ("potential", "supplied_to", "shared", "dissipated", "numerical", "projected")
        sizes = dict.fromkeys(of_blocks, self.n_blocks)
        sizes |= {"transferred": len(self.system.connections.names), "supplied": self.system.n_inputs}
        return {key: np.zeros(size) for key, size in sizes.items()}

    def quadratic(self, x: Floats) -> Floats:
        """Evaluate the stored energies that are quadratic.

        Parameters
        ----------
        x : numpy.ndarray
            States, shape (times, n).

        Returns
        -------
        numpy.ndarray
            Shape (times, blocks, kinds), J.
        """
        z = self._coordinates.at(x)
        density = 0.5 * z * (self._E @ z.T).T
        return np.asarray((self._energy_sum @ density.T).T).reshape(-1, self.n_blocks, self.n_kinds)

    def stored(self, x: Floats) -> Floats:
        """Evaluate the stored energies.

        Parameters
        ----------
        x : numpy.ndarray
            States, shape (times, n).

        Returns
        -------
        numpy.ndarray
            Shape (times, blocks, kinds), J.
        """
        stored = self.quadratic(x)
        for storage in self.system.storages:
            at = self.system.sharing.kept[storage.energy]
            kind = self.system.energy_kind_of_coordinate[at[0]]
            stored[:, self._block[at[0]], kind] += [storage.hamiltonian(row) for row in x[:, storage.energy]]
        return stored

    def of_groups(self, missing: Floats) -> Floats:
        """Sum over the blocks that share states with a block: what one misses another has.

        Parameters
        ----------
        missing : numpy.ndarray
            By block, shape (times, blocks), J.

        Returns
        -------
        numpy.ndarray
            Shape (times, blocks), J.
        """
        return np.asarray((self._group_sum @ missing.T).T)[:, self._group] if self.sharing.any() else missing

    def potential(self, moved: Floats) -> Floats:
        """Evaluate what gravity stores in displacements.

        Parameters
        ----------
        moved : numpy.ndarray
            Displacements, the components :attr:`moving`, shape (times, moving), m.

        Returns
        -------
        numpy.ndarray
            By block, shape (times, blocks), J.
        """
        return np.asarray((self._weight @ moved.T).T)

    def received(self, transferred: Floats) -> Floats:
        """Sum what blocks receive through connections.

        Parameters
        ----------
        transferred : numpy.ndarray
            From giving to taking blocks, shape (times, connections).

        Returns
        -------
        numpy.ndarray
            Shape (times, blocks).
        """
        return np.asarray((self._receive @ transferred.T).T)

    def velocities(self, z: Floats, theta: Floats) -> Floats:
        """Evaluate the velocities of the material points.

        Parameters
        ----------
        z : numpy.ndarray
            States, shape (times, n).
        theta : numpy.ndarray
            Rotation states, shape (times, n_theta), rad.

        Returns
        -------
        numpy.ndarray
            In the fixed frame, the components :attr:`moving`, shape (times, moving), m/s.
        """
        velocity = np.asarray((self._velocity @ z.T).T)
        if self._turning.size:
            angle = self.system.point_angles.at(theta.T)[self._turning].T
            velocity[:, self._turned] = rotate(angle, velocity[:, self._turned])
        return velocity

    def rates(self, theta: Floats, x: Floats, frozen: Floats, u: Floats, losses: list[Floats]) -> dict[str, Floats]:
        """Evaluate powers: through connections (by the matrices, and by the ports), inputs, dampings.

        Parameters
        ----------
        theta, x, u : numpy.ndarray
            Rotation states, states and inputs, shapes (times, n_theta), (times, n) and (times, n_inputs).
        frozen : numpy.ndarray
            States in which lines have their directions, shape (times, n).
        losses : list of numpy.ndarray
            R(x) of the modulations, each of shape (times, a, a).

        Returns
        -------
        dict of str to numpy.ndarray
            W, each of shape (times, ...).
        """
        z = self._coordinates.at(x)
        phi = self.system.features(theta.T, frozen.T).T if self._modulated else np.ones((len(z), 1))
        i, j, f = self._flow.indices
        transferred = self._flow_sum @ (self._flow.values * phi[:, f] * z[:, j] * z[:, i]).T
        i, k, f = self._input.indices
        supply = (self._input.values * phi[:, f] * z[:, i] * u[:, k]).T
        a, b = self._damping.coords
        loss = (self._damping.data * z[:, a] * z[:, b]).T
        dissipated = (self._damping_sum @ loss).T
        for m, R in zip(self.system.modulations, losses, strict=True):
            on, w = self.system.sharing.kept[m.on], x[:, m.on]
            dissipated[:, self._block[on[0]]] += np.einsum("ti,tij,tj->t", w, R, w)
        return {
            "transferred": transferred.T,
            "between_ports": self._exchange.powers(self.system.lines, theta, frozen, z),
            "supplied": (self._input_sum @ supply).T,
            "supplied_to": (self._input_block_sum @ supply).T,
            "dissipated": dissipated,
        }


def over_last(values: Floats) -> Floats:
    """Sum over the last axis, which is short: several times as fast as ``sum``.

    Parameters
    ----------
    values : numpy.ndarray
        Shape (..., k).

    Returns
    -------
    numpy.ndarray
        Shape (...).
    """
    return np.asarray(values[..., 0] if values.shape[-1] == 1 else values @ np.ones(values.shape[-1]))


def _of_blocks(system: System) -> tuple[sp.csr_array, sp.csr_array]:
    """E and R of all blocks, each in its own coordinates."""
    if system.sharing.trivial:
        return system.E, system.R0
    n, first = system.sharing.expansion.shape[0], [p.states.start for p in system.parts]
    E, R = (
        Triplets.join(entries.shifted(i, i) for entries, i in zip(of_blocks, first, strict=True)).csr((n, n))
        for of_blocks in ([p.form.E for p in system.parts], [p.form.R for p in system.parts])
    )
    return E, R


def _summing(group: Ints, size: int) -> sp.csr_array:
    """The matrix that sums entries of the same group."""
    return Triplets.of(group, np.arange(group.size), values=1.0).csr((size, group.size))
