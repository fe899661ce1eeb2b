"""What a run was asked for, as text; and a fingerprint of the system it is of."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from typing import Any

import numpy as np
import scipy.sparse as sp

from phblocks.errors import ResultFileError
from phblocks.results.labels import Labels
from phblocks.solvers.adaptive import Adaptive
from phblocks.solvers.discrete_gradient import DiscreteGradient
from phblocks.solvers.gauss_legendre import GaussLegendre
from phblocks.solvers.linearly_implicit import LinearlyImplicit
from phblocks.solvers.method import Integrator, Method
from phblocks.solvers.midpoint import Midpoint
from phblocks.solvers.newton import ModifiedNewton, Newton
from phblocks.solvers.projection import Projection
from phblocks.solvers.radau import RadauIIA
from phblocks.solvers.schedule import Schedule
from phblocks.solvers.scipy_ivp import ScipyIVP
from phblocks.system import System
from phblocks.triplets import Triplets

#: What can be made again from its text; other methods have to be given once more.
KNOWN: dict[str, Any] = {
    kind.__name__: kind
    for kind in (
        *(Midpoint, DiscreteGradient, GaussLegendre, RadauIIA, LinearlyImplicit, ScipyIVP),
        *(Newton, ModifiedNewton, Adaptive, Projection),
    )
}


@dataclasses.dataclass(frozen=True)
class Settings:
    """Arguments of a simulation besides system, start and inputs.

    Parameters
    ----------
    schedule : Schedule
        The times.
    method : Method or Integrator
        The method.
    max_halvings : int
        How often a failed step is halved.
    adaptive : Adaptive or None
        How steps are adapted.
    projection : Projection or None
        How often loops are closed.
    """

    schedule: Schedule
    method: Method | Integrator
    max_halvings: int
    adaptive: Adaptive | None
    projection: Projection | None = None

    @property
    def keeps_energy(self) -> bool:
        """Whether the method promises the balance of energy: those here do that do not choose their own steps."""
        promises = type(self.method).__name__ in KNOWN and not isinstance(self.method, Integrator)
        return promises and not getattr(self.method, "allow_energy_error", False)

    def text(self) -> dict[str, Any]:
        """Describe them by texts and numbers.

        Returns
        -------
        dict
            For JSON.
        """
        described = {"method": _described(self.method), "adaptive": _described(self.adaptive)}
        described["projection"] = _described(self.projection)
        described["keeps_energy"] = self.keeps_energy
        return {**dataclasses.asdict(self.schedule), "max_halvings": int(self.max_halvings), **described}

    @classmethod
    def of(cls, text: dict[str, Any], method: Method | Integrator | None, where: str) -> Settings:
        """Make them from their description.

        Parameters
        ----------
        text : dict
            From :meth:`text`.
        method : Method or Integrator or None
            The method, if it is one of the user's own.
        where : str
            The file, for messages.

        Returns
        -------
        Settings
            The same.

        Raises
        ------
        ResultFileError
            If the method is another one, or has to be given.
        """
        times = None if text["times"] is None else tuple(text["times"])
        schedule = Schedule(text["t_end"], text["dt"], text["save_every"], times, text["steps_too"])
        wanted = text["method"]
        if method is None and wanted["class"] not in KNOWN:
            raise ResultFileError(
                where,
                expected=f"the method {wanted['class']} of the run",
                got="none",
                fix="Give it: resume(method=...).",
            )
        if method is not None and _described(method) != wanted:
            raise ResultFileError(
                where,
                expected=f"the method of the run, {wanted}",
                got=repr(method),
                fix="Leave it out, or give the same.",
            )
        adaptive, projection = _made(text["adaptive"]), _made(text.get("projection"))
        return cls(schedule, method or _made(wanted), text["max_halvings"], adaptive, projection)


def _described(thing: Any) -> Any:
    kind = type(thing).__name__
    if KNOWN.get(kind) is type(thing):
        return {"class": kind, **{f.name: _described(getattr(thing, f.name)) for f in dataclasses.fields(thing)}}
    if isinstance(thing, np.generic):
        return thing.item()
    if isinstance(thing, (list, tuple)):
        return [_described(item) for item in thing]
    return thing if isinstance(thing, (bool, int, float, str, type(None))) else {"class": f"{kind} (of the user's)"}


def _made(text: Any) -> Any:
    if isinstance(text, dict):
        return KNOWN[text["class"]](**{key: _made(value) for key, value in text.items() if key != "class"})
    return tuple(text) if isinstance(text, list) else text


def fingerprint(system: System) -> str:
    """Condense names, matrices, start and what else makes the equations of a system.

    Parameters
    ----------
    system : System
        The system.

    Returns
    -------
    str
        Hexadecimal; functions of the user's count by their values at the start.
    """
    total = hashlib.sha256()

    def add(value: Any) -> None:
        array = np.ascontiguousarray(value)
        total.update(f"{array.dtype} {array.shape};".encode())
        total.update(array.tobytes())

    labels = dataclasses.asdict(Labels.of(system))
    connected = labels.pop("connected")
    total.update(json.dumps(labels).encode())
    start, lines = system.start, system.lines
    for array in (connected, system.gravity, system.point_mass, start.x, start.theta, start.points):
        add(array)
    for array in (lines.spans, lines.free, lines.line, system.angles.reference, system.point_angles.reference):
        add(array)
    for matrix in (system.E, system.J0, system.R0, system.T, system.G0, system.rates, system.input_rates):
        _add_matrix(add, matrix)
    for matrix in (system.kinematics_u, system.point_velocity, system.angles.rows, lines.stretch, lines.frames.rows):
        _add_matrix(add, matrix)
    for entries in (system.K, system.K_u, system.K_g, system.kinematics):
        _add_triplets(add, entries)
    for storage in system.storages:
        x = start.x[storage.energy]
        add([storage.hamiltonian(x), *storage.gradient(x)])
    for modulation in system.modulations:
        x = start.x[modulation.by]
        add(modulation.interconnection(x))
        add(modulation.dissipation(x))
    return total.hexdigest()


def _add_matrix(add: Any, matrix: Any) -> None:
    entries = sp.coo_array(matrix)
    for part in (*entries.coords, entries.data):
        add(part)


def _add_triplets(add: Any, entries: Triplets) -> None:
    add(entries.indices)
    add(entries.values)
