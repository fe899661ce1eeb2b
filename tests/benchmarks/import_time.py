"""Time to import the library, divided by that of `scipy.sparse.linalg`, each in an interpreter of its own."""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.benchmarks.tables import machine, markdown, write

YARDSTICK = "import scipy.sparse.linalg"
#: What is typed -> code. The second line is what a first run of a linkage loads, the third all there is.
CODES = {
    "`import phblocks`": "import phblocks",
    "... and `Diagram`, `Section`, `Beam`, `simulate`": (
        "import phblocks as ph; ph.Diagram, ph.Section, ph.Beam, ph.simulate"
    ),
    "`from phblocks import *`": "from phblocks import *",
}


def seconds(code: str) -> float:
    """Time one interpreter, s: from its start to its end, bytecode already compiled."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    begin = perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)
    return perf_counter() - begin


def measure(codes: Sequence[str], rounds: int = 15) -> tuple[float, list[tuple[float, float]]]:
    """Return the median time (s) of the yardstick; of each code its median time (s) and the median ratio.

    Runs alternate, and a ratio is that of two neighbours: a drift of the machine's speed meets both alike. The first
    round writes bytecode and fills the caches of the disk; it does not count.
    """
    table = [[seconds(code) for code in (YARDSTICK, *codes)] for _ in range(rounds + 1)][1:]
    yardstick, *columns = zip(*table, strict=True)
    found = [
        (statistics.median(column), statistics.median(a / b for a, b in zip(column, yardstick, strict=True)))
        for column in columns
    ]
    return statistics.median(yardstick), found


def main() -> None:
    """Measure all three."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="put the table into docs/performance.md")
    parser.add_argument("--rounds", type=int, default=15, help="runs of each, after one that does not count")
    arguments = parser.parse_args()
    base, found = measure(list(CODES.values()), arguments.rounds)
    rows = [[f"`{YARDSTICK}`", f"{base:.3f}", "1"]]
    rows += [[name, f"{time:.3f}", f"{ratio:.2f}"] for name, (time, ratio) in zip(CODES, found, strict=True)]
    table = markdown(["typed", "interpreter, s", "ratio"], rows)
    print(table, machine(), sep="\n\n")
    if arguments.write:
        write("performance.md", "import_time", table)


if __name__ == "__main__":
    main()
