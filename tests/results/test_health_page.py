"""docs/health.md: its code runs, its limits are the defaults."""

import re
from dataclasses import fields
from pathlib import Path

import phblocks as ph

TEXT = (Path(__file__).parents[2] / "docs" / "health.md").read_text(encoding="utf-8")


def test_code_runs(capsys):
    (code,) = re.findall(r"^```python\n(.*?)^```$", TEXT, re.S | re.M)
    session = {"__name__": "health"}
    exec(code, session)
    assert session["solution"].health.ok
    printed = capsys.readouterr().out
    assert "h omega_max" in printed and "gap of strain and configuration" in printed


def test_the_limits_are_those_of_the_page():
    rows = re.search(r"^\| number .*?\n\n", TEXT, re.S | re.M)[0].splitlines()[2:]
    told = [float(re.match(r" *([0-9.e-]+)", row.split("|")[-2])[1]) for row in rows if row]
    limits = ph.Limits()
    assert told == [
        getattr(limits, name)
        for name in ("balance", "unresolved", "alternation", "halvings", "gap", "closure", "momentum")
    ]
    assert len(told) == len(fields(limits)) and ph.Limits.suited(False).balance == 1e-2
