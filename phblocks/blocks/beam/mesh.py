"""Elements of a beam and the numbering of its states, with the switch between two causalities.

A field pair whose ends differ in causality switches at one interior element boundary: left of it one variant of
the pair, right of it the other.  A pair whose ends agree runs through and stays continuous there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from phblocks.blocks.beam.spaces import Basis
from phblocks.blocks.beam.tensors import Variant, field_basis, present_components
from phblocks.blocks.form import StateRun
from phblocks.space import Space
from phblocks.triplets import Floats, Ints

UNITS = {"V": "m/s", "W": "rad/s", "N": "N", "M": "N m"}
ENERGIES = {"V": "kinetic", "W": "kinetic", "N": "strain", "M": "strain"}


@dataclass(frozen=True)
class Segment:
    """Elements that share a variant.

    Parameters
    ----------
    first, last : int
        Elements ``first <= e < last``.
    variant : Variant
        Which side of each pair is continuous in them.
    """

    first: int
    last: int
    variant: Variant


@dataclass(frozen=True)
class Mesh:
    """Numbered states of a beam.

    Parameters
    ----------
    boundaries : numpy.ndarray
        Shape (elements + 1,): places of the element boundaries, m from the start.
    degree : int
        k of the pairs CG_k, DG_{k-1}.
    segments : sequence of Segment
        One, or two if a pair switches.
    space : Space
        Which components are present.
    states : sequence of mapping
        For each segment, component -> numbers of the states, shape (elements, functions).
    runs : sequence of StateRun
        All states in their order.
    """

    boundaries: Floats
    degree: int
    segments: Sequence[Segment]
    space: Space
    states: Sequence[Mapping[tuple[str, int], Ints]]
    runs: Sequence[StateRun]

    @property
    def lengths(self) -> Floats:
        """Length of each element, m."""
        return np.diff(self.boundaries)

    @property
    def size(self) -> int:
        """Number of states."""
        return sum(run.positions.size for run in self.runs)

    def basis(self, segment: int, field: str) -> Basis:
        """Return the basis of a field in a segment.

        Parameters
        ----------
        segment : int
            Its place in ``segments``.
        field : {"V", "W", "N", "M"}
            The field.

        Returns
        -------
        Basis
            CG_k or DG_{k-1}.
        """
        return field_basis(self.segments[segment].variant, field, self.degree)

    def local_states(self, segment: int) -> Ints:
        """Return the states of each element in the order of the reference element.

        Parameters
        ----------
        segment : int
            Its place in ``segments``.

        Returns
        -------
        numpy.ndarray
            Shape (elements of the segment, local states).
        """
        return np.concatenate([self.states[segment][c] for c in present_components(self.space)], axis=1)

    def segment_of(self, element: int) -> int:
        """Find the segment of an element.

        Parameters
        ----------
        element : int
            Its number.

        Returns
        -------
        int
            Place in ``segments``.
        """
        return sum(s.last <= element for s in self.segments)

    def locate(self, place: float) -> tuple[int, float]:
        """Find the element of a point.

        Parameters
        ----------
        place : float
            m from the start.

        Returns
        -------
        element : int
            Its number; at a boundary the one to the left.
        xi : float
            Coordinate in the element, in [0, 1].
        """
        element = int(np.clip(np.searchsorted(self.boundaries, place) - 1, 0, self.lengths.size - 1))
        xi = (place - self.boundaries[element]) / self.lengths[element]
        return element, float(np.clip(xi, 0.0, 1.0))


def number_states(boundaries: Floats, degree: int, segments: Sequence[Segment], space: Space) -> Mesh:
    """Number the states of a beam: component by component, each from start to end.

    Parameters
    ----------
    boundaries : numpy.ndarray
        Shape (elements + 1,), m.
    degree : int
        k >= 1.
    segments : sequence of Segment
        Covering all elements in order.
    space : Space
        Which components are present.

    Returns
    -------
    Mesh
        The numbering.
    """
    states: list[dict[tuple[str, int], Ints]] = [{} for _ in segments]
    runs: list[StateRun] = []
    count = 0
    for component in present_components(space):
        f = component[0]
        positions: list[Floats] = []
        for i, segment in enumerate(segments):
            variant = segment.variant
            basis = field_basis(variant, f, degree)
            elements = np.arange(segment.last - segment.first)
            spots = boundaries[segment.first : segment.last, None] + (
                np.diff(boundaries)[segment.first : segment.last, None] * np.array(basis.nodes)
            )
            if variant.is_continuous(f):
                continued = i > 0 and segments[i - 1].variant.is_continuous(f)
                start = count - 1 if continued else count
                states[i][component] = start + elements[:, None] * degree + np.arange(basis.size)
                own = spots[:, 1:].ravel()
                positions.append(own if continued else np.concatenate([spots[0, :1], own]))
            else:
                states[i][component] = count + elements[:, None] * basis.size + np.arange(basis.size)
                positions.append(spots.ravel())
            count += positions[-1].size
        name = f"{f}{component[1] + 1}"
        runs.append(StateRun(name, UNITS[f], ENERGIES[f], np.concatenate(positions)))
    return Mesh(boundaries, degree, tuple(segments), space, tuple(states), tuple(runs))
