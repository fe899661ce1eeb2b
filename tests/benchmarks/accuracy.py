"""What accuracy costs, here and in Exudyn: the tables and figures of docs/accuracy.md. Needs ``pip install exudyn``.

    python tests/benchmarks/accuracy.py [--quick] [--write] [--only four_bar large ...]

``--quick`` tries a few settings once; ``--only`` does some of the sections. Runs of both codes alternate in one process
with one thread.
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
import phblocks as ph
from phblocks.studies.machine import one_thread, this_machine
from phblocks.studies.measurement import Measurement, Runner, record
from phblocks.studies.quantity import distance, observe
from phblocks.studies.run import Job, Run, Setting
from phblocks.studies.settings import with_tolerance
from phblocks.studies.work_precision import WorkPrecisionStudy
from tests.benchmarks import accuracy_figures
from tests.benchmarks.accuracy_scenes import BY_STEP, Scene, Sweep, rubber_pendulum, scenes
from tests.benchmarks.peers import exudyn_beams
from tests.benchmarks.tables import DOCS, machine, markdown, write

PEER = "Exudyn"
#: Scene and error; the fastest settings below it are compared.
TARGETS = (("four_bar", 1e-3), ("four_bar", 2.5e-4), ("rubber_pendulum", 1e-3))

#: Runs that take at most this many times the time of the cheapest one as accurate are timed all the times, those of
#: less than SHORT seconds three times, the others once.
NEAR, SHORT = 1.3, 0.3

SCENES = ("four_bar", "rubber_pendulum", "flying_spaghetti")
SECTIONS = (*SCENES, "orders", "large", "growth")


class PeerRunner:
    """Does a job in Exudyn, as ``phblocks.studies`` does one of ours."""

    def __init__(self, job: Job, scene: Scene) -> None:
        self.job, self.measured, self._scene = job, Measurement(), scene
        self._run: Callable[..., exudyn_beams.Run] = getattr(exudyn_beams, scene.name)

    def repeat(self) -> None:
        """Run once; before the first time once more, untimed, for the energies."""
        measured, setting = self.measured, self.job.setting
        if measured.status != "success":
            return
        if not measured.seconds:
            run = self._simulate(energies=True)
            if not run.finished:  # a fixed step that fails is cut
                options = {**setting.arguments, "adaptive": True}
                self.job = replace(
                    self.job, setting=replace(setting, method=f"{setting.method}, adaptive", arguments=options)
                )
                run = self._simulate(energies=True)
            if not run.finished:
                measured.status = measured.status_text = "the run did not reach its end"
                return
            measured.states, measured.steps, measured.newton_iterations = run.unknowns, run.steps, run.iterations
            measured.halvings = max(0, run.steps - round(self.job.t_end / setting.dt))
            kept = run.energies[run.t >= self._scene.free]
            total = kept.sum(axis=1)
            measured.energy_error = float(np.abs(total - total[0]).max() / np.abs(run.energies).max())
        run = self._simulate()
        measured.seconds.append(run.seconds)
        measured.value = run.at(self._scene.times)

    def _simulate(self, **more: bool) -> exudyn_beams.Run:
        setting, t_end = self.job.setting, self.job.t_end
        return self._run(**setting.mesh, dt=setting.dt, t_end=t_end, **setting.arguments, **more)


def settings(scene: Scene, sweep: Sweep) -> Iterator[Setting]:
    """What a sweep runs."""
    own = dict(sweep.options) if sweep.method is None else {"method": sweep.method, **scene.inputs}
    for mesh in sweep.meshes:
        for dt in sweep.steps:
            for tolerance in sweep.tolerances or (None,):
                arguments, rtol = (own, 0.0) if tolerance is None else with_tolerance("accuracy", own, tolerance)
                yield Setting(mesh, dt, sweep.name, arguments, rtol)


def references(scene: Scene, quick: bool) -> tuple[ph.studies.Reference, str]:
    """The reference errors are measured against, and how the published and our own finest run agree."""
    mesh, dt = scene.fine[0], scene.fine[1] * (5 if quick else 1)
    observed = observe(scene.name, scene.quantity, scene.times, scene.t_end, "")

    def run(mesh: Any, dt: float) -> np.ndarray:
        method = ph.GaussLegendre(3)
        system = scene.make_system(**mesh)
        return observed(ph.simulate(system, max(scene.times), dt, method=method, progress=False, **scene.inputs))

    value = run(mesh, dt)
    agreement = distance(value, scene.published)
    uncertainty = distance(value, run({**mesh, "degree": mesh["degree"] - 1}, 2 * dt))
    text = (
        f"Our own finest run (three stages, {mesh}, dt = {dt:g} s; twice the step and one degree less move it by "
        f"{uncertainty:.1e} m) is {agreement:.1e} m from the published value, which is good to "
        f"{scene.published_uncertainty:g} m."
    ).replace("'", "")
    if scene.own_reference:
        return ph.studies.Reference(value, uncertainty, "our own finest run"), text + " Errors: from our own."
    return (
        ph.studies.Reference(scene.published, scene.published_uncertainty, "tests/references.json"),
        text + " Errors: from the published one.",
    )


def study(scene: Scene, repeats: int, reference: ph.studies.Reference) -> WorkPrecisionStudy:
    """Run both codes in turn."""
    observed = observe(scene.name, scene.quantity, scene.times, scene.t_end, "")
    systems: dict[int, ph.System] = {}

    def job(setting: Setting) -> Job:
        return Job(scene.make_system, setting, scene.t_end, observed, repeats, timed=True)

    ours = [Runner(job(s), systems) for sweep in scene.ours for s in settings(scene, sweep)]
    peer = [PeerRunner(job(s), scene) for sweep in scene.peer for s in settings(scene, sweep)]
    # spread over the round as evenly as can be, so that what slows the machine for a while slows both codes
    spread = [((i + 0.5) / len(part), r) for part in (ours, peer) for i, r in enumerate(part)]
    runners = [runner for _, runner in sorted(spread, key=lambda pair: pair[0])]
    for k in range(repeats):
        chosen = runners if not k else [*worth_repeating(ours, reference, k), *worth_repeating(peer, reference, k)]
        clock = told = perf_counter()
        for i, runner in enumerate(r for r in runners if r in chosen):
            with one_thread():
                runner.repeat()
            if perf_counter() - told > 15.0:
                told = perf_counter()
                print(f"    {i + 1} of {len(chosen)} runs, {told - clock:.0f} s", flush=True)
        print(f"  round {k + 1} of {repeats}: {len(chosen)} runs, {perf_counter() - clock:.0f} s", flush=True)
    rows = [Run(**record(r.job, r.measured, reference, shared_machine=False)) for r in runners]
    return WorkPrecisionStudy(tuple(rows), reference)


def worth_repeating(runners: Sequence[Any], reference: ph.studies.Reference, k: int) -> list[Any]:
    """The runs of one code that may be the cheapest at their error, and for the first rounds those that cost little."""
    known = [(r, reference.error_of(r.measured.value), min(r.measured.seconds, default=math.inf)) for r in runners]
    fronts = [min((t for _, e, t in known if e <= error), default=0.0) for _, error, _ in known]
    return [r for (r, _, s), t in zip(known, fronts, strict=True) if s <= NEAR * t or (k < 3 and s < SHORT)]


def of_peer(row: Run) -> bool:
    """Whether a run is Exudyn's."""
    return row.method.startswith(PEER)


