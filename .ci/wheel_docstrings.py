"""Build hook of wheels: what users call keeps its docstrings, the rest is code only, so that wheels stay small.

Half of the source is docstrings and comments. Those of all names in the reference (docs/api.rst) and of their public
methods stay, comments do not; lines keep their numbers, so that tracebacks are those of the source.
"""

import ast
import io
import re
import shutil
import tempfile
import tokenize
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SUMMARY = re.compile(r"^\.\. autosummary::\n(?: +:.*\n)*\n((?:   \S.*\n)+)", re.M)


class FewerDocstrings(BuildHookInterface):
    """Puts copies without internal docstrings in the place of modules."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        self.folder, root = Path(tempfile.mkdtemp()), Path(self.root)
        names = reference((root / "docs" / "api.rst").read_text(encoding="utf-8"))
        for number, file in enumerate(sorted((root / "phblocks").rglob("*.py"))):
            copy, text = self.folder / f"{number}.py", file.read_text(encoding="utf-8")
            shorter = without_internal_docstrings(text, names)
            if code(shorter) != code(text):
                raise ValueError(f"{file}: without internal docstrings it would be another program")
            copy.write_text(shorter, encoding="utf-8")
            build_data["force_include"][str(copy)] = file.relative_to(root).as_posix()

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        if version != "editable":
            shutil.rmtree(self.folder)


def reference(text: str) -> set[str]:
    """The names in the reference, without their modules."""
    return {name.rpartition(".")[2] for names in SUMMARY.findall(text) for name in names.split()}


def without_internal_docstrings(text: str, names: set[str]) -> str:
    """Leave empty lines in the place of comments and of docstrings that no user reads, but for one that is a body."""
    lines = text.split("\n")

    def visit(node: ast.AST, public: bool) -> None:
        for child in ast.iter_child_nodes(node):
            if not isinstance(child, (ast.FunctionDef, ast.ClassDef)):
                visit(child, public)
                continue
            shown = child.name in names
            if isinstance(node, ast.ClassDef):
                shown = public and (child.name == "__init__" or not child.name.startswith("_"))
            if ast.get_docstring(child) is not None and not shown:
                first, last = child.body[0].lineno - 1, (child.body[0].end_lineno or 0) - 1
                if len(child.body) > 1:
                    lines[first : last + 1] = [""] * (last + 1 - first)
                elif last > first and not lines[first].rstrip().endswith('"'):
                    lines[first] += '"""'
                    lines[first + 1 : last + 1] = [""] * (last - first)
            visit(child, shown)

    visit(ast.parse(text), False)
    for token in tokenize.generate_tokens(io.StringIO("\n".join(lines)).readline):
        if token.type == tokenize.COMMENT and token.line.lstrip().startswith("#"):
            lines[token.start[0] - 1] = ""
    return "\n".join(lines)


def code(text: str) -> tuple[str, list[int]]:
    """What a module does, and in which lines: its tree without the docstrings of classes and functions."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and ast.get_docstring(node) is not None:
            del node.body[0]
    return ast.dump(tree), [node.lineno for node in ast.walk(tree) if hasattr(node, "lineno")]
