"""How much of the forces of constraint of an inextensible, unshearable four-bar alternates, at first and at last."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

import phblocks as ph

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.benchmarks.tables import machine, markdown, write
from tests.validation.test_constraint_forces import INEXTENSIBLE, alternating, four_bar

LITTLE = ph.Damping(internal=1e-4)
RUNS: list[tuple[str, ph.Damping | None, ph.Midpoint | ph.RadauIIA, float, int]] = [
    ("midpoint", None, ph.Midpoint(), 1e-4, 50_000),
    ("midpoint", None, ph.Midpoint(), 5e-4, 10_000),
    ("midpoint", None, ph.Midpoint(), 5e-3, 10_000),
    ("midpoint, 0.1 ms of internal damping", LITTLE, ph.Midpoint(), 5e-3, 10_000),
    ("`RadauIIA(3)`", None, ph.RadauIIA(3), 5e-3, 10_000),
]


def measure(
    damping: ph.Damping | None, method: ph.Midpoint | ph.RadauIIA, dt: float, steps: int
) -> dict[str, tuple[float, float, float]]:
    """Return the size of N1 and N2 (N), and the parts that alternate in the first and in the last tenth of a run."""
    system = four_bar(INEXTENSIBLE, damping)
    run = ph.simulate(system, steps * dt, dt, method=method, limits=ph.Limits.none(), progress=False)
    assert run.status.ok
    parts = {}
    for field in ("N1", "N2"):
        forces = run.x[2:-2, [f".{field}[" in name for name in system.state_names]]
        tenth = len(forces) // 10
        size = float(np.sqrt(np.mean(np.square(forces))))
        parts[field] = size, alternating(forces[:tenth]), alternating(forces[-tenth:])
    return parts


def main() -> None:
    """Measure all runs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="put the table into docs/approximations.md")
    arguments = parser.parse_args()
    rows = []
    for name, damping, method, dt, steps in RUNS:
        row = [name, f"{1e3 * dt:g}", f"{steps}"]
        for size, first, last in measure(damping, method, dt, steps).values():
            row += [f"{size:.0f}", f"{first:.2g}", f"{last:.2g}"]
        rows.append(row)
    header = ["method", "dt, ms", "steps", "N1, N", "first tenth", "last tenth", "N2, N", "first tenth", "last tenth"]
    table = markdown(header, rows)
    print(table, machine(), sep="\n\n")
    if arguments.write:
        write("approximations.md", "multipliers", table)


if __name__ == "__main__":
    main()
