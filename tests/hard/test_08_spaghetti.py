"""Case 8: flying spaghetti: a free beam thrown by a force and a moment at one end, down to a rope."""

from functools import partial
from typing import Any

import numpy as np

import phblocks as ph
from tests.hard.scene import Check, Outcome, Scene, assert_holds, energy_error, energy_moved, finished, params

CASE = "Flying spaghetti"
OFF = 2.5  # s, a boundary between two steps
#: references.json, "flying_spaghetti_2d": both ends at two times.
PLACES = {2.5: ((4.9631, 4.476), (3.5832, 6.1119)), 6.0: ((11.9946, 5.8397), (12.7912, 5.6351))}


def throw(bending: float, elements: int, t_end: float, dt: float = 0.01) -> ph.Solution:
    section = ph.Section(axial=1e4, shear=1e4, bending=bending, mass=1.0, rotary=10.0)
    d = ph.Diagram("flying spaghetti")
    beam = d.add(ph.Beam("beam", section, (0.0, 8.0), (6.0, 0.0), elements=elements, degree=3))
    d.expose(beam.end.translation, "force")
    d.expose(beam.end.rotation, "moment")
    loads = {
        "force": lambda t: (8.0, 0.0) if t < OFF else (0.0, 0.0),
        "moment": lambda t: -80.0 if t < OFF else 0.0,
    }
    return ph.simulate(d.compile(), t_end, dt, inputs=loads)


def checks(run: ph.Solution) -> list[Check]:
    """Energy, and that it does not change after the load; the momentum that the force gave, 20 N s along x."""
    total, after = run.energy.total, run.t >= OFF
    mass = run.system.point_mass
    centre = np.einsum("m,tmd->td", mass, run.recording.points) / mass.sum()
    momentum = mass.sum() * np.diff(centre[after], axis=0) / np.diff(run.t[after])[:, None]
    return [
        finished(run),
        energy_error(run),
        Check("energy after the load", float(np.ptp(total[after])) / energy_moved(run), 1e-10),
        Check("momentum, relative", float(np.abs(momentum - [20.0, 0.0]).max()) / 20.0, 0.01),
    ]


def fly(bending: float, elements: int, t_end: float) -> Outcome:
    run = throw(bending, elements, t_end)
    found = checks(run)
    if bending == 1.0:
        found.pop()  # the moment curls a rope more tightly than any mesh here resolves: the momentum means nothing
    if bending == 100.0:
        error = [
            np.abs(run.position("beam", s)[round(t / 0.01)] - place).max()
            for t, ends in PLACES.items()
            for s, place in zip((1.0, 0.0), ends, strict=True)
        ]
        found.append(Check("ends at 2.5 s and 6 s from the reference, m", float(max(error)), 2e-3))
    return Outcome(found, [run])


SCENES = [
    Scene("EI = 100", "6 s, 32 elements", partial(fly, 100.0, 32, 6.0)),
    Scene("EI = 500", "6 s, 8 elements", partial(fly, 500.0, 8, 6.0)),
    Scene("EI = 1, a rope", "15 s, 16 elements", partial(fly, 1.0, 16, 15.0), tier="slow"),
    Scene("EI = 100", "15 s, 32 elements", partial(fly, 100.0, 32, 15.0), tier="slow"),
    Scene("EI = 500", "15 s, 32 elements", partial(fly, 500.0, 32, 15.0), tier="slow"),
]


@params(SCENES)
def test_spaghetti(scene: Scene) -> None:
    assert_holds(scene)


def test_reference(references: dict[str, Any]) -> None:
    """The places above are those of the reference numbers."""
    given = references["flying_spaghetti_2d"]
    for time, key in ((2.5, "t=2.5"), (6.0, "t=6")):
        assert PLACES[time] == (tuple(given[key]["loaded_end"]), tuple(given[key]["other_end"]))
