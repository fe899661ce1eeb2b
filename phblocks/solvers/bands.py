"""Factors in bands and the modes of a method, as the arrays that compiled code works with."""

from __future__ import annotations

from typing import Any

import numpy as np

from phblocks.solvers.collocation import CollocationEquation
from phblocks.solvers.linear import band_places


class BandFactors:
    """Room for the factors of the modes of a method, in bands.

    Parameters
    ----------
    equation : CollocationEquation
        Of the stages.

    Attributes
    ----------
    arrays : tuple
        Of the real mode and of the complex pair: both parts of the band, pivots, half-bandwidth; empty without one.
    """

    def __init__(self, equation: CollocationEquation) -> None:
        width, _ = band_places(equation.rows, equation.columns)
        values, pivots = equation.modes.values, np.zeros((2, equation.n), dtype=np.int64)
        some = ((values.imag == 0.0).any(), values.imag.any())
        real, paired = (np.zeros((equation.n if any_ else 0, 3 * width + 1)) for any_ in some)
        self.arrays = (real, real[:0], pivots[0], width), (paired, paired.copy(), pivots[1], width)


def modes_of(equation: CollocationEquation) -> tuple[Any, ...]:
    """Take the modes of a method apart, for compiled code.

    Parameters
    ----------
    equation : CollocationEquation
        Of the stages.

    Returns
    -------
    tuple
        Eigenvalue, weights into the mode and out of it, of the real mode and of the complex one.
    """
    none: tuple[Any, ...] = (0.0, np.zeros(equation.collocation.b.size), np.zeros(equation.collocation.b.size))
    real, paired = none, (0j, none[1] * 0j, none[2] * 0j)
    modes = equation.modes
    for value, left, right in zip(modes.values, modes.left, modes.right, strict=True):
        if value.imag:
            paired = (complex(value), left.copy(), right.copy())
        else:
            real = (float(value.real), left.real.copy(), right.real.copy())
    return (*real, *paired)
