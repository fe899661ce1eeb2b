"""The report of a compilation: every effect, what became of it, and why."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from typing import Literal, overload

from phblocks.effects.record import Effect
from phblocks.errors import DataError, UnknownNameError

Status = Literal["kept", "pruned", "approximated"]
STATUSES = ("kept", "pruned", "approximated")
COLUMNS = ("block", "effect", "status", "states", "reason")


class EffectsReport(Sequence[Effect]):
    """Every effect of a diagram: kept, pruned or approximated. It prints as a table.

    Parameters
    ----------
    effects : iterable of Effect, or callable
        The records, or what makes them when they are first asked for.
    """

    def __init__(self, effects: Iterable[Effect] | Callable[[], Iterable[Effect]] = ()) -> None:
        self._source = effects

    @cached_property
    def _effects(self) -> tuple[Effect, ...]:
        return tuple(self._source() if callable(self._source) else self._source)

    @overload
    def __getitem__(self, index: int) -> Effect: ...

    @overload
    def __getitem__(self, index: slice) -> EffectsReport: ...

    def __getitem__(self, index: int | slice) -> Effect | EffectsReport:
        """Return one record, or a report of some."""
        return EffectsReport(self._effects[index]) if isinstance(index, slice) else self._effects[index]

    def __len__(self) -> int:
        """Count the records."""
        return len(self._effects)

    def __iter__(self) -> Iterator[Effect]:
        """Go through the records."""
        return iter(self._effects)

    def select(self, block: str | None = None, status: Status | None = None, name: str | None = None) -> EffectsReport:
        """Choose some of the records.

        Parameters
        ----------
        block : str, optional
            Those of a block; ``""`` for those of the whole diagram.
        status : {"kept", "pruned", "approximated"}, optional
            Those that this became of.
        name : str, optional
            Those of an effect, such as ``"N1"`` or ``"positions"``.

        Returns
        -------
        EffectsReport
            Those that are all of it.

        Raises
        ------
        DataError
            If there is no such status.
        UnknownNameError
            If there is no such block, or no such effect in any block.
        """
        if status is not None and status not in STATUSES:
            raise DataError(
                "effects status", expected=f"one of {', '.join(STATUSES)}", got=repr(status), fix="Choose one of them."
            )
        for what, value in (("block", block), ("name", name)):
            known = dict.fromkeys(getattr(effect, what) for effect in self._effects)
            if value is not None and value not in known:
                raise UnknownNameError(
                    f"effects {what}",
                    expected=f"one of {', '.join(map(repr, known))}",
                    got=repr(value),
                    fix="Print system.effects to see them all.",
                )
        wanted = {"block": block, "status": status, "name": name}
        asked = {key: value for key, value in wanted.items() if value is not None}
        return EffectsReport(e for e in self._effects if all(getattr(e, key) == v for key, v in asked.items()))

    def joined(self, others: Iterable[Effect]) -> EffectsReport:
        """Add records.

        Parameters
        ----------
        others : iterable of Effect
            They come after those of this report.

        Returns
        -------
        EffectsReport
            A new one.
        """
        more = tuple(others)
        return EffectsReport(lambda: (*self._effects, *more))

    @property
    def _rows(self) -> list[tuple[str, ...]]:
        return [(e.block or "(diagram)", e.name, e.status, str(e.states), e.reason) for e in self._effects]

    def __getstate__(self) -> dict[str, object]:
        """Keep the records when pickled, not what makes them."""
        return {"_source": self._effects}

    def __str__(self) -> str:
        """Format the records as a table."""
        rows = [COLUMNS, *self._rows]
        widths = [max(len(r[c]) for r in rows) for c in range(len(COLUMNS))]
        lines = ["  ".join(cell.ljust(w) for cell, w in zip(r, widths, strict=True)).rstrip() for r in rows]
        lines.insert(1, "-" * min(max(map(len, lines)), 120))
        return "\n".join(lines)

    def __repr__(self) -> str:
        """Return the table."""
        return str(self)
