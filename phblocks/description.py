"""Diagrams as JSON: what a file says, and how a diagram is made of it; see ``docs/diagram-json.md``."""

from __future__ import annotations

import inspect
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from phblocks.blocks import load_all
from phblocks.blocks.block import Block
from phblocks.blocks.values import plain, value_of
from phblocks.errors import ArgumentTypeError, ExportError, PhblocksError, UnknownNameError
from phblocks.network import GAP_TOLERANCE, Junction, Network, drawn_by
from phblocks.ports import TRANSLATION, Port

FORMAT, VERSION = "phblocks diagram", 1
#: Keys of a file, of a block, a junction and an exposed port, and which of them may be left out.
KEYS = {
    "file": (("format", "version", "name", "blocks", "junctions", "exposed"), ("gravity",)),
    "block": (("kind", "name"), ("maker", "arguments")),
    "junction": (("ports",), ("apart",)),
    "exposed": (("port", "name"), ("imposes",)),
}


class Drawing(Protocol):
    """What a diagram is made through: the verbs that users call."""

    network: Network

    def add(self, block: Block) -> object:
        """Add a block.

        Parameters
        ----------
        block : Block
            The block.

        Returns
        -------
        object
            The same.
        """

    def connect(self, *ports: Port, apart: bool = False) -> None:
        """Join ports.

        Parameters
        ----------
        *ports : Port
            Two or more.
        apart : bool
            They may be in different places.
        """

    def free(self, *places: Port) -> None:
        """Declare that nothing is joined to ports.

        Parameters
        ----------
        *places : Port
            The ports.
        """

    def expose(self, port: Port, name: str, imposes: str | None = None) -> None:
        """Open a port to the outside.

        Parameters
        ----------
        port : Port
            The port.
        name : str
            Of input and output.
        imposes : str or None
            What the outside imposes.
        """


def describe(network: Network, ground: str) -> dict[str, Any]:
    """Write a network as plain data.

    Parameters
    ----------
    network : Network
        Blocks and junctions; blocks of nested diagrams have their long names.
    ground : str
        Name of its ground, which every diagram has and no file names.

    Returns
    -------
    dict
        The content of a file.

    Raises
    ------
    ExportError
        If an argument of a block is a function, or of a kind that has no place in a file.
    """
    blocks = []
    for name, block in network.blocks.items():
        if name == ground:
            continue
        entry: dict[str, Any] = {"kind": block.kind, "name": name} | ({"maker": block.maker} if block.maker else {})
        given = {key: value for key, value in block.arguments.items() if key != "name"}
        entry["arguments"] = {
            key: plain(value, f"{block.kind} {name!r} argument {key!r}") for key, value in given.items()
        }
        blocks.append(entry)
    return {
        "format": FORMAT,
        "version": VERSION,
        "name": network.name,
        "gravity": None if network.gravity is None else network.gravity.tolist(),
        "blocks": blocks,
        "junctions": [_junction(junction) for junction in network.joined],
        "exposed": [
            {
                "port": e.port.path,
                "name": e.name,
                "imposes": (e.port.domain.common if e.gives else e.port.domain.summed).name,
            }
            for e in network.exposed
        ],
    }


def write_file(data: Mapping[str, Any], path: str | os.PathLike[str]) -> Path:
    """Write plain data to a file; a file of the same name is replaced.

    Parameters
    ----------
    data : mapping
        What :func:`describe` returned.
    path : str or os.PathLike
        Such as ``"crane.json"``.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    ExportError
        If it cannot be written.
    ArgumentTypeError
        If it is not a path.
    """
    file = _path("save", path)
    text = json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    try:
        file.write_text(text, encoding="utf-8", newline="\n")
    except (OSError, ValueError) as error:
        fix = "Check folder, permissions and characters."
        raise ExportError(f"file {file}", expected="a place to write to", got=str(error), fix=fix) from error
    return file


