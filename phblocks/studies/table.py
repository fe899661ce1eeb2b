"""Tables of records: one frozen data class a row, read and written as text."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from operator import attrgetter
from pathlib import Path
from typing import Any, ClassVar, Generic, Self, TypeVar, get_type_hints

from phblocks.errors import ArgumentTypeError, ExportError, UnknownNameError

Row = TypeVar("Row")

#: How the cells of a file are read, by the type of the column.
READERS: dict[type, Callable[[str], Any]] = {
    str: str,
    int: int,
    float: float,
    bool: lambda text: {"True": True, "False": False}[text],
}


@dataclass(frozen=True, repr=False)
class Table(Generic[Row]):
    """Rows that are records of one kind; the names of the fields are those of the columns.

    Parameters
    ----------
    rows : tuple
        The records.
    """

    rows: tuple[Row, ...]

    #: The data class of the rows; its fields are text, numbers and truth values, their metadata may have a "unit", and
    #: a value that is printed as none ("absent").
    row_type: ClassVar[type[Any]]
    #: The columns that are printed; all of them are in the CSV file.
    shown: ClassVar[tuple[str, ...]]
    #: Those of them that are left out where no row has a value other than zero.
    shown_if_any: ClassVar[tuple[str, ...]] = ()

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(field.name for field in fields(self.row_type))

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences printed below the table."""
        return ()

    def __len__(self) -> int:
        """Count the rows."""
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        """Iterate over the rows."""
        return iter(self.rows)

    def __getitem__(self, number: int) -> Row:
        """Return one row."""
        return self.rows[number]

    def column(self, name: str) -> list[Any]:
        """Return one column.

        Parameters
        ----------
        name : str
            One of ``columns``.

        Returns
        -------
        list
            Its values, row by row.

        Raises
        ------
        UnknownNameError
            If there is no such column.
        """
        self._require(name)
        return [getattr(row, name) for row in self.rows]

    def filter(self, keep: Callable[[Row], bool] | None = None, **equal: Any) -> Self:
        """Keep some of the rows.

        Parameters
        ----------
        keep : callable, optional
            Says of a row whether it is kept.
        **equal : object
            Values that columns must have, such as ``method="Midpoint()"``.

        Returns
        -------
        Table
            With the rows that satisfy everything, in the same order.

        Raises
        ------
        UnknownNameError
            If there is no such column.
        """
        for name in equal:
            self._require(name)
        kept = (row for row in self.rows if keep is None or keep(row))
        return replace(self, rows=tuple(r for r in kept if all(getattr(r, n) == v for n, v in equal.items())))

    def sort(self, *names: str, reverse: bool = False) -> Self:
        """Order the rows; values that are not numbers (NaN) come last.

        Parameters
        ----------
        *names : str
            Columns, the most important one first.
        reverse : bool, optional
            From large to small.

        Returns
        -------
        Table
            With the same rows.

        Raises
        ------
        UnknownNameError
            If there is no such column.
        """
        rows = list(self.rows)
        for name in reversed(names):
            self._require(name)
            known = [row for row in rows if not _missing(getattr(row, name))]
            missing = [row for row in rows if _missing(getattr(row, name))]
            rows = [*sorted(known, key=attrgetter(name), reverse=reverse), *missing]
        return replace(self, rows=tuple(rows))

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write all columns to a file, numbers with all their digits.

        Parameters
        ----------
        path : str or os.PathLike
            The file; one of the same name is replaced.

        Returns
        -------
        pathlib.Path
            The file written.

        Raises
        ------
        ExportError
            If it cannot be written.
        """
        file = _path("to_csv", path)
        try:
            with file.open("w", newline="", encoding="utf-8") as stream:
                writer = csv.writer(stream)
                writer.writerow(self.columns)
                writer.writerows([getattr(row, name) for name in self.columns] for row in self.rows)
        except OSError as error:
            raise ExportError(
                f"file {file}", expected="a place to write to", got=str(error), fix="Check folder and permissions."
            ) from error
        return file

    @classmethod
    def from_csv(cls, path: str | os.PathLike[str]) -> Self:
        """Read a table back.

        Parameters
        ----------
        path : str or os.PathLike
            What ``to_csv`` of the same kind of table wrote.

        Returns
        -------
        Table
            With the same rows.

        Raises
        ------
        ExportError
            If there is no such file, or something else in it.
        """
        file = _path("from_csv", path)
        types = get_type_hints(cls.row_type)
        names = [field.name for field in fields(cls.row_type)]
        try:
            with file.open(newline="", encoding="utf-8") as stream:
                header, *lines = csv.reader(stream, strict=True)
            if sorted(header) != sorted(names):
                raise ValueError(f"columns {sorted(set(header) ^ set(names))} in one and not in the other")
            rows = [
                cls.row_type(**{n: READERS[types[n]](cell) for n, cell in zip(header, line, strict=True)})
                for line in lines
            ]
        except (OSError, ValueError, KeyError, csv.Error) as error:
            raise ExportError(
                f"file {file}",
                expected=f"a table of a {cls.__name__}",
                got=f"{type(error).__name__}: {error}",
                fix="Write it with to_csv, and read it with the same class.",
            ) from error
        return cls(tuple(rows))

    def to_markdown(self) -> str:
        """Format the columns shown as a Markdown table, followed by the notes.

        Returns
        -------
        str
            Without a line break at its end.
        """
        header, *lines = self._cells()
        text = [header, ["---"] * len(header), *lines]
        table = "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in text)
        return "\n\n".join([table, *self.notes])

    def __str__(self) -> str:
        """Format the columns shown as a table, followed by the notes."""
        lines = self._cells()
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        texts = [not self.rows or isinstance(getattr(self.rows[0], name), str) for name in self._printed]
        padded = [
            "  ".join(c.ljust(w) if t else c.rjust(w) for c, w, t in zip(line, widths, texts, strict=True)).rstrip()
            for line in lines
        ]
        return "\n".join([*padded, *([""] if self.notes else []), *self.notes])

    def __repr__(self) -> str:
        """Name the kind and the size."""
        return f"<{type(self).__name__} of {len(self.rows)} rows>"

    @property
    def _printed(self) -> list[str]:
        """The columns that are printed of these rows."""

        def told(name: str) -> bool:
            values = (getattr(row, name) for row in self.rows)
            return any(value and not _missing(value) for value in values)

        return [name for name in self.shown if name not in self.shown_if_any or told(name)]

    def _cells(self) -> list[list[str]]:
        """The heading and the rows as text."""
        meta = {field.name: field.metadata for field in fields(self.row_type)}
        units = {name: about.get("unit") for name, about in meta.items()}

        def cell(row: Row, name: str) -> str:
            value = getattr(row, name)
            return "-" if "absent" in meta[name] and value == meta[name]["absent"] else _text(value)

        heading = [name.replace("_", " ") + (f" ({units[name]})" if units[name] else "") for name in self._printed]
        return [heading, *([cell(row, name) for name in self._printed] for row in self.rows)]

    def _require(self, name: str) -> None:
        if name not in self.columns:
            raise UnknownNameError(
                f"column of a {type(self).__name__}",
                expected=f"one of {', '.join(self.columns)}",
                got=repr(name),
                fix="Check the name.",
            )


def _missing(value: object) -> bool:
    return isinstance(value, float) and math.isnan(value)


def _text(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return "-" if math.isnan(value) else f"{value:.4g}"
    return str(value)


def _path(where: str, path: object) -> Path:
    if not isinstance(path, (str, os.PathLike)):
        raise ArgumentTypeError(where, expected="a path", got=repr(path), fix='Give one such as "study.csv".')
    return Path(path)