def of_ours(row: Run) -> bool:
    """Whether a run is of a method of this library; SciPy's are not."""
    return not of_peer(row) and not row.method.startswith("SciPy")


def setting_cells(row: Run) -> list[str]:
    """Method, mesh and step."""
    return [row.method, row.mesh, f"rtol {row.rtol:g}" if row.rtol else f"{row.dt:g} s"]


def front_table(result: WorkPrecisionStudy) -> str:
    """The runs of each code that no other of the same code beats in both error and time."""
    rows = []
    groups = [of_ours, of_peer, lambda row: not of_ours(row) and not of_peer(row)]
    for group in groups:
        for row in result.filter(group).front:
            gap = "none" if math.isnan(row.gap) else f"{row.gap:.1e}"
            numbers = [str(row.states), f"{row.error:.1e}", f"{row.seconds:.3f}", f"{row.energy_error:.1e}", gap]
            rows.append([*setting_cells(row), *numbers])
    header = ["method", "mesh", "step", "unknowns", "error, m", "time, s", "energy error", "gap, m"]
    failed = result.filter(lambda row: not row.ok)
    text = markdown(header, rows)
    if len(failed):
        text += f"\n\n{len(failed)} of {len(result)} runs did not reach their end: "
        text += "; ".join(", ".join(setting_cells(row)) for row in failed) + "."
    return text


