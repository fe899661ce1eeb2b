"""What junctions and openings contribute: the exchange between giver and takers, inputs, rates of spans."""

from __future__ import annotations

import numpy as np

from phblocks.assembly.entries import Entries, direction_feature, with_feature
from phblocks.assembly.layout import Layout
from phblocks.errors import OrientationError
from phblocks.frames import QUARTER, Orientation, Turn
from phblocks.network import Junction
from phblocks.ports import Exposure, Port
from phblocks.triplets import Floats, Triplets

#: What to do where frames of space turn against each other.
TURNING = (
    "Weld parts, pin them to the ground only, and let forces and imposed motions follow the frame (follows=True); or "
    "leave large rotations out (ph.Approximation(large_rotation=False)); or draw it in the plane, with two coordinates."
)


def collect(layout: Layout) -> Entries:
    """Collect the entries of all junctions and openings of a network.

    Parameters
    ----------
    layout : Layout
        Numbering and orientations.

    Returns
    -------
    Entries
        In coordinates of blocks.
    """
    joints = Entries()
    for junction in layout.network.junctions():
        _join(layout, junction, joints)
    for exposure in layout.network.exposures():
        _load(layout, exposure, joints)
    return joints


def _join(layout: Layout, junction: Junction, to: Entries) -> None:
    """Add the exchange at one junction: the giver with each taker, and the outside.

    Of several that give together the first stands for all: their states are the same.
    """
    givers = [port for port in junction.ports if layout.gives(port)][:1]
    takers = [port for port in junction.ports if not layout.gives(port)]
    for giver in givers:
        for taker in takers:
            _exchange(layout, giver, taker, to)
    for exposure in junction.exposures:
        acted = [port for port in (takers if exposure.gives else givers) if layout.pieces(port)]
        for port in acted:
            _open(layout, exposure, port, layout.followed(exposure, acted[0]), to)


def _exchange(layout: Layout, giver: Port, taker: Port, to: Entries) -> None:
    """Entries of ``out_t^T C out_g`` with C the rotation from the giver's to the taker's frames."""
    flows = [
        part
        for giving, out in layout.pieces(giver)
        for taking, into in layout.pieces(taker)
        for part in _act(layout, giver, (giving, taking), into, out, to, f"joint of {giver.path} and {taker.path}")
    ]
    if not flows:
        return  # one side has nothing to give: the ground's velocity is zero
    to.pairs.append((giver, taker))
    to.flows.append(flows)
    for entries in flows:
        to.K.append(entries.skew)
    end = layout.span_at(taker)
    if end is not None:
        for giving, out in layout.pieces(giver):
            to.kinematics += _act(layout, giver, (giving, layout.still), _span_rows(*end), out, to)


def _open(layout: Layout, exposure: Exposure, port: Port, frame: Orientation, to: Entries) -> None:
    """Entries of ``out^T C u``: an input in the fixed frame, or in that of an anchor, acting on a port."""
    components = np.arange(len(port.domain.components(layout.network.space)))
    outside = Triplets.of(components, layout.first_input[exposure.name] + components, values=1.0)
    for taking, into in layout.pieces(port):
        to.K_u += _act(layout, port, (frame, taking), into, outside, to, f"input {exposure.name!r} on {port.path}")
    end = layout.span_at(port)
    if end is not None and exposure.gives:
        to.kinematics_u += _act(layout, port, (frame, layout.still), _span_rows(*end), outside, to)


def _load(layout: Layout, exposure: Exposure, to: Entries) -> None:
    """Entries of a load that a block brings along, the sum over its points."""
    components = np.arange(len(exposure.port.domain.components(layout.network.space)))
    outside = Triplets.of(components, layout.first_input[exposure.name] + components, values=1.0)
    for frame, into in layout.load_pieces(exposure.port):
        where = f"load {exposure.name!r} of {exposure.port.block.name!r}"
        to.K_u += _act(layout, exposure.port, (layout.still, frame), into, outside, to, where)


def _span_rows(first: int, sign: float) -> Triplets:
    return Triplets.of([0, 1], [first, first + 1], values=sign)


def _act(
    layout: Layout,
    port: Port,
    frames: tuple[Orientation | int, Orientation | int],
    into: Triplets,
    out: Triplets,
    to: Entries,
    where: str = "",
) -> list[Triplets]:
    """Entries (row, column, feature) of ``into^T C out``, with C from the giving to the taking frame or line."""
    giving, taking = frames
    assert not isinstance(giving, int)  # what points along a line gives force, so it never is the giver of a junction
    if isinstance(taking, int):
        assert isinstance(giving, Turn)  # lines are planar
        to.directions.append((taking, giving))
        d = len(to.directions) - 1
        row = np.zeros_like(into.indices[0])
        parts = [
            with_feature(_sandwich(Triplets((row, into.indices[1]), into.values), out, unit), direction_feature(d, b))
            for b, unit in enumerate((np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]])))
        ]
    elif not layout.network.space.turns(port.domain.turns_with):
        parts = [with_feature(_sandwich(into, out, np.eye(len(port.domain.components(layout.network.space)))), 0)]
    elif (turn := giving.minus(taking)).fixed:  # type: ignore[arg-type]  # both of one space
        parts = [with_feature(_sandwich(into, out, turn.matrix()), 0)]
    elif not isinstance(turn, Turn):
        raise OrientationError(
            where,
            expected="frames that keep their rotation against each other",
            got="frames that turn against each other in space, and how they stand then is not computed yet",
            fix=TURNING,
        )
    else:
        to.turns.append(turn)
        m = len(to.turns) - 1
        parts = [
            with_feature(_sandwich(into, out, np.eye(2)), 1 + 2 * m),
            with_feature(_sandwich(into, out, QUARTER), 2 + 2 * m),
        ]
    return [part for part in parts if part.values.size]


def _sandwich(into: Triplets, out: Triplets, matrix: Floats) -> Triplets:
    """Entries of ``into^T matrix out``, without zeros."""
    (a, i), (b, j) = into.indices, out.indices
    values = into.values[:, None] * matrix[a[:, None], b[None, :]] * out.values[None, :]
    rows, columns = np.nonzero(values)
    return Triplets.of(i[rows], j[columns], values=values[rows, columns])
