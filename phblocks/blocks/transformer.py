"""Parts that pass power on unchanged: gears and the like (transformers), pistons and the like (gyrators)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from phblocks.blocks.block import PortChoice, Tie
from phblocks.blocks.branch import Lumped, branch_form, lumped_form, state
from phblocks.blocks.checks import require_finite
from phblocks.blocks.form import Form
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.ports import ROTATION, Domain
from phblocks.space import PLANAR, Space


class _Pair(Lumped):
    """Two ports ``first`` and ``second``, each of one component, and a ratio that is not zero."""

    def __init__(self, name: str, ratio: float, first: Domain, second: Domain) -> None:
        super().__init__(name)
        kind = type(self).__name__
        self.ratio = require_finite(f"{kind} {name!r} ratio", ratio)
        if self.ratio == 0.0:
            raise DataError(f"{kind} {name!r} ratio", expected="a number that is not 0", got="0", fix="Correct it.")
        for side, domain in (("first", first), ("second", second)):
            if not isinstance(domain, Domain):
                raise ArgumentTypeError(
                    f"{kind} {name!r} {side}",
                    expected="a Domain",
                    got=repr(domain),
                    fix="Use ph.ROTATION, for example.",
                )
            if domain.turns_with == "translation":
                raise DataError(
                    f"{kind} {name!r} {side}",
                    expected="a domain of one component",
                    got=domain.name,
                    fix="Turn translation into rotation by the lever of a RigidBody, or use a Slider.",
                )
        self.first = self._add_port("first", first)
        self.second = self._add_port("second", second)

    @property
    def space(self) -> Space | None:
        """The plane, where rotation is one number; any space for scalars."""
        return PLANAR if ROTATION in (self.first.domain, self.second.domain) else None


class Transformer(_Pair):
    """A gear, lever or electrical transformer: ``u_second = ratio u_first`` for the common quantities.

    The summed ones follow from power: ``f_first = -ratio f_second``. One port takes the common quantity and the
    other gives it, whichever way round the diagram needs.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    ratio : float
        Not zero.
    first, second : Domain, optional
        Of the two ports, rotation by default; a motor without resistance joins electrical to rotation.
    multiplier : bool, optional
        Both ports take: for a gear between two things with inertia, as a constraint with a multiplier.

    Attributes
    ----------
    first, second : Port
        To be joined with ``connect``.

    Raises
    ------
    DataError
        If the ratio is zero, or a domain has several components.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    def __init__(
        self,
        name: str,
        ratio: float,
        first: Domain = ROTATION,
        second: Domain = ROTATION,
        multiplier: bool = False,
    ) -> None:
        super().__init__(name, ratio, first, second)
        self.multiplier = bool(multiplier)

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that one port gives and the other takes, or that both take.

        Returns
        -------
        choices : sequence of PortChoice
            Two.
        ties : sequence of Tie
            One.
        """
        if self.multiplier:
            return super().choices()
        what = f"{self.name} gives at both ports or at none"
        tie = Tie(self.first, self.second, None, what, opposite=True)
        return [PortChoice(p, may_give=True, may_take=True) for p in self._ports], [tie]

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the transformer to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            For each port.

        Returns
        -------
        Form
            A multiplier, and the common quantity of the port that gives; no energy.
        """
        unit = self.second.domain.summed
        return branch_form({self.first: self.ratio, self.second: -1.0}, gives, state(unit.name, unit.unit))


class Gyrator(_Pair):
    """A gyrator: the summed quantity of each side is the common one of the other, times the ratio.

    ``f_first = ratio u_second`` and ``f_second = -ratio u_first``, both into the block: a volume flow that is an area
    times a velocity, a force that is the area times a pressure.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    ratio : float
        Not zero.
    first, second : Domain
        Of the two ports.

    Attributes
    ----------
    first, second : Port
        To be joined with ``connect``; both take the common quantity, or both give it.

    Raises
    ------
    DataError
        If the ratio is zero, or a domain has several components.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    def __init__(self, name: str, ratio: float, first: Domain, second: Domain) -> None:
        super().__init__(name, ratio, first, second)

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that both ports give or both take.

        Returns
        -------
        choices : sequence of PortChoice
            Two.
        ties : sequence of Tie
            One.
        """
        tie = Tie(self.first, self.second, None, f"{self.name} gives at one port only")
        return [PortChoice(p, may_give=True, may_take=True) for p in self._ports], [tie]

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the gyrator to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            For each port; both alike.

        Returns
        -------
        Form
            What the two ports give; no energy.
        """
        both = gives["first"]
        # giving: 0 = f_first - ratio w_second;  taking: 0 = u_first + f_second / ratio
        k = -self.ratio if both else 1.0 / self.ratio
        given = [p.domain.common if both else p.domain.summed for p in self._ports]
        runs = [state(f"{q.name} of {p.name}", q.unit) for q, p in zip(given, self._ports, strict=True)]
        J = np.array([[0.0, k], [-k, 0.0]])
        outputs = {"first": (both, np.eye(2)[:1]), "second": (both, np.eye(2)[1:])}
        return lumped_form(self._ports, runs, np.zeros((2, 2)), J, np.zeros((2, 2)), outputs)
