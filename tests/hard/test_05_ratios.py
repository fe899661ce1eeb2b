"""Case 5: masses from 1e-4 kg to 1e4 kg, springs of 1e12 N/m and 1 N/m, elements of 1 mm and 1 m, in one scene."""

from functools import partial

import numpy as np

import phblocks as ph
from tests.hard.scene import Check, Outcome, Scene, assert_holds, energy_error, finished, params

CASE = "Ratios: masses 1e8, springs 1e12, elements 1000"


def diagram() -> ph.Diagram:
    """A beam pinned to the ground carries a grain and, by a hard and a soft spring, a heavy mass and another grain."""
    bar = ph.Section.rectangle(0.05, 0.05, young=2.1e11, poisson=0.3, density=2710.0)
    d = ph.Diagram("ratios", gravity=(0.0, -9.81))
    beam = d.add(
        ph.Beam(
            "beam",
            bar,
            (0.0, 0.0),
            (2.002, 0.0),
            elements=(0.0, 1.0 / 2.002, 1.001 / 2.002, 1.002 / 2.002, 1.0),
            degree=2,
        )
    )
    grain = d.add(ph.Mass("grain", 1e-4, (2.002, 0.0)))
    heavy = d.add(ph.Mass("heavy", 1e4, (3.002, 0.0)))
    far = d.add(ph.Mass("far grain", 1e-4, (3.002, -1.0)))
    hard = d.add(ph.Spring("hard", 1e12, (2.002, 0.0), (3.002, 0.0)))
    soft = d.add(ph.Spring("soft", 1.0, (3.002, 0.0), (3.002, -1.0)))
    d.pin(beam.start, d.ground)
    d.pin(beam.end, grain.centre, hard.start)
    d.pin(hard.end, heavy.centre, soft.start)
    d.pin(soft.end, far.centre)
    return d


def swing(dt: float, t_end: float) -> Outcome:
    """Energy, and the length that the hard spring knows against the distance of its ends."""
    system = diagram().compile()
    run = ph.simulate(system, t_end, dt)
    a, b = (run.position(name, (0.0, 0.0)) for name in ("grain", "heavy"))
    force = run.x[:, system.part("hard").states.start]
    gap = np.abs(np.hypot(*(b - a).T) - (1.0 + force / 1e12)).max()
    return Outcome([finished(run), energy_error(run), Check("length of the hard spring, m", float(gap), 1e-11)], [run])


SCENES = [
    Scene("dt = 0.01 s", "5 s", partial(swing, 0.01, 5.0)),
    Scene("dt = 0.001 s", "5 s", partial(swing, 0.001, 5.0), tier="slow"),
]


@params(SCENES)
def test_ratios(scene: Scene) -> None:
    assert_holds(scene)
