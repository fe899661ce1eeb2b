"""Two-terminal parts of circuits, electrical, hydraulic or of a domain of the user's: resistor, inductor, capacitor.

They have two ports, ``p`` and ``n``, and one through quantity, positive from p to n inside the part. Where nothing
else gives the common quantity (voltage) of a junction, one of them does: it then has a state without energy for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from phblocks.blocks.block import PortChoice, Tie
from phblocks.blocks.branch import Lumped, branch_form, state
from phblocks.blocks.checks import require_finite, require_positive
from phblocks.blocks.form import Form, PortForm, StateRun
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.ports import ELECTRICAL, Domain, Port
from phblocks.triplets import Triplets


def require_scalar_domain(where: str, domain: object) -> Domain:
    """Return a domain if its quantities are numbers, not vectors.

    Parameters
    ----------
    where : str
        Of which part, for the message.
    domain : object
        The candidate.

    Returns
    -------
    Domain
        The domain.

    Raises
    ------
    ArgumentTypeError
        If it is not a domain.
    DataError
        If its quantities turn with space.
    """
    if not isinstance(domain, Domain):
        raise ArgumentTypeError(where, expected="a Domain", got=repr(domain), fix="Use ph.ELECTRICAL, for example.")
    if domain.turns_with is not None:
        raise DataError(
            where, expected="a domain of scalars", got=domain.name, fix="Use the parts made for mechanisms."
        )
    return domain


class _TwoTerminal(Lumped):
    """Two ports of a scalar domain; each may give or take the common quantity."""

    def __init__(self, name: str, domain: Domain, energy: str | None = None) -> None:
        super().__init__(name)
        self.domain = require_scalar_domain(f"{type(self).__name__} {name!r} domain", domain)
        self.p = self._add_port("p", domain)
        self.n = self._add_port("n", domain)
        self._energy = energy

    @property
    def _ends(self) -> dict[Port, float]:
        return {self.p: 1.0, self.n: -1.0}

    def _kind(self, electrical: str) -> str:
        return self._energy or (electrical if self.domain == ELECTRICAL else self.domain.name)

    def _through(self, *energy: str) -> StateRun:
        return state(self.domain.summed.name, self.domain.summed.unit, *energy)

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that each port may give or take.

        Returns
        -------
        choices : sequence of PortChoice
            One for each port.
        ties : sequence of Tie
            None.
        """
        return [PortChoice(port, may_give=True, may_take=True) for port in self._ports], []


class Resistor(_TwoTerminal):
    """A resistor: ``u_p - u_n = R i``.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    resistance : float
        R, common quantity per summed quantity: ohm, or Pa s/m^3.
    domain : Domain, optional
        Electrical by default.

    Attributes
    ----------
    p, n : Port
        The terminals.

    Raises
    ------
    DataError
        If a number is out of its range.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    def __init__(self, name: str, resistance: float, domain: Domain = ELECTRICAL) -> None:
        super().__init__(name, domain)
        self.resistance = require_positive(f"Resistor {name!r} resistance", resistance)

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the resistor to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            For each port.

        Returns
        -------
        Form
            The through quantity, and the common one of each port that gives; no energy.
        """
        return branch_form(self._ends, gives, self._through(), r=self.resistance)


class Inductor(_TwoTerminal):
    """An inductor: ``L i' = u_p - u_n``; in other domains a fluid's inertia, or a spring between velocities.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    inductance : float
        L, common quantity times second per summed quantity: H, or Pa s^2/m^3.
    current : float, optional
        i at the start.
    domain : Domain, optional
        Electrical by default.
    energy : str, optional
        Kind of energy; by default "magnetic", in other domains their name.

    Attributes
    ----------
    p, n : Port
        The terminals.

    Raises
    ------
    DataError
        If a number is out of its range.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    def __init__(
        self,
        name: str,
        inductance: float,
        current: float = 0.0,
        domain: Domain = ELECTRICAL,
        energy: str | None = None,
    ) -> None:
        super().__init__(name, domain, energy)
        self.inductance = require_positive(f"Inductor {name!r} inductance", inductance)
        self.current = require_finite(f"Inductor {name!r} current", current)

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the inductor to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            For each port.

        Returns
        -------
        Form
            The through quantity, and the common one of each port that gives.
        """
        return branch_form(
            self._ends, gives, self._through(self._kind("magnetic")), e=self.inductance, start=self.current
        )


class Capacitor(_TwoTerminal):
    """A capacitor: ``C (u_p - u_n)' = i``; in other domains an accumulator, or a mass with n at the reference.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    capacitance : float
        C, summed quantity times second per common quantity: F, or m^3/Pa.
    voltage : float, optional
        ``u_p - u_n`` at the start.
    domain : Domain, optional
        Electrical by default.
    energy : str, optional
        Kind of energy; by default "electric", in other domains their name.

    Attributes
    ----------
    p, n : Port
        The terminals.

    Raises
    ------
    DataError
        If a number is out of its range.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    def __init__(
        self,
        name: str,
        capacitance: float,
        voltage: float = 0.0,
        domain: Domain = ELECTRICAL,
        energy: str | None = None,
    ) -> None:
        super().__init__(name, domain, energy)
        self.capacitance = require_positive(f"Capacitor {name!r} capacitance", capacitance)
        self.voltage = require_finite(f"Capacitor {name!r} voltage", voltage)

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the capacitor to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            For each port.

        Returns
        -------
        Form
            The through quantity, the difference of the common one, and that of each port that gives.
        """
        common = self.domain.common
        return branch_form(
            self._ends,
            gives,
            self._through(),
            charge=state(common.name, common.unit, self._kind("electric")),
            e_charge=self.capacitance,
            start_charge=self.voltage,
        )


class Reference(Lumped):
    """What the common quantity is counted from: it gives zero to any number of junctions.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    domain : Domain, optional
        Electrical by default: earth.

    Attributes
    ----------
    port : Port
        May be joined more than once.

    Raises
    ------
    DataError
        If the domain is not one of scalars.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    shared = True

    def __init__(self, name: str, domain: Domain = ELECTRICAL) -> None:
        super().__init__(name)
        self.port = self._add_port("port", require_scalar_domain(f"Reference {name!r} domain", domain))

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that the reference gives.

        Returns
        -------
        choices : sequence of PortChoice
            One.
        ties : sequence of Tie
            None.
        """
        return [PortChoice(self.port, may_give=True, may_take=False)], []

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the reference to no states at all.

        Parameters
        ----------
        gives : mapping of str to bool
            Always true.

        Returns
        -------
        Form
            Without states; what it gives is zero.
        """
        none = Triplets.empty()
        ports = {"port": PortForm(True, ())}
        return Form(size=0, runs=(), E=none, J0=none, R=none, T=Triplets.empty(3), ports=ports)
