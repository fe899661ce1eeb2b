"""The assembled port-Hamiltonian system: constant sparse arrays, and how the configuration modulates them.

    E x' = (J(x, theta) - R) z + gravity(theta) + G(theta) u      z = Q x,  Q = 1
    theta' = rates z + input_rates u                              (orientations: time integrals of spins)
    y = G(theta)^T z,     H = 1/2 x^T E x  (+ potential energy of gravity)

Spans of lines of action (springs, dampers) and distances along guides are states too, without energy:
``span' = kinematics phi x + kinematics_u u``; their rows are not part of E and J.

The configuration enters through *features* only, ``phi(theta) = [1, cos alpha, sin alpha]`` with
``alpha = alpha0 + P theta``: relative angles at joints, angles of ports in the fixed frame and of material
points.  Everything is linear in them:

    J(x, theta) = J0 + T x + K phi,    G(theta) = G0 + K_u phi,    gravity = K_g phi
"""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from phblocks.blocks.form import CONFIGURATION, NO_ENERGY
from phblocks.blocks.modulation import Modulation
from phblocks.blocks.storage import Storage
from phblocks.effects import EffectsReport
from phblocks.errors import UnknownNameError
from phblocks.export import Matrices, write
from phblocks.export.pymor import to_pymor
from phblocks.export.scipy import to_scipy
from phblocks.frames import Attitude
from phblocks.modes import Modes, find_modes
from phblocks.space import Space, space_of
from phblocks.system.angles import Angles
from phblocks.system.constraints import find_constraints
from phblocks.system.linearization import Linearization, energy_variables, linearize, small_motions
from phblocks.system.lines import Lines
from phblocks.system.matrices import energy_form, matrices_at
from phblocks.system.modulated import modulated, require_quadratic
from phblocks.system.nonlinear import nonlinear_model, to_control
from phblocks.system.parts import Connections, Guide, Input, Part, Site, State
from phblocks.system.pruning import Pruning, coordinate_names
from phblocks.system.sharing import Sharing
from phblocks.system.stability import StabilityCard, stability_card
from phblocks.system.states import require_input, require_state, rigid_motion
from phblocks.system.symbolic import SymbolicSystem, symbolic
from phblocks.triplets import Floats, Ints, Triplets

if TYPE_CHECKING:
    from phblocks.effects.record import Effect


