"""What a system is made of besides matrices: its state, its blocks, inputs, connections and joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from phblocks.blocks.block import Block
from phblocks.blocks.form import Form
from phblocks.ports import Place, Quantity
from phblocks.system.exchange import Exchange
from phblocks.triplets import Floats, Ints, Triplets

#: Place of a rotation state that is not kept, and of one that is proven to stay zero.
DROPPED, STILL = -1, -2


@dataclass(frozen=True)
class State:
    """Everything that evolves.

    Parameters
    ----------
    x : numpy.ndarray
        Energy states, shape (n,).
    theta : numpy.ndarray
        Rotation states, shape (n_theta,), rad: turned since the start.
    points : numpy.ndarray
        Positions of the tracked material points, shape (n_points, dimension), m.
    """

    x: Floats
    theta: Floats
    points: Floats

    def __repr__(self) -> str:
        """Count what is in it."""
        return f"<State: {self.x.size} energy states, {self.theta.size} rotations, {len(self.points)} points>"


@dataclass(frozen=True)
class Part:
    """A block in the system.

    Parameters
    ----------
    block : Block
        The block.
    form : Form
        Its matrices and read-outs in its own coordinates.
    states : slice
        Its coordinates among those of all blocks: its states in x, unless blocks share states (``system.sharing``).
    theta : numpy.ndarray
        For each of its rotation states the place in theta, :data:`DROPPED` if it is not kept, :data:`STILL` if it
        stays zero.
    points : slice
        Its material points among the tracked ones; empty if they are not tracked.
    """

    block: Block
    form: Form
    states: slice
    theta: Ints
    points: slice

    @property
    def name(self) -> str:
        """Of the block."""
        return self.block.name

    @property
    def angles_known(self) -> bool:
        """Whether its rotation states are kept, or known to stay zero."""
        return bool((self.theta != DROPPED).all())

    def turned(self, theta: Floats) -> Floats:
        """Take its rotation states out of those of the system.

        Parameters
        ----------
        theta : numpy.ndarray
            Rotation states of the system, shape (times, n_theta), rad.

        Returns
        -------
        numpy.ndarray
            Shape (times, rotation states of the block), rad; zero for those that stay zero or are not kept.
        """
        kept = self.theta >= 0
        turned = np.zeros((len(theta), self.theta.size))
        turned[:, kept] = theta[:, self.theta[kept]]
        return turned


@dataclass(frozen=True)
class Input:
    """One scalar input with its conjugate output.

    Parameters
    ----------
    name : str
        Of both; components end in ".x", ".y".
    imposed : Quantity
        What the outside imposes: the input u.
    answered : Quantity
        What it gets back: the output y; y times u is the power supplied.
    exposure : str
        Name given in ``expose``.
    common : bool
        The outside imposes the common quantity (a velocity), not the summed one.
    signal : callable, array_like or None
        What is imposed if the simulation is given nothing else; of the whole exposure.
    """

    name: str
    imposed: Quantity
    answered: Quantity
    exposure: str
    common: bool
    signal: Callable[[float], ArrayLike] | ArrayLike | None = None


@dataclass(frozen=True)
class Site:
    """A place where anchors are joined.

    Parameters
    ----------
    name : str
        The paths of the anchors.
    places : tuple of (str, Place)
        Block and place on it, for each anchor that is not the ground's.
    start : numpy.ndarray
        Initial position, shape (dimension,), m.
    known : bool
        The position does not depend on any block: the ground, or an imposed velocity.
    inputs : tuple of int
        The inputs that impose the velocity, if any.
    """

    name: str
    places: tuple[tuple[str, Place], ...]
    start: Floats
    known: bool
    inputs: tuple[int, ...] = ()

    def held(self, moved: Floats) -> Floats:
        """Return where the ground or an imposed motion holds it.

        Parameters
        ----------
        moved : numpy.ndarray
            Time integrals of all inputs, shape (..., n_inputs).

        Returns
        -------
        numpy.ndarray
            Shape (..., dimension), m.
        """
        shift = moved[..., list(self.inputs)] if self.inputs else np.zeros((*moved.shape[:-1], self.start.size))
        return np.asarray(self.start + shift)


@dataclass(frozen=True)
class Guide:
    """Two places that are held together across some directions only, and free along the others.

    Parameters
    ----------
    name : str
        Of the block that holds them.
    first, second : Site
        The two places.
    across : numpy.ndarray
        The directions, shape (directions, dimension), of length one.
    anchor : str or None
        Path of the anchor that the directions turn with; ``None`` if they are fixed in space.
    """

    name: str
    first: Site
    second: Site
    across: Floats
    anchor: str | None


@dataclass(frozen=True)
class Connections:
    """Power flows between blocks: what each taking port does at a junction, entry by entry.

    Parameters
    ----------
    names : tuple of tuple of str
        (giving port, taking port) of each connection.
    blocks : numpy.ndarray
        Shape (n_connections, 2): number of the giving and of the taking block.
    number : numpy.ndarray
        Connection of each entry.
    entries : Triplets
        Order three (row, column, feature): rows are coordinates of the taking block, columns of the giving one; the
        negative transpose is the reaction.
    supply : Triplets
        Order three (row, input, feature): what the outside does to the coordinates of blocks.
    exchange : Exchange
        The same powers from the ports alone.
    """

    names: tuple[tuple[str, str], ...]
    blocks: Ints
    number: Ints
    entries: Triplets
    supply: Triplets
    exchange: Exchange
