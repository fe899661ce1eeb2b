"""Case 13: loads that switch, jump and spike; none at all; the smallest meshes; a diagram of two parts."""

from collections.abc import Callable
from functools import partial

import numpy as np

import phblocks as ph
from tests.hard.scene import Check, Outcome, Scene, assert_holds, energy_error, energy_moved, finished, params

CASE = "Loads that jump; smallest and separate scenes"
BAR = ph.Section.rectangle(0.02, 0.02, young=2.1e11, poisson=0.3, density=7850.0)


def cantilever(elements: int, degree: int = 2) -> tuple[ph.Diagram, ph.Beam]:
    d = ph.Diagram("cantilever")
    beam = d.add(ph.Beam("beam", BAR, (0.0, 0.0), (1.0, 0.0), elements=elements, degree=degree))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "tip")
    return d, beam


def load(signal: Callable[[float], float], method: ph.Midpoint | ph.GaussLegendre) -> Outcome:
    d, _ = cantilever(6)
    run = ph.simulate(d.compile(), 1.0, 0.002, method=method, inputs={"tip": lambda t: (0.0, signal(t))})
    return Outcome([finished(run), energy_error(run)], [run])


def switch(t: float) -> float:
    """On and off every 10 ms."""
    return -1000.0 * (round(t / 0.01 - 0.5) % 2)


def jump(t: float) -> float:
    """From 10 kN down to 10 kN up within a step."""
    return -1e4 if t < 0.3001 else 1e4


def spike(t: float) -> float:
    """Twenty thousand newtons for one step."""
    return -2e4 if 0.2999 < t < 0.3019 else 0.0


def nothing() -> Outcome:
    """Without load, weight or motion nothing happens, to the last bit."""
    d, _ = cantilever(6)
    run = ph.simulate(d.compile(), 1.0, 0.01)
    return Outcome([finished(run), Check("largest state", float(np.abs(run.x).max()), 0.0)], [run])


def one_element(degree: int) -> Outcome:
    """A cantilever of one element, clamped by its causality, under its weight."""
    d = ph.Diagram("one element", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("beam", BAR, (0.0, 0.0), (1.0, 0.0), elements=1, degree=degree))
    d.pin(beam.start, d.ground)
    d.pin(beam.end, d.add(ph.Mass("mass", 1.0, (1.0, 0.0))).centre)
    run = ph.simulate(d.compile(), 2.0, 0.01)
    return Outcome([finished(run), energy_error(run)], [run])


def one_block() -> Outcome:
    """A mass and nothing else falls as Galilei says."""
    d = ph.Diagram("one block", gravity=(0.0, -9.81))
    mass = d.add(ph.Mass("mass", 1.0, (0.0, 0.0)))
    run = ph.simulate(d.compile(), 1.0, 0.01)
    place = run.position(mass, (0.0, 0.0))
    error = np.abs(place[:, 1] + 0.5 * 9.81 * run.t**2).max()
    return Outcome([finished(run), Check("height from g t^2 / 2, m", float(error), 1e-13), energy_error(run)], [run])


def apart() -> Outcome:
    """Two pendulums that are not connected move as each does alone."""

    def add(d: ph.Diagram, name: str, at: float, degree: int) -> None:
        beam = d.add(ph.Beam(name, BAR, (at, 0.0), (at + 1.0, 0.0), elements=3, degree=degree))
        d.pin(beam.start, d.ground)

    both, runs = ph.Diagram("both", gravity=(0.0, -9.81)), []
    tips = []
    for name, at, degree in (("left", 0.0, 1), ("right", 5.0, 2)):
        alone = ph.Diagram(name, gravity=(0.0, -9.81))
        add(alone, name, at, degree)
        add(both, name, at, degree)
        runs.append(ph.simulate(alone.compile(), 1.0, 0.005))
        tips.append(runs[-1].position(name, 1.0))
    together = ph.simulate(both.compile(), 1.0, 0.005)
    error = max(np.abs(together.position(n, 1.0) - tip).max() for n, tip in zip(("left", "right"), tips, strict=True))
    scale = energy_moved(together)
    assert scale > 0.0
    return Outcome(
        [
            finished(together, *runs),
            Check("tips from those of each alone, m", float(error), 1e-11),
            energy_error(together),
        ],
        [together],
    )


SCENES = [
    *(
        Scene(
            f"{signal.__name__} of the load, {type(method).__name__}",
            "500 steps",
            partial(load, signal, method),
            tier="always" if isinstance(method, ph.Midpoint) else "slow",
        )
        for signal in (switch, jump, spike)
        for method in (ph.Midpoint(), ph.GaussLegendre(2))
    ),
    Scene("no load at all", "100 steps", nothing),
    *(Scene(f"one element of degree {k}", "200 steps", partial(one_element, k)) for k in (1, 3)),
    Scene("one block", "100 steps", one_block),
    Scene("two parts that are not connected", "200 steps", apart),
]


@params(SCENES)
def test_loads(scene: Scene) -> None:
    assert_holds(scene)
