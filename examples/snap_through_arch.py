"""An arch that snaps through
==========================

A shallow arch under a load at its crown: up to a limit it carries, then it jumps.

::

    python examples/snap_through_arch.py [--out figures]

Twice the same arch, clamped at both ends. First the crown is *moved* down slowly and the force it takes is read: it
rises to a limit, falls, and rises again when the arch hangs. Then the crown is *loaded* slowly. Between the limit and
the hanging arch there is no state of rest that is stable under a load: it jumps there at the limit load, and what the
load and the arch give off in the jump goes into drag. One port, exposed with ``imposes="velocity"`` or
``imposes="force"``; causality does the rest.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import phblocks as ph

SPAN, RISE, THICKNESS = 1.0, 0.04, 0.01  # m
SECTION = ph.Section.rectangle(
    width=0.02, height=THICKNESS, young=2.1e11, poisson=0.3, density=7850.0, shear_factor=5.0 / 6.0
)
DRAG = 500.0  # N s/m^2
TRAVEL, SLOWLY = 0.09, 8.0  # of the crown, m; s
LOAD = 4000.0  # N at the end of the run with a load


def build(imposes: str, elements: int = 4, degree: int = 3) -> ph.Diagram:
    """Draw the arch as two halves welded at the crown, and open the crown."""
    half = 0.5 * SPAN
    radius = (half**2 + RISE**2) / (2.0 * RISE)
    d = ph.Diagram("arch")
    arc: dict[str, Any] = {"curvature": -1.0 / radius, "elements": elements, "degree": degree}
    arc["damping"] = ph.Damping(viscous=DRAG)
    left = d.add(ph.Beam("left", SECTION, (-half, 0.0), (0.0, RISE), **arc))
    right = d.add(ph.Beam("right", SECTION, (0.0, RISE), (half, 0.0), **arc))
    d.weld(d.ground, left.start)
    d.weld(left.end, right.start)
    d.weld(right.end, d.ground)
    d.expose(left.end.translation, "crown", imposes=imposes)
    return d


@dataclass
class Result:
    """What both runs gave."""

    moved: ph.Solution
    loaded: ph.Solution
    path: np.ndarray  # deflection of the crown when moved, m, and force on it, N, shape (times, 2)
    jump: np.ndarray  # the same when loaded
    limit: float  # largest force when moved, before it falls, N
    snap: float  # load at which the loaded crown passes half its rise in a jump, N


def run(dt: float = 0.01) -> Result:
    """Move the crown, then load it."""
    crown = -TRAVEL / SLOWLY

    def moving(t: float) -> tuple[float, float]:
        s = min(t / 0.5, 1.0)  # a smooth start
        return 0.0, crown * s * s * (3.0 - 2.0 * s)

    moved = ph.simulate(build("velocity").compile(), SLOWLY, dt, inputs={"crown": moving})
    path = np.stack([deflection(moved), crown_force(moved)], axis=1)

    loaded = ph.simulate(build("force").compile(), SLOWLY, dt, inputs={"crown": lambda t: (0.0, -LOAD * t / SLOWLY)})
    jump = np.stack([deflection(loaded), LOAD * loaded.t / SLOWLY], axis=1)
    standing = path[path[:, 0] < RISE]
    return Result(
        moved=moved,
        loaded=loaded,
        path=path,
        jump=jump,
        limit=float(standing[:, 1].max()),
        snap=float(np.interp(RISE, jump[:, 0], jump[:, 1])),
    )


def deflection(solution: ph.Solution) -> np.ndarray:
    """How far the crown is below its place, m."""
    return RISE - solution.position("left", 1.0, source="strain")[:, 1]


def crown_force(solution: ph.Solution) -> np.ndarray:
    """Force that presses the crown down, N: the difference of the internal forces beside it."""
    left, right = (solution.force(name, s, frame="fixed")[:, 1] for name, s in (("left", 1.0), ("right", 0.0)))
    return right - left


def tabulate(result: Result) -> str:
    """Format the numbers as a table."""
    lines = [f"{'deflection, mm':>15}{'force when moved, N':>21}"]
    for d in np.linspace(0.01, 0.07, 7):
        lines.append(f"{1e3 * d:15.1f}{np.interp(d, *result.path.T):21.1f}")
    energy = result.loaded.energy
    lines += [
        "",
        f"limit load {result.limit:.1f} N when moved; when loaded it jumps at {result.snap:.1f} N",
        f"work of the load {energy.supplied[-1]:.2f} J, of it lost in drag {energy.dissipated[-1]:.2f} J and stored "
        f"{energy.total[-1]:.2f} J",
        f"worst power balance {result.loaded.max_power_balance_error:.1e} J; {result.loaded.status}",
    ]
    return "\n".join(lines)


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figure; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    figure, (ax, shapes) = plt.subplots(1, 2, figsize=(10.0, 3.8), layout="compressed", width_ratios=(1.0, 1.3))
    shown = result.path[:, 1] < 1.3 * LOAD
    ax.plot(1e3 * result.path[shown, 0], 1e-3 * result.path[shown, 1], label="crown moved")
    ax.plot(1e3 * result.jump[:, 0], 1e-3 * result.jump[:, 1], "--", color="tab:red", label="crown loaded")
    ax.plot([0.0, 1e3 * TRAVEL], 2 * [1e-3 * result.limit], ":", color="grey", lw=0.8)
    ax.set(xlabel="deflection of the crown, mm", ylabel="force, kN", xlim=(0.0, 75.0), ylim=(0.0, 1.2e-3 * LOAD))
    ax.legend(frameon=False, loc="upper left")
    places = np.linspace(0.0, 1.0, 25)
    lines = np.concatenate(
        [[result.moved.position(half, s, source="strain") for s in places] for half in ("left", "right")]
    )
    for k, crown in enumerate(np.linspace(0.0, 0.07, 8)):
        line = 1e3 * lines[:, np.abs(result.path[:, 0] - crown).argmin()]
        shapes.plot(*line.T, color=plt.cm.viridis(k / 7.5), label=f"{1e3 * crown:.0f} mm")
    shapes.set(xlabel="x, mm", ylabel="y, mm (enlarged)")
    shapes.legend(frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    path = out / "snap_through_arch.png"
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
