"""Matrices of the user's in a loop with a flexible beam: an absorber with feedthrough, and a control law with R(x).

    python examples/matrices_in_a_loop.py [--out figures]

At the tip of a steel cantilever hang two blocks that nobody drew, both written down as equations:

* an absorber, a mass m on a spring k and a damper c in each direction, driven by the velocity u of the tip. Its
  damper acts on the tip directly: P = -c on the absorber's velocity, S = c, and a spinning wheel inside adds a force
  across the velocity, N. A SystemBlock.
* a control law: a force that grows with the integral of the velocity and hardens, with a leak that opens with it,
  x' = u - R(x) grad H(x). A CustomBlock.

Both are passive, so the loop is stable and its power adds up. The poles of the loop are compared with those of a loop
closed by hand from the matrices of the beam alone, and with theory: one mode of a Bernoulli beam with the absorber.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import phblocks as ph

LENGTH, WIDTH, HEIGHT = 1.0, 0.04, 0.01  # m
YOUNG, DENSITY = 2.1e11, 7850.0  # Pa, kg/m^3
MASS, WHEEL = 0.08, 0.5  # kg, N s/m
STIFFNESS, HARDENING, LEAK = 400.0, 4e6, 2e-4  # N/m, N/m^3, m/(N s)
KNOCK = 0.01  # s, of 50 N

BENDING, LINE_MASS = YOUNG * WIDTH * HEIGHT**3 / 12.0, DENSITY * WIDTH * HEIGHT
MODAL_MASS = LINE_MASS * LENGTH / 4.0  # of the first mode of a cantilever, seen from its tip
MODAL_STIFFNESS = 1.8751041**4 * BENDING / LENGTH**3 / 4.0


def absorber() -> dict[str, np.ndarray]:
    """Matrices of the absorber, tuned by Den Hartog's rule; its states are elongation and momentum, x and y of each."""
    ratio = MASS / MODAL_MASS
    omega = np.sqrt((MODAL_STIFFNESS + STIFFNESS) / MODAL_MASS) / (1.0 + ratio)
    k = MASS * omega**2
    c = 2.0 * MASS * omega * np.sqrt(3.0 * ratio / (8.0 * (1.0 + ratio)))
    one, none = np.eye(2), np.zeros((2, 2))
    return {
        "J": np.block([[none, -one], [one, none]]),
        "R": np.block([[none, none], [none, c * one]]),
        "Q": np.block([[k * one, none], [none, one / MASS]]),
        "G": np.vstack([one, none]),
        "P": np.vstack([none, -c * one]),
        "S": c * one,
        "N": WHEEL * np.array([[0.0, 1.0], [-1.0, 0.0]]),
    }


def control_law() -> ph.CustomBlock:
    """The control law as a block; its states are the integrals of the tip's velocity, with the leak."""
    return ph.CustomBlock(
        "control",
        size=2,
        hamiltonian=lambda x: STIFFNESS * (x @ x) / 2.0 + HARDENING * (x @ x) ** 2 / 4.0,
        gradient=lambda x: (STIFFNESS + HARDENING * (x @ x)) * x,
        hessian=lambda x: (STIFFNESS + HARDENING * (x @ x)) * np.eye(2) + 2.0 * HARDENING * np.outer(x, x),
        R=lambda x: LEAK * (1.0 + (x @ x) / 0.01**2) * np.eye(2),
        G=np.eye(2),
        ports={"tip": ph.SystemPort(ph.TRANSLATION, columns=(0, 1), gives="force")},
        units=("m", "m"),
    )


def build(closed: bool = True) -> ph.Diagram:
    """Draw the diagram; without the two blocks, the tip is open."""
    section = ph.Section.rectangle(width=WIDTH, height=HEIGHT, young=YOUNG, poisson=0.3, density=DENSITY)
    d = ph.Diagram("loop" if closed else "beam")
    beam = d.add(ph.Beam("beam", section, start=(0.0, 0.0), end=(LENGTH, 0.0), elements=4, degree=2))
    d.weld(beam.start, d.ground)
    if closed:
        port = ph.SystemPort(ph.TRANSLATION, columns=(0, 1), gives="force")
        a = absorber()
        hung = d.add(
            ph.SystemBlock(
                "absorber", J=a["J"], R=a["R"], Q=a["Q"], G=a["G"], P=a["P"], S=a["S"], N=a["N"], ports={"tip": port}
            )
        )
        d.connect(beam.end.translation, hung["tip"], d.add(control_law())["tip"])
    d.expose(beam.end.translation, "tip", imposes="force")
    return d


