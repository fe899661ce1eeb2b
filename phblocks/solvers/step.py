"""What a time method returns for one accepted step, and what it raises if there is none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from phblocks.triplets import Floats, Ints

#: Scaled states, roots of energies, of which the squares can be summed for sure.
SAFE = 1e140


@dataclass(frozen=True)
class Step:
    """One accepted step, in scaled and reordered unknowns.

    Parameters
    ----------
    x : numpy.ndarray
        Unknowns at the end, shape (n,).
    theta : numpy.ndarray
        Rotation states at the end, shape (n_theta,), rad.
    z : numpy.ndarray
        Unknowns at the stages, shape (stages, n).
    theta_z : numpy.ndarray
        Rotation states at the stages, shape (stages, n_theta).
    u : numpy.ndarray
        Inputs at the stages, shape (stages, n_inputs).
    dt : float
        Length, s.
    iterations : int
        Newton iterations, or linear solves of a method without iteration; 0 for a linear system.
    frozen : numpy.ndarray, optional
        Unknowns that fixed the structure at the stages, shape (stages, n), if not z.
    lag : float, optional
        How far they were from z in the energy norm, relative.
    residual : float, optional
        Size of the update that one iteration more would have made, in the energy norm, relative to the state.
    points : numpy.ndarray, optional
        Positions of the material points at the end, shape (n_points, dimension), m, if not by the velocities at the
        stages.
    damped : numpy.ndarray, optional
        Unknowns whose energy the method takes away, shape (n,), beside what is dissipated; if it takes any.
    before : numpy.ndarray, optional
        Unknowns at the end before they were projected, shape (n,), if they were.
    shift : numpy.ndarray, optional
        By how much that moved the material points, shape (n_points, dimension), m.
    """

    x: Floats
    theta: Floats
    z: Floats
    theta_z: Floats
    u: Floats
    dt: float
    iterations: int
    frozen: Floats | None = None
    lag: float = 0.0
    residual: float = 0.0
    points: Floats | None = None
    damped: Floats | None = None
    before: Floats | None = None
    shift: Floats | None = None


@dataclass(frozen=True)
class Steps:
    """Accepted steps, one after the other: those of :class:`Step`, in arrays with a row for each.

    Parameters
    ----------
    x, theta : numpy.ndarray
        Unknowns and rotation states at the ends, shapes (steps, n) and (steps, n_theta).
    z, theta_z, u : numpy.ndarray
        Unknowns, rotation states and inputs at the stages, shapes (steps, stages, n), (steps, stages, n_theta) and
        (steps, stages, n_inputs).
    dt : numpy.ndarray
        Lengths, shape (steps,), s.
    iterations, residual, lag : numpy.ndarray
        Shape (steps,).
    frozen : numpy.ndarray, optional
        Shape (steps, stages, n).
    points, shift : numpy.ndarray, optional
        Shape (steps, n_points, dimension), m.
    damped, before : numpy.ndarray, optional
        Shape (steps, n).
    """

    x: Floats
    theta: Floats
    z: Floats
    theta_z: Floats
    u: Floats
    dt: Floats
    iterations: Ints
    residual: Floats
    lag: Floats
    frozen: Floats | None = None
    points: Floats | None = None
    damped: Floats | None = None
    before: Floats | None = None
    shift: Floats | None = None

    def __len__(self) -> int:
        return int(self.dt.size)

    @classmethod
    def of(cls, step: Step) -> Steps:
        """Make one of a single step.

        Parameters
        ----------
        step : Step
            The step.

        Returns
        -------
        Steps
            With one row.
        """
        return cls(**_taken(step, lambda value: np.asarray(value)[None]))

    @classmethod
    def join(cls, parts: Sequence[Steps]) -> Steps:
        """Put steps together, in their order.

        Parameters
        ----------
        parts : sequence of Steps
            At least one.

        Returns
        -------
        Steps
            All rows. Where only some parts have what is optional, the others have what means the same as nothing.
        """
        if len(parts) == 1:
            return parts[0]
        shift = next((part.shift[:1] for part in parts if part.shift is not None), np.zeros((1, 0)))
        nothing: dict[str, Callable[[Steps], Floats]] = {
            "frozen": lambda part: part.z,
            "damped": lambda part: np.zeros_like(part.x),
            "before": lambda part: part.x,
            "shift": lambda part: np.zeros_like(shift).repeat(len(part), axis=0),
        }
        arrays: dict[str, Any] = {}
        for name in STEP_FIELDS:
            found = [getattr(part, name) for part in parts]
            if any(array is not None for array in found):
                full = [nothing[name](p) if array is None else array for p, array in zip(parts, found, strict=True)]
                arrays[name] = np.concatenate(full)
        return cls(**arrays)

    def first(self, count: int) -> Steps:
        """Return the first of them.

        Parameters
        ----------
        count : int
            How many.

        Returns
        -------
        Steps
            Views; these steps themselves if it is all of them.
        """
        return self if count == len(self) else Steps(**_taken(self, lambda array: array[:count]))

    @cached_property
    def last(self) -> Step:
        """The last step, always the same: what a method that looks back takes for the end of it."""
        return self.row(len(self) - 1)

    def row(self, i: int) -> Step:
        """Return one of them.

        Parameters
        ----------
        i : int
            Its number, from 0.

        Returns
        -------
        Step
            Views.
        """
        rows = _taken(self, lambda array: array[i])
        return Step(**rows | {name: rows[name].item() for name in ("dt", "iterations", "residual", "lag")})


#: What both consist of.
STEP_FIELDS = tuple(field.name for field in fields(Steps))


def _taken(source: Step | Steps, take: Callable[[Any], Any]) -> dict[str, Any]:
    """Take something of each field that there is."""
    values = {name: getattr(source, name) for name in STEP_FIELDS}
    return {name: None if value is None else take(value) for name, value in values.items()}


class StepFailed(Exception):
    """No step could be taken, however short; ends the run with a status.

    Parameters
    ----------
    time : float
        Start of the step, s.
    dt : float
        The shortest that was tried, s.
    why : str, optional
        What happened.
    state : str, optional
        Name of the state whose equation was missed by most.
    """

    def __init__(
        self, time: float, dt: float, why: str = "Newton's method did not converge", state: str | None = None
    ) -> None:
        super().__init__(f"{why} at t = {time}")
        self.time, self.dt, self.why, self.state = time, dt, why, state


def failure(stage: object) -> tuple[str, str | None]:
    """Ask what a stepper works with why no step was found.

    Parameters
    ----------
    stage : object
        Such as ``StageEquation``; that of a method of the user's need not know.

    Returns
    -------
    why : str
        What happened.
    state : str or None
        Name of the state whose equation was missed by most.
    """
    return getattr(stage, "why", "the method found no solution"), getattr(stage, "worst_state", None)
