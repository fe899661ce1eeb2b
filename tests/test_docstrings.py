"""Every public name of the package says what it does, what it takes and what it gives (numpydoc sections)."""

import dataclasses
import enum
import functools
import importlib
import inspect
import itertools
import pkgutil
import re
from collections.abc import Callable, Iterator
from types import FunctionType, ModuleType
from typing import Any, Never, NoReturn, Protocol

import pytest

PARAMETERS = ("Parameters", "Other Parameters")
GIVES_NOTHING = (None, "None", NoReturn, "NoReturn", Never, "Never")


# What a docstring says


def sections(doc: str | None) -> dict[str, set[str]]:
    """Title of each numpydoc section -> the names described in it."""
    lines = inspect.cleandoc(doc or "").splitlines()
    found: dict[str, set[str]] = {}
    names: set[str] = set()
    for line, below in itertools.pairwise([*lines, ""]):
        if line.strip() and re.fullmatch(r"-{3,}", below):
            names = found.setdefault(line.strip(), set())
        elif line and not line[0].isspace() and not line.startswith("---"):
            entry = re.split(r"\s*:(?:\s|$)", line, maxsplit=1)[0]
            names.update(name.strip(" `*\\") for name in entry.split(","))
    return found


def documented(docs: list[str | None], *titles: str) -> set[str]:
    """Names described in the sections with one of these titles, in any of the docstrings."""
    return {name for doc in docs for title in titles for name in sections(doc).get(title, ())}


def compare(given: set[str], described: set[str], claimed: set[str]) -> Iterator[str]:
    """Public parameters that are not described, and parameters claimed that do not exist."""
    for name in sorted(given - described):
        if not name.startswith("_"):
            yield f"parameter {name!r} is not documented"
    for name in sorted(claimed - given):
        yield f"documented parameter {name!r} does not exist"


# What an object must say


def problems_of_function(function: Callable[..., Any], overridden: list[Any]) -> Iterator[str]:
    """A method that overrides another need not repeat what the other's docstring says."""
    inherited = [method.__doc__ for method in overridden]
    docs = [function.__doc__, *inherited]
    if not any(docs):
        yield "has no docstring"
        return
    signature = inspect.signature(function)
    given = set(signature.parameters) - {"self", "cls"}
    yield from compare(given, documented(docs, *PARAMETERS), documented(docs[:1], *PARAMETERS))
    says_what = any({"Returns", "Yields"} & set(sections(doc)) for doc in docs)
    if signature.return_annotation not in GIVES_NOTHING and not says_what:
        yield "returns something but has no section Returns or Yields"


def problems_of_class(cls: type) -> Iterator[str]:
    """Parameters of the constructor and fields of a data class, described in the class or in __init__."""
    doc = vars(cls).get("__doc__")
    if not doc or doc.startswith(f"{cls.__name__}("):  # what dataclass and NamedTuple write on their own
        yield "has no docstring"
        return
    if issubclass(cls, enum.Enum) or Protocol in cls.__bases__:  # not constructed by the user
        return
    package = cls.__module__.split(".")[0]
    ours = [base for base in cls.__mro__ if base.__module__.split(".")[0] == package]
    constructed = any({"__init__", "__new__"} & set(vars(base)) for base in ours)
    given = set(inspect.signature(cls).parameters) if constructed else set()
    if dataclasses.is_dataclass(cls):
        given |= {field.name for field in dataclasses.fields(cls)}
    docs = [text for base in ours for text in (base.__doc__, vars(base).get("__init__", base).__doc__)]
    yield from compare(given, documented(docs, *PARAMETERS, "Attributes"), documented(docs[:2], *PARAMETERS))


def problems(thing: Any, overridden: list[Any] | None = None) -> list[str]:
    """Everything missing from, or wrong in, the docstring of a module, class, property or function."""
    if isinstance(thing, Exception):
        raise thing
    if isinstance(thing, type):
        return list(problems_of_class(thing))
    if isinstance(thing, FunctionType):
        return list(problems_of_function(thing, overridden or []))
    return [] if any(found.__doc__ for found in [thing, *(overridden or [])]) else ["has no docstring"]


# Which objects are public


def described_object(raw: Any) -> Any:
    """The function behind a method or a wrapper; a property, class or module as it is."""
    if isinstance(raw, staticmethod | classmethod):
        raw = raw.__func__
    return inspect.unwrap(raw) if callable(raw) and not isinstance(raw, type) else raw


