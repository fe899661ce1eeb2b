"""The gallery shows every example in an order that was chosen, with figures, under a title of its own."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
FIGURES = (ROOT / "docs" / "gallery_figures.py").read_text(encoding="utf-8")


def test_every_example_has_its_place():
    """docs/gallery_figures.py imports Sphinx-Gallery, which the tests do without."""
    [order] = [
        ast.literal_eval(node.value)
        for node in ast.parse(FIGURES).body
        if isinstance(node, ast.Assign) and node.targets[0].id == "ORDER"
    ]
    assert sorted(order) == [path.stem for path in EXAMPLES]


def test_every_example_has_a_title():
    titles = []
    for path in EXAMPLES:
        title, line, blank = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")), clean=False).split("\n")[:3]
        assert re.fullmatch("=+", line) and len(line) >= len(title) and not blank, path.name
        titles.append(title)
    assert len(titles) == len(set(titles))


def test_there_are_a_dozen_scenes_with_figures():
    """All but the one that is run on a file of another tool's; tests/examples runs them and counts their figures."""
    tests = (ROOT / "tests" / "examples" / "test_examples.py").read_text(encoding="utf-8")
    drawn = {name for name, figures in re.findall(r"^        \(\"(\w+)\", (\d)\),$", tests, re.M) if int(figures) > 0}
    assert len(drawn) >= 12
    assert {path.stem for path in EXAMPLES} - drawn == {"standalone_four_bar", "reduced_four_bar"}
    assert "reduced_four_bar.png" in tests  # pyMOR may be missing where the others run
