"""Put a measured table, with the machine it was measured on, into a page between two marks."""

from __future__ import annotations

import platform
import re
from collections.abc import Sequence
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def machine() -> str:
    """Name processor, Python and libraries."""
    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = re.findall(r"model name\s*:\s*(.+)", info.read_text())
        cpu = names[0] if names else cpu
    packages = ", ".join(f"{p} {version(p)}" for p in ("numpy", "scipy", "numba") if find_spec(p))
    return f"{cpu}, one BLAS thread; Python {platform.python_version()}, {packages}"


def markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Format rows as a Markdown table."""
    lines = ["| " + " | ".join(header) + " |", "|" + " --- |" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def write(page: str, mark: str, table: str) -> None:
    """Replace what stands between ``<!-- mark -->`` and ``<!-- end -->`` in a page of docs."""
    path = DOCS / page
    text = path.read_text()
    new, count = re.subn(
        rf"(<!-- {mark} -->\n).*?(<!-- end -->)",
        lambda m: f"{m[1]}\n{table}\n\nMeasured on {machine()}.\n\n{m[2]}",
        text,
        flags=re.S,
    )
    if count != 1:
        raise SystemExit(f"{path} has no place marked {mark!r}")
    path.write_text(new)
