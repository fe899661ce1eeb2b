"""How long lists are told."""

from __future__ import annotations

from collections.abc import Sequence

#: What is told of a list, before the rest is counted.
TOLD = 3


def enumerated(items: Sequence[str], between: str, rest: str) -> str:
    """Join the first few of a list, and count the others.

    Parameters
    ----------
    items : sequence of str
        The list.
    between : str
        Between two of them.
    rest : str
        What the others are called.

    Returns
    -------
    str
        All of them if they are few, or if only one would be left to count.
    """
    if len(items) <= TOLD + 1:
        return between.join(items)
    return between.join(items[:TOLD]) + f" ... and {len(items) - TOLD} more {rest}"
