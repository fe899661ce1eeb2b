"""How the features of the configuration enter a stage: which entries they act through, and what they depend on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from phblocks.system import System
from phblocks.triplets import Floats, Ints, Triplets


def entry_code(rows: Ints, columns: Ints, n: int) -> Ints:
    """Number places in a matrix by rows.

    Parameters
    ----------
    rows, columns : numpy.ndarray
        The places.
    n : int
        Number of columns.

    Returns
    -------
    numpy.ndarray
        ``rows n + columns``.
    """
    return np.asarray(rows, dtype=np.int64) * n + np.asarray(columns, dtype=np.int64)


def taken(entries: Triplets, keep: NDArray[np.bool_]) -> Triplets:
    """Take some of the entries.

    Parameters
    ----------
    entries : Triplets
        All.
    keep : numpy.ndarray
        For each whether it is taken.

    Returns
    -------
    Triplets
        Those.
    """
    return Triplets(tuple(i[keep] for i in entries.indices), entries.values[keep])


def modulated_pairs(
    n_features: int, moving: Triplets, by_gravity: Triplets, by_inputs: Triplets
) -> tuple[tuple[Ints, Ints], dict[str, Ints]]:
    """Number all (state, feature) pairs through which the configuration acts.

    Parameters
    ----------
    n_features : int
        Of the system.
    moving : Triplets
        K and the kinematics that turn, shape (n, n, n_features).
    by_gravity, by_inputs : Triplets
        K_g and K_u, shapes (n, n_features) and (n, n_inputs, n_features).

    Returns
    -------
    pairs : tuple of numpy.ndarray
        State and feature of each pair.
    spots : dict of str to numpy.ndarray
        For each entry of ``moving`` ("K"), K_g and K_u its pair.
    """
    parts = {
        "K": (moving.indices[0], moving.indices[2]),
        "K_g": (by_gravity.indices[0], by_gravity.indices[1]),
        "K_u": (by_inputs.indices[0], by_inputs.indices[2]),
    }
    codes = [entry_code(i, f, n_features) for i, f in parts.values()]
    pairs, spots = np.unique(np.concatenate(codes), return_inverse=True)
    ends = np.cumsum([c.size for c in codes])[:-1]
    return (pairs // n_features, pairs % n_features), dict(zip(parts, np.split(spots, ends), strict=True))


class Dependence:
    """The states that the feature of each pair depends on.

    Parameters
    ----------
    system : System
        The system.
    feature : numpy.ndarray
        Of each pair.
    chain : scipy.sparse.csr_array
        Derivatives of all angles by the time integrals of the states.

    Attributes
    ----------
    parts : list of tuple
        (pair, state, factor), by angle, and if there are lines by their spans and by their length.
    """

    def __init__(self, system: System, feature: Ints, chain: sp.csr_array) -> None:
        n_angles, lines = system.angles.reference.size, system.lines
        turning = np.flatnonzero(feature > 0)  # feature 0 is the constant
        number = feature[turning] - 1
        along = number - 2 * n_angles  # directions come last
        angle = np.where(along < 0, number % max(1, n_angles), n_angles + along % max(1, lines.count))
        place, column, value = expand(chain, angle)
        self.parts = [(turning[place], column, value)]
        if not lines.count:
            return
        on_line = turning[along >= 0]
        line = lines.line[along[along >= 0] % lines.count]
        self.parts += [(on_line, lines.spans[line, a], np.ones(line.size)) for a in range(2)]
        place, column, value = expand(lines.stretch, line)
        self.parts.append((on_line[place], column, value))


@dataclass(frozen=True)
class LineDirections:
    """Directions of lines and their derivatives, in scaled, reordered unknowns, one entry for each direction.

    Parameters
    ----------
    span : scipy.sparse.csr_array
        Picks both components of the spans, shape (2 directions, n).
    free : numpy.ndarray
        Length at zero force, m.
    stretch : scipy.sparse.csr_array
        What adds to it, shape (directions, n).
    taut : numpy.ndarray
        Length from the states; otherwise that of the span.
    before : int
        Number of features that come before directions.
    """

    span: sp.csr_array
    free: Floats
    stretch: sp.csr_array
    taut: NDArray[np.bool_]
    before: int

    @classmethod
    def of(cls, system: System, new: Ints, scale: Floats) -> LineDirections:
        """Collect them.

        Parameters
        ----------
        system : System
            The system; it has lines.
        new : numpy.ndarray
            The unknown that each state is.
        scale : numpy.ndarray
            Of each state.

        Returns
        -------
        LineDirections
            Of all directions.
        """
        lines = system.lines
        d, states = np.arange(lines.count), lines.spans[lines.line]
        rows = [Triplets.of(a * lines.count + d, new[states[:, a]], values=scale[states[:, a]]) for a in range(2)]
        place, column, value = expand(lines.stretch, lines.line)
        return cls(
            Triplets.join(rows).csr((2 * lines.count, system.n)),
            lines.free[lines.line],
            Triplets.of(place, new[column], values=value * scale[column]).csr((lines.count, system.n)),
            lines.taut[lines.line],
            1 + 2 * system.angles.reference.size,
        )

    def evaluate(self, z: Floats, cos: Floats, sin: Floats) -> tuple[Floats, Floats, tuple[Floats, ...]]:
        """Evaluate directions; several columns at once if given.

        Parameters
        ----------
        z : numpy.ndarray
            Unknowns, shape (n,) or (n, m).
        cos, sin : numpy.ndarray
            Of the angles of their frames, shape (directions,) or (directions, m).

        Returns
        -------
        features, slopes : numpy.ndarray
            Both components, and their derivatives by the angle, shape (2 directions,) or (2 directions, m).
        derivatives : tuple of numpy.ndarray
            Of all features, those before too, by both components of the span and by the length.
        """
        x, y = (self.span @ z).reshape(2, *cos.shape)
        tail = (1,) * (z.ndim - 1)
        taut = self.taut.reshape(-1, *tail)
        length = np.where(taut, self.free.reshape(-1, *tail) + self.stretch @ z, np.hypot(x, y))
        first, second = (cos * x + sin * y) / length, (cos * y - sin * x) / length
        direction, loose = np.concatenate((first, second)), ~taut
        by_x = np.concatenate((cos - loose * first * x / length, -sin - loose * second * x / length))
        by_y = np.concatenate((sin - loose * first * y / length, cos - loose * second * y / length))
        twice = np.concatenate((length, length))
        before = np.zeros((self.before, *z.shape[1:]))
        derivatives = tuple(np.concatenate((before, d / twice)) for d in (by_x, by_y, -direction))
        return direction, np.concatenate((second, -first)), derivatives


def expand(matrix: sp.csr_array, rows: Ints) -> tuple[Ints, Ints, Floats]:
    """List the entries of some rows of a matrix.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array
        The matrix.
    rows : numpy.ndarray
        The rows, which may repeat.

    Returns
    -------
    place, column, value : numpy.ndarray
        Place in ``rows``, column and value of each entry.
    """
    if not rows.size or not matrix.nnz:
        none = np.empty(0, dtype=np.int64)
        return none, none, np.empty(0)
    count = np.diff(matrix.indptr)[rows]
    place = np.repeat(np.arange(rows.size), count)
    within = np.arange(place.size) - np.repeat(np.cumsum(count) - count, count)
    spot = matrix.indptr[rows][place] + within
    return place, matrix.indices[spot].astype(np.int64), matrix.data[spot]
