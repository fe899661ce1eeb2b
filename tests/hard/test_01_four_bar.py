"""Case 1: the four-bar of the paper with steps far too long for its waves, soft as rubber and stiff as nothing is."""

from functools import partial

import phblocks as ph
from tests.hard.scene import Outcome, Scene, assert_holds, energy_error, finished, four_bar, params

CASE = "Four-bar, seven decades of stiffness"
OTHERS = "a leading C++ code with a fixed step fails at t = 1.4 to 2.1 s"


def fall(young: float, dt: float, t_end: float) -> Outcome:
    run = ph.simulate(four_bar(young), t_end, dt)
    return Outcome([finished(run), energy_error(run)], [run])


SCENES = [
    Scene(
        f"E = {young:g} Pa, dt = {dt:g} s",
        "10 s",
        partial(fall, young, dt, 10.0),
        tier="always" if young in (2.1e9, 2.1e11, 2.1e14) else "slow",
        others=OTHERS if (young, dt) == (2.1e11, 0.02) else "",
    )
    for dt in (0.02, 0.1)
    for young in (2.1e7, 2.1e8, 2.1e9, 2.1e10, 2.1e11, 2.1e12, 2.1e13, 2.1e14)
]


@params(SCENES)
def test_four_bar(scene: Scene) -> None:
    assert_holds(scene)
