"""Time to check and to compile diagrams of many beams: a pinned chain and a triangulated truss."""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import phblocks as ph
from phblocks.assembly import interconnection

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.benchmarks.tables import machine, markdown, write

BAR = ph.Section.rectangle(width=0.05, height=0.05, young=2.1e11, poisson=0.3, density=2710.0)


def chain(beams: int) -> ph.Diagram:
    """Hang a chain of pinned beams of two elements on the ground."""
    d = ph.Diagram("chain", gravity=(0.0, -9.81))
    last = d.ground
    for i in range(beams):
        beam = d.add(ph.Beam(f"beam{i}", BAR, (i, 0.0), (i + 1.0, 0.0), elements=2))
        d.pin(last, beam.start)
        last = beam.end
    return d


def truss(beams: int) -> ph.Diagram:
    """Make a pinned truss of triangles; every joint but the outermost ones is shared by four beams."""
    d = ph.Diagram("truss", gravity=(0.0, -9.81))
    at: dict[tuple[float, float], list[ph.Anchor]] = {}

    def add(p: tuple[float, float], q: tuple[float, float]) -> None:
        beam = d.add(ph.Beam(f"beam{sum(map(len, at.values())) // 2}", BAR, p, q, elements=2))
        at.setdefault(p, []).append(beam.start)
        at.setdefault(q, []).append(beam.end)

    for i in range(beams // 4):
        low, high = (float(i), 0.0), (i + 0.5, 1.0)
        add(low, (i + 1.0, 0.0))
        add(low, high)
        add((i + 1.0, 0.0), high)
        add(high, (i + 1.5, 1.0))
    for point, anchors in at.items():
        if point == (0.0, 0.0):
            anchors.append(d.ground)
        if len(anchors) > 1:
            d.pin(*anchors)
    return d


def measure(make: Callable[[int], ph.Diagram], beams: int, rounds: int = 3) -> tuple[int, float, float, float]:
    """Return states, and the median times (s) of ``check()``, of ``compile()`` and of finding the effects in it."""
    times: list[tuple[float, float, float]] = []
    prune, spent = interconnection.prune, [0.0]

    def timed(*arguments: Any) -> Any:
        begin = perf_counter()
        kept = prune(*arguments)
        spent[0] = perf_counter() - begin
        return kept

    try:
        interconnection.prune = timed
        for _ in range(rounds):
            d = make(beams)
            t0 = perf_counter()
            d.check()
            t1 = perf_counter()
            system = d.compile()
            times.append((t1 - t0, perf_counter() - t1, spent[0]))
    finally:
        interconnection.prune = prune
    check, compilation, effects = (statistics.median(column) for column in zip(*times, strict=True))
    return system.n, check, compilation, effects


def main() -> None:
    """Measure both families."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="put the table into docs/performance.md")
    arguments = parser.parse_args()
    rows = []
    for make in (chain, truss):
        for beams in (250, 500, 1000, 2000):
            n, check, compilation, effects = measure(make, beams)
            share = f"{100.0 * effects / compilation:.1f} %"
            rows.append([make.__name__, str(beams), str(n), f"{check:.2f}", f"{compilation:.2f}", share])
    names = ["diagram", "beams", "states", "`check()`, s", "`compile()` with its check, s", "finding effects"]
    table = markdown(names, rows)
    print(table, machine(), sep="\n\n")
    if arguments.write:
        write("performance.md", "compilation", table)


if __name__ == "__main__":
    main()
