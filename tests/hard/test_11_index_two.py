"""Case 11: constraints: an inconsistent start, redundant joints, a joint that is added to what moves already."""

from functools import partial

import numpy as np

import phblocks as ph
from tests.hard.scene import Check, Outcome, Scene, assert_holds, energy_error, finished, params

CASE = "Index 2: starts, redundancy, a joint added"
MASS, LENGTH = 2.0, 1.0


def rod(d: ph.Diagram, name: str, start: tuple[float, float], end: tuple[float, float]) -> ph.RigidBody:
    centre = np.add(start, end) / 2
    return d.add(ph.RigidBody(name, MASS, MASS * LENGTH**2 / 12, centre, {"start": start, "end": end}))


def alternation(run: ph.Solution) -> float:
    """How much multipliers jump up and down from step to step, over their size."""
    free = run.system.algebraic
    values = run.x[1:, free]
    jumps = np.abs(np.diff(values, n=2, axis=0)).max()
    return float(jumps / np.abs(values).max())


def inconsistent(t_end: float) -> Outcome:
    """Two rods in a row, held by multipliers; only the first one is told to turn."""
    d = ph.Diagram("double pendulum", gravity=(0.0, -9.81))
    first, second = rod(d, "first", (0.0, 0.0), (1.0, 0.0)), rod(d, "second", (1.0, 0.0), (2.0, 0.0))
    d.pin(first["start"], d.ground, multiplier=True)
    d.pin(first["end"], second["start"], multiplier=True)
    system = d.compile()
    start = system.rigid_motion(spin=3.0, blocks=["first"])
    run = ph.simulate(system, t_end, 0.005, start=start)
    # the pivot of the second rod moves at 3 m/s already: the impulse between the rods is the only unknown
    speed = 0.5 * MASS * LENGTH**2 / 3 * 9.0
    impulse = 3.0 * LENGTH / (3.0 / MASS + 4.0 / MASS)  # velocity of the ends over their compliances
    lost = 0.5 * impulse * 3.0 * LENGTH
    assert speed > lost
    return Outcome(
        [
            finished(run),
            Check(
                "energy lost by the projection from that of the impulse, relative",
                abs(run.statistics.start_energy_change / -lost - 1.0),
                1e-12,
            ),
            Check("multipliers' second difference / size", alternation(run), 0.1),
            energy_error(run),
        ],
        [run],
    )


def redundant() -> Outcome:
    """A weld and a pin between the same two bodies: refused by name, not solved by chance."""
    d = ph.Diagram("redundant")
    first, second = rod(d, "first", (0.0, 0.0), (1.0, 0.0)), rod(d, "second", (0.0, 0.0), (1.0, 0.0))
    d.weld(first["start"], second["start"], multiplier=True)
    d.pin(first["end"], second["end"], multiplier=True)
    try:
        d.compile()
    except ph.errors.ConstraintError as error:
        named = "first" in str(error) or "second" in str(error)
        return Outcome([Check("redundant joints that were not refused by name", float(not named), 0)])
    return Outcome([Check("redundant joints that were not refused by name", 1.0, 0)])


def caught(t_end: float) -> Outcome:
    """A rod falls freely for 0.3 s, then one end of it is pinned to the ground: a quarter of its energy is lost."""
    free = ph.Diagram("free", gravity=(0.0, -9.81))
    body = rod(free, "rod", (0.0, 0.0), (1.0, 0.0))
    before = ph.simulate(free.compile(), 0.3, 0.01)
    place = before.position(body, (0.0, 0.0))[-1]
    velocity = before.velocity(body, (0.0, 0.0))[-1]
    held = ph.Diagram("caught", gravity=(0.0, -9.81))
    same = rod(held, "rod", (place[0] - 0.5, place[1]), (place[0] + 0.5, place[1]))
    held.pin(same["start"], held.ground, multiplier=True)
    system = held.compile()
    after = ph.simulate(system, t_end, 0.005, start=system.rigid_motion(velocity))
    kinetic = 0.5 * MASS * float(velocity @ velocity)
    return Outcome(
        [
            finished(before, after),
            Check(
                "energy lost from a quarter, relative",
                abs(after.statistics.start_energy_change / (-kinetic / 4) - 1.0),
                1e-12,
            ),
            Check("multipliers' second difference / size", alternation(after), 0.1),
            energy_error(after),
        ],
        [before, after],
    )


SCENES = [
    Scene("inconsistent start", "5 s", partial(inconsistent, 5.0)),
    Scene("redundant constraints", "compile", redundant),
    Scene("joint added to a moving rod", "5 s", partial(caught, 5.0)),
]


@params(SCENES)
def test_index_two(scene: Scene) -> None:
    assert_holds(scene)