@dataclass(frozen=True, repr=False, eq=False)
class System:
    """A diagram in matrices.

    Parameters
    ----------
    name : str
        Of the diagram.
    dimension : int
        Number of coordinates of a point.
    gravity : numpy.ndarray
        Acceleration, shape (dimension,), m/s^2.
    parts : tuple of Part
        The blocks.
    inputs : tuple of Input
        The exposed ports, one entry for each component.
    E, J0, R0 : scipy.sparse.csr_array
        Shape (n, n): symmetric positive, skew, symmetric semidefinite; the constant parts. J0 includes the joints that
        do not turn.
    T : scipy.sparse.coo_array
        Shape (n, n, n), skew in the first two axes: ``J(x) = J0 + sum_k T[:, :, k] x[k]``.
    G0 : scipy.sparse.csr_array
        Constant part of the input matrix, shape (n, n_inputs).
    angles : Angles
        The angles that modulate K, K_u and K_g.
    K : Triplets
        Shape (n, n, n_features): joints that turn, skew in the first two axes.
    K_u : Triplets
        Shape (n, n_inputs, n_features): inputs in the fixed frame.
    K_g : Triplets
        Shape (n, n_features): gravity.
    rates, input_rates : scipy.sparse.csr_array
        Shape (n_theta, n) and (n_theta, n_inputs): theta' = rates x + input_rates u.
    lines : Lines
        Lines of action; their directions are features too, after the cosines and sines.
    kinematics : Triplets
        Shape (n, n, n_features): rates of the states of the configuration; other rows are empty.
    kinematics_u : scipy.sparse.csr_array
        Shape (n, n_inputs): the same from inputs.
    connections : Connections
        Who exchanges power with whom.
    sites : tuple of Site
        Where anchors are joined in space.
    guides : tuple of Guide
        Where they are joined across some directions only.
    anchor_angles : mapping of str to (numpy.ndarray, numpy.ndarray, float)
        Orientation of each anchor: places in theta, weights, initial angle (rad).
    attitudes : mapping of str to Attitude
        In space: how each anchor stands at the start, and what it turns with.
    point_mass : numpy.ndarray
        Mass of each tracked material point, shape (n_points,), kg.
    point_velocity : scipy.sparse.csr_array
        Shape (n_points * dimension, n): their material velocities.
    point_angles : Angles
        Their orientations.
    start : State
        The initial configuration, at rest.
    sharing : Sharing
        The states that blocks share.
    report : object
        The causality report the system was assembled from.
    pruning : Pruning
        What is left out of the states, and what that rests on.
    effects : EffectsReport
        Every effect with what became of it: kept, pruned with the proof, or approximated.
    approximations : tuple of Effect
        What was left out on request, by block.
    remake : callable or None
        Assembles the same diagram with other values of its parameters, by name.
    """

    name: str
    dimension: int
    gravity: Floats
    parts: tuple[Part, ...]
    inputs: tuple[Input, ...]
    E: sp.csr_array
    J0: sp.csr_array
    R0: sp.csr_array
    T: sp.coo_array
    G0: sp.csr_array
    angles: Angles
    K: Triplets
    K_u: Triplets
    K_g: Triplets
    rates: sp.csr_array
    input_rates: sp.csr_array
    lines: Lines
    kinematics: Triplets
    kinematics_u: sp.csr_array
    connections: Connections
    sites: tuple[Site, ...]
    guides: tuple[Guide, ...]
    anchor_angles: dict[str, tuple[Ints, Floats, float]]
    attitudes: dict[str, Attitude]
    point_mass: Floats
    point_velocity: sp.csr_array
    point_angles: Angles
    start: State
    sharing: Sharing
    report: object = field(repr=False)
    pruning: Pruning
    effects: EffectsReport
    approximations: tuple[Effect, ...] = ()
    remake: Callable[[Mapping[str, float]], System] | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        """Count what the system has."""
        blocks = sum(part.form.size > 0 for part in self.parts)
        return f"<System {self.name!r}: {self.n} states of {blocks} blocks, {self.n_inputs} inputs>"

    @property
    def n(self) -> int:
        """Number of energy states, the unknowns of a step."""
        return int(self.E.shape[0])

    @property
    def n_inputs(self) -> int:
        """Number of scalar inputs."""
        return len(self.inputs)

    @property
    def n_features(self) -> int:
        """Number of features of the configuration."""
        return 1 + 2 * self.angles.reference.size + 2 * self.lines.count

    def features(self, theta: Floats, x: Floats) -> Floats:
        """Evaluate all features of a configuration.

        Parameters
        ----------
        theta : numpy.ndarray
            Rotation states, shape (n_theta,) or (n_theta, m).
        x : numpy.ndarray
            States, shape (n,) or (n, m): the spans of lines are among them.

        Returns
        -------
        numpy.ndarray
            phi, shape (n_features,) or (n_features, m).
        """
        return np.concatenate([self.angles.features(theta), self.lines.directions(theta, x)])

    @property
    def space(self) -> Space:
        """Planar or spatial."""
        return space_of(self.dimension)

    @cached_property
    def prepared(self) -> dict[Hashable, object]:
        """What others made of this system once and want to find again, such as equations of time methods."""
        return {}

    @cached_property
    def Q(self) -> sp.csr_array:
        """The identity: states are co-energy variables.

        Raises
        ------
        StructureError
            If the energy is not quadratic: E and Q do not make it then.
        """
        require_quadratic(self, "Q")
        return sp.csr_array(sp.eye_array(self.n))

    @cached_property
    def rate_matrix(self) -> sp.csr_array:
        """What multiplies x' in the equations, shape (n, n): E, and one in the rows of the configuration.

        The rates of energy variables whose energy is not quadratic stand in the rows of their co-energy variables.
        """
        moving = np.flatnonzero(self.configuration)
        ones = [Triplets.of(moving, moving, values=1.0)]
        ones += [Triplets.of(s.coenergy, s.energy, values=1.0) for s in self.storages]
        return sp.csr_array(self.E + Triplets.join(ones).csr(self.J0.shape))

    @cached_property
    def storages(self) -> tuple[Storage, ...]:
        """Where energy is stored that is not quadratic in the states, with indices among those of the system."""
        place = self.sharing.state_of
        return tuple(
            p.form.storage.shifted(int(place(np.array(p.states.start))))
            for p in self.parts
            if p.form.storage is not None and self.computes(p)
        )

    @cached_property
    def modulations(self) -> tuple[Modulation, ...]:
        """Parts of J and R that depend on energy variables, with indices among the states of the system."""
        place = self.sharing.state_of
        return tuple(
            p.form.modulation.shifted(int(place(np.array(p.states.start))))
            for p in self.parts
            if p.form.modulation is not None and self.computes(p)
        )

    def computes(self, part: Part) -> bool:
        """Tell whether all of a block is computed, nothing of it being left out.

        Parameters
        ----------
        part : Part
            The block.

        Returns
        -------
        bool
            False if some of its coordinates stay what they are.
        """
        return bool(np.isin(np.arange(part.states.start, part.states.stop), self._computed).all())

    @cached_property
    def _computed(self) -> Ints:
        """The coordinates that follow from states."""
        return np.flatnonzero(np.diff(self.sharing.expansion.indptr))

    @cached_property
    def R(self) -> sp.csr_array:
        """R in the initial configuration, shape (n, n); elsewhere see :meth:`R_at`."""
        return self.R_at(self.start.x)

    @property
    def quadratic(self) -> bool:
        """Whether the energy is quadratic in the states, so that the midpoint rule keeps its balance exactly."""
        return not self.storages

    @cached_property
    def coenergy(self) -> NDArray[np.bool_]:
        """For each state whether it is the gradient of an energy that is not quadratic."""
        found = np.zeros(self.n, dtype=bool)
        for storage in self.storages:
            found[storage.coenergy] = True
        return found

    def settled(self, x: Floats) -> Floats:
        """Set the co-energy variables to the gradients of their energies.

        Parameters
        ----------
        x : numpy.ndarray
            States, shape (n,).

        Returns
        -------
        numpy.ndarray
            A copy; the same array if the system is quadratic.
        """
        if self.quadratic:
            return x
        x = x.copy()
        for storage in self.storages:
            x[storage.coenergy] = storage.gradient(x[storage.energy])
        return x

    @property
    def linear(self) -> bool:
        """Whether J and G are constant and gravity does not turn: one factorisation serves all steps."""
        return self.quadratic and self.T.nnz == 0 and not any(k.indices[-1].any() for k in (self.K, self.K_u, self.K_g))

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """Name of each state: block, field, component and number along the block, such as ``crank.V1[0]``."""
        names = coordinate_names(self.parts)
        return tuple(names[i] for i in self.sharing.kept)

    @cached_property
    def state_units(self) -> tuple[str, ...]:
        """SI unit of each state."""
        units = [r.unit for p in self.parts for r in p.form.runs for _ in range(r.positions.size)]
        return tuple(units[i] for i in self.sharing.kept)

    @cached_property
    def theta_names(self) -> tuple[str, ...]:
        """Name of each rotation state, such as ``crank.theta[0]``; ``turned[0]`` if an input drives it."""
        names = [f"turned[{i}]" for i in range(self.start.theta.size)]
        for part in self.parts:
            for i, place in enumerate(part.theta):
                if place >= 0:
                    names[place] = f"{part.name}.theta[{i}]"
        return tuple(names)

    @cached_property
    def state_positions(self) -> Floats:
        """Place of each state along its block, shape (n,), m from the start."""
        positions = [run.positions for part in self.parts for run in part.form.runs]
        return np.concatenate(positions or [np.empty(0)])[self.sharing.kept]

    @cached_property
    def energy_kinds(self) -> tuple[str, ...]:
        """Kinds of energy the states store, such as ``("kinetic", "strain")``."""
        return tuple(dict.fromkeys(run.energy for part in self.parts for run in part.form.runs))

    @property
    def energy_kind_of_state(self) -> Ints:
        """For each state its place in :attr:`energy_kinds`, shape (n,)."""
        return self.energy_kind_of_coordinate[self.sharing.kept]

    @cached_property
    def energy_kind_of_coordinate(self) -> Ints:
        """For each coordinate of the blocks its place in :attr:`energy_kinds`."""
        kinds = {kind: i for i, kind in enumerate(self.energy_kinds)}
        runs = [run for part in self.parts for run in part.form.runs]
        return np.repeat([kinds[r.energy] for r in runs], [r.positions.size for r in runs]).astype(np.int64)

    @cached_property
    def configuration(self) -> NDArray[np.bool_]:
        """For each state whether it belongs to the configuration: spans of lines, distances along guides."""
        return np.array([kind == CONFIGURATION for kind in self.energy_kinds], dtype=bool)[self.energy_kind_of_state]

    @cached_property
    def carries_energy(self) -> NDArray[np.bool_]:
        """For each state whether E says that it stores energy.

        Multipliers, states of stateless parts and spans do not, nor do states whose energy is not quadratic.
        """
        carry = np.array([kind not in (NO_ENERGY, CONFIGURATION) for kind in self.energy_kinds], dtype=bool)
        # a state that blocks share stores energy if it does in one of them
        carries = np.asarray(abs(self.sharing.expansion).T @ carry[self.energy_kind_of_coordinate].astype(float)) > 0.0
        for storage in self.storages:
            carries[storage.energy] = False
        return carries

    @cached_property
    def algebraic(self) -> NDArray[np.bool_]:
        """For each state whether it has no rate: a column of zeros in :attr:`rate_matrix`."""
        rated = np.zeros(self.n, dtype=bool)
        rated[self.rate_matrix.indices] = True
        return ~rated

    @cached_property
    def is_dae(self) -> bool:
        """Whether E is singular: there are states without energy."""
        return bool((self.algebraic & ~self.coenergy).any())

    @cached_property
    def constraint_names(self) -> tuple[str, ...]:
        """The constraints that states with energy must satisfy, by the state without energy that each belongs to.

        Empty if there are none: then the states without energy follow from the others (index 1, not 2).
        """
        return find_constraints(self).names if self.is_dae else ()

    @cached_property
    def acting(self) -> Ints:
        """The inputs that may differ from zero: all, but those that ``effects`` was proven without.

        Matrices and models for other tools have these only: what the others alone would move is not computed.
        """
        return np.setdiff1d(np.arange(self.n_inputs), self.pruning.quiet)

    @property
    def input_names(self) -> tuple[str, ...]:
        """Name of each input."""
        return tuple(i.name for i in self.inputs)

    @property
    def output_names(self) -> tuple[str, ...]:
        """Name of each output: that of the input it is conjugate to, and the quantity."""
        return tuple(f"{i.name} {i.answered.name}" for i in self.inputs)

    def part(self, name: str) -> Part:
        """Look up a block.

        Parameters
        ----------
        name : str
            Of the block.

        Returns
        -------
        Part
            Its form and its place in the system.

        Raises
        ------
        UnknownNameError
            If there is no such block.
        """
        for part in self.parts:
            if part.name == name:
                return part
        known = ", ".join(p.name for p in self.parts)
        raise UnknownNameError(
            f"system {self.name!r}", expected=f"one of {known}", got=repr(name), fix="Check the name."
        )

    def J(self, x: Floats | None = None, theta: Floats | None = None) -> sp.csr_array:
        """Evaluate the structure matrix.

        Parameters
        ----------
        x : numpy.ndarray, optional
            Energy states, shape (n,); zero by default, but those of the start for matrices that are functions of
            the user's.
        theta : numpy.ndarray, optional
            Rotation states, shape (n_theta,); the initial configuration by default.

        Returns
        -------
        scipy.sparse.csr_array
            J(x, theta), shape (n, n), skew.
        """
        theta = self.start.theta if theta is None else theta
        at = self.start.x if x is None else x
        phi = self.features(theta, at)
        joints = self.K.contracted(phi).csr(self.J0.shape)
        products = (
            sp.csr_array(self.J0.shape) if x is None else Triplets.from_coo(self.T).contracted(x).csr(self.J0.shape)
        )
        own = (
            modulated(self, at, lambda m, x: m.interconnection(x)) if self.modulations else sp.csr_array(self.J0.shape)
        )
        return sp.csr_array(self.J0 + products + joints + own)

    def R_at(self, x: Floats) -> sp.csr_array:
        """Evaluate the dissipation matrix.

        Parameters
        ----------
        x : numpy.ndarray
            Energy states, shape (n,).

        Returns
        -------
        scipy.sparse.csr_array
            R(x), shape (n, n), symmetric and positive semidefinite; constant unless a block brings functions.
        """
        return (
            sp.csr_array(self.R0 + modulated(self, x, lambda m, x: m.dissipation(x))) if self.modulations else self.R0
        )

    def G(self, theta: Floats | None = None, x: Floats | None = None) -> sp.csr_array:
        """Evaluate the input matrix.

        Parameters
        ----------
        theta : numpy.ndarray, optional
            Rotation states, shape (n_theta,); the initial configuration by default.
        x : numpy.ndarray, optional
            States, shape (n,), for the directions of lines; those of the start by default.

        Returns
        -------
        scipy.sparse.csr_array
            G(theta), shape (n, n_inputs); the outputs are ``G^T x``.
        """
        theta = self.start.theta if theta is None else theta
        phi = self.features(theta, self.start.x if x is None else x)
        return sp.csr_array(self.G0 + self.K_u.contracted(phi).csr(self.G0.shape))

    def gravity_force(self, theta: Floats | None = None) -> Floats:
        """Evaluate the generalised force of gravity.

        Parameters
        ----------
        theta : numpy.ndarray, optional
            Rotation states, shape (n_theta,); the initial configuration by default.

        Returns
        -------
        numpy.ndarray
            Shape (n,).
        """
        theta = self.start.theta if theta is None else theta
        return np.asarray(self.K_g.csr((self.n, self.n_features)) @ self.features(theta, self.start.x))

    def force(self, x: Floats, theta: Floats | None = None, u: Floats | None = None) -> Floats:
        """Evaluate the right-hand side of ``rate_matrix x' = ...``.

        Parameters
        ----------
        x : numpy.ndarray
            Energy states, shape (n,).
        theta : numpy.ndarray, optional
            Rotation states, shape (n_theta,); the initial configuration by default.
        u : numpy.ndarray, optional
            Inputs, shape (n_inputs,); zero by default.

        Returns
        -------
        numpy.ndarray
            Shape (n,).
        """
        u = np.zeros(self.n_inputs) if u is None else u
        theta = self.start.theta if theta is None else theta
        moving = self.kinematics.contracted(self.features(theta, x)).csr(self.J0.shape)
        result = (self.J(x, theta) - self.R_at(x) + moving) @ x + self.gravity_force(theta)
        for s in self.storages:
            result[s.energy] -= s.gradient(x[s.energy])
        return np.asarray(result + (self.G(theta, x) + self.kinematics_u) @ u)

    def linearize(self, state: State | None = None, u: Floats | None = None) -> Linearization:
        """Linearise the equations of motion about a state.

        From inputs to outputs it is that of the whole diagram. States that nothing excites and that are left out
        (``system.effects``) are not among its states, so that motions of their own, stable or not, are not either.

        Parameters
        ----------
        state : State, optional
            The initial configuration at rest by default. It need not be an equilibrium: the derivatives are those
            at the state.
        u : numpy.ndarray, optional
            Inputs there, shape (n_inputs,); zero by default.

        Returns
        -------
        Linearization
            Its states are x, and theta where the right-hand side depends on it.

        Raises
        ------
        DataError
            If the state or the input does not fit.
        ArgumentTypeError
            If one of them is of the wrong kind.
        """
        state = None if state is None else require_state(self, state, "linearize state")
        return linearize(self, state, None if u is None else require_input(self, u, "linearize u"))

    def small_motions(self) -> System:
        """Return the linear system for small motions about the initial configuration.

        The products of states (T) are dropped, and joints, ports and gravity keep their initial angles; a step
        then costs one back-substitution. Valid for turns and spins that are small: it has no centrifugal
        stiffening and no buckling, and gravity does not turn with the parts, so that a pendulum does not swing. Where
        that matters, use :meth:`linearize`.

        Returns
        -------
        System
            With constant matrices and the same names.
        """
        return small_motions(self)

    def modes(self, n: int, state: State | None = None, u: Floats | None = None) -> Modes:
        """Find the lowest natural frequencies of the linearisation about a state.

        Parameters
        ----------
        n : int
            How many; fewer are returned if there are fewer.
        state : State, optional
            The initial configuration at rest by default: without stress, so that under gravity it is no equilibrium,
            and a bar that carries a mass is not stiffened by it. A loaded state, such as the end of a damped run, is an
            equilibrium only together with the inputs that hold it: give them too.
        u : numpy.ndarray, optional
            Inputs there, shape (n_inputs,); zero by default.

        Returns
        -------
        Modes
            Frequencies above zero in rad/s, growth rates and shapes; rigid-body modes are left out.

        Raises
        ------
        DataError
            If n is not a positive integer, or a state or input does not fit.
        PrunedError
            If states were left out because nothing excites them: their modes would be missing.
        """
        self.pruning.require_none(self, f"modes of system {self.name!r}")
        return self.excited_modes(n, state, u)

    def excited_modes(self, n: int, state: State | None = None, u: Floats | None = None) -> Modes:
        """Find the lowest natural frequencies among the motions that something excites.

        Parameters
        ----------
        n : int
            How many; fewer are returned if there are fewer.
        state : State, optional
            About which; the start by default.
        u : numpy.ndarray, optional
            Inputs there, shape (n_inputs,); zero by default.

        Returns
        -------
        Modes
            As of :meth:`modes`, but without those of states that ``effects`` says are left out.

        Raises
        ------
        DataError
            If n is not a positive integer, or a state or input does not fit.
        """
        linear = self.linearize(state, u)
        if self.quadratic:
            return find_modes(linear.E, linear.A, n)
        left, right = energy_variables(self, self.start if state is None else state, linear.A.shape[0])
        found = find_modes(sp.csr_array(left @ linear.E @ right), sp.csr_array(left @ linear.A @ right), n)
        return Modes(found.frequencies, found.growth, right @ found.shapes, found.diverging)

    def stability_card(self, dt: float, state: State | None = None) -> StabilityCard:
        """Tell before a run what a step will meet: frequencies, condition, index, expected gap; prints as a table.

        Parameters
        ----------
        dt : float
            The step, s.
        state : State, optional
            About which it is linear; the initial configuration at rest by default.

        Returns
        -------
        StabilityCard
            Of the midpoint rule.

        Raises
        ------
        DataError
            If the step is not positive, or the state does not fit.
        """
        return stability_card(self, dt, state)

    def rigid_motion(
        self,
        velocity: ArrayLike | None = None,
        spin: ArrayLike | None = None,
        about: ArrayLike | None = None,
        blocks: Sequence[str] | None = None,
    ) -> State:
        """Make a start that moves as a rigid body, from the initial configuration.

        Parameters
        ----------
        velocity : array_like, optional
            Of the point ``about``, shape (dimension,), m/s, in the fixed frame; zero by default.
        spin : array_like, optional
            Angular velocity, rad/s: a number in the plane, shape (3,) in space, in the fixed frame; zero by default.
        about : array_like, optional
            A point, shape (dimension,), m; the origin by default.
        blocks : sequence of str, optional
            Names of the blocks that move; all by default, the others are at rest.

        Returns
        -------
        State
            For ``simulate(..., start=...)``.

        Raises
        ------
        DataError
            If a value is not finite or has the wrong shape.
        UnknownNameError
            If there is no such block.
        PrunedError
            If it moves what is left out (``system.effects``).
        """
        return rigid_motion(self, velocity, spin, about, blocks)

    def matrices(
        self, state: State | None = None, u: Floats | None = None, *, energy_variables: bool = False
    ) -> Matrices:
        """Evaluate E, J, R, Q, G and the tangent A, B, C, D at a state, with all names and units.

        An energy that is not quadratic is taken to second order at the state: its co-energy variables leave, Q has its
        Hessian, and its energy variables are shifted so that ``Q x`` is its gradient there. J, R and G are those at
        the state; the tangent has their derivatives too.

        Parameters
        ----------
        state : State, optional
            The initial configuration at rest by default.
        u : numpy.ndarray, optional
            Inputs there, shape (n_inputs,); zero by default.
        energy_variables : bool, optional
            The states are momenta, elongations, ... (E x) instead of velocities, forces, ...; E is one, Q the inverse
            of E, and states without energy are eliminated (Schur complement; G, P, S and N follow). No tangent then.
            These matrices are dense: for systems of some thousand states at most.

        Returns
        -------
        Matrices
            What :meth:`export` writes.

        Raises
        ------
        DataError
            If the state or the input does not fit.
        StructureError
            If an energy that is not quadratic has no positive semidefinite Hessian at the state; in energy variables
            also if states without energy do not follow from the others (joints with multipliers).
        """
        state = None if state is None else require_state(self, state, "matrices state")
        found = matrices_at(self, state, None if u is None else require_input(self, u, "matrices u"))
        return energy_form(self, found) if energy_variables else found

    def to_control(
        self, state: State | None = None, u: Floats | None = None, *, nonlinear: bool = False, eliminate: bool = False
    ) -> Any:
        """Make a model for python-control, with E inverted and names of letters, digits and underscores.

        Parameters
        ----------
        state : State, optional
            About which it is linear; the initial configuration at rest by default.
        u : numpy.ndarray, optional
            Inputs there, shape (n_inputs,); zero by default.
        nonlinear : bool, optional
            The equations of motion at all states instead, with energy states and rotation states as states.
        eliminate : bool, optional
            Eliminate states without a rate that follow from the others (dampers, internal damping) from the linear
            model, which is exact; by default they are refused.

        Returns
        -------
        control.StateSpace or control.NonlinearIOSystem
            With the inputs and outputs of the system.

        Raises
        ------
        StructureError
            If E is singular, or states that are to be eliminated do not follow from the others.
        ExtraMissingError
            If python-control is not installed.
        DataError
            If the state or the input does not fit.
        """
        return to_control(self, state, u, nonlinear, eliminate)

    def to_scipy(self, state: State | None = None, u: Floats | None = None, *, eliminate: bool = False) -> Any:
        """Make a linear model for ``scipy.signal``; see :meth:`to_control`.

        Parameters
        ----------
        state : State, optional
            About which it is linear; the initial configuration at rest by default.
        u : numpy.ndarray, optional
            Inputs there, shape (n_inputs,); zero by default.
        eliminate : bool, optional
            Eliminate states without a rate that follow from the others.

        Returns
        -------
        scipy.signal.StateSpace
            Inputs and outputs are in the order of :attr:`input_names` and :attr:`output_names`.

        Raises
        ------
        StructureError
            If E is singular, or states that are to be eliminated do not follow from the others.
        DataError
            If the state or the input does not fit.
        """
        return to_scipy(self.matrices(state, u), eliminate)

    def to_pymor(self, state: State | None = None, *, energy_variables: bool = False) -> Any:
        """Make a port-Hamiltonian model for pyMOR, whose N has the opposite sign.

        Parameters
        ----------
        state : State, optional
            At which J, R and G are taken; the initial configuration at rest by default.
        energy_variables : bool, optional
            See :meth:`matrices`: without states that store no energy, which methods of reduction may not like.

        Returns
        -------
        pymor.models.iosys.PHLTIModel
            Of the matrices at the state; what gravity and turning joints add to the tangent is not in it.

        Raises
        ------
        ExtraMissingError
            If pyMOR is not installed.
        StructureError
            As of :meth:`matrices`.
        DataError
            If the state does not fit.
        """
        return to_pymor(self.matrices(state, energy_variables=energy_variables))

    def symbolic(self) -> SymbolicSystem:
        """Write a small system in sympy: matrices, Hamiltonian, equations, LaTeX.

        Arguments of blocks that were given as ``ph.Parameter("m", 2.0)`` are symbols in all of them, if the matrices
        depend on them by powers; other numbers are numbers.

        Returns
        -------
        SymbolicSystem
            The same in symbols.

        Raises
        ------
        DataError
            If there are more than 60 states, or parameters of one name with several values.
        StructureError
            If matrices are functions of the user's, an energy is not an expression, or a parameter enters in another
            way than by powers.
        """
        return symbolic(self)

    def export(
        self, path: str | os.PathLike[str], state: State | None = None, u: Floats | None = None
    ) -> tuple[Path, ...]:
        """Write E, J, R, Q, G and the tangent A, B, C, D at a state, with all names and units, to a file.

        The equations of motion at all states are in the file too, in constant matrices, unless an energy is not
        quadratic: that comes with functions of the user's, which have no place in a file of matrices.

        Parameters
        ----------
        path : str or os.PathLike
            The suffix chooses the format: ``.mat`` (MATLAB), ``.npz`` (NumPy), ``.mtx`` (Matrix Market).
        state : State, optional
            The initial configuration at rest by default.
        u : numpy.ndarray, optional
            Inputs there, shape (n_inputs,); zero by default.

        Returns
        -------
        tuple of pathlib.Path
            The files that were written.

        Raises
        ------
        ExportError
            If the suffix is unknown, or the file cannot be written.
        DataError
            If the state or the input does not fit.
        StructureError
            If an energy that is not quadratic has no positive semidefinite Hessian at the state.
        """
        matrices = self.matrices(state, u)
        return write(replace(matrices, nonlinear=nonlinear_model(self, state)) if self.quadratic else matrices, path)

    def energy(self, x: Floats) -> float:
        """Evaluate the stored energy, without the potential of gravity.

        Parameters
        ----------
        x : numpy.ndarray
            Energy states, shape (n,).

        Returns
        -------
        float
            ``1/2 x^T E x`` and the energies that are not quadratic, J.
        """
        other = sum(float(s.hamiltonian(x[s.energy])) for s in self.storages)
        return float(0.5 * x @ (self.E @ x)) + other
