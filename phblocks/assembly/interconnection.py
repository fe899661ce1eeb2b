"""From blocks and an assignment of causality to one system: the Dirac structure, stacked and interconnected.

At each junction the giving port g and each taking port t exchange ``v_t = C v_g`` and ``f_g = -C^T f_t`` with
``C = Lambda_t^T Lambda_g``: the same rotation on both sides, transposed, so that J stays skew. Where g and t
keep their angle to each other, the exchange is part of the constant J0, elsewhere of K.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from phblocks.assembly.exchange import find_exchange
from phblocks.assembly.layout import Layout, lay_out
from phblocks.assembly.sharing import share
from phblocks.assembly.sites import find_sites
from phblocks.assembly.structure import check_structure
from phblocks.blocks.checks import is_one_of
from phblocks.blocks.form import AngleRows
from phblocks.causality import CausalityReport
from phblocks.errors import DataError
from phblocks.frames import NO_TURN, QUARTER, Turn, rotate
from phblocks.network import Junction, Network
from phblocks.ports import Exposure, Port
from phblocks.system import (
    Angles,
    Connections,
    Exchange,
    Lines,
    Part,
    Sharing,
    State,
    System,
    find_constraints,
    require_independent,
)
from phblocks.triplets import Floats, Ints, Triplets

Outputs = Literal["all"] | None


@dataclass
class _Entries:
    """Entries (row, column, feature) as they are collected.

    Preliminary numbers of features: 0 is the constant, 1 + 2m is cos alpha_m, 2 + 2m is sin alpha_m, and negative
    ones are directions.
    """

    turns: list[Turn] = field(default_factory=list)
    directions: list[tuple[int, Turn]] = field(default_factory=list)
    K: list[Triplets] = field(default_factory=list)
    K_u: list[Triplets] = field(default_factory=list)
    kinematics: list[Triplets] = field(default_factory=list)
    kinematics_u: list[Triplets] = field(default_factory=list)
    pairs: list[tuple[Port, Port]] = field(default_factory=list)
    flows: list[list[Triplets]] = field(default_factory=list)


def assemble(network: Network, report: CausalityReport, outputs: Outputs = "all") -> System:
    """Assemble a network.

    Parameters
    ----------
    network : Network
        Blocks and junctions.
    report : CausalityReport
        Who gives and who takes; must be ok.
    outputs : {"all", None}, optional
        "all" keeps orientations and positions of all blocks; ``None`` only what the physics needs.

    Returns
    -------
    System
        With its structure verified.

    Raises
    ------
    DataError
        If outputs is neither "all" nor None.
    StructureError
        If the matrices violate the port-Hamiltonian structure.
    ConstraintError
        If a constraint follows from others.
    GapError
        If what is joined to a block is not in the place that the block was given.
    """
    if not is_one_of(outputs, ("all", None)):
        raise DataError("compile outputs", expected='"all" or None', got=repr(outputs), fix='Use outputs="all".')
    layout = lay_out(network, report)
    joints = _Entries()
    for junction in network.junctions():
        _join(layout, junction, joints)
    for exposure in network.exposures():
        _load(layout, exposure, joints)
    gravity = np.zeros(network.space.dimension) if network.gravity is None else network.gravity
    heavy = bool(gravity.any()) and any(f.points is not None and f.points.weighs for f in layout.forms.values())
    points = _Points.of(layout) if heavy or outputs == "all" else _Points.of(layout, ())
    n_joints = len(joints.turns)
    n_angles = n_joints + (points.mass.size if heavy else 0)
    angle_rows = [_turn_rows(joints.turns)]
    references = [np.array([t.reference for t in joints.turns])]
    if heavy:
        angle_rows.append(points.angle.rows.shifted(n_joints, 0))
        references.append(points.angle.reference)
    rows = Triplets.join(angle_rows)
    seen = np.concatenate([rows.indices[1], _turn_rows([turn for _, turn in joints.directions]).indices[1]])
    keep = np.ones(layout.n_theta, dtype=bool) if outputs == "all" else np.isin(np.arange(layout.n_theta), seen)
    for name, form in layout.forms.items():  # how far a frozen block has turned is looked at after a run
        if form.frozen:
            keep[layout.first_theta[name] + np.arange(form.rotation_states.size)] = True
    same = np.concatenate([layout.theta_same, np.arange(layout.theta_same.size, layout.n_theta)])
    keep &= same == np.arange(layout.n_theta)
    place = np.where(keep, np.cumsum(keep) - 1, -1)[same]
    sharing = share(layout.teams, layout.pieces, network, layout.n)
    n, m, n_theta = sharing.kept.size, len(layout.inputs), int(keep.sum())
    forms = [(name, layout.forms[name], layout.first_state[name]) for name in layout.forms]
    driven_rows, driven_inputs = layout.driven_rows()
    held = [f.storage.shifted(i) for _, f, i in forms if f.storage is not None]
    local = Triplets.join(f.kinematics.shifted(i, i) for _, f, i in forms)
    joints.kinematics += [_with_feature(local, 0)]
    joints.kinematics += [Triplets.of(s.energy, s.coenergy, 0, values=1.0) for s in held]
    supply = _features(Triplets.join(joints.K_u, order=3), n_angles, len(joints.directions))
    exchange = _features(Triplets.join(joints.K, order=3), n_angles, len(joints.directions))
    fixed, turning = _constant(sharing.reduced(exchange, (0, 1)))
    fixed_u, turning_u = _constant(sharing.reduced(supply, (0,)))
    sites, guides = find_sites(layout)
    kinematics_u = _constant(_features(Triplets.join(joints.kinematics_u, order=3), n_angles, 0))[0]

    def matrix(entries: Iterable[Triplets]) -> Triplets:
        return sharing.reduced(Triplets.join(entries), (0, 1))

    system = System(
        name=network.name,
        dimension=network.space.dimension,
        gravity=gravity,
        parts=tuple(
            Part(
                network.blocks[name],
                form,
                slice(first, first + form.size),
                place[layout.first_theta[name] + np.arange(form.rotation_states.size)],
                points.of_block.get(name, slice(0, 0)),
            )
            for name, form, first in forms
        ),
        inputs=tuple(layout.inputs),
        E=matrix(f.E.shifted(i, i) for _, f, i in forms).csr((n, n)),
        J0=Triplets.join([matrix(f.J0.shifted(i, i) for _, f, i in forms), fixed]).csr((n, n)),
        R0=matrix(f.R.shifted(i, i) for _, f, i in forms).csr((n, n)),
        T=sharing.reduced(Triplets.join((f.T.shifted(i, i, i) for _, f, i in forms), order=3), (0, 1, 2)).coo(
            (n, n, n)
        ),
        G0=fixed_u.csr((n, m)),
        angles=Angles(_kept(rows, place).csr((n_angles, n_theta)), np.concatenate(references)),
        K=turning,
        K_u=turning_u,
        K_g=sharing.reduced(points.weight(gravity, n_joints, n_angles), (0,)) if heavy else Triplets.empty(),
        rates=sharing.reduced(
            Triplets.of(
                place[layout.theta_rows[keep[layout.theta_rows]]],
                layout.theta_states[keep[layout.theta_rows]],
                values=1.0,
            ),
            (1,),
        ).csr((n_theta, n)),
        input_rates=_kept_rows(Triplets.of(driven_rows, driven_inputs, values=1.0), place).csr((n_theta, m)),
        lines=_lines(layout, joints, sharing, place, n_theta),
        kinematics=sharing.reduced(_features(Triplets.join(joints.kinematics, order=3), n_angles, 0), (0, 1)),
        kinematics_u=sharing.reduced(kinematics_u, (0,)).csr((n, m)),
        connections=_connections(layout, joints, n_angles, supply, find_exchange(layout, joints.pairs, place, n_theta)),
        sites=sites,
        guides=guides,
        anchor_angles=layout.anchor_angles(place),
        point_mass=points.mass,
        point_velocity=sharing.reduced(points.velocity, (1,)).csr((points.mass.size * network.space.dimension, n)),
        point_angles=Angles(_kept(points.angle.rows, place).csr((points.mass.size, n_theta)), points.angle.reference),
        start=State(_start(layout)[sharing.kept], np.zeros(n_theta), points.start),
        sharing=sharing,
        report=report,
    )
    check_structure(system)
    if system.is_dae:
        require_independent(system, find_constraints(system))
    return system


def _start(layout: Layout) -> Floats:
    parts = [np.zeros(form.size) if form.start is None else form.start for form in layout.forms.values()]
    return np.concatenate(parts)


@dataclass(frozen=True)
class _Points:
    """The material points of all blocks, stacked."""

    mass: Floats  # zero where gravity is left out
    velocity: Triplets
    angle: AngleRows
    start: Floats
    of_block: dict[str, slice]

    @classmethod
    def of(cls, layout: Layout, names: Iterable[str] | None = None) -> _Points:
        d = layout.network.space.dimension
        mass, velocity, rows, reference, start = [np.empty(0)], [], [], [np.empty(0)], [np.empty((0, d))]
        of_block: dict[str, slice] = {}
        count = 0
        for name in layout.forms if names is None else names:
            points = layout.forms[name].points
            if points is None:
                continue
            of_block[name] = slice(count, count + points.mass.size)
            mass.append(points.mass * points.weighs)
            velocity.append(points.velocity.shifted(count * d, layout.first_state[name]))
            row, place = points.angle.rows.indices
            place = layout.theta_same[layout.first_theta[name] + place]
            rows.append(Triplets((row + count, place), points.angle.rows.values))
            reference.append(points.angle.reference)
            start.append(points.start)
            count += points.mass.size
        angle = AngleRows(Triplets.join(rows), np.concatenate(reference))
        return cls(np.concatenate(mass), Triplets.join(velocity), angle, np.concatenate(start), of_block)

    def weight(self, gravity: Floats, first_angle: int, n_angles: int) -> Triplets:
        """Entries of K_g: mass times Lambda^T g at each point, as a force on the states."""
        row, state = self.velocity.indices
        point, component = row // gravity.size, row % gravity.size
        value = self.velocity.values * self.mass[point]
        row, state, point, component, value = (a[value != 0.0] for a in (row, state, point, component, value))
        turning = np.isin(point, self.angle.rows.indices[0])
        if not turning.all():
            still = ~turning
            fixed = rotate(-self.angle.reference[point[still]], gravity)[np.arange(still.sum()), component[still]]
            parts = [Triplets.of(state[still], 0, values=value[still] * fixed)]
            point, component, state = point[turning], component[turning], state[turning]
            value = value[turning]
        else:
            parts = []
        cos = Triplets.of(state, 1 + first_angle + point, values=value * gravity[component])
        sin = Triplets.of(state, 1 + n_angles + first_angle + point, values=value * (QUARTER.T @ gravity)[component])
        return Triplets.join([*parts, cos, sin])


def _join(layout: Layout, junction: Junction, to: _Entries) -> None:
    """Add the exchange at one junction: the giver with each taker, and the outside.

    Of several that give together the first stands for all: their states are the same.
    """
    givers = [port for port in junction.ports if layout.gives(port)][:1]
    takers = [port for port in junction.ports if not layout.gives(port)]
    for giver in givers:
        for taker in takers:
            _exchange(layout, giver, taker, to)
    for exposure in junction.exposures:
        for port in takers if exposure.gives else givers:
            _open(layout, exposure, port, to)


def _exchange(layout: Layout, giver: Port, taker: Port, to: _Entries) -> None:
    """Entries of ``out_t^T C out_g`` with C the rotation from the giver's to the taker's frames."""
    flows = [
        part
        for giving, out in layout.pieces(giver)
        for taking, into in layout.pieces(taker)
        for part in _act(layout, giver, giving, taking, into, out, to)
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
            to.kinematics += _act(layout, giver, giving, NO_TURN, _span_rows(*end), out, to)


def _open(layout: Layout, exposure: Exposure, port: Port, to: _Entries) -> None:
    """Entries of ``out^T C u``: an input in the fixed frame, or in that of the anchor, acting on a port."""
    components = np.arange(len(port.domain.components(layout.network.space)))
    outside = Triplets.of(components, layout.first_input[exposure.name] + components, values=1.0)
    frame = layout.orientation(port) if exposure.follows else NO_TURN
    for taking, into in layout.pieces(port):
        to.K_u += _act(layout, port, frame, taking, into, outside, to)
    end = layout.span_at(port)
    if end is not None and exposure.gives:
        to.kinematics_u += _act(layout, port, frame, NO_TURN, _span_rows(*end), outside, to)


def _load(layout: Layout, exposure: Exposure, to: _Entries) -> None:
    """Entries of a load that a block brings along, the sum over its points."""
    components = np.arange(len(exposure.port.domain.components(layout.network.space)))
    outside = Triplets.of(components, layout.first_input[exposure.name] + components, values=1.0)
    for frame, into in layout.load_pieces(exposure.port):
        to.K_u += _act(layout, exposure.port, NO_TURN, frame, into, outside, to)


def _span_rows(first: int, sign: float) -> Triplets:
    return Triplets.of([0, 1], [first, first + 1], values=sign)


def _act(
    layout: Layout, port: Port, giving: Turn | int, taking: Turn | int, into: Triplets, out: Triplets, to: _Entries
) -> list[Triplets]:
    """Entries (row, column, feature) of ``into^T C out``, with C from the giving to the taking frame or line."""
    assert isinstance(giving, Turn)  # what points along a line gives force, so it never is the giver of a junction
    if isinstance(taking, int):
        to.directions.append((taking, giving))
        d = len(to.directions) - 1
        row = np.zeros_like(into.indices[0])
        parts = [
            _with_feature(_sandwich(Triplets((row, into.indices[1]), into.values), out, unit), _direction(d, b))
            for b, unit in enumerate((np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]])))
        ]
    elif not layout.network.space.turns(port.domain.turns_with):
        parts = [_with_feature(_sandwich(into, out, np.eye(len(port.domain.components(layout.network.space)))), 0)]
    elif (turn := giving.minus(taking)).fixed:
        parts = [_with_feature(_sandwich(into, out, turn.matrix()), 0)]
    else:
        to.turns.append(turn)
        m = len(to.turns) - 1
        parts = [
            _with_feature(_sandwich(into, out, np.eye(2)), 1 + 2 * m),
            _with_feature(_sandwich(into, out, QUARTER), 2 + 2 * m),
        ]
    return [part for part in parts if part.values.size]


def _direction(number: int, component: int) -> int:
    """Preliminary number of the feature of a direction."""
    return -1 - 2 * number - component


def _sandwich(into: Triplets, out: Triplets, matrix: Floats) -> Triplets:
    """Entries of ``into^T matrix out``, without zeros."""
    (a, i), (b, j) = into.indices, out.indices
    values = into.values[:, None] * matrix[a[:, None], b[None, :]] * out.values[None, :]
    rows, columns = np.nonzero(values)
    return Triplets.of(i[rows], j[columns], values=values[rows, columns])


def _with_feature(entries: Triplets, feature: int) -> Triplets:
    return Triplets((*entries.indices, np.full(entries.values.size, feature)), entries.values)


def _features(entries: Triplets, n_angles: int, n_directions: int) -> Triplets:
    """Number features finally: the constant, all cosines, all sines, first and second components of directions."""
    i, j, f = entries.indices
    turn, line = f - 1, -f - 1
    number = np.where(
        f > 0,
        1 + (turn % 2) * n_angles + turn // 2,
        np.where(f < 0, 1 + 2 * n_angles + (line % 2) * n_directions + line // 2, 0),
    )
    return Triplets((i, j, number), entries.values)


def _constant(entries: Triplets) -> tuple[Triplets, Triplets]:
    """Split entries into those of the constant feature, of order two, and the others."""
    still = entries.indices[2] == 0
    i, j, f = entries.indices
    return (
        Triplets((i[still], j[still]), entries.values[still]),
        Triplets((i[~still], j[~still], f[~still]), entries.values[~still]),
    )


def _connections(layout: Layout, joints: _Entries, n_angles: int, supply: Triplets, exchange: Exchange) -> Connections:
    parts = [part for flow in joints.flows for part in flow]
    sizes = [sum(part.values.size for part in flow) for flow in joints.flows]
    return Connections(
        tuple((giver.path, taker.path) for giver, taker in joints.pairs),
        np.array([[layout.block_number(p.block.name) for p in pair] for pair in joints.pairs], dtype=np.int64).reshape(
            -1, 2
        ),
        np.repeat(np.arange(len(sizes)), sizes),
        _features(Triplets.join(parts, order=3), n_angles, len(joints.directions)),
        supply,
        exchange,
    )


def _lines(layout: Layout, joints: _Entries, sharing: Sharing, place: Ints, n_theta: int) -> Lines:
    """All lines, and the frames in which their directions are seen."""
    numbered = [(layout.first_state[name], line) for name, form in layout.forms.items() for line in form.lines]
    stretches = [
        Triplets.of([m], [first + line.stretch[0]], values=line.stretch[1])
        for m, (first, line) in enumerate(numbered)
        if line.stretch is not None
    ]
    turns = [turn for _, turn in joints.directions]
    spans = np.array([(f + line.span, f + line.span + 1) for f, line in numbered], dtype=np.int64).reshape(-1, 2)
    return Lines(
        spans=sharing.state_of(spans),
        free=np.array([line.free for _, line in numbered]),
        stretch=sharing.reduced(Triplets.join(stretches), (1,)).csr((len(numbered), sharing.kept.size)),
        taut=np.array([line.stretch is not None for _, line in numbered], dtype=bool),
        line=np.array([line for line, _ in joints.directions], dtype=np.int64),
        frames=Angles(
            _kept(_turn_rows(turns), place).csr((len(turns), n_theta)), np.array([t.reference for t in turns])
        ),
    )


def _turn_rows(turns: Sequence[Turn]) -> Triplets:
    rows = [m for m, turn in enumerate(turns) for _ in turn.places]
    places = [p for turn in turns for p in turn.places]
    return Triplets.of(rows, places, values=[w for turn in turns for w in turn.weights]) if rows else Triplets.empty()


def _kept(rows: Triplets, place: Ints) -> Triplets:
    """Renumber the columns (rotation states)."""
    return Triplets((rows.indices[0], place[rows.indices[1]]), rows.values)


def _kept_rows(entries: Triplets, place: Ints) -> Triplets:
    """Renumber the rows (rotation states), leaving out those that are not kept."""
    rows = place[entries.indices[0]]
    return Triplets((rows[rows >= 0], entries.indices[1][rows >= 0]), entries.values[rows >= 0])
