"""The package as a whole: what it offers, and what importing it costs."""

import ast
import importlib
import subprocess
import sys
from importlib.resources import files
from pathlib import Path

import pytest

import phblocks

HEAVY = {
    *("sympy", "matplotlib", "matplotlib.pyplot", "scipy.io"),
    *("control", "pymor", "h5py", "numba", "pythonfmu3", "fmpy", "jsonschema"),
    *("pandas", "multiprocessing", "concurrent.futures.process", "threadpoolctl", "dask", "distributed"),
}
#: What a run of a linkage needs no more of than the above.
NOT_FOR_A_RUN = HEAVY | {
    *("networkx", "scipy.optimize", "scipy.integrate", "scipy.special", "scipy.signal", "tqdm"),
    *("phblocks.studies", "phblocks.plots", "phblocks.fmu", "phblocks.report", "phblocks.cli"),
}


def loaded_by(code: str) -> set[str]:
    """Modules that are loaded in a fresh interpreter, because the tests around this one load them."""
    program = f"{code}\nimport sys; print(*sys.modules, sep='\\n')"
    result = subprocess.run([sys.executable, "-W", "error", "-c", program], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return set(result.stdout.split())


def test_import_loads_nothing():
    loaded = loaded_by("import phblocks")
    assert "numpy" not in loaded and "scipy" not in loaded
    assert {name for name in loaded if name.startswith("phblocks")} == {"phblocks"}


def test_what_a_run_needs_is_light():
    assert NOT_FOR_A_RUN & loaded_by("import phblocks as ph; ph.Diagram, ph.Section, ph.Beam, ph.simulate") == set()


def test_all_names_together_leave_heavy_modules_alone():
    loaded = loaded_by("from phblocks import *")
    assert HEAVY & loaded == set() and "phblocks.plots" in loaded


def test_a_file_may_name_any_kind_of_block():
    """Kinds are known by name once their modules are loaded; nobody has used a block before."""
    code = """
import phblocks as ph
from phblocks.blocks.block import Block
try:
    ph.load("no such file.json")
except ph.PhblocksError:
    pass
before = set(Block.kinds)
from phblocks.description import draw
draw({"blocks": [], "junctions": [], "exposed": []}, ph.Diagram(), "")
after = set(Block.kinds)
from phblocks import *
assert {"Beam", "Spring", "CustomBlock"} <= after == set(Block.kinds) and "Spring" not in before
"""
    loaded_by(code)


def test_every_module_with_public_names_can_be_the_first():
    """No module relies on another one having been loaded before: a circle would show here."""
    code = """
import importlib, sys
import phblocks
places = sorted({*phblocks._PLACES.values(), *phblocks._MODULES})
for place in places:
    for name in [name for name in sys.modules if name.split(".")[0] == "phblocks"]:
        del sys.modules[name]
    importlib.import_module(f"phblocks.{place}")
assert len(places) > 30
"""
    loaded_by(code)


def test_every_name_in_all_exists():
    assert [name for name in phblocks.__all__ if not hasattr(phblocks, name)] == []
    assert phblocks.studies is importlib.import_module("phblocks.studies")
    assert phblocks.Beam.__module__ == "phblocks.blocks.beam.beam"


def test_what_runs_is_what_type_checkers_read():
    """The names are written down three times: for type checkers, for the interpreter, and in __all__."""
    tree = ast.parse(Path(phblocks.__file__).read_text(encoding="utf-8"))
    (choice,) = (node for node in tree.body if isinstance(node, ast.If))
    read = {
        alias.name: node.module.removeprefix("phblocks").removeprefix(".") or alias.name
        for node in choice.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert read == phblocks._PLACES | {name: name for name in phblocks._MODULES}
    assert sorted(read) == sorted(phblocks.__all__)


def test_names_are_listed_and_others_refused():
    assert set(phblocks.__all__) <= set(dir(phblocks))
    with pytest.raises(AttributeError, match="'Beem'"):
        _ = phblocks.Beem
    with pytest.raises(ImportError, match="Beem"):
        exec("from phblocks import Beem")


def test_no_name_in_all_twice():
    assert len(phblocks.__all__) == len(set(phblocks.__all__))


def test_marked_as_typed():
    assert files("phblocks").joinpath("py.typed").is_file()


def test_ships_the_schema_of_diagrams():
    assert files("phblocks").joinpath("diagram.schema.json").is_file()
