"""What ``simulate`` needs of a time method: what to write for a method of your own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from phblocks.inputs import Drive
from phblocks.solvers.schedule import Schedule
from phblocks.solvers.step import Step, Steps
from phblocks.system import State, System
from phblocks.triplets import Floats

#: Accepted steps, the times at their ends, s, and which of these to save; arrays of shape (steps,).
Booked = tuple[Steps, Floats, NDArray[np.bool_]]


class Unknowns(Protocol):
    """Changes states to the unknowns a stepper works with and back; ``StageEquation`` is one."""

    def pack(self, x: Floats) -> Floats:
        """Change states to unknowns.

        Parameters
        ----------
        x : numpy.ndarray
            Shape (..., n).

        Returns
        -------
        numpy.ndarray
            Shape (..., n).
        """
        ...

    def unpack(self, unknowns: Floats) -> Floats:
        """Change unknowns to states.

        Parameters
        ----------
        unknowns : numpy.ndarray
            Shape (..., n).

        Returns
        -------
        numpy.ndarray
            Shape (..., n).
        """
        ...


@runtime_checkable
class Stepper(Protocol):
    """Takes steps of one system. It may remember steps: a run that goes on passes the array the last one ended with."""

    @property
    def stage(self) -> Unknowns:
        """Changes states to unknowns and back."""
        ...

    @property
    def nodes(self) -> tuple[float, ...]:
        """Where in a step the inputs are evaluated, as fractions of it."""
        ...

    @property
    def weights(self) -> tuple[float, ...]:
        """Of the stages: powers and velocities there, times these, are what a step books."""
        ...

    def step(self, x: Floats, theta: Floats, dt: float, u: Floats) -> Step | None:
        """Take one step.

        Parameters
        ----------
        x : numpy.ndarray
            Unknowns at its start, shape (n,).
        theta : numpy.ndarray
            Rotation states there, shape (n_theta,), rad.
        dt : float
            Its length, s.
        u : numpy.ndarray
            Inputs at the nodes, shape (nodes, n_inputs).

        Returns
        -------
        Step or None
            ``None`` if there is no solution: the step is then repeated with half its length.
        """
        ...


@runtime_checkable
class Marching(Stepper, Protocol):
    """Takes several steps of one length at a time, which costs less than as many calls."""

    def march(self, x: Floats, theta: Floats, dt: float, u: Floats) -> Steps | None:
        """Take steps, one after the other.

        Parameters
        ----------
        x, theta : numpy.ndarray
            Where the first begins, as in :meth:`Stepper.step`.
        dt : float
            Their length, s.
        u : numpy.ndarray
            Inputs at the nodes of each, shape (steps, nodes, n_inputs).

        Returns
        -------
        Steps or None
            As far as there are solutions, at least one; ``None`` if the first step has none. They may end earlier,
            and should where numbers become too large: the run asks again from there.
        """
        ...


@runtime_checkable
class Method(Protocol):
    """A one-step method; the step is that of the run, or of ``Adaptive``."""

    @property
    def order(self) -> int:
        """Order of convergence on smooth solutions."""
        ...

    def prepare(self, system: System) -> Stepper:
        """Do once what does not change during a run.

        Parameters
        ----------
        system : System
            The system to integrate.

        Returns
        -------
        Stepper
            Ready for steps.

        Raises
        ------
        MethodError
            If the method does not suit the system.
        """
        ...


class Walk(Protocol):
    """The way of a run through time, step by step."""

    @property
    def stage(self) -> Unknowns:
        """Changes states to unknowns and back."""
        ...

    @property
    def weights(self) -> tuple[float, ...]:
        """Of the stages of each step."""
        ...

    @property
    def nodes(self) -> tuple[float, ...]:
        """Where in a step its stages are, as fractions of it."""
        ...

    @property
    def steps(self) -> int:
        """Accepted steps so far."""
        ...

    @property
    def halvings(self) -> int:
        """Steps so far that failed and were made shorter."""
        ...

    @property
    def rejections(self) -> int:
        """Steps so far whose estimated error was too large."""
        ...

    def __iter__(self) -> Iterator[Booked]:
        """Go; yields accepted steps, one or several at a time, with the times at their ends and which of them to save.

        Raises :class:`StepFailed`, :class:`~phblocks.inputs.NotFinite` or :class:`~phblocks.inputs.InputFailed` where
        it cannot go on.
        """
        ...


@runtime_checkable
class Resumable(Walk, Protocol):
    """A walk that can forget how it came to where it is, and go on from there: for checkpoints.

    What it remembers besides the state (factors, past steps) it loses at every checkpoint, in a run that goes on as in
    one that is resumed, so that both take the same steps.
    """

    def mark(self) -> dict[str, Floats] | None:
        """Return everything that is needed to go on from the last step that was yielded.

        Returns
        -------
        dict of str to numpy.ndarray or None
            With "input_times" and "inputs", shapes (times,) and (times, n_inputs): what the inputs gave last. ``None``
            where it cannot be left, such as in the middle of a step that was halved.
        """
        ...

    def resume(self, mark: Mapping[str, Floats]) -> None:
        """Go there; the next iteration goes on from there.

        Parameters
        ----------
        mark : mapping of str to numpy.ndarray
            From :meth:`mark`, of this walk or of another one of the same run.
        """
        ...


@runtime_checkable
class Integrator(Protocol):
    """A method that chooses its steps itself and needs the inputs as functions of time."""

    def integrate(self, system: System, drive: Drive, start: State, schedule: Schedule) -> Walk:
        """Prepare a run.

        Parameters
        ----------
        system : System
            The system to integrate.
        drive : Drive
            The inputs.
        start : State
            Where it starts.
        schedule : Schedule
            Its times.

        Returns
        -------
        Walk
            The way through time.

        Raises
        ------
        MethodError
            If the method does not suit the system.
        """
        ...
