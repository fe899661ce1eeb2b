"""The material points of all blocks: where gravity acts and positions are known."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from phblocks.assembly.layout import Layout
from phblocks.blocks.form import AngleRows
from phblocks.frames import rotate
from phblocks.triplets import Floats, Triplets


@dataclass(frozen=True)
class Points:
    """The material points of all blocks, stacked.

    Parameters
    ----------
    mass : numpy.ndarray
        Shape (points,), kg; zero where gravity is left out.
    velocity : Triplets
        Shape (points * dimension, coordinates of all blocks).
    angle : AngleRows
        Orientation of each point, in rotation states of the layout.
    start : numpy.ndarray
        Shape (points, dimension), m.
    of_block : dict of str to slice
        The points of each block.
    """

    mass: Floats
    velocity: Triplets
    angle: AngleRows
    start: Floats
    of_block: dict[str, slice]

    @classmethod
    def of(cls, layout: Layout, names: Iterable[str] | None = None) -> Points:
        """Stack the points of blocks.

        Parameters
        ----------
        layout : Layout
            Numbering and orientations.
        names : iterable of str, optional
            Of the blocks; all by default.

        Returns
        -------
        Points
            In the order of the blocks.
        """
        d = layout.network.space.dimension
        mass, velocity, rows, reference, start = [np.empty(0)], [], [], [np.empty(0)], [np.empty((0, d))]
        of_block: dict[str, slice] = {}
        count = 0
        for name in layout.forms if names is None else names:
            points = layout.forms[name].points
            if points is None:
                continue
            of_block[name] = slice(count, count + points.mass.size)
            mass.append(points.mass * points.weighs)
            velocity.append(points.velocity.shifted(count * d, layout.first_state[name]))
            row, place = points.angle.rows.indices
            place = layout.theta_same[layout.first_theta[name] + place]
            rows.append(Triplets((row + count, place), points.angle.rows.values))
            reference.append(points.angle.reference)
            start.append(points.start)
            count += points.mass.size
        angle = AngleRows(Triplets.join(rows), np.concatenate(reference))
        return cls(np.concatenate(mass), Triplets.join(velocity), angle, np.concatenate(start), of_block)

    def weight(self, gravity: Floats, first_angle: int, n_angles: int) -> Triplets:
        """List the entries of K_g: mass times Lambda^T g at each point, as a force on the states.

        Parameters
        ----------
        gravity : numpy.ndarray
            Acceleration, shape (dimension,), m/s^2.
        first_angle : int
            Place of the angle of the first point among all angles.
        n_angles : int
            Number of all angles.

        Returns
        -------
        Triplets
            Shape (states, features).
        """
        row, state = self.velocity.indices
        point, component = row // gravity.size, row % gravity.size
        value = self.velocity.values * self.mass[point]
        row, state, point, component, value = (a[value != 0.0] for a in (row, state, point, component, value))
        turning = np.isin(point, self.angle.rows.indices[0])
        if not turning.all():
            still = ~turning
            fixed = rotate(-self.angle.reference[point[still]], gravity)[np.arange(still.sum()), component[still]]
            parts = [Triplets.of(state[still], 0, values=value[still] * fixed)]
            point, component, state = point[turning], component[turning], state[turning]
            value = value[turning]
        else:
            parts = []
        cos = Triplets.of(state, 1 + first_angle + point, values=value * gravity[component])
        back = np.zeros_like(gravity)
        back[:2] = gravity[1], -gravity[0]  # a quarter turn
        sin = Triplets.of(state, 1 + n_angles + first_angle + point, values=value * back[component])
        return Triplets.join([*parts, cos, sin])