def target_table(results: dict[str, WorkPrecisionStudy]) -> str:
    """The fastest settings below given errors, of the scenes that were measured."""
    rows = []
    for name, error in ((name, error) for name, error in TARGETS if name in results):
        found: list[Run | None] = []
        for group in (of_ours, of_peer):
            enough = [row for row in results[name].filter(group) if row.ok and row.error < error]
            found.append(min(enough, key=lambda row: row.seconds) if enough else None)
        ratio = f"{found[1].seconds / found[0].seconds:.2f}" if found[0] and found[1] else "-"
        cells = [
            f"{', '.join(setting_cells(row))}: **{row.seconds:.3f} s** ({row.error:.1e} m)" if row else "not reached"
            for row in found
        ]
        rows.append([name.replace("_", "-"), f"< {error:g} m", *cells, ratio])
    return markdown(["scene", "error", "fastest of ours", f"fastest of {PEER}", "times faster than Exudyn"], rows)


def large_table(elements: int, steps: int, repeats: int) -> str:
    """Time of a step of the rubber pendulum, in turn."""
    system, dt = rubber_pendulum(elements), 0.005
    methods = {"Midpoint": ph.Midpoint(), "LinearlyImplicit": ph.LinearlyImplicit()}
    runs: dict[str, Callable[[], float]] = {
        name: lambda m=method: timed(system, steps, dt, m) for name, method in methods.items()
    }
    for name, options in ((PEER, {}), (f"{PEER}, modified Newton", {"modified": True})):
        runs[name] = lambda o=options: exudyn_beams.rubber_pendulum(elements, 1, dt, steps * dt, **o).seconds
    warm_up(methods.values())
    samples: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(repeats):
        for name, run in runs.items():
            with one_thread():
                samples[name].append(1e3 * run() / steps)
        print("  " + ", ".join(f"{name}: {times[-1]:.2f} ms a step" for name, times in samples.items()), flush=True)
    medians = {name: statistics.median(times) for name, times in samples.items()}
    rows = [[name, f"{ms:.2f}", f"{ms / medians[PEER]:.2f}"] for name, ms in medians.items()]
    return markdown(["method", f"ms a step, {elements} elements, {steps} steps", f"times {PEER}'s"], rows)


def warm_up(methods: Iterable[Any]) -> None:
    """Load and compile what is loaded and compiled once a process."""
    for method in methods:
        timed(rubber_pendulum(4), 4, 0.005, method)


def timed(system: ph.System, steps: int, dt: float, method: Any) -> float:
    """Seconds of a run."""
    clock = perf_counter()
    solution = ph.simulate(system, steps * dt, dt, method=method, progress=False)
    seconds = perf_counter() - clock
    assert solution.status.ok, solution.status
    return seconds


