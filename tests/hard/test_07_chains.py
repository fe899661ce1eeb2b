"""Case 7: ends that get faster and faster: a folded chain that falls, and a whip."""

from functools import partial
from itertools import pairwise

import numpy as np

import phblocks as ph
from phblocks.solvers.midpoint import MidpointStepper
from phblocks.solvers.step import Step
from phblocks.system import System
from phblocks.triplets import Floats
from tests.hard.scene import Check, Outcome, Scene, assert_holds, energy_error, finished, params

CASE = "Falling folded chain, and a whip"
GRAVITY = 9.81


class Watched:
    """The midpoint rule, with the residual of each accepted step written down."""

    order = 2

    def __init__(self) -> None:
        self.residuals: list[float] = []

    def prepare(self, system: System) -> "WatchedStepper":
        return WatchedStepper(system, self.residuals)


class WatchedStepper(MidpointStepper):
    """Takes the steps; a residual is relative to the momentum and the strain that a step deals with."""

    def __init__(self, system: System, residuals: list[float]) -> None:
        super().__init__(system, ph.Midpoint().newton, True)
        self._residuals = residuals

    def step(self, x: Floats, theta: Floats, dt: float, u: Floats, guess: Floats | None = None) -> Step | None:
        step = super().step(x, theta, dt, u, guess)
        if step is not None:
            residual = np.linalg.norm(self.stage.residual(step.z[0]))
            self._residuals.append(float(residual * dt / 2.0 / np.linalg.norm(step.z[0])))
        return step


def chain(links: int) -> ph.Diagram:
    """A chain of 1 m of flexible links, both ends up: one is held, the other one is let go."""
    rope = ph.Section(axial=1e4, shear=1e4, bending=1e-3, mass=0.1, rotary=1e-6)
    h = 1.0 / links
    half = links // 2
    places = [(0.0, -h * i) for i in range(half + 1)] + [(h, -h * (half - i)) for i in range(half)]
    d = ph.Diagram("folded chain", gravity=(0.0, -GRAVITY))
    last = d.ground
    for i, (a, b) in enumerate(pairwise(places)):
        link = d.add(ph.Beam(f"link {i}", rope, a, b, elements=1))
        d.pin(last, link.start)
        last = link.end
    return d


def fall(links: int, dt: float, t_end: float) -> Outcome:
    d = chain(links)
    method = Watched()
    run = ph.simulate(d.compile(), t_end, dt, method=method)
    tip = run.position(f"link {links - 1}", 1.0)[:, 1]
    drop = tip[0] - tip
    on_its_way = (run.t > 0.2) & (run.t < 0.45)
    ahead = float((drop[on_its_way] / (0.5 * GRAVITY * run.t[on_its_way] ** 2)).max())
    return Outcome(
        [
            finished(run),
            Check("tip's fall over a free fall", ahead, 1.05, least=True),
            Check(
                "speed of the tip over that of free fall from its height",
                float(
                    np.linalg.norm(run.velocity(f"link {links - 1}", 1.0), axis=1).max()
                    / np.sqrt(2 * GRAVITY * drop.max())
                ),
                1.1,
                least=True,
            ),
            energy_error(run),
            Check("residual of any accepted step, relative", max(method.residuals), 1e-11),
        ],
        [run],
    )


def whip(pieces: int, dt: float, t_end: float) -> Outcome:
    """A tapered lash of 2 m, its root turned by a stroke of the hand."""
    d = ph.Diagram("whip")
    at = np.linspace(0.0, 2.0, pieces + 1)
    last = None
    for i in range(pieces):
        radius = 0.01 * (1.0 - 0.9 * i / (pieces - 1))
        area = np.pi * radius**2
        section = ph.Section(
            axial=1e8 * area,
            shear=3e7 * area,
            bending=1e7 * area * radius**2 / 4,
            mass=1e3 * area,
            rotary=1e3 * area * radius**2 / 4,
        )
        piece = d.add(ph.Beam(f"piece {i}", section, (at[i], 0.0), (at[i + 1], 0.0), elements=2, degree=2))
        if last is None:
            d.pin(piece.start, d.ground)
            d.expose(piece.start.rotation, "hand", imposes="angular velocity")
        else:
            d.weld(last.end, piece.start)
        last = piece

    def stroke(t: float) -> float:
        return 30.0 * np.sin(2.0 * np.pi * t / 0.2) if t < 0.2 else 0.0

    method = Watched()
    run = ph.simulate(d.compile(), t_end, dt, method=method, inputs={"hand": stroke})
    speed = np.linalg.norm(run.velocity(f"piece {pieces - 1}", 1.0), axis=1).max()
    return Outcome(
        [
            finished(run),
            Check("speed of the tip over that of a rigid rod", float(speed) / 60.0, 1.5, least=True),
            energy_error(run),
            Check("residual of any accepted step, relative", max(method.residuals), 1e-11),
        ],
        [run],
    )


SCENES = [
    Scene("folded chain, 12 links", "0.45 s", partial(fall, 12, 0.001, 0.45)),
    Scene("folded chain, 16 links", "0.5 s", partial(fall, 16, 0.001, 0.5), tier="slow"),
    Scene("folded chain, 32 links", "1.5 s", partial(fall, 32, 0.001, 1.5), tier="slow"),
    Scene("whip, 4 pieces", "0.3 s", partial(whip, 4, 0.001, 0.3)),
    Scene("whip, 8 pieces", "0.6 s", partial(whip, 8, 0.001, 0.6), tier="slow"),
]


@params(SCENES)
def test_chains(scene: Scene) -> None:
    assert_holds(scene)
