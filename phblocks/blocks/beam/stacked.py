"""The matrices and ports of a beam with what is left out and with damping, in any space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from phblocks.approximation import Approximation
from phblocks.blocks.beam.damping import Damping, damp
from phblocks.blocks.beam.ends import End
from phblocks.blocks.beam.matrices import beam_matrices, trace
from phblocks.blocks.beam.mesh import Mesh
from phblocks.blocks.beam.omission import kept_coefficients, kept_damping, without_energy
from phblocks.blocks.form import Piece, PortForm, StateRun
from phblocks.triplets import Floats, Ints, Triplets

PAIRS = (("translation", "V", "N"), ("rotation", "W", "M"))


@dataclass(frozen=True)
class Stacked:
    """What of a beam does not depend on where it is.

    Parameters
    ----------
    runs : sequence of StateRun
        Its states: those of the mesh and after them the viscous parts of stresses.
    E, J0, R : Triplets
        Shape (size, size).
    T : Triplets
        Shape (size, size, size).
    copies : numpy.ndarray
        For each state of the mesh the state that is its viscous part, or -1; shape (0,) without damping.
    coefficients : numpy.ndarray
        Shape (12,): inertias and compliances in E.
    ports : mapping of str to PortForm
        In the frames of the ends.
    spins : numpy.ndarray
        The states that are angular velocities.
    """

    runs: Sequence[StateRun]
    E: Triplets
    J0: Triplets
    R: Triplets
    T: Triplets
    copies: Ints
    coefficients: Floats
    ports: Mapping[str, PortForm]
    spins: Ints

    @property
    def size(self) -> int:
        """Number of states."""
        return sum(run.positions.size for run in self.runs)


def stack(
    mesh: Mesh,
    ends: tuple[End, End],
    coefficients: Floats,
    offsets: Floats,
    damping: Damping | None,
    kept: Approximation,
) -> Stacked:
    """Reduce a beam to its matrices.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering, made for the same ends.
    ends : tuple of End
        What the start and the end give.
    coefficients : numpy.ndarray
        Shape (12,): inertias and compliances per length.
    offsets : numpy.ndarray
        Shape (12,): the constant part of strain and curvature.
    damping : Damping or None
        Of the beam.
    kept : Approximation
        Which strains, inertias and products are kept.

    Returns
    -------
    Stacked
        Matrices and ports.
    """
    full = coefficients
    coefficients, modulating = kept_coefficients(full, kept)
    E, J0, T = beam_matrices(mesh, coefficients, offsets, modulating)
    runs, R, copies = mesh.runs, Triplets.empty(), np.empty(0, dtype=np.int64)
    damping = None if damping is None else kept_damping(damping, kept)
    if damping is not None:
        inertia = E if coefficients is full else beam_matrices(mesh, full, offsets)[0]  # drag needs no inertia
        damped = damp(mesh, (inertia, J0, T), full, damping)
        runs, J0, R, T, copies = damped.runs, damped.J0, damped.R, damped.T, damped.copies
    sizes = [run.positions.size for run in mesh.runs]
    turning = np.repeat([run.field.startswith("W") for run in mesh.runs], sizes)
    ports = {
        f"{name}.{kind}": _port(mesh, copies, pair, gives, at_end)
        for name, at_end, end in (("start", False, ends[0]), ("end", True, ends[1]))
        for (kind, *pair), gives in zip(PAIRS, end, strict=True)
    }
    return Stacked(
        without_energy(runs, coefficients), E, J0, R, T, copies, coefficients, ports, np.flatnonzero(turning)
    )


def _port(mesh: Mesh, copies: Ints, pair: Sequence[str], gives: bool, at_end: bool) -> PortForm:
    """A port of an end; pair is that of its velocity and its stress."""
    common, summed = pair
    directions = mesh.space.translation if common == "V" else mesh.space.rotation
    states = [trace(mesh, common if gives else summed, d, at_end) for d in directions]
    sign = 1.0 if gives or at_end else -1.0  # -N(0) and +N(L) are the forces on the beam
    output = Triplets.of(np.arange(len(states)), states, values=sign)
    if copies.size:  # the force is that of the elastic and the viscous part
        viscous = copies[states] >= 0
        added = Triplets.of(np.flatnonzero(viscous), copies[states][viscous], values=sign)
        output = Triplets.join([output, added])
    return PortForm(gives, (Piece(output),))
