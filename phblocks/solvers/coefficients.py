"""Coefficients of collocation methods."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from phblocks.triplets import Floats


@dataclass(frozen=True, eq=False)
class Collocation:
    """Coefficients of a collocation method; those of a kind and number of stages are one object.

    Parameters
    ----------
    c, b : numpy.ndarray
        Nodes and weights, shape (stages,), as fractions of a step.
    A : numpy.ndarray
        Shape (stages, stages).
    """

    c: Floats
    b: Floats
    A: Floats

    @classmethod
    @cache
    def gauss(cls, stages: int) -> Collocation:
        """Compute the coefficients of Gauss-Legendre collocation.

        Parameters
        ----------
        stages : int
            Their number.

        Returns
        -------
        Collocation
            Of order ``2 stages``; quadratic energies are kept.
        """
        nodes, weights = np.polynomial.legendre.leggauss(stages)
        return cls._at(0.5 * (nodes + 1.0), 0.5 * weights)

    @classmethod
    @cache
    def radau(cls, stages: int) -> Collocation:
        """Compute the coefficients of Radau IIA, whose last stage is the end of the step.

        Parameters
        ----------
        stages : int
            Their number.

        Returns
        -------
        Collocation
            Of order ``2 stages - 1``; quadratic energies fall.
        """
        # the roots of the difference of two Legendre polynomials, of which 1 is one
        roots = np.polynomial.legendre.legroots([0.0] * (stages - 1) + [-1.0, 1.0])
        c, power = np.append(0.5 * (np.sort(roots)[:-1] + 1.0), 1.0), np.arange(stages)
        b = np.linalg.solve((c[:, None] ** power).T, 1.0 / (power + 1))
        return cls._at(c, np.asarray(b, dtype=np.float64))

    @classmethod
    def _at(cls, c: Floats, b: Floats) -> Collocation:
        power = np.arange(c.size)
        integrals = c[:, None] ** (power + 1) / (power + 1)
        return cls(c, b, np.asarray(np.linalg.solve((c[:, None] ** power).T, integrals.T).T, dtype=np.float64))

    @property
    def inverse(self) -> Floats:
        """Inverse of A."""
        return np.asarray(np.linalg.inv(self.A))

    @property
    def end(self) -> Floats:
        """Weights d in ``x_{n+1} = x_n + sum_i d_i (z_i - x_n)``."""
        if self.c[-1] == 1.0:
            return np.asarray(np.eye(self.c.size)[-1])
        return np.asarray(self.b @ self.inverse)

    @property
    def extrapolation(self) -> Floats:
        """Weights that continue the polynomial through the stages to the end of the step."""
        if self.c[-1] == 1.0:
            return np.asarray(np.eye(self.c.size)[-1])
        return np.asarray(np.linalg.solve((self.c[:, None] ** np.arange(self.c.size)).T, np.ones(self.c.size)))

    @cached_property
    def loss(self) -> Floats | None:
        """Weights l: a step loses the energy of ``sum_i l_i (z_i - x_n)``, beside what R takes; ``None`` if nothing.

        With the polynomial u of degree s through x_n and the stages, ``H(x_{n+1}) - H(x_n)`` is the integral of
        ``u'^T E u``, of degree 2 s - 1, and the weights b integrate all of it but the leading coefficient. What is
        left over is a multiple of the energy of the leading coefficient of u.
        """
        s = self.c.size
        share = 2.0 * s * float(self.b @ self.c ** (2 * s - 1)) - 1.0
        if abs(share) < 1e-12:
            return None
        nodes = np.append(self.c, 0.0)
        apart = nodes[:s, None] - nodes
        apart[np.arange(s), np.arange(s)] = 1.0
        return np.asarray(np.sqrt(share) / apart.prod(axis=1))
