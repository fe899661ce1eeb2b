"""States without a rate at the ends of steps, from the stages, where alone they are known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from phblocks.system import System
from phblocks.triplets import Floats

#: Steps that an extrapolation looks back on.
SEEN = 3
#: An extrapolation further than this, in distances of the means it starts from, is not trusted.
FARTHEST = 2.0


class Middles:
    """Values of the states without a rate (multipliers, the states of stateless parts) over the steps of a run.

    A method with one stage knows them in the middle of each step. At a time between two steps of lengths h and k their
    mean is taken, ``m = (h a + k b) / (h + k)``: the constant force of the same impulse. What alternates from step to
    step (its impulse does) cancels; for equal steps it is of second order, else it belongs to the middle of both steps.
    At both ends of the run two such means are extrapolated: for equal steps ``2 m_1 - m_2 = a_1 + (a_2 - a_3) / 2``, in
    which it cancels too. Methods with more stages say what the values at the end of a step are; at the start it is
    the polynomial through the stages of the first step.

    Parameters
    ----------
    system : System
        The system.
    nodes : sequence of float
        Where in a step its stages are, as fractions of it.

    Attributes
    ----------
    states : numpy.ndarray
        Their places among the states.
    between : bool
        Values at the end of a step need the step after it.
    """

    def __init__(self, system: System, nodes: Sequence[float]) -> None:
        self.states = np.flatnonzero(system.algebraic & ~system.coenergy)
        self.between = bool(self.states.size) and len(nodes) == 1
        powers = np.array(nodes)[:, None] ** np.arange(len(nodes))
        self._to_start = np.linalg.solve(powers.T, np.eye(len(nodes))[0])
        self._first = self._last = (np.zeros(0), np.zeros((0, self.states.size)))

    def add(self, dt: Floats, z: Floats) -> tuple[Floats | None, Floats | None, Floats | None]:
        """Take in steps.

        Parameters
        ----------
        dt : numpy.ndarray
            Their lengths, shape (steps,), s.
        z : numpy.ndarray
            States at the stages, shape (steps, stages, n).

        Returns
        -------
        start : numpy.ndarray or None
            Values at the start of the run, shape (n_states,), if these steps tell.
        before : numpy.ndarray or None
            Values at the start of the first of these steps, shape (n_states,), if it is not that of the run.
        ends : numpy.ndarray or None
            Values at the ends of these steps, shape (steps, n_states), the last one extrapolated; ``None`` if they are
            what the method says.
        """
        if not self.states.size:
            return None, None, None
        known, start = self._first[0].size, None
        if known < SEEN:
            stages = z[: SEEN - known][..., self.states]
            self._first = _joined(
                self._first, dt[: SEEN - known], stages[:, 0] if self.between else self._to_start @ stages
            )
            start = _extrapolated(*self._first) if self.between else self._first[1][0]
        if not self.between:
            return start, None, None
        h, a = _joined(self._last, dt, z[:, 0, self.states])
        self._last = h[-SEEN:], a[-SEEN:]
        inner = _means(h, a)
        last = _extrapolated(h[: -SEEN - 1 : -1], a[: -SEEN - 1 : -1])
        ends = np.vstack([inner, last])[-dt.size :]
        return start, inner[-dt.size] if inner.shape[0] >= dt.size else None, ends

    @property
    def waiting(self) -> bool:
        """Whether the values at the end of the last step, or at the start of the run, depend on what follows."""
        return self.between or (bool(self.states.size) and not self._first[0].size)

    def memory(self) -> dict[str, Floats]:
        """Return what it remembers of the steps so far.

        Returns
        -------
        dict of str to numpy.ndarray
            For :meth:`remember`.
        """
        pairs = {"first": self._first, "last": self._last}
        return {f"{name}_{part}": array for name, pair in pairs.items() for part, array in zip("ha", pair, strict=True)}

    def remember(self, memory: Mapping[str, Floats]) -> None:
        """Go on from there.

        Parameters
        ----------
        memory : mapping of str to numpy.ndarray
            From :meth:`memory`.
        """
        self._first = memory["first_h"], memory["first_a"]
        self._last = memory["last_h"], memory["last_a"]


def _joined(pair: tuple[Floats, Floats], dt: Floats, values: Floats) -> tuple[Floats, Floats]:
    return np.concatenate([pair[0], dt]), np.concatenate([pair[1], values])


def _extrapolated(h: Floats, a: Floats) -> Floats:
    """Values at the outer end of the first of up to three steps; without a third, the mean of what there is."""
    if h.size < 2:
        return np.asarray(a[0])
    near, *far = _means(h, a)
    reach = (h[0] + h[1]) / (h[0] + h[2]) if far else np.inf
    return np.asarray(near + reach * (near - far[0]) if reach <= FARTHEST else near)


def _means(h: Floats, a: Floats) -> Floats:
    """Of each two neighbours."""
    impulse = h[:, None] * a
    return np.asarray((impulse[1:] + impulse[:-1]) / (h[1:] + h[:-1])[:, None])
