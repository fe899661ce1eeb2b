"""The audit of the four-bar in docs/effects.md: what the middle of the coupler calls for, to two tolerances."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import phblocks as ph

sys.path.insert(0, str(Path(__file__).parents[2]))
from examples.four_bar import build
from phblocks.approximation import Requested
from tests.benchmarks.tables import DOCS, write

TOLERANCES = {"audit_loose": 2e-2, "audit_tight": 1e-3}
STEPS = (0.05, 0.025, 0.0125, 0.00625, 0.003125, 0.0015625)
TIMES = [k / 10 for k in range(1, 51)]


def four_bar(approximation: Requested) -> ph.System:
    """The four-bar of the README, two elements of degree 2 a bar."""
    return build((2, 2, 2), 2)[0].compile(approximation=approximation)


def main() -> None:
    """Run both audits."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="put the tables into docs/effects.md, with a figure")
    arguments = parser.parse_args()
    for mark, tolerance in TOLERANCES.items():
        study = ph.studies.effects(
            four_bar,
            ("position", "coupler", 0.5),
            tolerance,
            t_end=5.0,
            steps=STEPS,
            times=TIMES,
            method=ph.GaussLegendre(2),
        )
        print(study.shares, study, sep="\n\n")
        if arguments.write:
            write("effects.md", mark, study.to_markdown())
            study.plot().figure.savefig(DOCS / "images" / f"{mark}.png", dpi=110)


if __name__ == "__main__":
    main()
