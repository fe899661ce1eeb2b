"""What a time method returns for one accepted step, and what it raises if there is none."""

from __future__ import annotations

from dataclasses import dataclass

from phblocks.triplets import Floats


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