def growth_table(sizes: Sequence[int], repeats: int) -> str:
    """Time of a step over the number of elements: of some steps more, so that what a run needs once is not in it."""
    warm_up([ph.Midpoint()])
    rows, costs, peer_costs, dt, clock = [], [], [], 0.005, perf_counter()
    for n in sizes:
        system = rubber_pendulum(n)
        few, more = (4, max(8, 20_000 // n)) if n < 30_000 else (2, 4)
        ours, peer = [], []
        for _ in range(repeats):
            with one_thread():
                short, long = (timed(system, k, dt, ph.Midpoint()) for k in (few, few + more))
                ours.append((long - short) / more)
                if n <= 10_000:  # Exudyn makes its elements one by one
                    short, long = (exudyn_beams.rubber_pendulum(n, 1, dt, k * dt).seconds for k in (few, few + more))
                    peer.append((long - short) / more)
        costs.append(statistics.median(ours))
        peer_costs.append(statistics.median(peer) if peer else math.nan)
        rows.append([str(n), *(f"{1e3 * cost:.2f}" if cost == cost else "-" for cost in (costs[-1], peer_costs[-1]))])
        print(f"  {n} elements: {1e3 * costs[-1]:.2f} ms a step ({perf_counter() - clock:.0f} s)", flush=True)
    exponents = []
    for values in (costs, peer_costs):
        pairs = [(n, c) for n, c in zip(sizes, values, strict=True) if c > 0.0]
        exponents.append(f"{np.polyfit(*np.log(np.array(pairs)).T, 1)[0]:.2f}" if len(pairs) > 1 else "-")
    rows.append(["fitted exponent", *exponents])
    return markdown(["elements", "Midpoint, ms a step", f"{PEER}, ms a step"], rows)


def orders_table(steps: Sequence[float], reference_step: float) -> str:
    """Errors of the four-bar in its first second, space apart: the reference has the same mesh."""
    scene = next(scene for scene in scenes() if scene.name == "four_bar")
    mesh, times = {"elements": (2, 2, 2), "degree": 2}, [0.2, 0.4, 0.6, 0.8, 1.0]
    options = {"quantity": scene.quantity, "times": times, "t_end": 1.0}
    exact = ph.simulate(scene.make_system(**mesh), 1.0, reference_step, method=ph.GaussLegendre(3), times=times)
    reference = exact.position(*scene.quantity[1:])[1:]
    rows = []
    for name, method in BY_STEP:
        clock = perf_counter()
        found = ph.studies.convergence(
            scene.make_system, "dt", steps, mesh=mesh, method=method, reference=reference, progress=False, **options
        )
        cells = [f"{row.error:.1e}" + (f" ({row.rate:.1f})" if row.rate == row.rate else "") for row in found]
        rows.append([name, str(method.order), *cells])
        print(f"  {name}: {perf_counter() - clock:.0f} s", flush=True)
    return markdown(["method", "order", *(f"{dt:g} s" for dt in sorted(steps, reverse=True))], rows)


def earlier(folder: Path) -> dict[str, WorkPrecisionStudy]:
    """What was measured before on this machine with these versions."""
    found = {}
    for name in SCENES:
        with suppress(ph.errors.ExportError):  # never measured, or in other columns
            study = WorkPrecisionStudy.from_csv(folder / f"accuracy_{name}.csv")
            if all(row.machine == this_machine() for row in study):
                found[name] = study
    return found


def fewer(scene: Scene) -> Scene:
    """A few settings, to try: of every method the coarsest step on the last mesh of its first sweep."""

    def cut(part: Sequence[Sweep]) -> list[Sweep]:
        first = {s.name: s for s in reversed(part)}.values()
        return [replace(s, meshes=s.meshes[-1:], steps=s.steps[:1], tolerances=s.tolerances[:1]) for s in first]

    return replace(scene, ours=cut(scene.ours), peer=cut(scene.peer))


def main(argv: Sequence[str] | None = None) -> dict[str, str]:
    """Measure, print, and write if that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="put tables and figures into docs")
    parser.add_argument("--quick", action="store_true", help="few settings, once")
    parser.add_argument("--repeats", type=int, default=5, help="how often each run is timed")
    parser.add_argument("--only", nargs="+", choices=SECTIONS, default=SECTIONS, help="sections to measure")
    parser.add_argument("--figures", type=Path, help="folder for figures and runs, also without --write")
    options = parser.parse_args(argv)
    repeats, clock = 1 if options.quick else options.repeats, perf_counter()
    images, runs = (DOCS / "images", DOCS / "figures") if options.write else (options.figures, options.figures)
    tables: dict[str, str] = {}
    results = {} if runs is None else earlier(runs)

    def write_down(mark: str, table: str) -> None:
        """At once: what comes later may fail."""
        tables[mark] = table
        print(f"\n{mark} ({perf_counter() - clock:.0f} s)\n\n{table}\n", flush=True)
        if options.write:
            write("accuracy.md", mark, table)

    def announce(section: str) -> bool:
        if section in options.only:
            print(f"{section} ({perf_counter() - clock:.0f} s)", flush=True)
        return section in options.only

    for scene in scenes():
        if not announce(scene.name):
            continue
        chosen = fewer(scene) if options.quick else scene
        reference, agreement = references(chosen, options.quick)
        print(f"  reference ({perf_counter() - clock:.0f} s)", flush=True)
        results[scene.name] = result = study(chosen, repeats, reference)
        write_down(scene.name, f"{agreement}\n\n{front_table(result)}")
        if runs is not None:
            runs.mkdir(parents=True, exist_ok=True)
            result.to_csv(runs / f"accuracy_{scene.name}.csv")
            accuracy_figures.draw(result, scene.title, images / f"accuracy_{scene.name}.png", of_ours, of_peer)
    if set(options.only) & {name for name, _ in TARGETS}:
        write_down("targets", target_table(results))
    if announce("orders"):
        steps = (0.02, 0.01) if options.quick else (0.02, 0.01, 0.005, 0.0025, 0.00125)
        write_down("orders", orders_table(steps, 1 / 400 if options.quick else 1 / 3200))
    if announce("large"):
        write_down("large", large_table(1000, 10 if options.quick else 100, repeats))
    if announce("growth"):
        sizes = (100, 1000) if options.quick else (100, 300, 1000, 3000, 10_000, 30_000, 100_000)
        write_down("growth", growth_table(sizes, repeats))
    print(f"{machine()}, exudyn {version('exudyn')}; {perf_counter() - clock:.0f} s in total")
    return tables


if __name__ == "__main__":
    main()