def close_by_hand() -> np.ndarray:
    """Poles of the loop from the matrices of the beam alone: force on the tip = - (what absorber and control give)."""
    beam, a = build(closed=False).compile().linearize(), absorber()
    A, B, C = (m.toarray() for m in (beam.A, beam.B, beam.C))
    E = beam.E.toarray()
    A, B = np.linalg.solve(E, A), np.linalg.solve(E, B)
    inside = (a["J"] - a["R"]) @ a["Q"]
    into, out = a["G"] - a["P"], (a["G"] + a["P"]).T @ a["Q"]
    one = np.eye(2)
    loop = np.block(
        [
            [A - B @ (a["S"] + a["N"]) @ C, -B @ out, -STIFFNESS * B],
            [into @ C, inside, np.zeros((4, 2))],
            [C, np.zeros((2, 4)), -LEAK * STIFFNESS * one],
        ]
    )
    return np.linalg.eigvals(loop)


def theory() -> np.ndarray:
    """Poles with one mode of a Bernoulli beam: its deflection w, the absorber's z, the control's x, across the beam."""
    a = absorber()
    k, c = a["Q"][0, 0], a["S"][0, 0]
    # states w', w, z', z, x
    w = np.array([-c, -MODAL_STIFFNESS - k, c, k, -STIFFNESS]) / MODAL_MASS
    z = np.array([c, k, -c, -k, 0.0]) / MASS
    across = np.linalg.eigvals(np.array([w, [1, 0, 0, 0, 0], z, [0, 0, 1, 0, 0], [1, 0, 0, 0, -LEAK * STIFFNESS]]))
    along = np.linalg.eigvals([[-c / MASS, -k / MASS], [1, 0]])  # the tip does not move that way
    return np.concatenate([across, along])


@dataclass
class Loop:
    """What came out."""

    poles: dict[str, np.ndarray]  # the slowest three, by how they were found, 1/s
    runs: dict[str, ph.Solution]


def swinging(poles: np.ndarray, n: int = 3) -> np.ndarray:
    """The slowest poles above the real axis."""
    above = poles[poles.imag > 1e-6 * np.abs(poles)]
    return np.asarray(above[np.argsort(above.imag)][:n])


def run() -> Loop:
    """Poles in three ways, and the answer to a knock at the tip with and without the two blocks."""
    systems = {"beam alone": build(closed=False).compile(), "in the loop": build().compile()}
    modes = systems["in the loop"].modes(3)
    poles = {
        "diagram": modes.growth + 1j * modes.frequencies,
        "by hand": swinging(close_by_hand()),
        "one mode": swinging(theory()),
    }
    runs = {
        name: ph.simulate(system, 1.0, 0.002, inputs={"tip": lambda t: (0.0, 50.0 if t < KNOCK else 0.0)})
        for name, system in systems.items()
    }
    return Loop(poles, runs)


def tabulate(loop: Loop) -> str:
    """Format the poles as a table, and what the knock left."""
    lines = [f"{'poles, 1/s':>12}" + "".join(f"{f'{i + 1}':>22}{'damping':>9}" for i in range(3))]
    for name, poles in loop.poles.items():
        numbers = "".join(f"{p.real:10.4f} +{p.imag:9.4f}i{-p.real / abs(p):9.4f}" for p in poles)
        lines.append(f"{name:>12}{numbers}")
    lines.append("")
    for name, solution in loop.runs.items():
        energy = solution.energy
        lines.append(
            f"{name:>12}: knocked with {energy.supplied[-1]:.4f} J, after 1 s {energy.total[-1]:.4f} J left and "
            f"{energy.dissipated[-1]:.4f} J dissipated; balance of a step to {solution.max_power_balance_error:.0e} J"
        )
    return "\n".join(lines)


def draw(loop: Loop, out: Path) -> list[Path]:
    """Write the figure; return its path."""
    out.mkdir(parents=True, exist_ok=True)
    figure, axis = plt.subplots(figsize=(7.0, 3.5), layout="compressed")
    for name, solution in loop.runs.items():
        axis.plot(solution.t, 1e3 * solution.position("beam", 1.0)[:, 1], label=name)
    axis.set(xlabel="t, s", ylabel="deflection of the tip, mm")
    axis.legend()
    path = out / "matrices_in_a_loop.png"
    figure.savefig(path, dpi=100)
    plt.close(figure)
    return [path]


def main(argv: Sequence[str] | None = None) -> Loop:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder for the figures")
    options = parser.parse_args(argv)

    loop = run()
    print(tabulate(loop), "", *draw(loop, options.out), sep="\n")
    return loop


if __name__ == "__main__":
    main()
