"""The reference (docs/api.rst) has every public name, and every name in it is there."""

import importlib
import re
from pathlib import Path

import phblocks as ph

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "api.rst").read_text(encoding="utf-8")
SUMMARIES = re.findall(r"^\.\. autosummary::\n((?: +:.*\n)*)\n((?:   \S.*\n)+)", TEXT, re.M)
LISTED = [name for _, names in SUMMARIES for name in names.split()]
DATA = re.findall(r"^\.\. py:data:: (\w+)$", TEXT, re.M)
MODULES = re.findall(r"^\.\. automodule:: (\S+)$", TEXT, re.M)


def test_every_public_name_is_in_the_reference():
    """Modules are there with the names in them."""
    modules = {"errors", "export", "fmu", "plots", "studies"}
    assert modules <= set(ph.__all__)
    missing = set(ph.__all__) - modules - set(LISTED) - set(DATA)
    assert missing == set()
    for module in modules - {"errors"}:
        assert {f"{module}.{name}" for name in getattr(ph, module).__all__} - set(LISTED) <= {"export.CONVENTION"}
    assert MODULES == ["phblocks.errors"]
    assert {f"export.{name}" for name in ("read", "write", "Matrices", "Tangent")} <= set(LISTED)


def test_every_name_of_the_reference_exists():
    assert len(LISTED) == len(set(LISTED))
    assert all(":toctree: _api" in options for options, _ in SUMMARIES)
    for name in [*LISTED, *DATA]:
        module, _, last = f"phblocks.{name}".rpartition(".")
        try:
            assert hasattr(importlib.import_module(module), last), name
        except ModuleNotFoundError:
            raise AssertionError(name) from None
