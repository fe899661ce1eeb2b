"""Flying spaghetti
===================

A free beam is thrown by a force and a moment at its lower end, both of which stop after 2.5 s.

::

    python examples/flying_spaghetti.py [--out figures]

A case known to break codes: the beam leaves in large rotations and bends into loops, with nothing to hold it. Prints
both ends next to those of another code, and what is conserved: the energy after the push to round-off, the momentum to
the order of the method.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import Normalize

import phblocks as ph

SECTION = ph.Section(axial=1e4, shear=1e4, bending=100.0, mass=1.0, rotary=10.0)
START, END = (0.0, 8.0), (6.0, 0.0)  # m
FORCE, MOMENT, OFF = 8.0, -80.0, 2.5  # N along x and N m at the lower end, until (s)
#: Time (s) -> lower and upper end (m), from another code with beams of another kind, good to 2e-3 m.
REFERENCE = {
    2.5: np.array([(4.9631, 4.4760), (3.5832, 6.1119)]),
    6.0: np.array([(11.9946, 5.8397), (12.7912, 5.6351)]),
}


def build(elements: int = 16, degree: int = 3) -> tuple[ph.Diagram, ph.Beam]:
    """Draw the diagram: one beam, nothing joined to it; return it with the beam."""
    d = ph.Diagram("flying spaghetti")
    beam = d.add(ph.Beam("beam", SECTION, START, END, elements=elements, degree=degree))
    d.expose(beam.end.translation, "force")
    d.expose(beam.end.rotation, "moment")
    return d, beam


@dataclass
class Result:
    """What the run gave."""

    beam: ph.Beam
    solution: ph.Solution
    ends: dict[float, np.ndarray]  # time, s -> lower and upper end, shape (2, 2), m
    energy_drift: float  # largest change of the energy after the push, J
    momentum: np.ndarray  # after the push, shape (times, 2), N s


def run(dt: float = 0.01, t_end: float = 6.0) -> Result:
    """Simulate; the loads change between two steps."""
    d, beam = build()

    def force(t: float) -> tuple[float, float]:
        return (FORCE, 0.0) if t < OFF else (0.0, 0.0)

    def moment(t: float) -> float:
        return MOMENT if t < OFF else 0.0

    solution = ph.simulate(d.compile(), t_end, dt, inputs={"force": force, "moment": moment})
    after = solution.t >= OFF - 1e-9
    mass = solution.system.point_mass
    impulse = np.einsum("m,tmd->td", mass, solution.recording.points)
    paths = [solution.position(beam, s, source="strain") for s in (1.0, 0.0)]
    return Result(
        beam=beam,
        solution=solution,
        ends={t: np.array([path[np.abs(solution.t - t).argmin()] for path in paths]) for t in REFERENCE},
        energy_drift=float(np.ptp(solution.energy.total[after])),
        momentum=np.diff(impulse[after], axis=0) / np.diff(solution.t[after])[:, None],
    )


def tabulate(result: Result) -> str:
    """Format the numbers as a table."""
    lines = [f"{'t, s':>6}{'end':>8}{'x, m':>12}{'y, m':>12}{'from the other code, m':>26}"]
    for t, ends in result.ends.items():
        for name, end, known in zip(("lower", "upper"), ends, REFERENCE[t], strict=True):
            lines.append(f"{t:6.1f}{name:>8}{end[0]:12.4f}{end[1]:12.4f}{np.abs(end - known).max():26.1e}")
    energy = result.solution.energy
    off = np.abs(result.momentum - [FORCE * OFF, 0.0]).max()
    lines += [
        "",
        f"work of the push {energy.supplied[-1]:.4f} J; after it the energy changes by {result.energy_drift:.1e} J",
        f"momentum after the push {FORCE * OFF:g} N s along x, kept within {off:.1e} N s",
        f"{result.solution.statistics}; {result.solution.status}",
    ]
    return "\n".join(lines)


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figure; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    figure, ax = plt.subplots(figsize=(8.0, 3.8), layout="compressed")
    t, places = result.solution.t, np.linspace(0.0, 1.0, 81)
    shapes = np.stack([result.solution.position(result.beam, s, source="strain") for s in places], axis=1)
    shown = np.arange(0.0, t[-1] + 1e-9, 0.25)
    for time in shown:
        shape = shapes[np.abs(t - time).argmin()]
        ax.plot(*shape.T, color=plt.cm.viridis(time / shown[-1]), lw=1.8)
    for s, style in ((-1, "-"), (0, ":")):
        ax.plot(*shapes[:, s].T, style, color="tab:red", lw=0.8, label="lower end" if s else "upper end")
    for ends in REFERENCE.values():
        ax.plot(*ends.T, "kx", label="other code" if ends is REFERENCE[OFF] else None)
    bar = plt.cm.ScalarMappable(Normalize(0.0, shown[-1]), "viridis")
    figure.colorbar(bar, ax=ax, label="time, s", pad=0.01)
    ax.set(xlabel="x, m", ylabel="y, m", aspect="equal")
    ax.legend(loc="lower right", frameon=False)
    path = out / "flying_spaghetti.png"
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
