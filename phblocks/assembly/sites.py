"""Where anchors are joined in space, and where they are held together across some directions only."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from phblocks.assembly.layout import Layout
from phblocks.blocks.hold import Hold
from phblocks.errors import GapError
from phblocks.network import GAP_TOLERANCE, Junction
from phblocks.ports import TRANSLATION, Anchor, Port
from phblocks.system import Guide, Site
from phblocks.triplets import Floats


def find_sites(layout: Layout) -> tuple[tuple[Site, ...], tuple[Guide, ...]]:
    """List where anchors are joined in space: by a junction, or by blocks that hold junctions together.

    Parameters
    ----------
    layout : Layout
        Of the diagram.

    Returns
    -------
    sites : tuple of Site
        One for each place of two or more anchors, or of one that the ground or an imposed velocity holds.
    guides : tuple of Guide
        One for each block that holds two places together across some directions only.

    Raises
    ------
    GapError
        If what is joined to a block is not in the place that the block was given.
    """
    junctions = [j for j in layout.network.junctions() if j.domain == TRANSLATION]
    at = {port: i for i, j in enumerate(junctions) for port in j.ports if not port.block.shared}
    holds = [
        (block.ports[hold.first], block.ports[hold.second], hold)
        for name, block in layout.network.blocks.items()
        for hold in layout.forms[name].holds
    ]
    same = np.array([(at[a], at[b]) for a, b, hold in holds if hold.complete], dtype=np.int64).reshape(-1, 2)
    links = coo_array((np.ones(len(same)), (same[:, 0], same[:, 1])), shape=(len(junctions),) * 2)
    label = connected_components(links, directed=False)[1]
    members: dict[int, list[Junction]] = {}
    for number, junction in zip(label.tolist(), junctions, strict=True):
        members.setdefault(number, []).append(junction)
    places = {number: _Place.of(layout, joined) for number, joined in members.items()}
    alike = (together for place in places.values() for together in place.split())
    sites = (p.site(p.anchors[0][1]) for p in alike if len(p.anchors) + p.known > 1)
    guides = (_guide(a, hold, places[label[at[a]]], places[label[at[b]]]) for a, b, hold in holds if not hold.complete)
    return tuple(sites), tuple(guide for guide in guides if guide is not None)


@dataclass(frozen=True)
class _Place:
    """Anchors that are together: those with an initial position, and the paths of all."""

    anchors: list[tuple[Anchor, Floats]]
    paths: list[str]
    made_by: dict[Anchor, str]
    ground: bool
    inputs: tuple[int, ...]
    imposed: int

    @classmethod
    def of(cls, layout: Layout, junctions: Iterable[Junction]) -> _Place:
        joined = list(junctions)
        made_by = {port: junction.made_by for junction in joined for port in junction.ports}
        ports = list(made_by)
        # where what follows a frame moves an anchor to depends on how that turns
        imposed = [e for junction in joined for e in junction.exposures if e.gives and not e.follows]
        # springs and the like follow what they join; the ground is where it is needed
        anchors = dict.fromkeys(
            p.anchor
            for p in ports
            if p.anchor is not None
            and (p.block.shared or (p.anchor.position is not None and layout.forms[p.block.name].points is not None))
        )
        first = layout.first_input[imposed[0].name] if imposed else 0
        return cls(
            [(a, a.position) for a in anchors if a.position is not None],
            [a.path for a in anchors],
            {p.anchor: call for p, call in made_by.items() if p.anchor is not None},
            any(a.block.shared for a in anchors),
            tuple(range(first, first + layout.network.space.dimension)) if imposed else (),
            len(imposed),
        )

    @property
    def known(self) -> int:
        """How many positions do not depend on any block."""
        return self.ground + self.imposed

    def split(self) -> list[_Place]:
        """Tell anchors that are joined but apart from each other: they have one velocity, and places of their own."""
        groups: list[list[tuple[Anchor, Floats]]] = []
        for anchor, position in self.anchors:
            near = GAP_TOLERANCE * (1.0 + float(np.abs(position).max()))
            home = next((g for g in groups if float(np.linalg.norm(g[0][1] - position)) <= near), None)
            if home is None:
                groups.append([(anchor, position)])
            else:
                home.append((anchor, position))
        if len(groups) < 2:
            return [self] if groups else []
        return [replace(self, anchors=group, paths=[a.path for a, _ in group]) for group in groups]

    def site(self, start: Floats) -> Site:
        return Site(
            name=" = ".join(self.paths),
            places=tuple((a.block.name, a.place) for a, _ in self.anchors),
            start=start,
            known=self.known > 0,
            inputs=self.inputs,
        )


def _guide(port: Port, hold: Hold, first: _Place, second: _Place) -> Guide | None:
    """The two places that a block holds together across some directions; none where one is nowhere in particular."""
    starts = [_start(port.block.name, place, given) for place, given in ((first, hold.start), (second, hold.end))]
    known = [start for start in starts if start is not None]
    if not known or any(not (place.anchors or place.known) for place in (first, second)):
        return None
    # without a place of its own the ground is where the other side is
    a, b = (known[0] if start is None else start for start in starts)
    anchor = port.anchor.path if hold.turning and port.anchor is not None else None
    return Guide(port.block.name, first.site(a), second.site(b), hold.across, anchor)


def _start(block: str, place: _Place, given: Floats | None) -> Floats | None:
    """Where a side is at first; what is joined there has to be where the block was told."""
    for anchor, position in place.anchors:
        if given is None:
            return position
        distance = float(np.linalg.norm(position - given))
        if distance > GAP_TOLERANCE * (1.0 + float(np.abs(given).max())):
            raise GapError(
                f"{block} and {anchor.path} ({place.made_by[anchor]})",
                expected=f"an anchor at {given.tolist()}, where {block} was put",
                got=f"{position.tolist()}, {distance:.6g} m away",
                fix="Correct the coordinates.",
            )
    return given
