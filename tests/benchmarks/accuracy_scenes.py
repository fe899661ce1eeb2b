"""The scenes of docs/accuracy.md, and the settings they are run with, in both codes."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import phblocks as ph
from examples.four_bar import build

REFERENCES = json.loads((Path(__file__).parents[1] / "references.json").read_text(encoding="utf-8"))

Mesh = Mapping[str, Any]


@dataclass(frozen=True)
class Sweep:
    """Every mesh with every step, or every tolerance; options are those of the peer."""

    name: str
    meshes: Sequence[Mesh]
    steps: Sequence[float]
    method: Any = None
    options: Mapping[str, bool] = field(default_factory=dict)
    tolerances: Sequence[float] = ()


@dataclass(frozen=True)
class Scene:
    """One scene in both codes; ``fine`` is the setting of a reference of our own."""

    name: str
    title: str
    make_system: Callable[..., ph.System]
    quantity: tuple[str, str, float]
    times: tuple[float, ...]
    t_end: float
    published: np.ndarray
    published_uncertainty: float
    fine: tuple[Mesh, float]
    ours: Sequence[Sweep]
    peer: Sequence[Sweep]
    free: float = 0.0  # s, from when on nothing supplies energy
    inputs: Mapping[str, Any] = field(default_factory=dict)
    own_reference: bool = False  # errors are measured against it, not against what is published


def four_bar(elements: tuple[int, int, int], degree: int) -> ph.System:
    """The four-bar of the README."""
    return build(elements, degree)[0].compile()


def rubber_pendulum(elements: int, degree: int = 1) -> ph.System:
    """A bar of rubber, pinned, falling from the horizontal."""
    b = REFERENCES["rubber_pendulum"]["beam"]
    poisson = b["E"] / (2.0 * b["G"]) - 1.0
    section = ph.Section.circle(b["radius"], b["E"], poisson, b["rho"], b["shear_factor"])
    d = ph.Diagram("rubber pendulum", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (b["L"], 0.0), elements, degree))
    d.pin(beam.start, d.ground)
    return d.compile()


def flying_spaghetti(elements: int, degree: int) -> ph.System:
    """A free beam with a force and a moment at one end."""
    b = REFERENCES["flying_spaghetti_2d"]["beam"]
    section = ph.Section(axial=b["EA"], shear=b["kGA"], bending=b["EI"], mass=b["rhoA"], rotary=b["rhoI"])
    d = ph.Diagram("flying spaghetti")
    beam = d.add(ph.Beam("beam", section, b["from"], b["to"], elements, degree))
    d.expose(beam.end.translation, "force")
    d.expose(beam.end.rotation, "moment")
    return d.compile()


OFF = 2.5  # s
LOADS = {
    "force": lambda t: (8.0, 0.0) if t < OFF else (0.0, 0.0),
    "moment": lambda t: -80.0 if t < OFF else 0.0,
}

BY_STEP = (
    ("Midpoint", ph.Midpoint()),
    ("GaussLegendre(2)", ph.GaussLegendre(2)),
    ("GaussLegendre(3)", ph.GaussLegendre(3)),
    ("LinearlyImplicit", ph.LinearlyImplicit()),
    ("LinearlyImplicit, 1 correction", ph.LinearlyImplicit(corrections=1)),
)


def sweeps(meshes: Sequence[Mesh], steps: Sequence[Sequence[float]], finest: Sequence[float]) -> list[Sweep]:
    """All methods on all meshes, each with its steps, and a finer step (if not 0) on the last mesh."""
    found = [Sweep(name, meshes, own, method) for (name, method), own in zip(BY_STEP, steps, strict=True)]
    more = [Sweep(n, meshes[-1:], [dt], m) for (n, m), dt in zip(BY_STEP, finest, strict=True) if dt]
    return found + more


def radau(mesh: Mesh, tolerances: Sequence[float]) -> Sweep:
    """SciPy's Radau on our system; states are saved every 0.1 s and at the times asked for."""
    method = ph.ScipyIVP("Radau", rtol=1e-3, atol=1e-3)
    return Sweep("SciPy's Radau, our system", [mesh], [0.1], method, tolerances=tolerances)


