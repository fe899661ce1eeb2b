"""The angles that modulate a system, and their features."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from phblocks.triplets import Floats


@dataclass(frozen=True)
class Angles:
    """The angles that modulate the system: ``alpha = reference + rows @ theta``.

    Parameters
    ----------
    rows : scipy.sparse.csr_array
        P, shape (n_angles, n_theta).
    reference : numpy.ndarray
        alpha0, shape (n_angles,), rad.
    """

    rows: sp.csr_array
    reference: Floats

    def at(self, theta: Floats) -> Floats:
        """Evaluate the angles.

        Parameters
        ----------
        theta : numpy.ndarray
            Rotation states, shape (n_theta,) or (n_theta, m).

        Returns
        -------
        numpy.ndarray
            Shape (n_angles,) or (n_angles, m), rad.
        """
        reference = self.reference if theta.ndim == 1 else self.reference[:, None]
        return np.asarray(self.rows @ theta + reference)

    def features(self, theta: Floats) -> Floats:
        """Evaluate ``phi = [1, cos alpha, sin alpha]``.

        Parameters
        ----------
        theta : numpy.ndarray
            Rotation states, shape (n_theta,) or (n_theta, m).

        Returns
        -------
        numpy.ndarray
            Shape (1 + 2 n_angles,) or (1 + 2 n_angles, m).
        """
        alpha = self.at(theta)
        return np.concatenate([np.ones_like(alpha, shape=(1, *alpha.shape[1:])), np.cos(alpha), np.sin(alpha)])

    def slopes(self, theta: Floats) -> sp.csr_array:
        """Evaluate the derivatives of the features with respect to theta.

        Parameters
        ----------
        theta : numpy.ndarray
            Rotation states, shape (n_theta,).

        Returns
        -------
        scipy.sparse.csr_array
            Shape (1 + 2 n_angles, n_theta).
        """
        alpha = self.at(theta)
        first = sp.csr_array((1, theta.size))
        cos, sin = sp.diags_array(np.cos(alpha)), sp.diags_array(np.sin(alpha))
        return sp.csr_array(sp.vstack([first, -sin @ self.rows, cos @ self.rows]))
