"""Case 9: a column past Euler's load, an arch that snaps through, a follower load past Beck's."""

from functools import partial

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipk

import phblocks as ph
from tests.hard.scene import Check, Outcome, Scene, assert_holds, energy_error, energy_moved, finished, params

CASE = "Buckling, snap-through, flutter"
#: EI = 1 N m^2, L = 1 m, rho A = 1 kg/m, slenderness 1000.
SLENDER = ph.Section(axial=1.2e7, shear=4e6, bending=1.0, mass=1.0, rotary=1e-7)


def column(over: float) -> Outcome:
    """A cantilever under ``over`` times Euler's load pi^2/4, nudged aside: it comes to rest on Euler's elastica.

    ``P / P_Euler = (2 K(k) / pi)^2`` with k = sin(alpha/2), alpha the angle of the tip.
    """
    load = over * np.pi**2 / 4.0
    k = brentq(lambda k: (2.0 * ellipk(k**2) / np.pi) ** 2 - over, 1e-6, 1.0 - 1e-9)
    alpha = 2.0 * np.arcsin(k)
    d = ph.Diagram("column")
    damping = ph.Damping(viscous=2.0)
    beam = d.add(ph.Beam("column", SLENDER, (0.0, 0.0), (0.0, 1.0), elements=4, degree=3, damping=damping))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "load")

    def press(t: float) -> tuple[float, float]:
        nudge = 0.01 * np.sin(np.pi * t) if t < 1.0 else 0.0
        return nudge, -load * min(t / 2.0, 1.0)

    run = ph.simulate(d.compile(), 60.0, 0.1, inputs={"load": press}, save_every=10)
    turned = run.angle(beam, 1.0) - run.angle(beam, 0.0)
    return Outcome(
        [
            finished(run),
            Check("angle of the tip from Euler's, rad", float(abs(abs(turned[-1]) - alpha)), 1e-4),
            energy_error(run),
        ],
        [run],
    )


def arch(dt: float) -> Outcome:
    """A pinned arch of 1 m, rise 0.1 m, pushed through by a force at its crown that goes away again: it stays there."""
    span, rise = 1.0, 0.1
    radius = (span**2 / 4 + rise**2) / (2 * rise)
    curvature = -1.0 / radius
    section = ph.Section(axial=2e5, shear=8e4, bending=1.0, mass=1.0, rotary=5e-6)
    d = ph.Diagram("arch")
    damping = ph.Damping(viscous=5.0)
    halves = ph.Beam("arch", section, (0.0, 0.0), (span, 0.0), 8, 2, curvature=curvature, damping=damping).split(0.5)
    left, right = (d.add(half) for half in halves)
    d.pin(left.start, d.ground)
    d.weld(left.end, right.start)
    d.pin(right.end, d.ground)
    d.expose(left.end.translation, "crown")

    def push(t: float) -> tuple[float, float]:
        return (0.1, -80.0) if t < 2.0 else (0.0, 0.0)

    run = ph.simulate(d.compile(), 6.0, dt, inputs={"crown": push})
    height = run.position(left, 1.0, source="strain")[:, 1]
    return Outcome(
        [
            finished(run),
            Check("height of the crown at the end, m", float(height[-1]), -0.05),
            Check("movement in the last second, m", float(np.ptp(height[run.t > 5.0])), 0.01),
            energy_error(run),
        ],
        [run],
    )


def beck(load: float, t_end: float) -> tuple[ph.Solution, float]:
    """A cantilever under a follower force; the growth of its deflection, the last third over the first."""
    d = ph.Diagram("Beck's column")
    beam = d.add(ph.Beam("column", SLENDER, (0.0, 0.0), (1.0, 0.0), elements=8, degree=3))
    d.weld(beam.start, d.ground)
    follower = d.add(ph.Force("follower", (-load, 0.0), follows=True))
    d.connect(beam.end.translation, follower.port)
    d.expose(beam.end.rotation, "nudge")
    nudge = {"nudge": lambda t: 1e-4 * np.sin(np.pi * t / 0.1) if t < 0.1 else 0.0}
    run = ph.simulate(d.compile(), t_end, 0.005, inputs=nudge)
    aside = np.abs(run.position(beam, 1.0, source="strain")[:, 1])
    third = aside.size // 3
    return run, float(aside[-third:].max() / aside[:third].max())


def flutter() -> Outcome:
    """Below 20.05 EI/L^2 (Beck 1952, doi:10.1007/BF02008828) it swings, above it flutters; the ledger has its power."""
    (below, still), (above, grows) = (beck(load, 6.0) for load in (0.9 * 20.05, 1.1 * 20.05))
    power = [np.abs(run.energy.supplied).max() / energy_moved(run) for run in (below, above)]
    errors = [energy_error(run) for run in (below, above)]
    return Outcome(
        [
            finished(below, above),
            Check("growth at 0.9 of Beck's load", still, 1.5),
            Check("growth at 1.1 of Beck's load", grows, 10.0, least=True),
            Check("follower's work over the energy about", float(max(power)), 0.01, least=True),
            max(errors, key=lambda check: check.measured),
        ],
        [below, above],
    )


SCENES = [
    *(Scene(f"column at {over:g} of Euler's load", "60 s", partial(column, over)) for over in (1.1, 2.0)),
    Scene("shallow arch snaps through, dt = 0.01 s", "6 s", partial(arch, 0.01)),
    Scene("follower at 0.9 and 1.1 of Beck's load", "6 s each", flutter),
]


@params(SCENES)
def test_buckling(scene: Scene) -> None:
    assert_holds(scene)
