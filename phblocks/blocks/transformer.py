"""Parts that pass power on unchanged: gears and the like (transformers), pistons and the like (gyrators)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from phblocks.blocks.block import PortChoice, Tie
from phblocks.blocks.branch import Lumped, lumped_form, state
from phblocks.blocks.checks import require_direction, require_finite, require_matrix
from phblocks.blocks.form import Form, StateRun
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.ports import ROTATION, Domain, Quantity
from phblocks.space import PLANAR, Space
from phblocks.triplets import Floats, real_array


class _Pair(Lumped):
    """Two ports ``first`` and ``second``."""

    def __init__(self, name: str, first: Domain, second: Domain) -> None:
        super().__init__(name)
        for side, domain in (("first", first), ("second", second)):
            if not isinstance(domain, Domain):
                raise ArgumentTypeError(
                    f"{type(self).__name__} {name!r} {side}",
                    expected="a Domain",
                    got=repr(domain),
                    fix="Use ph.ROTATION, for example.",
                )
        self.first = self._add_port("first", first)
        self.second = self._add_port("second", second)

    @property
    def space(self) -> Space | None:
        """The plane for what is mechanical; any space for scalars."""
        return PLANAR if any(port.domain.turns_with for port in self._ports) else None


def _require_ratio(where: str, ratio: object) -> float:
    number = require_finite(where, ratio)
    if number == 0.0:
        raise DataError(where, expected="a number that is not 0", got="0", fix="Correct it.")
    return number


class Transformer(_Pair):
    """A gear, lever, rack and pinion or electrical transformer: ``u_second = ratio u_first`` for the common quantities.

    The summed ones follow from power: ``f_first = -ratio f_second``. One port takes the common quantity and the
    other gives it, whichever way round the diagram needs.

    Between two ports of translation the ratio is a number, or a matrix A: ``v_second = A v_first`` and
    ``f_first = -A^T f_second``, in the fixed frame. A port of translation may instead take part along one direction d
    only. Then ``d . v`` stands for its velocity and the force on the block acts along d; across d the port is free to
    move and there is no force. Such a port can only take velocity, since it knows nothing of the velocity across:

    * rack and pinion, winch: ``d . v_second = ratio omega_first``, the ratio being a radius, m;
    * lever between two directions: ``b . v_second = ratio (a . v_first)``.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    ratio : float or array_like
        Not zero. Between two ports of translation also an invertible matrix of shape (2, 2), by rows of the second.
    first, second : Domain, optional
        Of the two ports, rotation by default; a motor without resistance joins electrical to rotation.
    multiplier : bool, optional
        Both ports take: for a gear between two things with inertia, as a constraint with a multiplier. Always so if
        both ports have a direction.
    first_direction, second_direction : array_like, optional
        (x, y), of any length but zero, fixed in space: the direction along which a port of translation takes part.

    Attributes
    ----------
    first, second : Port
        To be joined with ``connect``.

    Raises
    ------
    DataError
        If the ratio is zero or its matrix not invertible, a direction is zero or of a port that is not of
        translation, or one port has two components and the other one.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    def __init__(
        self,
        name: str,
        ratio: ArrayLike,
        first: Domain = ROTATION,
        second: Domain = ROTATION,
        multiplier: bool = False,
        first_direction: ArrayLike | None = None,
        second_direction: ArrayLike | None = None,
    ) -> None:
        super().__init__(name, first, second)
        where = f"Transformer {name!r}"
        along = [
            self._direction(f"{where} {port.name}_direction", port.domain, direction)
            for port, direction in zip(self._ports, (first_direction, second_direction), strict=True)
        ]
        if len(along[0]) != len(along[1]):
            vector = self._ports[int(len(along[1]) > 1)]
            raise DataError(
                f"{where} {vector.name}",
                expected="as many components at both ports",
                got=f"translation without {vector.name}_direction beside one component",
                fix="Say along which direction it takes part.",
            )
        given = real_array(ratio)
        scalar = given is None or given.ndim == 0 or len(along[0]) == 1
        self.ratio: float | Floats = (
            _require_ratio(f"{where} ratio", ratio)
            if scalar
            else require_matrix(f"{where} ratio", ratio, (len(along[1]), len(along[0])))
        )
        matrix = self.ratio * np.eye(len(along[0])) if scalar else np.asarray(self.ratio)
        if not np.linalg.cond(matrix) <= 1e12:
            raise DataError(
                f"{where} ratio",
                expected="an invertible matrix",
                got=str(matrix.tolist()),
                fix="A lever along one direction at each end has first_direction, second_direction and a number.",
            )
        # 0 = C_first u_first + C_second u_second
        self._coefficients = (matrix @ along[0], -along[1])
        #: Whether each port may give the common quantity.
        self._may_give = tuple(direction is None for direction in (first_direction, second_direction))
        self.multiplier = bool(multiplier) or not any(self._may_give)

    @staticmethod
    def _direction(where: str, domain: Domain, direction: ArrayLike | None) -> Floats:
        """What a port's common quantity is multiplied by, shape (1, 2) along a direction, else the identity."""
        vector = domain.turns_with == "translation"
        if direction is None:
            return np.eye(2 if vector else 1)
        if not vector:
            raise DataError(where, expected=f"none for {domain.name}", got=repr(direction), fix="Leave it out.")
        return require_direction(where, direction)[None]

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that one port gives and the other takes, or that both take; one with a direction takes.

        Returns
        -------
        choices : sequence of PortChoice
            Two.
        ties : sequence of Tie
            At most one.
        """
        if self.multiplier:
            return super().choices()
        what = f"{self.name} gives at both ports or at none"
        tie = Tie(self.first, self.second, None, what, opposite=True)
        may = zip(self._ports, self._may_give, strict=True)
        return [PortChoice(port, may_give=give, may_take=True) for port, give in may], [tie]

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the transformer to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            For each port.

        Returns
        -------
        Form
            A multiplier, or one for each component, and the common quantity of the port that gives; no energy.
        """
        m = len(self._coefficients[0])
        runs = _states(self.second.domain.summed, "", m)
        for port in self._ports:
            if gives[port.name]:
                runs += _states(port.domain.common, f" of {port.name}", m)
        n = len(runs)
        J = np.zeros((n, n))
        outputs = {}
        for port, c in zip(self._ports, self._coefficients, strict=True):
            if gives[port.name]:
                J[:m, m:], J[m:, :m] = c, -c.T
                outputs[port.name] = (True, np.eye(n)[m:])
            else:
                outputs[port.name] = (False, np.hstack([c.T, np.zeros((c.shape[1], n - m))]))
        return lumped_form(self._ports, runs, np.zeros((n, n)), J, np.zeros((n, n)), outputs)


def _states(quantity: Quantity, of: str, components: int) -> list[StateRun]:
    axes = [""] if components == 1 else [f" {axis}" for axis in "xy"]
    return [state(f"{quantity.name}{axis}{of}", quantity.unit) for axis in axes]


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
        super().__init__(name, first, second)
        self.ratio = _require_ratio(f"Gyrator {name!r} ratio", ratio)
        for port in self._ports:
            if port.domain.turns_with == "translation":
                raise DataError(
                    f"Gyrator {name!r} {port.name}",
                    expected="a domain of one component",
                    got=port.domain.name,
                    fix="Put a Transformer with a direction between it and the port of translation.",
                )

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
