"""Effects that any block can leave out: frames that turn, and weight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from phblocks.approximation import Approximation
from phblocks.blocks.form import FIXED, AngleRows, Form, Piece
from phblocks.triplets import Floats, Triplets


def reduced(form: Form, kept: Approximation, angles: Mapping[str, float]) -> Form:
    """Leave out what is not kept.

    Parameters
    ----------
    form : Form
        Of the block.
    kept : Approximation
        What is kept.
    angles : mapping of str to float
        Initial orientation of each anchor, rad.

    Returns
    -------
    Form
        The very same object if nothing is left out.
    """
    turns = bool(form.T.values.size or form.rotation_states.size or form.lines) and not form.frozen
    if kept.large_rotation is False and turns:
        form = frozen(form, angles)
    if not kept.gravity and form.points is not None:
        form = replace(form, points=replace(form.points, weighs=False))
    return form


def frozen(form: Form, angles: Mapping[str, float]) -> Form:
    """Hold all frames of a block in their initial orientation, and drop the products of its states.

    Parameters
    ----------
    form : Form
        Of the block.
    angles : mapping of str to float
        Initial orientation of each anchor, rad, for those that take it from elsewhere.

    Returns
    -------
    Form
        Linear: ``J = J0 + T x_start``, and lines of action keep their initial direction.
    """
    J0 = form.J0 if form.start is None else Triplets.join([form.J0, form.T.contracted(form.start)])
    return replace(
        form,
        J0=J0,
        T=Triplets.empty(3),
        ports={name: replace(port, pieces=_held(form, port.pieces)) for name, port in form.ports.items()},
        orientations={
            name: _constant(rows.reference if isinstance(rows, AngleRows) else np.array([angles[name]]))
            for name, rows in form.orientations.items()
        },
        points=None if form.points is None else replace(form.points, angle=_constant(form.points.angle.reference)),
        loads={name: _held(form, pieces) for name, pieces in form.loads.items()},
        frozen=True,
    )


def _constant(reference: Floats) -> AngleRows:
    return AngleRows(Triplets.empty(), reference)


def _held(form: Form, pieces: Sequence[Piece]) -> tuple[Piece, ...]:
    return tuple(_still(form, piece) for piece in pieces)


def _still(form: Form, piece: Piece) -> Piece:
    if piece.line is not None:  # a line is a state of the configuration, so the block has a start
        assert form.start is not None
        first = form.lines[piece.line].span
        unit = form.start[first : first + 2] / np.linalg.norm(form.start[first : first + 2])
        state, values = piece.output.indices[1], piece.output.values
        return Piece(Triplets.of([[0], [1]], state[None], values=unit[:, None] * values), FIXED)
    if isinstance(piece.frame, AngleRows):
        return replace(piece, frame=_constant(piece.frame.reference))
    return piece
