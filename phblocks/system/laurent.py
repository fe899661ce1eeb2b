"""How numbers depend on parameters, found from their values: sums of products of powers from -2 to 2.

Masses, stiffnesses, dampings, ratios and lengths enter the matrices of blocks in this way. Whatever does not is found
out by values that were not used, and refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import product

import numpy as np

from phblocks.errors import StructureError
from phblocks.triplets import Floats

POWERS = (-2, -1, 0, 1, 2)
#: Factors of a parameter at which numbers are looked at; as many as powers.
FACTORS = (0.7, 1.0, 1.4, 1.9, 2.6)
#: Factors for the check, one after the other for the parameters.
CHECKED = (1.23, 0.81, 1.57, 0.93, 1.11)
#: Relative size of what counts as round-off.
NOISE = 1e-11

#: By powers, one of each parameter, the coefficient.
Terms = dict[tuple[int, ...], float]


def terms_of(
    numbers: Callable[[Mapping[str, float]], Floats], parameters: Mapping[str, float], where: str
) -> dict[int, Terms]:
    """Find how numbers depend on parameters.

    Parameters
    ----------
    numbers : callable
        Of values of parameters to an array of shape (k,).
    parameters : mapping of str to float
        Their values now.
    where : str
        What it is for, for the message.

    Returns
    -------
    dict of int to dict
        For each number that depends on a parameter its terms; the powers are in the order of the parameters.

    Raises
    ------
    StructureError
        If a number depends on a parameter in another way.
    """
    names, base = list(parameters), numbers({})
    moved = [abs(numbers({name: 1.4 * value}) - base) > NOISE * np.abs(base) for name, value in parameters.items()]
    found: dict[int, Terms] = {}
    for group in sorted({tuple(row) for row in np.array(moved).T.tolist() if any(row)}):
        used = [i for i, on in enumerate(group) if on]
        places = np.flatnonzero((np.array(group) == np.array(moved).T).all(axis=1))
        if len(used) > 3:
            raise _refused(where, [names[i] for i in used], "four parameters in one number")
        samples = np.array(
            [
                numbers({names[i]: f * parameters[names[i]] for i, f in zip(used, factors, strict=True)})[places]
                for factors in product(FACTORS, repeat=len(used))
            ]
        )
        found |= _fitted(samples, [parameters[names[i]] for i in used], used, len(names), places.tolist())
    factors = {name: CHECKED[i % len(CHECKED)] * value for i, (name, value) in enumerate(parameters.items())}
    check, values = numbers(factors), list(factors.values())
    for place, terms in found.items():
        fit = sum(c * np.prod(np.power(values, powers)) for powers, c in terms.items())
        if abs(fit - check[place]) > 1e-9 * max(abs(check[place]), abs(base[place])):
            used = [i for i in range(len(names)) if moved[i][place]]
            raise _refused(where, [names[i] for i in used], "a dependence of another kind")
    return found


def _fitted(
    samples: Floats, values: Sequence[float], used: Sequence[int], count: int, places: Sequence[int]
) -> dict[int, Terms]:
    """Solve for the coefficients, one parameter after the other; samples are those of a full grid of factors."""
    k = len(used)
    grid = samples.reshape((len(FACTORS),) * k + (-1,))
    inverse = np.linalg.inv(np.power.outer(np.array(FACTORS), np.array(POWERS, dtype=float)))
    for axis in range(k):
        grid = np.moveaxis(np.tensordot(inverse, grid, axes=(1, axis)), 0, axis)
    found: dict[int, Terms] = {}
    for column, place in enumerate(places):
        coefficients, terms = grid[..., column], {}
        largest = np.abs(coefficients).max()
        for at in np.argwhere(np.abs(coefficients) > NOISE * largest):
            powers = [0] * count
            for i, p in zip(used, at, strict=True):
                powers[i] = POWERS[p]
            scale = np.prod([v ** POWERS[p] for v, p in zip(values, at, strict=True)])
            terms[tuple(powers)] = float(coefficients[tuple(at)] / scale)
        found[place] = terms
    return found


def _refused(where: str, names: Sequence[str], got: str) -> StructureError:
    return StructureError(
        f"{where}: {', '.join(names)}",
        expected="matrices in sums of products of powers of the parameters",
        got=got,
        fix="Give plain numbers for them; other parameters can stay.",
    )
