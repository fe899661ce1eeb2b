"""What is measured of a run, and how."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from phblocks.errors import PhblocksError
from phblocks.results.limits import Limits
from phblocks.results.solution import Solution
from phblocks.simulation import simulate
from phblocks.studies.machine import Machine, one_thread, this_machine
from phblocks.studies.reference import Reference
from phblocks.studies.run import Job
from phblocks.system import System
from phblocks.triplets import Floats

#: Runs of studies are too coarse on purpose, and have columns for what health would warn of.
QUIETLY: dict[str, Any] = {"progress": False, "limits": Limits.none()}

#: Columns that are copied from the measurement.
MEASURED = (
    *("states", "steps", "halvings", "rejections", "newton_iterations", "lag"),
    *("energy_error", "gap", "status", "status_text"),
)


@dataclass(kw_only=True)
class Measurement:
    """What is known of a run before there is a reference.

    Parameters
    ----------
    value : numpy.ndarray or None
        The quantity; ``None`` if the run failed.
    seconds : list of float
        Of every repeat, s.
    states, steps, halvings, rejections, newton_iterations : int
        Of the system and of the run.
    energy_error, gap, lag : float
        See :class:`~phblocks.studies.run.Run`.
    status, status_text : str
        How it ended, in a word and in full.
    machine : Machine
        Where.
    shared : bool
        Whether other runs of the study may have worked there at the same time.
    """

    value: Floats | None = None
    seconds: list[float] = field(default_factory=list)
    states: int = 0
    steps: int = 0
    halvings: int = 0
    rejections: int = 0
    newton_iterations: int = 0
    lag: float = 0.0
    energy_error: float = math.nan
    gap: float = math.nan
    status: str = "success"
    status_text: str = ""
    machine: Machine = field(default_factory=this_machine)
    shared: bool = False

    @property
    def ok(self) -> bool:
        """Whether the run reached its end and the quantity could be read."""
        return self.value is not None


class Runner:
    """Does a job, repeat by repeat.

    Parameters
    ----------
    job : Job
        The run.
    systems : dict
        By the identity of the mesh; shared with other runners, so that a system is made once.

    Attributes
    ----------
    measured : Measurement
        Of all repeats so far.
    """

    def __init__(self, job: Job, systems: dict[int, System]) -> None:
        self.job = job
        self._systems = systems
        self.measured = Measurement()

    def repeat(self) -> None:
        """Run once; a run that failed before is not tried again."""
        if self.measured.status != "success":
            return
        try:
            with one_thread():
                self._run()
        except Exception as error:  # whatever it is: the other runs of the study go on
            self.measured.status, self.measured.status_text = type(error).__name__, str(error)
            self.measured.value = None

    def _run(self) -> None:
        job, measured, first = self.job, self.measured, not self.measured.seconds
        setting = job.setting
        if id(setting.mesh) not in self._systems:
            self._systems[id(setting.mesh)] = job.make_system(**setting.mesh)
        system = self._systems[id(setting.mesh)]
        arguments = job.arguments
        if first and job.timed:  # what is loaded and computed once a process should not be in the first time
            with suppress(Exception):  # if there is something wrong, the run itself says so
                simulate(system, min(setting.dt, job.t_end), setting.dt, **{**QUIETLY, **setting.arguments})
        clock = perf_counter()
        solution = simulate(system, job.t_end, setting.dt, **{**QUIETLY, **arguments})
        measured.seconds.append(perf_counter() - clock)
        if not first:
            return
        statistics = solution.statistics
        measured.states, measured.steps, measured.halvings = system.n, statistics.steps, statistics.halvings
        measured.rejections, measured.lag = statistics.rejections, float(statistics.lag.max(initial=0.0))
        measured.newton_iterations = int(statistics.newton_iterations.sum())
        measured.energy_error, measured.gap = energy_error(solution), strain_gap(solution)
        measured.status, measured.status_text = solution.status.name, solution.status.text
        if solution.status.ok:
            measured.value = job.observed(solution)


def measure(job: Job) -> Measurement:
    """Do a job with all its repeats, as a worker does.

    Parameters
    ----------
    job : Job
        The run.

    Returns
    -------
    Measurement
        Also of a run that failed.
    """
    runner = Runner(job, {})
    for _ in range(job.repeats):
        runner.repeat()
    return runner.measured


def energy_error(solution: Solution) -> float:
    """Measure how well a run kept its energy.

    Parameters
    ----------
    solution : Solution
        Of the run.

    Returns
    -------
    float
        Largest ``|H - H(0) - supplied + losses|`` at the saved times over the largest energy of any kind; 0 where
        there is no energy.
    """
    energy = solution.energy
    lost = energy.dissipated + energy.numerical_loss - energy.projected
    left = np.abs(energy.total - energy.total[0] - energy.supplied + lost).max()
    largest = max(float(np.abs(series).max()) for series in energy.values())
    return float(left / largest) if largest else 0.0


def strain_gap(solution: Solution) -> float:
    """Measure how far strain and configuration are apart, which energy does not show.

    Parameters
    ----------
    solution : Solution
        Of the run.

    Returns
    -------
    float
        Largest distance at the saved times, m: between positions from strain and from velocity at the anchors, and
        between the positions from strain that a joint joins. NaN if there is none of this.
    """
    distances: list[float] = []
    for anchor in (a for part in solution.system.parts for a in part.block.anchors.values()):
        with suppress(PhblocksError):  # not every block has both positions
            by_strain, by_velocity = (solution.position(anchor, source=s) for s in ("strain", "velocity"))
            distances.append(float(np.linalg.norm(by_strain - by_velocity, axis=1).max()))
    with suppress(PhblocksError):
        distances += [float(series.max()) for series in solution.closure(source="strain").values()]
    return max(distances, default=math.nan)


def record(job: Job, measured: Measurement, reference: Reference, shared_machine: bool | None = None) -> dict[str, Any]:
    """Join what was set and what was measured.

    Parameters
    ----------
    job : Job
        The run.
    measured : Measurement
        What came of it.
    reference : Reference
        What its error is measured against.
    shared_machine : bool, optional
        Whether other runs may have disturbed it; by default whether they ran at the same time.

    Returns
    -------
    dict
        The columns of :class:`~phblocks.studies.run.Run`.
    """
    setting, observed, seconds = job.setting, job.observed, measured.seconds or [math.nan]
    return {
        **asdict(measured.machine),
        "method": setting.method,
        "mesh": setting.mesh_label,
        "dt": setting.dt,
        "rtol": setting.rtol,
        "t_end": job.t_end,
        **{name: getattr(measured, name) for name in MEASURED},
        "seconds": median(seconds),
        "seconds_min": min(seconds),
        "seconds_max": max(seconds),
        "repeats": len(measured.seconds),
        "error": reference.error_of(measured.value),
        "reference_uncertainty": reference.uncertainty,
        "shared_machine": measured.shared if shared_machine is None else shared_machine,
        "quantity": observed.label,
        "unit": observed.unit,
        "reference": reference.source,
        "settings": ", ".join(f"{name}={value!r}" for name, value in setting.arguments.items()),
    }
