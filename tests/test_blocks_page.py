"""docs/blocks.md names every block, and what it says to write can be written."""

import re
from pathlib import Path

import numpy as np

import phblocks as ph
from phblocks.blocks.block import Block

TEXT = (Path(__file__).parents[1] / "docs" / "blocks.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| `(\w+)` \| (.*?) \| (.*?) \|", TEXT, re.M)


def test_every_block_has_a_row():
    public = {n for n in ph.__all__ if isinstance(getattr(ph, n), type) and issubclass(getattr(ph, n), Block)}
    assert {name for name, _, _ in ROWS} == public


def test_the_calls_work_and_the_places_exist():
    section = ph.Section(axial=1e4, shear=1e4, bending=10.0, mass=1.0, rotary=1e-3)
    for name, made, joined in ROWS:
        call = re.search(r"`(ph\.\w+\((?:[^`]|\.(?!\.\.))*?\))`", made)
        if call is None or "..." in call[1] or name in ("SystemBlock", "CustomBlock"):
            continue
        block = eval(call[1], {"ph": ph, "np": np, "section": section})
        assert type(block).__name__ == name
        for place in re.findall(r"`(\w+)`", joined):
            if place not in ("first_rotation", "second_rotation"):
                assert hasattr(block, place), (name, place)
