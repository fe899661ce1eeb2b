"""Case 2: the four-bar with a coupler a thousand times softer than its neighbours."""

from functools import partial

import phblocks as ph
from tests.hard.scene import Outcome, Scene, assert_holds, energy_error, finished, four_bar, params

CASE = "Four-bar with a soft coupler (2.1e8 Pa)"
OTHERS = (
    "a well-known C++ multibody code at dt 0.005 s with automatic step cutting gains energy to 7e17 J and stops at "
    "t = 4.07 s"
)


def fall(dt: float, t_end: float) -> Outcome:
    run = ph.simulate(four_bar(coupler=2.1e8), t_end, dt)
    return Outcome([finished(run), energy_error(run)], [run])


SCENES = [
    Scene("dt = 0.005 s", "3 s", partial(fall, 0.005, 3.0)),
    Scene("dt = 0.005 s", "10 s", partial(fall, 0.005, 10.0), tier="slow", others=OTHERS),
]


@params(SCENES)
def test_soft_coupler(scene: Scene) -> None:
    assert_holds(scene)
