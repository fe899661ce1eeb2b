"""The report of effects: for every component, orientation and position why it is computed, or why not."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Literal

from phblocks.assembly.layout import Layout
from phblocks.assembly.pruning import Kept
from phblocks.assembly.reachable import Reach
from phblocks.effects import Effect
from phblocks.system import DROPPED, STILL
from phblocks.triplets import Ints

#: Steps of a way that are told, and what excites it.
STEPS = 4


def describe(
    layout: Layout, kept: Kept, place: Ints, positions: Mapping[str, slice], needs: str, linear: bool
) -> Iterator[Effect]:
    """List every effect of a diagram.

    Parameters
    ----------
    layout : Layout
        Numbering and orientations.
    kept : Kept
        What is computed.
    place : numpy.ndarray
        Number of each rotation state in the system, DROPPED or STILL.
    positions : mapping of str to slice
        The material points that are tracked, by block.
    needs : str
        What positions and orientations are kept for; empty if for the physics of joints and directions only.
    linear : bool
        Whether the matrices of the system are constant.

    Yields
    ------
    Effect
        One for each component of each block, for the orientation and the positions of each block that has them, and
        for the products of the whole.
    """
    proof = None if kept.reach is None else _Proof(kept.reach)
    gone = "" if proof is None else f"no path from: {proof.excitations}"
    coordinate = 0
    for name, form in layout.forms.items():
        for number, run in enumerate(form.runs):
            count = run.positions.size
            out = bool(kept.dropped[coordinate])
            reason = kept.why if proof is None else gone if out else proof.way(kept.reach, name, number)
            yield Effect(name, run.field, "pruned" if out else "kept", count, reason)
            coordinate += count
        if form.rotation_states.size:
            first = layout.first_theta[name]
            places = place[first : first + form.rotation_states.size]
            reason = needs or "a joint, a load or the direction of a spring turns with it"
            if (places == STILL).all():
                reason = f"its angular velocity stays zero; {gone}"
            elif (places == DROPPED).all():
                reason = "no joint, load, gravity or output needs it"
            status: Literal["kept", "pruned"] = "kept" if (places >= 0).any() else "pruned"
            count = int((places >= 0).sum()) if status == "kept" else places.size
            yield Effect(name, "orientation", status, count, reason)
        if form.points is not None:
            tracked = name in positions
            reason = needs if tracked else "no gravity and no output needs them"
            yield Effect(name, "positions", "kept" if tracked else "pruned", form.points.start.size, reason)
    reason = "no product of two quantities that differ from zero is left, and nothing turns: the matrices are constant"
    yield Effect(
        "",
        "nonlinearity",
        "pruned" if linear else "kept",
        0,
        reason if linear else "products of quantities that differ from zero, or frames that turn, are left",
    )


class _Proof:
    """Ways through a pattern in words."""

    def __init__(self, reach: Reach) -> None:
        pattern = reach.reached.pattern
        self._edges = set(zip(*pattern.edges.tolist(), strict=True))
        a, b, c = pattern.products
        both = reach.reached.mask[a] & reach.reached.mask[b]
        a, b, c = (axis[both].tolist() for axis in (a, b, c))
        self._factor = dict(zip(zip(a, c, strict=True), b, strict=True))
        self._factor |= dict(zip(zip(b, c, strict=True), a, strict=True))
        self.excitations = ", ".join(dict.fromkeys(self._seed(reach, node) for node in reach.excited))

    def _seed(self, reach: Reach, node: int) -> str:
        what = reach.excited[node]
        return f"{reach.names(node)} ({what})" if node < len(reach.components.names) else what

    def way(self, reach: Reach | None, block: str, number: int) -> str:
        """From a component back to what excites it."""
        assert reach is not None
        component = reach.components.first[block] + number
        node = int(reach.moving[component])
        if not reach.reached.mask[node]:
            return "its value at the start is asked for"
        path = reach.reached.path(node)
        words = []
        for here, before in pairwise(path):
            other = None if (before, here) in self._edges else self._factor.get((before, here))
            factor = "" if other is None else f" (times {reach.names(other)})"
            if before in path[-1:] and before in reach.excited:
                words.append(f"{self._seed(reach, before)}{factor}")
            else:
                words.append(f"{reach.names(before)}{factor}")
        if len(words) > STEPS + 1:
            words = [*words[:STEPS], "...", words[-1]]
        told = list(dict.fromkeys([reach.names(node), *words]))
        return " <- ".join(told) if words else self._seed(reach, node)
