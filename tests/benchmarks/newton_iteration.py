"""Time of one Newton iteration divided by LAPACK ``dgbsv`` on the same band, for the four-bar of the README.

With NumPy, and in compiled code (the extra ``fast``).

Also of one step of the same scene made linear (small motions), divided by ``dgbtrs``.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np
from scipy.linalg import lapack

import phblocks as ph
from phblocks.solvers.compiled import CompiledStepper
from phblocks.solvers.linear import BandedSolver, band_places
from phblocks.solvers.linear_stepper import LinearStepper
from phblocks.solvers.midpoint import MidpointStepper

sys.path.insert(0, str(Path(__file__).parents[2]))
from examples.four_bar import build
from tests.benchmarks.tables import machine, markdown, write

MESHES = ((10, 6, 6), (100, 60, 60), (1000, 600, 600))


def measure(elements: tuple[int, int, int], rounds: int = 15) -> tuple[int, int, list[float], float]:
    """Return unknowns, half-bandwidth, and the median times (s) of iterations and of ``dgbsv``."""
    system = build(elements=elements)[0].compile()
    stepper = ph.Midpoint(ph.Newton(), predict=False).prepare(system)
    fast = ph.Midpoint(ph.ModifiedNewton(max_iterations=1), predict=False).prepare(system)
    assert isinstance(stepper, MidpointStepper) and isinstance(fast, CompiledStepper), 'pip install ".[fast]"'
    stage, solver = stepper.stage, stepper.solver
    assert isinstance(solver, BandedSolver)
    x, theta, u = stage.pack(system.start.x), system.start.theta, np.zeros((1, 0))
    for _ in range(5):  # a state in motion
        step = stepper.step(x, theta, 0.02, u)
        assert step is not None
        x, theta = step.x, step.theta
    z = step.z[0]
    stage.begin(100.0, 0.01, theta, u[0], 100.0 * stage.momentum(x))

    def iteration() -> None:
        residual, jacobian = stage.evaluate(z)
        solver.factorise(jacobian)
        _ = z - solver.solve(residual)

    def compiled() -> None:
        assert fast.step(x, theta, 0.02, u, guess=z[None]) is None  # no second iteration is allowed

    residual, jacobian = stage.evaluate(z)
    band = np.zeros((3 * solver.width + 1, stage.n), order="F")
    band[2 * solver.width + stage.rows - stage.columns, stage.columns] = jacobian
    work = band.copy(order="F")

    def reset() -> None:
        work[:] = band

    def dgbsv() -> None:
        reset()
        lapack.dgbsv(solver.width, solver.width, work, residual, overwrite_ab=1)

    repeats = max(5, 100_000 // stage.n)
    samples: dict[Callable[[], None], list[float]] = {iteration: [], compiled: [], dgbsv: [], reset: []}
    for _ in range(rounds):  # in turn, so that a drift of the machine's speed meets all alike
        for function, times in samples.items():
            begin = perf_counter()
            for _ in range(repeats):
                function()
            times.append((perf_counter() - begin) / repeats)
    *ours, theirs = (statistics.median(samples[f]) for f in (iteration, compiled, dgbsv))
    return stage.n, solver.width, ours, theirs - statistics.median(samples[reset])


def measure_linear(elements: tuple[int, int, int], rounds: int = 15) -> tuple[int, int, list[float], float]:
    """Return unknowns, half-bandwidth, and the median times (s) of a linear step and of ``dgbtrs``."""
    system = build(elements=elements)[0].compile().small_motions()
    stepper, dt, together = ph.Midpoint().prepare(system), 0.02, 50
    assert isinstance(stepper, LinearStepper)
    stage, u = stepper.stage, np.zeros((together, 1, 0))
    x, theta = stage.pack(system.start.x), system.start.theta

    def step() -> None:
        assert stepper.march(x, theta, dt, u) is not None

    width, _ = band_places(stage.rows, stage.columns)
    band, right = np.zeros((3 * width + 1, stage.n), order="F"), np.random.default_rng(1).standard_normal(stage.n)
    band[2 * width + stage.rows - stage.columns, stage.columns] = stage.matrix(2.0 / dt)
    factor, pivots, info = lapack.dgbtrf(band, width, width)
    assert info == 0

    def dgbtrs() -> None:
        for _ in range(together):
            lapack.dgbtrs(factor, width, width, right, pivots)

    repeats = max(2, 200_000 // stage.n // together)
    samples: dict[Callable[[], None], list[float]] = {step: [], dgbtrs: []}
    for _ in range(rounds):
        for function, times in samples.items():
            begin = perf_counter()
            for _ in range(repeats):
                function()
            times.append((perf_counter() - begin) / repeats / together)
    ours, theirs = (statistics.median(samples[f]) for f in (step, dgbtrs))
    return stage.n, width, [ours], theirs


def main() -> None:
    """Measure all meshes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="put the table into docs/performance.md")
    arguments = parser.parse_args()
    kinds = (
        ("newton_iteration", measure, ["NumPy", "compiled"], "`dgbsv`", MESHES),
        ("linear_step", measure_linear, ["one step"], "`dgbtrs`", MESHES[1:]),
    )
    for mark, function, whats, lapacks, meshes in kinds:
        rows = []
        for elements in meshes:
            n, width, ours, theirs = function(elements)
            times = [f"{1e3 * t:.3f}" for t in (*ours, theirs)] + [f"{t / theirs:.1f}" for t in ours]
            rows.append(["/".join(map(str, elements)), str(n), str(width), *times])
        columns = [f"{what}, ms" for what in (*whats, lapacks)] + [f"ratio, {what}" for what in whats]
        table = markdown(["elements", "unknowns", "half-bandwidth", *columns], rows)
        print(table, machine(), sep="\n\n")
        if arguments.write:
            write("performance.md", mark, table)


if __name__ == "__main__":
    main()
