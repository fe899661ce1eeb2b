"""The direct-current motor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from phblocks.blocks.block import PortChoice, Tie
from phblocks.blocks.branch import Lumped, branch_form, state
from phblocks.blocks.checks import require_finite, require_not_negative, require_positive
from phblocks.blocks.form import NO_ENERGY, Form
from phblocks.ports import ELECTRICAL, ROTATION
from phblocks.space import PLANAR, Space


class DCMotor(Lumped):
    """A direct-current motor: winding, and one constant for moment and induced voltage.

    ``L i' = u_p - u_n - R i - k (w_shaft - w_stator)``; the shaft is driven by ``k i``, the stator by ``-k i``. The
    inertia of the rotor is a RigidBody on the shaft, if it matters.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    resistance : float
        R, ohm.
    constant : float
        k, N m/A, which is V s/rad.
    inductance : float, optional
        L, H; 0 by default: then the current follows the voltage at once.
    current : float, optional
        i at the start, A.

    Attributes
    ----------
    p, n : Port
        The terminals; n usually at a Reference.
    shaft, stator : Port
        Ports of rotation that take angular velocity; the stator usually at ``diagram.ground.rotation``.

    Raises
    ------
    DataError
        If a number is out of its range.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    def __init__(
        self, name: str, resistance: float, constant: float, inductance: float = 0.0, current: float = 0.0
    ) -> None:
        super().__init__(name)
        where = f"DCMotor {name!r}"
        self.resistance = require_positive(f"{where} resistance", resistance)
        self.constant = require_finite(f"{where} constant", constant)
        self.inductance = require_not_negative(f"{where} inductance", inductance)
        self.current = require_finite(f"{where} current", current)
        self.p = self._add_port("p", ELECTRICAL)
        self.n = self._add_port("n", ELECTRICAL)
        self.shaft = self._add_port("shaft", ROTATION)
        self.stator = self._add_port("stator", ROTATION)

    @property
    def space(self) -> Space:
        """The plane, where a moment is one number."""
        return PLANAR

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that the terminals may give voltage, and that shaft and stator take angular velocity.

        Returns
        -------
        choices : sequence of PortChoice
            Four.
        ties : sequence of Tie
            None.
        """
        return [PortChoice(p, may_give=p.domain == ELECTRICAL, may_take=True) for p in self._ports], []

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the motor to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            For each port.

        Returns
        -------
        Form
            The current, and the voltage of each terminal that gives it.
        """
        k, energy = self.constant, "magnetic" if self.inductance else NO_ENERGY
        ends = {self.p: 1.0, self.n: -1.0, self.shaft: -k, self.stator: k}
        start = self.current if self.inductance else 0.0
        return branch_form(ends, gives, state("current", "A", energy), self.inductance, self.resistance, start)
