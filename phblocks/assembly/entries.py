"""Entries of joints and inputs as they are collected, and the numbering of the features they go with."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from phblocks.frames import Turn
from phblocks.ports import Port
from phblocks.triplets import Triplets


@dataclass
class Entries:
    """Entries (row, column, feature) as they are collected.

    Preliminary numbers of features: 0 is the constant, 1 + 2m is cos alpha_m, 2 + 2m is sin alpha_m, and negative
    ones are directions.

    Parameters
    ----------
    turns : list of Turn
        The angles alpha_m.
    directions : list of (int, Turn)
        Line and frame of each direction.
    K, K_u, kinematics, kinematics_u : list of Triplets
        What becomes of the matrices of the system with these names, in coordinates of blocks.
    pairs : list of (Port, Port)
        The giving and the taking port of each connection.
    flows : list of list of Triplets
        The entries that carry power across each.
    """

    turns: list[Turn] = field(default_factory=list)
    directions: list[tuple[int, Turn]] = field(default_factory=list)
    K: list[Triplets] = field(default_factory=list)
    K_u: list[Triplets] = field(default_factory=list)
    kinematics: list[Triplets] = field(default_factory=list)
    kinematics_u: list[Triplets] = field(default_factory=list)
    pairs: list[tuple[Port, Port]] = field(default_factory=list)
    flows: list[list[Triplets]] = field(default_factory=list)


def direction_feature(number: int, component: int) -> int:
    """Number the feature of a direction, preliminarily.

    Parameters
    ----------
    number : int
        Of the direction.
    component : int
        0 or 1.

    Returns
    -------
    int
        Negative.
    """
    return -1 - 2 * number - component


def with_feature(entries: Triplets, feature: int) -> Triplets:
    """Let the entries of a matrix go with a feature.

    Parameters
    ----------
    entries : Triplets
        Of order two.
    feature : int
        Its number.

    Returns
    -------
    Triplets
        Of order three.
    """
    return Triplets((*entries.indices, np.full(entries.values.size, feature)), entries.values)


def number_features(entries: Triplets, n_angles: int, n_directions: int) -> Triplets:
    """Number features finally: the constant, all cosines, all sines, first and second components of directions.

    Parameters
    ----------
    entries : Triplets
        With preliminary numbers.
    n_angles, n_directions : int
        How many there are.

    Returns
    -------
    Triplets
        With final ones.
    """
    i, j, f = entries.indices
    turn, line = f - 1, -f - 1
    number = np.where(
        f > 0,
        1 + (turn % 2) * n_angles + turn // 2,
        np.where(f < 0, 1 + 2 * n_angles + (line % 2) * n_directions + line // 2, 0),
    )
    return Triplets((i, j, number), entries.values)


def split_constant(entries: Triplets) -> tuple[Triplets, Triplets]:
    """Split entries into those of the constant feature, of order two, and the others.

    Parameters
    ----------
    entries : Triplets
        Of order three.

    Returns
    -------
    constant, others : Triplets
        Of order two and three.
    """
    still = entries.indices[2] == 0
    i, j, f = entries.indices
    return (
        Triplets((i[still], j[still]), entries.values[still]),
        Triplets((i[~still], j[~still], f[~still]), entries.values[~still]),
    )
