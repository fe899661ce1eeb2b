"""Packages that only some exporters need: asked for when they are used, and named where they are missing."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from phblocks.errors import ExtraMissingError


def require_extra(module: str, extra: str, where: str) -> Any:
    """Import a module that comes with an extra of this package.

    Parameters
    ----------
    module : str
        Its name.
    extra : str
        The extra, such as ``"control"``.
    where : str
        What needs it, for the message.

    Returns
    -------
    module
        The module.

    Raises
    ------
    ExtraMissingError
        If it is not installed.
    """
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise ExtraMissingError(
            where,
            expected=f"the package {package!r}",
            got=f"none that can be imported ({error})",
            fix=f'Install it: pip install "phblocks[{extra}]".',
        ) from error
