"""From blocks and an assignment of causality to one system: the Dirac structure, stacked and interconnected.

At each junction the giving port g and each taking port t exchange ``v_t = C v_g`` and ``f_g = -C^T f_t`` with
``C = Lambda_t^T Lambda_g``: the same rotation on both sides, transposed, so that J stays skew. Where g and t
keep their angle to each other, the exchange is part of the constant J0, elsewhere of K.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from phblocks.assembly.entries import Entries, number_features, split_constant, with_feature
from phblocks.assembly.exchange import find_exchange
from phblocks.assembly.explanation import describe
from phblocks.assembly.joints import collect
from phblocks.assembly.layout import Layout, lay_out
from phblocks.assembly.points import Points
from phblocks.assembly.pruning import everything, hides_multipliers, prune
from phblocks.assembly.sharing import share
from phblocks.assembly.sites import find_sites
from phblocks.assembly.structure import check_structure
from phblocks.blocks.checks import is_one_of
from phblocks.causality import CausalityReport
from phblocks.effects import EffectsReport
from phblocks.errors import DataError, OrientationError
from phblocks.frames import Turn
from phblocks.network import Network
from phblocks.system import (
    DROPPED,
    STILL,
    Angles,
    Connections,
    Exchange,
    Lines,
    Part,
    Pruning,
    Sharing,
    State,
    System,
    find_constraints,
    require_independent,
)
from phblocks.triplets import Floats, Ints, Triplets

Outputs = Literal["all"] | None


Effects = Literal["auto", "all"]


def assemble(network: Network, report: CausalityReport, outputs: Outputs = "all", effects: Effects = "auto") -> System:
    """Assemble a network.

    Parameters
    ----------
    network : Network
        Blocks and junctions.
    report : CausalityReport
        Who gives and who takes; must be ok.
    outputs : {"all", None}, optional
        "all" keeps orientations and positions of all blocks; ``None`` only what the physics needs.
    effects : {"auto", "all"}, optional
        "auto" leaves out what is proven to stay zero; "all" computes it too.

    Returns
    -------
    System
        With its structure verified.

    Raises
    ------
    DataError
        If outputs is neither "all" nor None, or effects neither "auto" nor "all".
    StructureError
        If the matrices violate the port-Hamiltonian structure.
    ConstraintError
        If a constraint follows from others.
    GapError
        If what is joined to a block is not in the place that the block was given.
    OrientationError
        If something depends on how frames stand that turn in space.
    """
    if not is_one_of(outputs, ("all", None)):
        raise DataError("compile outputs", expected='"all" or None', got=repr(outputs), fix='Use outputs="all".')
    if not is_one_of(effects, ("auto", "all")):
        raise DataError("compile effects", expected='"auto" or "all"', got=repr(effects), fix='Use effects="auto".')
    layout = lay_out(network, report)
    whole = collect(layout)
    gravity = np.zeros(network.space.dimension) if network.gravity is None else network.gravity
    _require_frames(layout, gravity)
    heavy = bool(gravity.any()) and any(f.points is not None and f.points.weighs for f in layout.forms.values())
    points = Points.of(layout) if heavy or outputs == "all" else Points.of(layout, ())
    shared = share(layout.teams, layout.pieces, network, layout.n)
    if effects == "auto":
        kept = prune(layout, whole, points if heavy else Points.of(layout, ()), gravity, shared)
    else:
        kept = everything(layout, 'asked for with effects="all"')
    if hides_multipliers(layout, kept):
        assemble(network, report, outputs, "all")  # refuse what is redundant or undetermined, also where nothing moves
    begin = _start(layout)
    sharing = shared.without(kept.dropped, begin)
    rotations = _rotations(layout, whole, points if heavy else None, outputs)
    joints, number = kept.joints(whole)
    points = kept.points(points)
    n_joints = len(joints.turns)
    n_angles = n_joints + (points.mass.size if heavy else 0)
    angle_rows = [_turn_rows(joints.turns)]
    references = [np.array([t.reference for t in joints.turns])]
    if heavy:
        angle_rows.append(points.angle.rows.shifted(n_joints, 0))
        references.append(points.angle.reference)
    rows = Triplets.join(angle_rows)
    keep = _rotations(layout, joints, points if heavy else None, outputs) & ~kept.still
    same = np.concatenate([layout.theta_same, np.arange(layout.theta_same.size, layout.n_theta)])
    place = np.where(kept.still, STILL, np.where(keep, np.cumsum(keep) - 1, DROPPED))[same]
    n, m, n_theta = sharing.kept.size, len(layout.inputs), int(keep.sum())
    forms = [(name, layout.forms[name], layout.first_state[name]) for name in layout.forms]
    moving = [(name, f, i) for name, f, i in forms if not kept.dropped[i : i + f.size].all()]
    driven_rows, driven_inputs = layout.driven_rows()
    held = [f.storage.shifted(i) for _, f, i in forms if f.storage is not None]
    local = Triplets.join(f.kinematics.shifted(i, i) for _, f, i in forms)
    joints.kinematics += [with_feature(local, 0)]
    joints.kinematics += [Triplets.of(s.energy, s.coenergy, 0, values=1.0) for s in held]
    supply = number_features(Triplets.join(joints.K_u, order=3), n_angles, len(joints.directions))
    exchange = number_features(Triplets.join(joints.K, order=3), n_angles, len(joints.directions))
    fixed, turning = split_constant(sharing.reduced(exchange, (0, 1)))
    fixed_u, turning_u = split_constant(sharing.reduced(supply, (0,)))
    sites, guides = find_sites(layout)
    kinematics_u = split_constant(number_features(Triplets.join(joints.kinematics_u, order=3), n_angles, 0))[0]
    lines, line_places = _lines(layout, joints, sharing, kept.dropped, place, n_theta)

    exchanged = find_exchange(layout, joints.pairs, place, n_theta, line_places)
    number_of = np.where(kept.dropped, -1, 0)[shared.kept]
    number_of[number_of == 0] = np.arange(n)

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
        E=matrix(f.E.shifted(i, i) for _, f, i in moving).csr((n, n)),
        J0=Triplets.join([matrix(f.J0.shifted(i, i) for _, f, i in moving), fixed]).csr((n, n)),
        R0=matrix(f.R.shifted(i, i) for _, f, i in moving).csr((n, n)),
        T=sharing.reduced(Triplets.join((f.T.shifted(i, i, i) for _, f, i in moving), order=3), (0, 1, 2)).coo(
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
        lines=lines,
        kinematics=sharing.reduced(number_features(Triplets.join(joints.kinematics, order=3), n_angles, 0), (0, 1)),
        kinematics_u=sharing.reduced(kinematics_u, (0,)).csr((n, m)),
        connections=_connections(layout, joints, number, n_angles, supply, exchanged),
        sites=sites,
        guides=guides,
        anchor_angles=layout.anchor_angles(place),
        attitudes=layout.attitudes,
        point_mass=points.mass,
        point_velocity=sharing.reduced(points.velocity, (1,)).csr((points.mass.size * network.space.dimension, n)),
        point_angles=Angles(_kept(points.angle.rows, place).csr((points.mass.size, n_theta)), points.angle.reference),
        start=State(begin[sharing.kept], np.zeros(n_theta), points.start),
        sharing=sharing,
        report=report,
        pruning=Pruning(shared.kept, number_of, place[rotations], kept.quiet, sharing.state_of(kept.held)),
        effects=EffectsReport(
            lambda: describe(layout, kept, place, points.of_block, _needs(heavy, outputs), system.linear)
        ),
    )
    check_structure(system)
    if system.is_dae:
        require_independent(system, find_constraints(system))
    return system


def _require_frames(layout: Layout, gravity: Floats) -> None:
    """Refuse weight on what turns in space."""
    heavy = [name for name, f in layout.forms.items() if f.unoriented and layout.network.blocks[name].kept.gravity]
    if gravity.any() and heavy:
        raise OrientationError(
            f"gravity on {heavy[0]!r}",
            expected="parts whose frames stay as they are (large_rotation=False), or a planar diagram",
            got="a part that turns in space: how its frames stand then is not computed yet",
            fix="Leave out gravity or large rotations (ph.Approximation), or draw it in the plane.",
        )


def _needs(heavy: bool, outputs: Outputs) -> str:
    """What positions, and orientations of all that moves, are kept for."""
    return "gravity acts" if heavy else 'asked for with outputs="all"' if outputs == "all" else ""


def _start(layout: Layout) -> Floats:
    parts = [np.zeros(form.size) if form.start is None else form.start for form in layout.forms.values()]
    return np.concatenate(parts)


def _rotations(layout: Layout, joints: Entries, heavy: Points | None, outputs: Outputs) -> NDArray[np.bool_]:
    """The rotation states that outputs, joints or gravity on points ask for; of those that are the same the first."""
    numbers = np.arange(layout.n_theta)
    same = np.concatenate([layout.theta_same, numbers[layout.theta_same.size :]]) == numbers
    if outputs == "all":
        return np.asarray(same)
    turns = [*joints.turns, *(turn for _, turn in joints.directions)]
    seen = [_turn_rows(turns).indices[1]] + ([] if heavy is None else [heavy.angle.rows.indices[1]])
    # how far a frozen block has turned is looked at after a run
    frozen = [
        layout.first_theta[name] + np.arange(form.rotation_states.size)
        for name, form in layout.forms.items()
        if form.frozen
    ]
    return np.asarray(same & np.isin(numbers, np.concatenate([*seen, *frozen])))


def _connections(
    layout: Layout, joints: Entries, number: Ints, n_angles: int, supply: Triplets, exchange: Exchange
) -> Connections:
    return Connections(
        tuple((giver.path, taker.path) for giver, taker in joints.pairs),
        np.array([[layout.block_number(p.block.name) for p in pair] for pair in joints.pairs], dtype=np.int64).reshape(
            -1, 2
        ),
        number,
        number_features(joints.flows[0][0], n_angles, len(joints.directions)),
        supply,
        exchange,
    )


def _lines(
    layout: Layout, joints: Entries, sharing: Sharing, dropped: NDArray[np.bool_], place: Ints, n_theta: int
) -> tuple[Lines, Ints]:
    """The lines that are kept, the frames in which their directions are seen, and the place of each line or -1."""
    every = [(layout.first_state[name], line) for name, form in layout.forms.items() for line in form.lines]
    stay = np.array([not dropped[first + line.span] for first, line in every], dtype=bool)
    places = np.where(stay, np.cumsum(stay) - 1, -1)
    numbered = [pair for pair, here in zip(every, stay, strict=True) if here]
    stretches = [
        Triplets.of([m], [first + line.stretch[0]], values=line.stretch[1])
        for m, (first, line) in enumerate(numbered)
        if line.stretch is not None
    ]
    turns = [turn for _, turn in joints.directions]
    spans = np.array([(f + line.span, f + line.span + 1) for f, line in numbered], dtype=np.int64).reshape(-1, 2)
    lines = Lines(
        spans=sharing.state_of(spans),
        free=np.array([line.free for _, line in numbered]),
        stretch=sharing.reduced(Triplets.join(stretches), (1,)).csr((len(numbered), sharing.kept.size)),
        taut=np.array([line.stretch is not None for _, line in numbered], dtype=bool),
        line=places[np.array([line for line, _ in joints.directions], dtype=np.int64)],
        frames=Angles(
            _kept(_turn_rows(turns), place).csr((len(turns), n_theta)), np.array([t.reference for t in turns])
        ),
    )
    return lines, places


def _turn_rows(turns: Sequence[Turn]) -> Triplets:
    rows = [m for m, turn in enumerate(turns) for _ in turn.places]
    places = [p for turn in turns for p in turn.places]
    return Triplets.of(rows, places, values=[w for turn in turns for w in turn.weights]) if rows else Triplets.empty()


def _kept(rows: Triplets, place: Ints) -> Triplets:
    """Renumber the columns (rotation states), leaving out those that stay zero."""
    column = place[rows.indices[1]]
    turning = column != STILL
    return Triplets((rows.indices[0][turning], column[turning]), rows.values[turning])


def _kept_rows(entries: Triplets, place: Ints) -> Triplets:
    """Renumber the rows (rotation states), leaving out those that are not kept."""
    rows = place[entries.indices[0]]
    return Triplets((rows[rows >= 0], entries.indices[1][rows >= 0]), entries.values[rows >= 0])
