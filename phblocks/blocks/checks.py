"""Checks of the numbers that users give to blocks."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from phblocks.errors import ArgumentTypeError, DataError, OrientationError, StructureError
from phblocks.triplets import Floats, real_array


def require_real(where: str, value: object) -> float:
    """Return a number if it is real.

    Parameters
    ----------
    where : str
        What the number is, for the message.
    value : object
        The candidate.

    Returns
    -------
    float
        The number; it may be NaN or infinite.

    Raises
    ------
    ArgumentTypeError
        If it is not a real number (a truth value is none).
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ArgumentTypeError(
            where, expected="a real number", got=type(value).__name__, fix="Give a number in SI units."
        )
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def is_one_of(value: object, options: Sequence[str | None]) -> bool:
    """Say whether something a user gave is one of some words; arrays and the like are not.

    Parameters
    ----------
    value : object
        The candidate.
    options : sequence of str or None
        The words.

    Returns
    -------
    bool
        Whether it is.
    """
    return (value is None or isinstance(value, str)) and value in options


def require_flag(where: str, value: object) -> bool:
    """Return a truth value if it is one.

    Parameters
    ----------
    where : str
        What it is, for the message.
    value : object
        The candidate.

    Returns
    -------
    bool
        The value.

    Raises
    ------
    ArgumentTypeError
        If it is anything else.
    """
    if not isinstance(value, (bool, np.bool_)):
        raise ArgumentTypeError(where, expected="True or False", got=repr(value), fix="Give one of them.")
    return bool(value)


def require_finite(where: str, value: object) -> float:
    """Return a number if it is finite.

    Parameters
    ----------
    where : str
        What the number is, for the message.
    value : object
        The candidate.

    Returns
    -------
    float
        The number.

    Raises
    ------
    ArgumentTypeError
        If it is not a real number.
    DataError
        If it is not finite.
    """
    number = require_real(where, value)
    if not math.isfinite(number):
        raise DataError(where, expected="a finite number", got=repr(value), fix="Give a value in SI units.")
    return number


def require_not_negative(where: str, value: object) -> float:
    """Return a number if it is finite and not negative.

    Parameters
    ----------
    where : str
        What the number is, for the message.
    value : object
        The candidate.

    Returns
    -------
    float
        The number.

    Raises
    ------
    ArgumentTypeError
        If it is not a real number.
    DataError
        If it is not finite, or negative.
    """
    number = require_real(where, value)
    if not (math.isfinite(number) and number >= 0.0):
        raise DataError(where, expected="a finite number >= 0", got=repr(value), fix="Give a value in SI units.")
    return number


def require_positive(where: str, value: object) -> float:
    """Return a number if it is finite and positive.

    Parameters
    ----------
    where : str
        What the number is, for the message.
    value : object
        The candidate.

    Returns
    -------
    float
        The number.

    Raises
    ------
    ArgumentTypeError
        If it is not a real number.
    DataError
        If it is not finite and positive.
    """
    number = require_real(where, value)
    # the inverse of the smallest numbers is infinite: a mass of 5e-324 kg is none
    if not (math.isfinite(number) and number > 0.0 and math.isfinite(1.0 / number)):
        raise DataError(where, expected="a finite number > 0", got=repr(value), fix="Give a value in SI units.")
    return number


def require_point(where: str, value: ArrayLike) -> Floats:
    """Return a point in the plane.

    Parameters
    ----------
    where : str
        What it is, for the message.
    value : array_like
        The candidate.

    Returns
    -------
    numpy.ndarray
        Shape (2,), m, read-only.

    Raises
    ------
    ArgumentTypeError
        If it is not made of numbers.
    DataError
        If it has not two finite coordinates.
    OrientationError
        If it has three: the part is one of the plane only.
    """
    point = real_array(value)
    if point is None:
        raise ArgumentTypeError(where, expected="coordinates (x, y)", got=repr(value), fix="Give two numbers in m.")
    if point.shape == (3,):
        raise OrientationError(
            where,
            expected="two coordinates, of a part of the plane",
            got="three",
            fix="In space there are beams, sources and the ground: orientations that turn there are not computed yet.",
        )
    if point.shape != (2,) or not np.isfinite(point).all():
        raise DataError(where, expected="two finite coordinates (x, y)", got=repr(value), fix="Give two numbers in m.")
    point.setflags(write=False)
    return point


