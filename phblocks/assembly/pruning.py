"""What of a diagram is computed: the components that its excitations reach, and the angles that they turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from phblocks.assembly.entries import Entries
from phblocks.assembly.layout import Layout
from phblocks.assembly.points import Points
from phblocks.assembly.reachable import Reach, find_reach
from phblocks.blocks.form import NO_ENERGY, AngleRows
from phblocks.frames import Turn, snapped
from phblocks.system import Sharing
from phblocks.triplets import Floats, Ints, Triplets

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Kept:
    """What is computed.

    Parameters
    ----------
    dropped : numpy.ndarray
        For each coordinate of the blocks whether it stays what it is.
    still : numpy.ndarray
        For each rotation state whether it stays zero.
    reach : Reach or None
        The proof; ``None`` if nothing was to be left out, or nothing excites the diagram.
    why : str
        Why everything is computed, if it is.
    """

    dropped: Mask
    still: Mask
    reach: Reach | None
    why: str = ""

    @property
    def quiet(self) -> Ints:
        """Inputs that are taken to be zero and must stay so."""
        return np.empty(0, dtype=np.int64) if self.reach is None else self.reach.quiet()

    @property
    def held(self) -> Ints:
        """Coordinates of the configuration that are kept though nothing moves them."""
        if self.reach is None:
            return np.empty(0, dtype=np.int64)
        components = self.reach.components
        held = components.configuration & ~self.reach.reached.mask[self.reach.moving]
        return np.flatnonzero(held[components.of_coordinate] & ~self.dropped)

    def entries(self, entries: Triplets, axes: Sequence[int], turns: Sequence[Turn]) -> tuple[Triplets, Ints]:
        """Leave out entries of what is dropped, and make features constant that stay as they are.

        Parameters
        ----------
        entries : Triplets
            Of order three, with preliminary numbers of features.
        axes : sequence of int
            Those that count coordinates.
        turns : sequence of Turn
            All angles at joints.

        Returns
        -------
        entries : Triplets
            Those that are left.
        number : numpy.ndarray
            Which ones.
        """
        left = ~np.any([self.dropped[entries.indices[axis]] for axis in axes], axis=0)
        *places, feature = entries.indices
        values = entries.values
        fixed = np.array([self.still[list(turn.places)].all() for turn in turns], dtype=bool)
        if fixed.any():
            phi = np.array([snapped(float(f(t.reference))) for t in turns for f in (np.cos, np.sin)])
            constant = np.zeros(feature.size, dtype=bool)
            turning = feature > 0
            constant[turning] = fixed[(feature[turning] - 1) // 2]
            values = values.copy()
            values[constant] *= phi[feature[constant] - 1]
            feature = np.where(constant, 0, feature)
            left &= values != 0.0
        number = np.flatnonzero(left)
        return Triplets((*(axis[left] for axis in places), feature[left]), values[left]), number

    def joints(self, joints: Entries) -> tuple[Entries, Ints]:
        """Leave out what joints contribute to what is dropped; number the angles and directions that are left.

        Parameters
        ----------
        joints : Entries
            As collected.

        Returns
        -------
        joints : Entries
            With flows in one list.
        number : numpy.ndarray
            Connection of each entry of the flows.
        """
        sizes = [sum(part.values.size for part in flow) for flow in joints.flows]
        number = np.repeat(np.arange(len(sizes)), sizes)
        flows = Triplets.join([part for flow in joints.flows for part in flow], order=3)
        given = {
            "K": (Triplets.join(joints.K, order=3), (0, 1)),
            "K_u": (Triplets.join(joints.K_u, order=3), (0,)),
            "kinematics": (Triplets.join(joints.kinematics, order=3), (0, 1)),
            "kinematics_u": (Triplets.join(joints.kinematics_u, order=3), (0,)),
        }
        if self.reach is None:
            K, K_u, rates, rates_u = ([entries] for entries, _ in given.values())
            return (
                Entries(joints.turns, joints.directions, K, K_u, rates, rates_u, joints.pairs, [[flows]]),
                number,
            )
        left = {name: self.entries(entries, axes, joints.turns)[0] for name, (entries, axes) in given.items()}
        flows, kept = self.entries(flows, (0, 1), joints.turns)
        used = np.concatenate([entries.indices[2] for entries in (*left.values(), flows)])
        turns, directions = np.unique((used[used > 0] - 1) // 2), np.unique((-used[used < 0] - 1) // 2)

        def renumbered(entries: Triplets) -> Triplets:
            i, j, f = entries.indices
            by_turn = 1 + 2 * np.searchsorted(turns, (f - 1) // 2) + (f - 1) % 2
            by_direction = -1 - 2 * np.searchsorted(directions, (-f - 1) // 2) - (-f - 1) % 2
            return Triplets((i, j, np.where(f > 0, by_turn, np.where(f < 0, by_direction, 0))), entries.values)

        fewer = Entries(
            turns=[joints.turns[m] for m in turns],
            directions=[joints.directions[d] for d in directions],
            pairs=joints.pairs,
            flows=[[renumbered(flows)]],
            **{name: [renumbered(entries)] for name, entries in left.items()},
        )
        return fewer, number[kept]

    def points(self, points: Points) -> Points:
        """Hold the angles of material points that do not turn.

        Parameters
        ----------
        points : Points
            Of all blocks.

        Returns
        -------
        Points
            The same ones.
        """
        if not self.still.any():
            return points
        rows = points.angle.rows
        turning = ~self.still[rows.indices[1]]
        rows = Triplets(tuple(axis[turning] for axis in rows.indices), rows.values[turning])
        return replace(points, angle=AngleRows(rows, points.angle.reference))


def everything(layout: Layout, why: str) -> Kept:
    """Leave nothing out.

    Parameters
    ----------
    layout : Layout
        Of the diagram.
    why : str
        The reason, for the report.

    Returns
    -------
    Kept
        All coordinates and rotation states.
    """
    return Kept(np.zeros(layout.n, dtype=bool), np.zeros(layout.n_theta, dtype=bool), None, why)


def prune(layout: Layout, joints: Entries, points: Points, gravity: Floats, sharing: Sharing) -> Kept:
    """Leave out what no excitation reaches; nothing if nothing at all is excited.

    Parameters
    ----------
    layout : Layout
        Numbering and orientations.
    joints : Entries
        Of joints and inputs.
    points : Points
        The material points that gravity acts on; none without gravity.
    gravity : numpy.ndarray
        Acceleration, m/s^2.
    sharing : Sharing
        Of the states, with none left out.

    Returns
    -------
    Kept
        With its proof.
    """
    reach = find_reach(layout, joints, points, gravity, sharing)
    if not reach.anything:
        return everything(layout, "nothing excites the diagram: computed as a whole, for a start or for modes")
    dropped = reach.dropped()[reach.components.of_coordinate]
    return Kept(dropped, ~reach.reached.mask[reach.theta], reach)


def hides_multipliers(layout: Layout, kept: Kept) -> bool:
    """Tell whether states are left out that neither store nor lose: constraints among them are to be checked first.

    Parameters
    ----------
    layout : Layout
        Numbering and orientations.
    kept : Kept
        What is computed.

    Returns
    -------
    bool
        False for a diagram without multipliers, transformers and the like in what is left out.
    """
    if not kept.dropped.any():
        return False
    for name, form in layout.forms.items():
        out = kept.dropped[layout.first_state[name] : layout.first_state[name] + form.size]
        if not out.any():
            continue
        bare = np.repeat([run.energy == NO_ENERGY for run in form.runs], [run.positions.size for run in form.runs])
        bare[form.R.indices[0]] = False
        if (bare & out).any():
            return True
    return False
