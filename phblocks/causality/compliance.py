"""How stiff a joint, or how heavy a point, must be to stand in for one without compliance or mass.

What a port gives answers at once to what it takes: ``C = output E^-1 output^T`` is the velocity per impulse of a port
that gives velocity (``1/m + arm^2/I`` across the arm of a rigid body), and the force per displacement of one that
takes it (the stiffness of a spring). A stiffness k between two parts oscillates with ``sqrt(k (C_1 + C_2))``, a mass m
between stiffnesses with ``sqrt((K_1 + K_2) / m)``. Suggested is what oscillates a decade above the fastest that the
neighbours do already. For a joint of translation, what goes through translation counts: not the swing of a shaft
against a winding. A joint is never slower than where nothing sets a scale (1000 rad/s): it stands in
for a rigid one, and the slower its neighbours are the further it would give way.

How fast that is must not depend on a mesh: a finer one carries faster waves and has less mass at its end, and a joint
that becomes stiffer with it is another joint, so that a refinement would not be one of the same diagram. So a beam
counts as it is on its coarsest mesh (``Block.coarsest``): two elements, whose waves are as fast as its length and its
section say. The frequency that is reported is that with the mesh as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.linalg import block_diag
from scipy.sparse.linalg import splu

from phblocks.blocks.block import Block
from phblocks.blocks.form import AngleRows, Form, Piece
from phblocks.causality.meetings import Meeting
from phblocks.frames import rotate
from phblocks.network import Junction, Network
from phblocks.ports import Anchor, Domain, Port
from phblocks.triplets import Floats, Ints

#: How far above what is there already.
DECADE = 10.0
#: What is there if nothing says so, rad/s: fast for a mechanism. A decade above, the deflection under the own weight is
#: g / (1000 rad/s)^2, a hundredth of a millimetre.
SCALE = 100.0


@dataclass(frozen=True)
class Forms:
    """From a block to its form.

    Parameters
    ----------
    meshed, coarsest : callable
        As it is, and on its coarsest mesh.
    """

    meshed: Callable[[Block], Form]
    coarsest: Callable[[Block], Form]


@dataclass(frozen=True)
class Suggestion:
    """What to put in, and the frequency it adds.

    Parameters
    ----------
    value : float
        Stiffness, N/m (N m/rad between ports of rotation), or mass, kg; rounded to three digits.
    frequency : float
        The highest that it adds with what is joined to it otherwise free, rad/s.
    weights : numpy.ndarray
        Of a stiffness: what ``value`` is multiplied by for each component, translation first, shape (components,).
    """

    value: float
    frequency: float
    weights: Floats


def answer(network: Network, form: Form, ports: Sequence[Port]) -> Floats:
    """Return what ports of a block give at once for a unit of what they take, ``output E^-1 output^T``.

    Parameters
    ----------
    network : Network
        For the components of space.
    form : Form
        Of the block.
    ports : sequence of Port
        Its ports.

    Returns
    -------
    numpy.ndarray
        Shape (components, components), symmetric positive semidefinite, in the fixed frame at the start: velocity
        per impulse (1/kg) where ports give velocity, force per displacement (N/m) where they take it.
    """
    output, E, stores = _stored(network, form, ports)
    return np.asarray(output @ splu(E).solve(output.T)) if stores.size else np.zeros((len(output), len(output)))


def _stored(network: Network, form: Form, ports: Sequence[Port]) -> tuple[Floats, sp.csc_array, Ints]:
    """What ports give of the states with energy, in the fixed frame at the start, with E and the numbers of these."""
    rows = []
    for port in ports:
        out = np.zeros((len(port.domain.components(network.space)), form.size))
        for piece in form.ports[port.name].pieces:
            out += _in_fixed_frame(form, port, piece)
        rows.append(out)
    output = np.concatenate(rows)
    E = form.E.csr((form.size, form.size))
    stores = np.flatnonzero(E.diagonal() > 0.0)
    return output[:, stores], sp.csc_array(E[stores][:, stores]), stores


def _in_fixed_frame(form: Form, port: Port, piece: Piece) -> Floats:
    """What a piece gives at the start, shape (components, states)."""
    if piece.line is not None:
        assert form.start is not None
        first = form.lines[piece.line].span
        span = form.start[first : first + 2]
        return np.outer(span / np.linalg.norm(span), piece.output.csr((1, form.size)).toarray())
    if port.domain.turns_with != "translation":
        return np.asarray(piece.output.csr((1, form.size)).toarray())
    frame = piece.frame
    if frame is None and port.anchor is not None:
        frame = form.orientations.get(port.anchor.name)
    anchor = frame if isinstance(frame, Anchor) else port.anchor
    angle = anchor.angle if anchor else 0.0
    if isinstance(frame, AngleRows):
        angle = float(frame.reference[0])
    return rotate(np.asarray(angle), piece.output.csr((2, form.size)).toarray().T).T


def fastest_beside(
    network: Network, forms: Forms, blocks: Collection[Block], known: Collection[str], domains: Collection[Domain]
) -> float:
    """Find the fastest oscillation of blocks against what is joined to them, or inside one of both.

    Parameters
    ----------
    network : Network
        The network.
    forms : Forms
        From a block to its form; those on the coarsest mesh count.
    blocks : collection of Block
        The blocks.
    known : collection of str
        Names of the blocks that count; those that a repair has put in do not.
    domains : collection of Domain
        Of the junctions that count.

    Returns
    -------
    float
        The largest ``sqrt(C_giver C_taker)`` over their junctions, and the largest ``|J C| / |C|`` inside, in the norm
        of energy, rad/s; zero if there is no stiffness.
    """
    fastest = 0.0
    for junction in network.joined:
        ports = [p for p in junction.ports if p.block.name in known]
        if junction.domain not in domains or not any(p.block in blocks for p in ports):
            continue
        fastest = max([fastest, *(_inside(network, forms.coarsest(p.block), p) for p in ports)])
        tops = [(p, float(np.linalg.eigvalsh(answer(network, forms.coarsest(p.block), [p]))[-1])) for p in ports]
        for giver, inertia in tops:
            for taker, stiffness in tops:
                gives = [forms.coarsest(p.block).ports[p.name].gives for p in (giver, taker)]
                if gives == [True, False] and (giver.block in blocks or taker.block in blocks):
                    fastest = max(fastest, inertia * stiffness)
    return float(np.sqrt(max(fastest, 0.0)))


def _inside(network: Network, form: Form, port: Port) -> float:
    """Square of the frequency at which what a port moves at once passes its energy on inside the block."""
    output, E, stores = _stored(network, form, [port])
    if not stores.size:
        return 0.0
    factor = splu(E)
    moved = factor.solve(output.T)
    passed = form.J0.csr((form.size, form.size))[stores][:, stores] @ moved
    energy, after = np.einsum("im,im->m", output.T, moved), np.einsum("im,im->m", passed, factor.solve(passed))
    return float((after[energy > 0.0] / energy[energy > 0.0]).max(initial=0.0))


def suggest_stiffness(network: Network, forms: Forms, meeting: Meeting, known: Collection[str]) -> Suggestion | None:
    """Suggest the stiffness between parts that all give velocity.

    The slowest oscillation it adds is a decade above the fastest of these parts against their neighbours
    (:func:`fastest_beside`) in the domains that the joint holds, but never below 1000 rad/s, which is also what it is
    if they have none with energy; all beams on their coarsest mesh.
    Stiffness is the same in all directions; that against turning, in a weld, is chosen so that it alone would add the
    same frequency.

    Parameters
    ----------
    network : Network
        The network.
    forms : Forms
        From a block to its form.
    meeting : Meeting
        The parts.
    known : collection of str
        Names of the blocks that set the scale.

    Returns
    -------
    Suggestion or None
        With the highest frequency added, of the parts free otherwise; ``None`` if one of them has no inertia,
        or so little that its inverse, or the stiffness, is no number.
    """
    sides = [meeting.ports_of(p) for p in meeting.others]
    still = meeting.ports_of(meeting.hub)  # none of the outside, which does not give way
    compliance = _compliance(network, forms.coarsest, still, sides)
    meshed = _compliance(network, forms.meshed, still, sides)
    if not (np.isfinite(compliance).all() and np.isfinite(meshed).all()):
        return None
    first = len(sides[0][0].domain.components(network.space))
    one = compliance[: len(compliance) // len(sides), : len(compliance) // len(sides)]
    slow = float(np.linalg.eigvalsh(one[:first, :first])[0])
    weights = np.ones(len(one))
    if len(one) > first:
        turning = float(np.linalg.eigvalsh(one[first:, first:])[0])
        if not turning > 0.0:
            return None
        weights[first:] = _rounded(slow / turning)
    root = np.tile(np.sqrt(weights), len(sides))
    values = np.linalg.eigvalsh(root[:, None] * compliance * root)
    if not values[0] > 1e-12 * values[-1]:
        return None
    blocks = {port.block for ports in (still, *sides) for port in ports if not port.block.shared}
    domains = {port.domain for ports in sides for port in ports}
    target = DECADE * max(fastest_beside(network, forms, blocks, known, domains), SCALE)
    stiffness = _rounded(target * target / values[0])
    if not np.isfinite(stiffness):
        return None
    tops, directions = np.linalg.eigh(root[:, None] * meshed * root)
    impulses = np.split(root * directions[:, -1], len(sides))
    moved = [(still, -np.sum(impulses, axis=0))] if still else []
    moved += zip(sides, impulses, strict=True)
    # of the energy of this motion, what goes into the spring at first and what into the parts themselves
    inside = sum(_passed(network, forms.meshed(ports[0].block), ports, impulse) for ports, impulse in moved)
    return Suggestion(stiffness, float(np.sqrt(stiffness * tops[-1] + inside / tops[-1])), weights)


def _passed(network: Network, form: Form, ports: Sequence[Port], impulse: Floats) -> float:
    """What a block moved at once by impulses on its ports passes on inside, squared in the norm of energy."""
    output, E, stores = _stored(network, form, ports)
    if not stores.size:
        return 0.0
    factor = splu(E)
    passed = form.J0.csr((form.size, form.size))[stores][:, stores] @ factor.solve(output.T @ impulse)
    return float(passed @ factor.solve(passed))


def _compliance(
    network: Network, form: Callable[[Block], Form], still: Sequence[Port], sides: Sequence[Sequence[Port]]
) -> Floats:
    """Velocities of the sides against the hub per impulses between them, shape (components of all sides,) twice."""
    others = [answer(network, form(ports[0].block), ports) for ports in sides]
    hub = answer(network, form(still[0].block), still) if still else np.zeros_like(others[0])
    return np.asarray(np.kron(np.ones((len(others), len(others))), hub) + block_diag(*others))


def suggest_mass(network: Network, forms: Forms, junction: Junction, known: Collection[str]) -> Suggestion | None:
    """Suggest the mass of a point at which only parts without mass meet.

    The frequency it adds along the stiffest direction, ``sqrt(K / m)`` with the other ends of these parts held, is a
    decade above the fastest translation that they take part in already (:func:`fastest_beside`), or 1000 rad/s if
    there is none.

    Parameters
    ----------
    network : Network
        The network.
    forms : Forms
        From a block to its form.
    junction : Junction
        Where they meet.
    known : collection of str
        Names of the blocks that set the scale.

    Returns
    -------
    Suggestion or None
        ``None`` if none of the parts has a stiffness, or one so large that the mass is no number.
    """
    coarse, top = (
        float(np.linalg.eigvalsh(sum(answer(network, form(p.block), [p]) for p in junction.ports))[-1])
        for form in (forms.coarsest, forms.meshed)
    )
    if not coarse > 0.0:
        return None
    fastest = fastest_beside(network, forms, {p.block for p in junction.ports}, known, {junction.domain})
    target = DECADE * (fastest or SCALE)
    mass = _rounded(coarse / (target * target))
    if not mass > 0.0:
        return None
    return Suggestion(mass, float(np.sqrt(top / mass)), np.ones(1))


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")
