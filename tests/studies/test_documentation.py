"""The code of docs/studies.md runs, and its table names columns that are there."""

import re
import warnings
from pathlib import Path

import matplotlib.pyplot as plt

from phblocks.studies import Run, WorkPrecisionStudy

DOCS = Path(__file__).resolve().parents[2] / "docs" / "studies.md"
TEXT = DOCS.read_text(encoding="utf-8")


def test_code_runs(tmp_path, monkeypatch):
    """The blocks follow each other like the cells of one session."""
    blocks = list(re.finditer(r"^```python\n(.*?)^```$", TEXT, flags=re.MULTILINE | re.DOTALL))
    assert len(blocks) == 3
    monkeypatch.chdir(tmp_path)
    session = {"__name__": "docs"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for block in blocks:
            exec(compile("\n" * TEXT.count("\n", 0, block.start(1)) + block[1], str(DOCS), "exec"), session)
    plt.close("all")
    assert isinstance(session["row"], Run) and session["row"].error_bound <= 2e-3
    assert session["again"] == session["study"]
    assert (tmp_path / "study.png").stat().st_size > 10_000


def test_columns_exist():
    names = re.findall(r"^\| (`.*?`) \|", TEXT, flags=re.MULTILINE)
    columns = [name for cell in names for name in re.findall(r"`(\w+)`", cell)]
    assert len(columns) == 14
    assert set(columns) <= set(WorkPrecisionStudy(()).columns)
