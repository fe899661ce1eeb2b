"""Case 10: so many steps that a trend would show: the error of energy grows like the root of their number."""

from functools import partial

import numpy as np

import phblocks as ph
from tests.hard.scene import Check, Outcome, Scene, assert_holds, energy_moved, finished, four_bar, params

CASE = "Long runs: no trend in the energy"


def pendulum() -> ph.System:
    """A mass on a spring, swinging and stretching under gravity."""
    d = ph.Diagram("elastic pendulum", gravity=(0.0, -9.81))
    spring = d.add(ph.Spring("spring", 200.0, (0.0, 0.0), (1.0, 0.0)))
    mass = d.add(ph.Mass("mass", 1.0, (1.0, 0.0)))
    d.pin(spring.start, d.ground)
    d.pin(spring.end, mass.centre)
    return d.compile()


def drift(run: ph.Solution) -> list[Check]:
    """The error of energy in units of round-off times the root of the number of steps: a walk, not a march.

    An error of half an ulp a step in one direction would give ``sqrt(N) / 4``: 250 after 1e6 steps.
    """
    steps, eps = run.statistics.steps, np.finfo(float).eps
    error = run.energy.total - run.energy.total[0]
    unit = eps * np.sqrt(steps) * energy_moved(run)
    slope = float(np.polyfit(run.t / run.t[-1], error, 1)[0])
    return [
        finished(run),
        Check("energy / (eps sqrt(N))", float(np.abs(error).max() / unit), 20.0),
        Check("its trend over the run / (eps sqrt(N))", abs(slope) / unit, 20.0),
    ]


def swing(steps: int) -> Outcome:
    run = ph.simulate(pendulum(), 0.01 * steps, 0.01, save_every=max(1, steps // 1000), progress=False)
    return Outcome(drift(run), [run])


def fall(steps: int) -> Outcome:
    run = ph.simulate(four_bar(), 0.02 * steps, 0.02, save_every=max(1, steps // 1000), progress=False)
    return Outcome(drift(run), [run])


SCENES = [
    Scene("elastic pendulum", "3000 steps", partial(swing, 3000)),
    Scene("elastic pendulum", "3e4 steps", partial(swing, 30000), tier="slow"),
    Scene("elastic pendulum", "1e6 steps", partial(swing, 10**6), tier="full"),
    Scene("four-bar, dt = 0.02 s", "1e3 steps", partial(fall, 10**3)),
    Scene("four-bar, dt = 0.02 s", "1e4 steps", partial(fall, 10**4), tier="slow"),
    Scene("four-bar, dt = 0.02 s", "1e5 steps", partial(fall, 10**5), tier="full"),
]


@params(SCENES)
def test_long_runs(scene: Scene) -> None:
    assert_holds(scene)
