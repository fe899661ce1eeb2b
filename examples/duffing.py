"""A Duffing oscillator: an energy that is not quadratic, with the discrete gradient and with the midpoint rule.

    python examples/duffing.py [--out figures]

A mass on a spring that stiffens, q'' = -q - q^3, from q = 2 m at rest. The discrete gradient keeps its energy to
round-off; the midpoint rule lets it swing by 1e-2 J. Both are of second order in q.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import ellipj

import phblocks as ph
from phblocks.solvers.method import Method

START, DT, END = 2.0, 0.05, 100.0  # m, s, s
METHODS: dict[str, Method] = {
    "discrete gradient": ph.DiscreteGradient(),
    "midpoint": ph.Midpoint(allow_energy_error=True),
}
LINE = ph.Domain("line", ph.Quantity("velocity", "m/s"), ph.Quantity("force", "N"))


def build(damping: float = 0.0) -> ph.Diagram:
    """Draw the diagram, with a force from outside on the mass; x = (q, p)."""
    d = ph.Diagram("Duffing oscillator")
    oscillator = d.add(
        ph.CustomBlock(
            "oscillator",
            size=2,
            hamiltonian=lambda x: x[1] ** 2 / 2 + x[0] ** 2 / 2 + x[0] ** 4 / 4,
            gradient=lambda x: [x[0] + x[0] ** 3, x[1]],
            hessian=lambda x: [[1.0 + 3.0 * x[0] ** 2, 0.0], [0.0, 1.0]],
            J=[[0.0, 1.0], [-1.0, 0.0]],
            R=[[0.0, 0.0], [0.0, damping]],
            G=[[0.0], [1.0]],
            ports={"mass": ph.SystemPort(LINE, columns=(0,), gives="velocity")},
            start=[START, 0.0],
            units=("m", "kg m/s"),
        )
    )
    d.expose(oscillator["mass"], "force")
    return d


def exact(t: np.ndarray) -> np.ndarray:
    """Position of the undamped oscillator that starts at rest: Jacobi's elliptic cosine."""
    squared = 1.0 + START**2
    return np.asarray(START * ellipj(np.sqrt(squared) * t, START**2 / (2.0 * squared))[1])


@dataclass
class Run:
    """What one method gave."""

    solution: ph.Solution
    energy_error: float  # largest, J
    position_errors: dict[float, float]  # largest up to t = 10 s, by step, m


def run(method: Method) -> Run:
    """Integrate with one method; the errors of position with three steps."""
    system = build().compile()
    solution = ph.simulate(system, END, DT, method=method)
    energy, errors = solution.energy.total, {}
    for dt in (DT, DT / 2, DT / 4):
        short = ph.simulate(system, 10.0, dt, method=method)
        errors[dt] = float(np.abs(short.x[:, 0] - exact(short.t)).max())
    return Run(solution, float(np.abs(energy - energy[0]).max()), errors)


def tabulate(runs: dict[str, Run]) -> str:
    """Format the numbers as a table."""
    steps = list(next(iter(runs.values())).position_errors)
    lines = [
        f"{'':>18}{'energy off, J':>15}" + "".join(f"{f'q off, dt {dt:g}':>18}" for dt in steps) + f"{'order':>8}",
    ]
    for name, result in runs.items():
        errors = list(result.position_errors.values())
        order = np.log2(errors[-2] / errors[-1])
        lines.append(f"{name:>18}{result.energy_error:15.2e}" + "".join(f"{e:18.3e}" for e in errors) + f"{order:8.3f}")
    return "\n".join(lines)


def draw(runs: dict[str, Run], out: Path) -> list[Path]:
    """Write the figure; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    figure, axis = plt.subplots(figsize=(7.0, 3.5), layout="compressed")
    for name, result in runs.items():
        energy = result.solution.energy.total
        axis.semilogy(result.solution.t[1:], np.maximum(np.abs(energy - energy[0])[1:], 1e-17), label=name)
    axis.set(xlabel="t, s", ylabel="change of energy, J")
    axis.legend()
    path = out / "duffing.png"
    figure.savefig(path, dpi=100)
    plt.close(figure)
    return [path]


def main(argv: Sequence[str] | None = None) -> dict[str, Run]:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder for the figures")
    options = parser.parse_args(argv)

    runs = {name: run(method) for name, method in METHODS.items()}
    print(tabulate(runs), "", *draw(runs, options.out), sep="\n")
    return runs


if __name__ == "__main__":
    main()
