"""Case 4: a parallelogram linkage that turns through its flat positions, where it could also fold into a kite."""

from functools import partial

import numpy as np

import phblocks as ph
from tests.hard.scene import Check, Outcome, Scene, assert_holds, energy_error, finished, params

CASE = "Parallelogram through its flat position"
ARM, COUPLER = 1.0, 2.0  # m
CORNERS = ((0.0, 0.0), (0.0, ARM), (COUPLER, ARM), (COUPLER, 0.0))


def moving(system: ph.System, spin: float) -> ph.State:
    """Both arms turn about their pins, the coupler follows without turning."""
    parts = [
        system.rigid_motion(spin=spin, about=CORNERS[0], blocks=["left"]),
        system.rigid_motion((-spin * ARM, 0.0), blocks=["coupler"]),
        system.rigid_motion(spin=spin, about=CORNERS[3], blocks=["right"]),
    ]
    return ph.State(sum(part.x for part in parts), system.start.theta, system.start.points)


def flexible(young: float) -> ph.System:
    bar = ph.Section.rectangle(0.05, 0.05, young=young, poisson=0.3, density=2710.0)
    d = ph.Diagram("parallelogram")
    last = d.ground
    for name, a, b in zip(("left", "coupler", "right"), CORNERS, CORNERS[1:], strict=False):
        beam = d.add(ph.Beam(name, bar, a, b, elements=4, degree=2))
        d.pin(last, beam.start)
        last = beam.end
    d.pin(last, d.ground)
    return d.compile()


def rigid() -> ph.System:
    d = ph.Diagram("parallelogram of rigid bars")
    last, mass = d.ground, 2710.0 * 0.05**2
    for name, a, b in zip(("left", "coupler", "right"), CORNERS, CORNERS[1:], strict=False):
        length = float(np.hypot(*np.subtract(b, a)))
        bar = ph.RigidBody(name, mass * length, mass * length**3 / 12, np.add(a, b) / 2, {"start": a, "end": b})
        d.add(bar)
        d.pin(last, bar["start"], multiplier=True)
        last = bar["end"]
    d.pin(last, d.ground, multiplier=True)
    return d.compile()


def off_branch(run: ph.Solution, s: float | tuple[float, float]) -> float:
    """How far the arms are from being parallel, rad."""
    left, right = run.angle("left", s), run.angle("right", s)
    return float(np.abs((left - left[0]) - (right - right[0])).max())


def turn(young: float, spin: float, dt: float, turns: float) -> Outcome:
    system = flexible(young)
    t_end = turns * 2.0 * np.pi / spin
    run = ph.simulate(system, t_end, dt, start=moving(system, spin))
    turned = float(run.angle("left", 0.5)[-1] - run.angle("left", 0.5)[0])
    return Outcome(
        [
            finished(run),
            Check("arms from parallel, rad", off_branch(run, 0.5), 0.05),
            Check("angle turned, relative", abs(turned / (2.0 * np.pi * turns) - 1.0), 0.01),
            energy_error(run),
        ],
        [run],
    )


def turn_rigid(dt: float, turns: float) -> Outcome:
    """On its branch to the end, or a status that says where it stopped; balanced either way."""
    system = rigid()
    run = ph.simulate(system, turns, dt, start=moving(system, 2.0 * np.pi))
    silent = not (run.status.ok or (run.status.name == "step failed" and run.status.time is not None))
    return Outcome(
        [
            Check("ends without success or a clear status", float(silent), 0),
            Check("arms from parallel, rad", off_branch(run, (0.0, 0.0)), 0.01),
            energy_error(run),
        ],
        [run],
    )


TURN = 2.0 * np.pi
SCENES = [
    Scene("E = 2.1e9 Pa, 1 rad/s, dt = 0.01 s", "2 turns", partial(turn, 2.1e9, 1.0, 0.01, 2.0)),
    Scene("E = 2.1e11 Pa, 1 rad/s, dt = 0.01 s", "2 turns", partial(turn, 2.1e11, 1.0, 0.01, 2.0), tier="slow"),
    Scene("E = 2.1e11 Pa, a turn a second, dt = 0.005 s", "3 turns", partial(turn, 2.1e11, TURN, 0.005, 3.0)),
    Scene(
        "E = 2.1e11 Pa, a turn a second, dt = 0.005 s",
        "20 turns",
        partial(turn, 2.1e11, TURN, 0.005, 20.0),
        tier="slow",
    ),
    Scene("rigid, multipliers, flat at the end of a step", "3 turns", partial(turn_rigid, 0.005, 3.0)),
    Scene("rigid, multipliers, flat in the middle of a step", "3 turns", partial(turn_rigid, 0.25 / 50.5, 3.0)),
]


@params(SCENES)
def test_parallelogram(scene: Scene) -> None:
    assert_holds(scene)
