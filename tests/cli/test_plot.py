"""``phblocks plot``: a file of each kind, that is a picture with something on it."""

import xml.etree.ElementTree as ET
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest


@pytest.fixture
def stored(phblocks):
    """A run on disk."""
    pytest.importorskip("h5py")
    assert phblocks("run rod.py --t-end 0.1 --dt 0.01 --out rod.h5").code == 0


def drawn(path) -> float:
    """Share of the pixels that are not white."""
    picture = plt.imread(path)[:, :, :3]
    assert min(picture.shape[:2]) > 100
    return float(np.mean(picture.min(axis=2) < 0.9))


@pytest.mark.parametrize("kind", ["diagram", "sparsity", "spectrum"])
def test_of_a_diagram(phblocks, kind):
    said = phblocks(f"plot rod.py --kind {kind} --dpi 80 --modes 4")
    assert said.code == 0 and said.out == f"rod_{kind}.png\n"
    assert 0.001 < drawn(f"rod_{kind}.png") < 0.9


@pytest.mark.parametrize("kind", ["motion", "energy", "balance", "gap", "power-flow"])
def test_of_a_stored_run(phblocks, stored, kind):
    said = phblocks(f"plot rod.py --result rod.h5 --kind {kind} --out picture.png --dpi 80 --json")
    assert said.code == 0 and said.data["out"] == "picture.png" and said.data["status"]["ok"]
    assert 0.001 < drawn("picture.png") < 0.9


def test_of_a_run_without_its_diagram(phblocks, stored):
    assert phblocks("plot rod.h5").out == "rod_energy.png\n"
    assert phblocks("plot rod.h5 --kind balance").out == "rod_balance.png\n"
    said = phblocks("plot rod.h5 --kind motion")
    assert said.code == 2 and "--result rod.h5" in said.err


def test_of_a_run_made_for_it(phblocks):
    line = "plot rod.py --t-end 0.2 --dt 0.01 --kind motion --times 0.1 0.2 --out motion.svg"
    assert phblocks(line).code == 0
    root = ET.parse("motion.svg").getroot()
    assert root.tag.endswith("svg") and len(list(root.iter())) > 50


@pytest.mark.parametrize("kind", ["report", "animation"])
def test_pages(phblocks, kind):
    said = phblocks(f"plot rod.py --t-end 0.1 --dt 0.01 --kind {kind}")
    assert said.code == 0 and said.out == f"rod_{kind}.html\n"
    text = Path(f"rod_{kind}.html").read_text(encoding="utf-8")
    assert text.startswith("<!DOCTYPE html>") and len(text) > 5_000


def test_what_cannot_be(phblocks):
    for line, told in (
        ("plot rod.py --kind energy", "no --t-end"),
        ("plot rod.py --out rod.txt", ".png, .svg, .pdf"),
        ("plot rod.py --kind report --out rod.png", ".html"),
        ("plot rod.py --out nowhere/rod.png", "a folder that exists"),
        ("plot none.h5", "none.h5"),
        ("plot rod.py --kind photo", "invalid choice"),
    ):
        said = phblocks(line)
        assert said.code == 2 and told in said.err and said.out == "", line


def test_a_place_that_cannot_be_written_to(phblocks, folder):
    (folder / "taken.png").mkdir()
    said = phblocks("plot rod.py --out taken.png")
    assert said.code == 2 and "PH501" in said.err and plt.get_fignums() == []


def test_dots_per_inch_are_checked_before_anything_is_drawn(phblocks):
    for dpi in ("0", "-80", "nan", "inf", "9.9", "2401"):
        said = phblocks("plot rod.py --out rod.png --json", f"--dpi={dpi}")
        assert said.code == 2 and "plot --dpi" in said.err and "10 to 2400" in said.data["error"]["expected"], dpi
    assert not Path("rod.png").exists()
    assert phblocks("plot rod.py --out rod.png --dpi 10").code == 0 and Path("rod.png").exists()
