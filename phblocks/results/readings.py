"""What can be read of a run by the names of states, blocks and ports alone."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np

from phblocks.blocks.form import CONFIGURATION, NO_ENERGY
from phblocks.errors import UnknownNameError
from phblocks.results.health import Health
from phblocks.results.labels import Labels
from phblocks.results.limits import Limits
from phblocks.results.power import PowerLedger
from phblocks.results.recording import Recording
from phblocks.results.status import EnergySeries, Statistics, Status
from phblocks.triplets import Floats


class Readings(ABC):
    """States, energies and powers of a run; a base of :class:`~phblocks.results.solution.Solution`.

    Attributes
    ----------
    recording : Recording
        The arrays.
    status : Status
        How the run ended.
    statistics : Statistics
        What it took.
    limits : Limits
        What its health is judged by.
    """

    recording: Recording
    status: Status
    statistics: Statistics
    limits: Limits

    @property
    @abstractmethod
    def labels(self) -> Labels:
        """The names."""

    def __repr__(self) -> str:
        """Say how far the run went and how it ended."""
        last = f"{self.t.size} times to {self.t[-1]:g} s" if self.t.size else "no times"
        return f"<{type(self).__name__} of {self.labels.name!r}: {last}, {self.status.name}>"

    @property
    def t(self) -> Floats:
        """Saved times, shape (times,), s."""
        return self.recording.t

    @property
    def x(self) -> Floats:
        """States at the saved times, shape (times, n); names in ``system.state_names``."""
        return self.recording.x

    def state(self, name: str) -> Floats:
        """Return the series of one state.

        Parameters
        ----------
        name : str
            Such as ``"crank.V1[0]"``; all of them are in ``system.state_names``.

        Returns
        -------
        numpy.ndarray
            Shape (times,).

        Raises
        ------
        UnknownNameError
            If there is no such state.
        """
        if not isinstance(name, str) or name not in self._places:
            raise UnknownNameError(
                "state",
                expected="one of system.state_names",
                got=repr(name),
                fix=f"For example {self.labels.state_names[0]}.",
            )
        return self.x[:, self._places[name]]

    @cached_property
    def _places(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.labels.state_names)}

    @cached_property
    def energy(self) -> EnergySeries:
        """Energies at the saved times, J: the kinds stored (kinetic, strain), gravity, supplied, dissipated, total.

        Before the total stand numerical_loss, what a method that damps (``RadauIIA``) took away, and projected, what
        closing loops (``Projection``) added; both zero otherwise. Gravity is the potential energy relative to the
        start. Total is what is stored plus gravity; its change is ``supplied - dissipated - numerical_loss +
        projected``.
        """
        ledger = self.recording.ledger
        series = dict(zip(self.labels.energy_kinds, np.moveaxis(ledger.stored.sum(axis=1), 1, 0), strict=True))
        for kind in (NO_ENERGY, CONFIGURATION):
            series.pop(kind, None)
        series["gravity"] = ledger.potential.sum(axis=1)
        total = np.sum(list(series.values()), axis=0)
        series["supplied"] = ledger.supplied.sum(axis=1)
        series["dissipated"] = ledger.dissipated.sum(axis=1)
        series["numerical_loss"] = ledger.numerical.sum(axis=1)
        series["projected"] = ledger.projected.sum(axis=1)
        series["total"] = total
        return EnergySeries(series)

    @property
    def max_power_balance_error(self) -> float:
        """Largest ``|dH - supplied + dissipated + numerical loss - projected|`` of any step, J."""
        return float(self.recording.ledger.balance_error.max(initial=0.0))

    @cached_property
    def power(self) -> PowerLedger:
        """Who gave energy to whom: by block and by connection, with the worst residuals."""
        return PowerLedger(self.labels, self.recording)

    @cached_property
    def health(self) -> Health:
        """Balance, gaps, drifts, unresolved energy and counts, each with a limit and a verdict; prints as a table."""
        return Health(self, self.limits)
