"""What FILE says: a diagram, and the inputs of its runs."""

from __future__ import annotations

import inspect
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from phblocks.errors import ArgumentTypeError, DataError, ExportError, UnknownNameError

if TYPE_CHECKING:
    from phblocks.approximation import Requested
    from phblocks.diagram import Diagram
    from phblocks.inputs import Signal
    from phblocks.system import System

#: What a file defines if nothing else is asked for.
NAME = "diagram"


@dataclass(frozen=True)
class Source:
    """A file, and the name in it.

    Parameters
    ----------
    path : str
        The file.
    name : str, optional
        Of a diagram, or of a function that returns one; not of a JSON file.
    """

    path: str
    name: str = NAME

    @classmethod
    def of(cls, text: str) -> Source:
        """Read what was typed.

        Parameters
        ----------
        text : str
            ``scene.json``, ``scene.py`` or ``scene.py:name``.

        Returns
        -------
        Source
            The file and the name.

        Raises
        ------
        ExportError
            If the suffix is another, or there is no such file.
        """
        head, colon, name = text.rpartition(":")
        path, chosen = (head, name) if colon and head.lower().endswith(".py") else (text, NAME)
        if Path(path).suffix.lower() not in (".json", ".py"):
            raise ExportError(
                f"file {path}",
                expected="a diagram: .json, or .py that defines `diagram`",
                got=repr(Path(path).suffix) if Path(path).suffix else "no suffix",
                fix="Rename the file, or give another one.",
            )
        if not Path(path).is_file():
            raise ExportError(f"file {path}", expected="a file", got="none", fix="Check the path.")
        return cls(path, chosen)

    @property
    def stem(self) -> str:
        """The name of the file without suffix, for files made of it."""
        return Path(self.path).stem

    def diagram(self, **mesh: Any) -> Diagram:
        """Draw the diagram.

        Parameters
        ----------
        **mesh : object
            ``elements`` or ``degree``: given to the function of that name if it takes them, otherwise to all blocks
            that have them.

        Returns
        -------
        Diagram
            A new one, unless the file defines one and no mesh is asked for.

        Raises
        ------
        ExportError
            If the file is damaged or raises, or a diagram with functions in it is to be meshed anew.
        UnknownNameError
            If it does not define the name.
        ArgumentTypeError
            If that is no diagram.
        DataError
            If no block has such an argument.
        """
        from phblocks.diagram import Diagram, load

        if Path(self.path).suffix.lower() == ".json":
            return _meshed(load(self.path), mesh)
        module = self._module
        if not hasattr(module, self.name):
            raise UnknownNameError(
                f"file {self.path}",
                expected=f"the name {self.name!r}: a Diagram, or a function that returns one",
                got="no such name",
                fix=f"Call it {self.name!r}, or give {self.path}:NAME.",
            )
        found = getattr(module, self.name)
        if not isinstance(found, Diagram) and callable(found):
            with _blamed(self.path):
                taken = {key: value for key, value in mesh.items() if _takes(found, key)}
                found = found(**taken)
            mesh = {key: value for key, value in mesh.items() if key not in taken}
        drawn = found[0] if isinstance(found, tuple) and found else found
        if not isinstance(drawn, Diagram):
            raise ArgumentTypeError(
                f"file {self.path}: {self.name}",
                expected="a Diagram, or a function that returns one (alone, or first of a tuple)",
                got=type(drawn).__name__,
                fix=f"Give another name, {self.path}:NAME.",
            )
        return _meshed(drawn, mesh)

    def inputs(self, constants: Mapping[str, Any]) -> dict[str, Signal]:
        """Collect the inputs of a run.

        Parameters
        ----------
        constants : mapping
            From the command line, by the name of the exposed port; they go before those of the file.

        Returns
        -------
        dict
            Those that the file calls ``inputs``, and the constants.

        Raises
        ------
        ArgumentTypeError
            If ``inputs`` of the file is no mapping.
        """
        defined = {} if self.path.lower().endswith(".json") else getattr(self._module, "inputs", {})
        if not isinstance(defined, Mapping):
            raise ArgumentTypeError(
                f"file {self.path}: inputs",
                expected="a mapping from exposed ports to constants or functions of time",
                got=type(defined).__name__,
                fix='Such as inputs = {"tip": lambda t: (0.0, -10.0 * t)}.',
            )
        signals = {name: FileSignal(self, name) if callable(value) else value for name, value in defined.items()}
        return {**signals, **constants}

    @property
    def _module(self) -> ModuleType:
        about = os.stat(self.path)
        return _executed(self.path, about.st_mtime_ns, about.st_size)


