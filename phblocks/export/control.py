"""Models for python-control."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from phblocks.export.extras import require_extra
from phblocks.export.matrices import Matrices
from phblocks.export.statespace import legal_names, state_space
from phblocks.triplets import Floats

#: Of state and input to rates, or outputs.
Vector = Callable[[Floats, Floats], Floats]


def to_control(m: Matrices, eliminate: bool = False) -> Any:
    """Make a ``control.StateSpace`` of the tangent.

    Parameters
    ----------
    m : Matrices
        Such as ``system.matrices(state)`` or what :func:`phblocks.export.read` returns.
    eliminate : bool, optional
        Eliminate states without a rate that follow from the others.

    Returns
    -------
    control.StateSpace
        With the names of the matrices; what is not a letter or digit becomes an underscore.

    Raises
    ------
    StructureError
        If E is singular, or states that are to be eliminated do not follow from the others.
    ExtraMissingError
        If python-control is not installed.
    """
    control = require_extra("control", "control", "to_control")
    model = state_space(m, eliminate)
    return control.ss(
        *(model.A, model.B, model.C, model.D),
        states=legal_names(model.state_names),
        inputs=legal_names(m.input_names),
        outputs=legal_names(m.output_names),
        name=legal_names([m.name])[0],
        remove_useless_states=False,
    )


def nonlinear_to_control(
    name: str,
    rates: Vector,
    outputs: Vector,
    state_names: Sequence[str],
    input_names: Sequence[str],
    output_names: Sequence[str],
) -> Any:
    """Make a ``control.NonlinearIOSystem``.

    Parameters
    ----------
    name : str
        Of the system.
    rates, outputs : callable
        Of state and input.
    state_names, input_names, output_names : sequence of str
        As they are here.

    Returns
    -------
    control.NonlinearIOSystem
        With legal names.

    Raises
    ------
    ExtraMissingError
        If python-control is not installed.
    """
    control = require_extra("control", "control", "to_control")
    return control.nlsys(
        lambda t, x, u, params: rates(x, u),
        lambda t, x, u, params: outputs(x, u),
        states=legal_names(state_names),
        inputs=legal_names(input_names),
        outputs=legal_names(output_names),
        name=legal_names([name])[0],
    )
