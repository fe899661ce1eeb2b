"""Time of a run with what is proven to stay zero left out, divided by that of the run with everything.

And of a linear scene, made so by ``large_rotation=False``, beside the same scene as it is. The two alternate in one
process, so that a drift of the machine's speed meets both alike. Time should fall at least as the unknowns do.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from time import perf_counter

import numpy as np

import phblocks as ph
from phblocks.solvers.linear import BandedSolver
from phblocks.solvers.linear_stepper import LinearStepper

sys.path.insert(0, str(Path(__file__).parents[2]))
from examples.four_bar import build
from tests.benchmarks.tables import machine, markdown, write

BAR = ph.Section.rectangle(width=0.05, height=0.05, young=2.1e11, poisson=0.3, density=2710.0, shear_factor=1.0)


def rod(elements: int) -> ph.Diagram:
    """Pull a bar at its end: V1 and N1 are left of six fields."""
    d = ph.Diagram("rod")
    bar = d.add(ph.Beam("bar", BAR, (0.0, 0.0), (2.0, 0.0), elements))
    d.weld(d.ground, bar.start)
    d.connect(bar.end.translation, d.add(ph.Force("F", (1e3, 0.0))).port)
    return d


def hanging(elements: int) -> ph.Diagram:
    """Hang two bars below each other under their weight: V1 and N1 are left, and no angle turns."""
    d = ph.Diagram("hanging", gravity=(0.0, -9.81))
    high = d.add(ph.Beam("high", BAR, (0.0, 0.0), (0.0, -1.0), elements // 2))
    low = d.add(ph.Beam("low", BAR, (0.0, -1.0), (0.0, -2.0), elements // 2))
    d.pin(d.ground, high.start)
    d.pin(high.end, low.start)
    return d


def shaft(discs: int) -> ph.Diagram:
    """Turn discs on a shaft of torsion springs: W3 and M3 are left, the discs do not travel."""
    d = ph.Diagram("shaft")
    wheels = [d.add(ph.RigidBody(f"disc{i}", 2.0, 0.5, (float(i), 0.0))) for i in range(discs)]
    springs = [d.add(ph.TorsionSpring(f"spring{i}", 40.0)) for i in range(discs)]
    d.connect(d.ground.rotation, springs[0].first)
    moment = d.add(ph.Moment("M", 1.0)).port
    for wheel, left, right in zip(wheels, springs, [*(s.first for s in springs[1:]), moment], strict=True):
        d.connect(wheel.centre.rotation, left.second, right)
    return d


def half_at_rest(elements: int) -> ph.Diagram:
    """Shake one four-bar linkage beside another one that nothing moves: half of the blocks are left."""
    d = ph.Diagram("half at rest")
    for name, shift in (("driven", 0.0), ("idle", 10.0)):
        places = [(shift, 0.5), (shift + 2.0, 1.5), (shift + 3.5, 1.5), (shift + 2.5, 0.5)]
        bars = [
            d.add(ph.Beam(f"{name} {i}", BAR, p, q, max(2, elements // 3))) for i, (p, q) in enumerate(pairwise(places))
        ]
        for first, second in zip([d.ground, *(b.end for b in bars)], [*(b.start for b in bars), d.ground], strict=True):
            d.pin(first, second)
        if name == "driven":
            d.connect(bars[0].start.rotation, d.add(ph.Moment("M", 50.0)).port)
    return d


def spatial(force: tuple[float, float, float] | None, elements: int) -> ph.Diagram:
    """Act on a cantilever in space in its own frame: by a force, or a moment about its axis."""
    d = ph.Diagram("spatial")
    beam = d.add(ph.Beam("beam", BAR, (0.0, 0.0, 0.0), (2.0, 0.0, 0.0), elements))
    d.weld(d.ground, beam.start)
    if force is None:
        d.connect(beam.end.rotation, d.add(ph.Moment("M", (10.0, 0.0, 0.0), follows=True)).port)
    else:
        d.connect(beam.end.translation, d.add(ph.Force("F", force, follows=True)).port)
    return d


def shaken(elements: int) -> ph.Diagram:
    """Shake a cantilever in space across, without large rotations: a Timoshenko beam, linear either way."""
    d = ph.Diagram("shaken")
    small = ph.Approximation(large_rotation=False)
    beam = d.add(ph.Beam("beam", BAR, (0.0, 0.0, 0.0), (2.0, 0.0, 0.0), elements, approximation=small))
    d.weld(d.ground, beam.start)
    d.connect(beam.end.translation, d.add(ph.Force("F", (0.0, 10.0, 0.0), follows=True)).port)
    return d


SCENES: dict[str, Callable[[int], ph.Diagram]] = {
    "pulled bar": rod,
    "hanging bars": hanging,
    "turned shaft": shaft,
    "one of two linkages": half_at_rest,
    "in space, pulled": partial(spatial, (1e3, 0.0, 0.0)),
    "in space, twisted": partial(spatial, None),
    "in space, bent in a plane": partial(spatial, (0.0, 1e3, 0.0)),
    "in space, shaken across, linear": shaken,
}


def measure(
    make: Callable[[int], ph.Diagram], size: int, steps: int = 200, rounds: int = 9, dt: float = 1e-4
) -> tuple[tuple[int, int], tuple[float, float]]:
    """Return unknowns and median times of the loop (s), pruned and whole."""
    systems = [make(size).compile(effects=effects) for effects in ("auto", "all")]
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(rounds):
        for system, spent in zip(systems, times, strict=True):
            begin = perf_counter()
            solution = ph.simulate(system, steps * dt, dt, save_every=steps, progress=False)
            assert solution.status.ok and perf_counter() > begin
            spent.append(solution.statistics.loop_seconds)
    unknowns = (systems[0].n, systems[1].n)
    return unknowns, (statistics.median(times[0]), statistics.median(times[1]))


def cantilever(elements: int) -> ph.Diagram:
    """Shake a Timoshenko cantilever across."""
    section = ph.Section(axial=1200.0, shear=1200.0 / 3.12, bending=1.0, mass=1.0, rotary=1.0 / 1200.0)
    d = ph.Diagram("cantilever")
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.0), elements, degree=2))
    d.weld(d.ground, beam.start)
    d.connect(beam.end.translation, d.add(ph.Force("F", (0.0, 1e-3))).port)
    return d


LINEAR: dict[str, Callable[[], ph.Diagram]] = {
    "Timoshenko cantilever, 200 elements": lambda: cantilever(200),
    "four-bar near rest, 100/60/60": lambda: build((100, 60, 60))[0],
    "Timoshenko cantilever, 2000 elements": lambda: cantilever(2000),
}


def measure_linear(
    make: Callable[[], ph.Diagram], steps: int = 100, rounds: int = 5, dt: float = 2e-3
) -> tuple[int, tuple[float, float], tuple[float, float]]:
    """Return unknowns, medians of the loop per step (s), full and linear, and of a linear step and its solve."""
    small = ph.Approximation(large_rotation=False, insist=True)
    full, linear = (make().compile(approximation=a) for a in (None, small))
    assert linear.linear and not full.linear
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(rounds):
        for system, spent in zip((full, linear), times, strict=True):
            spent.append(ph.simulate(system, steps * dt, dt, progress=False).statistics.loop_seconds / steps)
    stepper = ph.Midpoint().prepare(linear)
    assert isinstance(stepper, LinearStepper)
    stage, together = stepper.stage, 10
    x, theta, u = stage.pack(linear.start.x), linear.start.theta, np.zeros((together, 1, linear.n_inputs))
    solver, right = BandedSolver(stage.rows, stage.columns, stage.n), np.random.default_rng(1).standard_normal(linear.n)
    assert solver.factorise(stage.matrix(2.0 / dt)) and stepper.march(x, theta, dt, u) is not None

    def solve() -> None:
        for _ in range(together):
            solver.solve(right)

    functions = (lambda: stepper.march(x, theta, dt, u), solve)
    parts: tuple[list[float], list[float]] = ([], [])
    for _ in range(20 * rounds):
        for function, spent in zip(functions, parts, strict=True):
            begin = perf_counter()
            function()
            spent.append((perf_counter() - begin) / together)
    loop, alone = ((statistics.median(a), statistics.median(b)) for a, b in (times, parts))
    return linear.n, loop, alone


def main() -> None:
    """Measure all scenes in three sizes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="put the table into docs/effects.md")
    arguments = parser.parse_args()
    rows = []
    for name, make in SCENES.items():
        for size in (12, 120, 1200):
            steps = 120_000 // size
            (few, all_), (mine, whole) = measure(make, size, steps)
            ratios = [f"{few / all_:.2f}", f"{mine / whole:.2f}"]
            times = [f"{1e6 * time / steps:.3g}" for time in (mine, whole)]
            rows.append([name, str(size), str(few), str(all_), *times, *ratios])
    header = ["scene", "elements or discs", "unknowns", "of", "step, µs", "of", "unknowns, ratio", "time, ratio"]
    table = markdown(header, rows)
    print(table, machine(), sep="\n\n")
    if arguments.write:
        write("effects.md", "pruning", table)
    rows = []
    for name, draw in LINEAR.items():
        n, (full, loop), (step, solve) = measure_linear(draw)
        numbers = [f"{1e3 * t:.3f}" for t in (full, loop, step, solve)]
        rows.append([name, str(n), *numbers, f"{full / loop:.1f}", f"{step / solve:.2f}"])
    header = ["scene", "unknowns", "nonlinear, ms a step", "linear", "linear, step alone", "back-substitution"]
    table = markdown([*header, "times faster", "step by back-substitution"], rows)
    print(table, machine(), sep="\n\n")
    if arguments.write:
        write("effects.md", "linear", table)


if __name__ == "__main__":
    main()