def scenes() -> tuple[Scene, ...]:
    """Describe the scenes; those of the peer have the same names."""
    path = REFERENCES["four_bar"]["P_flexible_t"]
    spaghetti = REFERENCES["flying_spaghetti_2d"]
    modified = {"modified": True}
    return (
        Scene(
            name="four_bar",
            title="Four-bar, 10 s, largest error of P at t = 1, 2, ..., 5 s",
            make_system=four_bar,
            quantity=("position", "coupler", 0.5),
            times=(1.0, 2.0, 3.0, 4.0, 5.0),
            t_end=10.0,
            published=np.array([path[str(t)] for t in range(1, 6)]),
            published_uncertainty=REFERENCES["four_bar"]["tolerance_flexible"]["t<=5"],
            fine=({"elements": (3, 2, 2), "degree": 4}, 1e-3),
            ours=[
                *sweeps(
                    [
                        {"elements": (40, 24, 24), "degree": 1},
                        {"elements": (2, 2, 2), "degree": 2},
                        {"elements": (1, 1, 1), "degree": 3},
                        {"elements": (1, 1, 1), "degree": 4},
                    ],
                    [(0.01, 0.002), (0.0125, 0.005), (0.02, 0.01), (0.005, 0.002), (0.005, 0.002)],
                    [0.001, 0.0025, 0.005, 0.001, 0.001],
                ),
                Sweep("GaussLegendre(2)", [{"elements": (2, 1, 1), "degree": 3}], [0.01, 0.005], ph.GaussLegendre(2)),
                Sweep("GaussLegendre(3)", [{"elements": (2, 1, 1), "degree": 3}], [0.02, 0.01], ph.GaussLegendre(3)),
                radau({"elements": (1, 1, 1), "degree": 4}, (1e-2, 1e-3, 3e-4)),
            ],
            peer=[
                Sweep("Exudyn", [{"elements": (4, 4, 4), "order": 1}, {"elements": (10, 6, 6), "order": 1}], [1e-3]),
                Sweep(
                    "Exudyn", [{"elements": (2, 1, 1), "order": 2}, {"elements": (3, 2, 2), "order": 2}], [1e-3, 5e-4]
                ),
                Sweep("Exudyn", [{"elements": (3, 2, 2), "order": 2}], [5e-3, 2e-3]),
                Sweep("Exudyn", [{"elements": (4, 3, 3), "order": 2}], [5e-4]),
                Sweep(
                    "Exudyn, modified Newton",
                    [{"elements": (2, 1, 1), "order": 2}, {"elements": (3, 2, 2), "order": 2}],
                    [1e-3, 5e-4, 2.5e-4],
                    options=modified,
                ),
                Sweep(
                    "Exudyn, modified Newton",
                    [{"elements": (4, 4, 4), "order": 1}, {"elements": (10, 6, 6), "order": 1}],
                    [1e-3],
                    options=modified,
                ),
            ],
        ),
        Scene(
            name="rubber_pendulum",
            title="Rubber pendulum, 1 s, error of the tip at t = 1 s",
            make_system=rubber_pendulum,
            quantity=("position", "beam", 1.0),
            times=(1.0,),
            t_end=1.0,
            published=np.array([REFERENCES["rubber_pendulum"]["tip(1)"]]),
            published_uncertainty=REFERENCES["rubber_pendulum"]["tolerance"],
            fine=({"elements": 16, "degree": 4}, 1 / 800),
            ours=[
                *sweeps(
                    [
                        {"elements": 20, "degree": 1},
                        {"elements": 80, "degree": 1},
                        {"elements": 8, "degree": 2},
                        {"elements": 4, "degree": 3},
                        {"elements": 8, "degree": 3},
                        {"elements": 4, "degree": 4},
                    ],
                    [
                        (0.02, 0.01, 0.005, 0.0025),
                        (0.05, 0.025, 0.02, 0.01),
                        (0.1, 0.05, 0.04, 0.025),
                        (0.02, 0.01, 0.005, 0.0025),
                        (0.02, 0.01, 0.005, 0.0025),
                    ],
                    [0.00125, 0.005, 0.0125, 0.00125, 0.00125],
                ),
                radau({"elements": 4, "degree": 3}, (1e-2, 1e-3, 1e-4)),
            ],
            peer=[
                Sweep(
                    name,
                    [{"elements": n, "order": 1} for n in (20, 100)]
                    + [{"elements": n, "order": 2} for n in (5, 10, 20)],
                    [0.02, 0.01, 0.005, 0.0025, 0.00125],
                    options=options,
                )
                for name, options in (("Exudyn", {}), ("Exudyn, modified Newton", modified))
            ],
        ),
        Scene(
            name="flying_spaghetti",
            title="Flying spaghetti, 6 s, largest error of the loaded end at t = 2.5 and 6 s",
            make_system=flying_spaghetti,
            quantity=("position", "beam", 1.0),
            times=(OFF, 6.0),
            t_end=6.0,
            published=np.array([spaghetti[f"t={t}"]["loaded_end"] for t in ("2.5", "6")]),
            published_uncertainty=spaghetti["tolerance"],
            fine=({"elements": 32, "degree": 4}, 0.005),
            ours=[
                *sweeps(
                    [
                        {"elements": 40, "degree": 1},
                        {"elements": 12, "degree": 2},
                        {"elements": 8, "degree": 3},
                        {"elements": 16, "degree": 4},
                    ],
                    [(0.05, 0.02, 0.01), (0.1, 0.05, 0.025), (0.1, 0.05), (0.02, 0.01), (0.02, 0.01)],
                    [0.005, 0.0125, 0.025, 0.005, 0.005],
                ),
                radau({"elements": 8, "degree": 3}, (1e-2, 1e-3, 1e-4)),
            ],
            peer=[
                Sweep(
                    name,
                    [{"elements": n, "order": 1} for n in (16, 40)]
                    + [{"elements": n, "order": 2} for n in (8, 16, 32)],
                    [0.05, 0.02, 0.01, 0.005],
                    options=options,
                )
                for name, options in (("Exudyn", {}), ("Exudyn, modified Newton", modified))
            ],
            free=OFF + 1e-6,
            inputs={"inputs": LOADS},
            own_reference=True,
        ),
    )
