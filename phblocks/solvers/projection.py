"""Runs whose loops are closed now and then, with the energy that this changes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from phblocks.errors import ArgumentTypeError, DataError
from phblocks.inputs import Drive
from phblocks.solvers.loops import Loops
from phblocks.solvers.method import Booked, Resumable, Unknowns
from phblocks.solvers.step import Step, StepFailed, Steps
from phblocks.system import State, System
from phblocks.system.constraints import consistent_start
from phblocks.triplets import Floats

#: A gap that is left, relative to the size of the diagram, with which a run ends.
OPEN = 1e-8


@dataclass(frozen=True)
class Projection:
    """Closes loops: joints hold velocities together, and positions drift apart with the square of the step.

    After every step, or every so many, the positions that strain and orientation tell are made to close around every
    loop again, by the displacement with the least strain energy; among displacements without strain, such as links that
    turn on their pins, by that of the least mass. Strains, orientations, spans of springs and the positions of masses
    follow it together; velocities stay (those of joints with multipliers are projected on their constraints). The
    energy this changes is a series of its own, ``solution.energy.projected``, a column of ``solution.power``, and in
    ``solution.statistics.projection_energy_change``.

    Where the gap comes from time steps alone (rigid parts), the order of the method stays. Beams have a part of it from
    their mesh, however short the steps, of order h^2 at degree 1: it is taken away too, and what comes back of it in
    every step is an error of first order, small as it is. What the method remembers of the steps before is lost at each
    projection. Diagrams without loops, or with gaps of round-off only, are left alone.

    Parameters
    ----------
    every : int, optional
        Steps from one projection to the next; each by default.

    Raises
    ------
    DataError
        If it is not positive.
    ArgumentTypeError
        If it is not an integer.

    Notes
    -----
    Derived in ``docs/theory.md``; that projections keep the order: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical
    Integration, 2nd ed., IV.4, doi:10.1007/3-540-30666-8.
    """

    every: int = 1

    def __post_init__(self) -> None:
        """Check the value."""
        if isinstance(self.every, bool) or not isinstance(self.every, (int, np.integer)):
            raise ArgumentTypeError("Projection every", expected="an integer", got=repr(self.every), fix="Use 1.")
        if self.every < 1:
            raise DataError("Projection every", expected="an integer >= 1", got=repr(self.every), fix="Use 1.")


class ProjectedSteps:
    """Goes the way of another walk and closes loops at the ends of some of its steps.

    Parameters
    ----------
    walk : Resumable
        The other walk, which yields one step at a time.
    system : System
        The system.
    drive : Drive
        The inputs.
    start : State
        Where the other walk starts.
    options : Projection
        How often.

    Attributes
    ----------
    projections : int
        How often loops were closed so far.
    energy_change : float
        Energy that this added, J.
    largest_gap : float
        The largest jump at a joint that was closed, m.

    Raises
    ------
    DataError
        If an imposed motion may have displaced the start already: by how much is not part of a state.
    """

    def __init__(self, walk: Resumable, system: System, drive: Drive, start: State, options: Projection) -> None:
        self._walk, self._system, self._drive, self._every = walk, system, drive, int(options.every)
        self._loops = Loops(system)
        self._moved, self._since = np.zeros(system.n_inputs), 0
        self._require_known(start)
        self.projections, self.energy_change, self.largest_gap = 0, 0.0, 0.0

    @property
    def stage(self) -> Unknowns:
        """Changes states to unknowns and back."""
        return self._walk.stage

    @property
    def weights(self) -> tuple[float, ...]:
        """Of the stages of each step."""
        return self._walk.weights

    @property
    def nodes(self) -> tuple[float, ...]:
        """Where in a step its stages are, as fractions of it."""
        return self._walk.nodes

    @property
    def steps(self) -> int:
        """Accepted steps so far."""
        return self._walk.steps

    @property
    def halvings(self) -> int:
        """Steps so far that failed and were made shorter."""
        return self._walk.halvings

    @property
    def rejections(self) -> int:
        """Steps so far whose estimated error was too large."""
        return self._walk.rejections

    def __iter__(self) -> Iterator[Booked]:
        """Go; see :class:`~phblocks.solvers.method.Walk`."""
        going = True
        while going:
            going = False
            for steps, at, saved in self._walk:
                step = steps.last
                self._moved = self._moved + step.dt * (np.array(self.weights) @ step.u)
                self._since += 1
                mark = self._walk.mark() if self._since >= self._every and self._loops.count else None
                if mark is None:
                    yield steps, at, saved
                    continue
                projected = self._project(step, float(at[-1]))
                self._since, going = 0, projected is not step
                if going:
                    self._walk.resume({**mark, "x": projected.x, "theta": projected.theta})
                yield Steps.of(projected), at, saved
                if going:
                    break

    def mark(self) -> dict[str, Floats] | None:
        """Return where it is; see :class:`~phblocks.solvers.method.Resumable`.

        Returns
        -------
        dict of str to numpy.ndarray or None
            For :meth:`resume`; ``None`` where it cannot be left.
        """
        mark = self._walk.mark()
        if mark is None:
            return None
        told = np.array([self.energy_change, self.largest_gap])
        counts = np.array([self._since, self.projections], dtype=np.int64)
        return {**mark, "projection_counts": counts, "projection_told": told, "projection_moved": self._moved}

    def resume(self, mark: Mapping[str, Floats]) -> None:
        """Go there; see :class:`~phblocks.solvers.method.Resumable`.

        Parameters
        ----------
        mark : mapping of str to numpy.ndarray
            From :meth:`mark`.
        """
        self._walk.resume(mark)
        self._since, self.projections = map(int, mark["projection_counts"])
        self.energy_change, self.largest_gap = map(float, mark["projection_told"])
        self._moved = mark["projection_moved"]

    def _require_known(self, start: State) -> None:
        """Refuse a start from which loops would be closed onto the place where an imposed motion began."""
        gap = self._loops.unaccounted(start)
        if gap > self._loops.allowed(OPEN):
            raise DataError(
                f"simulate start of system {self._system.name!r}",
                expected="with projection, loops that close through imposed motions where those began",
                got=f"a gap of {gap:.3g} m, and how far imposed motions had come by then is not part of a State",
                fix="Start from the initial configuration, resume a saved run (ph.resume), or leave out projection.",
            )

    def _project(self, step: Step, at: float) -> Step:
        """Close the loops at the end of a step; the same step if they are closed."""
        system, stage = self._system, self.stage
        before = State(stage.unpack(step.x), step.theta, np.zeros_like(system.start.points))
        closure = self._loops.close(before, self._moved)
        if closure.left > self._loops.allowed(OPEN):
            raise StepFailed(at, step.dt, f"a loop that had opened by {closure.gap:.3g} m could not be closed")
        if closure.state is before:
            return step
        after = closure.state
        if system.is_dae:
            after = consistent_start(system, after, self._drive.at([at])[0])[0]
        lifted = -float(system.point_mass @ (after.points @ system.gravity))
        self.energy_change += system.energy(after.x) - system.energy(before.x) + lifted
        self.largest_gap = max(self.largest_gap, closure.gap)
        self.projections += 1
        return replace(step, x=stage.pack(after.x), theta=after.theta, before=step.x, shift=after.points)
