"""What a user may ask to leave out: effects by their names, each by field terms, for one block or a whole diagram."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

from phblocks.errors import ArgumentTypeError


@dataclass(frozen=True)
class Approximation:
    """Effects to keep (True) or to leave out (False), each block as far as it has them.

    What is left out is entries of the same matrices: a product of T, a compliance or an inertia in E. What a block
    says for itself takes the place of all that is said for the diagram.

    Parameters
    ----------
    large_rotation : bool or "second-order", optional
        False: the linear theory about rest. No products of states, and all frames keep their initial orientation.
        "second-order": of the products of a beam those with its axial strain are left out; what an axial force does
        to bending is kept, about a posture that may move and turn as a whole.
    shear : bool, optional
        Shear strain of a beam; without it shear forces are constraint forces.
    extension : bool, optional
        Axial strain of a beam; without it axial forces are constraint forces.
    rotary_inertia : bool, optional
        Inertia of the cross sections of a beam.
    flexible : bool, optional
        False: a beam is a rigid body with the same ports, held by multipliers where others give velocity too.
    internal_damping : bool, optional
        Kelvin-Voigt damping of a beam.
    gravity : bool, optional
        Weight.
    insist : bool, optional
        Leave out large rotations also where that is known to be wrong, without a word.

    Raises
    ------
    ArgumentTypeError
        If a value is not one of those named here.
    """

    large_rotation: bool | Literal["second-order"] = True
    shear: bool = True
    extension: bool = True
    rotary_inertia: bool = True
    flexible: bool = True
    internal_damping: bool = True
    gravity: bool = True
    insist: bool = False

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            choice = field.name == "large_rotation"
            if not (isinstance(value, bool) or (choice and value == "second-order")):
                raise ArgumentTypeError(
                    f"Approximation {field.name}",
                    expected='True, False or "second-order"' if choice else "True or False",
                    got=repr(value),
                    fix="True keeps the effect, False leaves it out.",
                )


#: Everything is kept.
EXACT = Approximation()


def require_approximation(where: str, value: object) -> Approximation | None:
    """Check what a user gives for an approximation.

    Parameters
    ----------
    where : str
        What it is for, for the message.
    value : object
        The candidate.

    Returns
    -------
    Approximation or None
        The same object.

    Raises
    ------
    ArgumentTypeError
        If it is neither an approximation nor ``None``.
    """
    if value is not None and not isinstance(value, Approximation):
        raise ArgumentTypeError(
            where,
            expected="an Approximation, or None",
            got=repr(value),
            fix="Make one: ph.Approximation(shear=False).",
        )
    return value
