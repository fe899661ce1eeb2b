"""What accuracy costs: error, time and what else a run shows, over methods, steps and meshes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from itertools import product
from typing import TYPE_CHECKING, Any, ClassVar

from numpy.typing import ArrayLike

from phblocks.blocks.checks import require_real
from phblocks.errors import ArgumentTypeError, DataError, StudyError
from phblocks.studies.execution import carry_out
from phblocks.studies.measurement import Measurement, record
from phblocks.studies.notes import notes_of
from phblocks.studies.quantity import Quantity, distance, observe
from phblocks.studies.reference import Reference, given, refined
from phblocks.studies.run import Job, MakeSystem, Mesh, Run, Setting, step_control
from phblocks.studies.settings import (
    Methods,
    name_of,
    named_methods,
    positive_values,
    require_function,
    with_tolerance,
)
from phblocks.studies.table import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WHERE = "work_precision"


@dataclass(frozen=True, repr=False)
class WorkPrecisionStudy(Table[Run]):
    """Runs of all combinations of methods, meshes and steps.

    Parameters
    ----------
    rows : tuple of Run
        The runs.
    reference : Reference, optional
        What their errors are measured against; not in the CSV file, which has its uncertainty and source only.
    """

    reference: Reference | None = field(default=None, compare=False)

    row_type: ClassVar[type[Run]] = Run
    shown: ClassVar[tuple[str, ...]] = (
        *("method", "mesh", "dt", "rtol", "states", "error", "seconds", "steps", "halvings", "rejections"),
        *("newton_iterations", "energy_error", "gap", "lag", "status"),
    )
    shown_if_any: ClassVar[tuple[str, ...]] = ("rtol", "halvings", "rejections", "lag")

    @property
    def notes(self) -> tuple[str, ...]:
        """What the error is of, how times were taken, on which machine, and which runs failed."""
        return notes_of(self.rows)

    @property
    def front(self) -> WorkPrecisionStudy:
        """The runs that no other one beats in both error and time, from fast to accurate."""
        best, kept = math.inf, []
        for row in self.filter(lambda row: row.ok).sort("seconds", "error"):
            if row.error < best:
                best = row.error
                kept.append(row)
        return WorkPrecisionStudy(tuple(kept), self.reference)

    def plot(self) -> Figure:
        """Draw error, energy error and gap against time, see ``ph.plots.work_precision``.

        Returns
        -------
        matplotlib.figure.Figure
            A new one.
        """
        from phblocks.plots import work_precision as draw

        return draw(self)


def work_precision(
    make_system: MakeSystem,
    methods: Methods,
    steps: Iterable[float],
    meshes: Sequence[Mesh] | None = None,
    *,
    quantity: Quantity,
    t_end: float,
    times: ArrayLike | None = None,
    tolerances: Iterable[float] | None = None,
    reference: Reference | ArrayLike | None = None,
    repeats: int = 5,
    unit: str = "",
    executor: Executor | None = None,
    shared_machine: bool | None = None,
    progress: bool | None = None,
    **arguments: Any,
) -> WorkPrecisionStudy:
    """Measure what every method reaches with every step on every mesh, and how long it takes.

    A run that fails is a row that says so. Times are those of ``simulate`` with one thread of linear algebra, medians
    of the repeats; runs that are timed alternate, one after another in this process, so that nothing of the study
    disturbs them. What is not timed goes to processes on this machine, side by side, if it takes longer than two
    seconds: the runs for the reference, and all runs if ``repeats`` is 0.

    Parameters
    ----------
    make_system : callable
        Takes the arguments of a mesh by name, returns a compiled ``System``.
    methods : sequence or mapping
        Time methods, such as ``[ph.Midpoint(), ...]`` or by name; in a mapping a method may also be a mapping of
        arguments of ``simulate``: ``{"adapted": {"method": ph.GaussLegendre(), "adaptive": ph.Adaptive()}}``.
    steps : iterable of float
        Steps, s; they should divide ``times``. Runs that choose their steps (``adaptive``, ``ScipyIVP``) are made once
        a tolerance, with the largest of them as dt.
    meshes : sequence of mapping, optional
        Arguments of ``make_system``, from coarse to fine: ``[{"elements": 4}, {"elements": 8, "degree": 2}]``.
    quantity : callable or tuple
        What the error is of: a function of a ``Solution``, or ("position", block, place), and so for "angle",
        "velocity", "spin", "force" and "moment". A block is given by its name.
    t_end : float
        Duration of the runs, s.
    times : array_like, optional
        When, s: the quantity gets the solution at these times only. By default a tuple is taken at ``t_end``, and a
        function gets the whole solution. Runs that choose their steps are made to end steps there.
    tolerances : iterable of float, optional
        Relative tolerances of runs that choose their steps, in place of steps; the absolute one is changed by the same
        factor. By default each has its own.
    reference : Reference or array_like, optional
        The true value, one row for each time. By default more runs are made: one with the method of the highest
        ``order``, without other options of its own, half the smallest step, and the last mesh with ``elements`` doubled
        and ``degree`` raised by one (where it has them); one with the full step; one with a mesh between. The
        uncertainty is a third of the two differences, as if the order were two.
    repeats : int, optional
        How often each run is timed. 0: each is made once, and its time counts for nothing.
    unit : str, optional
        Of a quantity that is a function.
    executor : concurrent.futures.Executor, optional
        Does all runs elsewhere or side by side, see ``processes``; by default see above.
    shared_machine : bool, optional
        Whether runs disturb each other's times; by default, whether they were made side by side.
    progress : bool, optional
        Show a progress bar; by default if a terminal is attached and the study takes longer than a second.
    **arguments : object
        More arguments of ``simulate`` for all runs, such as ``inputs``.

    Returns
    -------
    WorkPrecisionStudy
        A row a run.

    Raises
    ------
    DataError, ArgumentTypeError, UnknownNameError
        If an argument is out of its range, of the wrong kind or unknown, or the reference has another shape.
    StudyError
        If the runs for the reference fail, or a worker is lost.

    Notes
    -----
    Work-precision diagrams after E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.10,
    doi:10.1007/978-3-642-05221-7.
    """
    require_function(f"{WHERE} make_system", make_system)
    t_end = require_real(f"{WHERE} t_end", t_end)
    if isinstance(repeats, bool) or not isinstance(repeats, int) or repeats < 0:
        raise DataError(f"{WHERE} repeats", expected="an integer >= 0", got=repr(repeats), fix="Correct it.")
    named, sizes = named_methods(WHERE, methods, arguments), positive_values(f"{WHERE} steps", steps)
    chosen = [{}] if meshes is None else _require_meshes(meshes)
    observed = observe(WHERE, quantity, times, t_end, unit)
    relative = [None] if tolerances is None else positive_values(f"{WHERE} tolerances", tolerances)
    settings = [
        setting
        for (name, own), mesh in product(named.items(), chosen)
        for setting in _settings(name, own, mesh, sizes, relative)
    ]
    jobs = [Job(make_system, setting, t_end, observed, max(1, repeats), repeats > 0) for setting in settings]
    known = None if reference is None else given(reference)
    finest = Job(make_system, Setting(chosen[-1], sizes[-1], "", {}), t_end, observed)
    extra = _reference_jobs(finest, named, arguments) if known is None else []
    measured = carry_out([*extra, *jobs], executor, WHERE, progress)
    truth = known or _computed(extra, measured[: len(extra)])
    rows = [Run(**record(job, m, truth, shared_machine)) for job, m in zip(jobs, measured[len(extra) :], strict=True)]
    return WorkPrecisionStudy(tuple(rows), truth)


def _settings(
    name: str, own: Mapping[str, Any], mesh: Mesh, steps: Sequence[float], tolerances: Sequence[float | None]
) -> list[Setting]:
    """One for each step, or where the run chooses its steps for each tolerance."""
    if step_control(own) is None:
        return [Setting(mesh, dt, name, own) for dt in steps]
    found = [with_tolerance(WHERE, own, rtol) for rtol in tolerances]
    return [Setting(mesh, steps[0], name, arguments, rtol) for arguments, rtol in found]


def _require_meshes(meshes: object) -> list[Mesh]:
    if not isinstance(meshes, (list, tuple)) or not all(isinstance(mesh, Mapping) for mesh in meshes):
        raise ArgumentTypeError(
            f"{WHERE} meshes", expected="a list of dicts", got=repr(meshes), fix="Such as [{'elements': 4}]."
        )
    if not meshes:
        raise DataError(f"{WHERE} meshes", expected="one or more", got="none", fix="Leave it out if there is one.")
    return list(meshes)


def _reference_jobs(finest: Job, named: Mapping[str, Mapping[str, Any]], arguments: Mapping[str, Any]) -> list[Job]:
    """The finest run comes last; the others, with a coarser mesh or the full step, tell how far it may be off."""
    # a method that chooses its steps itself has no order, and a smaller step does not make it better
    candidates = [own.get("method") for own in named.values()]
    fixed = [m for m in candidates if m is None or hasattr(m, "order")]
    if not fixed:
        raise StudyError(
            f"{WHERE} reference",
            expected="a method that a smaller step makes more accurate",
            got=", ".join(named),
            fix="Give a reference, or add such a method.",
        )
    best = max(fixed, key=lambda method: getattr(method, "order", 0))
    own = {**arguments} if best is None else {**arguments, "method": best}
    dt, half = finest.setting.dt, 0.5 * finest.setting.dt
    mesh, *coarser = refined(finest.setting.mesh)
    settings = [*((other, half) for other in coarser), (mesh, dt), (mesh, half)]
    return [replace(finest, setting=Setting(mesh, dt, name_of(best), own)) for mesh, dt in settings]


def _computed(jobs: Sequence[Job], measured: Sequence[Measurement]) -> Reference:
    """The reference from its runs, the finest one last."""
    for job, run in zip(jobs, measured, strict=True):
        if not run.ok:
            raise StudyError(
                f"{WHERE} reference",
                expected="finer runs that reach their end",
                got=f"{job.setting.method}, {job.setting.mesh_label}, dt = {job.setting.dt:g} s: "
                f"{run.status}: {run.status_text}",
                fix="Give a reference.",
            )
    *others, finest = (run.value for run in measured if run.value is not None)
    uncertainty = sum(distance(finest, other) for other in others) / 3.0
    setting = jobs[-1].setting
    return Reference(finest, uncertainty, f"{setting.method}, mesh {setting.mesh_label}, dt = {setting.dt:g} s")
