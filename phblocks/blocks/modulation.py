"""Matrices of a block that depend on its energy variables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from phblocks.errors import DataError, StructureError
from phblocks.triplets import Floats, Ints, real_array

#: Of the energy variables, shape (k,), to an array; and as a user writes it.
OfState = Callable[[Floats], Floats]
Given = Callable[[Floats], ArrayLike]

#: Relative size of a defect of symmetry, skewness or definiteness that counts as round-off.
TOLERANCE = 1e-12


@dataclass(frozen=True)
class Modulation:
    """``J(x) - R(x)`` on a few states, as functions of the energy variables x of a block.

    A time method evaluates them where it evaluates the rest of the equations: the midpoint rule, and with it the
    discrete gradient, at the midpoint of the step, so that the power lost is ``z^T R(x_mid) z`` exactly.

    Parameters
    ----------
    where : str
        The block, for messages.
    by, on : numpy.ndarray
        Indices of x, shape (k,), and of the states that the matrices act on, shape (a,).
    interconnection, dissipation : callable
        J(x) and R(x), shape (a, a).
    slope : callable
        Of J - R by x, shape (a, a, k): entry (i, j, m) is the derivative of (i, j) by x[m].
    names : tuple of str
        What J and R are made of, for messages.
    """

    where: str
    by: Ints
    on: Ints
    interconnection: OfState
    dissipation: OfState
    slope: OfState
    names: tuple[str, str] = ("J", "R")

    def shifted(self, first: int) -> Modulation:
        """Number the states from another one on.

        Parameters
        ----------
        first : int
            What is added to the indices.

        Returns
        -------
        Modulation
            Of the same matrices.
        """
        return replace(self, by=self.by + first, on=self.on + first)

    def verified(self, x: Floats) -> tuple[Floats, Floats]:
        """Evaluate J and R at several states, and see that they are what they must be.

        Parameters
        ----------
        x : numpy.ndarray
            Energy variables, shape (states, k).

        Returns
        -------
        J, R : numpy.ndarray
            Shape (states, a, a).

        Raises
        ------
        StructureError
            If they are not finite, J is not skew, or R not symmetric and positive semidefinite, with the state where
            that is so.
        """
        with np.errstate(all="ignore"):  # what is not finite is said below
            J = np.stack([self.interconnection(row) for row in x])
            R = np.stack([self.dissipation(row) for row in x])
        turned = (0, 2, 1)
        self._require_finite(x, 0, J)
        self._require_finite(x, 1, R)
        self._require(x, 0, "a skew matrix", np.abs(J + J.transpose(turned)), J)
        self._require(x, 1, "a symmetric matrix", np.abs(R - R.transpose(turned)), R)
        least = np.linalg.eigvalsh(R)[:, :1, None]
        self._require(x, 1, "a positive semidefinite matrix", np.maximum(-least, 0.0), R)
        return J, R

    def undefined(self, x: Floats) -> str:
        """Say which matrix, or whether a derivative, is not finite at a state.

        Parameters
        ----------
        x : numpy.ndarray
            Energy variables, shape (k,).

        Returns
        -------
        str
            Block, matrix and state; empty if all are finite.
        """
        with np.errstate(all="ignore"):
            for name, function in zip(self.names, (self.interconnection, self.dissipation), strict=True):
                if not np.isfinite(function(x)).all():
                    return f"{self.where} {name}(x) is not finite at x = {x.tolist()}"
            if not np.isfinite(self.slope(x)).all():
                return f"{self.where} derivative of {' - '.join(self.names)} is not finite at x = {x.tolist()}"
        return ""

    def _require_finite(self, x: Floats, which: int, matrix: Floats) -> None:
        bad = np.flatnonzero(~np.isfinite(matrix).all(axis=(1, 2)))
        if bad.size:
            raise StructureError(
                f"{self.where} {self.names[which]}(x)",
                expected="finite numbers",
                got=f"{matrix[bad[0]].tolist()} at x = {x[bad[0]].tolist()}",
                fix="Correct the function, or keep the motion where it is defined.",
            )

    def _require(self, x: Floats, which: int, expected: str, defect: Floats, matrix: Floats) -> None:
        worst = defect.max(axis=(1, 2))
        bad = np.flatnonzero(worst > TOLERANCE * np.abs(matrix).max(axis=(1, 2)))
        if bad.size:
            raise StructureError(
                f"{self.where} {self.names[which]}(x)",
                expected=expected,
                got=f"a defect of {worst[bad[0]]:.3g} at x = {x[bad[0]].tolist()}",
                fix="Correct the function; what is skew belongs to J, what is symmetric to R with the opposite sign.",
            )


class StateMatrix:
    """A matrix given as numbers or as a function of the energy variables, with its derivative.

    Without a derivative from the user it is found by central differences, column by column, with the step
    ``eps^(1/3) max(|x_k|, s_k)``. There ``s_k = size_k min(1, r)`` with ``r = max |x_j| / size_j``, so that a variable
    near zero gets a step like those of the others, and like ``size_k`` where all are zero. They serve Newton's method
    and linear models; what a step converges to does not depend on them.

    Parameters
    ----------
    where : str
        What it is, for messages.
    function : callable or numpy.ndarray
        Of x, or constant.
    shape : tuple of int
        Rows and columns.
    size : numpy.ndarray
        Of each energy variable where the energy is of order one, shape (k,).
    derivative : callable, optional
        Of x, shape (rows, columns, k).

    Attributes
    ----------
    constant : bool
        It does not depend on x.
    """

    def __init__(
        self, where: str, function: Given | Floats, shape: tuple[int, int], size: Floats, derivative: Given | None
    ) -> None:
        self.constant = not callable(function)
        self._where, self._function, self._shape = where, function, shape
        self._size, self._derivative = size, derivative

    def __call__(self, x: Floats) -> Floats:
        """Evaluate, with a check of the shape.

        Parameters
        ----------
        x : numpy.ndarray
            Energy variables, shape (k,).

        Returns
        -------
        numpy.ndarray
            Shape (rows, columns).
        """
        if not callable(self._function):
            return self._function
        return _shaped(self._where, self._function(x), self._shape)

    def slope(self, x: Floats) -> Floats:
        """Evaluate the derivative.

        Parameters
        ----------
        x : numpy.ndarray
            Energy variables, shape (k,).

        Returns
        -------
        numpy.ndarray
            Shape (rows, columns, k).
        """
        if self.constant:
            return np.zeros((*self._shape, x.size))
        if self._derivative is not None:
            return _shaped(f"derivative of {self._where}", self._derivative(x), (*self._shape, x.size))
        return self.differences(x)

    def differences(self, x: Floats, factor: float = 1.0) -> Floats:
        """Approximate the derivative by central differences.

        Parameters
        ----------
        x : numpy.ndarray
            Energy variables, shape (k,).
        factor : float, optional
            On the step.

        Returns
        -------
        numpy.ndarray
            Shape (rows, columns, k).
        """
        step = factor * float(np.cbrt(np.finfo(float).eps)) * typical(x, self._size)
        columns = []
        for k, h in enumerate(step):
            ends = np.stack([x, x])
            ends[:, k] += (-h, h)
            columns.append((self(ends[1]) - self(ends[0])) / (ends[1, k] - ends[0, k]))
        return np.stack(columns, axis=-1)


def typical(x: Floats, size: Floats) -> Floats:
    """Return how large each energy variable is, or may soon be.

    Parameters
    ----------
    x : numpy.ndarray
        Energy variables, shape (k,).
    size : numpy.ndarray
        Of each where the energy is of order one, shape (k,).

    Returns
    -------
    numpy.ndarray
        Positive, shape (k,).
    """
    ratio = float(np.max(np.abs(x) / size))
    return np.maximum(np.abs(x), size * min(1.0, ratio) if ratio > 0.0 else size)


def _shaped(where: str, value: object, shape: tuple[int, ...]) -> Floats:
    array = real_array(value)
    if array is None or array.shape != shape:
        got = type(value).__name__ if array is None else f"shape {array.shape}"
        raise DataError(where, expected=f"real numbers of shape {shape}", got=got, fix="Correct the function.")
    return array
