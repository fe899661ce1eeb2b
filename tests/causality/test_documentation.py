"""The examples of docs/errors.md raise what their heading says."""

import re
from pathlib import Path

import pytest

from phblocks import errors

TEXT = (Path(__file__).parents[2] / "docs" / "errors.md").read_text(encoding="utf-8")
START = re.search(r"```python\n(import phblocks.*?)```", TEXT, re.S)[1]
SECTIONS = re.findall(r"^### (PH\d+) (\w+)\n(.*?)(?=^###? |\Z)", TEXT, re.S | re.M)


@pytest.mark.parametrize(("code", "name", "text"), SECTIONS, ids=[s[0] for s in SECTIONS])
def test_the_example_raises_what_it_says(code, name, text):
    with pytest.raises(getattr(errors, name)) as caught:
        exec(START + re.search(r"```python\n(.*?)```", text, re.S)[1], {})
    assert type(caught.value).__name__ == name and caught.value.code == code
    assert caught.value.fix


def test_every_class_of_causality_has_a_section():
    classes = [c for c in vars(errors).values() if isinstance(c, type) and issubclass(c, errors.CausalityError)]
    assert {c.__name__ for c in classes} <= {name for _, name, _ in SECTIONS}
