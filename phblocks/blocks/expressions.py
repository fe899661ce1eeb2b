"""Expressions as text that can be stored and read again without executing anything.

sympy's own readers evaluate Python; here a text is parsed, and only numbers, names that are expected, arithmetic and a
list of functions are made into an expression.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping
from typing import Any

from phblocks.errors import ExportError

#: Functions of one number, by their names in sympy and in files.
FUNCTIONS = (
    *("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh"),
    *("exp", "log", "sqrt", "Abs", "sign"),
)
CONSTANTS = {"pi": "pi", "E": "E"}
#: A text longer than this is not read, and a power of numbers of more digits than this not evaluated.
LONGEST, DIGITS = 10_000, 300


def text_of(expression: Any, where: str) -> str:
    """Write an expression as a text that :func:`expression_of` reads.

    Parameters
    ----------
    expression : sympy.Expr
        Of symbols, numbers, arithmetic and the functions of :data:`FUNCTIONS`.
    where : str
        What it is, for the message.

    Returns
    -------
    str
        With all digits of its numbers.

    Raises
    ------
    ExportError
        If it contains something else.
    """
    from sympy.printing.str import StrPrinter

    class Printer(StrPrinter):  # type: ignore[misc]
        def _print_Float(self, number: Any) -> str:
            return repr(float(number))

    text = str(Printer().doprint(expression))
    symbols = {str(symbol): symbol for symbol in expression.free_symbols}
    if expression_of(text, symbols, where) - expression != 0:
        raise ExportError(
            where,
            expected="an expression of numbers, symbols, arithmetic and functions such as sin",
            got=text,
            fix="Write it with other functions.",
        )
    return text


def expression_of(text: Any, symbols: Mapping[str, Any], where: str) -> Any:
    """Read an expression; nothing is executed.

    Parameters
    ----------
    text : str
        Such as ``"p**2/(2*m) + cos(q)"``.
    symbols : mapping of str to sympy.Symbol
        The names that may occur.
    where : str
        What it is, for the message.

    Returns
    -------
    sympy.Expr
        The expression.

    Raises
    ------
    ExportError
        If it is not an expression, or has names or operations that are not known.
    """
    if not isinstance(text, str) or len(text) > LONGEST:
        raise _refused(where, repr(text)[:60])
    try:
        return _built(ast.parse(text.strip(), mode="eval").body, symbols)
    except (SyntaxError, ValueError, RecursionError, MemoryError, OverflowError, ZeroDivisionError) as error:
        raise _refused(where, f"{text[:60]!r} ({str(error) or type(error).__name__})") from error


def _built(node: ast.expr, symbols: Mapping[str, Any]) -> Any:
    import sympy

    match node:
        case ast.Constant(value=bool() | complex() | str() | bytes() | None):
            pass
        case ast.Constant(value=int() as number):
            return sympy.Integer(number)
        case ast.Constant(value=float() as number) if math.isfinite(number):
            return sympy.Float(number)
        case ast.Name(id=name) if name in symbols:
            return symbols[name]
        case ast.Name(id=name) if name in CONSTANTS:
            return getattr(sympy, name)
        case ast.UnaryOp(op=ast.USub(), operand=inner):
            return -_built(inner, symbols)
        case ast.UnaryOp(op=ast.UAdd(), operand=inner):
            return _built(inner, symbols)
        case ast.BinOp(left=left, op=op, right=right):
            return _combined(_built(left, symbols), op, _built(right, symbols))
        case ast.Call(func=ast.Name(id=name), args=[inner], keywords=[]) if name in FUNCTIONS:
            return getattr(sympy, name)(_built(inner, symbols))
    raise ValueError(f"{ast.unparse(node)[:40]!r} is not known here")


def _combined(left: Any, op: ast.operator, right: Any) -> Any:
    match op:
        case ast.Add():
            return left + right
        case ast.Sub():
            return left - right
        case ast.Mult():
            return left * right
        case ast.Div():
            if right == 0:
                raise ValueError("a division by zero")
            return left / right
        case ast.Pow():
            exponent = abs(float(right)) if right.is_number and right.is_real else 1.0
            base = abs(float(left)) if left.is_number and left.is_real else 10.0
            if exponent * max(1.0, abs(math.log10(base)) if base else 1.0) > DIGITS:
                raise ValueError("a power of too many digits")
            return left**right
    raise ValueError(f"{type(op).__name__} is not known here")


def _refused(where: str, got: str) -> ExportError:
    return ExportError(
        where,
        expected=f"an expression of numbers, known names, + - * / ** and {', '.join(FUNCTIONS)}",
        got=got,
        fix="Correct the expression.",
    )
