"""A wave that does not come back
================================

A pulse travels along a bar into a damper: tuned to the impedance of the bar, it swallows all of it.

::

    python examples/wave_absorber.py [--out figures]

A hammer hits one end of a long steel bar. At the other end stands a damper c against the ground. Of a wave of velocity
the fraction r = (Z - c) / (Z + c) comes back, Z = sqrt(EA rho A): all of it from a free end (c = 0), its negative from
a wall, nothing if c = Z. This is a boundary control by interconnection: the controller is a block like any other, and
the ledger tells how much energy it took, 1 - r^2 of that of the pulse.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import phblocks as ph

LENGTH, PULSE, FORCE = 4.0, 2.5e-4, 1000.0  # m, s, N
SECTION = ph.Section.rectangle(
    width=0.01, height=0.01, young=2.1e11, poisson=0.3, density=7850.0, shear_factor=5.0 / 6.0
)
IMPEDANCE = np.sqrt(SECTION.axial * SECTION.mass)  # N s/m
SPEED = np.sqrt(SECTION.axial / SECTION.mass)  # m/s
DAMPERS = {"free end": 0.0, "a third of Z": IMPEDANCE / 3.0, "Z": IMPEDANCE, "three times Z": 3.0 * IMPEDANCE}
SMALL = ph.Approximation(large_rotation=False)  # nothing turns here, and a linear system keeps one factor
PLACES = np.linspace(0.0, 1.0, 81)  # along the bar


def hammer(t: float) -> float:
    """Force of the blow, N: a smooth pulse."""
    return FORCE * np.sin(np.pi * t / PULSE) ** 2 if t < PULSE else 0.0


def build(damping: float, elements: int = 32, degree: int = 3) -> tuple[ph.Diagram, ph.Beam]:
    """Draw the bar, hit at its start, with a damper of N s/m at its end; return it with the beam."""
    d = ph.Diagram("bar")
    bar = d.add(ph.Beam("bar", SECTION, (0.0, 0.0), (LENGTH, 0.0), elements=elements, degree=degree))
    d.connect(d.add(ph.Force("hammer", lambda t: (hammer(t), 0.0))).port, bar.start.translation)
    if damping:
        absorber = d.add(ph.Damper("absorber", damping, (LENGTH, 0.0), (LENGTH + 0.5, 0.0)))
        d.pin(bar.end, absorber.start)
        d.pin(absorber.end, d.ground)
    return d, bar


@dataclass
class Run:
    """What came back from one end."""

    solution: ph.Solution
    field: np.ndarray  # axial velocity, shape (times, places), m/s
    reflected: float  # peak of the wave on its way back, of the one on its way there
    expected: float  # (Z - c) / (Z + c)
    absorbed: float  # energy in the damper, of the work of the hammer


def run(dt: float = 4e-6) -> dict[str, Run]:
    """Simulate until the reflected wave has passed the middle of the bar."""
    runs = {}
    for name, damping in DAMPERS.items():
        d, bar = build(damping)
        solution = ph.simulate(d.compile(approximation=SMALL), 1.6 * LENGTH / SPEED + PULSE, dt, save_every=2)
        field = np.stack([solution.velocity(bar, s)[:, 0] for s in PLACES], axis=1)
        middle, back = field[:, PLACES.size // 2], solution.t > LENGTH / SPEED + 0.5 * PULSE
        peaks = [part[np.abs(part).argmax()] for part in (middle[~back], middle[back])]
        runs[name] = Run(
            solution=solution,
            field=field,
            reflected=peaks[1] / peaks[0],
            expected=(IMPEDANCE - damping) / (IMPEDANCE + damping),
            absorbed=solution.energy.dissipated[-1] / solution.energy.supplied[-1],
        )
    return runs


def tabulate(runs: dict[str, Run]) -> str:
    """Format the numbers as a table."""
    lines = [f"{'damper':<16}{'reflected':>11}{'(Z-c)/(Z+c)':>14}{'absorbed':>11}{'1 - r^2':>10}{'balance, J':>13}"]
    for name, found in runs.items():
        lines.append(
            f"{name:<16}{found.reflected:11.4f}{found.expected:14.4f}{found.absorbed:11.4f}"
            f"{1.0 - found.expected**2:10.4f}{found.solution.max_power_balance_error:13.1e}"
        )
    solution = next(iter(runs.values())).solution
    lines += [
        "",
        f"Z = {IMPEDANCE:.2f} N s/m, waves at {SPEED:.0f} m/s; {solution.statistics}",
    ]
    return "\n".join(lines)


def draw(runs: dict[str, Run], out: Path) -> list[Path]:
    """Write the figure: place along the bar against time; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    figure, axes = plt.subplots(1, len(runs), figsize=(10.0, 3.8), sharey=True, layout="compressed")
    top = max(np.abs(found.field[:, PLACES.size // 2]).max() for found in runs.values())
    for ax, (name, found) in zip(axes, runs.items(), strict=True):
        image = ax.pcolormesh(
            LENGTH * PLACES, 1e3 * found.solution.t, found.field, cmap="RdBu_r", vmin=-top, vmax=top, rasterized=True
        )
        ax.set(title=f"{name}, r = {found.reflected:.2f}", xlabel="place, m")
    axes[0].set_ylabel("time, ms")
    figure.colorbar(image, ax=axes, label="velocity, m/s", pad=0.01)
    path = out / "wave_absorber.png"
    figure.savefig(path, dpi=100)
    plt.close(figure)
    return [path]


def main(argv: Sequence[str] | None = None) -> dict[str, Run]:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder for the figures")
    options = parser.parse_args(argv)

    runs = run()
    print(tabulate(runs), "", *draw(runs, options.out), sep="\n")
    return runs


# %%
# The table and the figure:

if __name__ == "__main__":
    main()
