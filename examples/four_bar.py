"""The four-bar linkage: three flexible bars, pinned to each other and to the ground, fall from rest.

    python examples/four_bar.py [--out figures] [--elements 10 6 6] [--degree 1] [--dt 0.02] [--t-end 10]

By default the setting of Brugnoli, Kinon, Sanfedino, Betsch: Structure-preserving discretization of intrinsic
geometrically exact beams for explicit multibody dynamics, table 1. Prints the path of P, the middle of the coupler,
next to a reference, what the energy and the joints did, and what it cost; draws its Figs. 6 and 7, the diagram and
the matrices.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

import phblocks as ph

GRAVITY = 9.81  # m/s^2
Bars = tuple[ph.Beam, ph.Beam, ph.Beam]  # crank, coupler, rocker

#: P at t = 0, 1, ..., 10 s, m: an independent displacement-based beam code at dt = 5e-5 s, shear factor 5/6 (which
#: moves P by 8e-5 m up to t = 5 s); good to 4e-5 m up to t = 5 s and to 2.2e-4 m up to t = 10 s.
REFERENCE = np.array(
    [
        (2.75, 1.5),
        (1.39596844583251, -0.264185077932891),
        (1.47989352275675, 1.08272922833597),
        (2.58306381551442, -0.182361609762521),
        (2.31446828063222, 1.16451655243399),
        (2.77037396407714, 1.13756734541519),
        (2.67121095605296, -0.608406757447717),
        (1.33992231586665, 1.3684094974943),
        (1.18609311424043, -1.18223576891858),
        (2.83504872403316, 1.35603435487395),
        (1.76266390609032, 0.682715791007273),
    ]
)


def build(elements: Sequence[int] = (10, 6, 6), degree: int = 1) -> tuple[ph.Diagram, Bars]:
    """Draw the diagram; return it with its three bars."""
    bar = ph.Section.rectangle(width=0.05, height=0.05, young=2.1e11, poisson=0.3, density=2710.0, shear_factor=1.0)
    d = ph.Diagram("four-bar", gravity=(0.0, -GRAVITY))
    crank = d.add(ph.Beam("crank", bar, start=(0.0, 0.5), end=(2.0, 1.5), elements=elements[0], degree=degree))
    coupler = d.add(ph.Beam("coupler", bar, start=(2.0, 1.5), end=(3.5, 1.5), elements=elements[1], degree=degree))
    rocker = d.add(ph.Beam("rocker", bar, start=(3.5, 1.5), end=(2.5, 0.5), elements=elements[2], degree=degree))
    d.pin(crank.start, d.ground)
    d.pin(crank.end, coupler.start)
    d.pin(coupler.end, rocker.start)
    d.pin(rocker.end, d.ground)
    return d, (crank, coupler, rocker)


@dataclass
class Result:
    """What a run gave."""

    diagram: ph.Diagram
    bars: Bars
    solution: ph.Solution
    P: np.ndarray  # path of the middle of the coupler, shape (times, 2), m
    seconds: np.ndarray  # whole seconds of the run, shape (k,), s
    P_seconds: np.ndarray  # P at those times, shape (k, 2), m
    distances: np.ndarray  # of those from the reference, shape (k,), m
    start_energy: float  # potential energy at the start above y = 0, J
    energy_drift: float  # largest change of the total energy, J
    gaps: dict[str, tuple[float, float]]  # joint -> largest gap by positions from (strain, velocity), m
    wall_time: float  # to check, compile and simulate, s


def run(elements: Sequence[int] = (10, 6, 6), degree: int = 1, dt: float = 0.02, t_end: float = 10.0) -> Result:
    """Simulate; return the solution and the numbers drawn from it."""
    clock = perf_counter()
    d, bars = build(elements, degree)
    solution = ph.simulate(d.compile(), t_end=t_end, dt=dt)
    wall_time = perf_counter() - clock

    P = solution.position(bars[1], 0.5)
    seconds = np.arange(min(len(REFERENCE), int(solution.t[-1] + 1e-9) + 1))
    P_seconds = np.stack([np.interp(seconds, solution.t, P[:, i]) for i in range(2)], axis=1)
    energy = solution.energy.total
    by_strain, by_velocity = (solution.closure(source=source) for source in ("strain", "velocity"))
    return Result(
        diagram=d,
        bars=bars,
        solution=solution,
        P=P,
        seconds=seconds,
        P_seconds=P_seconds,
        distances=np.linalg.norm(P_seconds - REFERENCE[: seconds.size], axis=1),
        start_energy=sum(b.section.mass * b.length * GRAVITY * solution.position(b, 0.5)[0, 1] for b in bars),
        energy_drift=np.abs(energy - energy[0]).max(),
        gaps={joint: (by_strain[joint].max(), by_velocity[joint].max()) for joint in by_strain},
        wall_time=wall_time,
    )


def tabulate(result: Result) -> str:
    """Format the numbers as tables."""
    lines = ["P, the middle of the coupler", f"{'t (s)':>6}{'x (m)':>12}{'y (m)':>12}{'from reference (m)':>21}"]
    for t, (x, y), distance in zip(result.seconds, result.P_seconds, result.distances, strict=True):
        lines.append(f"{t:6.0f}{x:12.6f}{y:12.6f}{distance:21.1e}")
    lines += ["", f"{'largest gap of a joint (m)':<32}{'from strain':>14}{'from velocity':>16}"]
    lines += [f"{joint:<32}{strain:14.1e}{velocity:16.1e}" for joint, (strain, velocity) in result.gaps.items()]
    drift, error = result.energy_drift, result.solution.max_power_balance_error
    lines += [
        "",
        f"total energy changed by at most   {drift:.1e} J (potential energy at the start: {result.start_energy:.0f} J)",
        f"power balance of the worst step   {error:.1e} J",
        f"system and run                    {result.solution.system.n} states, {result.solution.statistics}",
        f"check, compile and simulate       {result.wall_time:.2f} s",
        f"status                            {result.solution.status}",
    ]
    return "\n".join(lines)


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figures; return their paths."""
    solution, (_, coupler, _) = result.solution, result.bars
    out.mkdir(parents=True, exist_ok=True)
    figures: dict[str, Figure] = {}

    figures["four_bar"], ax = plt.subplots(figsize=(6.4, 4.6), layout="compressed")
    ph.plots.motion(solution, times=np.linspace(0.0, min(1.2, solution.t[-1]), 7)[1:], path=coupler.at(0.5), ax=ax)

    figures["four_bar_point"], ax = plt.subplots(figsize=(7.0, 3.4), layout="constrained")
    for i, (name, colour) in enumerate((("x", "tab:blue"), ("y", "tab:orange"))):
        ax.plot(solution.t, result.P[:, i], color=colour, label=f"{name} of P")
        ax.plot(result.seconds, REFERENCE[: result.seconds.size, i], "o", color=colour, label=f"{name}, reference")
    ax.set(xlabel="time (s)", ylabel="position (m)")
    ax.grid(alpha=0.3)
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False)

    figures["four_bar_energy"], axes = plt.subplots(2, 1, figsize=(7.0, 6.0), layout="constrained")
    ph.plots.energy(solution, ax=axes[0])
    ph.plots.energy(solution, increments=True, ax=axes[1])

    figures["four_bar_matrices"], axes = plt.subplots(1, 2, figsize=(12.0, 6.8), layout="compressed")
    ph.plots.sparsity(solution.system, "J", ax=axes[0])
    ph.plots.sparsity(solution.system, "newton", ax=axes[1])

    drawn = ph.plots.diagram(result.diagram).figure
    assert isinstance(drawn, Figure)
    figures["four_bar_diagram"] = drawn

    paths = [out / f"{name}.png" for name in figures]
    for figure, path in zip(figures.values(), paths, strict=True):
        figure.savefig(path, dpi=100)
        plt.close(figure)
    return paths


def main(argv: Sequence[str] | None = None) -> Result:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder for the figures")
    parser.add_argument("--elements", type=int, nargs=3, default=(10, 6, 6), help="of crank, coupler, rocker")
    parser.add_argument("--degree", type=int, default=1, help="of the elements")
    parser.add_argument("--dt", type=float, default=0.02, help="step, s")
    parser.add_argument("--t-end", type=float, default=10.0, help="duration, s")
    options = parser.parse_args(argv)

    result = run(options.elements, options.degree, options.dt, options.t_end)
    print(result.diagram.check(), tabulate(result), "", *draw(result, options.out), sep="\n")
    return result


if __name__ == "__main__":
    main()
