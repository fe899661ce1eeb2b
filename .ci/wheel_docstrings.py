"""Build hook of wheels: internal modules keep the first paragraph of their docstrings, public ones all of it.

Half of the source is docstrings. Lines keep their numbers, so that tracebacks are those of the source.
"""

import ast
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

#: What users hold in their hands, or build upon, beside the modules of public names.
PUBLIC_TOO = (
    *("blocks/block.py", "blocks/form.py", "solvers/method.py", "results/readings.py", "results/status.py"),
    *("modes.py", "export/__init__.py", "export/matrices.py", "system/linearization.py", "network.py"),
)


class ShorterDocstrings(BuildHookInterface):
    """Puts shortened copies of internal modules in the place of the modules."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        self.folder = Path(tempfile.mkdtemp())
        package = Path(self.root) / "phblocks"
        public = {*public_files(package), *(package / name for name in PUBLIC_TOO)}
        for number, file in enumerate(sorted({*package.rglob("*.py")} - public)):
            copy = self.folder / f"{number}.py"
            copy.write_text(shortened(file.read_text(encoding="utf-8")), encoding="utf-8")
            build_data["force_include"][str(copy)] = file.relative_to(self.root).as_posix()

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        if version != "editable":
            shutil.rmtree(self.folder)


def public_files(package: Path) -> set[Path]:
    """Find the modules that public names come from: what the package imports, and what such packages in it import."""
    found, waiting = set(), [package / "__init__.py"]
    while waiting:
        file = waiting.pop()
        found.add(file)
        if file.name == "__init__.py":
            waiting += [path for path in imported(file, package) if path not in found]
    return found


def imported(file: Path, package: Path) -> Iterator[Path]:
    """The files of this package that a file imports from."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == package.name:
            for module in (node.module, *(f"{node.module}.{alias.name}" for alias in node.names)):
                path = package.parent.joinpath(*module.split("."))
                yield from (p for p in (path.with_suffix(".py"), path / "__init__.py") if p.is_file() and p != file)


def shortened(text: str) -> str:
    """Keep the first paragraph of each docstring; blank lines stand for the others."""
    lines = text.split("\n")
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, (ast.FunctionDef, ast.ClassDef)) or ast.get_docstring(node) is None:
            continue
        first, last = node.body[0].lineno - 1, node.body[0].end_lineno - 1
        end = next((i for i in range(first, last) if not lines[i].strip()), None)
        if end is not None and lines[last].strip() == '"""':
            lines[end - 1] += '"""'
            lines[end : last + 1] = [""] * (last + 1 - end)
    return "\n".join(lines)
