"""Numbers with a name, which symbolic models keep as symbols."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, Self

from phblocks.blocks.checks import require_finite
from phblocks.errors import ArgumentTypeError, DataError


class Parameter(float):
    """A number with a name: an argument of a block that :meth:`System.symbolic` keeps as a symbol.

    Everywhere else it is the number; the results of arithmetic with it are plain numbers.

    Parameters
    ----------
    symbol : str
        Its name, of letters, digits and underscores.
    value : float
        Finite and not zero.

    Raises
    ------
    DataError
        If the name is not one, or the value zero or not finite.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    symbol: str

    def __new__(cls, symbol: str, value: float) -> Self:
        """Make the number; ``float`` has no other way."""
        if not isinstance(symbol, str):
            raise ArgumentTypeError("Parameter", expected="a name", got=repr(symbol), fix='Write ("m", 2.0).')
        number = require_finite(f"Parameter {symbol!r}", value)
        if not symbol.isidentifier() or number == 0.0:
            fix = "Choose another name or value."
            raise DataError("Parameter", expected="a name and a value not 0", got=f"{symbol!r}, {value!r}", fix=fix)
        self = super().__new__(cls, number)
        self.symbol = symbol
        return self

    def __getnewargs__(self) -> tuple[str, float]:  # type: ignore[override]
        """Return what makes an equal one, for copies and pickles."""
        return self.symbol, float(self)

    def __repr__(self) -> str:
        """Return name and value."""
        return f"Parameter({self.symbol!r}, {float(self)!r})"


def parameters_in(value: Any) -> Iterator[Parameter]:
    """Find the parameters in an argument of a block.

    Parameters
    ----------
    value : object
        A number, or tuples, lists, dictionaries and data classes with numbers in them.

    Yields
    ------
    Parameter
        One after the other.
    """
    if isinstance(value, Parameter):
        yield value
    elif isinstance(value, Mapping):
        yield from (found for part in value.values() for found in parameters_in(part))
    elif isinstance(value, (list, tuple)):
        yield from (found for part in value for found in parameters_in(part))
    elif is_dataclass(value):
        yield from (found for f in fields(value) for found in parameters_in(getattr(value, f.name)))


def with_values(value: Any, values: Mapping[str, float]) -> Any:
    """Give parameters in an argument of a block other values.

    Parameters
    ----------
    value : object
        As of :func:`parameters_in`.
    values : mapping of str to float
        By the name of the parameter.

    Returns
    -------
    object
        A copy.
    """
    if not any(True for _ in parameters_in(value)):
        return value
    if isinstance(value, Parameter):
        return Parameter(value.symbol, values.get(value.symbol, float(value)))
    if isinstance(value, Mapping):
        return {key: with_values(part, values) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(with_values(part, values) for part in value)
    return replace(value, **{f.name: with_values(getattr(value, f.name), values) for f in fields(value)})
