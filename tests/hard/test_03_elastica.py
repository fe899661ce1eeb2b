"""Case 3: a cantilever bent by P L^2 / (E I) = 10, from stocky to slender as a hair.

Only what the section says may change: the reference is Reissner's beam with the same extension and shear (solved as a
boundary value problem), which for a slender one is Euler's elastica of references.json.
"""

from functools import cache, partial
from math import inf
from typing import Any

import numpy as np
from scipy.integrate import solve_bvp

import phblocks as ph
from tests.hard.scene import Check, Outcome, Scene, assert_holds, energy_error, finished, params

CASE = "Elastica, P L^2/EI = 10, slenderness 1e1 to 1e6"
LOAD, RAMP, END = 10.0, 8.0, 28.0  # N with EI = 1 N m^2 and L = 1 m; s


def section(slenderness: float) -> ph.Section:
    """A square one: EA/EI = 12 slenderness^2; Poisson's number 0.3, shear factor 5/6."""
    axial = 12.0 * slenderness**2
    return ph.Section(axial=axial, shear=axial / 2.6 * 5 / 6, bending=1.0, mass=1.0, rotary=1.0 / axial)


@cache
def reference(axial: float, shear: float) -> tuple[float, float]:
    """Tip under a dead load (0, -P): Reissner (1972), doi:10.1007/BF01602645; inextensible at infinite stiffness."""

    def slope(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        angle, curvature, _, _ = y
        along, across = -LOAD * np.sin(angle), -LOAD * np.cos(angle)
        stretch, shift = 1.0 + along / axial, across / shear
        dx = stretch * np.cos(angle) - shift * np.sin(angle)
        dy = stretch * np.sin(angle) + shift * np.cos(angle)
        # M' = - (r' x n) = -(dx * (-P))
        return np.array([curvature, LOAD * dx, dx, dy])

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.array([a[0], b[1], a[2], a[3]])

    s = np.linspace(0.0, 1.0, 101)
    found = solve_bvp(slope, ends, s, np.array([-s, -1.0 + 0 * s, s, -s / 2]), tol=1e-10, max_nodes=100000)
    assert found.success
    return float(found.y[2, -1]), float(found.y[3, -1])


def press(t: float) -> tuple[float, float]:
    """The load, applied slowly and then held."""
    return 0.0, -LOAD * (0.5 - 0.5 * np.cos(np.pi * min(t, RAMP) / RAMP))


def bend(slenderness: float, internal: float = 0.0) -> Outcome:
    """Bend it; the distance of the tip from the reference after the load was held."""
    return bend_section(section(slenderness), internal)


def bend_section(s: ph.Section, internal: float = 0.0) -> Outcome:
    damping = ph.Damping(viscous=4.0, internal=internal)
    d = ph.Diagram("elastica")
    beam = d.add(ph.Beam("beam", s, (0.0, 0.0), (1.0, 0.0), elements=8, degree=3, damping=damping))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "load")
    run = ph.simulate(d.compile(), END, 0.1, inputs={"load": press}, max_halvings=0)
    tip = run.position(beam, 1.0, source="strain")[-1]
    stiff = min(s.axial, 1e14), min(float(np.min(s.shear)), 1e14)  # strains of 1e-13: no digit of the reference
    error = float(np.hypot(*(tip - reference(*stiff))))
    # the same bound for all: the error does not depend on the slenderness
    return Outcome([finished(run), Check("tip from the elastica / L", error, 1e-7), energy_error(run)], [run])


def inextensible(internal: float = 0.0) -> Outcome:
    """Neither extension nor shear: a compliance of exactly zero."""
    return bend_section(ph.Section(axial=inf, shear=inf, bending=1.0, mass=1.0, rotary=1e-12), internal)


SLENDERNESS = (1e1, 1e2, 1e3, 1e4, 1e5, 1e6)
SCENES = [
    *(
        Scene(
            f"slenderness {s:g}, EA/EI = {12 * s * s:.2g} m^-2, {name}",
            "280 steps",
            partial(bend, s, internal),
            tier="always" if s in always else "slow",
        )
        for name, internal, always in (
            ("drag", 0.0, (1e1, 1e4, 1e6)),
            ("drag and internal damping", 0.02, (1e2, 1e6)),
        )
        for s in SLENDERNESS
    ),
    Scene("compliance exactly 0, drag", "280 steps", inextensible),
    Scene("compliance exactly 0, drag and internal damping", "280 steps", partial(inextensible, 0.02)),
]


@params(SCENES)
def test_elastica(scene: Scene) -> None:
    assert_holds(scene)


def test_reference(references: dict[str, Any]) -> None:
    """The boundary value problem of a slender beam gives the elastica of the reference numbers."""
    expected = references["elastica_cantilever"]["10"]
    x, y = reference(1e12, 1e12)
    assert abs(1.0 - x - expected["u/L"]) <= 1e-9 and abs(-y - expected["w/L"]) <= 1e-9
