"""The two polynomial spaces of a mixed pair on the reference element [0, 1].

``CG_k`` (continuous, degree k, Lagrange polynomials on Gauss-Lobatto points) and ``DG_{k-1}`` (discontinuous,
degree k-1, Lagrange polynomials on Gauss points): the derivative maps the first exactly onto the second.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre

from phblocks.triplets import Floats


@cache
def gauss(n: int) -> tuple[Floats, Floats]:
    """Gauss-Legendre quadrature on [0, 1], exact for degree 2n - 1.

    Parameters
    ----------
    n : int
        Number of points.

    Returns
    -------
    points, weights : numpy.ndarray
        Shape (n,).
    """
    points, weights = legendre.leggauss(n)
    return (points + 1.0) / 2.0, weights / 2.0


@dataclass(frozen=True)
class Basis:
    """Lagrange polynomials on given nodes.

    Parameters
    ----------
    nodes : tuple of float
        In [0, 1].
    """

    nodes: tuple[float, ...]

    @property
    def size(self) -> int:
        """Number of functions."""
        return len(self.nodes)

    def _coefficients(self) -> Floats:
        """Legendre coefficients of each function, one column each."""
        inverse = np.linalg.inv(legendre.legvander(2.0 * np.array(self.nodes) - 1.0, self.size - 1))
        return np.asarray(inverse, dtype=np.float64)

    def at(self, points: Floats) -> Floats:
        """Evaluate all functions.

        Parameters
        ----------
        points : numpy.ndarray
            Shape (m,), in [0, 1].

        Returns
        -------
        numpy.ndarray
            Shape (m, size).
        """
        values = legendre.legvander(2.0 * np.asarray(points) - 1.0, self.size - 1) @ self._coefficients()
        return np.asarray(values, dtype=np.float64)

    def derivative(self, points: Floats) -> Floats:
        """Evaluate the derivatives of all functions with respect to the coordinate in [0, 1].

        Parameters
        ----------
        points : numpy.ndarray
            Shape (m,), in [0, 1].

        Returns
        -------
        numpy.ndarray
            Shape (m, size).
        """
        coefficients = legendre.legder(self._coefficients(), axis=0)
        return np.asarray(2.0 * legendre.legval(2.0 * np.asarray(points) - 1.0, coefficients).T, dtype=np.float64)


@cache
def continuous(degree: int) -> Basis:
    """Return the basis of CG_k: Lagrange polynomials on the Gauss-Lobatto points, both ends included.

    Parameters
    ----------
    degree : int
        k >= 1.

    Returns
    -------
    Basis
        With k + 1 functions.
    """
    inner = legendre.legroots(legendre.legder(np.eye(degree + 1)[degree])) if degree > 1 else np.empty(0)
    return Basis((0.0, *((np.sort(inner) + 1.0) / 2.0).tolist(), 1.0))


@cache
def discontinuous(degree: int) -> Basis:
    """Return the basis of DG_{k-1}: Lagrange polynomials on the k Gauss points.

    Parameters
    ----------
    degree : int
        k >= 1, the degree of the pair.

    Returns
    -------
    Basis
        With k functions.
    """
    return Basis(tuple(gauss(degree)[0].tolist()))
