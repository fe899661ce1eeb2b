"""A chain that falls faster than a stone
=======================================

A chain hangs by both ends, side by side. One end is let go: it overtakes a stone dropped at the same time.

::

    python examples/falling_chain.py [--out figures]

What falls becomes shorter and its energy has nowhere else to go: with l the length of the chain, the end that has
fallen by x has v^2 = g x (2 l - x) / (l - x) (Calkin, March, Am. J. Phys. 57 (1989) 154-157, doi:10.1119/1.16110), more
than the 2 g x of a stone. Here the chain has 25 stiff links with pins between them: 25 beams, no multiplier. In the end
it cracks like a whip. Prints the speed next to theory.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

import phblocks as ph

GRAVITY, LINKS, LINK = 9.81, 12, 1.0 / 12.0  # m/s^2, number on each side, m
LENGTH = (2 * LINKS + 1) * LINK  # m
SECTION = ph.Section(axial=1e5, shear=1e5, bending=100.0, mass=0.5, rotary=1e-9)


def build() -> tuple[ph.Diagram, list[ph.Beam]]:
    """Draw the chain: down on the left, one link across, up on the right; return it with the links."""
    d = ph.Diagram("chain", gravity=(0.0, -GRAVITY))
    down = [(0.0, -LINK * i) for i in range(LINKS + 1)]
    places = down + [(LINK, y) for _, y in down[::-1]]
    links = [
        d.add(ph.Beam(f"link {i}", SECTION, a, b, elements=2, degree=2)) for i, (a, b) in enumerate(pairwise(places))
    ]
    d.pin(d.ground, links[0].start)
    for a, b in pairwise(links):
        d.pin(a.end, b.start)
    return d, links


def theory(fallen: ArrayLike) -> np.ndarray:
    """Speed of the end, m/s, where it has fallen so far, m."""
    x = np.asarray(fallen)
    return np.asarray(np.sqrt(GRAVITY * x * (2.0 * LENGTH - x) / (LENGTH - x)))


@dataclass
class Result:
    """What the run gave."""

    links: list[ph.Beam]
    solution: ph.Solution
    fallen: np.ndarray  # of the free end, m
    speed: np.ndarray  # downwards, m/s
    energy_drift: float  # J


def run(dt: float = 0.0005, t_end: float = 0.6) -> Result:
    """Let go."""
    d, links = build()
    solution = ph.simulate(d.compile(), t_end, dt, save_every=2)
    free = links[-1].end
    return Result(
        links=links,
        solution=solution,
        fallen=-solution.position(free)[:, 1],
        speed=-solution.velocity(free)[:, 1],
        energy_drift=float(np.ptp(solution.energy.total)),
    )


def tabulate(result: Result) -> str:
    """Format the numbers as a table."""
    lines = [f"{'t, s':>6}{'fallen, m':>11}{'a stone, m':>12}{'speed, m/s':>12}{'theory, m/s':>13}"]
    for i in range(0, result.solution.t.size, 60):
        t, x = result.solution.t[i], max(result.fallen[i], 0.0)
        known = f"{theory(x):.4f}" if x < LENGTH else ""
        lines.append(f"{t:6.2f}{x:11.4f}{0.5 * GRAVITY * t**2:12.4f}{result.speed[i]:12.4f}{known:>13}")
    lines += [
        "",
        f"largest speed {result.speed.max():.1f} m/s",
        f"energy within {result.energy_drift:.1e} J; {result.solution.statistics}; {result.solution.status}",
    ]
    return "\n".join(lines)


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figure; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    figure, (ax, speed) = plt.subplots(1, 2, figsize=(9.0, 4.0), layout="compressed", width_ratios=(1.6, 1.0))
    t = result.solution.t
    joints = [result.solution.position(link, s) for link in result.links for s in (0.0, 0.5, 1.0)]
    shapes = np.stack(joints, axis=1)
    times = np.linspace(0.0, t[-1], 13)
    for k, time in enumerate(times):
        i = np.abs(t - time).argmin()
        shift = 0.28 * k  # side by side
        ax.plot(shapes[i, :, 0] + shift, shapes[i, :, 1], color=plt.cm.viridis(k / times.size), lw=1.8)
        ax.plot(shapes[i, 0, 0] + shift, shapes[i, 0, 1], "k^", ms=5)
        ax.plot(LINK + shift, -0.5 * GRAVITY * t[i] ** 2, "o", color="tab:red", ms=4, label=None if k else "a stone")
    ax.set(xlabel="one picture every 0.05 s", ylabel="y, m", aspect="equal", xticks=[])
    ax.legend(frameon=False, loc="lower left")
    ax.set_ylim(-2.15, 0.1)
    below = np.linspace(0.0, 0.95 * LENGTH, 200)
    down = slice(result.fallen.argmax())
    speed.plot(result.fallen[down], result.speed[down], label="end of the chain")
    speed.plot(below, theory(below), "k--", lw=0.8, label="theory")
    speed.plot(below, np.sqrt(2.0 * GRAVITY * below), ":", color="tab:red", label="a stone")
    speed.set(xlabel="fallen, m", ylabel="speed, m/s", xlim=(0.0, LENGTH), ylim=(0.0, 20.0))
    speed.legend(frameon=False, loc="upper left")
    path = out / "falling_chain.png"
    figure.savefig(path, dpi=100)
    plt.close(figure)
    return [path]


def main(argv: Sequence[str] | None = None) -> Result:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder for the figures")
    options = parser.parse_args(argv)

    result = run()
    print(tabulate(result), "", *draw(result, options.out), sep="\n")
    return result


# %%
# The table and the figure:

if __name__ == "__main__":
    main()
