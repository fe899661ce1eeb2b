"""The code of docs/files.md runs, and the page names every series."""

import re
import warnings
from pathlib import Path

import matplotlib.pyplot as plt

from phblocks.results.recording import ROWS, STEPS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "files.md"
TEXT = PAGE.read_text(encoding="utf-8")


def test_code_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    session = {"__name__": "files"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for block in re.finditer(r"^```python\n(.*?)^```$", TEXT, flags=re.MULTILINE | re.DOTALL):
            exec(compile("\n" * TEXT.count("\n", 0, block.start(1)) + block[1], str(PAGE), "exec"), session)
    plt.close("all")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["early.h5", "run.h5"]


def test_page_names_every_series():
    for name in (*ROWS, *STEPS):
        assert f"`{name}`" in TEXT or f"/{name}`" in TEXT, name
