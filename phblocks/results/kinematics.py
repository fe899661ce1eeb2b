"""Positions rebuilt from strain and orientation, and how well joints stay closed.

From a place that is known (the ground, an imposed motion) positions are followed through the blocks,
``r(b) = r(a) + integral of Lambda (e1 + Gamma)``, along a spanning tree of the diagram. A part that hangs on
nothing known starts from its centre of mass, which the velocities give; so does what hangs on an imposed motion if the
run did not start in the initial configuration.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from phblocks.blocks.form import History
from phblocks.ports import Place
from phblocks.results.recording import Recording
from phblocks.system import Part, Site, System
from phblocks.triplets import Floats


@dataclass(frozen=True)
class Base:
    """A place of a block whose position is known.

    Parameters
    ----------
    place : Place
        On the block.
    position : numpy.ndarray
        Shape (times, dimension), m.
    """

    place: Place
    position: Floats


def history_of(system: System, recording: Recording, part: Part) -> History:
    """Cut the history of one block out of a recording.

    Parameters
    ----------
    system : System
        The system.
    recording : Recording
        Of a run of it.
    part : Part
        The block.

    Returns
    -------
    History
        For the read-outs of its form.
    """
    theta = part.turned(recording.theta)  # rotation states that were not kept are not asked for
    tracked = part.points.stop > part.points.start
    x = system.sharing.of_block(recording.x, part.states)
    return History(x, theta, recording.points[:, part.points] if tracked else None)


class Chords:
    """Vectors between places of a block, rebuilt from strain and orientation.

    Parameters
    ----------
    system : System
        The system.
    recording : Recording
        Of a run of it.
    """

    def __init__(self, system: System, recording: Recording) -> None:
        self.system, self.recording = system, recording
        self._histories: dict[str, History] = {}

    def history(self, part: Part) -> History:
        """Return the history of a block.

        Parameters
        ----------
        part : Part
            The block.

        Returns
        -------
        History
            Cut out once.
        """
        if part.name not in self._histories:
            self._histories[part.name] = history_of(self.system, self.recording, part)
        return self._histories[part.name]

    def between(self, part: Part, first: Place, second: Place) -> Floats:
        """Rebuild the vector between two places.

        Parameters
        ----------
        part : Part
            The block.
        first, second : Place
            On it.

        Returns
        -------
        numpy.ndarray
            From first to second, shape (times, dimension), m.
        """
        return part.form.chord(self.history(part), first, second)

    def to_centre(self, part: Part) -> Floats:
        """Rebuild the vector from the place positions are counted from to the centre of mass.

        Parameters
        ----------
        part : Part
            The block.

        Returns
        -------
        numpy.ndarray
            Shape (times, dimension), m.
        """
        return part.form.mean_chord(self.history(part))


def imposed_known(system: System, recording: Recording) -> bool:
    """Tell whether a run knows where imposed motions are: inputs are integrated since its start only.

    Parameters
    ----------
    system : System
        The system.
    recording : Recording
        Of a run of it.

    Returns
    -------
    bool
        False if it started elsewhere than in the initial configuration: how far they had come by then no state tells.
    """
    first, initial = recording.start, system.start
    pairs = [(first.points, initial.points), (first.theta, initial.theta)]
    if not initial.points.size:
        pairs.append((first.x[system.carries_energy], initial.x[system.carries_energy]))
    return all(np.array_equal(one, other) for one, other in pairs)


def held_at(system: System, site: Site, recording: Recording) -> list[Floats]:
    """Return where the ground or an imposed motion holds a site.

    Parameters
    ----------
    system : System
        The system.
    site : Site
        A place where anchors are joined.
    recording : Recording
        Of a run.

    Returns
    -------
    list of numpy.ndarray
        One of shape (times, dimension), m; none if nothing holds it, or if it is not known where.
    """
    if not site.known or (site.inputs and not imposed_known(system, recording)):
        return []
    return [site.held(recording.input_integral)]


def bases(chords: Chords) -> Mapping[str, Base]:
    """Find a known place on every block, along a spanning tree from the known sites.

    Parameters
    ----------
    chords : Chords
        Of a run.

    Returns
    -------
    mapping of str to Base
        By name of the block; blocks without extension are left out.
    """
    system, recording = chords.system, chords.recording
    found: dict[str, Base] = {}
    parts = {p.name: p for p in system.parts}
    at_block: dict[str, list[int]] = {}
    for number, site in enumerate(system.sites):
        for name, _ in site.places:
            at_block.setdefault(name, []).append(number)
    position: dict[int, Floats] = {}
    queue: list[int] = []

    def reach(number: int, where: Floats) -> None:
        if number not in position:
            position[number] = where
            queue.append(number)

    def follow() -> None:
        while queue:
            number = queue.pop(0)
            for name, place in system.sites[number].places:
                if name not in found:
                    settle(name, Base(place, position[number]))

    def settle(name: str, base: Base) -> None:
        found[name] = base
        for other in at_block.get(name, ()):
            place = next(p for n, p in system.sites[other].places if n == name)
            if other not in position:
                reach(other, base.position + chords.between(parts[name], base.place, place))

    for number, site in enumerate(system.sites):
        for held in held_at(system, site, recording):
            reach(number, held)
    follow()
    for part in system.parts:
        if part.name not in found and part.form.points is not None:
            if part.points.stop == part.points.start:
                continue
            mass = part.form.points.mass
            if not mass.any():
                continue
            centre = np.einsum("tmd,m->td", recording.points[:, part.points], mass) / mass.sum()
            settle(part.name, Base(part.form.base, centre - chords.to_centre(part)))
            follow()
    return found
