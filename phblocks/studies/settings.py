"""Checks and names of what a study varies."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass, replace
from typing import Any

from phblocks.blocks.checks import require_real
from phblocks.errors import ArgumentTypeError, DataError, UnknownNameError
from phblocks.simulation import simulate
from phblocks.studies.run import step_control

#: What a study gives to ``simulate`` itself.
OWN = ("system", "t_end", "dt", "progress")

Methods = Mapping[str, object] | Sequence[object]


def name_of(method: object) -> str:
    """Name a method for tables: its options where they are not the defaults.

    Parameters
    ----------
    method : object
        Such as ``ph.Midpoint()``; ``None`` is what ``simulate`` chooses.

    Returns
    -------
    str
        Such as "GaussLegendre(stages=3)".
    """
    if method is None:
        return "default"
    if not is_dataclass(method) or isinstance(method, type):
        return repr(method)
    options = []
    for option in fields(method):
        default = option.default if option.default_factory is MISSING else option.default_factory()
        value = getattr(method, option.name)
        if option.repr and (default is MISSING or value != default):
            options.append(f"{option.name}={value!r}")
    return f"{type(method).__name__}({', '.join(options)})"


def named_methods(where: str, methods: Methods, arguments: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Give every method its name and its arguments of ``simulate``.

    Parameters
    ----------
    where : str
        The study, for messages.
    methods : mapping or sequence
        Methods by name, or methods; in a mapping also mappings of arguments of ``simulate``.
    arguments : mapping
        Arguments for all of them.

    Returns
    -------
    dict
        Arguments of ``simulate`` by the name of the method.

    Raises
    ------
    ArgumentTypeError, DataError, UnknownNameError
        If there is none, two have one name, or an argument is unknown to ``simulate``.
    """
    if isinstance(methods, Mapping):
        pairs = list(methods.items())
    elif isinstance(methods, (list, tuple)):
        pairs = [(name_of(method), method) for method in methods]
    else:
        raise ArgumentTypeError(
            f"{where} methods", expected="a list of methods, or a dict with names", got=repr(methods), fix="Give one."
        )
    named: dict[str, dict[str, Any]] = {}
    for name, method in pairs:
        own = dict(method) if isinstance(method, Mapping) else {} if method is None else {"method": method}
        named[name] = {**arguments, **own}
        known = [p for p in inspect.signature(simulate).parameters if p not in OWN]
        for key in named[name]:
            if key not in known:
                raise UnknownNameError(
                    f"{where} argument",
                    expected=f"one of its own, or {', '.join(known)}",
                    got=repr(key),
                    fix="Check it.",
                )
    if not named or len(named) < len(pairs):
        raise DataError(
            f"{where} methods",
            expected="one or more of different names",
            got=", ".join(name for name, _ in pairs) or "none",
            fix="Give names: methods={'tight': ph.Midpoint(...), ...}.",
        )
    return named


def with_tolerance(where: str, arguments: Mapping[str, Any], rtol: float | None) -> tuple[dict[str, Any], float]:
    """Change the tolerance of a run that chooses its steps.

    Parameters
    ----------
    where : str
        The study, for messages.
    arguments : mapping
        Of ``simulate``, with ``adaptive`` or a method that chooses its steps itself.
    rtol : float or None
        Relative tolerance; the absolute one is changed by the same factor. ``None``: leave it.

    Returns
    -------
    arguments : dict
        With this tolerance.
    rtol : float
        The relative tolerance, 0 if there is none.

    Raises
    ------
    DataError
        If there is no relative tolerance above zero to change.
    """
    control = step_control(arguments)
    own = float(getattr(control, "rtol", 0.0))
    if rtol is None:
        return dict(arguments), own
    if not (own > 0.0 and is_dataclass(control) and not isinstance(control, type)):
        raise DataError(
            f"{where} tolerances",
            expected="methods that choose their steps to have rtol > 0",
            got=repr(control),
            fix="Give one, or leave tolerances out.",
        )
    changed = {"rtol": rtol}
    if hasattr(control, "atol"):
        changed["atol"] = control.atol * (rtol / own)
    name = "adaptive" if arguments.get("adaptive") is control else "method"
    return {**arguments, name: replace(control, **changed)}, rtol


def positive_values(where: str, values: object, least: int = 1) -> list[float]:
    """Check a list of numbers above zero.

    Parameters
    ----------
    where : str
        The argument, for messages.
    values : object
        What was given.
    least : int, optional
        How many there have to be.

    Returns
    -------
    list of float
        From large to small.

    Raises
    ------
    ArgumentTypeError, DataError
        If they are not, or two are equal, or there are too few.
    """
    if not isinstance(values, Iterable) or isinstance(values, (str, Mapping)):
        raise ArgumentTypeError(where, expected="a list of numbers", got=repr(values), fix="Give one.")
    numbers = [require_real(where, value) for value in values]
    if len(set(numbers)) < max(least, len(numbers)) or min(numbers) <= 0.0:
        raise DataError(
            where, expected=f"{least} or more different numbers > 0", got=repr(numbers), fix="Correct them."
        )
    return sorted(numbers, reverse=True)


def require_function(where: str, make_system: object) -> None:
    """Check that this can be called.

    Parameters
    ----------
    where : str
        The argument, for messages.
    make_system : object
        What was given.

    Raises
    ------
    ArgumentTypeError
        If it cannot.
    """
    if not callable(make_system):
        raise ArgumentTypeError(
            where, expected="a function that returns a System", got=repr(make_system), fix="Write one."
        )
