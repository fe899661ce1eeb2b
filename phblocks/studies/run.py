"""One run of a study: what is set, and the record that is kept of it."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from phblocks.errors import DataError
from phblocks.solvers.method import Integrator
from phblocks.studies.machine import Machine
from phblocks.studies.quantity import Observed
from phblocks.system import System

Mesh = Mapping[str, Any]
MakeSystem = Callable[..., System]


@dataclass(frozen=True)
class Setting:
    """What may differ from run to run.

    Parameters
    ----------
    mesh : mapping
        Arguments of the function that makes the system.
    dt : float
        Step, s; of a method that chooses its steps what ``simulate`` calls dt.
    method : str
        What the method is called in tables.
    arguments : mapping
        More arguments of ``simulate``: the method and its options, inputs.
    rtol : float, optional
        Relative tolerance of a method that chooses its steps; 0 if there is none.
    """

    mesh: Mesh
    dt: float
    method: str
    arguments: Mapping[str, Any]
    rtol: float = 0.0

    @property
    def mesh_label(self) -> str:
        """What the mesh is called in tables."""
        plain = {name: value.item() if isinstance(value, np.generic) else value for name, value in self.mesh.items()}
        return ", ".join(f"{name}={value!r}" for name, value in plain.items()) or "default"


@dataclass(frozen=True)
class Job:
    """A run, with all that a worker needs to do it.

    Parameters
    ----------
    make_system : callable
        Makes the system from the arguments of the mesh.
    setting : Setting
        Mesh, step and method.
    t_end : float
        End of the run, s.
    observed : Observed
        The quantity.
    repeats : int
        How often it is done.
    timed : bool
        Whether its time is asked for: then nothing else of the study runs meanwhile, unless an executor does it.
    """

    make_system: MakeSystem
    setting: Setting
    t_end: float
    observed: Observed
    repeats: int = 1
    timed: bool = False

    @property
    def arguments(self) -> dict[str, Any]:
        """What ``simulate`` is given besides system, end and step.

        A run in steps of its own has to be told the times of the quantity; it saves all its steps besides them, so that
        energy and gap are judged as those of other runs are.
        """
        given, times = dict(self.setting.arguments), [t for t in self.observed.times or () if t > 0.0]
        if times and step_control(given) is not None and "times" not in given:
            given = {"save_every": 1, **given, "times": sorted(set(times))}
        return given


def step_control(arguments: Mapping[str, Any]) -> object:
    """Find what chooses the steps of a run.

    Parameters
    ----------
    arguments : mapping
        Of ``simulate``.

    Returns
    -------
    object
        ``Adaptive``, or a method that chooses its steps itself; ``None`` if the steps are equal.
    """
    method = arguments.get("method")
    return arguments.get("adaptive") or (method if isinstance(method, Integrator) else None)


@dataclass(frozen=True, kw_only=True)
class Run(Machine):
    """A row of a study.

    Parameters
    ----------
    method : str
        Short name of the time method.
    mesh : str
        Arguments the system was made with.
    dt, t_end : float
        Step and end of the run, s. Where the method chooses its steps, dt is what it was given to begin with.
    rtol : float
        Relative tolerance of a method that chooses its steps; 0 if the steps are equal.
    states : int
        Unknowns of the system.
    steps, halvings, rejections, newton_iterations : int
        Accepted steps, steps that failed and were halved, steps whose estimated error was too large, and Newton
        iterations of the whole run.
    lag : float
        Consistency residual of a linearly implicit method, ``solution.statistics.lag``, largest of any step; 0 for
        other methods.
    seconds : float
        Median over the repeats of the time ``simulate`` took, s, with one thread; making the system and reading the
        quantity are not in it.
    seconds_min, seconds_max : float
        Fastest and slowest repeat, s.
    repeats : int
        How often it was timed.
    error : float
        Largest distance from the reference; NaN if the run failed.
    reference_uncertainty : float
        How far the reference may be from the truth, in the same unit; NaN if it is not known.
    energy_error : float
        Largest departure from the balance ``H - supplied + losses``, relative to the largest energy of any kind.
    gap : float
        Strain against configuration, m: the largest distance between positions from strain and from velocity at the
        anchors of blocks, and between what a joint joins. NaN if there is no position to compare.
    status, status_text : str
        How the run ended.
    shared_machine : bool
        Other runs may have worked on the machine at the same time, so that ``seconds`` are not what they could be.
    quantity, unit : str
        What the error is of.
    reference : str
        Where the reference is from.
    settings : str
        Everything given to ``simulate``.
    """

    method: str
    mesh: str
    dt: float = field(metadata={"unit": "s"})
    rtol: float = field(metadata={"absent": 0.0})
    t_end: float = field(metadata={"unit": "s"})
    states: int
    steps: int
    halvings: int
    rejections: int
    newton_iterations: int
    lag: float = field(metadata={"absent": 0.0, "unit": "relative"})
    seconds: float
    seconds_min: float
    seconds_max: float
    repeats: int
    error: float
    reference_uncertainty: float
    energy_error: float = field(metadata={"unit": "relative"})
    gap: float = field(metadata={"unit": "m"})
    status: str
    status_text: str
    shared_machine: bool
    quantity: str
    unit: str
    reference: str
    settings: str

    @property
    def ok(self) -> bool:
        """Whether the run has an error to be judged by."""
        return not math.isnan(self.error)

    @property
    def mesh_arguments(self) -> dict[str, Any]:
        """Arguments to make the system with again, read from ``mesh``.

        Raises
        ------
        DataError
            If they are not numbers, text or tuples of these.
        """
        call = ast.parse(f"make({self.mesh})", mode="eval").body
        assert isinstance(call, ast.Call)
        try:
            return {str(word.arg): ast.literal_eval(word.value) for word in call.keywords}
        except ValueError as error:
            raise DataError(
                "mesh of a run", expected="numbers, text or tuples", got=self.mesh, fix="Look it up among the meshes."
            ) from error

    @property
    def error_bound(self) -> float:
        """Error, and what the reference may add to it where that is known."""
        return self.error + (0.0 if math.isnan(self.reference_uncertainty) else self.reference_uncertainty)

    def __str__(self) -> str:
        """Say the setting, and what it gave."""
        result = f"error {self.error:.3g} {self.unit}".rstrip() if self.ok else self.status
        step = f"dt = {self.dt:g} s" if self.rtol == 0.0 else f"rtol = {self.rtol:g}"
        return f"{self.method}, {self.mesh}, {step}: {result} in {self.seconds:.3g} s"

    @property
    def machine(self) -> Machine:
        """Where it was measured."""
        return Machine(**{f.name: getattr(self, f.name) for f in fields(Machine)})
