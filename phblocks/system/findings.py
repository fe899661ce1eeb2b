"""Findings about a system or a run: a number, what it may be, and what to do; they print as a table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Literal, overload

from phblocks.errors import UnknownNameError

Verdict = Literal["ok", "over", "noted", "unknown"]
COLUMNS = ("what", "value", "limit", "verdict", "where")


@dataclass(frozen=True)
class Finding:
    """A number that says how well something goes.

    Parameters
    ----------
    name : str
        What it is.
    value : float or None
        ``None`` if it is not known.
    unit : str, optional
        Empty for a ratio.
    limit : float or None, optional
        Above it something is wrong; ``None`` if there is nothing to compare with.
    where : str, optional
        The block, joint or state it is worst at.
    time : float or None, optional
        When, s.
    advice : str, optional
        What the number is about, and what to do if it is too large; or why it is not known.
    """

    name: str
    value: float | None
    unit: str = ""
    limit: float | None = None
    where: str = ""
    time: float | None = None
    advice: str = ""

    @property
    def verdict(self) -> Verdict:
        """One of "over" (above the limit), "ok", "noted" (without a limit) and "unknown" (without a value)."""
        if self.value is None:
            return "unknown"
        if self.limit is None:
            return "noted"
        return "ok" if self.value <= self.limit else "over"

    @property
    def needed(self) -> str:
        """The advice, if it is over its limit or not known; else nothing."""
        return self.advice if self.verdict in ("over", "unknown") else ""

    @property
    def cells(self) -> tuple[str, ...]:
        """Texts for a table: :data:`COLUMNS`."""
        value = "-" if self.value is None else f"{self.value:.3g} {self.unit}".rstrip()
        limit = "" if self.limit is None else f"{self.limit:.3g}"
        when = "" if self.time is None else f"t = {self.time:.4g} s"
        return self.name, value, limit, self.verdict, ", ".join(text for text in (self.where, when) if text)

    def __str__(self) -> str:
        """Say it in a sentence."""
        name, value, limit, verdict, where = self.cells
        than, advice = (f", more than {limit}", f" {self.advice}") if verdict == "over" else ("", "")
        return f"{name}: {value}{than}{f' ({where})' if where else ''}.{advice}"


class Findings(Sequence[Finding]):
    """Several of them, also by their names.

    Parameters
    ----------
    findings : iterable of Finding
        In the order of the table.
    """

    def __init__(self, findings: Iterable[Finding]) -> None:
        self._findings = tuple(findings)

    @overload
    def __getitem__(self, key: int | str) -> Finding: ...

    @overload
    def __getitem__(self, key: slice) -> Findings: ...

    def __getitem__(self, key: int | str | slice) -> Finding | Findings:
        """Return one by its number or name, or some; an unknown name raises ``UnknownNameError``."""
        if isinstance(key, slice):
            return Findings(self._findings[key])
        if not isinstance(key, str):
            return self._findings[key]
        for finding in self._findings:
            if finding.name == key:
                return finding
        names = ", ".join(repr(f.name) for f in self._findings)
        raise UnknownNameError("findings", expected=f"one of {names}", got=repr(key), fix="Check the name.")

    def __len__(self) -> int:
        """Count them."""
        return len(self._findings)

    def __iter__(self) -> Iterator[Finding]:
        """Go through them."""
        return iter(self._findings)

    @property
    def over(self) -> tuple[Finding, ...]:
        """Those above their limit."""
        return tuple(f for f in self._findings if f.verdict == "over")

    @property
    def ok(self) -> bool:
        """Whether none is above its limit."""
        return not self.over

    def to_json(self) -> list[dict[str, object]]:
        """Describe them by texts and numbers.

        Returns
        -------
        list of dict
            One for each, with its verdict; infinite numbers as ``None``.
        """
        return [
            {
                key: None if isinstance(value, float) and not abs(value) < float("inf") else value
                for key, value in (asdict(f) | {"verdict": f.verdict}).items()
            }
            for f in self._findings
        ]

    def __str__(self) -> str:
        """Format them as a table, with what to do below it."""
        rows = [COLUMNS, *(f.cells for f in self._findings)]
        widths = [max(len(r[c]) for r in rows) for c in range(len(COLUMNS))]
        lines = ["  ".join(cell.ljust(w) for cell, w in zip(r, widths, strict=True)).rstrip() for r in rows]
        lines.insert(1, "-" * min(max(map(len, lines)), 120))
        return "\n".join(lines + [f"{f.name}: {f.needed}" for f in self._findings if f.needed])

    def __repr__(self) -> str:
        """Return the table."""
        return str(self)
