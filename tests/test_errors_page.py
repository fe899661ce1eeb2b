"""docs/errors.md: every code has a section, and every example there raises what its heading says."""

import re
import warnings
from pathlib import Path

import pytest

from phblocks import PhblocksError, errors

TEXT = (Path(__file__).parents[1] / "docs" / "errors.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.S | re.M)
START = BLOCK.search(TEXT)[1]
SECTIONS = re.findall(r"^### (PH\d+) (\w+)\n(.*?)(?=^##|\Z)", TEXT, re.S | re.M)
CLASSES = {c for c in vars(errors).values() if isinstance(c, type) and issubclass(c, PhblocksError)}


def test_every_code_has_a_section_and_every_section_a_code():
    assert sorted((code, name) for code, name, _ in SECTIONS) == sorted((c.code, c.__name__) for c in CLASSES)


def test_the_table_has_them_all_in_order():
    rows = re.findall(r"^\| (PH\d+) \| `(\w+)` \| `(\w+)` \|", TEXT, re.M)
    assert [code for code, _, _ in rows] == sorted(c.code for c in CLASSES)
    for _, name, base in rows:
        assert base in {c.__name__ for c in getattr(errors, name).__mro__}, name


@pytest.mark.parametrize(("code", "name", "text"), SECTIONS, ids=[s[0] for s in SECTIONS])
def test_the_example_raises_what_it_says(code, name, text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (example,) = BLOCK.findall(text)
    session = {"__name__": "errors"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        exec(START, session)
        if name == "PhblocksError":
            exec(example, session)
            return
        with pytest.raises(PhblocksError) as caught:
            exec(example, session)
    assert type(caught.value).__name__ == name and caught.value.code == code
    assert caught.value.fix


@pytest.mark.parametrize(("code", "name", "text"), SECTIONS, ids=[s[0] for s in SECTIONS])
def test_it_says_what_to_do(code, name, text):
    before, after = BLOCK.split(text)[::2]
    assert len(before.split()) > 4
    assert code == "PH000" or len(after.split()) > 4


def test_numbers_of_the_page():
    """The bushing of the example: 1000 rad/s along the arms, sqrt(k (1/m + arm^2/I) of both) across them."""
    session = {}
    (text,) = [text for code, _, text in SECTIONS if code == "PH304"]
    with pytest.raises(errors.OverdeterminedError):
        exec(START + BLOCK.search(text)[1], session)
    cost = session["d"].check().repairs[0].cost
    assert f"{cost.stiffness / 1e3:.0f} kN/m" in text and f"{cost.frequency:.0f} rad/s" in text
    assert cost.frequency == pytest.approx((cost.stiffness * 2.0 * (1.0 + 1.0 / 0.1)) ** 0.5)