def members(cls: type) -> Iterator[tuple[str, Any, list[Any]]]:
    """Public members that the class itself defines, each with those it overrides."""
    for name, raw in vars(cls).items():
        if name.startswith("_") and name != "__call__":
            continue
        thing = described_object(raw)
        defined_here = getattr(thing, "__qualname__", None) == f"{cls.__qualname__}.{name}"
        if isinstance(thing, property | functools.cached_property) or (
            isinstance(thing, FunctionType | type) and defined_here
        ):
            overridden = [vars(base)[name] for base in cls.__mro__[1:-1] if name in vars(base)]
            yield f"{cls.__module__}.{cls.__qualname__}.{name}", thing, [*map(described_object, overridden)]


def modules(name: str) -> Iterator[tuple[str, ModuleType | Exception]]:
    """A module and the public modules in it; an exception stands for one that cannot be imported."""
    try:
        module = importlib.import_module(name)
    except Exception as error:  # reported by the test of this module, not by a broken collection
        yield name, error
        return
    yield name, module
    for child in pkgutil.iter_modules(getattr(module, "__path__", [])):
        if not child.name.startswith("_"):
            yield from modules(f"{name}.{child.name}")


def public_objects(package: str) -> dict[str, tuple[Any, list[Any]]]:
    """Dotted name of everything public -> the object, and what it overrides."""
    found: dict[str, tuple[Any, list[Any]]] = {}
    waiting: list[Any] = []
    for name, module in modules(package):
        found[name] = module, []
        for key, thing in vars(module).items() if isinstance(module, ModuleType) else ():
            if not key.startswith("_") and getattr(thing, "__module__", None) == name:
                waiting.append(thing)
    root = found[package][0]
    waiting += [getattr(root, key) for key in getattr(root, "__all__", []) if hasattr(root, key)]
    for raw in waiting:
        thing = described_object(raw)
        if isinstance(thing, FunctionType | type):
            found.setdefault(f"{thing.__module__}.{thing.__qualname__}", (thing, []))
    classes = [thing for thing, _ in found.values() if isinstance(thing, type)]
    while classes:
        for name, thing, overridden in members(classes.pop()):
            if isinstance(thing, type) and name not in found:
                classes.append(thing)
            found.setdefault(name, (thing, overridden))
    return found


PUBLIC = public_objects("phblocks")


@pytest.mark.parametrize("name", PUBLIC)
def test_docstring(name):
    found = problems(*PUBLIC[name])
    assert not found, f"{name} " + "; ".join(found)


# The check itself: what it lets pass and what it stops


@dataclasses.dataclass
class Spring:
    """A spring.

    Parameters
    ----------
    stiffness : float
        N/m.

    Attributes
    ----------
    length : float
        m.
    """

    stiffness: float
    length: float = dataclasses.field(default=0.0, init=False)

    def energy(self, extension: float, /, *loads: float, scale: float = 1.0) -> float:
        """Energy.

        Parameters
        ----------
        extension, scale : float
            m.
        *loads : float
            N.

        Returns
        -------
        float
            J.
        """
        return self.stiffness * extension**2 * scale / 2

    @property
    def soft(self) -> bool:
        """Whether it is soft."""
        return self.stiffness < 1


class StiffSpring(Spring):
    """A spring whose energy is documented where it is declared."""

    def energy(self, extension: float, /, *loads: float, scale: float = 1.0) -> float:
        """See Spring."""
        return 0.0


@dataclasses.dataclass
class Undocumented:
    force: float


class Forgetful:
    """A class.

    Parameters
    ----------
    mass : float
        kg.
    """

    def __init__(self, weight: float) -> None:
        """Do nothing."""

    def silent(self) -> None: ...

    def gives(self) -> float:
        """Give."""
        return 0.0

    def takes(self, f: float) -> None:
        """Take.

        Parameters
        ----------
        g : float
            N.
        """


@pytest.mark.parametrize(
    ("thing", "expected"),
    [
        (Spring, []),
        (Spring.energy, []),
        (Spring.soft, []),
        (StiffSpring, []),
        (Undocumented, ["has no docstring"]),
        (Forgetful, ["parameter 'weight' is not documented", "documented parameter 'mass' does not exist"]),
        (Forgetful.silent, ["has no docstring"]),
        (Forgetful.gives, ["returns something but has no section Returns or Yields"]),
        (Forgetful.takes, ["parameter 'f' is not documented", "documented parameter 'g' does not exist"]),
    ],
)
def test_check(thing, expected):
    assert problems(thing) == expected


def test_check_of_an_overriding_method():
    [(_, energy, overridden)] = members(StiffSpring)
    assert problems(energy, overridden) == []
    assert problems(energy) != []