@dataclass(frozen=True)
class FileSignal:
    """A function of time in a file; other processes find it there.

    Parameters
    ----------
    source : Source
        The file.
    name : str
        In its ``inputs``.
    """

    source: Source
    name: str

    def __call__(self, t: float) -> Any:
        """Evaluate it.

        Parameters
        ----------
        t : float
            Time, s.

        Returns
        -------
        array_like
            What the function in the file returns.
        """
        return self.source._module.inputs[self.name](t)


@dataclass(frozen=True)
class Maker:
    """Makes the system of a file, here or in another process; for studies.

    Parameters
    ----------
    source : Source
        The file.
    mesh : tuple of (str, int), optional
        Arguments of every system that is made.
    """

    source: Source
    mesh: tuple[tuple[str, int], ...] = ()

    def __call__(self, approximation: Requested | None = None, **mesh: Any) -> System:
        """Draw and compile.

        Parameters
        ----------
        approximation : Approximation or mapping, optional
            What is left out.
        **mesh : object
            ``elements``, ``degree``.

        Returns
        -------
        System
            A new one.
        """
        return self.source.diagram(**dict(self.mesh), **mesh).compile(approximation=approximation)


@lru_cache(maxsize=8)
def _executed(path: str, modified: int, size: int) -> ModuleType:
    """Run a Python file once, as long as it stays as it is; modules beside it can be imported by it."""
    file = Path(path).resolve()
    module = ModuleType(f"phblocks_file_{file.stem}")
    module.__file__ = str(file)
    sys.modules[module.__name__] = module  # dataclasses look there
    if str(file.parent) not in sys.path:
        sys.path.insert(0, str(file.parent))
    with _blamed(path):
        exec(compile(file.read_bytes(), str(file), "exec"), module.__dict__)
    return module


@contextmanager
def _blamed(path: str) -> Iterator[None]:
    """Say in which line of the user's file an error was raised."""
    from phblocks.errors import PhblocksError

    try:
        yield
    except PhblocksError as error:
        error.add_note(f"({_line(error, path)})")
        raise
    except (Exception, SystemExit) as error:
        where = f"{path}, line {error.lineno}" if isinstance(error, SyntaxError) else _line(error, path)
        raise ExportError(
            f"file {where}",
            expected="a Python file that runs and defines a diagram",
            got=f"{type(error).__name__}: {error}",
            fix="Correct it; --traceback shows all lines.",
        ) from error


def _line(error: BaseException, path: str) -> str:
    """The innermost line of the file in a traceback."""
    found, step = None, error.__traceback__
    while step is not None:
        if step.tb_frame.f_code.co_filename == str(Path(path).resolve()):
            found = step.tb_lineno
        step = step.tb_next
    return path if found is None else f"{path}, line {found}"


def _takes(function: Callable[..., Any], name: str) -> bool:
    parameters = inspect.signature(function).parameters.values()
    return any(p.name == name or p.kind is p.VAR_KEYWORD for p in parameters)


def _meshed(diagram: Diagram, mesh: Mapping[str, Any]) -> Diagram:
    """Draw a diagram once more, with other arguments of all blocks that have them."""
    if not mesh:
        return diagram
    from phblocks.blocks.block import Block
    from phblocks.description import describe, draw

    data = describe(diagram.network, diagram.ground.block.name)
    for name, value in mesh.items():
        having = [entry for entry in data["blocks"] if name in inspect.signature(Block.kinds[entry["kind"]]).parameters]
        if not having:
            raise DataError(
                f"mesh of diagram {diagram.name!r}",
                expected=f"blocks with {name}",
                got="none",
                fix="Vary something else, such as --over dt.",
            )
        for entry in having:
            entry.setdefault("arguments", {})[name] = value
    new = type(diagram)(data["name"], data.get("gravity"))
    draw(data, new, f"diagram {diagram.name!r}")
    return new
