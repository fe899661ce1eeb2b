"""The code of docs/effects.md runs, and its table is the one that is printed."""

import re
import warnings
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs" / "effects.md"
TEXT = DOCS.read_text(encoding="utf-8")


def test_code_runs(tmp_path, monkeypatch, capsys):
    """The blocks follow each other like the cells of one session."""
    blocks = list(re.finditer(r"^```python\n(.*?)^```$", TEXT, flags=re.MULTILINE | re.DOTALL))
    assert blocks
    monkeypatch.chdir(tmp_path)
    session = {"__name__": "docs"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for block in blocks:
            exec(compile("\n" * TEXT.count("\n", 0, block.start(1)) + block[1], str(DOCS), "exec"), session)
    printed = capsys.readouterr().out
    (table,) = re.findall(r"^```text\n(.*?)^```$", TEXT, flags=re.MULTILINE | re.DOTALL)
    lines = {line.rstrip() for line in printed.splitlines()}
    for line in table.splitlines():
        shown = line.removesuffix(", ...")
        assert any(real.startswith(shown) for real in lines), line
    assert "[PH404]" in printed
