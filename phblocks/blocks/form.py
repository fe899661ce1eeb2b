"""What a block reduces itself to: its matrices, ports and mass points in its own coordinates, and its read-outs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np

from phblocks.blocks.centreline import Centreline
from phblocks.blocks.hold import Hold
from phblocks.blocks.modulation import Modulation
from phblocks.blocks.storage import Storage
from phblocks.errors import DataError, UnknownNameError
from phblocks.frames import Attitude
from phblocks.ports import Anchor, Place
from phblocks.triplets import Floats, Ints, Triplets

#: Kind of energy of a state that stores none: a multiplier, or a state of a part without memory.
NO_ENERGY = "none"


#: Kind of energy of states that belong to the configuration, such as spans of lines: they move with velocities, and
#: what moves them is in ``Form.kinematics`` or follows from ``Form.lines``.
CONFIGURATION = "configuration"


#: What a picture may be coloured by: bending moment (N m), strain energy a length (J/m).
Profile = Literal["moment", "energy"]


@dataclass(frozen=True)
class StateRun:
    """Consecutive states of one component of one field.

    Parameters
    ----------
    field : str
        Field and component, such as ``"V1"``.
    unit : str
        SI unit.
    energy : str
        Kind of energy stored, such as ``"kinetic"`` or ``"strain"``; ``NO_ENERGY`` for a state with a row of
        zeros in E.
    positions : numpy.ndarray
        Place of each state along the block, shape (n,), m from its start.
    """

    field: str
    unit: str
    energy: str
    positions: Floats


@dataclass(frozen=True)
class AngleRows:
    """Orientation angles that depend on the rotation states of a block: ``reference + rows @ theta``.

    Parameters
    ----------
    rows : Triplets
        Shape (n, number of rotation states).
    reference : numpy.ndarray
        Shape (n,), rad: the initial angles.
    """

    rows: Triplets
    reference: Floats


#: The fixed frame of the diagram.
FIXED = AngleRows(Triplets.empty(), np.zeros(1))


@dataclass(frozen=True)
class Piece:
    """A part of what a port gives, in a frame of its own: ``Lambda(frame) output z`` in the fixed frame.

    Parameters
    ----------
    output : Triplets
        Shape (components, states); what the port takes enters the state equations through the transpose. Along a
        line, one row.
    frame : AngleRows, Attitude, Anchor or None
        Orientation of the frame, one row; in space its attitude; that of another anchor of the block; ``None`` for the
        port's own anchor, ``FIXED`` for the fixed frame.
    line : int or None
        The line of the block along which the output points, if it points along a line.
    """

    output: Triplets
    frame: AngleRows | Attitude | Anchor | None = None
    line: int | None = None


@dataclass(frozen=True)
class LineForm:
    """A line of action between two ports that take velocity.

    Parameters
    ----------
    start, end : str
        Names of the ports.
    span : int
        First of the two states that are the vector from start to end.
    free : float
        Length at zero force, m.
    stretch : (int, float) or None
        The state that adds to the length, and its factor; ``None`` if the length is that of the span.
    """

    start: str
    end: str
    span: int
    free: float = 0.0
    stretch: tuple[int, float] | None = None


@dataclass(frozen=True)
class PortForm:
    """A port in the coordinates of its block.

    Parameters
    ----------
    gives : bool
        It gives the common quantity (velocity) and takes the summed one (force).
    pieces : tuple of Piece
        What it gives is their sum; none if it gives nothing at all (the ground's velocity, a source's own force).
    """

    gives: bool
    pieces: tuple[Piece, ...]


@dataclass(frozen=True)
class MaterialPoints:
    """Points that carry mass and move with the block: gravity acts there and positions are known there.

    Parameters
    ----------
    mass : numpy.ndarray
        Shape (m,), kg.
    velocity : Triplets
        Shape (m * dimension, states): material velocity of each point, m/s.
    angle : AngleRows
        Orientation of the material frame at each point.
    start : numpy.ndarray
        Shape (m, dimension): initial positions, m.
    weighs : bool
        Gravity acts on them.
    """

    mass: Floats
    velocity: Triplets
    angle: AngleRows
    start: Floats
    weighs: bool = True


@dataclass(frozen=True)
class History:
    """What happened to one block: the input of its read-outs.

    Parameters
    ----------
    x : numpy.ndarray
        States, shape (times, states).
    theta : numpy.ndarray
        Rotation states, shape (times, rotation states), rad.
    points : numpy.ndarray or None
        Positions of the material points, shape (times, points, dimension), m; ``None`` if not tracked.
    """

    x: Floats
    theta: Floats
    points: Floats | None


@dataclass(frozen=True)
class Form:
    """A block as a port-Hamiltonian system in its own coordinates (equations in ``docs/notation.md``).

    ``E x' = (J0 + T x - R) z + sum over ports of output^T u``, with ``z = Q x`` and ``H = 1/2 x^T Q^T E x``.

    Parameters
    ----------
    size : int
        Number of states.
    runs : sequence of StateRun
        The states in their order.
    E, J0, R : Triplets
        Shape (size, size).  ``Q`` is the identity.
    T : Triplets
        Order three: ``J(x)[i, j] = J0[i, j] + sum_k T[i, j, k] x[k]``, skew in (i, j).
    ports : mapping of str to PortForm
        By name of the port.
    rotation_states : numpy.ndarray
        Indices of the states whose time integrals are the rotation states ``theta`` (zero at the start).
    orientations : mapping of str to AngleRows, Attitude or None
        By name of the anchor, one row; in space its attitude; ``None`` where the anchor takes its angular velocity, and
        with it its orientation, from elsewhere.
    points : MaterialPoints or None
        Where the block has mass.
    start : numpy.ndarray or None
        States at the start, shape (size,); ``None`` for zero (at rest, stress-free).
    lines : sequence of LineForm
        Lines of action that turn with what they join.
    loads : mapping of str to sequence of Piece
        What answers the exposures of the block's own whose port is no place to be joined at, by name of that port:
        an input u enters the state equations as the sum of ``output^T Lambda(frame)^T u``. For a load that follows
        the material frame is ``FIXED``.
    kinematics : Triplets
        Rates of the states of the configuration from the states, shape (size, size), those of lines left out.
    holds : sequence of Hold
        Which ports it holds together in position.
    storage : Storage or None
        The states whose energy is not quadratic, if there are any; E, J0, R, T and the outputs of ports do not act on
        its energy variables, and E not on its co-energy variables.
    modulation : Modulation or None
        Parts of J and R that depend on the energy variables of the storage, beside J0, T and R.
    frozen : bool
        Its frames keep their initial orientation, whatever its rotation states say: those are kept only to see how far
        it has turned.
    unoriented : bool
        Its frames turn in space, and how they stand then is not known: it has no points, and no weight.
    copies : numpy.ndarray
        For each of the first states the state without energy whose rows of J, T and outputs are the same, or -1;
        shape (0,) if there is none. In a damped beam it is the viscous part of a stress.
    """

    size: int
    runs: Sequence[StateRun]
    E: Triplets
    J0: Triplets
    R: Triplets
    T: Triplets
    ports: Mapping[str, PortForm]
    rotation_states: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    orientations: Mapping[str, AngleRows | Attitude | None] = field(default_factory=dict)
    points: MaterialPoints | None = None
    start: Floats | None = None
    lines: Sequence[LineForm] = ()
    loads: Mapping[str, Sequence[Piece]] = field(default_factory=dict)
    kinematics: Triplets = field(default_factory=Triplets.empty)
    holds: Sequence[Hold] = ()
    storage: Storage | None = None
    modulation: Modulation | None = None
    frozen: bool = False
    unoriented: bool = False
    copies: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))

    #: The place that positions rebuilt from strain are counted from.
    base: ClassVar[Place] = 0.0

    def place(self, s: object, where: str) -> Place:
        """Check what a user gives for a place on the block.

        Parameters
        ----------
        s : object
            The candidate.
        where : str
            What it is, for the message.

        Returns
        -------
        Place
            The place.

        Raises
        ------
        DataError
            If it is not a place on the block.
        """
        raise DataError(where, expected="a block with places", got=repr(s), fix="Ask for its states by name.")

    def cut_sign(self, place: Place) -> float | None:
        """Tell how the internal force at an end follows from the force on the block there.

        Parameters
        ----------
        place : Place
            Where on the block.

        Returns
        -------
        float or None
            +1 if they are the same, -1 if they are opposite, ``None`` where there is no end with an internal force.
        """
        return None

    def outline(self) -> Sequence[Place]:
        """List places in the order in which a line drawn through them shows the block.

        Returns
        -------
        sequence of Place
            None for a block without extension.
        """
        return ()

    def centreline(self) -> Centreline | None:
        """Describe the line that strain deforms, for checks of many blocks at once.

        Returns
        -------
        Centreline or None
            ``None`` for a block that no strain deforms.
        """
        return None

    def profile(self, history: History, quantity: Profile, places: Sequence[Place]) -> Floats | None:
        """Read a quantity along the block, to colour a picture by.

        Parameters
        ----------
        history : History
            Of this block.
        quantity : {"moment", "energy"}
            Bending moment, N m; strain energy a length, J/m.
        places : sequence of Place
            Where on the block.

        Returns
        -------
        numpy.ndarray or None
            Shape (times, places); ``None`` for a block that has no such quantity.
        """
        return None

    def velocity(self, history: History, place: Place) -> Floats:
        """Read the velocity of a place, in the material frame there.

        Parameters
        ----------
        history : History
            Of this block.
        place : Place
            Where on the block.

        Returns
        -------
        numpy.ndarray
            Shape (times, dimension), m/s.
        """
        return np.stack([self.value(history, f"V{i}", place) for i in (1, 2)], axis=1)

    def value(self, history: History, name: str, place: Place) -> Floats:
        """Read a component of a field at a place of the block.

        Parameters
        ----------
        history : History
            Of this block.
        name : str
            Field and component, such as ``"N1"``.
        place : Place
            Where on the block.

        Returns
        -------
        numpy.ndarray
            Shape (times,).

        Raises
        ------
        UnknownNameError
            If the block has no such field.
        """
        raise UnknownNameError("block", expected="a block with fields", got=name, fix="Read the states by name.")

    def angle(self, history: History, place: Place) -> Floats:
        """Read the orientation at a place of the block.

        Parameters
        ----------
        history : History
            Of this block.
        place : Place
            Where on the block.

        Returns
        -------
        numpy.ndarray
            Shape (times,), rad.

        Raises
        ------
        UnknownNameError
            If the block has no orientation.
        """
        raise UnknownNameError("block", expected="a block with orientation", got="none", fix="Ask another block.")

    def attitude(self, place: Place) -> Attitude | None:
        """Tell how a place of the block stands in space.

        Parameters
        ----------
        place : Place
            Where on the block.

        Returns
        -------
        Attitude or None
            ``None`` in the plane.
        """
        return None

    def position(self, history: History, place: Place) -> Floats:
        """Read the position integrated from velocities.

        Parameters
        ----------
        history : History
            Of this block, with points.
        place : Place
            Where on the block.

        Returns
        -------
        numpy.ndarray
            Shape (times, dimension), m.

        Raises
        ------
        UnknownNameError
            If the block has no position.
        """
        raise UnknownNameError("block", expected="a block with positions", got="none", fix="Ask another block.")

    def chord(self, history: History, first: Place, second: Place) -> Floats:
        """Rebuild the vector between two places from strain and orientation.

        Parameters
        ----------
        history : History
            Of this block.
        first, second : Place
            Where on the block.

        Returns
        -------
        numpy.ndarray
            From first to second, shape (times, dimension), m.

        Raises
        ------
        UnknownNameError
            If the block has no extension.
        """
        raise UnknownNameError("block", expected="a block with extension", got="none", fix="Ask another block.")

    def moving(self, velocity: Floats, spin: Floats, about: Floats) -> Floats:
        """Return the states of a rigid motion from the initial configuration.

        Parameters
        ----------
        velocity : numpy.ndarray
            Of the point ``about``, shape (dimension,), m/s, in the fixed frame.
        spin : numpy.ndarray
            Angular velocity, rad/s, shape () in the plane and (3,) in space, in the fixed frame.
        about : numpy.ndarray
            A point, shape (dimension,), m.

        Returns
        -------
        numpy.ndarray
            Shape (size,); zero for a block without velocities.
        """
        return np.zeros(self.size)

    def mean_chord(self, history: History) -> Floats:
        """Rebuild the vector from :attr:`base` to the centre of mass from strain and orientation.

        Parameters
        ----------
        history : History
            Of this block.

        Returns
        -------
        numpy.ndarray
            Shape (times, dimension), m.

        Raises
        ------
        UnknownNameError
            If the block has no extension.
        """
        raise UnknownNameError("block", expected="a block with extension", got="none", fix="Ask another block.")
