"""Arguments of blocks as plain data for files, and back.

Numbers, texts, lists and objects stand for themselves (arrays are lists). What they cannot say has one key that begins
with ``$``, which says what it is; see ``docs/diagram-json.md``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from phblocks.approximation import Approximation
from phblocks.blocks.beam.damping import Damping
from phblocks.blocks.beam.load import LineLoad
from phblocks.blocks.beam.section import Section
from phblocks.blocks.expressions import expression_of, text_of
from phblocks.blocks.parameter import Parameter
from phblocks.blocks.system_block import SystemPort
from phblocks.errors import ExportError
from phblocks.ports import ELECTRICAL, HYDRAULIC, ROTATION, TRANSLATION, Domain, Quantity

#: Data that are not blocks, by name.
TYPES: dict[str, type[Any]] = {
    t.__name__: t for t in (Section, Approximation, Damping, LineLoad, SystemPort, Domain, Quantity)
}
#: Domains that are known by their name alone.
DOMAINS = {domain.name: domain for domain in (TRANSLATION, ROTATION, ELECTRICAL, HYDRAULIC)}


def plain(value: Any, where: str) -> Any:
    """Write a value as plain data.

    Parameters
    ----------
    value : object
        An argument of a block.
    where : str
        Which one, for the message.

    Returns
    -------
    object
        Of dictionaries, lists, texts, numbers, truth values and ``None``.

    Raises
    ------
    ExportError
        If it is a function, or of a kind that has no place in a file.
    """
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, (np.bool_, np.integer, int)):
        return value.item() if isinstance(value, np.generic) else int(value)
    if isinstance(value, Parameter):
        return {"$parameter": value.symbol, "value": float(value)}
    if isinstance(value, (float, np.floating)):
        number = float(value)
        return number if math.isfinite(number) else {"$number": str(number)}
    if isinstance(value, np.ndarray):
        return plain(value.tolist(), where)
    if isinstance(value, (list, tuple, range)):
        return [plain(part, where) for part in value]
    if isinstance(value, Mapping):
        if not all(isinstance(key, str) and not key.startswith("$") for key in value):
            raise _refused(where, "texts that do not begin with $, as keys", repr(list(value)))
        return {key: plain(part, f"{where} {key!r}") for key, part in value.items()}
    if isinstance(value, Domain) and DOMAINS.get(value.name) == value:
        return {"$domain": value.name}
    if type(value).__name__ in TYPES and type(value) is TYPES[type(value).__name__]:
        parts = {f.name: plain(getattr(value, f.name), f"{where} {f.name}") for f in fields(value)}
        return {"$type": type(value).__name__, **parts}
    return _symbolic(value, where)


def _symbolic(value: Any, where: str) -> Any:
    if str(type(value).__module__).partition(".")[0] != "sympy":
        raise _refused(where, "numbers, texts or sympy expressions", "a function" if callable(value) else repr(value))
    import sympy

    if isinstance(value, sympy.MatrixBase):
        return {"$matrix": [[text_of(entry, where) for entry in row] for row in value.tolist()]}
    if isinstance(value, sympy.Symbol):
        if not value.name.isidentifier():
            raise _refused(where, "symbols that are names of letters and digits", repr(value.name))
        return {"$symbol": value.name}
    if isinstance(value, sympy.Expr):
        return {"$expression": text_of(value, where)}
    raise _refused(where, "sympy expressions and matrices", type(value).__name__)


def value_of(data: Any, where: str, symbols: Mapping[str, Any]) -> Any:
    """Read plain data; nothing is executed.

    Parameters
    ----------
    data : object
        What :func:`plain` made, or an editor.
    where : str
        Which argument, for the message.
    symbols : mapping of str to sympy.Symbol
        The names that may occur in expressions.

    Returns
    -------
    object
        The value; lists are tuples.

    Raises
    ------
    ExportError
        If a key that begins with ``$`` is not known, or what it says is not what it must be.
    """
    if isinstance(data, list):
        return tuple(value_of(part, where, symbols) for part in data)
    if not isinstance(data, dict):
        return data
    tags = [key for key in data if key.startswith("$")]
    if not tags:
        return {key: value_of(part, f"{where} {key!r}", symbols) for key, part in data.items()}
    if tags != ["$type"]:
        return _tagged(data, where, symbols)
    kind = TYPES.get(data["$type"]) if isinstance(data["$type"], str) else None
    given = {key: part for key, part in data.items() if key != "$type"}
    if kind is None:
        raise _refused(where, f"$type out of {', '.join(TYPES)}", repr(data["$type"]))
    known = [f.name for f in fields(kind)]
    if unknown := sorted(given.keys() - set(known)):
        raise _refused(where, f"of {kind.__name__} {', '.join(known)}", ", ".join(map(repr, unknown)))
    parts = {key: value_of(part, f"{where} {key}", symbols) for key, part in given.items()}
    try:
        return kind(**parts)
    except TypeError as error:
        raise _refused(where, f"a complete {kind.__name__}", str(error)) from error


def _tagged(data: Mapping[str, Any], where: str, symbols: Mapping[str, Any]) -> Any:
    """Data of one key that begins with ``$``."""
    (tag, content), *more = data.items()
    if tag == "$parameter" and list(data) == ["$parameter", "value"]:
        return Parameter(content, data["value"])
    if not more:
        if tag == "$number" and content in ("inf", "-inf"):
            return float(content)
        if tag == "$domain" and isinstance(content, str) and content in DOMAINS:
            return DOMAINS[content]
        if tag == "$symbol" and isinstance(content, str) and content in symbols:
            return symbols[content]
        if tag == "$expression":
            return expression_of(content, symbols, where)
        if tag == "$matrix" and isinstance(content, list) and all(isinstance(row, list) for row in content):
            import sympy

            return sympy.Matrix([[expression_of(entry, symbols, where) for entry in row] for row in content])
    raise _refused(where, "$type, $number, $parameter, $domain, $symbol, $expression or $matrix", repr(dict(data))[:80])


def _refused(where: str, expected: str, got: str) -> ExportError:
    return ExportError(where, expected=expected, got=got, fix="See docs/diagram-json.md for what a file can hold.")
