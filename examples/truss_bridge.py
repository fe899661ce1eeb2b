"""Modes of a truss bridge
=======================

A Warren truss of steel bars, pinned at every joint: its lowest modes, next to those of bars without bending.

::

    python examples/truss_bridge.py [--out figures]

Nobody says who gives velocity and who takes it at joints of four or five bars; the compiler finds a choice for all of
them without multipliers. Where bars are pinned they only pull and push as long as they do not vibrate between the
joints themselves, so the low modes are those of a plain truss, assembled here from 4 by 4 bar matrices; and those of a
beam are pinned at both ends.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import interp1d
from scipy.linalg import eigh

import phblocks as ph
from phblocks.modes import Modes

PANELS, PANEL, HEIGHT = 5, 4.0, 3.5  # number, m, m
BAR = ph.Section.tube(radius=0.3, thickness=0.01, young=2.1e11, poisson=0.3, density=7850.0)
BENDING = 2.1e11 * np.pi / 4.0 * (0.3**4 - 0.29**4)  # N m^2


def nodes_and_bars() -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Places of the joints, shape (n, 2), m, and which two joints each bar leads from and to."""
    bottom = [(PANEL * i, 0.0) for i in range(PANELS + 1)]
    top = [(PANEL * (i + 0.5), HEIGHT) for i in range(PANELS)]
    first = PANELS + 1  # of the joints above
    bars = [(i, i + 1) for i in range(PANELS)] + [(first + i, first + i + 1) for i in range(PANELS - 1)]
    bars += [pair for i in range(PANELS) for pair in ((i, first + i), (first + i, i + 1))]
    return np.array(bottom + top), bars


def build(elements: int = 2, degree: int = 2) -> tuple[ph.Diagram, list[ph.Beam]]:
    """Draw the bridge, pinned at its left end, on a roller at its right; return it with the bars."""
    places, bars = nodes_and_bars()
    d = ph.Diagram("bridge")
    beams = [
        d.add(ph.Beam(f"bar {a}-{b}", BAR, places[a], places[b], elements=elements, degree=degree)) for a, b in bars
    ]
    meeting: dict[int, list[ph.Anchor]] = {node: [] for node in range(len(places))}
    for (a, b), beam in zip(bars, beams, strict=True):
        meeting[a].append(beam.start)
        meeting[b].append(beam.end)
    roller = d.add(ph.Slider("roller", (1.0, 0.0)))
    d.connect(d.ground.translation, roller.first)
    for node, anchors in meeting.items():
        if node == 0:
            d.pin(*anchors, d.ground)
        elif node == PANELS:
            d.connect(*(anchor.translation for anchor in anchors), roller.second)
        else:
            d.pin(*anchors)
    return d, beams


def plain_truss() -> np.ndarray:
    """Lowest angular frequencies of bars that only pull and push, ascending, rad/s: consistent masses."""
    places, bars = nodes_and_bars()
    K, M = np.zeros((2, 2 * len(places), 2 * len(places)))
    for a, b in bars:
        along = places[b] - places[a]
        length = np.linalg.norm(along)
        e = np.concatenate([-along, along]) / length
        at = [2 * a, 2 * a + 1, 2 * b, 2 * b + 1]
        K[np.ix_(at, at)] += BAR.axial / length * np.outer(e, e)
        M[np.ix_(at, at)] += BAR.mass * length / 6.0 * np.kron([[2.0, 1.0], [1.0, 2.0]], np.eye(2))
    free = np.setdiff1d(np.arange(len(K)), [0, 1, 2 * PANELS + 1])
    return np.asarray(np.sqrt(eigh(K[np.ix_(free, free)], M[np.ix_(free, free)], eigvals_only=True)))


@dataclass
class Result:
    """What the modes are."""

    beams: list[ph.Beam]
    system: ph.System
    modes: Modes  # lowest ones
    plain: np.ndarray  # frequencies of the plain truss, rad/s


def run(n: int = 3) -> Result:
    """Find the lowest modes of both."""
    d, beams = build()
    system = d.compile()
    return Result(beams, system, system.modes(n), plain_truss()[:n])


def shape(result: Result, mode: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Displacements along each bar in a mode: list of arrays of shape (places, 2), of largest size 1."""
    names = result.system.state_names
    value = result.modes.shapes[:, mode]
    value = (value * np.exp(-1j * np.angle(value[np.abs(value * [n.find(".V") > 0 for n in names]).argmax()]))).real
    found = []
    places, bars = nodes_and_bars()
    for (a, b), beam in zip(bars, result.beams, strict=True):
        along = places[b] - places[a]
        along = along / np.linalg.norm(along)
        grid = np.linspace(0.0, beam.length, 9)
        fields = []
        for field in ("V1", "V2"):
            of = [i for i, name in enumerate(names) if name.startswith(f"{beam.name}.{field}[")]
            at = result.system.state_positions[of]
            fields.append(interp1d(at, value[of], fill_value="extrapolate")(grid))
        moved = fields[0][:, None] * along + fields[1][:, None] * np.array((-along[1], along[0]))
        found.append((places[a] + grid[:, None] * along, moved))
    largest = max(np.linalg.norm(moved, axis=1).max() for _, moved in found)
    return [(line, moved / largest) for line, moved in found]


def tabulate(result: Result) -> str:
    """Format the numbers as a table."""
    lines = [f"{'mode':>4}{'frequency, Hz':>16}{'plain truss, Hz':>18}{'difference':>13}"]
    for i, (found, plain) in enumerate(zip(result.modes.hertz, result.plain / (2.0 * np.pi), strict=True)):
        lines.append(f"{i + 1:4d}{found:16.4f}{plain:18.4f}{found / plain - 1.0:13.1e}")
    alone = np.pi / 2.0 * np.sqrt(BENDING / BAR.mass) / PANEL**2
    multipliers = len(result.system.constraint_names)
    lines += [
        "",
        f"{len(result.beams)} bars, {result.system.n} states, {multipliers} multiplier (the roller's); one "
        f"bar alone vibrates between its joints at {alone:.1f} Hz",
    ]
    return "\n".join(lines)


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figure; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    figure, axes = plt.subplots(len(result.modes.hertz), 1, figsize=(8.0, 6.0), sharex=True, layout="compressed")
    for mode, ax in enumerate(axes):
        for line, moved in shape(result, mode):
            ax.plot(*line.T, color="0.8", lw=1.0)
            ax.plot(*(line + 1.5 * moved).T, color="tab:blue", lw=1.5)
        ax.plot(0.0, 0.0, "k^", ms=9)
        ax.plot(PANELS * PANEL, 0.0, "ko", ms=7)
        ax.set(aspect="equal", ylabel="y, m")
        ax.set_title(f"{result.modes.hertz[mode]:.2f} Hz", fontsize=10)
    axes[-1].set_xlabel("x, m")
    path = out / "truss_bridge.png"
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
