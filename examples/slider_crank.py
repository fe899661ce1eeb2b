"""A slider-crank with a flexible connecting rod: how far the rod bows under its own inertia.

    python examples/slider_crank.py [--out figures]

A stiff crank is turned by a prescribed speed, a rod of steel drives a piston that slides along x. Prints the piston
next to the kinematics of rigid parts, and the deflection of the middle of the rod next to that of a beam on two
supports under the inertia of the rigid motion, 5 q l^4 / (384 EI): the load is linear along the rod and the part that
is odd about the middle does not bend the middle.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

import phblocks as ph

CRANK, ROD, PISTON, SPEED, RAMP = 0.15, 0.45, 0.1, 40.0, 0.3  # m, m, kg, rad/s, s
STEEL = {"young": 2.1e11, "poisson": 0.3, "density": 7850.0, "shear_factor": 5.0 / 6.0}
ROD_SECTION = ph.Section.rectangle(width=0.008, height=0.008, **STEEL)
CRANK_SECTION = ph.Section.rectangle(width=0.04, height=0.04, **STEEL)


def speed(t: ArrayLike) -> np.ndarray:
    """Angular velocity of the crank, rad/s: from rest to constant with three smooth derivatives."""
    s = np.clip(np.asarray(t, dtype=float) / RAMP, 0.0, 1.0)
    return np.asarray(SPEED * s**4 * (35.0 - 84.0 * s + 70.0 * s**2 - 20.0 * s**3))


def build(elements: int = 3, degree: int = 3) -> tuple[ph.Diagram, ph.Beam, ph.Beam, ph.Mass]:
    """Draw the diagram; return it with crank, rod and piston."""
    d = ph.Diagram("slider-crank")
    crank = d.add(ph.Beam("crank", CRANK_SECTION, (0.0, 0.0), (CRANK, 0.0), elements=2, degree=2))
    rod = d.add(ph.Beam("rod", ROD_SECTION, (CRANK, 0.0), (CRANK + ROD, 0.0), elements=elements, degree=degree))
    piston = d.add(ph.Mass("piston", PISTON, (CRANK + ROD, 0.0)))
    guide, drive = d.add(ph.Slider("guide", (1.0, 0.0))), d.add(ph.AngularVelocity("drive", speed))
    d.pin(d.ground, crank.start)
    d.connect(drive.port, crank.start.rotation)
    d.pin(crank.end, rod.start)
    d.connect(rod.end.translation, piston.centre.translation, guide.second)
    d.connect(d.ground.translation, guide.first)
    return d, crank, rod, piston


@dataclass
class Result:
    """What the run gave."""

    rod: ph.Beam
    solution: ph.Solution
    angle: np.ndarray  # of the crank, rad
    piston: np.ndarray  # x of the piston, m
    piston_rigid: np.ndarray  # the same for rigid parts, m
    bow: np.ndarray  # deflection of the middle of the rod from its chord, m
    bow_static: np.ndarray  # the same of a beam under the inertia of the rigid motion, m
    energy_error: float  # supplied less stored and dissipated at the end, J
    guide: float  # largest y of the piston, m


def run(dt: float = 0.0005, t_end: float = 0.7) -> Result:
    """Simulate and compare with rigid parts and with a beam on two supports."""
    d, crank, rod, piston = build()
    solution = ph.simulate(d.compile(), t_end=t_end, dt=dt)
    angle = solution.angle(crank.start)
    start, middle, end = (solution.position(rod, s, source="strain") for s in (0.0, 0.5, 1.0))
    chord = end - start
    across = np.stack([-chord[:, 1], chord[:, 0]], axis=1) / np.linalg.norm(chord, axis=1)[:, None]
    x, bow = rigid(solution.t, angle)
    place = solution.position(piston.centre)
    energy = solution.energy
    return Result(
        rod=rod,
        solution=solution,
        angle=angle,
        piston=place[:, 0],
        piston_rigid=x,
        bow=np.einsum("ti,ti->t", middle - 0.5 * (start + end), across),
        bow_static=bow,
        energy_error=float(abs(energy.supplied[-1] - energy.total[-1] - energy.dissipated[-1])),
        guide=float(np.abs(place[:, 1]).max()),
    )


def rigid(t: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place of the piston, m, and deflection of the rod, m, for rigid parts at these angles of the crank."""
    w, alpha = speed(t), np.gradient(speed(t), t)
    sine, cosine = CRANK / ROD * np.sin(angle), np.sqrt(1.0 - (CRANK / ROD * np.sin(angle)) ** 2)
    turn = -CRANK / ROD * w * np.cos(angle) / cosine  # angular velocity of the rod, whose angle has the sine -sine
    turned = (-CRANK / ROD * (alpha * np.cos(angle) - w**2 * np.sin(angle)) - turn**2 * sine) / cosine
    # acceleration of the middle, across the rod: that of the crank pin, and that of the middle about it
    pin = CRANK * np.stack(
        [-alpha * np.sin(angle) - w**2 * np.cos(angle), alpha * np.cos(angle) - w**2 * np.sin(angle)]
    )
    across = sine * pin[0] + cosine * pin[1] + 0.5 * ROD * turned
    load = -ROD_SECTION.mass * across
    bending, shear = (float(np.atleast_1d(pair)[0]) for pair in (ROD_SECTION.bending, ROD_SECTION.shear))  # square
    bow = load * (5.0 * ROD**4 / (384.0 * bending) + ROD**2 / (8.0 * shear))
    return CRANK * np.cos(angle) + ROD * cosine, bow


def tabulate(result: Result) -> str:
    """Format the numbers as a table."""
    t = result.solution.t
    lines = [f"{'t, s':>8}{'crank, rad':>12}{'piston, m':>12}{'rigid, m':>12}{'bow, mm':>12}{'static, mm':>12}"]
    for i in np.linspace(0, t.size - 1, 15).astype(int)[1:]:
        lines.append(
            f"{t[i]:8.3f}{result.angle[i]:12.4f}{result.piston[i]:12.6f}{result.piston_rigid[i]:12.6f}"
            f"{1e3 * result.bow[i]:12.4f}{1e3 * result.bow_static[i]:12.4f}"
        )
    lines += [
        "",
        f"largest bow {1e3 * np.abs(result.bow).max():.4f} mm, static {1e3 * np.abs(result.bow_static).max():.4f} mm, "
        f"they differ by at most {1e3 * np.abs(result.bow - result.bow_static).max():.4f} mm",
        f"piston within {np.abs(result.piston - result.piston_rigid).max():.1e} m of the rigid one, and within "
        f"{result.guide:.1e} m of its guide",
        f"{result.solution.statistics}; energy at the end off by {result.energy_error:.1e} J; {result.solution.status}",
    ]
    return "\n".join(lines)


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figure; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    figure, ax = plt.subplots(figsize=(7.0, 3.6), layout="compressed")
    ax.plot(result.solution.t, 1e3 * result.bow, label="flexible rod")
    ax.plot(result.solution.t, 1e3 * result.bow_static, "--", label="beam under the inertia of the rigid motion")
    ax.set(xlabel="t, s", ylabel="middle of the rod from its chord, mm")
    ax.legend()
    path = out / "slider_crank.png"
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
