"""Checks of the options of methods, and of the systems they are for."""

from __future__ import annotations

import numpy as np

from phblocks.blocks.checks import require_flag as require_flag
from phblocks.errors import ArgumentTypeError, DataError, MethodError
from phblocks.solvers.newton import Newton
from phblocks.system import System


def require_newton(where: str, newton: object) -> None:
    """Check that these are options of Newton's method.

    Parameters
    ----------
    where : str
        The method.
    newton : object
        What was given.

    Raises
    ------
    ArgumentTypeError
        If they are not.
    """
    if not isinstance(newton, Newton):
        raise ArgumentTypeError(
            f"{where} newton", expected="options of Newton's method", got=repr(newton), fix="Use ph.Newton()."
        )


def require_stages(where: str, stages: object, one: str) -> None:
    """Check a number of stages.

    Parameters
    ----------
    where : str
        The method.
    stages : object
        What was given.
    one : str
        What to do for another number.

    Raises
    ------
    DataError
        If the number is another than 2 or 3.
    ArgumentTypeError
        If it is not a number.
    """
    if isinstance(stages, bool) or not isinstance(stages, (int, np.integer)):
        raise ArgumentTypeError(f"{where} stages", expected="2 or 3", got=repr(stages), fix="Use 2.")
    if stages not in (2, 3):
        raise DataError(f"{where} stages", expected="2 or 3", got=repr(stages), fix=one)


def require_quadratic(where: str, system: System, otherwise: str = "") -> None:
    """Check that a method that keeps quadratic energies only keeps that of the system.

    Parameters
    ----------
    where : str
        The method.
    system : System
        The system.
    otherwise : str, optional
        What else can be done.

    Raises
    ------
    MethodError
        If the energy is not quadratic.
    """
    if not system.quadratic:
        names = ", ".join(repr(p.name) for p in system.parts if p.form.storage is not None)
        raise MethodError(
            f"{where} for system {system.name!r}",
            expected="an energy that is quadratic in the states",
            got=f"another one in {names}",
            fix=f"Use ph.DiscreteGradient(){otherwise}.",
        )
