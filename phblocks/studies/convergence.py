"""How the error falls with the step, the elements or the degree."""

from __future__ import annotations

import math
from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from numpy.typing import ArrayLike

from phblocks.blocks.checks import require_real
from phblocks.errors import ArgumentTypeError, DataError, StudyError
from phblocks.studies.execution import carry_out
from phblocks.studies.fit import Fit, asymptotic_part, fit_line, pairwise_rates
from phblocks.studies.measurement import record
from phblocks.studies.notes import notes_of
from phblocks.studies.quantity import Quantity, observe
from phblocks.studies.reference import Reference, element_counts, extrapolate, given
from phblocks.studies.run import Job, MakeSystem, Mesh, Run, Setting, step_control
from phblocks.studies.settings import name_of, named_methods, positive_values, require_function
from phblocks.studies.table import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WHERE = "convergence"
Over = Literal["dt", "elements", "degree"]


@dataclass(frozen=True, kw_only=True)
class ConvergenceRun(Run):
    """A row of a convergence study.

    Parameters
    ----------
    over : str
        What is varied: "dt", "elements" or "degree".
    value : str
        Its value.
    size : float
        Step, s; one over the number of elements of all blocks; or the degree.
    rate : float
        From the next coarser run: the order in the size, or over the degree the factor by which the error falls with
        one degree more. NaN if there is none.
    fitted : bool
        Belongs to the asymptotic part, which the line is fitted to.
    """

    over: str
    value: str
    size: float
    rate: float
    fitted: bool


