"""A column that buckles
=======================

How a compressed column loses its stiffness, and where it goes when it has none left.

::

    python examples/buckling_column.py [--out figures]

A slender column, pinned at its foot and on a guide at its head, is pressed together. About the straight state the
square of its first frequency falls in proportion to the load and is zero at Euler's load, pi^2 EI / L^2 (Southwell's
line); the linear model about rest knows nothing of this. Above that load, pressed slowly and with some drag, it bends
out into the elastica. Prints frequencies next to theory, and the shortening next to elliptic integrals.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import phblocks as ph

LENGTH, WIDTH, THICKNESS, YOUNG, DENSITY = 1.0, 0.02, 0.005, 2.1e11, 7850.0  # m, Pa, kg/m^3
BENDING, MASS = YOUNG * WIDTH * THICKNESS**3 / 12.0, DENSITY * WIDTH * THICKNESS  # N m^2, kg/m
SECTION = ph.Section.rectangle(
    width=WIDTH, height=THICKNESS, young=YOUNG, poisson=0.3, density=DENSITY, shear_factor=5.0 / 6.0
)
EULER = np.pi**2 * BENDING / LENGTH**2  # N
LOADS = np.linspace(0.0, 0.95, 20)  # of Euler's load, where frequencies are taken
TOP, RAMP, HOLD = 1.4, 8.0, 1.0  # of Euler's load; s


def press(t: float) -> float:
    """Force on the head, N, without the sideways nudge that shows the column where to go."""
    s = min(t / RAMP, 1.0)
    return -TOP * EULER * s * s * (3.0 - 2.0 * s)


def build(elements: int = 8, degree: int = 2, viscous: float = 0.0) -> tuple[ph.Diagram, ph.Beam]:
    """Draw the column, lying along x; return it with its beam."""
    d = ph.Diagram("column")
    nudge = ph.LineLoad("nudge", (0.0, 0.2), follows=False)  # N/m
    column = d.add(
        ph.Beam(
            "column", SECTION, (0.0, 0.0), (LENGTH, 0.0), elements, degree,
            damping=ph.Damping(viscous=viscous), loads=nudge if viscous else (),
        )
    )  # fmt: skip
    guide = d.add(ph.Slider("guide", (1.0, 0.0)))
    d.pin(column.start, d.ground)
    d.connect(column.end.translation, guide.second)
    d.connect(d.ground.translation, guide.first)
    d.expose(column.end.translation, "head", imposes="force")
    return d, column


@dataclass
class Result:
    """What modes and run gave."""

    column: ph.Beam
    solution: ph.Solution
    frequencies: np.ndarray  # first frequency under each of LOADS, rad/s
    theory: np.ndarray  # the same of a slender column, rad/s
    force: np.ndarray  # on the head in the run, of Euler's load
    shortening: np.ndarray  # of the distance of the ends, m
    elastica: float  # the same at the end for an inextensible column, m


def run(dt: float = 0.02) -> Result:
    """Take the frequencies under load; press the column."""
    d, _ = build()
    system = d.compile(effects="all")
    axial = np.array([name.startswith("column.N1") for name in system.state_names])
    frequencies = []
    for load in LOADS * EULER:
        x = np.where(axial, -load, 0.0)  # straight and pressed: a state of rest
        state = ph.State(x, system.start.theta, system.start.points)
        frequencies.append(system.modes(1, state, np.array([-load, 0.0])).frequencies[0])
    omega = np.pi**2 / LENGTH**2 * np.sqrt(BENDING / MASS)

    d, column = build(viscous=60.0)
    solution = ph.simulate(d.compile(), RAMP + HOLD, dt, inputs={"head": lambda t: (press(t), 0.0)})
    head = solution.position(column, 1.0, source="strain")[:, 0]
    return Result(
        column=column,
        solution=solution,
        frequencies=np.array(frequencies),
        theory=omega * np.sqrt(1.0 - LOADS),
        force=np.array([-press(t) / EULER for t in solution.t]),
        shortening=LENGTH - head,
        elastica=elastica(TOP),
    )


def elastica(load: float) -> float:
    """Shortening of an inextensible pinned column, m, under a load above Euler's (in units of it)."""
    m = brentq(lambda m: (2.0 * ellipk(m) / np.pi) ** 2 - load, 1e-9, 0.9)
    return float(2.0 * LENGTH * (1.0 - ellipe(m) / ellipk(m)))


def tabulate(result: Result) -> str:
    """Format the numbers as tables."""
    lines = [f"{'load / Euler':>13}{'omega, rad/s':>15}{'slender, rad/s':>17}"]
    rows = zip(LOADS, result.frequencies, result.theory, strict=True)
    lines += [f"{load:13.2f}{found:15.4f}{known:17.4f}" for load, found, known in list(rows)[::3]]
    lines += [
        "",
        f"Euler's load {EULER:.2f} N; pressed with {TOP:g} times as much the ends approach by "
        f"{result.shortening[-1]:.5f} m, elastica {result.elastica:.5f} m",
        f"{result.solution.statistics}; worst power balance {result.solution.max_power_balance_error:.1e} J; "
        f"{result.solution.status}",
    ]
    return "\n".join(lines)


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figures; return their paths."""
    out.mkdir(parents=True, exist_ok=True)
    line, axes = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="compressed")
    axes[0].plot(LOADS, result.frequencies**2, "o", label="modes of the loaded state")
    axes[0].plot([0.0, 1.0], [result.theory[0] ** 2, 0.0], "k-", lw=0.8, label="Southwell's line")
    axes[0].axhline(result.frequencies[0] ** 2, ls=":", color="grey", label="linear model about rest")
    axes[0].set(xlabel="load / Euler's load", ylabel="omega², rad²/s²", ylim=(0.0, None))
    axes[0].legend(frameon=False, loc="lower left")
    axes[1].plot(1e3 * result.shortening, result.force, label="run")
    loads = np.linspace(1.0 + 1e-6, TOP, 50)
    axes[1].plot([1e3 * elastica(load) for load in loads], loads, "k--", lw=0.8, label="elastica")
    axes[1].set(xlabel="shortening, mm", ylabel="load / Euler's load")
    axes[1].legend(frameon=False, loc="lower right")

    shapes, ax = plt.subplots(figsize=(7.0, 3.6), layout="compressed")
    times = np.interp(np.linspace(0.0, result.shortening[-1], 8)[1:], result.shortening, result.solution.t)
    ph.plots.motion(result.solution, times, path=result.column.end, ax=ax)
    paths = [out / "buckling_shapes.png", out / "buckling_line.png"]
    for figure, path in zip((shapes, line), paths, strict=True):
        figure.savefig(path, dpi=100)
        plt.close(figure)
    return paths


def main(argv: Sequence[str] | None = None) -> Result:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder for the figures")
    options = parser.parse_args(argv)

    result = run()
    print(tabulate(result), "", *draw(result, options.out), sep="\n")
    return result


# %%
# The tables and figures:

if __name__ == "__main__":
    main()
