"""``phblocks export``: files that are read back, at the start and at a time of a run."""

import json
from pathlib import Path

import numpy as np
import pytest

from phblocks import export


def test_a_diagram_becomes_json_and_stays_the_same(phblocks):
    said = phblocks("export rod.py --to rod.json")
    assert said.code == 0 and said.out == "rod.json\n"
    assert json.loads(Path("rod.json").read_text(encoding="utf-8"))["blocks"][0]["arguments"]["elements"] == 2
    assert phblocks("export rod.json --to again.json").code == 0
    assert Path("again.json").read_text(encoding="utf-8") == Path("rod.json").read_text(encoding="utf-8")
    a, b = (phblocks(f"run {file} --t-end 0.1 --dt 0.01 --json").data for file in ("rod.py", "rod.json"))
    assert a["energy"] == b["energy"]


@pytest.mark.parametrize("suffix", [".mat", ".npz", ".mtx"])
def test_matrices(phblocks, suffix):
    said = phblocks(f"export stone.py --to stone{suffix} --json")
    assert said.code == 0 and said.data["states"] == 2 and said.data["inputs"] == ["push.x", "push.y"]
    matrices = export.read(f"stone{suffix}")
    assert matrices.E.toarray() == pytest.approx(2.0 * np.eye(2))  # kg
    assert matrices.G.toarray() == pytest.approx(np.eye(2))


def test_at_a_time_of_a_run_stored_or_made(phblocks):
    pytest.importorskip("h5py")
    assert phblocks("run rod.py --t-end 0.2 --dt 0.01 --out rod.h5").code == 0
    assert phblocks("export rod.py --to stored.npz --at 0.1 --result rod.h5").code == 0
    assert phblocks("export rod.py --to made.npz --at 0.1 --dt 0.01").code == 0
    assert phblocks("export rod.py --to start.npz --at 0 --dt 0.01").code == 0
    stored, made, start = (export.read(f"{name}.npz") for name in ("stored", "made", "start"))
    assert abs(stored.J - made.J).max() < 1e-9 * abs(made.J).max()
    assert abs(stored.J - start.J).max() > 1e-6 * abs(start.J).max()  # it has turned


def test_an_fmu(phblocks):
    pytest.importorskip("pythonfmu3")
    assert phblocks("export stone.py --to stone.fmu --step 0.001").code == 0
    assert Path("stone.fmu").read_bytes()[:2] == b"PK"


def test_what_cannot_be(phblocks):
    for line, told in (
        ("export stone.py --to stone.txt", ".mat, .npz, .mtx, .json, .fmu"),
        ("export stone.py --to stone.json --at 1", "no time"),
        ("export stone.py --to stone.mat --at 1", "--dt"),
        ("export stone.py --to stone.mat --at 1 --dt 0.1 --method euler", "midpoint"),
        ("export stone.py --to stone.mat --at -1 --dt 0.1", "-1"),
        ("export stone.py --to stone.mat --at 1 --result none.h5", "none.h5"),
        ("export stone.py --to nowhere/stone.mat", "nowhere"),
        ("export stone.py --to nowhere/stone.json", "nowhere"),
        ("export stone.py", "--to"),
    ):
        said = phblocks(line)
        assert said.code == 2 and told in said.err and said.out == "", line


def test_functions_have_no_place_in_json(phblocks, folder):
    (folder / "signal.py").write_text(
        "import phblocks as ph\n"
        "diagram = ph.Diagram('signal')\n"
        "stone = diagram.add(ph.Mass('stone', 2.0, (0.0, 0.0)))\n"
        "push = diagram.add(ph.Force('push', lambda t: (t, 0.0)))\n"
        "diagram.connect(push.port, stone.centre.translation)\n"
    )
    said = phblocks("export signal.py --to signal.json")
    assert said.code == 2 and "PH501" in said.err and "a function" in said.err
