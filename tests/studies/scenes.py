"""Scenes of the studies; importable, so that other processes find them."""

import math

import phblocks as ph

OMEGA = 2.0  # rad/s
STRETCH = 0.1  # m


def oscillator() -> ph.System:
    """A mass on a stretched spring, released: it moves as 0.9 + 0.1 cos(2 t) along x."""
    d = ph.Diagram("oscillator")
    spring = d.add(ph.Spring("spring", OMEGA**2, (0.0, 0.0), (1.0, 0.0), free_length=1.0 - STRETCH))
    mass = d.add(ph.Mass("mass", 1.0, (1.0, 0.0)))
    d.pin(spring.start, d.ground)
    d.pin(spring.end, mass.centre)
    return d.compile()


def exact(t: float, dt: float | None = None) -> float:
    """Where the mass is, m; with a step, by the midpoint rule, which turns by 2 atan(omega dt / 2) a step."""
    omega = OMEGA if dt is None else 2.0 / dt * math.atan(0.5 * OMEGA * dt)
    return 1.0 - STRETCH + STRETCH * math.cos(omega * t)


def pendulum(elements: int = 4, degree: int = 2) -> ph.System:
    """The rubber pendulum."""
    section = ph.Section.circle(radius=0.01, young=5e6, poisson=0.5, density=1000.0, shear_factor=27.0 / 28.0)
    d = ph.Diagram("pendulum", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("beam", section, start=(0.0, 0.0), end=(1.0, 0.0), elements=elements, degree=degree))
    d.pin(beam.start, d.ground)
    return d.compile()


def cantilever(elements: int = 4, degree: int = 1) -> ph.System:
    """The thick beam of the references, clamped at its start."""
    section = ph.Section(axial=1200.0, shear=384.6153846153846, bending=1.0, mass=1.0, rotary=1.0 / 1200.0)
    d = ph.Diagram("cantilever")
    beam = d.add(ph.Beam("beam", section, start=(0.0, 0.0), end=(1.0, 0.0), elements=elements, degree=degree))
    d.weld(beam.start, d.ground)
    return d.compile()


def picky(elements: int = 4) -> ph.System:
    """A pendulum that cannot be made of 5 elements."""
    if elements == 5:
        raise ValueError("five is right out")
    return pendulum(elements)


def first_frequency(solution: ph.Solution) -> float:
    """The lowest natural frequency, rad/s."""
    return float(solution.system.modes(1).frequencies[0])


def place_of_mass(solution: ph.Solution) -> list[float]:
    """x of the oscillating mass at the times of the solution, m."""
    return list(solution.position("mass", (0.0, 0.0))[:, 0])
