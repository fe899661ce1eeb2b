"""What watching the health of a run costs: time of ``simulate`` with its limits and without any."""

from __future__ import annotations

import argparse
import statistics
import sys
from pathlib import Path
from time import perf_counter

import phblocks as ph
from phblocks.results.health import Health
from phblocks.results.monitor import Monitor

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.benchmarks.compilation import chain
from tests.benchmarks.tables import machine, markdown, write
from tests.hard.scene import four_bar


def measure(system: ph.System, steps: int, dt: float, rounds: int = 5) -> tuple[float, float, float, float]:
    """Return median times: of a step without health, ms, of the sums a step, ms, of the end the first and each time."""
    spent, add = [0.0], Monitor.add

    def timed(self: Monitor, *arguments: object) -> None:
        begin = perf_counter()
        add(self, *arguments)  # type: ignore[arg-type]
        spent[0] += perf_counter() - begin

    ph.simulate(system, dt, dt, limits=ph.Limits.none())  # what is made once
    loops, sums, ends, first = [], [], [], 0.0
    try:
        Monitor.add = timed  # type: ignore[method-assign]
        for round_ in range(rounds):
            spent[0] = 0.0
            solution = ph.simulate(system, steps * dt, dt, limits=ph.Limits.none(), progress=False)
            loops.append(1e3 * (solution.statistics.loop_seconds - spent[0]) / steps)
            sums.append(1e3 * spent[0] / steps)
            begin = perf_counter()
            _ = Health(solution, ph.Limits()).watched
            taken = 1e3 * (perf_counter() - begin)
            if round_ == 0:
                first = taken
            else:
                ends.append(taken)
    finally:
        Monitor.add = add  # type: ignore[method-assign]
    return statistics.median(loops), statistics.median(sums), first, statistics.median(ends or [first])


def rows(rounds: int = 5) -> list[list[str]]:
    """Measure the four-bar of the paper, a finer one, and a chain of many beams."""
    scenes = [
        ("four-bar 10/6/6", four_bar(elements=(10, 6, 6)), 500, 0.02),
        ("four-bar 100/60/60", four_bar(elements=(100, 60, 60)), 200, 0.005),
        ("chain of 250 beams", chain(250).compile(), 100, 0.002),
    ]
    table = []
    for name, system, steps, dt in scenes:
        step, sums, first, end = measure(system, steps, dt, rounds)
        share = (sums + end / steps) / step
        once = (sums + first / steps) / step
        numbers = [f"{step:.3f}", f"{sums:.4f}", f"{end:.2f}", f"{first:.1f}"]
        table.append([name, str(system.n), str(steps), *numbers, f"{100 * share:.1f} %", f"{100 * once:.1f} %"])
    return table


HEADINGS = ["scene", "states", "steps", "step, ms", "sums a step, ms", "end of a run, ms", "first run, ms"]
HEADINGS += ["of a run", "of the first run"]

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="into docs/health.md")
    arguments = parser.parse_args()
    text = markdown(HEADINGS, rows())
    print(text, machine(), sep="\n\n")
    if arguments.write:
        write("health.md", "health", text)