def read_file(path: str | os.PathLike[str]) -> tuple[Path, dict[str, Any]]:
    """Read a file and check that it is a diagram, of a version that is known.

    Parameters
    ----------
    path : str or os.PathLike
        The file.

    Returns
    -------
    path : pathlib.Path
        The file.
    data : dict
        Its content, for :func:`draw`.

    Raises
    ------
    ExportError
        If it cannot be read, is not JSON, is something else or of a later version, or a key is missing or unknown.
    ArgumentTypeError
        If it is not a path.
    """
    file = _path("load", path)
    where = f"file {file}"
    try:
        data = json.loads(file.read_bytes(), object_pairs_hook=_unique, parse_constant=_no_constant)
    except OSError as error:
        raise ExportError(where, expected="a file that can be read", got=str(error), fix="Check the path.") from error
    except (ValueError, RecursionError) as error:
        raise ExportError(where, expected="JSON", got=str(error) or "a deep nest", fix="Save it once more.") from error
    found = data.get("format") if isinstance(data, dict) else None
    if found != FORMAT:
        got = "one without" if found is None else repr(found)[:60]
        fix = "Give a file written by Diagram.save."
        raise ExportError(where, expected=f"a file that says format = {FORMAT!r}", got=got, fix=fix)
    version = data.get("version")
    if isinstance(version, bool) or version != VERSION:
        fix = "Read it with a later version of the library."
        raise ExportError(where, expected=f"version {VERSION}", got=repr(version)[:60], fix=fix)
    _require_keys(where, data, "file")
    for key in ("blocks", "junctions", "exposed"):
        if not isinstance(data[key], list):
            raise _not(f"{where}: {key}", "a list", data[key])
    return file, data


def draw(data: Mapping[str, Any], diagram: Drawing, where: str) -> None:
    """Add what a file says to an empty diagram, in the same order, with the checks of all calls.

    Parameters
    ----------
    data : mapping
        What :func:`read_file` returned.
    diagram : Drawing
        The diagram.
    where : str
        The file, for messages.

    Raises
    ------
    ExportError
        If a kind of block or an argument is not known, a block cannot be made, or an entry is not what it must be.
    PhblocksError
        As the same calls in Python: a number out of its range, a port that does not exist or is joined already.
    """
    load_all()
    for i, entry in enumerate(data["blocks"]):
        at = f"{where}: blocks[{i}]"
        _require_keys(at, entry, "block")
        with drawn_by(at):
            diagram.add(_block(entry, at))
    for i, entry in enumerate(data["junctions"]):
        at = f"{where}: junctions[{i}]"
        _require_keys(at, entry, "junction")
        paths, apart = entry["ports"], entry.get("apart", False)
        if not isinstance(paths, list) or not paths or not isinstance(apart, bool):
            raise _not(at, "a list of ports, and apart true or false", entry)
        ports = [_port(diagram.network, path, at) for path in paths]
        with drawn_by(at):
            if len(ports) == 1:
                diagram.free(*ports)
            else:
                diagram.connect(*ports, apart=apart)
    for i, entry in enumerate(data["exposed"]):
        at = f"{where}: exposed[{i}]"
        _require_keys(at, entry, "exposed")
        port = _port(diagram.network, entry["port"], at)
        with drawn_by(at):
            diagram.expose(port, entry["name"], entry.get("imposes"))


