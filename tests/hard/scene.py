"""What a case of the suite is made of: scenes that are run, and the numbers that must hold."""

import os
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pytest

import phblocks as ph

#: Scenes of full length are run where this is set (``PHBLOCKS_FULL=1``), and recorded in the table.
FULL = os.environ.get("PHBLOCKS_FULL") == "1"

Tier = Literal["always", "slow", "full"]


@dataclass(frozen=True)
class Check:
    """A number that must hold: at most the bound, or at least."""

    what: str
    measured: float
    bound: float
    least: bool = False

    @property
    def holds(self) -> bool:
        return bool(self.measured >= self.bound if self.least else self.measured <= self.bound)

    def __str__(self) -> str:
        word = "at least" if self.least else "at most"
        missed = "" if self.holds else ", **does not hold**"
        return f"{self.what}: {self.measured:.2g} ({word} {self.bound:g}{missed})"


@dataclass(frozen=True)
class Outcome:
    """What came out: the checks, and the runs they were measured in."""

    checks: Sequence[Check]
    runs: Sequence[ph.Solution] = ()

    @property
    def halvings(self) -> int:
        return sum(run.statistics.halvings for run in self.runs)

    @property
    def iterations(self) -> np.ndarray:
        return np.concatenate([run.statistics.newton_iterations for run in self.runs] or [np.zeros(0, dtype=int)])

    def __str__(self) -> str:
        return "; ".join(map(str, self.checks))


@dataclass(frozen=True)
class Scene:
    """One row of the table.

    ``tier`` says when it is run: always, with the slow tests, or only in full length. ``others`` is what other codes
    did, where the specification of the project states it.
    """

    title: str
    length: str
    run: Callable[[], Outcome]
    tier: Tier = "always"
    others: str = ""
    #: Plain words, where the scene cannot be made to hold: the table says so, and the test holds the run to what is
    #: promised of every run, a clear status and a balance up to there.
    open: str = ""


def params(scenes: Sequence[Scene]) -> pytest.MarkDecorator:
    """Parametrise a test with scenes; those of full length only where they are asked for."""
    wanted = [scene for scene in scenes if FULL or scene.tier != "full"]
    marks = {"always": (), "slow": pytest.mark.slow, "full": pytest.mark.slow}
    return pytest.mark.parametrize(
        "scene", [pytest.param(s, id=f"{s.title}, {s.length}", marks=marks[s.tier]) for s in wanted]
    )


def assert_holds(scene: Scene) -> None:
    with warnings.catch_warnings():  # hard on purpose: what must hold is in the checks
        warnings.simplefilter("ignore", ph.errors.HealthWarning)
        outcome = scene.run()
    assert outcome.checks
    if scene.open:
        for run in outcome.runs:
            assert run.status.ok or (run.status.name == "step failed" and run.status.time is not None), run.status
            assert run.max_power_balance_error <= 1e-10 * max(1.0, energy_moved(run))
        return
    missed = [str(check) for check in outcome.checks if not check.holds]
    assert not missed, missed


def finished(*runs: ph.Solution) -> Check:
    """All runs reached their end; if not, the status is what pytest prints."""
    early = [str(run.status) for run in runs if not run.status.ok]
    return Check("runs that ended early" + "".join(f" [{text}]" for text in early), len(early), 0)


def energy_moved(run: ph.Solution) -> float:
    """The energy that is about in a run: the largest that is stored, supplied, or moved by gravity, J."""
    energy = run.energy
    series = [np.ptp(energy.gravity) if name == "gravity" else np.abs(energy[name]).max() for name in energy]
    moved = max(s for name, s in zip(energy, series, strict=True) if name != "total")
    return float(max(moved, np.finfo(float).tiny))


def energy_error(run: ph.Solution, bound: float = 1e-10) -> Check:
    """The largest miss of the balance of energy from the start on, relative to the energy that is about."""
    energy = run.energy
    balance = energy.total - energy.supplied + energy.dissipated
    assert np.isfinite(run.x).all()
    return Check("energy", float(np.abs(balance - balance[0]).max()) / energy_moved(run), bound)


def worst(checks: Sequence[Check]) -> Check:
    """The largest of checks of one kind."""
    return max(checks, key=lambda check: check.measured)


def four_bar(
    young: float = 2.1e11,
    coupler: float | None = None,
    elements: tuple[int, int, int] = (10, 6, 6),
    degree: int = 1,
) -> ph.System:
    """The four-bar of the paper (references.json); the coupler may have a stiffness of its own."""
    stiff, soft = (
        ph.Section.rectangle(0.05, 0.05, young=E, poisson=0.3, density=2710.0, shear_factor=1.0)
        for E in (young, young if coupler is None else coupler)
    )
    d = ph.Diagram("four-bar", gravity=(0.0, -9.81))
    places = ((0.0, 0.5), (2.0, 1.5), (3.5, 1.5), (2.5, 0.5))
    last = d.ground
    for i, (name, section) in enumerate((("crank", stiff), ("coupler", soft), ("rocker", stiff))):
        beam = d.add(ph.Beam(name, section, places[i], places[i + 1], elements=elements[i], degree=degree))
        d.pin(last, beam.start)
        last = beam.end
    d.pin(last, d.ground)
    return d.compile()
