"""Two uniform bars hang from each other: as rigid bodies held by multipliers, and as stiff beams that need none.

    python examples/double_pendulum.py [--out figures]

Two rigid bodies pinned to each other both have a velocity of their own, so the joint asks for a multiplier; a beam may
take velocity at one end and give it at the other, and the same mechanism has no constraints at all. Prints the angles
after 1 s at three steps next to a reference.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import phblocks as ph

GRAVITY = (0.0, -9.81)  # m/s^2
PLACES = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, -1.0)])  # the first bar horizontal, the second hanging, at rest
STEPS = (0.005, 0.0025, 0.00125)  # s
#: Angles of the two bars from hanging down after 1 s, rad (equations of the two angles, good to all digits).
REFERENCE = np.array((-0.5202776458589, -1.9043987624111))
#: A bar of 1 kg/m without rotary inertia to speak of, a thousand times stiffer than its weight asks for.
STIFF = ph.Section(axial=1e8, shear=1e8, bending=1e6, mass=1.0, rotary=1e-9)


def build_rigid() -> tuple[ph.Diagram, list[ph.RigidBody]]:
    """Draw the pendulum of rigid bodies; return it with its bars."""
    d = ph.Diagram("rigid double pendulum", gravity=GRAVITY)
    bars = []
    for name, a, b in zip(("upper", "lower"), PLACES, PLACES[1:], strict=False):
        angle = np.arctan2(*(b - a)[::-1])
        bars.append(d.add(ph.RigidBody(name, 1.0, 1.0 / 12.0, (a + b) / 2.0, {"top": a, "end": b}, angle=angle)))
    d.pin(d.ground, bars[0]["top"], multiplier=True)
    d.pin(bars[0]["end"], bars[1]["top"], multiplier=True)
    return d, bars


def build_flexible(elements: int = 2, degree: int = 2) -> tuple[ph.Diagram, list[ph.Beam]]:
    """Draw the pendulum of beams; return it with its bars."""
    d = ph.Diagram("flexible double pendulum", gravity=GRAVITY)
    upper, lower = (
        d.add(ph.Beam(name, STIFF, a, b, elements=elements, degree=degree))
        for name, a, b in zip(("upper", "lower"), PLACES, PLACES[1:], strict=False)
    )
    d.pin(d.ground, upper.start)
    d.pin(upper.end, lower.start)
    return d, [upper, lower]


@dataclass
class Result:
    """What the runs gave."""

    rigid: dict[float, ph.Solution]  # step, s -> solution
    flexible: dict[float, ph.Solution]  # step, s -> solution
    rigid_errors: np.ndarray  # of both angles after 1 s, shape (steps, 2), rad
    flexible_errors: np.ndarray  # the same of the beams
    constraints: tuple[str, ...]  # names of the constraints of the rigid one
    bars: list[ph.Beam]  # of the flexible one


def run(steps: Sequence[float] = STEPS) -> Result:
    """Simulate both at each step; return the solutions and the numbers drawn from them."""
    d, bodies = build_rigid()
    system = d.compile()
    rigid = {dt: ph.simulate(system, t_end=1.0, dt=dt) for dt in steps}
    d, beams = build_flexible()
    flexible = {dt: ph.simulate(d.compile(), t_end=1.0, dt=dt) for dt in steps}
    down = 0.5 * np.pi
    return Result(
        rigid=rigid,
        flexible=flexible,
        rigid_errors=np.array([[s.angle(b.centre)[-1] + down for b in bodies] for s in rigid.values()]) - REFERENCE,
        flexible_errors=np.array([[s.angle(b, 0.5)[-1] + down for b in beams] for s in flexible.values()]) - REFERENCE,
        constraints=system.constraint_names,
        bars=beams,
    )


def tabulate(result: Result) -> str:
    """Format the numbers as a table."""
    lines = [f"{'bars':<10}{'dt, s':>10}{'upper, rad':>14}{'lower, rad':>14}{'errors, rad':>22}{'energy, J':>12}"]
    runs = (("rigid", result.rigid, result.rigid_errors), ("flexible", result.flexible, result.flexible_errors))
    for name, solutions, errors in runs:
        for (dt, solution), (upper, lower) in zip(solutions.items(), errors, strict=True):
            lines.append(
                f"{name:<10}{dt:10.5f}{REFERENCE[0] + upper:14.6f}{REFERENCE[1] + lower:14.6f}"
                f"{upper:11.1e}{lower:11.1e}{np.ptp(solution.energy.total):12.1e}"
            )
    lines += ["", f"constraints of the rigid one: {', '.join(result.constraints)}; of the flexible one: none"]
    return "\n".join(lines)


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figure; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    solution = result.flexible[min(result.flexible)]
    figure, ax = plt.subplots(figsize=(6.0, 5.0), layout="compressed")
    ph.plots.motion(solution, np.linspace(0.0, 1.0, 7)[1:], path=result.bars[1].end, ax=ax)
    path = out / "double_pendulum.png"
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
