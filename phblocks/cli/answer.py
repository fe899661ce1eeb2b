"""What a command says: to people, and to programs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

#: Exit codes; those of ``docs/cli.md``.
DONE, NO, WRONG, FAULT, INTERRUPTED = 0, 1, 2, 3, 130


@dataclass(frozen=True)
class Answer:
    """What a command found.

    Parameters
    ----------
    text : str
        For people.
    data : mapping
        The same for programs: texts, numbers, truth values, arrays, and lists and mappings of them.
    ok : bool, optional
        Whether the answer is yes: the diagram is causal, the run reached its end.
    """

    text: str
    data: Mapping[str, Any] = field(repr=False)
    ok: bool = True

    @property
    def code(self) -> int:
        """The exit code."""
        return DONE if self.ok else NO


def jsonable(value: Any) -> Any:
    """Make plain data that JSON has a place for.

    Parameters
    ----------
    value : object
        Texts, numbers, truth values, arrays, paths, and lists and mappings of them.

    Returns
    -------
    object
        The same; numbers that are not finite are ``None``.
    """
    if isinstance(value, Mapping):
        return {str(key): jsonable(part) for key, part in value.items()}
    if hasattr(value, "tolist"):
        return jsonable(value.tolist())
    if isinstance(value, (list, tuple)):
        return [jsonable(part) for part in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if isinstance(value, (str, int, type(None))) else str(value)


def table(rows: Sequence[Sequence[str]]) -> str:
    """Align rows; the first one is the heading, the first column text and the others numbers.

    Parameters
    ----------
    rows : sequence of sequence of str
        Cells.

    Returns
    -------
    str
        Lines.
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        "  ".join([row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))]).rstrip()
        for row in rows
    ]
    lines.insert(1, "-" * max(map(len, lines)))
    return "\n".join(lines)
