"""The bushing: an elastic joint of no length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from phblocks.blocks.block import Block, PortChoice, Tie
from phblocks.blocks.branch import entries, state
from phblocks.blocks.checks import require_finite, require_matrix, require_semidefinite
from phblocks.blocks.form import FIXED, AngleRows, Form, Piece, PortForm
from phblocks.errors import DataError
from phblocks.frames import QUARTER
from phblocks.ports import Anchor
from phblocks.space import PLANAR, Space
from phblocks.triplets import Floats, Triplets

#: Eigenvalues below this, relative to the largest, are directions without stiffness or damping.
SLACK = 1e-12


class Bushing(Block):
    """An elastic joint of no length, with full stiffness and damping matrices.

    With the deflection ``q = (dx, dy, angle)`` of second against first, components in a frame that turns with first,
    the elastic part of force and moment is ``K q`` and the viscous one ``C q'``. The state is the elastic force with
    the compliance ``K^-1`` (on the range of K), so deflection and force never separate. The force acts on first
    where second is, so first also takes the moment of the force with the deflection as lever: momentum and angular
    momentum are balanced, and power exactly.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    stiffness : array_like
        K, shape (3, 3), symmetric, positive semidefinite: N/m, N/rad, N m/rad.
    damping : array_like, optional
        C, shape (3, 3), symmetric, positive semidefinite; none by default.
    angle : float, optional
        Of the first axis of the frame at the start, rad.

    Attributes
    ----------
    first, second : Anchor
        To be joined with ``weld``; they take velocity and angular velocity.

    Raises
    ------
    DataError
        If a matrix has the wrong shape, or the stiffness is zero.
    StructureError
        If a matrix is not symmetric and positive semidefinite.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    def __init__(self, name: str, stiffness: ArrayLike, damping: ArrayLike | None = None, angle: float = 0.0) -> None:
        super().__init__(name)
        where = f"Bushing {name!r}"
        self.stiffness = require_matrix(f"{where} stiffness", stiffness, (3, 3))
        self.damping = require_matrix(f"{where} damping", np.zeros((3, 3)) if damping is None else damping, (3, 3))
        require_semidefinite(f"{where} stiffness", self.stiffness)
        require_semidefinite(f"{where} damping", self.damping)
        if not self.stiffness.any():
            raise DataError(f"{where} stiffness", expected="some stiffness", got="none", fix="Leave it out.")
        self.angle = require_finite(f"{where} angle", angle)
        self.first = Anchor(self, "first", None)
        self.second = Anchor(self, "second", None)

    @property
    def anchors(self) -> Mapping[str, Anchor]:
        """Both anchors by name."""
        return {"first": self.first, "second": self.second}

    @property
    def space(self) -> Space:
        """The plane."""
        return PLANAR

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that all ports take velocity.

        Returns
        -------
        choices : sequence of PortChoice
            Four.
        ties : sequence of Tie
            None.
        """
        return [PortChoice(p, may_give=False, may_take=True) for p in self.ports.values()], []

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the bushing to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            Always false.

        Returns
        -------
        Form
            Elastic forces along the stiff directions, viscous ones along the damped directions, then the moment on
            first and its angular velocity; only the elastic ones store energy.
        """
        stiff, k = _range(self.stiffness)
        damped, c = _range(self.damping)
        directions = np.hstack([stiff, damped])  # generalised force on second = directions @ (elastic, viscous)
        f = directions.shape[1]
        moment, spin, size = f, f + 1, f + 2
        E, J, R, T = np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size)), np.zeros((size,) * 3)
        E[: k.size, : k.size] = np.diag(1.0 / k)
        R[k.size : f, k.size : f] = np.diag(1.0 / c)
        # rows of the forces: directions^T (v_second - v_first - spin x q, w_second - spin), q = stiff E elastic
        J[:f, spin], J[spin, :f] = -directions[2], directions[2]
        J[moment, spin], J[spin, moment] = -1.0, 1.0  # 0 = w_first - spin, and its moment
        lever = -directions[:2].T @ QUARTER @ stiff[:2] / k
        T[:f, spin, : k.size], T[spin, :f, : k.size] = lever, -lever
        runs = [state(f"elastic{i}", "N", "strain") for i in range(k.size)]
        runs += [state(f"viscous{i}", "N") for i in range(c.size)]
        runs += [state("M3", "N m"), state("W3", "rad/s")]
        frame = AngleRows(Triplets.of([0], [0], values=1.0), np.array([self.angle]))
        force, turn, held = np.zeros((2, size)), np.zeros((1, size)), np.zeros((1, size))
        force[:, :f], turn[0, :f], held[0, moment] = directions[:2], directions[2], 1.0
        given = {
            self.first.translation: Piece(entries(-force), frame),
            self.second.translation: Piece(entries(force), frame),
            self.first.rotation: Piece(entries(held), FIXED),
            self.second.rotation: Piece(entries(turn), FIXED),
        }
        return Form(
            size=size,
            runs=runs,
            E=entries(E),
            J0=entries(J),
            R=entries(R),
            T=entries(T) if T.any() else Triplets.empty(3),
            ports={port.name: PortForm(False, (piece,)) for port, piece in given.items()},
            rotation_states=np.array([spin]),
            orientations={"first": None, "second": None},
        )


def _range(matrix: Floats) -> tuple[Floats, Floats]:
    """Directions that span the range of a symmetric matrix, shape (3, rank), and the eigenvalues."""
    values, vectors = np.linalg.eigh(matrix)
    kept = values > SLACK * values.max()
    return vectors[:, kept], values[kept]
