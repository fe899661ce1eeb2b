"""Run the suite and put what it measured into ``docs/stability.md``.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python -m tests.hard.table --write            # all but the full lengths
    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python -m tests.hard.table --write --full     # those too: an hour
    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python -m tests.hard.table --write --case 4   # one case

What was measured is kept in ``results.json`` with its date and machine; a run replaces the rows that it ran.
"""

import argparse
import datetime
import importlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from typing import Any

from tests.benchmarks.tables import DOCS, machine, markdown
from tests.hard.scene import Scene

RESULTS = Path(__file__).with_name("results.json")
PAGE = DOCS / "stability.md"
START, END = "<!-- hard cases -->\n", "<!-- end -->"
HEADER = ("scene", "length", "measured (bound)", "halvings", "Newton, mean / most", "time, s", "date")


def cases() -> Iterator[tuple[int, str, list[Scene]]]:
    """Number, title and scenes of each case."""
    for path in sorted(Path(__file__).parent.glob("test_[0-9]*.py")):
        module = importlib.import_module(f"tests.hard.{path.stem}")
        yield int(path.stem.split("_")[1]), module.CASE, module.SCENES


def key(case: int, scene: Scene) -> str:
    return f"{case}: {scene.title}, {scene.length}"


def measure(scene: Scene) -> dict[str, Any]:
    """Run a scene: what stands in its row."""
    clock = perf_counter()
    outcome = scene.run()
    iterations = outcome.iterations
    return {
        "measured": str(outcome),
        "holds": all(check.holds for check in outcome.checks),
        "halvings": outcome.halvings,
        "newton": f"{iterations.mean():.1f} / {iterations.max()}" if iterations.size else "",
        "seconds": round(perf_counter() - clock, 1),
        "date": datetime.date.today().isoformat(),
        "machine": machine(),
    }


def page(results: dict[str, dict[str, Any]]) -> str:
    """The table of each case, of all that was measured."""
    parts, machines = [], set()
    for number, title, scenes in cases():
        rows, others = [], []
        for scene in scenes:
            row = results.get(key(number, scene))
            if row is None:
                continue
            machines.add(row["machine"])
            words = f"{row['measured']}. **Open:** {scene.open}" if scene.open else row["measured"]
            cells = [words, str(row["halvings"]), row["newton"], f"{row['seconds']:g}", row["date"]]
            rows.append([scene.title, scene.length, *cells])
            if scene.others:
                others.append(f"Elsewhere ({scene.title}): {scene.others}.")
        parts += [f"### {number}. {title}", markdown(HEADER, rows), *others]
    return "\n\n".join([*parts, f"Measured on {'; '.join(sorted(machines))}."])


def write(results: dict[str, dict[str, Any]]) -> None:
    """Keep what was measured, and show it in the page."""
    RESULTS.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    text, table = PAGE.read_text(encoding="utf-8"), page(results)
    pattern = re.compile(f"({START}).*?({END})", flags=re.S)
    PAGE.write_text(pattern.sub(lambda m: f"{m[1]}\n{table}\n\n{m[2]}", text), encoding="utf-8")


def read() -> dict[str, dict[str, Any]]:
    """What was measured before."""
    return json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}


def forget(results: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Drop the rows of scenes that are no more."""
    known = {key(number, scene) for number, _, scenes in cases() for scene in scenes}
    return {name: row for name, row in results.items() if name in known}


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="keep the results and put them into docs/stability.md")
    parser.add_argument("--full", action="store_true", help="the scenes of full length too")
    parser.add_argument("--case", type=int, help="one case only")
    parser.add_argument("--scene", default="", help="only scenes whose title or length has this text")
    parser.add_argument("--missing", action="store_true", help="only scenes that were not measured yet")
    parser.add_argument("--forget", action="store_true", help="run nothing, drop the rows of scenes that are no more")
    arguments = parser.parse_args()
    if arguments.forget:
        write(forget(read()))
        return
    for number, title, scenes in cases():
        if arguments.case in (None, number):
            print(f"{number}. {title}")
        for scene in scenes:
            wanted = arguments.case in (None, number) and arguments.scene in f"{scene.title}, {scene.length}"
            wanted = wanted and not (arguments.missing and key(number, scene) in read())
            if wanted and (arguments.full or scene.tier != "full"):
                row = measure(scene)
                print(f"  {scene.title}, {scene.length}: {row['measured']} [{row['seconds']} s]", flush=True)
                if arguments.write:
                    write(read() | {key(number, scene): row})


if __name__ == "__main__":
    main()
