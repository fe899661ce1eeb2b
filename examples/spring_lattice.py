"""A square lattice of masses and stretched springs in a rigid frame: its frequencies are those of the dispersion.

    python examples/spring_lattice.py [--out figures]

Masses m at distance a, springs of stiffness k under a tension T. A wave that moves the masses along x with wave
numbers p, q has

    omega^2 = 4 / m (k sin^2(p a / 2) + T / a sin^2(q a / 2)),

exactly, and so have standing waves of n + 1 distances between the walls of the frame, p a = i pi / (n + 1). Prints
these next to the modes of the compiled system, and the frequency at which a mode swings in a run.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import phblocks as ph

MASS, STIFFNESS, DISTANCE, TENSION = 0.2, 80.0, 0.5, 6.0  # kg, N/m, m, N


def build(n: int = 4) -> tuple[ph.Diagram, dict[tuple[int, int], ph.Mass]]:
    """Draw the lattice of n times n masses; return it with the masses by column and row."""
    d = ph.Diagram("lattice")
    free = DISTANCE - TENSION / STIFFNESS
    place = {(i, j): DISTANCE * np.array((i, j), dtype=float) for i in range(n + 2) for j in range(n + 2)}
    inside = [node for node in place if min(node) > 0 and max(node) <= n]
    masses = {node: d.add(ph.Mass(f"mass {node[0]} {node[1]}", MASS, place[node])) for node in inside}
    ends = {node: [masses[node].centre] for node in inside}
    for i, j in place:
        for a, b in (((i, j), (i + 1, j)), ((i, j), (i, j + 1))):
            if a in masses or b in masses:
                spring = d.add(ph.Spring(f"spring {a[0]} {a[1]} - {b[0]} {b[1]}", STIFFNESS, place[a], place[b], free))
                for node, anchor in ((a, spring.start), (b, spring.end)):
                    ends.setdefault(node, [d.ground]).append(anchor)
    for anchors in ends.values():
        d.pin(*anchors)
    return d, masses


def dispersion(n: int) -> np.ndarray:
    """Angular frequencies of the standing waves along x, by half waves along x and y: shape (n, n), rad/s."""
    half = np.sin(np.pi * np.arange(1, n + 1) / (2 * (n + 1))) ** 2
    return np.sqrt(4.0 / MASS * (STIFFNESS * half[:, None] + TENSION / DISTANCE * half))


@dataclass
class Result:
    """What the modes and the run gave."""

    masses: dict[tuple[int, int], ph.Mass]
    solution: ph.Solution
    found: np.ndarray  # frequencies of the compiled system, ascending, shape (2 n^2,), rad/s
    exact: np.ndarray  # those of the dispersion, ascending, shape (2 n^2,), rad/s
    swing: float  # frequency of the lowest wave along x in the run, rad/s
    swing_exact: float  # the same from the dispersion, with the known lag of the midpoint rule, rad/s


def run(n: int = 4, dt: float = 0.01, t_end: float = 4.0, amplitude: float = 1e-4) -> Result:
    """Find the modes; run the wave of one half wave in each direction, of small velocity (m/s)."""
    d, masses = build(n)
    system = d.compile()
    along = dispersion(n)
    x = system.start.x.copy()
    for (i, j), mass in masses.items():
        shape = np.sin(np.pi * i / (n + 1)) * np.sin(np.pi * j / (n + 1))
        x[system.state_names.index(f"{mass.name}.vx[0]")] = amplitude * shape
    solution = ph.simulate(system, t_end, dt, start=ph.State(x, system.start.theta, system.start.points))
    v = solution.state(f"{masses[1, 1].name}.vx[0]")
    return Result(
        masses=masses,
        solution=solution,
        found=np.sort(system.modes(2 * n * n).frequencies),
        exact=np.sort(np.concatenate([along.ravel(), along.ravel()])),
        swing=_frequency(solution.t, v),
        swing_exact=float(2.0 / dt * np.arctan(0.5 * dt * along[0, 0])),
    )


def _frequency(t: np.ndarray, v: np.ndarray) -> float:
    """Angular frequency from the first and last zero of a swing."""
    i = np.flatnonzero(v[:-1] * v[1:] < 0.0)
    zeros = t[i] + (t[i + 1] - t[i]) * v[i] / (v[i] - v[i + 1])
    return float(np.pi * (zeros.size - 1) / (zeros[-1] - zeros[0]))


def tabulate(result: Result) -> str:
    """Format the numbers as a table."""
    lines = [f"{'mode':>6}{'found, rad/s':>16}{'dispersion, rad/s':>20}{'difference':>14}"]
    for i in range(0, result.found.size, 2):
        found, exact = result.found[i], result.exact[i]
        lines.append(f"{i + 1:6d}{found:16.9f}{exact:20.9f}{found - exact:14.1e}")
    lines += [
        "(every one twice: along x and along y)",
        "",
        f"run of the lowest wave: {result.swing:.6f} rad/s, "
        f"dispersion and midpoint rule {result.swing_exact:.6f} rad/s",
        f"long waves along x travel at a sqrt(k/m) = {DISTANCE * np.sqrt(STIFFNESS / MASS):.4f} m/s, "
        f"along y at sqrt(T a / m) = {np.sqrt(TENSION * DISTANCE / MASS):.4f} m/s",
        f"{result.solution.statistics}; energy within {np.ptp(result.solution.energy.total):.1e} J; "
        f"{result.solution.status}",
    ]
    return "\n".join(lines)


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figure; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    figure, ax = plt.subplots(figsize=(6.0, 4.0), layout="compressed")
    ax.plot(result.exact, "o", fillstyle="none", label="dispersion")
    ax.plot(result.found, "x", label="modes of the system")
    ax.set(xlabel="mode", ylabel="omega, rad/s")
    ax.legend()
    path = out / "spring_lattice.png"
    figure.savefig(path, dpi=100)
    plt.close(figure)
    return [path]


def main(argv: Sequence[str] | None = None) -> Result:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder for the figures")
    options = parser.parse_args(argv)

    result = run()
    print(tabulate(result), "", *draw(result, options.out), sep="\n")
    return result


if __name__ == "__main__":
    main()
