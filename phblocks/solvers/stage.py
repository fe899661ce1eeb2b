"""The nonlinear equation of one implicit stage, prepared for speed.

Unknown is z, the energy states at the stage. With the stage's orientation ``theta = theta0 + tau (rates z)`` it
must satisfy

    residual(z) = mass_factor E z - (J(z, theta) - R) z - gravity(theta) - G(theta) u - b = 0.

Everything is done in *scaled, reordered* unknowns: ``z = scale * zhat[order]`` with ``scale = diag(E)^(-1/2)``, so
that ``|zhat|^2`` is about twice the energy whatever the units, and an order of small bandwidth. All products with
the state are sparse matrix products over the whole system: no loop over elements, joints or quadrature points.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Hashable
from functools import cached_property
from itertools import pairwise
from typing import Self

import numpy as np
import scipy.sparse as sp

from phblocks.solvers.equations import Equations
from phblocks.solvers.features import Dependence, LineDirections, entry_code, modulated_pairs, taken
from phblocks.solvers.modulations import ModulatedMatrices
from phblocks.solvers.ordering import narrow_order
from phblocks.solvers.residual import ResidualParts
from phblocks.solvers.storages import StorageEquations
from phblocks.system import System
from phblocks.triplets import Floats, Ints, Triplets

_ONE, _NONE = np.ones(1), np.zeros(0)


class StageEquation:
    """Residual and Jacobian of a stage over a fixed sparsity pattern.

    Parameters
    ----------
    system : System
        The system to integrate.

    Attributes
    ----------
    n : int
        Number of unknowns.
    order : numpy.ndarray
        Unknown i is state ``order[i]``.
    rows, columns : numpy.ndarray
        Places of the entries of the Jacobian.
    algebraic : numpy.ndarray
        The unknowns without a rate: columns of zeros in what multiplies the rates.
    carrying : slice or numpy.ndarray
        The unknowns with a rate.
    impulsive : numpy.ndarray
        The unknowns that are measured by their impulse over the step: forces without energy.
    constant : bool
        The Jacobian does not depend on the unknowns.
    mass : numpy.ndarray
        Entries of E on the pattern.
    left : float
        What the last iteration left, see :class:`~phblocks.solvers.newton.Equation`.
    missed : numpy.ndarray
        The last residual of an iteration that failed, shape (n,) or (n, stages); (0,) if none did.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.n = system.n
        self.constant = system.linear
        self.left, self.missed = 0.0, np.empty(0)
        self._equations = equations = Equations.of(system)
        tensor, scale, size_of = equations.T, equations.scale, equations.size
        lines = system.lines
        # angles of joints and of the frames of directions, one below the other
        alpha_rows = sp.csr_array(sp.vstack([system.angles.rows, lines.frames.rows]))
        chain = sp.csr_array(alpha_rows @ system.rates)  # d alpha / d (integral of z)
        still = equations.kinematics.indices[2] == 0
        moving = Triplets.join([equations.K, taken(equations.kinematics, ~still)], order=3)
        still_rows = taken(equations.kinematics, still)
        by_gravity, by_inputs = equations.K_g, equations.K_u
        pairs, pair_of = modulated_pairs(system.n_features, moving, by_gravity, by_inputs)

        constants = [m.tocoo() for m in (equations.rate_matrix, equations.J0, equations.R0)]
        codes = [entry_code(m.coords[0], m.coords[1], self.n) for m in constants]
        codes.append(entry_code(still_rows.indices[0], still_rows.indices[1], self.n))
        i, j, k = tensor.indices
        codes += [
            entry_code(i, j, self.n),
            entry_code(i, k, self.n),
            entry_code(moving.indices[0], moving.indices[1], self.n),
        ]
        # what the features of each pair depend on: (pair, state, factor) by angle, by span and by length
        by = Dependence(system, pairs[1], chain)
        codes += [entry_code(pairs[0][pair], column, self.n) for pair, column, _ in by.parts]
        codes += [
            entry_code(np.repeat(s.energy, s.energy.size), np.tile(s.energy, s.energy.size), self.n)
            for s in system.storages
        ]
        codes += [
            entry_code(m.on.repeat(to.size), np.tile(to, m.on.size), self.n)
            for m in system.modulations
            for to in (m.on, m.by)
        ]
        pattern, spots = np.unique(np.concatenate(codes), return_inverse=True)
        at = iter(np.split(spots, np.cumsum([c.size for c in codes])[:-1]))

        rows, columns = pattern // self.n, pattern % self.n
        self.order = narrow_order(rows, columns, self.n)
        new = np.empty(self.n, dtype=np.int64)
        new[self.order] = np.arange(self.n)
        # the pattern in the new order, sorted by rows: "slot" maps the old numbering of entries to the new one
        sort = np.lexsort((new[columns], new[rows]))
        slot = np.empty_like(sort)
        slot[sort] = np.arange(sort.size)
        rated = ~system.algebraic[self.order]
        self.algebraic = np.flatnonzero(~rated)
        self.carrying = np.flatnonzero(rated) if self.algebraic.size else slice(None)
        impulsive = system.algebraic & ~system.coenergy
        impulsive[equations.followers] = False
        self.impulsive, self._span = np.flatnonzero(impulsive[self.order]), 1.0
        self.rows, self.columns = new[rows][sort], new[columns][sort]
        self.scale = scale[self.order]
        weight = (size_of[rows] * scale[columns])[sort]
        size = pattern.size

        def entries(values: Floats, spot: Ints) -> Floats:
            return np.bincount(slot[spot], weights=values, minlength=size) * weight

        self.mass = entries(constants[0].data, next(at))
        self._rest = entries(constants[1].data, next(at)) - entries(constants[2].data, next(at))
        self._rest += entries(still_rows.values, next(at))
        self._mass_matrix = self._matrix(self.mass)
        cubes = tensor.values * size_of[i] * scale[j] * scale[k]
        self._skew = Triplets.of(slot[next(at)], new[k], values=cubes)  # of J(x); with its mirror it is the derivative
        mirror = Triplets.of(slot[next(at)], new[j], values=cubes)
        self._cubic = Triplets.join([self._skew, mirror]).csr((size, self.n))
        # modulated part: force_i = sum over pairs (i, f) of kappa phi_f,  kappa = K z + K_g + K_u u
        ki, kj, kf = moving.indices
        n_pairs = pairs[0].size
        self._feature = pairs[1]
        modulation = [Triplets.of(slot[next(at)], kf, values=moving.values * size_of[ki] * scale[kj])]
        for kind, (pair, column, factor) in enumerate(by.parts):
            modulation.append(
                Triplets.of(
                    slot[next(at)],
                    system.n_features + kind * n_pairs + pair,
                    values=factor * size_of[pairs[0][pair]] * scale[column],
                )
            )
        self._modulation = Triplets.join(modulation).csr((size, system.n_features + len(by.parts) * n_pairs))
        self._kappa = Triplets.of(pair_of["K"], new[kj], values=moving.values * scale[kj]).csr((n_pairs, self.n))
        self._kappa_gravity = np.bincount(pair_of["K_g"], weights=by_gravity.values, minlength=n_pairs)
        self._kappa_input = Triplets.of(pair_of["K_u"], by_inputs.indices[1], values=by_inputs.values).csr(
            (n_pairs, system.n_inputs)
        )
        self._collect = Triplets.of(new[pairs[0]], np.arange(n_pairs), values=size_of[pairs[0]]).csr((self.n, n_pairs))
        unscale = sp.diags_array(self.scale)
        self._alpha_rows, self._turn = alpha_rows, sp.csr_array(chain[:, self.order] @ unscale)
        self._alpha_reference = np.concatenate([system.angles.reference, lines.frames.reference])
        self._n_angles = system.angles.reference.size
        self._rates = sp.csr_array(system.rates[:, self.order] @ unscale)
        self._inputs = sp.csr_array(sp.diags_array(size_of[self.order]) @ equations.inputs[self.order])
        self._line_data = LineDirections.of(system, new, scale) if lines.count else None
        self._storages: StorageEquations | None = None
        if system.storages:
            self._storages = StorageEquations(system, new, scale, [slot[next(at)] for _ in system.storages])
        self._modulated: ModulatedMatrices | None = None
        if system.modulations:
            places = [(slot[next(at)], slot[next(at)]) for _ in system.modulations]
            self._modulated = ModulatedMatrices(system, new, scale, places)
        self._work = self._matrix(self.mass.copy())
        self._mass_factor = np.nan
        self._weight = self._collect @ self._kappa_gravity

    @classmethod
    def of(cls, system: System, *options: Hashable) -> Self:
        """Make an equation for a run of its own; what is constant is made once and kept with the system.

        Parameters
        ----------
        system : System
            The system to integrate.
        *options : hashable
            What else the kind of equation needs.

        Returns
        -------
        StageEquation
            Shares constant arrays with others of the system.
        """
        if system.storages or system.modulations:
            return cls(system, *options)  # these remember what they met
        first = system.prepared.get((cls, *options))
        if not isinstance(first, cls):
            first = system.prepared[cls, *options] = cls(system, *options)
        return first._another()

    def _another(self) -> Self:
        """An equation that shares what is constant."""
        self._make_all()
        other = copy.copy(self)
        other._work, other._mass_factor = self._matrix(self.mass.copy()), np.nan
        other.left, other.missed = 0.0, np.empty(0)
        return other

    def _make_all(self) -> None:
        """Make what is made when it is asked for."""
        _ = self._parts, self._modulation_parts

    def _matrix(self, data: Floats) -> sp.csr_array:
        """The matrix with these entries on the pattern."""
        indptr = np.searchsorted(self.rows, np.arange(self.n + 1))
        return sp.csr_array((data, self.columns.astype(np.int32), indptr.astype(np.int32)), shape=(self.n, self.n))

    def pack(self, x: Floats) -> Floats:
        """Change states to scaled, reordered unknowns.

        Parameters
        ----------
        x : numpy.ndarray
            Shape (..., n).

        Returns
        -------
        numpy.ndarray
            Shape (..., n).
        """
        return np.asarray(x[..., self.order] / self.scale)

    def unpack(self, unknowns: Floats) -> Floats:
        """Change scaled, reordered unknowns to states.

        Parameters
        ----------
        unknowns : numpy.ndarray
            Shape (..., n).

        Returns
        -------
        numpy.ndarray
            Shape (..., n).
        """
        x = np.empty_like(unknowns, order="F")  # so that matrices multiply many of them without a copy
        x[..., self.order] = unknowns * self.scale
        return x

    def momentum(self, unknowns: Floats) -> Floats:
        """Multiply by E.

        Parameters
        ----------
        unknowns : numpy.ndarray
            Shape (n,).

        Returns
        -------
        numpy.ndarray
            Shape (n,).
        """
        return np.asarray(self._mass_matrix @ unknowns)

    def spins(self, unknowns: Floats, u: Floats) -> Floats:
        """Evaluate the rates of the rotation states in many states.

        Parameters
        ----------
        unknowns : numpy.ndarray
            Shape (..., n).
        u : numpy.ndarray
            Inputs, shape (..., n_inputs).

        Returns
        -------
        numpy.ndarray
            theta', shape (..., n_theta), rad/s.
        """
        many, turning = math.prod(u.shape[:-1]), self._rates.shape[0]
        spins = np.zeros((turning, many))
        if turning:
            spins = self._rates @ unknowns.reshape(many, self.n).T
            spins += self.system.input_rates @ u.reshape(many, u.shape[-1]).T
        return np.asarray(spins.T.reshape(*u.shape[:-1], turning))

    def spin(self, unknowns: Floats, u: Floats) -> Floats:
        """Evaluate the rates of the rotation states.

        Parameters
        ----------
        unknowns : numpy.ndarray
            Shape (n,).
        u : numpy.ndarray
            Inputs, shape (n_inputs,).

        Returns
        -------
        numpy.ndarray
            theta', shape (n_theta,), rad/s.
        """
        if not self._rates.shape[0]:
            return _NONE
        spin = self._rates @ unknowns
        return np.asarray(spin + self.system.input_rates @ u if self.system.input_rates.nnz else spin)

    def settle(self, unknowns: Floats) -> None:
        """Set co-energy variables to the gradients of energies that are not quadratic.

        Parameters
        ----------
        unknowns : numpy.ndarray
            Shape (n,), changed in place.
        """
        if self._storages is not None:
            self._storages.settle(unknowns)

    def begin(
        self, mass_factor: float, tau: float, theta: Floats, u: Floats, b: Floats, before: Floats | None = None
    ) -> None:
        """Fix the data of a stage.

        Parameters
        ----------
        mass_factor : float
            Of E, 1/s.
        tau : float
            Weight of the stage's own spin in its orientation, s.
        theta : numpy.ndarray
            Orientation without that, shape (n_theta,), rad.
        u : numpy.ndarray
            Inputs, shape (n_inputs,).
        b : numpy.ndarray
            Known part, shape (n,), in scaled, reordered unknowns.
        before : numpy.ndarray, optional
            Unknowns at the start of the step, shape (n,): energies that are not quadratic act by their discrete
            gradients from there to the mirror image in the stage, not by the gradients at the stage.
        """
        self._before = before
        if self._modulated is not None:
            self._modulated.undefined = ""
        self._tau, self._span = tau, 2.0 * tau
        if mass_factor != self._mass_factor:
            self._mass_factor = mass_factor
            self._linear = mass_factor * self.mass - self._rest
        self._known, self._kappa_known = b, self._kappa_gravity
        if u.size:
            self._known = b + self._inputs @ u
            self._kappa_known = self._kappa_gravity + self._kappa_input @ u
        if self.constant:
            self._known = self._known + (self._collect @ self._kappa_known if u.size else self._weight)
            self._alpha = self._alpha_reference  # modulates nothing
            return
        theta = theta + tau * (self.system.input_rates @ u)
        self._alpha = self._alpha_reference + self._alpha_rows @ theta

    def loads(self, u: Floats) -> Floats:
        """Evaluate weight and inputs of a linear system.

        Parameters
        ----------
        u : numpy.ndarray
            Inputs, shape (..., n_inputs).

        Returns
        -------
        numpy.ndarray
            Of ``E x'``, shape (..., n).
        """
        flat = u.reshape(math.prod(u.shape[:-1]), u.shape[-1])
        loads = np.tile(self._weight, (len(flat), 1))
        if flat.size and (flat == flat[0]).all():
            loads += self._by_inputs @ flat[0]
        elif flat.size:
            loads += (self._by_inputs @ flat.T).T
        return loads.reshape(*u.shape[:-1], self.n)

    def matrix(self, mass_factor: float | complex) -> Floats:
        """Evaluate the Jacobian of a linear system.

        Parameters
        ----------
        mass_factor : float or complex
            Of E, 1/s.

        Returns
        -------
        numpy.ndarray
            Its entries on the pattern.
        """
        return np.asarray(mass_factor * self.mass - self._rest)

    @cached_property
    def _by_inputs(self) -> sp.csr_array:
        """Of a linear system: forces by inputs, directly and along directions that stay."""
        return sp.csr_array(self._inputs + self._collect @ self._kappa_input)

    @cached_property
    def free(self) -> sp.csr_array:
        """What multiplies the unknowns in ``E x'`` at any orientation; in a linear system, all that does."""
        matrix = self._matrix(self._rest.copy())
        matrix.eliminate_zeros()
        return matrix

    def evaluate(self, z: Floats) -> tuple[Floats, Floats]:
        """Evaluate residual and Jacobian.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns, shape (n,).

        Returns
        -------
        residual : numpy.ndarray
            Shape (n,).
        jacobian : numpy.ndarray
            Its entries on the pattern (``rows``, ``columns``).
        """
        work = self._work
        if self.constant:
            work.data = self._linear
            return np.asarray(work @ z - self._known), self._linear
        features, slopes, by_line = self._features(z, self._alpha + self._tau * (self._turn @ z))
        kappa = self._kappa @ z + self._kappa_known
        products = self._cubic @ z
        work.data = self._linear - 0.5 * products
        residual = work @ z - self._collect @ (kappa * features[self._feature]) - self._known
        parts = [features, self._tau * kappa * slopes[self._feature]]
        parts += [kappa * derivative[self._feature] for derivative in by_line]
        jacobian = self._linear - products - self._modulation @ np.concatenate(parts)
        if self._storages is not None:
            self._storages.add(z, self._before, residual, jacobian)
        if self._modulated is not None:
            self._modulated.add(z, residual, jacobian)
        return residual, jacobian

    @property
    def why(self) -> str:
        """Why an iteration since ``begin`` failed, if it did."""
        found = "" if self._modulated is None else self._modulated.undefined
        return found or "Newton's method did not converge"

    @property
    def worst_state(self) -> str | None:
        """Name of the state whose equation the last iteration that failed missed by most, in units of its energy."""
        if not self.missed.size:
            return None
        with np.errstate(all="ignore"):
            size = np.square(self.missed).reshape(self.n, -1).sum(axis=1)
        return str(self.system.state_names[self.order[int(np.argmax(size))]])

    def residual(self, z: Floats) -> Floats:
        """Evaluate the residual only.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns, shape (n,).

        Returns
        -------
        numpy.ndarray
            Shape (n,).
        """
        if self.constant or self._storages is not None or self._modulated is not None:
            return self.evaluate(z)[0]
        turned, kappa, momentum, forced = self._parts.linear(z)
        features = self._features(z, self._alpha + self._tau * turned)[0]
        force = forced + self._parts.summed(z, (kappa + self._kappa_known) * features[self._feature])
        return np.asarray(self._mass_factor * momentum - force - self._known)

    @cached_property
    def _parts(self) -> ResidualParts:
        linear = (self._turn, self._kappa, self._mass_matrix, self.free)
        return ResidualParts.of(self._equations, self.order, self.scale, linear, self._collect)

    def _features(self, z: Floats, alpha: Floats) -> tuple[Floats, Floats, tuple[Floats, ...]]:
        """Features, their slopes in the angle, and their derivatives by what lines depend on; for columns alike."""
        cos, sin = np.cos(alpha), np.sin(alpha)
        turning = slice(0, self._n_angles)
        one = _ONE if alpha.ndim == 1 else np.ones((1, alpha.shape[1]))
        phi = [one, cos[turning], sin[turning]]
        slope = [0.0 * one, -sin[turning], cos[turning]]
        by_line: tuple[Floats, ...] = ()
        if self._line_data is not None:
            direction, turned, by_line = self._line_data.evaluate(z, cos[self._n_angles :], sin[self._n_angles :])
            phi.append(direction)
            slope.append(turned)
        return np.concatenate(phi), np.concatenate(slope), by_line

    @cached_property
    def _modulation_parts(self) -> tuple[sp.csr_array, sp.csr_array, sp.csr_array]:
        """What multiplies the features, their turning, and what lines depend on, apart."""
        n_features, n_pairs = self.system.n_features, self._feature.size
        by_columns = self._modulation.tocsc()
        ends = (0, n_features, n_features + n_pairs, by_columns.shape[1])
        first, turning, lines = (sp.csr_array(by_columns[:, a:b]) for a, b in pairwise(ends))
        return first, turning, lines

    def apply(self, entries: Floats, z: Floats) -> Floats:
        """Multiply by a matrix on the pattern.

        Parameters
        ----------
        entries : numpy.ndarray
            Of the matrix.
        z : numpy.ndarray
            Shape (n,).

        Returns
        -------
        numpy.ndarray
            Shape (n,).
        """
        self._work.data = entries
        return np.asarray(self._work @ z)

    def measure(self, z: Floats) -> float:
        """Measure unknowns, or an update of them, in one unit: the root of an energy.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns, shape (n,) or (n, stages).

        Returns
        -------
        float
            Euclidean norm; forces of constraint count by their impulse over the step that has begun.
        """
        if self.impulsive.size:
            z = z.copy()
            z[self.impulsive] *= self._span
        return float(np.linalg.norm(z))

    def round_off(self, z: Floats) -> float:
        """Estimate the round-off in the residual at the last evaluation.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns, shape (n,).

        Returns
        -------
        float
            Of its Euclidean norm.
        """
        parts, size = abs(self._parts), np.abs(z)
        _, kappa, momentum, forced = parts.linear(size)
        forced = forced + parts.summed(size, kappa + np.abs(self._kappa_known)) + np.abs(self._known)
        noise = float(np.finfo(float).eps * np.linalg.norm(abs(self._mass_factor) * momentum + forced))
        noise += 0.0 if self._storages is None else float(np.linalg.norm(self._storages.noise))
        return noise + (0.0 if self._modulated is None else float(np.linalg.norm(self._modulated.noise)))
