"""Names of the causality of a beam end."""

from __future__ import annotations

from typing import NamedTuple

from phblocks.errors import ArgumentTypeError, DataError


class End(NamedTuple):
    """What one end of a beam gives.

    Parameters
    ----------
    velocity : bool
        It gives velocity and takes force; otherwise the other way round.
    spin : bool
        It gives angular velocity and takes moment; otherwise the other way round.
    """

    velocity: bool
    spin: bool


ENDS = {
    "free": End(True, True),
    "pinned": End(False, True),
    "clamped": End(False, False),
    "guided": End(True, False),
}
END_NAMES = {end: name for name, end in ENDS.items()}


def parse_causality(where: str, causality: object) -> tuple[End, End] | None:
    """Read what a user writes for the causality of a beam.

    Parameters
    ----------
    where : str
        For messages.
    causality : object
        "auto", "start-end" or a pair of names.

    Returns
    -------
    tuple of End or None
        Start and end; ``None`` for "auto".

    Raises
    ------
    DataError
        If a name is unknown.
    ArgumentTypeError
        If it is neither a text nor a pair of texts.
    """
    if isinstance(causality, str) and causality == "auto":
        return None
    names = tuple(causality.split("-")) if isinstance(causality, str) else causality
    if not isinstance(names, (tuple, list)) or not all(isinstance(n, str) for n in names):
        raise ArgumentTypeError(
            where,
            expected='"auto", a text such as "clamped-free" or a pair of texts',
            got=repr(causality),
            fix='Use "auto" to let the compiler choose.',
        )
    if len(names) != 2 or any(n not in ENDS for n in names):
        raise DataError(
            where,
            expected=f"two of {', '.join(ENDS)}",
            got=repr(causality),
            fix='Write for instance "pinned-free", or "auto" to let the compiler choose.',
        )
    return ENDS[names[0]], ENDS[names[1]]
