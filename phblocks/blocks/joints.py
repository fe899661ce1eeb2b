"""Joints as constraints with multipliers: their forces are states without energy."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from phblocks.blocks.branch import Lumped, lumped_form, state
from phblocks.blocks.checks import require_point
from phblocks.blocks.form import Form
from phblocks.errors import DataError
from phblocks.ports import ROTATION, TRANSLATION
from phblocks.space import PLANAR, Space
from phblocks.triplets import Floats


class _Joint(Lumped):
    """Two sides that both take velocity; ``directions`` are those along which they may not separate."""

    def __init__(self, name: str, directions: Floats, turns: bool) -> None:
        super().__init__(name)
        self._directions = directions
        self.first = self._add_port("first.translation", TRANSLATION)
        self.second = self._add_port("second.translation", TRANSLATION)
        self.turns = turns
        if not turns:
            self.first_rotation = self._add_port("first.rotation", ROTATION)
            self.second_rotation = self._add_port("second.rotation", ROTATION)

    @property
    def space(self) -> Space:
        """The plane."""
        return PLANAR

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the joint to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            Always false.

        Returns
        -------
        Form
            The forces of the joint on its second side, and the moment; no energy.
        """
        n = len(self._directions)
        runs = [state(f"force{i}" if n == 1 else f"force {'xy'[i]}", "N") for i in range(n)]
        size = n + (not self.turns)
        out = np.zeros((2, size))
        out[:, :n] = self._directions.T
        outputs = {"first.translation": (False, -out), "second.translation": (False, out)}
        if not self.turns:
            runs.append(state("moment", "N m"))
            turn = np.eye(size)[-1:]
            outputs |= {"first.rotation": (False, -turn), "second.rotation": (False, turn)}
        none = np.zeros((size, size))
        return lumped_form(self._ports, runs, none, none, none, outputs)


class RigidJoint(_Joint):
    """A pin or weld between two parts that both give velocity: ``0 = v_second - v_first`` with a multiplier.

    Made by ``pin(..., multiplier=True)`` and ``weld(..., multiplier=True)``. The joint force is a state without
    energy, in the fixed frame; with it the system is differential-algebraic of index 2.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    turns : bool, optional
        The sides may turn against each other (a pin); otherwise there is a moment too (a weld).

    Attributes
    ----------
    first, second : Port
        Of translation.
    """

    def __init__(self, name: str, turns: bool = True) -> None:
        super().__init__(name, np.eye(2), turns)


class Slider(_Joint):
    """A joint that leaves the second side free to move against the first along a direction of the fixed frame.

    Both sides give velocity; across the direction it is the same. The lateral force is a multiplier, and so is the
    moment if the sides must not turn against each other.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    direction : array_like
        (x, y), of any length but zero; fixed in space.
    turns : bool, optional
        The sides may turn against each other (by default), otherwise they keep their angle.

    Attributes
    ----------
    first, second : Port
        Of translation; ``first_rotation`` and ``second_rotation`` if the sides may not turn.

    Raises
    ------
    DataError
        If the direction is zero or not finite.
    ArgumentTypeError
        If it is not made of numbers.
    """

    def __init__(self, name: str, direction: ArrayLike, turns: bool = True) -> None:
        along = require_point(f"Slider {name!r} direction", direction)
        length = float(np.linalg.norm(along))
        if length == 0.0:
            raise DataError(f"Slider {name!r} direction", expected="a direction", got="(0, 0)", fix="Correct it.")
        super().__init__(name, np.array([[-along[1], along[0]]]) / length, turns)
