"""Models for pyMOR, whose port-Hamiltonian models have the same letters but ``y = (G + P)^T Q x + (S - N) u``."""

from __future__ import annotations

from typing import Any

from phblocks.export.extras import require_extra
from phblocks.export.matrices import Matrices
from phblocks.export.statespace import takes_part


def to_pymor(m: Matrices) -> Any:
    """Make a ``pymor.models.iosys.PHLTIModel``.

    Parameters
    ----------
    m : Matrices
        Such as ``system.matrices(state)``. The tangent and the constant load f0 are left out: the model is that of
        small departures with J, R and G as they are at the state.

    Returns
    -------
    PHLTIModel
        With ``N`` of the opposite sign. States that have no equation in these matrices (spans of lines, distances
        along guides) are left out.

    Raises
    ------
    ExtraMissingError
        If pyMOR is not installed.
    """
    iosys = require_extra("pymor.models.iosys", "pymor", "to_pymor")
    used = takes_part(m)
    square = {key: getattr(m, key)[used][:, used].tocsc() for key in ("J", "R", "E", "Q")}
    through = {key: getattr(m, key).toarray() for key in ("S", "N")}
    return iosys.PHLTIModel.from_matrices(
        **square,
        G=m.G[used].toarray(),
        P=m.P[used].toarray(),
        S=through["S"],
        N=-through["N"],
        name=m.name,
    )
