"""How well a run went: what an exact balance of energy does not show, each with a limit, a verdict and what to do."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from phblocks.errors import HealthWarning, PhblocksError
from phblocks.results.chords import position_gaps
from phblocks.results.gaps import sizes
from phblocks.results.kinematics import imposed_known
from phblocks.results.limits import Limits
from phblocks.results.momentum import free_bodies, momentum_drift
from phblocks.system import State
from phblocks.system.findings import Finding, Findings
from phblocks.system.stability import stability_card
from phblocks.triplets import Floats, Ints

if TYPE_CHECKING:
    from phblocks.results.readings import Readings
    from phblocks.results.solution import Solution

BALANCE = "energy balance"
GAP, CLOSURE = "gap of strain and configuration", "closure of joints"
LINEAR, ANGULAR = "linear momentum of free bodies", "angular momentum of free bodies"
PARTED = (
    "Rotation within a step is too large, or the mesh too coarse: take a smaller dt (gaps fall with its square), or, "
    "for curved beams, more elements or a higher degree."
)
UNTOLD = (
    "How far imposed motions had come by the start is not part of a state: start in the initial configuration, or "
    "resume a saved run."
)
#: Saved times at which positions are compared, evenly spread: these cost a fixed time a run.
TIMES = 33
#: Multipliers that are smaller than this part of the largest do not matter, nor do those that are smaller than this
#: part of what would move all the energy there is within a step.
MINOR, QUIET = 0.05, 1e-6
#: Energies below this part of weight times height are lost in its round-off.
LIGHT = 1e-6
#: Shorter runs are judged by their balance only.
FEWEST = 20
#: Positions are looked at unasked in runs of so many steps for every block: they cost some 0.1 ms a block.
STEPS_A_BLOCK = 4
#: All is held by joints where the energy is smaller than this, relative to what their forces could move in a step.
HELD = 1e-20


class Health:
    """The health of a run; it prints as a table.

    Parameters
    ----------
    run : Readings
        The run.
    limits : Limits
        What may be.
    """

    def __init__(self, run: Readings, limits: Limits) -> None:
        self._run, self.limits = run, limits

    def judged(self, limits: Limits) -> Health:
        """Judge the same run by other limits.

        Parameters
        ----------
        limits : Limits
            They.

        Returns
        -------
        Health
            Of the same run.
        """
        return Health(self._run, limits)

    @cached_property
    def watched(self) -> Findings:
        """What is looked at after every run: positions of many blocks only if it has steps enough to pay for them."""
        return Findings([*self._judged_steps, *(self._positions if self._pays else [])])

    @cached_property
    def findings(self) -> Findings:
        """All of it, with frequencies and condition at the end of the run, which are found when first asked for."""
        return Findings([*self._judged_steps, *self._positions, *_of_frequencies(self._run)])

    @property
    def _pays(self) -> bool:
        return bool(self._run.statistics.steps >= STEPS_A_BLOCK * len(self._run.labels.blocks))

    @cached_property
    def _judged_steps(self) -> Sequence[Finding]:
        return self._limited(self._of_steps())

    @cached_property
    def _positions(self) -> Sequence[Finding]:
        return self._limited(_of_positions(self._run, self.limits))

    def _limited(self, findings: Sequence[Finding]) -> Sequence[Finding]:
        """In runs of less than 20 steps only balances have a limit."""
        if self._run.statistics.steps >= FEWEST:
            return findings
        return [f if f.name.startswith(BALANCE) else replace(f, limit=None) for f in findings]

    def __getitem__(self, name: str) -> Finding:
        """Return one by its name."""
        return self.watched[name] if name in {f.name for f in self.watched} else self.findings[name]

    @property
    def ok(self) -> bool:
        """Whether nothing that is looked at after every run is above its limit."""
        return self.watched.ok

    def to_json(self) -> dict[str, object]:
        """Describe it by texts and numbers.

        Returns
        -------
        dict
            Name, status and findings.
        """
        run = self._run
        return {"name": run.labels.name, "status": run.status.name, "findings": self.findings.to_json()}

    def __str__(self) -> str:
        """Format it as a table."""
        return f"{self._run.labels.name}: {self._run.status.name}\n{self.findings}"

    def __repr__(self) -> str:
        """Return the table."""
        return str(self)

    def warn(self, stacklevel: int) -> None:
        """Warn if something is above its limit.

        Parameters
        ----------
        stacklevel : int
            How many callers up the warning belongs.
        """
        if self.watched.over:
            text = " ".join(str(finding) for finding in self.watched.over)
            warnings.warn(
                f"run of {self._run.labels.name!r}: {text} See solution.health.", HealthWarning, stacklevel + 1
            )

    @property
    def _step(self) -> float:
        """The mean step, s."""
        run = self._run
        return float(run.t[-1] - run.t[0]) / max(int(run.statistics.steps), 1) or 1.0

    @property
    def _held(self) -> bool:
        """Whether nothing can move, so that the energy is nothing but round-off of the forces of joints."""
        sums, steps = self._run.recording.sums, max(int(self._run.statistics.steps), 1)
        force = float(sums.carried.max(initial=0.0)) / steps
        return bool(2.0 * sums.energy[0] <= HELD * force * self._step**2)

    def _of_steps(self) -> Sequence[Finding]:
        """What the sums over all steps and the counts tell."""
        run, limits = self._run, self.limits
        sums, statistics = run.recording.sums, run.statistics
        energy, step, whole, weight = (0.0 if self._held else float(e) for e in sums.energy)
        energy = max(energy, LIGHT * weight)
        iterations = statistics.newton_iterations
        steps = max(int(statistics.steps), 1)
        return [
            Finding(
                f"{BALANCE}, worst step",
                _ratio(step, energy),
                limit=limits.balance,
                where=run.power.worst[0],
                time=float(sums.when[0]),
                advice="Make Newton's tolerance smaller; methods that do not keep energy need a smaller dt.",
            ),
            Finding(
                f"{BALANCE}, whole run",
                _ratio(whole, energy),
                limit=limits.balance,
                time=float(sums.when[1]),
                advice="Residuals of steps add up: make Newton's tolerance smaller, or use a method that keeps energy.",
            ),
            self._unresolved(),
            *([self._alternation()] if sums.multipliers.size else []),
            Finding(
                "halvings a step",
                statistics.halvings / steps,
                limit=limits.halvings,
                advice="Newton's method fails at this step: take a smaller dt.",
            ),
            Finding("Newton iterations a step, mean", float(iterations.mean()) if iterations.size else 0.0),
            Finding("Newton iterations a step, most", float(iterations.max(initial=0))),
        ]

    def _unresolved(self) -> Finding:
        """Energy that the stages miss: of an undamped mode ``(h omega / 2)^2 / (1 + (h omega / 2)^2)`` of its own."""
        sums, blocks = self._run.recording.sums, self._run.labels.blocks
        share = 0.0 if self._held else max(_ratio(float(sums.missed.sum()), float(sums.held.sum())), 0.0)
        return Finding(
            "unresolved share of energy",
            share,
            limit=self.limits.unresolved,
            where=blocks[int(sums.missed.argmax())] if sums.missed.size and share > 0.0 else "",
            advice="The step is too long for the oscillations that hold this energy: take a smaller dt, or damp them.",
        )

    def _alternation(self) -> Finding:
        """The part of each multiplier that changes sign from step to step; of all the largest."""
        run, steps = self._run, max(int(self._run.statistics.steps), 1)
        sums = run.recording.sums
        # in units of state_scale a force of this size brings in all the energy there is within a step
        most = 2.0 * float(sums.energy[0]) / self._step**2
        floor = max(MINOR**2 * float(sums.carried.max()), steps * QUIET**2 * most, np.finfo(float).tiny)
        part = np.sqrt(sums.alternating / np.maximum(sums.carried, floor))
        worst = int(part.argmax())
        return Finding(
            "multiplier alternation",
            float(part[worst]),
            limit=self.limits.alternation,
            where=run.labels.state_names[sums.multipliers[worst]],
            advice="An imposed velocity jumps, or the motion has waves that dt does not resolve: make it smooth, take "
            "a smaller dt, a little internal damping, or method=ph.RadauIIA(3).",
        )


def judged(solution: Solution, limits: Limits) -> Solution:
    """Give a run its limits, and warn if it reached its end and is above one.

    Parameters
    ----------
    solution : Solution
        As it was carried out.
    limits : Limits
        What may be.

    Returns
    -------
    Solution
        The same run.
    """
    solution = replace(solution, limits=limits)
    if solution.status.ok and limits.any:
        solution.health.warn(stacklevel=3)
    return solution


def _of_positions(run: Readings, limits: Limits) -> Sequence[Finding]:
    """Gaps and momenta, where the system of the run is known and there are any; in a linear one frames do not turn."""
    system = getattr(run, "system", None)
    if system is None:
        why = "Needs the system: ph.read(path, system)."
        return [Finding(name, None, advice=why) for name in (GAP, CLOSURE, LINEAR, ANGULAR)]
    solution: Solution = run  # type: ignore[assignment]
    turning_in_space = [part.name for part in system.parts if part.form.unoriented]
    if turning_in_space:
        why = "Needs orientations that turn in space, which are not computed: keep spin times dt below 0.3."
        return [Finding(name, None, where=turning_in_space[0], advice=why) for name in (GAP, CLOSURE, LINEAR, ANGULAR)]
    thin, size = solution.sliced(evenly(solution.t.size, TIMES)), sizes(system)
    largest = max(size.values(), default=0.0)
    blocks, joints = ({}, {}) if system.linear or not largest else position_gaps(system, thin.recording)
    drifts = {body.name: momentum_drift(thin, body) for body in free_bodies(system)}
    kept = "The scheme keeps momentum to second order in dt only: take a smaller dt."
    series: Sequence[tuple[str, Mapping[str, Floats], float, str]] = [
        (GAP, {b: g / size[b] for b, g in blocks.items() if b in size}, limits.gap, PARTED),
        (CLOSURE, {j: g / (_size_at(j, size) or largest) for j, g in joints.items()}, limits.closure, PARTED),
        (LINEAR, {body: linear for body, (linear, _) in drifts.items()}, limits.momentum, kept),
        (ANGULAR, {body: own for body, (_, own) in drifts.items() if own is not None}, limits.momentum, kept),
    ]
    found = [_worst(name, thin.t, of, limit, advice) for name, of, limit, advice in series if of]
    if blocks and not joints and not imposed_known(system, thin.recording) and any(s.inputs for s in system.sites):
        found.append(Finding(CLOSURE, None, advice=UNTOLD))
    return found


def _of_frequencies(run: Readings) -> Sequence[Finding]:
    """What the linearisation at the end tells, for the mean step."""
    system = getattr(run, "system", None)
    if system is None or run.statistics.steps == 0:
        return []
    last = State(run.recording.x[-1], run.recording.theta[-1], run.recording.points[-1])
    wanted = ("h omega_max", "unresolved modes, h omega > 1", "condition of the Newton matrix")
    try:
        card = stability_card(system, float(run.t[-1] - run.t[0]) / run.statistics.steps, last)
    except PhblocksError as error:  # there is no linearisation at the end of the run
        return [Finding(name, None, advice=str(error)) for name in wanted]
    return [card.findings[name] for name in wanted]


def evenly(count: int, most: int) -> Ints:
    """Choose numbers that are evenly spread, the first and the last among them.

    Parameters
    ----------
    count : int
        How many there are.
    most : int
        How many are wanted.

    Returns
    -------
    numpy.ndarray
        Ascending.
    """
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))


def _worst(name: str, t: Floats, series: Mapping[str, Floats], limit: float, advice: str) -> Finding:
    """The largest of several series."""
    worst = max(series, key=lambda key: float(series[key].max()))
    i = int(series[worst].argmax())
    return Finding(name, float(series[worst][i]), limit=limit, where=worst, time=float(t[i]), advice=advice)


def _size_at(joint: str, size: Mapping[str, float]) -> float:
    """Of the largest block that a joint joins, by the paths of its anchors."""
    return max((s for block, s in size.items() if f"{block}." in joint), default=0.0)


def _ratio(value: float, whole: float) -> float:
    return value / whole if whole > 0.0 else 0.0
