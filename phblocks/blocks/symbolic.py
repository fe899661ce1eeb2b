"""Functions of numbers from sympy expressions, with their derivatives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from phblocks.errors import ArgumentTypeError, DataError

Function = Callable[..., Any]


@dataclass(frozen=True)
class Derived:
    """A function of an expression, or of a derivative of one; it needs no check by differences.

    Parameters
    ----------
    function : callable
        Of an array of the variables.
    """

    function: Function

    def __call__(self, x: Any) -> Any:
        """Evaluate.

        Parameters
        ----------
        x : numpy.ndarray
            The variables.

        Returns
        -------
        float or list
            The value.
        """
        return self.function(x)


def require_symbols(where: str, variables: Sequence[Any]) -> list[Any]:
    """Return variables if they are symbols.

    Parameters
    ----------
    where : str
        What they are, for the message.
    variables : sequence of sympy.Symbol
        The candidates.

    Returns
    -------
    list of sympy.Symbol
        The same.

    Raises
    ------
    ArgumentTypeError
        If one of them is not a symbol.
    """
    import sympy

    symbols = list(variables)
    if not all(isinstance(symbol, sympy.Symbol) for symbol in symbols):
        raise ArgumentTypeError(where, expected="sympy symbols", got=repr(variables), fix="Use sympy.symbols.")
    return symbols


def energy_of(where: str, expression: Any, x: Sequence[Any]) -> tuple[Function, Function, Function]:
    """Make functions of an expression, its gradient and its Hessian.

    Parameters
    ----------
    where : str
        What it is, for messages.
    expression : sympy.Expr
        With numbers for all parameters.
    x : sequence of sympy.Symbol
        The variables.

    Returns
    -------
    value, gradient, hessian : callable
        Of an array of the variables.

    Raises
    ------
    ArgumentTypeError
        If it is not an expression.
    DataError
        If it depends on other symbols.
    """
    import sympy

    if not isinstance(expression, sympy.Expr):
        raise ArgumentTypeError(where, expected="a sympy expression", got=repr(expression), fix="Write one.")
    _require_known(where, expression, x)
    slopes = [expression.diff(a) for a in x]
    return (
        Derived(_function(x, expression)),
        Derived(_function(x, slopes)),
        Derived(_function(x, [[slope.diff(b) for b in x] for slope in slopes])),
    )


def matrix_of(where: str, matrix: Any, x: Sequence[Any]) -> tuple[Any, Function | None] | None:
    """Make a function of a matrix of expressions, and one of its derivative.

    Parameters
    ----------
    where : str
        What it is, for the message.
    matrix : sympy.Matrix or object
        The candidate.
    x : sequence of sympy.Symbol
        The variables.

    Returns
    -------
    (callable or list, callable or None) or None
        Function and derivative, the latter with a third axis for the variable; numbers and ``None`` for a matrix
        without variables. ``None`` for anything but a sympy matrix.

    Raises
    ------
    DataError
        If it depends on other symbols.
    """
    import sympy

    if not isinstance(matrix, sympy.MatrixBase):
        return None
    _require_known(where, matrix, x)
    rows = matrix.tolist()
    if not matrix.free_symbols:
        return [[float(entry) for entry in row] for row in rows], None
    return _function(x, rows), _function(x, [[[entry.diff(a) for a in x] for entry in row] for row in rows])


def _require_known(where: str, expression: Any, x: Sequence[Any]) -> None:
    others = sorted(str(symbol) for symbol in expression.free_symbols - set(x))
    if others:
        raise DataError(
            where,
            expected="an expression in the variables alone",
            got=f"one in {', '.join(others)} too",
            fix="Substitute numbers for the parameters.",
        )


def _function(x: Sequence[Any], expressions: Any) -> Function:
    import sympy

    function: Function = sympy.lambdify([list(x)], expressions, modules="numpy", cse=True)
    return function
