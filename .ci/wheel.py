"""Builds the wheel and tries it as users get it: size, content, command, and types for code of theirs.

Run by `.ci/run` with the Python of an environment that has the dependencies and mypy.
"""

import ast
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MOST_BYTES = 500_000
#: Some of what users call, with docstrings in the wheel as in the source.
SHOWN = {
    "phblocks/diagram.py": ("Diagram", "compile", "load"),
    "phblocks/simulation.py": ("simulate",),
    "phblocks/blocks/form.py": ("Form",),
}
SHIPPED = ("py.typed", "diagram.schema.json", "report/page.css", "report/page.js", "__main__.py", "cli/entry.py")


def run(*command: object, cwd: Path) -> str:
    """Run a command that must succeed; return what it printed."""
    done = subprocess.run([str(part) for part in command], cwd=cwd, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def build(folder: Path) -> Path:
    """Build it."""
    run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", folder, ROOT, cwd=folder)
    (wheel,) = folder.glob("phblocks-*.whl")
    return wheel


def docstrings(text: str) -> dict[str, str | None]:
    """Those of all classes and functions by name."""
    nodes = [node for node in ast.walk(ast.parse(text)) if isinstance(node, (ast.FunctionDef, ast.ClassDef))]
    return {node.name: ast.get_docstring(node) for node in nodes}


def inspect(wheel: Path) -> None:
    """Check size and content."""
    size = wheel.stat().st_size
    assert size < MOST_BYTES, f"{wheel.name} has {size} bytes"
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (points,) = (name for name in names if name.endswith("entry_points.txt"))
        assert "phblocks = phblocks.cli:main" in archive.read(points).decode()
        for name, shown in SHOWN.items():
            shipped = docstrings(archive.read(name).decode())
            source = docstrings((ROOT / name).read_text(encoding="utf-8"))
            assert all(shipped[key] and shipped[key] == source[key] for key in shown), f"docstrings of {name}"
    assert not [path for path in SHIPPED if f"phblocks/{path}" not in names]
    foreign = [name for name in names if not name.startswith(("phblocks/", "phblocks-")) or "__pycache__" in name]
    assert not foreign, foreign
    print(f"{wheel.name}: {size / 1000:.0f} kB, {len(names)} files")


def try_out(wheel: Path, folder: Path) -> None:
    """Install it beside the dependencies of this environment; run the command, and mypy on the examples."""
    run(sys.executable, "-m", "venv", folder / "venv", cwd=folder)
    python = folder / "venv" / "bin" / "python"
    run(python, "-m", "pip", "install", "--quiet", "--no-deps", wheel, cwd=folder)
    place = run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=folder).strip()
    # as text, so that nothing is executed that makes the clone importable
    Path(place, "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    where = run(python, "-c", "import phblocks; print(phblocks.__file__)", cwd=folder).strip()
    assert Path(where).is_relative_to(place), where
    shutil.copytree(ROOT / "examples", folder / "examples")
    command = folder / "venv" / "bin" / "phblocks"
    assert "141 states" in run(command, "check", "examples/four_bar.py:build", cwd=folder)
    options = ("--strict", "--config-file", ROOT / "pyproject.toml", "--python-executable", python, "--no-incremental")
    print(run(sys.executable, "-m", "mypy", *options, "examples", cwd=folder).strip())


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        wheel = build(Path(name))
        inspect(wheel)
        try_out(wheel, Path(name))
