"""Case 12: steps a million times too long, far too short, and changing a thousandfold within a run."""

from functools import partial

import numpy as np

import phblocks as ph
from tests.hard.scene import Check, Outcome, Scene, assert_holds, energy_error, finished, four_bar, params

CASE = "Steps: very large, very small, changing"


def fastest(system: ph.System) -> float:
    """The highest natural frequency, rad/s."""
    linear = system.linearize()
    A = linear.A.toarray() if hasattr(linear.A, "toarray") else np.asarray(linear.A)
    return float(np.abs(np.linalg.eigvals(A)).max())


def frame() -> ph.System:
    """A steel portal, hanging over under its weight and a load."""
    bar = ph.Section.rectangle(0.02, 0.02, young=2.1e11, poisson=0.3, density=7850.0)
    d = ph.Diagram("portal", gravity=(0.0, -9.81))
    left = d.add(ph.Beam("left", bar, (0.0, 0.0), (0.0, 1.0), elements=4, degree=2))
    top = d.add(ph.Beam("top", bar, (0.0, 1.0), (2.0, 1.0), elements=8, degree=2))
    d.weld(left.start, d.ground)
    d.weld(left.end, top.start)
    return d.compile()


def large(product: float, steps: int) -> Outcome:
    system = frame()
    dt = product / fastest(system)
    run = ph.simulate(system, steps * dt, dt)
    return Outcome([finished(run), energy_error(run)], [run])


def small(dt: float, steps: int) -> Outcome:
    """From rest the four-bar begins to fall; a step twenty times as long, still short, comes to the same."""
    system = four_bar()
    run, coarse = ph.simulate(system, steps * dt, dt), ph.simulate(system, steps * dt, 20 * dt)
    difference = run.x[-1] - coarse.x[-1]
    size = np.sqrt(system.energy(difference) / system.energy(run.x[-1]))
    total = run.energy.total
    return Outcome(
        [
            finished(run, coarse),
            Check("states from those of a step 20 times as long, in the energy norm", float(size), 1e-6),
            Check(
                "energy, over the 392 J that the mechanism can fall",
                float(np.abs(total - total[0]).max()) / 392.0,
                1e-13,
            ),
        ],
        [run, coarse],
    )


def changing(ratio: float) -> Outcome:
    """Steps of 0.02 s, with a burst of steps ``ratio`` times shorter in the middle of each second."""
    h = 0.02 / ratio
    times = np.concatenate([second + 0.5 + h * np.arange(1, 21) for second in range(5)])
    run = ph.simulate(four_bar(), 5.0, 0.02, times=times)
    lengths = np.diff(run.t)
    assert lengths.min() < 1.01 * h
    return Outcome([finished(run), energy_error(run)], [run])


SCENES = [
    Scene("h omega_max = 1e4", "200 steps", partial(large, 1e4, 200)),
    Scene("h omega_max = 1e6", "200 steps", partial(large, 1e6, 200)),
    Scene("dt = 1e-9 s", "1000 steps", partial(small, 1e-9, 1000)),
    Scene("dt changing by 1e3 and back, five times", "5 s", partial(changing, 1e3)),
    Scene("dt changing by 1e6 and back, five times", "5 s", partial(changing, 1e6)),
]


@params(SCENES)
def test_steps(scene: Scene) -> None:
    assert_holds(scene)
