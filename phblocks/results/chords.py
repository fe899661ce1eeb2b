"""Chords of all blocks that strain deforms, at many times at once: a few sparse products for the whole system.

Of a line of length L with points s, positions r and tangents t, two vectors of the same motion are compared:

    12/L^2 * integral of (s - L/2) r ds  =  6/L^2 * integral of s (L - s) t ds        (by parts; the chord if straight)

the left one from positions integrated from velocity, the right one from strain and orientation; and so are two centres.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from phblocks.errors import UnknownNameError
from phblocks.frames import rotate
from phblocks.results.gaps import joint_gaps
from phblocks.results.kinematics import Base, Chords, bases, held_at, imposed_known
from phblocks.results.recording import Recording
from phblocks.triplets import Floats, Ints, Triplets

if TYPE_CHECKING:
    from phblocks.ports import Place
    from phblocks.system import Part, Site, System

#: A line ends this far from its start.
ENDS = (0.0, 1.0)


@dataclass(frozen=True)
class Lines:
    """Constant matrices of the centrelines of a system, one below the other.

    Parameters
    ----------
    names : tuple of str
        The blocks.
    strain : tuple of scipy.sparse.csr_array
        For each direction, of all coordinates.
    spin, lean : scipy.sparse.csr_array
        Of the rotation states of the system, and of all coordinates.
    reference : numpy.ndarray
        Angles at the start, rad.
    chord, slope, centre : scipy.sparse.csr_array
        Sums of tangents by block: from end to end, the right-hand side above, from the start to the centre.
    points : numpy.ndarray
        Material points of the blocks.
    slope_of_points, centre_of_points : scipy.sparse.csr_array
        The left-hand side above, and the mean, of their positions.
    """

    names: tuple[str, ...]
    strain: tuple[sp.csr_array, ...]
    spin: sp.csr_array
    lean: sp.csr_array
    reference: Floats
    chord: sp.csr_array
    slope: sp.csr_array
    centre: sp.csr_array
    points: Ints
    slope_of_points: sp.csr_array
    centre_of_points: sp.csr_array

    @classmethod
    def of(cls, system: System) -> Lines:
        """Make them, or find those that were made before.

        Parameters
        ----------
        system : System
            The system.

        Returns
        -------
        Lines
            Kept with the system.
        """
        known = system.prepared.get("centrelines")
        if not isinstance(known, cls):
            known = system.prepared["centrelines"] = cls._made(system)
        return known

    @classmethod
    def _made(cls, system: System) -> Lines:
        parts = [p for p in system.parts if p.angles_known and not p.form.frozen]
        found = [(part, line) for part in parts if (line := part.form.centreline()) is not None]
        first = np.cumsum([0, *(line.place.size for _, line in found)])
        rows, size = int(first[-1]), system.sharing.constant.size

        def stacked(which: str, number: int = 0) -> sp.csr_array:
            entries = []
            for (part, line), at in zip(found, first, strict=False):
                own: Triplets = line.strain[number] if which == "strain" else getattr(line, which)
                if which != "spin":
                    entries.append(own.shifted(int(at), part.states.start))
                    continue
                place = part.theta[own.indices[1]]
                kept = place >= 0
                entries.append(Triplets((own.indices[0][kept] + at, place[kept]), own.values[kept]))
            return Triplets.join(entries).csr((rows, system.start.theta.size if which == "spin" else size))

        lines = [line for _, line in found]
        s, weight, arm, kernel = (
            np.concatenate([np.zeros(0), *(getattr(line, key) for line in lines)])
            for key in ("place", "weight", "arm", "kernel")
        )
        block = np.repeat(np.arange(len(lines)), np.diff(first))
        L = np.array([line.length for line in lines])[block]

        def summed(factors: Floats) -> sp.csr_array:
            return Triplets.of(block, np.arange(rows), values=factors).csr((len(lines), rows))

        points = [np.arange(part.points.start, part.points.stop) for part, _ in found]
        return cls(
            tuple(part.name for part, _ in found),
            tuple(stacked("strain", d) for d in range(system.dimension)),
            stacked("spin"),
            stacked("lean"),
            np.concatenate([np.zeros(0), *(line.reference for line in lines)]),
            summed(weight),
            summed(12.0 / L**2 * weight * kernel),
            summed(weight * (1.0 - s / L)),
            np.concatenate([np.zeros(0, dtype=np.int64), *points]),
            summed(12.0 / L**2 * weight * (arm - 0.5 * L)),
            summed(weight / L),
        )


class AllChords(Chords):
    """Chords from end to end of all blocks at once; others block by block.

    Parameters
    ----------
    system : System
        The system.
    recording : Recording
        Of a run of it.
    """

    def __init__(self, system: System, recording: Recording) -> None:
        super().__init__(system, recording)
        self.lines = lines = Lines.of(system)
        self._number = {name: i for i, name in enumerate(lines.names)}
        x = system.sharing.expand(recording.x).T
        self._angle = angle = lines.reference + (lines.spin @ recording.theta.T + lines.lean @ x).T
        strain = np.stack([(rows @ x).T for rows in lines.strain], axis=-1)
        strain[..., 0] += 1.0
        self._tangents = rotate(angle, strain)
        self._chord = self.summed(lines.chord)

    def summed(self, rows: sp.csr_array) -> Floats:
        """Sum tangents by block.

        Parameters
        ----------
        rows : scipy.sparse.csr_array
            Shape (blocks, m).

        Returns
        -------
        numpy.ndarray
            Shape (times, blocks, dimension), m.
        """
        return _by_block(rows, self._tangents)

    def between(self, part: Part, first: Place, second: Place) -> Floats:
        """Rebuild the vector between two places; see :meth:`Chords.between`."""
        if first == second:
            return np.zeros((self.recording.t.size, self.system.dimension))
        if part.name in self._number and first in ENDS and second in ENDS:
            chord = self._chord[:, self._number[part.name]]
            return chord if second == ENDS[1] else -chord
        return super().between(part, first, second)

    def gaps(self) -> tuple[Mapping[str, Floats], Mapping[str, Floats]]:
        """Compare strain with configuration by block, and what joints join.

        Returns
        -------
        blocks : mapping of str to numpy.ndarray
            For each block that strain deforms the larger of the gaps at its two ends, shape (times,), m: that of the
            centre plus and minus half of that of the chord, beyond what they are in the initial configuration. Empty if
            positions were not kept.
        joints : mapping of str to numpy.ndarray
            See :meth:`phblocks.results.solution.Solution.closure`.
        """
        system, recording = self.system, self.recording
        base = bases(self)

        def spots(site: Site) -> list[Floats]:
            return [
                base[name].position + self.between(system.part(name), base[name].place, place)
                for name, place in site.places
            ] + held_at(system, site, recording)

        joints: Mapping[str, Floats] = {}
        with suppress(KeyError, UnknownNameError):  # of a block nothing is known that orientation or place follows from
            joints = joint_gaps(system, recording, spots)
        parted, blocks = self._parted(base), {}
        if parted:
            initially, turned = self._initially()
            number = self._number
            for name, both in parted.items():
                # before anything moves it is what quadrature makes of an arc, and it turns with the block
                turn = np.broadcast_to(self.turned[number[name]] - turned[number[name]], both.shape[:2])
                defect = rotate(turn, np.broadcast_to(initially[name], both.shape))
                blocks[name] = np.linalg.norm(both - defect, axis=2).max(axis=0)
        return blocks, joints

    @property
    def turned(self) -> Floats:
        """Mean orientations of the blocks, shape (blocks, times), rad."""
        weights = self.lines.chord
        mean: Floats = np.asarray(weights @ self._angle.T) / np.asarray(weights.sum(axis=1))[:, None]
        return mean

    def _parted(self, base: Mapping[str, Base]) -> dict[str, Floats]:
        """How far positions and strain are apart at both ends of each block, shape (2, times, dimension), m."""
        system, lines = self.system, self.lines
        if lines.points.size != lines.reference.size or not lines.names:
            return {}
        places = self.recording.points[:, lines.points]
        half = 0.5 * (_by_block(lines.slope_of_points, places) - self.summed(lines.slope))
        centre, mean = self.summed(lines.centre), _by_block(lines.centre_of_points, places)
        parted = {}
        for b, name in enumerate(lines.names):
            if name in base:
                start = base[name].position + self.between(system.part(name), base[name].place, ENDS[0])
                off = mean[:, b] - start - centre[:, b]
                parted[name] = np.stack([off - half[:, b], off + half[:, b]])
        return parted

    def _initially(self) -> tuple[dict[str, Floats], Floats]:
        """The same in the initial configuration, and how it is turned; kept with the system."""
        system, recording = self.system, self.recording
        key = f"centrelines at the start, imposed motions known: {imposed_known(system, recording)}"
        if key not in system.prepared:
            start = system.start
            once = replace(
                recording.sliced(np.zeros(1, dtype=np.int64)),
                x=start.x[None],
                theta=start.theta[None],
                points=start.points[None],
                input_integral=np.zeros((1, system.n_inputs)),
            )
            chords = AllChords(system, once)
            system.prepared[key] = chords._parted(bases(chords)), chords.turned
        known: tuple[dict[str, Floats], Floats] = system.prepared[key]  # type: ignore[assignment]
        return known


def position_gaps(system: System, recording: Recording) -> tuple[Mapping[str, Floats], Mapping[str, Floats]]:
    """Measure how far strain and configuration part, and joints open; see :meth:`AllChords.gaps`.

    Parameters
    ----------
    system : System
        The system.
    recording : Recording
        Of a run of it.

    Returns
    -------
    blocks, joints : mapping of str to numpy.ndarray
        Shape (times,), m; empty where positions or orientations are not known.
    """
    try:
        return AllChords(system, recording).gaps()
    except UnknownNameError:  # a chord on the way is not known
        return {}, {}


def _by_block(rows: sp.csr_array, vectors: Floats) -> Floats:
    """Weighted sums over points, for all times and components: shape (times, blocks, dimension)."""
    t, m, d = vectors.shape
    flat = vectors.transpose(1, 0, 2).reshape(m, t * d)
    return np.asarray(rows @ flat).reshape(-1, t, d).transpose(1, 0, 2)
