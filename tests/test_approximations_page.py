"""docs/approximations.md: the code runs, and what it says in numbers is so."""

import re
import warnings
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

import phblocks as ph

DOCS = Path(__file__).parents[1] / "docs" / "approximations.md"
TEXT = DOCS.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def session():
    """The blocks follow each other like the cells of one session, and raise no warning."""
    found = {"__name__": "docs"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for block in re.finditer(r"^```python\n(.*?)^```$", TEXT, flags=re.MULTILINE | re.DOTALL):
            exec(compile("\n" * TEXT.count("\n", 0, block.start(1)) + block[1], str(DOCS), "exec"), found)
    return found


def test_the_first_system(session):
    assert [(e.block, e.name) for e in session["system"].approximations] == [
        ("crank", "extension"),
        ("coupler", "extension"),
        ("rocker", "flexible"),
    ]
    assert session["solution"].status.ok
    assert {n.split(".")[0] for n in session["system"].state_names} >= {"pin ground rocker"}


def test_every_field_has_a_row():
    rows = re.findall(r"^\| `(\w+)` \| ", TEXT.split("## What each changes")[0], re.M)
    assert rows == [f.name for f in fields(ph.Approximation) if f.name != "insist"]


def test_the_spinning_beam(session):
    """The text of the refusal, the strain at the root, and the frequency at second order."""
    (rate,) = re.findall(r"at the rate (4\.\d+) 1/s", TEXT)
    with pytest.raises(ph.errors.ApproximationError, match=re.escape(rate)):
        session["spinning"](ph.Approximation(large_rotation=False)).compile()
    strain = 1.2 * 36.0 * 50.0 / 2.8e7
    assert strain == pytest.approx(8e-5, rel=0.05)
    system, u = session["second_order"], np.array([6.0])
    state = system.rigid_motion(spin=6.0)
    for _ in range(3):
        A = system.linearize(state, u).A.tocsc()[: system.n, : system.n]
        x = state.x + spsolve(A, -system.force(state.x, state.theta, u))
        state = ph.State(x, state.theta, state.points)
    assert f"{system.modes(1, state, u).frequencies[0]:.4f}" == "4.5119"
    assert "4.51189 rad/s" in TEXT
