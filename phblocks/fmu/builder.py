"""Write the file: a few lines of Python for pythonfmu3, and the diagram."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from phblocks.blocks.checks import require_positive
from phblocks.diagram import Diagram
from phblocks.errors import ArgumentTypeError, ExportError
from phblocks.export.extras import require_extra
from phblocks.export.statespace import legal_names

DIAGRAM = "diagram.json"
SCRIPT = '''"""Made by phblocks."""

from pathlib import Path

from phblocks.fmu.interface import declare
from phblocks.fmu.runtime import Runtime
from pythonfmu3 import Fmi3Slave


class Model(Fmi3Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.modelName = {name!r}
        self.description = {description!r}
        self.runtime = Runtime(Path(self.resources) / {diagram!r}, {step!r})
        declare(self, self.runtime)

    def exit_initialization_mode(self):
        self.runtime.begin()

    def do_step(self, current_time, step_size):
        return self.runtime.advance(step_size)
'''


def write(diagram: Diagram, path: str | os.PathLike[str], step: float = 0.01) -> Path:
    """Write a diagram as an FMU for co-simulation (FMI 3.0).

    Its inputs and outputs are those of the compiled system, with units; inputs are held over a communication step,
    which is divided into equal steps of the time method. Outputs beside them are the energies: stored, of gravity,
    supplied, dissipated, and the largest error of the balance of any step, ``energy.error``.

    Parameters
    ----------
    diagram : Diagram
        Without Python functions in its blocks: signals become inputs, and constants their start.
    path : str or os.PathLike
        Such as ``"crane.fmu"``; a file of this name is replaced.
    step : float, optional
        Longest step of the time method, s: the start of the parameter ``longest_step``.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    ExportError
        If the diagram cannot be stored, or the file cannot be written.
    ExtraMissingError
        If pythonfmu3 is not installed.
    PhblocksError
        If the diagram does not compile.
    """
    if not isinstance(diagram, Diagram):
        raise ArgumentTypeError("fmu.write", expected="a Diagram", got=repr(diagram)[:60], fix="Give the diagram.")
    if not isinstance(path, (str, os.PathLike)) or Path(path).suffix != ".fmu":
        raise ExportError("fmu.write", expected='a path such as "crane.fmu"', got=repr(path), fix="Choose one.")
    longest = require_positive("fmu.write step", step)
    builder = require_extra("pythonfmu3", "fmu", "fmu.write").FmuBuilder
    diagram.compile(effects="all")
    name = legal_names([diagram.name])[0]
    name = name if name.isascii() and not name[0].isdigit() else "model"
    with TemporaryDirectory() as folder:
        script = Path(folder) / "phblocks_model.py"
        words = {"name": name, "description": diagram.name, "diagram": DIAGRAM, "step": longest}
        script.write_text(SCRIPT.format(**words), encoding="utf-8")
        stored = diagram.save(Path(folder) / DIAGRAM)
        try:
            made = builder.build_FMU(script, dest=Path(folder) / "made", project_files=[stored])
            shutil.move(made, Path(path))
        except OSError as error:
            fix = "Check folder and permissions."
            raise ExportError(f"file {path}", expected="a place to write to", got=str(error), fix=fix) from error
        finally:
            sys.modules.pop("phblocks_model", None)
    return Path(path)
