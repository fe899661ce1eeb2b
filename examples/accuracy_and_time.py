"""How accurate can the rubber pendulum be in a tenth of a second, and what does an error of 2 mm cost?

    python examples/accuracy_and_time.py [--out figures] [--repeats 3]

Runs the pendulum of `pendulum.py` with two settings of Newton's method, on three meshes, with three steps, and measures
error, time, energy error and gap of each run; then asks for the setting to use, and runs it again. Prints the tables,
draws error against time, and the error against the step.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import phblocks as ph

RUBBER = ph.Section.circle(radius=0.01, young=5e6, poisson=0.5, density=1000.0, shear_factor=27.0 / 28.0)
METHODS = {
    "midpoint": ph.Midpoint(),
    "midpoint, loose Newton": ph.Midpoint(newton=ph.Newton(tolerance=1e-5)),
}
MESHES = [{"elements": 8, "degree": 1}, {"elements": 4, "degree": 2}, {"elements": 4, "degree": 3}]
STEPS = [0.02, 0.01, 0.005]
#: The error is the largest distance of the tip from where it should be at these times, s: at one time alone errors in
#: space and time may happen to cancel.
TIMES = [0.2, 0.4, 0.6, 0.8]
TIP = ("position", "beam", 1.0)
#: What is asked for, m and s.
TOLERANCE, SECONDS = 2e-3, 0.1


def build(elements: int, degree: int) -> ph.System:
    """Make the pendulum, 1 m long, released from horizontal."""
    d = ph.Diagram("rubber pendulum", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("beam", RUBBER, start=(0.0, 0.0), end=(1.0, 0.0), elements=elements, degree=degree))
    d.pin(beam.start, d.ground)
    return d.compile()


@dataclass
class Result:
    """What the studies gave."""

    study: ph.studies.WorkPrecisionStudy
    orders: ph.studies.ConvergenceStudy  # over the step
    cheapest: ph.studies.Run  # to TOLERANCE
    best: ph.studies.Run | None  # within SECONDS, if this machine is fast enough
    again: float  # error of the cheapest setting, run once more, m


def run(repeats: int = 3) -> Result:
    """Measure, choose, and run the choice again."""
    study = ph.studies.work_precision(
        build, METHODS, STEPS, MESHES, quantity=TIP, t_end=TIMES[-1], times=TIMES, repeats=repeats
    )
    orders = ph.studies.convergence(
        build,
        "dt",
        [0.02, 0.01, 0.005, 0.0025, 0.00125],
        quantity=TIP,
        t_end=TIMES[-1],
        times=TIMES,
        mesh=MESHES[1],
        method=METHODS["midpoint"],
    )
    cheapest = ph.studies.cheapest(study, TOLERANCE)
    try:
        best = ph.studies.best_within(study, SECONDS)
    except ph.errors.UnreachedError:
        best = None
    solution = ph.simulate(
        build(**cheapest.mesh_arguments), t_end=TIMES[-1], dt=cheapest.dt, method=METHODS[cheapest.method]
    )
    places = np.rint(np.array(TIMES) / cheapest.dt).astype(int)
    return Result(
        study=study,
        orders=orders,
        cheapest=cheapest,
        best=best,
        again=study.reference.error_of(solution.position("beam", 1.0)[places]) if study.reference else np.nan,
    )


def tabulate(result: Result) -> str:
    """Format the tables and the answers."""
    return "\n".join(
        [
            str(result.study.sort("seconds")),
            "",
            str(result.orders),
            "",
            f"cheapest to {TOLERANCE:g} m:  {result.cheapest}",
            f"  run again:         error {result.again:.3g} m",
            f"best within {SECONDS:g} s:  {result.best or 'none is so fast on this machine'}",
        ]
    )


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figures; return their paths."""
    out.mkdir(parents=True, exist_ok=True)
    order, ax = plt.subplots(figsize=(5.6, 4.2), layout="constrained")
    result.orders.plot(ax=ax)
    figures = {"accuracy_and_time": result.study.plot(), "accuracy_and_time_order": order}
    paths = [out / f"{name}.png" for name in figures]
    for figure, path in zip(figures.values(), paths, strict=True):
        figure.savefig(path, dpi=100)
        plt.close(figure)
    return paths


def main(argv: Sequence[str] | None = None) -> Result:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder for the figures")
    parser.add_argument("--repeats", type=int, default=3, help="how often each run is timed")
    options = parser.parse_args(argv)

    result = run(options.repeats)
    print(tabulate(result), "", *draw(result, options.out), sep="\n")
    return result


if __name__ == "__main__":
    main()
