"""Case 4: a parallelogram linkage that turns through its flat positions, where it could also fold into a kite."""

from functools import partial

import numpy as np

import phblocks as ph
from tests.hard.scene import Check, Outcome, Scene, assert_holds, energy_error, energy_moved, params

CASE = "Parallelogram through its flat position"
ARM, COUPLER, SPIN = 1.0, 2.0, 2.0 * np.pi  # m, m, rad/s: a turn per second
CORNERS = ((0.0, 0.0), (0.0, ARM), (COUPLER, ARM), (COUPLER, 0.0))


def moving(system: ph.System) -> ph.State:
    """Both arms turn about their pins, the coupler follows without turning."""
    parts = [
        system.rigid_motion(spin=SPIN, about=CORNERS[0], blocks=["left"]),
        system.rigid_motion((-SPIN * ARM, 0.0), blocks=["coupler"]),
        system.rigid_motion(spin=SPIN, about=CORNERS[3], blocks=["right"]),
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
    return float(np.abs((run.angle("left", s) - run.angle("left", s)[0]) - (run.angle("right", s) - run.angle("right", s)[0])).max())


def turn(young: float, turns: float) -> Outcome:
    system = flexible(young)
    run = ph.simulate(system, turns, 0.005, start=moving(system))
    early = Check("runs that ended early", float(not run.status.ok), 0)
    turned = float((run.angle("left", 0.5)[-1] - run.angle("left", 0.5)[0]) / (2.0 * np.pi * turns))
    return Outcome(
        [
            early,
            Check("arms from parallel, rad", off_branch(run, 0.5), 0.1),
            Check("turns made less turns told, relative", abs(turned - 1.0), 0.01),
            energy_error(run),
        ],
        [run],
    )


def turn_rigid(turns: float) -> Outcome:
    """On its branch to the end, or a status that says where it stopped; balanced either way."""
    system = rigid()
    run = ph.simulate(system, turns, 0.005, start=moving(system))
    silent = not (run.status.ok or (run.status.name == "step failed" and run.status.time is not None))
    centre = (0.0, 0.0)
    total = run.energy.total
    return Outcome(
        [
            Check("ends without success or a clear status", float(silent), 0),
            Check("arms from parallel, rad", off_branch(run, centre), 0.02),
            Check("energy", float(np.abs(total - total[0]).max()) / energy_moved(run), 1e-10),
        ],
        [run],
    )


SCENES = [
    *(Scene(f"E = {E:g} Pa", "3 turns", partial(turn, E, 3.0)) for E in (2.1e9, 2.1e11)),
    *(Scene(f"E = {E:g} Pa", "20 turns", partial(turn, E, 20.0), tier="slow") for E in (2.1e9, 2.1e11)),
    Scene("rigid bars, multipliers", "3 turns", partial(turn_rigid, 3.0)),
]


@params(SCENES)
def test_parallelogram(scene: Scene) -> None:
    assert_holds(scene)
