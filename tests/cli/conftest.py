"""Files as users have them, and commands run in this process."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from phblocks.cli import main

#: A point mass in free fall, pushed along x on request: every number of its runs is known by heart.
STONE = """
import phblocks as ph

def diagram():
    d = ph.Diagram("stone", gravity=(0.0, -10.0))
    stone = d.add(ph.Mass("stone", 2.0, (0.0, 0.0)))
    d.expose(stone.centre.translation, "push")
    return d
"""
#: A flexible pendulum that falls from horizontal; takes elements.
ROD = """
import phblocks as ph

SECTION = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)

def diagram(elements=2):
    d = ph.Diagram("rod", gravity=(0.0, -9.81))
    rod = d.add(ph.Beam("rod", SECTION, (0.0, 0.0), (1.0, 0.0), elements=elements, degree=2))
    d.pin(rod.start, d.ground)
    return d
"""
#: Two bodies that both give velocity where they are pinned.
BODIES = """
import phblocks as ph

diagram = ph.Diagram("bodies")
a = diagram.add(ph.RigidBody("a", 1.0, 0.1, (0.0, 0.0), {"tip": (1.0, 0.0)}))
b = diagram.add(ph.RigidBody("b", 1.0, 0.1, (2.0, 0.0), {"tip": (1.0, 0.0)}))
diagram.pin(a["tip"], b["tip"])
"""
#: A cantilever in space whose frames stay as they are, pushed at its tip.
CANTILEVER = """
import phblocks as ph

SECTION = ph.Section(axial=1e6, shear=(4e5, 4e5), bending=(200.0, 100.0), mass=1.0, rotary=(1e-3, 2e-3),
                     torsion=150.0, polar=3e-3)

def diagram():
    d = ph.Diagram("cantilever")
    linear = ph.Approximation(large_rotation=False)
    b = d.add(ph.Beam("b", SECTION, (0, 0, 0), (1, 0, 0), elements=4, approximation=linear))
    d.weld(b.start, d.ground)
    d.expose(b.end.translation, "tip")
    return d
"""
#: Three rigid bars on four pins: a loop with one degree of freedom.
FRAME = """
import itertools
import numpy as np
import phblocks as ph

diagram = ph.Diagram("frame", gravity=(0.0, -9.81))
corners = np.array([(0.0, 0.0), (0.3, 1.0), (1.5, 1.2), (1.8, 0.1)])
a, b, c = (
    diagram.add(ph.RigidBody(name, 1.0, 0.1, (start + end) / 2, {"start": start, "end": end}))
    for name, (start, end) in zip("abc", itertools.pairwise(corners))
)
diagram.pin(a["start"], diagram.ground, multiplier=True)
diagram.pin(a["end"], b["start"], multiplier=True)
diagram.pin(b["end"], c["start"], multiplier=True)
diagram.pin(c["end"], diagram.ground, multiplier=True)
"""
FILES = {"stone.py": STONE, "rod.py": ROD, "bodies.py": BODIES, "cantilever.py": CANTILEVER, "frame.py": FRAME}


@dataclass
class Said:
    """What a command left."""

    code: int
    out: str
    err: str

    @property
    def data(self) -> dict[str, Any]:
        """Its answer, of a command with --json: nothing else may be on stdout."""
        return json.loads(self.out, parse_constant=pytest.fail)


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """A folder with the files, where commands run."""
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def phblocks(folder, capsys) -> Callable[..., Said]:
    """A function that carries out a command, given as on the command line."""

    def carry_out(line: str, *more: str) -> Said:
        code = main([*line.split(), *more])
        captured = capsys.readouterr()
        return Said(code, captured.out, captured.err)

    return carry_out
