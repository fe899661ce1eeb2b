"""What a scene calls for: the scene with one effect after another left out, and what that costs and saves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from statistics import median
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from phblocks.approximation import Approximation
from phblocks.blocks.checks import require_real
from phblocks.errors import ArgumentTypeError, DataError, PhblocksError, StudyError, UnreachedError
from phblocks.simulation import simulate
from phblocks.studies.execution import carry_out
from phblocks.studies.machine import Machine
from phblocks.studies.measurement import QUIETLY, Measurement
from phblocks.studies.quantity import Observed, Quantity, distance, observe
from phblocks.studies.run import Job, MakeSystem, Setting
from phblocks.studies.settings import name_of, named_methods, positive_values, require_function
from phblocks.studies.shares import EffectShares, effect_shares
from phblocks.studies.table import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WHERE = "effects"
#: What the full system is called in the table.
FULL = "nothing"
#: Effects that are tried for all blocks that hardly need them together; flexibility is tried block by block.
TOGETHER = ("extension", "shear", "rotary_inertia", "internal_damping", "gravity", "large_rotation")
#: Effects with larger shares are not tried: of the energy, and for large rotations in rad.
WORTH_TRYING = {"gravity": 0.01, "large_rotation": 0.1, "internal_damping": 0.05}
MOST_SHARE = 0.25
#: Part of the tolerance that the error of the steps may be.
NUMERICAL = 0.2

#: What is left out, by the name of the block.
Choice = Mapping[str, Approximation]


@dataclass(frozen=True, kw_only=True)
class EffectRun(Machine):
    """The scene without some effects.

    Parameters
    ----------
    left_out : str
        What is left out; "nothing" is the full system.
    unknowns, unknowns_saved : int
        Of the system, and how many fewer than of the full one.
    states, states_saved : int
        The same for those that carry energy: what is left out may remain as a constraint.
    dt : float
        The largest of the steps whose error is a fifth of the tolerance, s; otherwise the smallest one.
    numerical_error : float
        Estimate of the error of this step, in the unit of the quantity.
    change : float
        Of the quantity, with the smallest step: what leaving out does to it.
    error : float
        Distance from the full system with the smallest step, with its numerical error added: what the row costs.
    energy_share : float
        Share of what is left out in the energy of the full system, see :class:`~phblocks.studies.shares.Share`.
    seconds : float
        Median over the repeats of the time ``simulate`` took with this step, s.
    time_saved : float
        Seconds of the full system over these.
    newton_iterations, steps, repeats : int
        Of a timed run; how often it was timed.
    within : bool
        Whether the error is within the tolerance.
    status, status_text : str
        How the run ended.
    tolerance : float
        Of the quantity.
    quantity, unit, method : str
        What was judged, and how it was integrated.
    shared_machine : bool
        Whether runs may have disturbed each other's times.
    """

    left_out: str
    unknowns: int
    unknowns_saved: int
    states: int
    states_saved: int
    dt: float = field(metadata={"unit": "s"})
    numerical_error: float
    change: float
    error: float
    energy_share: float
    seconds: float
    time_saved: float = field(metadata={"unit": "times"})
    newton_iterations: int
    steps: int
    repeats: int
    within: bool
    status: str
    status_text: str
    tolerance: float
    quantity: str
    unit: str
    method: str
    shared_machine: bool


@dataclass(frozen=True, repr=False)
class EffectsStudy(Table[EffectRun]):
    """The full system, then the system without each effect, then combinations.

    Parameters
    ----------
    rows : tuple of EffectRun
        The runs.
    choices : mapping
        For each row, by ``left_out``, what to give to ``compile(approximation=...)``; not in the CSV file.
    shares : EffectShares, optional
        The estimate that chose what to try; not in the CSV file.
    """

    choices: Mapping[str, Choice] = field(default_factory=dict, compare=False)
    shares: EffectShares | None = field(default=None, compare=False)

    row_type: ClassVar[type[EffectRun]] = EffectRun
    shown: ClassVar[tuple[str, ...]] = (
        *("left_out", "unknowns", "states", "states_saved", "dt", "seconds", "time_saved"),
        *("change", "numerical_error", "error", "energy_share", "within", "status"),
    )

    @property
    def notes(self) -> tuple[str, ...]:
        """What was judged and how, and on which machine."""
        if not self.rows:
            return ()
        first = self.rows[0]
        units = f" {first.unit}" if first.unit else ""
        notes = [
            f"Tolerance {first.tolerance:g}{units} of {first.quantity}; {first.method}, for each row the largest step "
            f"whose own error is below {NUMERICAL * first.tolerance:.2g}{units}.",
            f"Seconds: simulate only, one thread, median of {first.repeats}.",
        ]
        if first.numerical_error > NUMERICAL * first.tolerance:
            notes.append("The full system is not resolved to that by any of the steps: give smaller ones.")
        with suppress(UnreachedError):
            best = self.cheapest
            saved = f"{best.time_saved:.1f} times as fast"
            notes.append(f"Cheapest within {first.tolerance:g}{units}: without {best.left_out}, {saved}.")
        notes += [f"Machine: {row}." for row in dict.fromkeys(str(_machine(r)) for r in self.rows)]
        return (*notes, *(f"Failed: {row.left_out}: {row.status_text}" for row in self.rows if row.status != "success"))

    @property
    def cheapest(self) -> EffectRun:
        """The fastest row within the tolerance.

        Raises
        ------
        UnreachedError
            If none is, not even the full system.
        """
        fine = [row for row in self.rows if row.within]
        if not fine:
            best = min((row.error for row in self.rows if not math.isnan(row.error)), default=math.nan)
            raise UnreachedError(
                "cheapest set of effects",
                expected=f"an error within {self.rows[0].tolerance:g}" if self.rows else "rows",
                got=f"at best {best:g}",
                fix="Give smaller steps: not even the full system is resolved.",
            )
        return min(fine, key=lambda row: row.seconds)

    def choice_of(self, row: EffectRun) -> Choice:
        """Look up what a row leaves out.

        Parameters
        ----------
        row : EffectRun
            Of this study.

        Returns
        -------
        mapping of str to Approximation
            To be given to ``compile(approximation=...)``.
        """
        return self.choices[row.left_out]

    def plot(self) -> Axes:
        """Draw error made against time saved, see ``ph.plots.effects``.

        Returns
        -------
        matplotlib.axes.Axes
            In a new figure.
        """
        from phblocks.plots import effects as draw

        return draw(self)


def effects(
    make_system: MakeSystem,
    quantity: Quantity,
    tolerance: float,
    *,
    t_end: float,
    steps: Iterable[float],
    times: ArrayLike | None = None,
    method: object | None = None,
    candidates: Mapping[str, Choice] | None = None,
    repeats: int = 5,
    unit: str = "",
    executor: Executor | None = None,
    progress: bool | None = None,
    **arguments: Any,
) -> EffectsStudy:
    """Find out which effects a scene calls for, to a tolerance of a quantity.

    One run of the full system tells the share that each effect has in the energy; effects with large shares are not
    tried. Of the others each is left out alone, then all together that were within the tolerance alone, and as long as
    that is too much the one that changed most comes back: so there are about twice as many systems as candidates, not
    two to their power. Every system is run with all steps and judged with the largest that is accurate enough for it,
    so that none is better or worse for its step.

    Parameters
    ----------
    make_system : callable
        Takes ``approximation``, a mapping from names of blocks to approximations, and returns a compiled system:
        ``lambda approximation: build().compile(approximation=approximation)``.
    quantity : callable or tuple
        What must not change, see :func:`~phblocks.studies.work_precision`.
    tolerance : float
        By how much it may, in its unit.
    t_end : float
        Duration of the runs, s.
    steps : iterable of float
        Steps, s, two or more; they should divide ``times``.
    times : array_like, optional
        When the quantity is taken, s; by default as in :func:`~phblocks.studies.work_precision`.
    method : Method, optional
        Time method; by default what ``simulate`` chooses.
    candidates : mapping, optional
        What to leave out, by a name for the table: ``{"rigid crank": {"crank": ph.Approximation(flexible=False)}}``. By
        default what the shares say is worth trying.
    repeats : int, optional
        How often each row is timed.
    unit : str, optional
        Of a quantity that is a function.
    executor : concurrent.futures.Executor, optional
        Does the runs elsewhere or side by side, see ``processes``.
    progress : bool, optional
        Show a progress bar; by default if a terminal is attached and it takes longer than a second.
    **arguments : object
        More arguments of ``simulate`` for all runs, such as ``inputs``.

    Returns
    -------
    EffectsStudy
        A row for the full system, one for each candidate and each combination; see its ``cheapest``.

    Raises
    ------
    DataError, ArgumentTypeError, UnknownNameError
        If an argument is out of its range, of the wrong kind or unknown, or ``make_system`` leaves nothing out.
    StudyError
        If the full system cannot be run.
    """
    require_function(f"{WHERE} make_system", make_system)
    t_end, tolerance = require_real(f"{WHERE} t_end", t_end), require_real(f"{WHERE} tolerance", tolerance)
    for name, value in (("t_end", t_end), ("tolerance", tolerance)):
        if not value > 0.0:
            raise DataError(f"{WHERE} {name}", expected="a number > 0", got=repr(value), fix="Correct it.")
    if isinstance(repeats, bool) or not isinstance(repeats, int) or repeats < 1:
        raise DataError(f"{WHERE} repeats", expected="an integer >= 1", got=repr(repeats), fix="Correct it.")
    sizes = sorted(positive_values(f"{WHERE} steps", steps, least=2), reverse=True)
    ((label, options),) = named_methods(WHERE, [method], arguments).items()
    observed = observe(WHERE, quantity, times, t_end, unit)
    audit = _Audit(make_system, observed, tolerance, t_end, sizes, options, executor, progress)
    shares = audit.estimate()
    singles = _worth_trying(shares) if candidates is None else _required(candidates)
    audit.require_listening(singles)
    audit.run({FULL: {}, **singles})
    full = audit.trials[FULL]
    if not full.ok:
        raise StudyError(
            f"{WHERE} full system",
            expected="runs that reach their end",
            got=f"{full.status}: {full.status_text}",
            fix="Correct the scene, or give smaller steps.",
        )
    audit.combine(singles)
    return EffectsStudy(audit.rows(shares, label or name_of(method), repeats), audit.choices, shares)


def _worth_trying(shares: EffectShares) -> dict[str, Choice]:
    """Candidates by name: each effect in all blocks that hardly need it, and each flexible block taken for rigid."""
    found: dict[str, Choice] = {}
    for effect in TOGETHER:
        most = WORTH_TRYING.get(effect, MOST_SHARE)
        blocks = [block for block, share in shares.of(effect).items() if share <= most]
        if blocks:
            options: dict[str, Any] = {effect: False, "insist": effect == "large_rotation"}
            some = "" if len(blocks) == len(shares.of(effect)) else f" of {', '.join(map(repr, blocks))}"
            found[effect + some] = dict.fromkeys(blocks, Approximation(**options))
    for block, share in shares.of("flexible").items():
        if share <= MOST_SHARE:
            found[f"flexible {block!r}"] = {block: Approximation(flexible=False)}
    return found


def _required(candidates: object) -> dict[str, Choice]:
    if not isinstance(candidates, Mapping) or not all(isinstance(choice, Mapping) for choice in candidates.values()):
        raise ArgumentTypeError(
            f"{WHERE} candidates",
            expected="a dict of dicts of approximations",
            got=repr(candidates),
            fix='Such as {"rigid crank": {"crank": ph.Approximation(flexible=False)}}.',
        )
    return {str(name): choice for name, choice in candidates.items()}


def merged(choices: Iterable[Choice]) -> dict[str, Approximation]:
    """Leave out everything that any of several choices leaves out.

    Parameters
    ----------
    choices : iterable of mapping
        Approximations by the name of the block.

    Returns
    -------
    dict
        The same for all of them together.
    """
    together: dict[str, Approximation] = {}
    for choice in choices:
        for block, approximation in choice.items():
            known = together.get(block)
            if known is not None:
                gone = {name: value for name, value in asdict(approximation).items() if value is not True}
                gone["insist"] = known.insist or approximation.insist
                approximation = replace(known, **gone)
            together[block] = approximation
    return together


@dataclass
class _Trial:
    """Runs of one system with all steps, from large to small."""

    steps: Sequence[float]
    runs: Sequence[Measurement]

    @property
    def ok(self) -> bool:
        """Whether the two smallest steps came to their end."""
        return all(run.ok for run in self.runs[-2:])

    @property
    def status(self) -> str:
        return next((run.status for run in self.runs[-2:] if not run.ok), "success")

    @property
    def status_text(self) -> str:
        return next((run.status_text for run in self.runs[-2:] if not run.ok), "")

    @property
    def finest(self) -> np.ndarray[Any, Any]:
        value = self.runs[-1].value
        assert value is not None
        return value

    def numerical_error(self, i: int) -> float:
        """Estimate the error of a step: distance from the smallest one, and a third of what that changed last."""
        value, before = self.runs[i].value, self.runs[-2].value
        if value is None or before is None:
            return math.nan
        return distance(value, self.finest) + distance(self.finest, before) / 3.0

    def accurate_enough(self, most: float) -> int:
        """Find the largest step with at most this error; the smallest one if there is none."""
        fine = [i for i in range(len(self.steps)) if self.numerical_error(i) <= most]
        return fine[0] if fine else len(self.steps) - 1


class _Audit:
    """All runs of one study."""

    def __init__(
        self,
        make_system: MakeSystem,
        observed: Observed,
        tolerance: float,
        t_end: float,
        steps: Sequence[float],
        options: Mapping[str, Any],
        executor: Executor | None,
        progress: bool | None,
    ) -> None:
        self._make, self._observed, self._tolerance, self._t_end = make_system, observed, tolerance, t_end
        self._steps, self._options, self._executor, self._progress = steps, options, executor, progress
        self.trials: dict[str, _Trial] = {}
        self.choices: dict[str, Choice] = {}
        self._meshes: dict[str, Mapping[str, Choice]] = {}  # by which runs know that they are of one system

    def estimate(self) -> EffectShares:
        """Run the full system once with the largest step."""
        solution = simulate(self._make(approximation={}), self._t_end, self._steps[0], **{**QUIETLY, **self._options})
        return effect_shares(solution)

    def require_listening(self, choices: Mapping[str, Choice]) -> None:
        """Refuse a function that makes the same system whatever it is to leave out."""
        for choice in (c for c in choices.values() if c):
            try:
                system = self._make(approximation=choice)
            except PhblocksError:  # its row says what happened
                continue
            if not system.approximations:
                raise DataError(
                    f"{WHERE} make_system",
                    expected="a system that leaves out what it is told to",
                    got=f"one with nothing left out, for {choice!r}",
                    fix="Give its argument on: compile(approximation=approximation).",
                )
            return

    def run(self, choices: Mapping[str, Choice]) -> None:
        """Run systems with all steps."""
        self._meshes |= {name: {"approximation": choice} for name, choice in choices.items()}
        jobs = [self._job(name, dt) for name in choices for dt in self._steps]
        measured = carry_out(jobs, self._executor, WHERE, self._progress)
        count = len(self._steps)
        for i, (name, choice) in enumerate(choices.items()):
            self.trials[name] = _Trial(self._steps, measured[i * count : (i + 1) * count])
            self.choices[name] = choice

    def combine(self, singles: Mapping[str, Choice]) -> None:
        """Leave out together what may be left out alone, and take back what changes most until that is fine."""
        left = sorted((name for name in singles if self.error(name) <= self._tolerance), key=self.error)
        while len(left) > 1:
            name = ", ".join(left)
            self.run({name: merged(singles[part] for part in left)})
            if self.error(name) <= self._tolerance:
                return
            left.pop()

    def error(self, name: str) -> float:
        """Estimate the error of a system with the step it is judged with; infinite if it failed."""
        trial, full = self.trials[name], self.trials[FULL]
        if not trial.ok or not full.ok:
            return math.inf
        value = trial.runs[trial.accurate_enough(NUMERICAL * self._tolerance)].value
        assert value is not None
        if value.shape != full.finest.shape:
            return math.inf
        return distance(value, full.finest) + full.numerical_error(-1)

    def rows(self, shares: EffectShares, method: str, repeats: int) -> tuple[EffectRun, ...]:
        """Time every system with the step it is judged with."""
        chosen = {name: t.accurate_enough(NUMERICAL * self._tolerance) for name, t in self.trials.items()}
        jobs = [replace(self._job(name, self._steps[i]), repeats=repeats, timed=True) for name, i in chosen.items()]
        timed = carry_out(jobs, self._executor, WHERE, self._progress)
        seconds = {name: median(m.seconds or [math.nan]) for name, m in zip(chosen, timed, strict=True)}
        systems = {name: self._sizes(choice) for name, choice in self.choices.items()}
        full = self.trials[FULL]
        rows = []
        for (name, i), measured in zip(chosen.items(), timed, strict=True):
            trial, error = self.trials[name], self.error(name)
            unknowns, states = systems[name]
            rows.append(
                EffectRun(
                    **asdict(measured.machine),
                    left_out=name,
                    unknowns=unknowns,
                    unknowns_saved=systems[FULL][0] - unknowns,
                    states=states,
                    states_saved=systems[FULL][1] - states,
                    dt=self._steps[i],
                    numerical_error=trial.numerical_error(i),
                    change=distance(trial.finest, full.finest) if error < math.inf else math.nan,
                    error=error if error < math.inf else math.nan,
                    energy_share=_share(shares, self.choices[name]),
                    seconds=seconds[name],
                    time_saved=seconds[FULL] / seconds[name],
                    newton_iterations=measured.newton_iterations,
                    steps=measured.steps,
                    repeats=repeats,
                    within=error <= self._tolerance,
                    status=trial.status,
                    status_text=trial.status_text,
                    tolerance=self._tolerance,
                    quantity=self._observed.label,
                    unit=self._observed.unit,
                    method=method,
                    shared_machine=measured.shared,
                )
            )
        return tuple(rows)

    def _job(self, name: str, dt: float) -> Job:
        setting = Setting(self._meshes[name], dt, "", self._options)
        return Job(self._make, setting, self._t_end, self._observed)

    def _sizes(self, choice: Choice) -> tuple[int, int]:
        """Numbers of unknowns, and of states that carry energy."""
        try:
            system = self._make(approximation=choice)
        except Exception:  # its rows say what happened
            return 0, 0
        return system.n, int(system.carries_energy.sum())


def _share(shares: EffectShares, choice: Choice) -> float:
    """Sum the shares of the energies that are left out."""
    gone = [
        row.share
        for row in shares
        if row.block in choice
        and getattr(choice[row.block], row.effect) is not True
        and row.effect != "large_rotation"
        and not (row.effect != "flexible" and not choice[row.block].flexible and row.measure == "stored energy")
    ]
    return float(sum(gone)) if gone else 0.0


def _machine(row: EffectRun) -> Machine:
    return Machine(**{name: getattr(row, name) for name in Machine.__dataclass_fields__})
