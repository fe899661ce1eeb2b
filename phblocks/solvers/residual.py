"""The products of a residual without its Jacobian, gathered into two sparse ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from phblocks.solvers.equations import Equations
from phblocks.triplets import Floats, Ints, Triplets


@dataclass(frozen=True)
class ResidualParts:
    """All that is linear in the unknowns in one product, and all that is summed into the force in another.

    The quadratic part ``T z z`` sums products of pairs of unknowns, each pair once: no entries of a matrix are made.

    Parameters
    ----------
    stacked : scipy.sparse.csr_array
        The matrices that are linear in z, one below the other.
    ends : tuple of int
        Rows at which the next one begins.
    pairs : numpy.ndarray
        Shape (2, n_pairs): the unknowns that are multiplied.
    forces : scipy.sparse.csr_array
        What sums products of pairs and modulated quantities, shape (n, n_pairs + n_modulated).
    """

    stacked: sp.csr_array
    ends: tuple[int, ...]
    pairs: Ints
    forces: sp.csr_array

    @classmethod
    def of(
        cls, equations: Equations, order: Ints, scale: Floats, linear: Sequence[sp.csr_array], collect: sp.csr_array
    ) -> ResidualParts:
        """Gather them.

        Parameters
        ----------
        equations : Equations
            For T.
        order, scale : numpy.ndarray
            State and scale of each unknown.
        linear : sequence of scipy.sparse.csr_array
            The matrices that are linear in z.
        collect : scipy.sparse.csr_array
            What sums modulated quantities.

        Returns
        -------
        ResidualParts
            Without explicit zeros.
        """
        n, new, size = order.size, np.argsort(order), equations.size[order]
        tensor = equations.T
        i, j, k = (new[index] for index in tensor.indices)
        pairs, pair = np.unique(np.minimum(j, k) * n + np.maximum(j, k), return_inverse=True)
        products = Triplets.of(i, pair, values=tensor.values * size[i] * scale[j] * scale[k])
        stacked = sp.csr_array(sp.vstack(linear))
        stacked.eliminate_zeros()
        ends = np.cumsum([matrix.shape[0] for matrix in linear])[:-1]
        return cls(
            stacked,
            tuple(map(int, ends)),
            np.stack([pairs // n, pairs % n]),
            sp.csr_array(sp.hstack([products.csr((n, pairs.size)), collect])),
        )

    def __abs__(self) -> ResidualParts:
        """Take the entries without their signs, for estimates of round-off."""
        return ResidualParts(abs(self.stacked), self.ends, self.pairs, abs(self.forces))

    def linear(self, z: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Multiply by the four matrices.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns, shape (n,) or (n, stages).

        Returns
        -------
        tuple of numpy.ndarray
            The products.
        """
        (a, b, c), product = self.ends, self.stacked @ z
        return product[:a], product[a:b], product[b:c], product[c:]

    def summed(self, z: Floats, modulated: Floats) -> Floats:
        """Sum products of pairs and modulated quantities.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns, shape (n,) or (n, stages).
        modulated : numpy.ndarray
            Shape (n_modulated,) or (n_modulated, stages).

        Returns
        -------
        numpy.ndarray
            Forces, of the shape of z.
        """
        factors = z.take(self.pairs, axis=0)
        return np.asarray(self.forces @ np.concatenate([factors[0] * factors[1], modulated]))
