"""Joints as constraints with multipliers: their forces are states without energy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from phblocks.blocks.branch import Lumped, entries, lumped_form, state
from phblocks.blocks.checks import is_one_of, require_direction, require_flag, require_point
from phblocks.blocks.form import CONFIGURATION, Form, Piece, PortForm
from phblocks.blocks.hold import Hold
from phblocks.errors import DataError
from phblocks.frames import QUARTER
from phblocks.ports import ROTATION, TRANSLATION, Anchor
from phblocks.space import PLANAR, Space
from phblocks.triplets import Floats, Triplets

#: What the direction of a slider is fixed to.
GuideSide = Literal["fixed", "first"]


class _Joint(Lumped):
    """Two sides that both take velocity; ``directions`` are those along which they may not separate."""

    def __init__(self, name: str, directions: Floats, turns: bool, guided: bool = False) -> None:
        super().__init__(name)
        self._directions, self._guided = directions, guided
        if guided:
            # it turns with what it takes, and the vectors of both sides are in its frame
            self._guide = Anchor(self, "first", None)
            self.first, self.first_rotation = self._guide.ports
            self._ports += self._guide.ports
        else:
            self.first = self._add_port("first.translation", TRANSLATION)
            if not turns:
                self.first_rotation = self._add_port("first.rotation", ROTATION)
        self.second = self._add_port("second.translation", TRANSLATION)
        if not turns:
            self.second_rotation = self._add_port("second.rotation", ROTATION)
        self.turns = turns

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
            The forces of the second side on the joint, and the moment; no energy.
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
        form = lumped_form(self._ports, runs, none, none, none, outputs)
        return replace(form, holds=(Hold(self.first.name, self.second.name, self._directions),))


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
        super().__init__(name, np.eye(2), require_flag(f"RigidJoint {name!r} turns", turns))


class Slider(_Joint):
    """A joint that leaves the second side free to move against the first along a direction.

    Both sides give velocity; across the direction it is the same. The lateral force is a multiplier, and so is the
    moment if the sides must not turn against each other. The direction is fixed in space, or it is that of a guide on
    the first side and turns with it: then the force at a distance from the first side is a moment on the guide.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    direction : array_like
        (x, y), of any length but zero; as it is in the initial configuration.
    turns : bool, optional
        The sides may turn against each other (by default), otherwise they keep their angle.
    guide : {"fixed", "first"}, optional
        What the direction is fixed to: space (by default), or the first side.
    start, end : array_like, optional
        Initial places of the first and second side, shape (2,), m; needed for a guide on the first side, which has
        to know how far along it the second side is, and checked against the places of what is joined there.

    Attributes
    ----------
    first, second : Port
        Of translation.
    first_rotation, second_rotation : Port
        Of rotation, both if the sides may not turn; the first also if the guide turns with it.

    Raises
    ------
    DataError
        If the direction is zero or not finite, or a place is missing.
    ArgumentTypeError
        If it is not made of numbers.

    Notes
    -----
    With the unit vectors t along and n across the guide, which turns with w_1, and the distance s along it,

        0 = n . (v_2 - v_1) - w_1 s,    s' = t . (v_2 - v_1) + w_1 d,

    where d is the distance across, a constant. The force ``n f`` on the second side is ``-n f`` on the first, with the
    moment ``-s f``: the power of the three is f times the constraint, so zero. Under the midpoint rule the place of
    the second side in the frame of the guide, (s, d), satisfies the constraint to round-off.
    """

    def __init__(
        self,
        name: str,
        direction: ArrayLike,
        turns: bool = True,
        guide: GuideSide = "fixed",
        start: ArrayLike | None = None,
        end: ArrayLike | None = None,
    ) -> None:
        self._along = require_direction(f"Slider {name!r} direction", direction)
        if not is_one_of(guide, ("fixed", "first")):
            raise DataError(
                f"Slider {name!r} guide", expected='"fixed" or "first"', got=repr(guide), fix="Choose one of them."
            )
        super().__init__(name, (QUARTER @ self._along)[None], turns, guided=guide == "first")
        self._start, self._end = (
            None if place is None else require_point(f"Slider {name!r} {side}", place)
            for side, place in (("start", start), ("end", end))
        )
        if guide == "first" and (self._start is None or self._end is None):
            raise DataError(
                f"Slider {name!r}",
                expected="the places start and end, for a guide that turns",
                got=f"start {start!r} and end {end!r}",
                fix="Give the initial places of its two sides.",
            )

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the slider to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            Always false.

        Returns
        -------
        Form
            The lateral force of the second side on the joint, and the moment. For a guide that turns also: the force
            along it, which is zero, the moment of the guide on the joint, its angular velocity, the velocity of the
            second side along it and its distance from the first.
        """
        hold = Hold(self.first.name, self.second.name, self._directions, self._guided, self._start, self._end)
        if not self._guided:
            return replace(super().form(gives), holds=(hold,))
        assert self._start is not None and self._end is not None
        across, along, turning, spin, slide, distance = range(6)
        span = self._end - self._start
        offset = float(self._directions[0] @ span)
        runs = [state("force across", "N"), state("force along", "N"), state("moment of guide", "N m")]
        runs += [state("angular velocity", "rad/s"), state("velocity along", "m/s")]
        runs.append(state("distance", "m", CONFIGURATION))
        if not self.turns:
            runs.append(state("moment", "N m"))
        n = len(runs)
        # 0 = t . (v_2 - v_1) + w d - slide,  0 = w_1 - w,  and their transposes in the rows of slide and w
        J = np.zeros((n, n))
        J[along, slide], J[along, spin], J[turning, spin] = -1.0, offset, -1.0
        force, moment = np.zeros((2, n)), np.eye(n)[[turning]]
        force[:, across], force[:, along] = self._directions[0], self._along
        outputs = {self.first.name: -force, self.second.name: force}
        if not self.turns:
            lock = np.eye(n)[-1:]
            moment = moment - lock
            outputs[self.second_rotation.name] = lock
        outputs[self.first_rotation.name] = moment
        start = np.zeros(n)
        start[distance] = self._along @ span
        return Form(
            size=n,
            runs=runs,
            E=Triplets.empty(),
            J0=entries(J - J.T),
            R=Triplets.empty(),
            # 0 = n . (v_2 - v_1) - s w, and f s in the row of w
            T=Triplets.of([across, spin], [spin, across], distance, values=[-1.0, 1.0]),
            ports={name: PortForm(False, (Piece(entries(out), self._guide),)) for name, out in outputs.items()},
            orientations={p.anchor.name: None for p in self._ports if p.anchor is not None},
            start=start,
            kinematics=Triplets.of([distance], [slide], values=1.0),
            holds=(hold,),
        )
