"""The four-bar linkage about a posture on its way, reduced by pyMOR to port-Hamiltonian models of a few states.

    python examples/reduced_four_bar.py [--out figures] [--orders 8 12 16 20] [--time 1]

Needs pyMOR: pip install "phblocks[pymor]". A moment drives the crank; the linkage is stopped at a time of the run, and
linear there: small velocities and forces, with joints as they stand. The full model has momenta and elongations as
states (viscous stresses have no energy and are eliminated, which is exact). pH-IRKA (Gugercin, Polyuga, Beattie, van
der Schaft, Automatica 48 (2012) 1963-1974, doi:10.1016/j.automatica.2012.05.052) projects it so that J stays skew and
R positive semidefinite. Prints how far the response from the moment to the spin of the crank is from the full one, and
draws both.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import phblocks as ph

OMEGA = np.logspace(0.0, 3.5, 200)  # rad/s
MOMENT = 200.0  # N m, on the way to the posture


def build() -> ph.Diagram:
    """Draw the linkage with damped bars."""
    bar = ph.Section.rectangle(width=0.05, height=0.05, young=2.1e11, poisson=0.3, density=2710.0, shear_factor=1.0)
    damping = ph.Damping(viscous=2.0, rotary=0.02, internal=1e-4)
    d = ph.Diagram("four-bar")
    crank = d.add(ph.Beam("crank", bar, (0.0, 0.5), (2.0, 1.5), elements=10, damping=damping))
    coupler = d.add(ph.Beam("coupler", bar, (2.0, 1.5), (3.5, 1.5), elements=6, damping=damping))
    rocker = d.add(ph.Beam("rocker", bar, (3.5, 1.5), (2.5, 0.5), elements=6, damping=damping))
    d.pin(crank.start, d.ground)
    d.pin(crank.end, coupler.start)
    d.pin(coupler.end, rocker.start)
    d.pin(rocker.end, d.ground)
    d.expose(crank.start.rotation, "drive")
    return d


@dataclass
class Reduction:
    """One reduced model next to the full one."""

    order: int
    response: np.ndarray  # spin of the crank per moment at OMEGA, rad/s per N m
    error: float  # largest distance from the full response, relative to its largest value
    skew_defect: float  # of J, relative
    least_loss: float  # smallest eigenvalue of R
    iterations: int


@dataclass
class Result:
    """What all of it gave."""

    system: ph.System
    states: int  # of the full model
    turned: float  # the crank, on the way to the posture, rad
    response: np.ndarray  # of the full model at OMEGA
    reductions: list[Reduction]


def run(orders: Sequence[int] = (8, 12, 16, 20), time: float = 1.0) -> Result:
    """Reduce; return responses and how good they are."""
    system = build().compile()
    solution = ph.simulate(system, t_end=time, dt=0.01, inputs={"drive": MOMENT})
    there = solution.at(time)
    posture = ph.State(np.zeros(system.n), there.theta, there.points)
    full = system.to_pymor(posture, energy_variables=True)

    from pymor.algorithms.to_matrix import to_matrix
    from pymor.core.logger import set_log_levels
    from pymor.reductors.ph.ph_irka import PHIRKAReductor

    set_log_levels({"pymor": "ERROR"})
    response = full.transfer_function.freq_resp(OMEGA)[:, 0, 0]
    reductions = []
    for order in orders:
        reductor = PHIRKAReductor(full)
        reduced = reductor.reduce(np.logspace(0.0, 3.0, order), tol=1e-4, maxit=60, projection="QTEorth")
        found = reduced.transfer_function.freq_resp(OMEGA)[:, 0, 0]
        J, R = (to_matrix(operator, format="dense") for operator in (reduced.J, reduced.R))
        reductions.append(
            Reduction(
                order=order,
                response=found,
                error=float(np.abs(found - response).max() / np.abs(response).max()),
                skew_defect=float(np.abs(J + J.T).max() / np.abs(J).max()),
                least_loss=float(np.linalg.eigvalsh((R + R.T) / 2.0).min()),
                iterations=len(reductor.conv_crit),
            )
        )
    turned = float(solution.angle("crank", 0.0)[-1] - solution.angle("crank", 0.0)[0])
    return Result(system, full.order, turned, response, reductions)


def tabulate(result: Result) -> str:
    """Format the numbers as a table."""
    lines = [
        f"{result.system.n} states, {result.states} with energy; the crank has turned by {result.turned:.3f} rad",
        f"{'states':>7}{'error':>10}{'defect of J':>13}{'least eigenvalue of R':>23}{'iterations':>12}",
    ]
    lines += [
        f"{r.order:7}{r.error:10.1e}{r.skew_defect:13.1e}{r.least_loss:23.1e}{r.iterations:12}"
        for r in result.reductions
    ]
    return "\n".join(lines)


def draw(result: Result, out: Path) -> Path:
    """Write the figure; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    figure, ax = plt.subplots(figsize=(7.0, 4.2), layout="constrained")
    ax.loglog(OMEGA, np.abs(result.response), "k", linewidth=2.5, label=f"{result.states} states")
    for reduction in result.reductions:
        ax.loglog(OMEGA, np.abs(reduction.response), "--", label=f"{reduction.order} states")
    ax.set(xlabel="angular frequency (rad/s)", ylabel="spin of the crank per moment (rad/s/(N m))")
    ax.grid(alpha=0.3)
    ax.legend(frameon=False)
    path = out / "reduced_four_bar.png"
    figure.savefig(path, dpi=100)
    plt.close(figure)
    return path


def main(argv: Sequence[str] | None = None) -> Result:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder for the figure")
    parser.add_argument("--orders", type=int, nargs="+", default=(8, 12, 16, 20), help="states of the reduced models")
    parser.add_argument("--time", type=float, default=1.0, help="of the posture, s")
    options = parser.parse_args(argv)
    result = run(tuple(options.orders), options.time)
    print(tabulate(result), "", draw(result, options.out), sep="\n")
    return result


if __name__ == "__main__":
    main()
