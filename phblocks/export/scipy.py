"""Models for ``scipy.signal``."""

from __future__ import annotations

from typing import Any

from phblocks.export.matrices import Matrices
from phblocks.export.statespace import state_space


def to_scipy(m: Matrices, eliminate: bool = False) -> Any:
    """Make a ``scipy.signal.StateSpace`` of the tangent.

    Parameters
    ----------
    m : Matrices
        Such as ``system.matrices(state)`` or what :func:`phblocks.export.read` returns.
    eliminate : bool, optional
        Eliminate states without a rate that follow from the others.

    Returns
    -------
    scipy.signal.StateSpace
        Without names: those of inputs and outputs are ``m.input_names`` and ``m.output_names``, in the same order.

    Raises
    ------
    StructureError
        If E is singular, or states that are to be eliminated do not follow from the others.
    """
    from scipy.signal import StateSpace

    model = state_space(m, eliminate)
    return StateSpace(model.A, model.B, model.C, model.D)
