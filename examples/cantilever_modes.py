"""Natural frequencies and shapes of a cantilever, and how fast they converge.

    python examples/cantilever_modes.py [--out figures] [--modes 8]

A Timoshenko beam, thick (length / height = 10), clamped at its start: that end takes velocity and angular velocity,
the other takes force and moment. Bending modes are compared with exact frequencies; axial modes, which come in
between, with (2 j - 1) pi / 2 sqrt(EA / rho A) / L.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import phblocks as ph

#: Length, stiffness and inertia all in one unit of length, mass and time.
LENGTH = 1.0
SECTION = ph.Section(axial=1200.0, shear=384.6153846153846, bending=1.0, mass=1.0, rotary=1.0 / 1200.0)
#: Exact bending frequencies, rad/s.
BENDING = np.array(
    (3.4883549511812, 20.906915438489, 54.988379721983, 99.747157639555, 151.84234370656, 208.68383242793)
)
#: Exact axial frequencies, rad/s.
AXIAL = (np.arange(3) + 0.5) * np.pi * np.sqrt(SECTION.axial / SECTION.mass) / LENGTH


def build(elements: int = 16, degree: int = 3) -> tuple[ph.Diagram, ph.Beam]:
    """Draw the diagram; return it with its beam."""
    d = ph.Diagram("cantilever")
    beam = d.add(ph.Beam("beam", SECTION, start=(0.0, 0.0), end=(LENGTH, 0.0), elements=elements, degree=degree))
    d.weld(beam.start, d.ground)
    return d, beam


@dataclass
class Result:
    """Modes of a system."""

    system: ph.System
    frequencies: np.ndarray  # ascending, shape (n,), rad/s
    shapes: np.ndarray  # complex, shape (states, n)
    axial: np.ndarray  # whether most of the energy is in V1 and N1, shape (n,)
    exact: np.ndarray  # frequencies, shape (n,), rad/s; NaN where none is known

    @property
    def errors(self) -> np.ndarray:
        """Relative errors of the frequencies, shape (n,)."""
        return np.asarray(self.frequencies / self.exact - 1.0)


def run(elements: int = 16, degree: int = 3, n: int = 8) -> Result:
    """Find the lowest modes and tell axial ones from bending ones."""
    d, _ = build(elements, degree)
    system = d.compile()
    modes = system.modes(n)
    energy = (modes.shapes.conj() * (system.E @ modes.shapes)).real
    along = [name.split(".")[1][:2] in ("V1", "N1") for name in system.state_names]
    axial = energy[along].sum(axis=0) > 0.5 * energy.sum(axis=0)
    exact = np.full(modes.frequencies.size, np.nan)
    for kind, known in ((axial, AXIAL), (~axial, BENDING)):
        places = np.flatnonzero(kind)[: known.size]
        exact[places] = known[: places.size]
    return Result(system, modes.frequencies, modes.shapes, axial, exact)


def converge(
    degrees: Sequence[int] = (1, 2, 3), elements: Sequence[int] = (4, 8, 16, 32), n: int = 3
) -> dict[int, np.ndarray]:
    """Relative errors of the lowest n modes: degree -> array of shape (elements, n)."""
    return {k: np.abs([run(m, k, n).errors for m in elements]) for k in degrees}


def tabulate(result: Result, errors: dict[int, np.ndarray], elements: Sequence[int] = (4, 8, 16, 32)) -> str:
    """Format the numbers as tables."""
    lines = [f"{'mode':>4}  {'kind':<8}{'frequency (rad/s)':>18}{'exact (rad/s)':>16}{'relative error':>16}"]
    rows = zip(result.frequencies, result.axial, result.exact, result.errors, strict=True)
    for i, (frequency, axial, exact, error) in enumerate(rows, start=1):
        lines.append(f"{i:4}  {'axial' if axial else 'bending':<8}{frequency:18.9f}{exact:16.9f}{error:16.1e}")
    lines += ["", "relative error of mode 1", f"{'elements':>8}" + "".join(f"{f'degree {k}':>12}" for k in errors)]
    for i, m in enumerate(elements):
        lines.append(f"{m:8}" + "".join(f"{error[i, 0]:12.1e}" for error in errors.values()))
    return "\n".join(lines)


def deflection(result: Result, mode: int) -> tuple[np.ndarray, np.ndarray]:
    """Transverse velocity of a mode along the beam: places (m) and values, of largest size 1."""
    across = [name.split(".")[1].startswith("V2") for name in result.system.state_names]
    place, value = result.system.state_positions[across], result.shapes[across, mode]
    order = np.argsort(place, kind="stable")
    place, value = place[order], value[order]
    value = (value * np.exp(-1j * np.angle(value[np.abs(value).argmax()]))).real
    return place, value / np.abs(value).max()


def draw(
    result: Result, errors: dict[int, np.ndarray], out: Path, elements: Sequence[int] = (4, 8, 16, 32)
) -> list[Path]:
    """Write the figures; return their paths."""
    out.mkdir(parents=True, exist_ok=True)
    shapes, ax = plt.subplots(figsize=(7.0, 3.8), layout="constrained")
    for mode in np.flatnonzero(~result.axial)[:4]:
        ax.plot(*deflection(result, mode), label=f"{result.frequencies[mode]:.2f} rad/s")
    ax.set(xlabel="place along the beam (m)", ylabel="deflection / largest (1)")
    ax.grid(alpha=0.3)
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False)

    convergence, ax = plt.subplots(figsize=(5.5, 4.2), layout="constrained")
    for k, error in errors.items():
        [line] = ax.loglog(elements, error[:, 0], "o-", label=f"degree {k}")
        slope = error[-1, 0] * (elements[-1] / np.array(elements)) ** (2.0 * k)
        ax.loglog(elements, slope, "--", color=line.get_color(), label=f"order {2 * k}")
    ax.set(xlabel="elements (1)", ylabel="relative error of the lowest frequency (1)")
    ax.set_xticks(elements, [str(m) for m in elements])
    ax.minorticks_off()
    ax.grid(alpha=0.3)
    ax.legend(frameon=False)

    paths = [out / "cantilever_shapes.png", out / "cantilever_convergence.png"]
    for figure, path in zip((shapes, convergence), paths, strict=True):
        figure.savefig(path, dpi=100)
        plt.close(figure)
    return paths


def main(argv: Sequence[str] | None = None) -> Result:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder for the figures")
    parser.add_argument("--modes", type=int, default=8, help="how many")
    options = parser.parse_args(argv)

    result, errors = run(n=options.modes), converge()
    print(tabulate(result, errors), "", *draw(result, errors, options.out), sep="\n")
    return result


if __name__ == "__main__":
    main()
