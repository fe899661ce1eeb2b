"""How a run ended, what it took, and named series of energies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from phblocks.errors import StructureError, UnknownNameError
from phblocks.triplets import Floats, Ints


@dataclass(frozen=True)
class Status:
    """How a run ended.

    Parameters
    ----------
    ok : bool
        It reached its end.
    name : str
        A word for programs: "success", "step failed", "structure lost", "input not finite", "input failed", "not
        written", "interrupted".
    text : str
        When, where, and what to do.
    time : float or None
        Where it stopped, s, if it did not reach its end.
    state : str or None
        Of a step that failed: the state whose equation was missed by most, as in ``system.state_names``.
    error : Exception or None
        The exception that stopped it, with its traceback, if it came from a function of the user's.
    """

    ok: bool
    name: str
    text: str
    time: float | None = None
    state: str | None = None
    error: Exception | None = field(default=None, repr=False, compare=False)

    def __str__(self) -> str:
        """Return name and text."""
        return f"{self.name}: {self.text}"

    @property
    def block(self) -> str | None:
        """The block, or joint, of that state."""
        return None if self.state is None else self.state.rpartition(".")[0]

    @property
    def field(self) -> str | None:
        """The field of that state, such as "N1"."""
        return None if self.state is None else self.state.rpartition(".")[2].partition("[")[0]

    @classmethod
    def success(cls) -> Status:
        """Report that the end was reached.

        Returns
        -------
        Status
            With ``ok``.
        """
        return cls(True, "success", "the end was reached")

    @classmethod
    def step_failed(cls, time: float, dt: float, why: str, state: str | None = None) -> Status:
        """Report that no step could be taken, also with the smallest length.

        Parameters
        ----------
        time : float
            Start of the step, s.
        dt : float
            The smallest step that was tried, s.
        why : str
            What happened.
        state : str or None, optional
            Name of the state whose equation was missed by most.

        Returns
        -------
        Status
            Not ``ok``.
        """
        status = cls(False, "step failed", "", time, state)
        missed = f"; the largest residual was that of {status.field} of {status.block!r} ({state})" if state else ""
        text = (
            f"{why} at t = {time:.9g} s, also with the step halved to {dt:.3g} s{missed}. The "
            "results up to there are kept. Use a smaller dt or more max_halvings; look at the last states for a "
            "singular position or a load that jumps."
        )
        return replace(status, text=text)

    @classmethod
    def structure_lost(cls, time: float, error: StructureError) -> Status:
        """Report that matrices of the user's were not what they must be, in a step that was not kept.

        Parameters
        ----------
        time : float
            Start of the step, s.
        error : StructureError
            Which block and matrix, what is violated, by how much and at which state.

        Returns
        -------
        Status
            Not ``ok``.
        """
        text = (
            f"{error.where}: expected {error.expected}, got {error.got}, in the step from t = {time:.9g} s on. The "
            f"results up to there are kept. {error.fix}"
        )
        return cls(False, "structure lost", text, time)

    @classmethod
    def input_not_finite(cls, time: float, name: str) -> Status:
        """Report that a signal gave NaN or infinity.

        Parameters
        ----------
        time : float
            When, s.
        name : str
            Which exposed port.

        Returns
        -------
        Status
            Not ``ok``.
        """
        text = (
            f"the signal of {name!r} is not finite at t = {time:.9g} s. The results up to there are kept. "
            "Correct the function given in inputs."
        )
        return cls(False, "input not finite", text, time)

    @classmethod
    def input_failed(cls, time: float, name: str, error: Exception) -> Status:
        """Report that a signal raised an exception, or gave a value of another shape or kind than at the start.

        Parameters
        ----------
        time : float
            When, s.
        name : str
            Which exposed port.
        error : Exception
            What was raised.

        Returns
        -------
        Status
            Not ``ok``; the exception is its ``error``.
        """
        text = (
            f"the signal of {name!r} at t = {time:.9g} s: {type(error).__name__}: {error} The results up to there are "
            "kept. Correct the function given in inputs; status.error is the exception, with its traceback."
        )
        return cls(False, "input failed", text, time, error=error)

    @classmethod
    def not_written(cls, time: float, path: str, error: Exception) -> Status:
        """Report that results could not be written to disk.

        Parameters
        ----------
        time : float
            Up to which the run went, s.
        path : str
            The file.
        error : Exception
            What was raised.

        Returns
        -------
        Status
            Not ``ok``; the exception is its ``error``.
        """
        text = (
            f"{path} could not be written at t = {time:.9g} s: {error}. What was written before is complete and "
            "can be read, and this solution has all results up to there. Make room, or correct the rights, and call "
            "ph.resume."
        )
        return cls(False, "not written", text, time, error=error)

    @classmethod
    def interrupted(cls, time: float, path: str) -> Status:
        """Report that a run on disk has no end: it was killed, or still goes on.

        Parameters
        ----------
        time : float
            Of its last checkpoint, s.
        path : str
            The file.

        Returns
        -------
        Status
            Not ``ok``.
        """
        text = f"the run was killed, or still goes on; ph.resume({path!r}, system) goes on from t = {time:.9g} s"
        return cls(False, "interrupted", text, time)


@dataclass(frozen=True)
class Statistics:
    """What a run took.

    Parameters
    ----------
    steps : int
        Accepted steps.
    halvings : int
        Steps that failed and were halved.
    newton_iterations : numpy.ndarray
        Of each accepted step, shape (steps,).
    preparation_seconds, loop_seconds : float
        Time before and in the time loop, s.
    start_energy_change : float
        Stored energy that the start gained when it was projected on the constraints, J; 0 if it satisfied them.
    rejections : int, optional
        Steps whose estimated error was too large and that were repeated with a shorter one.
    lag : numpy.ndarray, optional
        Consistency of a linearly implicit method, of each accepted step, shape (steps,): how far the extrapolated
        state that fixed the structure was from the state in the middle, in the energy norm, relative.
    residual : numpy.ndarray, optional
        What Newton's method left of each accepted step, shape (steps,): estimated size of the update that one iteration
        more would have made, in the energy norm, relative to the state. A step is accepted when that is below the
        tolerance of the method (1e-15), or when it is round-off (and then at most 1e-8).
    projections : int, optional
        How often loops were closed (``Projection``).
    largest_gap : float, optional
        The largest jump at a joint that was closed then, m.
    projection_energy_change : float, optional
        Energy that this added, stored and of gravity, J.
    """

    steps: int
    halvings: int
    newton_iterations: Ints
    preparation_seconds: float
    loop_seconds: float
    start_energy_change: float = 0.0
    rejections: int = 0
    lag: Floats = field(default_factory=lambda: np.zeros(0))
    residual: Floats = field(default_factory=lambda: np.zeros(0))
    projections: int = 0
    largest_gap: float = 0.0
    projection_energy_change: float = 0.0

    def __repr__(self) -> str:
        """Summarise in one line, without the numbers of every step."""
        return f"<Statistics: {self}>"

    def __str__(self) -> str:
        """Summarise in one line."""
        mean = float(self.newton_iterations.mean()) if self.newton_iterations.size else 0.0
        projected = f", start projected ({self.start_energy_change:+.3g} J)" if self.start_energy_change else ""
        rejected = f", {self.rejections} rejections" if self.rejections else ""
        largest = float(self.lag.max(initial=0.0))
        lagging = f", structure off by {largest:.2g}" if largest else ""
        closed = ""
        if self.projections:
            closed = f", loops closed {self.projections} times ({self.projection_energy_change:+.3g} J)"
        return (
            f"{self.steps} steps, {mean:.2f} Newton iterations a step, {self.halvings} halvings{rejected}, "
            f"{self.loop_seconds:.3g} s{lagging}{projected}{closed}"
        )


class EnergySeries(Mapping[str, Floats]):
    """Named series of energies, J: as a mapping or by attribute, ``energy["kinetic"]`` or ``energy.kinetic``.

    Parameters
    ----------
    series : mapping of str to numpy.ndarray
        Each of shape (times,).
    """

    def __init__(self, series: Mapping[str, Floats]) -> None:
        self._series = dict(series)

    def __repr__(self) -> str:
        """Name the series."""
        return f"<EnergySeries: {', '.join(self)}>"

    def __getitem__(self, name: str) -> Floats:
        """Return one series; an unknown name raises :class:`~phblocks.errors.UnknownNameError`."""
        if name not in self._series:
            raise UnknownNameError(
                "energy", expected=f"one of {', '.join(self._series)}", got=repr(name), fix="Check the name."
            )
        return self._series[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return iter(self._series)

    def __len__(self) -> int:
        """Count the series."""
        return len(self._series)

    def __getattr__(self, name: str) -> Floats:
        """Return one series by attribute."""
        if name.startswith("_") or name not in self._series:
            raise AttributeError(f"no energy {name!r}; there are {', '.join(self.__dict__.get('_series', ()))}")
        return self._series[name]