@dataclass(frozen=True, repr=False)
class ConvergenceStudy(Table[ConvergenceRun]):
    """Runs from coarse to fine.

    Parameters
    ----------
    rows : tuple of ConvergenceRun
        The runs.
    reference : Reference, optional
        What their errors are measured against; not in the CSV file, which has its uncertainty and source only.
    """

    reference: Reference | None = field(default=None, compare=False)

    row_type: ClassVar[type[ConvergenceRun]] = ConvergenceRun
    shown: ClassVar[tuple[str, ...]] = (
        *("over", "value", "states", "error", "rate", "fitted", "seconds", "halvings"),
        *("energy_error", "gap", "lag", "status"),
    )
    shown_if_any: ClassVar[tuple[str, ...]] = ("halvings", "lag")

    @property
    def fit(self) -> Fit:
        """Least squares through log(error) over log(size), or over the degree, of the runs marked ``fitted``."""
        rows = [row for row in self.rows if row.fitted]
        return fit_line(self._over, [row.size for row in rows], [row.error for row in rows])

    @property
    def order(self) -> float:
        """Fitted order in the step or the element length; NaN with fewer than two runs in the asymptotic part.

        Raises
        ------
        StudyError
            Over the degree, in which the error is exponential.
        """
        if self._over == "degree":
            raise StudyError(
                "order of a study over degree",
                expected="a study over dt or elements",
                got="errors that fall exponentially",
                fix="Use study.rate, the factor by which one degree more lowers the error.",
            )
        return self.fit.slope

    @property
    def rate(self) -> float:
        """Fitted factor by which one degree more lowers the error.

        Raises
        ------
        StudyError
            Of a study over anything else.
        """
        if self._over != "degree":
            raise StudyError(
                f"rate of a study over {self._over}",
                expected="a study over degree",
                got="errors that fall with a power",
                fix="Use study.order.",
            )
        return math.exp(-self.fit.slope)

    @property
    def notes(self) -> tuple[str, ...]:
        """The fit, what the error is of, the machine, and which runs failed."""
        slope, deviation, runs = self.fit
        if not runs:
            return notes_of(self.rows)
        off = "" if math.isnan(deviation) else f" ± {deviation:.1g}"
        if self._over == "degree":
            text = f"Fitted over {runs} runs: the error falls by {self.rate:.3g} with every degree."
        else:
            text = f"Fitted order over {runs} runs: {slope:.3f}{off}."
        if runs == 2:
            text += " Rates before differ by more than 15 %, or are not known: do not rely on it."
        return (text, f"Method: {self.rows[0].method}.", *notes_of(self.rows))

    @property
    def _over(self) -> str:
        return self.rows[0].over if self.rows else ""

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the errors and the fitted line, see ``ph.plots.convergence``.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure by default.

        Returns
        -------
        matplotlib.axes.Axes
            With the drawing.
        """
        from phblocks.plots import convergence as draw

        return draw(self, ax=ax)


def convergence(
    make_system: MakeSystem,
    over: Over,
    values: Iterable[Any],
    *,
    quantity: Quantity,
    t_end: float,
    dt: float | None = None,
    mesh: Mesh | None = None,
    method: object = None,
    times: ArrayLike | None = None,
    reference: Reference | ArrayLike | None = None,
    unit: str = "",
    executor: Executor | None = None,
    shared_machine: bool | None = None,
    progress: bool | None = None,
    **arguments: Any,
) -> ConvergenceStudy:
    """Measure how the error falls with the step, the elements or the degree.

    Parameters
    ----------
    make_system : callable
        Takes ``elements`` or ``degree`` (what is varied) and the arguments of ``mesh`` by name, returns a compiled
        ``System``.
    over : {"dt", "elements", "degree"}
        What is varied.
    values : iterable
        Steps, s; numbers of elements, each an integer or several, one for each beam; or degrees.
    quantity : callable or tuple
        What the error is of: a function of a ``Solution``, or ("position", block, place), and so for "angle",
        "velocity", "spin", "force" and "moment". A block is given by its name.
    t_end : float
        Duration of the runs, s.
    dt : float, optional
        Step, s, of a study over something else. Its error stays in all runs alike: a reference that is given has to
        have it too.
    mesh : mapping, optional
        Further arguments of ``make_system``.
    method : optional
        Time method, by default what ``simulate`` chooses.
    times : array_like, optional
        When, s: the quantity gets the solution at these times only. By default a tuple is taken at ``t_end``, and a
        function gets the whole solution.
    reference : Reference or array_like, optional
        The true value, one row for each time. By default it is extrapolated from the three finest runs with the order
        they show (over the degree: with the rate), so that those three lie on a line by construction.
    unit : str, optional
        Of a quantity that is a function.
    executor : concurrent.futures.Executor, optional
        Does the runs elsewhere or side by side, see ``processes``. By default they are made in this process, and what
        is left after two seconds in processes on this machine.
    shared_machine : bool, optional
        Whether runs disturb each other's times; by default, whether they were made side by side.
    progress : bool, optional
        Show a progress bar; by default if a terminal is attached and the study takes longer than a second.
    **arguments : object
        More arguments of ``simulate`` for all runs, such as ``inputs``.

    Returns
    -------
    ConvergenceStudy
        A row a run, from coarse to fine. The line is fitted to the runs from the finest one on back whose rates are
        the same within 15 %; runs whose error is below the uncertainty of a reference that was given are left out.

    Raises
    ------
    DataError, ArgumentTypeError, UnknownNameError
        If an argument is out of its range, of the wrong kind or unknown, or the reference has another shape.
    StudyError
        If fewer than three runs reach their end where they have to give the reference, or a worker is lost.
    """
    require_function(f"{WHERE} make_system", make_system)
    t_end = require_real(f"{WHERE} t_end", t_end)
    sized = _sized(over, values, 3 if reference is None else 2)
    if (dt is None) != (over == "dt"):
        raise DataError(
            f"{WHERE} dt",
            expected="none over dt, a step over anything else",
            got=repr(dt),
            fix="Over dt the steps are the values.",
        )
    observed = observe(WHERE, quantity, times, t_end, unit)
    [(name, own)] = named_methods(WHERE, {name_of(method): method}, arguments).items()
    if over == "dt" and step_control(own) is not None:
        raise DataError(
            f"{WHERE} over dt",
            expected="a method with equal steps",
            got=name if own.get("adaptive") is None else repr(own["adaptive"]),
            fix="Use work_precision(..., tolerances=...).",
        )
    fixed = {} if mesh is None else dict(mesh)
    jobs = [
        Job(
            make_system,
            Setting(fixed, float(value), name, own)
            if dt is None
            else Setting({**fixed, over: value}, require_real(f"{WHERE} dt", dt), name, own),
            t_end,
            observed,
        )
        for _, value in sized
    ]
    known = None if reference is None else given(reference)
    measured = carry_out(jobs, executor, WHERE, progress)
    sizes = [size for size, _ in sized]
    if known is None:
        done = [(size, m.value) for size, m in zip(sizes, measured, strict=True) if m.value is not None]
        if len(done) < 3:
            failed = next(m for m in measured if not m.ok)
            raise StudyError(
                f"{WHERE} reference",
                expected="three runs or more that reach their end",
                got=f"{len(done)}; {failed.status}: {failed.status_text}",
                fix="Mend or leave out what fails, or give a reference.",
            )
        # over the degree the error is exponential: a power of exp(-degree)
        lengths = [math.exp(-size) if over == "degree" else size for size, _ in done]
        truth = extrapolate(lengths, [value for _, value in done])
    else:
        truth = known
    errors = [truth.error_of(m.value) for m in measured]
    rates = pairwise_rates(over, sizes, errors)
    # what was extrapolated from the finest runs has them on a line, and nothing to leave out
    floor = 0.0 if known is None or math.isnan(truth.uncertainty) else truth.uncertainty
    steady = asymptotic_part(over, sizes, errors, floor)
    rows = [
        ConvergenceRun(
            **record(job, m, truth, shared_machine),
            over=over,
            value=str(value),
            size=size,
            rate=rate,
            fitted=i in steady,
        )
        for i, (job, m, (size, value), rate) in enumerate(zip(jobs, measured, sized, rates, strict=True))
    ]
    return ConvergenceStudy(tuple(rows), truth)


def _sized(over: object, values: Iterable[Any], least: int) -> list[tuple[float, Any]]:
    """Sizes and values from coarse to fine."""
    where = f"{WHERE} values"
    if over == "dt":
        return [(value, value) for value in positive_values(where, values, least)]
    if over == "degree":
        degrees = positive_values(where, values, least)[::-1]
        if any(not degree.is_integer() for degree in degrees):
            raise DataError(where, expected="integers", got=repr(degrees), fix="Correct them.")
        return [(degree, int(degree)) for degree in degrees]
    if over != "elements":
        raise DataError(
            f"{WHERE} over", expected='"dt", "elements" or "degree"', got=repr(over), fix="Choose one of them."
        )
    if not isinstance(values, Iterable) or isinstance(values, str):
        raise ArgumentTypeError(where, expected="a list of numbers of elements", got=repr(values), fix="Give one.")
    meshes = list(values)
    sizes = positive_values(where, [1.0 / sum(element_counts(mesh)) for mesh in meshes], least)
    return list(zip(sizes, sorted(meshes, key=lambda mesh: sum(element_counts(mesh))), strict=True))
