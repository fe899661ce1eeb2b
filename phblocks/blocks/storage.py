"""Storage of energy that is not quadratic in the states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from phblocks.triplets import Floats, Ints

#: Of the energy variables, shape (k,), to a number, a vector of shape (k,), a matrix of shape (k, k).
Hamiltonian = Callable[[Floats], float]
Gradient = Callable[[Floats], Floats]
Hessian = Callable[[Floats], Floats]


@dataclass(frozen=True)
class Storage:
    """Energy variables x with any energy H(x), and as many co-energy variables ``z = grad H(x)``.

    Both are states: ``x' = (J - R) z + G u`` stands in the rows of z, where J and R act, and ``0 = z - grad H(x)`` in
    the rows of x.

    Parameters
    ----------
    energy, coenergy : numpy.ndarray
        Indices of x and z among the states.
    hamiltonian, gradient, hessian : callable
        H and its derivatives with respect to x.
    size : numpy.ndarray
        Of each energy variable where H is of order one.
    expression : (sequence of sympy.Symbol, sympy.Expr) or None
        H as an expression of symbols for the energy variables, if it was made of one.
    """

    energy: Ints
    coenergy: Ints
    hamiltonian: Hamiltonian
    gradient: Gradient
    hessian: Hessian
    size: Floats
    expression: tuple[Any, Any] | None = None

    def shifted(self, first: int) -> Storage:
        """Number the states from another one on.

        Parameters
        ----------
        first : int
            What is added to the indices.

        Returns
        -------
        Storage
            Of the same energy.
        """
        return replace(self, energy=self.energy + first, coenergy=self.coenergy + first)

    def discrete_gradient(self, before: Floats, middle: Floats) -> tuple[Floats, Floats, float]:
        """Evaluate Gonzalez' discrete gradient between two states.

        With ``d = after - before`` it is the g next to ``grad H(middle)`` that satisfies ``g^T d = H(after) -
        H(before)``; distances are measured in units of :attr:`size`.

        Parameters
        ----------
        before, middle : numpy.ndarray
            Energy variables, shape (k,); after is ``2 middle - before``.

        Returns
        -------
        gradient : numpy.ndarray
            Shape (k,).
        slope : numpy.ndarray
            Its derivative with respect to ``middle``, shape (k, k).
        noise : float
            Round-off in the gradient in units of ``1 / size``.

        Notes
        -----
        O. Gonzalez, Time integration and discrete Hamiltonian systems, J. Nonlinear Sci. 6 (1996) 449-467,
        doi:10.1007/BF02440162.
        """
        d = 2.0 * (middle - before)
        after = before + d
        gradient, hessian = np.asarray(self.gradient(middle)), np.asarray(self.hessian(middle))
        weight = self.size**-2
        towards = weight * d
        square = float(d @ towards)
        # what is missing is of third order in d: in steps so small it is below the round-off of H
        if square <= 1e-11 * float(middle @ (weight * middle)) or square == 0.0:
            return gradient, hessian, 0.0
        first, last = self.hamiltonian(before), self.hamiltonian(after)
        along = float(gradient @ d)
        missing = (last - first - along) / square
        curved = hessian @ d
        change = 2.0 * (np.asarray(self.gradient(after)) - gradient) - curved
        slope = hessian + np.outer(towards, (change - 4.0 * missing * towards) / square)
        slope += np.diag(2.0 * missing * weight)
        noise = float(np.finfo(float).eps * (abs(first) + abs(last) + abs(along)) / np.sqrt(square))
        return gradient + missing * towards, slope, noise
