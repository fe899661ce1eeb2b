"""The nonlinear equation of one implicit stage, prepared for speed.

Unknown is z, the energy states at the stage. With the stage's orientation ``theta = theta0 + tau (rates z)`` it
must satisfy

    residual(z) = mass_factor E z - (J(z, theta) - R) z - gravity(theta) - G(theta) u - b = 0.

Everything is done in *scaled, reordered* unknowns: ``z = scale * zhat[order]`` with ``scale = diag(E)^(-1/2)``, so
that ``|zhat|^2`` is about twice the energy whatever the units, and an order of small bandwidth. All products with
the state are sparse matrix products over the whole system: no loop over elements, joints or quadrature points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from phblocks.solvers.modulations import ModulatedMatrices
from phblocks.solvers.ordering import narrow_order
from phblocks.solvers.storages import StorageEquations
from phblocks.system import System
from phblocks.system.scaling import state_scale
from phblocks.triplets import Floats, Ints, Triplets

_ONE, _ZERO = np.ones(1), np.zeros(1)


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
    constant : bool
        The Jacobian does not depend on the unknowns.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.n = system.n
        self.constant = system.linear
        scale = state_scale(system)
        tensor = Triplets.from_coo(system.T)
        lines = system.lines
        # angles of joints and of the frames of directions, one below the other
        alpha_rows = sp.csr_array(sp.vstack([system.angles.rows, lines.frames.rows]))
        chain = sp.csr_array(alpha_rows @ system.rates)  # d alpha / d (integral of z)
        still = system.kinematics.indices[2] == 0
        moving = Triplets.join([system.K, _taken(system.kinematics, ~still)], order=3)
        still_rows = _taken(system.kinematics, still)
        pairs, pair_of = _pairs(system, moving)

        constants = [m.tocoo() for m in (system.rate_matrix, system.J0, system.R0)]
        codes = [_code(m.coords[0], m.coords[1], self.n) for m in constants]
        codes.append(_code(still_rows.indices[0], still_rows.indices[1], self.n))
        i, j, k = tensor.indices
        codes += [_code(i, j, self.n), _code(i, k, self.n), _code(moving.indices[0], moving.indices[1], self.n)]
        # what the features of each pair depend on: (pair, state, factor) by angle, by span and by length
        by = _Dependence(system, pairs[1], chain)
        codes += [_code(pairs[0][pair], column, self.n) for pair, column, _ in by.parts]
        codes += [
            _code(np.repeat(s.energy, s.energy.size), np.tile(s.energy, s.energy.size), self.n) for s in system.storages
        ]
        codes += [
            _code(m.on.repeat(to.size), np.tile(to, m.on.size), self.n)
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
        self.rows, self.columns = new[rows][sort], new[columns][sort]
        self.scale = scale[self.order]
        weight = (scale[rows] * scale[columns])[sort]
        size = pattern.size

        def entries(values: Floats, spot: Ints) -> Floats:
            return np.bincount(slot[spot], weights=values, minlength=size) * weight

        self._mass = entries(constants[0].data, next(at))
        self._rest = entries(constants[1].data, next(at)) - entries(constants[2].data, next(at))
        self._rest += entries(still_rows.values, next(at))
        self._mass_matrix = self._matrix(self._mass)
        self._cubic = Triplets.join(
            [
                Triplets.of(slot[next(at)], new[k], values=tensor.values * scale[i] * scale[j] * scale[k]),
                Triplets.of(slot[next(at)], new[j], values=tensor.values * scale[i] * scale[k] * scale[j]),
            ]
        ).csr((size, self.n))
        # modulated part: force_i = sum over pairs (i, f) of kappa phi_f,  kappa = K z + K_g + K_u u
        ki, kj, kf = moving.indices
        n_pairs = pairs[0].size
        self._feature = pairs[1]
        modulation = [Triplets.of(slot[next(at)], kf, values=moving.values * scale[ki] * scale[kj])]
        for kind, (pair, column, factor) in enumerate(by.parts):
            modulation.append(
                Triplets.of(
                    slot[next(at)],
                    system.n_features + kind * n_pairs + pair,
                    values=factor * scale[pairs[0][pair]] * scale[column],
                )
            )
        self._modulation = Triplets.join(modulation).csr((size, system.n_features + len(by.parts) * n_pairs))
        self._kappa = Triplets.of(pair_of["K"], new[kj], values=moving.values * scale[kj]).csr((n_pairs, self.n))
        self._kappa_gravity = np.bincount(pair_of["K_g"], weights=system.K_g.values, minlength=n_pairs)
        self._kappa_input = Triplets.of(pair_of["K_u"], system.K_u.indices[1], values=system.K_u.values).csr(
            (n_pairs, system.n_inputs)
        )
        self._collect = Triplets.of(new[pairs[0]], np.arange(n_pairs), values=scale[pairs[0]]).csr((self.n, n_pairs))
        unscale = sp.diags_array(self.scale)
        self._alpha_rows, self._turn = alpha_rows, sp.csr_array(chain[:, self.order] @ unscale)
        self._alpha_reference = np.concatenate([system.angles.reference, lines.frames.reference])
        self._n_angles = system.angles.reference.size
        self._rates = sp.csr_array(system.rates[:, self.order] @ unscale)
        self._inputs = sp.csr_array(sp.diags_array(self.scale) @ (system.G0 + system.kinematics_u)[self.order])
        self._line_data = _LineData.of(system, new, scale) if lines.count else None
        self._storages: StorageEquations | None = None
        if system.storages:
            self._storages = StorageEquations(system, new, scale, [slot[next(at)] for _ in system.storages])
        self._modulated: ModulatedMatrices | None = None
        if system.modulations:
            places = [(slot[next(at)], slot[next(at)]) for _ in system.modulations]
            self._modulated = ModulatedMatrices(system, new, scale, places)
        self._work = self._matrix(self._mass.copy())

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
        x = np.empty_like(unknowns)
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
        return np.asarray(self._rates @ unknowns + self.system.input_rates @ u)

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
        self._tau = tau
        self._linear = mass_factor * self._mass - self._rest
        theta = theta + tau * (self.system.input_rates @ u)
        self._alpha = self._alpha_reference + self._alpha_rows @ theta
        self._kappa_known = self._kappa_gravity + self._kappa_input @ u
        self._known = b + self._inputs @ u
        if self.constant:
            self._known = self._known + self._collect @ self._kappa_known

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
        alpha = self._alpha + self._tau * (self._turn @ z)
        cos, sin = np.cos(alpha), np.sin(alpha)
        joints = slice(0, self._n_angles)
        phi = [_ONE, cos[joints], sin[joints]]
        slope = [_ZERO, -sin[joints], cos[joints]]
        by_line: tuple[Floats, ...] = ()
        if self._line_data is not None:
            direction, turned, by_line = self._line_data.evaluate(z, cos[self._n_angles :], sin[self._n_angles :])
            phi.append(direction)
            slope.append(turned)
        features, slopes = np.concatenate(phi), np.concatenate(slope)
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
        size = self._matrix(np.abs(self._work.data)) @ np.abs(z) + np.abs(self._known)
        noise = float(np.finfo(float).eps * np.linalg.norm(size))
        noise += 0.0 if self._storages is None else float(np.linalg.norm(self._storages.noise))
        return noise + (0.0 if self._modulated is None else float(np.linalg.norm(self._modulated.noise)))


def _code(rows: Ints, columns: Ints, n: int) -> Ints:
    return np.asarray(rows, dtype=np.int64) * n + np.asarray(columns, dtype=np.int64)


def _taken(entries: Triplets, keep: NDArray[np.bool_]) -> Triplets:
    return Triplets(tuple(i[keep] for i in entries.indices), entries.values[keep])


def _pairs(system: System, moving: Triplets) -> tuple[tuple[Ints, Ints], dict[str, Ints]]:
    """All (state, feature) pairs through which the configuration acts, and where K, K_g and K_u stand in them."""
    parts = {
        "K": (moving.indices[0], moving.indices[2]),
        "K_g": (system.K_g.indices[0], system.K_g.indices[1]),
        "K_u": (system.K_u.indices[0], system.K_u.indices[2]),
    }
    codes = [_code(i, f, system.n_features) for i, f in parts.values()]
    pairs, spots = np.unique(np.concatenate(codes), return_inverse=True)
    ends = np.cumsum([c.size for c in codes])[:-1]
    return (pairs // system.n_features, pairs % system.n_features), dict(zip(parts, np.split(spots, ends), strict=True))


class _Dependence:
    """The states that the feature of each pair depends on: lists of (pair, state, factor) by angle, span, length."""

    def __init__(self, system: System, feature: Ints, chain: sp.csr_array) -> None:
        n_angles, lines = system.angles.reference.size, system.lines
        turning = np.flatnonzero(feature > 0)  # feature 0 is the constant
        number = feature[turning] - 1
        along = number - 2 * n_angles  # directions come last
        angle = np.where(along < 0, number % max(1, n_angles), n_angles + along % max(1, lines.count))
        place, column, value = _expand(chain, angle)
        self.parts = [(turning[place], column, value)]
        if not lines.count:
            return
        on_line = turning[along >= 0]
        line = lines.line[along[along >= 0] % lines.count]
        self.parts += [(on_line, lines.spans[line, a], np.ones(line.size)) for a in range(2)]
        place, column, value = _expand(lines.stretch, line)
        self.parts.append((on_line[place], column, value))


@dataclass(frozen=True)
class _LineData:
    """Directions of lines and their derivatives, in scaled, reordered unknowns, one entry for each direction."""

    span: sp.csr_array
    free: Floats
    stretch: sp.csr_array
    taut: NDArray[np.bool_]
    before: Floats

    @classmethod
    def of(cls, system: System, new: Ints, scale: Floats) -> _LineData:
        lines = system.lines
        d, states = np.arange(lines.count), lines.spans[lines.line]
        rows = [Triplets.of(a * lines.count + d, new[states[:, a]], values=scale[states[:, a]]) for a in range(2)]
        place, column, value = _expand(lines.stretch, lines.line)
        return cls(
            Triplets.join(rows).csr((2 * lines.count, system.n)),
            lines.free[lines.line],
            Triplets.of(place, new[column], values=value * scale[column]).csr((lines.count, system.n)),
            lines.taut[lines.line],
            np.zeros(1 + 2 * system.angles.reference.size),
        )

    def evaluate(self, z: Floats, cos: Floats, sin: Floats) -> tuple[Floats, Floats, tuple[Floats, ...]]:
        """Features, their slopes in the angle, and over all features their derivatives by span and length."""
        x, y = (self.span @ z).reshape(2, -1)
        length = np.where(self.taut, self.free + self.stretch @ z, np.hypot(x, y))
        first, second = (cos * x + sin * y) / length, (cos * y - sin * x) / length
        direction, loose = np.concatenate((first, second)), ~self.taut
        by_x = np.concatenate((cos - loose * first * x / length, -sin - loose * second * x / length))
        by_y = np.concatenate((sin - loose * first * y / length, cos - loose * second * y / length))
        twice = np.concatenate((length, length))
        derivatives = tuple(np.concatenate((self.before, d / twice)) for d in (by_x, by_y, -direction))
        return direction, np.concatenate((second, -first)), derivatives


def _expand(matrix: sp.csr_array, rows: Ints) -> tuple[Ints, Ints, Floats]:
    """Entries of the given rows of a matrix: (place in ``rows``, column, value)."""
    if not rows.size or not matrix.nnz:
        none = np.empty(0, dtype=np.int64)
        return none, none, np.empty(0)
    count = np.diff(matrix.indptr)[rows]
    place = np.repeat(np.arange(rows.size), count)
    within = np.arange(place.size) - np.repeat(np.cumsum(count) - count, count)
    spot = matrix.indptr[rows][place] + within
    return place, matrix.indices[spot].astype(np.int64), matrix.data[spot]
