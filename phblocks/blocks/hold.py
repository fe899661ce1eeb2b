"""What a joint with forces of its own holds together in position."""

from __future__ import annotations

from dataclasses import dataclass

from phblocks.triplets import Floats


@dataclass(frozen=True)
class Hold:
    """Two ports of translation that may not separate along some directions.

    Parameters
    ----------
    first, second : str
        Names of the ports.
    across : numpy.ndarray
        The directions, shape (directions, dimension), of length one; as many as there are dimensions if the two
        stay in one place.
    turning : bool
        The directions turn with the anchor of the first port; otherwise they are fixed in space.
    start, end : numpy.ndarray or None
        Initial places of the two, shape (dimension,), m, where the block has to know them.
    """

    first: str
    second: str
    across: Floats
    turning: bool = False
    start: Floats | None = None
    end: Floats | None = None

    @property
    def complete(self) -> bool:
        """Whether the two stay in one place."""
        return bool(len(self.across) == self.across.shape[1])
