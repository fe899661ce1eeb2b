"""The nonlinear equation of one implicit stage, prepared for speed.

Unknown is z, the energy states at the stage. With the stage's orientation ``theta = theta0 + tau (rates z)`` it
must satisfy

    residual(z) = mass_factor E z - (J(z, theta) - R) z - gravity(theta) - G(theta) u - b = 0.

Everything is done in *scaled, reordered* unknowns: ``z = scale * zhat[order]`` with ``scale = diag(E)^(-1/2)``, so
that ``|zhat|^2`` is about twice the energy whatever the units, and an order of small bandwidth. All products with
the state are sparse matrix products over the whole system: no loop over elements, joints or quadrature points.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from phblocks.solvers.ordering import narrow_order
from phblocks.system import System
from phblocks.system.scaling import state_scale
from phblocks.triplets import Floats, Ints, Triplets


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
        The unknowns without energy: rows of zeros in E.
    carrying : slice or numpy.ndarray
        The unknowns with energy.
    constant : bool
        The Jacobian does not depend on the unknowns.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.n = system.n
        self.constant = system.linear
        scale = state_scale(system)
        tensor = Triplets.from_coo(system.T)
        chain = sp.csr_array(system.angles.rows @ system.rates)  # d alpha / d (integral of z)
        pairs, pair_of = _pairs(system)

        constants = [m.tocoo() for m in (system.E, system.J0, system.R)]
        codes = [_code(m.coords[0], m.coords[1], self.n) for m in constants]
        i, j, k = tensor.indices
        codes += [_code(i, j, self.n), _code(i, k, self.n), _code(system.K.indices[0], system.K.indices[1], self.n)]
        turning = np.flatnonzero(pairs[1] > 0)  # feature 0 is the constant
        angle = (pairs[1][turning] - 1) % max(1, system.angles.reference.size)
        place, column, value = _expand(chain, angle)
        turned = turning[place], column, value
        codes.append(_code(pairs[0][turned[0]], turned[1], self.n))
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
        self.algebraic = np.flatnonzero(~system.carries_energy[self.order])
        self.carrying = np.flatnonzero(system.carries_energy[self.order]) if self.algebraic.size else slice(None)
        self.rows, self.columns = new[rows][sort], new[columns][sort]
        self.scale = scale[self.order]
        weight = (scale[rows] * scale[columns])[sort]
        size = pattern.size

        def entries(values: Floats, spot: Ints) -> Floats:
            return np.bincount(slot[spot], weights=values, minlength=size) * weight

        self._mass = entries(system.E.tocoo().data, next(at))
        self._rest = entries(system.J0.tocoo().data, next(at)) - entries(system.R.tocoo().data, next(at))
        self._mass_matrix = self._matrix(self._mass)
        unscale = scale[k], scale[j]
        self._cubic = Triplets.join(
            [
                Triplets.of(slot[next(at)], new[k], values=tensor.values * scale[i] * scale[j] * unscale[0]),
                Triplets.of(slot[next(at)], new[j], values=tensor.values * scale[i] * scale[k] * unscale[1]),
            ]
        ).csr((size, self.n))
        # modulated part: force_i = sum over pairs (i, f) of kappa phi_f,  kappa = K z + K_g + K_u u
        ki, kj, kf = system.K.indices
        n_pairs = pairs[0].size
        self._feature = pairs[1]
        modulation = [Triplets.of(slot[next(at)], kf, values=system.K.values * scale[ki] * scale[kj])]
        spot, (pair, _, value) = next(at), turned
        modulation.append(
            Triplets.of(
                slot[spot],
                system.n_features + pair,
                values=value * scale[pairs[0][pair]] * scale[turned[1]],
            )
        )
        self._modulation = Triplets.join(modulation).csr((size, system.n_features + n_pairs))
        row_scale = scale[pairs[0]]
        self._kappa = Triplets.of(pair_of["K"], new[kj], values=system.K.values * scale[kj]).csr((n_pairs, self.n))
        self._kappa_gravity = np.bincount(pair_of["K_g"], weights=system.K_g.values, minlength=n_pairs)
        self._kappa_input = Triplets.of(pair_of["K_u"], system.K_u.indices[1], values=system.K_u.values).csr(
            (n_pairs, system.n_inputs)
        )
        self._collect = Triplets.of(new[pairs[0]], np.arange(n_pairs), values=row_scale).csr((self.n, n_pairs))
        self._turn = sp.csr_array(chain[:, self.order] @ sp.diags_array(self.scale))
        self._rates = sp.csr_array(system.rates[:, self.order] @ sp.diags_array(self.scale))
        self._inputs = sp.csr_array(sp.diags_array(self.scale) @ system.G0[self.order])
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

    def begin(self, mass_factor: float, tau: float, theta: Floats, u: Floats, b: Floats) -> None:
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
        """
        self._tau = tau
        self._linear = mass_factor * self._mass - self._rest
        self._alpha = self.system.angles.at(theta + tau * (self.system.input_rates @ u))
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
        one, zero = np.ones(1), np.zeros(1)
        phi, slope = np.concatenate((one, cos, sin)), np.concatenate((zero, -sin, cos))
        kappa = self._kappa @ z + self._kappa_known
        products = self._cubic @ z
        work.data = self._linear - 0.5 * products
        residual = work @ z - self._collect @ (kappa * phi[self._feature]) - self._known
        modulation = np.concatenate((phi, self._tau * kappa * slope[self._feature]))
        return residual, self._linear - products - self._modulation @ modulation

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
        return float(np.finfo(float).eps * np.linalg.norm(size))


def _code(rows: Ints, columns: Ints, n: int) -> Ints:
    return np.asarray(rows, dtype=np.int64) * n + np.asarray(columns, dtype=np.int64)


def _pairs(system: System) -> tuple[tuple[Ints, Ints], dict[str, Ints]]:
    """All (state, feature) pairs through which the configuration acts, and where K, K_g and K_u stand in them."""
    parts = {
        "K": (system.K.indices[0], system.K.indices[2]),
        "K_g": (system.K_g.indices[0], system.K_g.indices[1]),
        "K_u": (system.K_u.indices[0], system.K_u.indices[2]),
    }
    codes = [_code(i, f, system.n_features) for i, f in parts.values()]
    pairs, spots = np.unique(np.concatenate(codes), return_inverse=True)
    ends = np.cumsum([c.size for c in codes])[:-1]
    return (pairs // system.n_features, pairs % system.n_features), dict(zip(parts, np.split(spots, ends), strict=True))


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
