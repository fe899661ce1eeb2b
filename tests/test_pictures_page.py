"""docs/pictures.md: every code block runs, and writes what it says; every picture is there."""

import re
from pathlib import Path

from tests.test_readme import python_blocks

PAGE = Path(__file__).parents[1] / "docs" / "pictures.md"
TEXT = PAGE.read_text(encoding="utf-8")


def test_code_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    session = {"__name__": "page"}
    for block in python_blocks(TEXT):
        exec(compile(block, str(PAGE), "exec"), session)
    named = set(re.findall(r'"(four_bar\w*\.\w+)"', TEXT))
    assert {path.name for path in tmp_path.iterdir()} == named
    assert (tmp_path / "four_bar_report.html").stat().st_size < 2e6


def test_pictures_are_there():
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", TEXT)
    assert len(pictures) == 3
    assert all((PAGE.parent / picture).is_file() for picture in pictures)


def test_every_plot_of_a_solution_is_on_the_page():
    for name in ("diagram", "power_flow", "spectrum", "gap", "comparison"):
        assert f"ph.plots.{name}(" in TEXT
