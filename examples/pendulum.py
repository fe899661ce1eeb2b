"""Two pendulums released from horizontal: one of rubber, one so stiff that it is a rigid bar.

    python examples/pendulum.py [--out figures]

One end is pinned, which takes velocity, the other free, which takes force: the beam switches in between. Prints the
tip of the rubber pendulum, by both ways to a position, and swing and period of the rigid one, next to references.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import phblocks as ph

#: Tip of the rubber pendulum after 1 s, m, good to 5e-5 m.
RUBBER_TIP = np.array((-0.91421, 0.10037))
#: Rigid uniform bar of 1 m: angle after 1 s from hanging down, rad, and period, s (exact).
RIGID_ANGLE, RIGID_PERIOD = -1.56262171803447, 1.93333485437325

RUBBER = ph.Section.circle(radius=0.01, young=5e6, poisson=0.5, density=1000.0, shear_factor=27.0 / 28.0)
#: A bar without rotary inertia to speak of, a thousand times stiffer than its weight asks for.
RIGID = ph.Section(axial=1e10, shear=1e10, bending=1e7, mass=1.0, rotary=1e-9)


def build(section: ph.Section, elements: int, degree: int) -> tuple[ph.Diagram, ph.Beam]:
    """Draw the diagram of a pendulum of 1 m; return it with its beam."""
    d = ph.Diagram("pendulum", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("beam", section, start=(0.0, 0.0), end=(1.0, 0.0), elements=elements, degree=degree))
    d.pin(beam.start, d.ground)
    return d, beam


@dataclass
class Result:
    """What the two runs gave."""

    beam: ph.Beam  # of the rubber pendulum
    rubber: ph.Solution
    rigid_beam: ph.Beam
    rigid: ph.Solution
    tips: dict[str, np.ndarray]  # source -> tip of the rubber pendulum after 1 s, shape (2,), m
    angle: float  # of the rigid pendulum after 1 s, from hanging down, rad
    period: float  # of the rigid pendulum, s


def run(dt: float = 0.001) -> Result:
    """Simulate both; return the solutions and the numbers drawn from them."""
    d, beam = build(RUBBER, elements=8, degree=3)
    rubber = ph.simulate(d.compile(), t_end=1.0, dt=dt)
    # degree 2: of degree 1 the velocity of the pinned half is constant in each element, too coarse for a rotation
    d, rigid_beam = build(RIGID, elements=2, degree=2)
    rigid = ph.simulate(d.compile(), t_end=2.0, dt=dt)
    return Result(
        beam=beam,
        rubber=rubber,
        rigid_beam=rigid_beam,
        rigid=rigid,
        tips={source: rubber.position(beam.end, source=source)[-1] for source in ("velocity", "strain")},
        angle=np.interp(1.0, rigid.t, rigid.angle(rigid_beam, 0.5)) + 0.5 * np.pi,
        period=_period(rigid.t, rigid.spin(rigid_beam, 0.5)),
    )


def _period(t: np.ndarray, spin: np.ndarray) -> float:
    """When it comes to rest for the second time, back at the start."""
    i = np.flatnonzero((spin[:-1] > 0.0) & (spin[1:] <= 0.0))[0]
    return float(t[i] + (t[i + 1] - t[i]) * spin[i] / (spin[i] - spin[i + 1]))


def tabulate(result: Result) -> str:
    """Format the numbers as a table."""
    rows = [
        (f"rubber: {axis} of the tip after 1 s, from {source}", "m", tip[i], RUBBER_TIP[i])
        for source, tip in result.tips.items()
        for i, axis in enumerate("xy")
    ]
    rows.append(("rigid: angle after 1 s, from hanging down", "rad", result.angle, RIGID_ANGLE))
    rows.append(("rigid: period", "s", result.period, RIGID_PERIOD))
    lines = [f"{'':<48}{'unit':<6}{'value':>12}{'reference':>12}{'difference':>12}"]
    lines += [f"{what:<48}{unit:<6}{a:12.6f}{b:12.6f}{a - b:12.1e}" for what, unit, a, b in rows]
    lines.append("")
    for name, solution in (("rubber", result.rubber), ("rigid", result.rigid)):
        error = solution.max_power_balance_error
        lines.append(f"{name:<8}{solution.statistics}; worst power balance {error:.1e} J; {solution.status}")
    return "\n".join(lines)


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figures; return their paths."""
    out.mkdir(parents=True, exist_ok=True)
    motion, axes = plt.subplots(2, 1, figsize=(7.0, 7.4), layout="compressed")
    times = np.linspace(0.0, 1.0, 9)[1:]
    ph.plots.motion(result.rubber, times, path=result.beam.end, ax=axes[0]).set_title("rubber")
    ph.plots.motion(result.rigid, times, path=result.rigid_beam.end, ax=axes[1]).set_title("rigid")

    energy, ax = plt.subplots(figsize=(7.0, 3.6), layout="constrained")
    ph.plots.energy(result.rubber, ax=ax)

    paths = [out / "pendulum.png", out / "pendulum_energy.png"]
    for figure, path in zip((motion, energy), paths, strict=True):
        figure.savefig(path, dpi=100)
        plt.close(figure)
    return paths


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