def _block(entry: Mapping[str, Any], where: str) -> Block:
    kind = Block.kinds.get(entry["kind"]) if isinstance(entry["kind"], str) else None
    if kind is None or inspect.isabstract(kind):
        known = ", ".join(sorted(name for name, k in Block.kinds.items() if not inspect.isabstract(k)))
        raise ExportError(
            f"{where}: kind", expected=f"one of {known}", got=repr(entry["kind"])[:60], fix="Correct it, or import it."
        )
    maker, given = entry.get("maker"), entry.get("arguments", {})
    if maker is not None and maker not in kind.makers:
        raise _not(f"{where}: maker", f"none, or one of {', '.join(kind.makers) or '(none)'}", maker)
    if not isinstance(given, dict):
        raise _not(f"{where}: arguments", "an object", given)
    make = kind if maker is None else getattr(kind, maker)
    parameters = dict(inspect.signature(make).parameters)
    if any(p.kind is p.VAR_KEYWORD for p in parameters.values()):
        parameters |= inspect.signature(kind).parameters
    names = [name for name, p in parameters.items() if name != "name" and p.kind is not p.VAR_KEYWORD]
    if unknown := sorted(given.keys() - set(names)):
        raise _not(f"{where}: arguments of {kind.kind}", ", ".join(names), ", ".join(unknown))
    symbols = _symbols(given.get("variables"), f"{where}: variables") if maker else {}
    arguments = {key: value_of(value, f"{where}: {key}", symbols) for key, value in given.items()}
    try:
        block: Block = make(name=entry["name"], **arguments)
    except PhblocksError:
        raise
    except Exception as error:  # whatever numpy says about data that are not of our making
        got = f"{type(error).__name__}: {error}"
        raise ExportError(where, expected=f"arguments of a {kind.kind}", got=got[:200], fix="Correct them.") from error
    return block


def _symbols(given: object, where: str) -> dict[str, Any]:
    """The symbols that the variables of a block are."""
    import keyword

    names = [v.get("$symbol") if isinstance(v, dict) else None for v in given] if isinstance(given, list) else [None]
    if not all(isinstance(name, str) and name.isidentifier() and not keyword.iskeyword(name) for name in names):
        raise _not(where, 'a list such as [{"$symbol": "q"}]', given)
    import sympy

    return {str(name): sympy.Symbol(str(name)) for name in names}


def _junction(junction: Junction) -> dict[str, Any]:
    entry: dict[str, Any] = {"ports": [port.path for port in junction.ports]}
    places = [p.anchor.position for p in junction.ports if p.domain == TRANSLATION and p.anchor is not None]
    placed = [place for place in places if place is not None]
    gap = max((float(np.linalg.norm(place - placed[0])) for place in placed), default=0.0)
    if placed and gap > GAP_TOLERANCE * (1.0 + float(np.abs(placed[0]).max())):
        entry["apart"] = True
    return entry


def _port(network: Network, path: object, where: str) -> Port:
    name, dot, port = path.partition(".") if isinstance(path, str) else ("", "", "")
    if not dot:
        raise _not(where, 'a port such as "crank.end.translation"', path)
    if name not in network.blocks:
        raise UnknownNameError(
            where, expected=f"a block out of {', '.join(network.blocks)}", got=repr(name), fix="Correct the port."
        )
    return network.blocks[name].ports[port]


def _require_keys(where: str, entry: object, kind: str) -> None:
    needed, optional = KEYS[kind]
    if not isinstance(entry, dict):
        raise _not(where, "an object", entry)
    if missing := [key for key in needed if key not in entry]:
        raise _not(where, f"the keys {', '.join(needed)}", f"none named {', '.join(missing)}")
    if unknown := [key for key in entry if key not in (*needed, *optional)]:
        raise _not(where, f"no keys but {', '.join((*needed, *optional))}", ", ".join(unknown))


def _unique(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        raise ValueError(f"the key {next(key for key in keys if keys.count(key) > 1)!r} twice")
    return found


def _no_constant(name: str) -> float:
    raise ValueError(f"{name}, which is not JSON")


def _path(verb: str, path: object) -> Path:
    if not isinstance(path, (str, os.PathLike)):
        raise ArgumentTypeError(verb, expected="a path", got=repr(path), fix='Give one such as "crane.json".')
    return Path(path)


def _not(where: str, expected: str, got: object) -> ExportError:
    said = got if isinstance(got, str) else repr(got)
    return ExportError(where, expected=expected, got=said[:80], fix="See docs/diagram-json.md.")
