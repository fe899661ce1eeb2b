"""A direct-current motor turns a flexible arm through a gear: what the arm does to the current.

    python examples/dc_motor_arm.py [--out figures]

A step of voltage drives the winding; the shaft turns the root of the arm through a gear of 20 : 1, and the arm lags
behind and swings. Prints speed, current and where the energy went, next to the motor with a rigid arm.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import phblocks as ph

VOLTAGE, RESISTANCE, INDUCTANCE, CONSTANT, RATIO = 12.0, 1.2, 2e-3, 0.05, 20.0
LENGTH = 0.6
ARM = ph.Section.rectangle(width=0.03, height=0.003, young=7e10, poisson=0.33, density=2700.0, shear_factor=5.0 / 6.0)


def build(elements: int = 4, degree: int = 2) -> tuple[ph.Diagram, ph.Beam]:
    """Draw the diagram; return it with the arm."""
    d = ph.Diagram("motor and arm")
    source, earth = d.add(ph.Voltage("source", VOLTAGE)), d.add(ph.Reference("earth"))
    motor = d.add(ph.DCMotor("motor", RESISTANCE, CONSTANT, INDUCTANCE))
    gear = d.add(ph.Transformer("gear", 1.0 / RATIO))  # the arm turns 20 times slower than the shaft
    arm = d.add(ph.Beam("arm", ARM, start=(0.0, 0.0), end=(LENGTH, 0.0), elements=elements, degree=degree))
    d.connect(source.port, motor.p)
    d.connect(motor.n, earth.port)
    d.connect(motor.stator, d.ground.rotation)
    d.connect(motor.shaft, gear.first)
    d.connect(gear.second, arm.start.rotation)
    d.pin(arm.start, d.ground)
    return d, arm


@dataclass
class Result:
    """What the run gave."""

    arm: ph.Beam
    solution: ph.Solution
    current: np.ndarray  # A
    speed: np.ndarray  # of the root, rad/s
    rigid: np.ndarray  # speed with a rigid arm, exact, rad/s
    lag: float  # largest angle of the tip behind the root, rad
    energy_error: float  # supplied less stored and dissipated at the end, J


def run(dt: float = 0.0005, t_end: float = 0.5) -> Result:
    """Simulate and compare with the motor that turns a rigid arm."""
    d, arm = build()
    solution = ph.simulate(d.compile(), t_end=t_end, dt=dt)
    energy = solution.energy
    return Result(
        arm=arm,
        solution=solution,
        current=solution.state("motor.current[0]"),
        speed=np.gradient(solution.angle(arm.start), solution.t),
        rigid=rigid_speed(solution.t),
        lag=float((solution.angle(arm.start) - solution.angle(arm.end)).max()),
        energy_error=float(abs(energy.supplied[-1] - energy.total[-1] - energy.dissipated[-1])),
    )


def rigid_speed(t: np.ndarray) -> np.ndarray:
    """Speed of a rigid arm of the same inertia: two first-order equations, solved exactly."""
    inertia = ARM.mass * LENGTH**3 / 3.0 + float(np.atleast_1d(ARM.rotary)[-1]) * LENGTH
    k = CONSTANT * RATIO
    A = np.array([[-RESISTANCE / INDUCTANCE, -k / INDUCTANCE], [k / inertia, 0.0]])
    values, vectors = np.linalg.eig(A)
    end = -np.linalg.solve(A, [VOLTAGE / INDUCTANCE, 0.0])
    return np.asarray((end[:, None] - (vectors * np.linalg.solve(vectors, end)) @ np.exp(np.outer(values, t)))[1].real)


def tabulate(result: Result) -> str:
    """Format the numbers as a table."""
    t, final = result.solution.t, VOLTAGE / (CONSTANT * RATIO)
    energy, blocks = result.solution.energy, result.solution.power.blocks
    lines = [f"{'t, s':>8}{'current, A':>14}{'root, rad/s':>14}{'rigid, rad/s':>14}"]
    for i in np.linspace(0, t.size - 1, 6).astype(int)[1:]:
        lines.append(f"{t[i]:8.2f}{result.current[i]:14.4f}{result.speed[i]:14.4f}{result.rigid[i]:14.4f}")
    lines += [
        "",
        f"speed without load {final:.4f} rad/s; largest lag of the tip {np.degrees(result.lag):.2f} degrees",
        f"supplied {energy.supplied[-1]:.6f} J, of it heat in the winding {blocks['motor']['dissipated'][-1]:.6f} J, "
        f"kinetic {energy.kinetic[-1]:.6f} J, strain {energy.strain[-1]:.6f} J, magnetic {energy.magnetic[-1]:.6f} J",
        f"{result.solution.statistics}; energy at the end off by {result.energy_error:.1e} J; {result.solution.status}",
    ]
    return "\n".join(lines)


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figure; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    figure, axes = plt.subplots(2, 1, sharex=True, figsize=(7.0, 5.0), layout="compressed")
    t = result.solution.t
    axes[0].plot(t, result.current)
    axes[0].set_ylabel("current, A")
    axes[1].plot(t, result.speed, label="root of the flexible arm")
    axes[1].plot(t, result.rigid, "--", label="rigid arm")
    axes[1].set(xlabel="t, s", ylabel="speed, rad/s")
    axes[1].legend()
    path = out / "dc_motor_arm.png"
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
