"""What errors are measured against: given, extrapolated from the runs of a study, or from a run finer than all."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.studies.quantity import distance
from phblocks.triplets import Floats

#: Orders, or rates of decay, between which extrapolation looks.
LEAST_ORDER, MOST_ORDER = 0.05, 30.0


@dataclass(frozen=True, eq=False)
class Reference:
    """The value errors are measured against.

    Parameters
    ----------
    value : numpy.ndarray
        What the quantity should be, shape (times,) or (times, components).
    uncertainty : float, optional
        How far it may be from the truth, in the norm of the error; NaN if that is not known.
    source : str, optional
        Where it is from, for the notes of tables.
    """

    value: NDArray[np.float64]
    uncertainty: float = math.nan
    source: str = "given"

    def __post_init__(self) -> None:
        """Check the value."""
        try:
            value = np.atleast_1d(np.asarray(self.value, dtype=float))
        except (TypeError, ValueError) as error:
            raise ArgumentTypeError("reference", expected="numbers", got=repr(self.value), fix="Give them.") from error
        if not value.size or not np.isfinite(value).all():
            raise DataError("reference", expected="finite numbers", got=str(self.value), fix="Correct it.")
        if self.uncertainty < 0.0:
            raise DataError("reference", expected="uncertainty >= 0", got=repr(self.uncertainty), fix="Correct it.")
        object.__setattr__(self, "value", value)

    def __repr__(self) -> str:
        """Say where it is from and how far it may be off."""
        return f"<Reference of shape {self.value.shape}, uncertain by {self.uncertainty:.2g}: {self.source}>"

    def error_of(self, value: Floats | None) -> float:
        """Measure an error.

        Parameters
        ----------
        value : numpy.ndarray or None
            The quantity of a run, ``None`` if it failed.

        Returns
        -------
        float
            Largest over the times of the Euclidean norm over the components; NaN if the run failed.

        Raises
        ------
        DataError
            If the shape is not that of the reference.
        """
        if value is None:
            return math.nan
        if value.shape != self.value.shape:
            raise DataError(
                "reference",
                expected=f"the shape of the quantity, {value.shape}",
                got=f"shape {self.value.shape}",
                fix="One row for each time; one column for each component.",
            )
        return distance(value, self.value)


def given(reference: Reference | ArrayLike) -> Reference:
    """Take a reference as the user gives it.

    Parameters
    ----------
    reference : Reference or array_like
        It, or its value.

    Returns
    -------
    Reference
        With unknown uncertainty if only the value was given.
    """
    return reference if isinstance(reference, Reference) else Reference(np.asarray(reference))


def extrapolate(sizes: Sequence[float], values: Sequence[Floats]) -> Reference:
    """Extrapolate runs to size zero (Richardson), with the order that the three finest runs show.

    With ``f(h) = f + C h^p`` the order follows from ``|f3 - f2| / |f2 - f1| = (h3^p - h2^p) / (h2^p - h1^p)``, and
    ``f = f1 + (f1 - f2) h1^p / (h2^p - h1^p)``. Where the differences do not fall as any order would have them, the
    finest run is taken as it is.

    Parameters
    ----------
    sizes : sequence of float
        Sizes h, from coarse to fine, at least three.
    values : sequence of numpy.ndarray
        The quantity, of the same shape each.

    Returns
    -------
    Reference
        Its uncertainty is the distance from what the three next coarser runs give, or where there are none from the
        finest run.

    Notes
    -----
    P. J. Roache, Perspective: a method for uniform reporting of grid refinement studies, doi:10.1115/1.2910291;
    observed order for unequal ratios after L. Eca, M. Hoekstra, doi:10.1016/j.jcp.2014.01.006.
    """
    limit = _limit(sizes[-3:], values[-3:])
    if limit is None:
        return Reference(
            values[-1], distance(values[-1], values[-2]), "the finest run: differences do not fall as an order has it"
        )
    coarser = _limit(sizes[-4:-1], values[-4:-1]) if len(sizes) > 3 else None
    return Reference(
        limit,
        distance(limit, values[-1] if coarser is None else coarser),
        "extrapolated from the three finest runs",
    )


def _limit(sizes: Sequence[float], values: Sequence[Floats]) -> Floats | None:
    """The limit of three runs; ``None`` if no order explains the differences."""
    h3, h2, h1 = sizes
    fine = distance(values[2], values[1])
    if fine == 0.0:
        return None
    wanted = distance(values[1], values[0]) / fine
    low, high = LEAST_ORDER, MOST_ORDER

    def ratio(p: float) -> float:  # grows with p; relative to h1, so that nothing underflows
        far, near = (math.pow(h / h1, p) for h in (h3, h2))
        return (far - near) / (near - 1.0)

    if not ratio(low) < wanted < ratio(high):
        return None
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if ratio(middle) < wanted else (low, middle)
    order = 0.5 * (low + high)
    return values[2] + (values[2] - values[1]) / (math.pow(h2 / h1, order) - 1.0)


def refined(mesh: Mapping[str, Any]) -> tuple[dict[str, Any], ...]:
    """Refine a mesh.

    Parameters
    ----------
    mesh : mapping
        Arguments of the function that makes the system. ``elements``, an integer or several, are doubled, ``degree`` is
        raised by one, where they are there.

    Returns
    -------
    tuple of dict
        The finer mesh, and one between it and this one to compare with: of the same degree, or else of the same
        elements. Only the mesh itself if nothing in it can be refined.
    """
    finer = dict(mesh)
    with suppress(ArgumentTypeError):
        counts = element_counts(mesh.get("elements"))
        finer["elements"] = 2 * counts[0] if np.ndim(mesh["elements"]) == 0 else tuple(2 * n for n in counts)
    if isinstance(mesh.get("degree"), (int, np.integer)):
        return {**finer, "degree": mesh["degree"] + 1}, finer
    return (finer,) if finer == mesh else (finer, dict(mesh))


def element_counts(elements: object) -> tuple[int, ...]:
    """Read numbers of elements.

    Parameters
    ----------
    elements : object
        An integer, or several.

    Returns
    -------
    tuple of int
        The numbers.

    Raises
    ------
    ArgumentTypeError
        If it is something else.
    """
    several = tuple(elements) if isinstance(elements, (tuple, list)) else (elements,)
    if not several or not all(isinstance(n, (int, np.integer)) and not isinstance(n, bool) and n > 0 for n in several):
        raise ArgumentTypeError(
            "elements", expected="an integer > 0, or several", got=repr(elements), fix="Such as 8 or (10, 6, 6)."
        )
    return tuple(int(n) for n in several)
