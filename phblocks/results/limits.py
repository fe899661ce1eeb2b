"""What the health of a run is judged by."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from phblocks.errors import ArgumentTypeError, DataError

#: Of methods that do not keep energy a balance as good as this is expected.
DRIFT = 1e-2


@dataclass(frozen=True)
class Limits:
    """Above which number a run is not healthy; infinity asks for no warning.

    Parameters
    ----------
    balance : float, optional
        Residual of the balance of energy, of a step and since the start, over the largest energy.
    unresolved : float, optional
        Share of the stored energy that the steps do not resolve.
    gap : float, optional
        Distance of positions from strain and from velocity over the size of the block.
    closure : float, optional
        Gap of a joint over the size of the largest block in it.
    momentum : float, optional
        Drift of the momentum of free bodies, relative.
    alternation : float, optional
        Part of a multiplier that changes sign from step to step.
    halvings : float, optional
        Failed steps over accepted ones.

    Raises
    ------
    DataError
        If a limit is not positive.
    ArgumentTypeError
        If one is not a number.
    """

    balance: float = 1e-7
    unresolved: float = 0.6
    gap: float = 0.015
    closure: float = 0.015
    momentum: float = 0.01
    alternation: float = 0.5
    halvings: float = 0.5

    def __post_init__(self) -> None:
        """Check the values."""
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
                raise ArgumentTypeError(
                    f"Limits {field.name}", expected="a number", got=repr(value), fix="math.inf asks for no warning."
                )
            if not value > 0.0:
                raise DataError(
                    f"Limits {field.name}",
                    expected="a number > 0",
                    got=repr(value),
                    fix="math.inf asks for no warning.",
                )

    @classmethod
    def none(cls) -> Limits:
        """Return those that nothing exceeds: a run with them is not checked at all.

        Returns
        -------
        Limits
            All infinite.
        """
        return cls(**{field.name: math.inf for field in fields(cls)})

    @classmethod
    def suited(cls, keeps_energy: bool) -> Limits:
        """Return the defaults for a method.

        Parameters
        ----------
        keeps_energy : bool
            Whether it promises the balance of energy.

        Returns
        -------
        Limits
            With a wider limit of the balance if it does not.
        """
        return cls() if keeps_energy else cls(balance=DRIFT)

    @property
    def any(self) -> bool:
        """Whether there is one."""
        return any(getattr(self, field.name) < math.inf for field in fields(self))


def require_limits(where: str, value: object) -> Limits | None:
    """Check what a user gives for limits.

    Parameters
    ----------
    where : str
        What it is for, for the message.
    value : object
        The candidate.

    Returns
    -------
    Limits or None
        The same object.

    Raises
    ------
    ArgumentTypeError
        If it is something else.
    """
    if value is not None and not isinstance(value, Limits):
        raise ArgumentTypeError(where, expected="ph.Limits(...)", got=repr(value), fix="Make them first.")
    return value
