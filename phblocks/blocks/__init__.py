"""The kinds of parts a diagram is made of; one kind a file."""

from importlib import import_module
from pkgutil import walk_packages


def load_all() -> None:
    """Load all kinds there are: a file of a diagram asks for them by name, in ``Block.kinds``."""
    for module in walk_packages(__path__, f"{__name__}."):
        import_module(module.name)
