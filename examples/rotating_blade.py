"""A blade that spins
===================

Centrifugal stiffening: the faster a beam spins, the faster it swings; a linear model says the opposite.

::

    python examples/rotating_blade.py [--out figures]

The first lag frequency (in the plane of rotation) of a cantilever that spins at the rate Omega, about its steady state,
next to known values for a slender one (Wright, Smith, Thresher, Wang, J. Appl. Mech. 49 (1982) 197-202,
doi:10.1115/1.3161966). The model of second order agrees with the full one; the linear one has
omega^2 = omega_0^2 - Omega^2 and diverges above omega_0, so it is refused unless one insists.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.sparse.linalg import spsolve

import phblocks as ph

LENGTH, BENDING, MASS = 10.0, 1.4e4, 1.2  # m, N m^2, kg/m
SECTION = ph.Section(axial=2.8e7, shear=1.0e7, bending=BENDING, mass=MASS, rotary=6e-4)
UNIT = np.sqrt(BENDING / MASS) / LENGTH**2  # rad/s
#: Flap frequencies at the spins 0, 1, ..., 10, all in this unit.
FLAP = np.array((3.5160, 3.6816, 4.1373, 4.7973, 5.5850, 6.4495, 7.3604, 8.2996, 9.2568, 10.2257, 11.2023))
SPINS = UNIT * np.arange(FLAP.size)  # rad/s
KNOWN = UNIT * np.sqrt(FLAP**2 - np.arange(FLAP.size) ** 2)  # lag, rad/s
MODELS = {
    "full": ph.Approximation(),
    "second order": ph.Approximation(large_rotation="second-order"),
}


def build(spin: float, elements: int = 6, degree: int = 2) -> ph.Diagram:
    """Draw the diagram: the root turned at a constant rate, rad/s."""
    d = ph.Diagram("blade")
    blade = d.add(ph.Beam("blade", SECTION, (0.0, 0.0), (LENGTH, 0.0), elements=elements, degree=degree))
    motor = d.add(ph.AngularVelocity("motor", float(spin)))
    d.pin(blade.start, d.ground)
    d.connect(motor.port, blade.start.rotation)
    return d


def steady(system: ph.System, spin: float) -> ph.State:
    """Find the state in which the blade turns as one, stretched by its own inertia: Newton's method."""
    state, u = system.rigid_motion(spin=spin), np.array([spin])
    for _ in range(4):
        A = system.linearize(state, u).A.tocsc()[: system.n, : system.n]
        state = ph.State(state.x + spsolve(A, -system.force(state.x, state.theta, u)), state.theta, state.points)
    return state


@dataclass
class Result:
    """Frequencies over the spin."""

    frequencies: dict[str, np.ndarray]  # model -> first lag frequency at each of SPINS, rad/s
    still: float  # of the blade at rest, rad/s
    linear: np.ndarray  # of the linear theory in the frame that turns, rad/s; NaN where it diverges
    refusal: str  # what the linear model is told at the highest spin


def run(spins: np.ndarray = SPINS) -> Result:
    """Take the lowest frequency about the steady state of each spin."""
    found = {name: np.empty(spins.size) for name in MODELS}
    for name, model in MODELS.items():
        for i, spin in enumerate(spins):
            system = build(spin).compile(effects="all", approximation=model)
            state = steady(system, spin)
            found[name][i] = system.modes(1, state, np.array([spin])).frequencies[0]
    try:
        build(spins[-1]).compile(approximation=ph.Approximation(large_rotation=False))
        refusal = "none"
    except ph.errors.ApproximationError as error:
        refusal = f"[{error.code}] {error.got}"
    still = found["full"][0]
    with np.errstate(invalid="ignore"):
        linear = np.sqrt(still**2 - spins**2)
    return Result(found, still, linear, refusal)


def tabulate(result: Result) -> str:
    """Format the numbers as a table."""
    head = "".join(f"{name + ', rad/s':>22}" for name in result.frequencies)
    lines = [f"{'spin, rad/s':>12}{head}{'known, rad/s':>16}{'linear, rad/s':>18}"]
    for i in range(0, SPINS.size, 2):
        row = "".join(f"{found[i]:22.5f}" for found in result.frequencies.values())
        linear = "diverges" if np.isnan(result.linear[i]) else f"{result.linear[i]:.5f}"
        lines.append(f"{SPINS[i]:12.3f}{row}{KNOWN[i]:16.4f}{linear:>18}")
    lines += ["", f"the linear model at {SPINS[-1]:.1f} rad/s is refused: {result.refusal}"]
    return "\n".join(lines)


def draw(result: Result, out: Path) -> list[Path]:
    """Write the figure; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    figure, ax = plt.subplots(figsize=(6.4, 4.2), layout="compressed")
    ax.plot(SPINS, KNOWN, "k-", lw=0.8, label="known")
    for (name, found), style in zip(result.frequencies.items(), ("o", "x"), strict=True):
        ax.plot(SPINS, found, style, fillstyle="none", label=name)
    below = np.linspace(0.0, result.still, 200)
    ax.plot(below, np.sqrt(result.still**2 - below**2), ":", color="tab:red", label="linear theory")
    ax.plot(SPINS, SPINS, "--", color="grey", lw=0.8)
    ax.text(6.3, 6.55, "once per turn", rotation=38, color="grey", rotation_mode="anchor")
    ax.set(xlabel="spin, rad/s", ylabel="first lag frequency, rad/s", ylim=(0.0, 8.0), xlim=(0.0, SPINS[-1]))
    ax.legend(frameon=False, loc="lower right")
    path = out / "rotating_blade.png"
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
