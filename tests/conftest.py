"""What every test runs under: no screen, the same random examples in every run, the reference numbers."""

import json
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

os.environ["MPLBACKEND"] = "Agg"

settings.register_profile("fixed", derandomize=True, deadline=None)
settings.load_profile("fixed")


@pytest.fixture(scope="session")
def references() -> dict[str, Any]:
    """Numbers this project did not compute; see tests/README.md."""
    return json.loads(Path(__file__).with_name("references.json").read_text(encoding="utf-8"))