def require_place(where: str, value: ArrayLike) -> Floats:
    """Return a point in the plane or in space.

    Parameters
    ----------
    where : str
        What it is, for the message.
    value : array_like
        The candidate.

    Returns
    -------
    numpy.ndarray
        Shape (2,) or (3,), m, read-only.

    Raises
    ------
    ArgumentTypeError
        If it is not made of numbers.
    DataError
        If it has not two or three finite coordinates.
    """
    point = real_array(value)
    if point is None or point.shape != (3,):
        return require_point(where, value)
    if not np.isfinite(point).all():
        raise DataError(where, expected="finite coordinates (x, y, z)", got=repr(value), fix="Give numbers in m.")
    point.setflags(write=False)
    return point


def require_direction(where: str, value: ArrayLike, dimension: int = 2) -> Floats:
    """Return a direction, of length one.

    Parameters
    ----------
    where : str
        What it is, for the message.
    value : array_like
        The candidate, of any length.
    dimension : int, optional
        2 in the plane, 3 in space.

    Returns
    -------
    numpy.ndarray
        Shape (dimension,).

    Raises
    ------
    ArgumentTypeError
        If it is not made of numbers.
    DataError
        If it has not so many finite components, or all are zero.
    """
    vector = require_point(where, value) if dimension == 2 else require_place(where, value)
    if vector.size != dimension:
        raise DataError(where, expected=f"{dimension} components", got=repr(value), fix="Correct it.")
    length = float(np.hypot(*vector)) if dimension == 2 else float(np.linalg.norm(vector))
    if length == 0.0:
        raise DataError(where, expected="a direction", got=str((0,) * dimension), fix="Correct it.")
    return np.asarray(vector / length)


def require_matrix(where: str, value: ArrayLike, shape: tuple[int, int]) -> Floats:
    """Return a matrix of a given shape.

    Parameters
    ----------
    where : str
        What it is, for the message.
    value : array_like
        The candidate.
    shape : tuple of int
        Rows and columns.

    Returns
    -------
    numpy.ndarray
        A copy, read-only.

    Raises
    ------
    ArgumentTypeError
        If it is not made of numbers.
    DataError
        If the shape is another, or a number is not finite.
    """
    matrix = real_array(value)
    if matrix is None:
        raise ArgumentTypeError(where, expected=f"numbers of shape {shape}", got=repr(value), fix="Give a matrix.")
    if matrix.shape != shape or not np.isfinite(matrix).all():
        got = f"shape {matrix.shape}" if matrix.shape != shape else "numbers that are not finite"
        raise DataError(where, expected=f"finite numbers of shape {shape}", got=got, fix="Correct the matrix.")
    matrix.setflags(write=False)
    return matrix


def require_semidefinite(where: str, matrix: Floats) -> None:
    """Check that a matrix is symmetric and positive semidefinite.

    Parameters
    ----------
    where : str
        What it is, for the message.
    matrix : numpy.ndarray
        Square.

    Raises
    ------
    StructureError
        If it is not.
    """
    size = np.abs(matrix).max(initial=0.0)
    defect = np.abs(matrix - matrix.T).max(initial=0.0)
    if defect > 1e-12 * size:
        raise StructureError(
            where, expected="a symmetric matrix", got=f"a defect of {defect:.3g}", fix="Correct the matrix."
        )
    least = float(np.linalg.eigvalsh(matrix).min(initial=0.0))
    if least < -1e-12 * size:
        raise StructureError(
            where,
            expected="a positive semidefinite matrix",
            got=f"one with the eigenvalue {least:.6g}",
            fix="Correct the matrix.",
        )
