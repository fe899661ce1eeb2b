"""The package as a whole: what it offers, and what importing it costs."""

import subprocess
import sys
from importlib.resources import files

import phblocks

HEAVY = {
    *("sympy", "matplotlib", "matplotlib.pyplot", "scipy.io"),
    *("control", "pymor", "h5py", "pythonfmu3", "fmpy", "jsonschema"),
    *("pandas", "multiprocessing", "concurrent.futures.process", "threadpoolctl", "dask", "distributed"),
}


def test_import_leaves_heavy_modules_alone():
    """In a fresh interpreter, because the tests around this one load them."""
    code = "import sys, phblocks; print(*sys.modules, sep='\\n')"
    result = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert HEAVY & set(result.stdout.split()) == set()


def test_every_name_in_all_exists():
    assert [name for name in phblocks.__all__ if not hasattr(phblocks, name)] == []


def test_no_name_in_all_twice():
    assert len(phblocks.__all__) == len(set(phblocks.__all__))


def test_marked_as_typed():
    assert files("phblocks").joinpath("py.typed").is_file()


def test_ships_the_schema_of_diagrams():
    assert files("phblocks").joinpath("diagram.schema.json").is_file()
