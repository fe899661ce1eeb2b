"""The ground: it gives zero velocity to whatever is attached to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from phblocks.blocks.block import Block, PortChoice, Replacement, Tie
from phblocks.blocks.form import FIXED, Form, PortForm
from phblocks.ports import Anchor
from phblocks.space import Space
from phblocks.triplets import Triplets


class Ground(Block):
    """The frame at rest that a mechanism is mounted on; its anchor is wherever it is needed.

    Parameters
    ----------
    name : str, optional
        As in messages.
    """

    #: Any number of junctions may use the ground.
    shared = True

    def __init__(self, name: str = "ground") -> None:
        super().__init__(name)
        self.anchor = Anchor(self, "anchor", None)

    @property
    def anchors(self) -> Mapping[str, Anchor]:
        """The one anchor."""
        return {"anchor": self.anchor}

    @property
    def space(self) -> Space | None:
        """It fits any space."""
        return None

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that the ground gives velocity.

        Returns
        -------
        choices : sequence of PortChoice
            Both ports give.
        ties : sequence of Tie
            None.
        """
        return [PortChoice(port, may_give=True, may_take=False) for port in self.anchor.ports], []

    def welded_to(self, other: Block, name: str) -> Replacement | None:
        """Take the place of a rigid part that cannot move.

        Parameters
        ----------
        other : Block
            What is held by the ground.
        name : str
            Does not matter.

        Returns
        -------
        Replacement or None
            The ground; ``None`` if the other is not rigid.
        """
        if other.rigid is None:
            return None
        ports = self.anchor.ports
        places = {q: r for a in other.anchors.values() for q, r in zip(a.ports, ports, strict=False)}
        what = f"leave out {other.name!r}, which cannot move, and attach to the ground what hangs on it"
        return Replacement(self, places, what)

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the ground to no states at all.

        Parameters
        ----------
        gives : mapping of str to bool
            Always true.

        Returns
        -------
        Form
            Without states; what it gives is zero.
        """
        none = Triplets.empty()
        return Form(
            size=0,
            runs=(),
            E=none,
            J0=none,
            R=none,
            T=Triplets.empty(3),
            ports={port.name: PortForm(True, ()) for port in self.anchor.ports},
            orientations={"anchor": FIXED},
        )
