"""Which components of translation and rotation a model has: the plane is a slice of space.

Vectors have components 1, 2, 3 along the axes of their frame (indices 0, 1, 2 here).  A planar model keeps the
translations 1, 2 and the rotation 3; a bar that is only pulled keeps translation 1.  Everything that depends on
the number of components asks a :class:`Space`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phblocks.triplets import Floats

#: The Levi-Civita symbol: ``cross(a, b)[i] = LEVI_CIVITA[i, j, k] a[j] b[k]``.
LEVI_CIVITA: Floats = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    LEVI_CIVITA[_i, _j, _k], LEVI_CIVITA[_i, _k, _j] = 1.0, -1.0


@dataclass(frozen=True)
class Space:
    """A choice of components.

    Parameters
    ----------
    name : str
        For messages.
    translation : tuple of int
        Indices (0, 1, 2) of the components of velocity and force that exist.
    rotation : tuple of int
        Indices of the components of angular velocity and moment that exist.
    """

    name: str
    translation: tuple[int, ...]
    rotation: tuple[int, ...]

    @property
    def dimension(self) -> int:
        """Number of coordinates of a point."""
        return len(self.translation)

    def turns(self, kind: str | None) -> bool:
        """Tell whether rotations change components: in the plane they leave angular velocities alone.

        Parameters
        ----------
        kind : {"translation", "rotation"} or None
            What the components are; ``None`` for scalars.

        Returns
        -------
        bool
            False if every rotation of this space leaves them as they are.
        """
        return kind is not None and len(self.translation if kind == "translation" else self.rotation) > 1


SPATIAL = Space("spatial", (0, 1, 2), (0, 1, 2))
PLANAR = Space("planar", (0, 1), (2,))


def space_of(dimension: int) -> Space:
    """Find the space by the number of coordinates of a point.

    Parameters
    ----------
    dimension : int
        2 or 3.

    Returns
    -------
    Space
        Planar or spatial.
    """
    return {space.dimension: space for space in (PLANAR, SPATIAL)}[dimension]
