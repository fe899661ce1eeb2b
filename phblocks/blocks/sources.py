"""Sources: blocks that impose a quantity on what they are joined to, constant or as a function of time.

Their energy stands under their name in ``solution.power.inputs``. A signal given to ``simulate(inputs={name: ...})``
replaces that of the source.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from phblocks.blocks.branch import Lumped
from phblocks.blocks.checks import require_flag
from phblocks.blocks.circuit import require_scalar_domain
from phblocks.blocks.form import Form, PortForm
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.ports import ELECTRICAL, ROTATION, TRANSLATION, Domain, Exposure
from phblocks.space import PLANAR, SPATIAL, Space
from phblocks.triplets import Triplets, real_array

Signal = Callable[[float], ArrayLike] | ArrayLike

#: Of a constant, by what it turns with: its shapes, and how they are called.
SHAPES: dict[str | None, tuple[Sequence[tuple[int, ...]], str]] = {
    None: (((), (1,)), "a number, or a function of time"),
    "translation": (((2,), (3,)), "two numbers (in space three), or a function of time"),
    "rotation": (((), (1,), (3,)), "a number (in space three), or a function of time"),
}


class _Source(Lumped):
    """One port, which takes and gives nothing, opened to the outside."""

    _gives: ClassVar[bool]

    def __init__(self, name: str, domain: Domain, signal: Signal, follows: bool = False) -> None:
        super().__init__(name)
        self.signal = signal if callable(signal) else self._constant(domain, signal)
        self.follows = require_flag(f"{type(self).__name__} {name!r} follows", follows)
        self.port = self._add_port("port", domain)

    def _constant(self, domain: Domain, value: ArrayLike) -> ArrayLike:
        where = f"{type(self).__name__} {self.name!r}"
        shapes, expected = SHAPES[domain.turns_with]
        array = real_array(value)
        if array is None:
            raise ArgumentTypeError(where, expected=expected, got=repr(value), fix="Give SI units.")
        if array.shape not in shapes or not np.isfinite(array).all():
            raise DataError(where, expected=expected, got=repr(value), fix="Give finite numbers in SI units.")
        return array

    @property
    def space(self) -> Space | None:
        """That of a constant, for what is mechanical; any for a function of time."""
        if self.port.domain.turns_with is None or callable(self.signal):
            return None
        return SPATIAL if np.size(self.signal) == SPATIAL.dimension else PLANAR

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the source to no states at all.

        Parameters
        ----------
        gives : mapping of str to bool
            Always false.

        Returns
        -------
        Form
            Without states; its port gives nothing, what it imposes comes from outside.
        """
        none = Triplets.empty()
        ports = {"port": PortForm(False, ())}
        return Form(size=0, runs=(), E=none, J0=none, R=none, T=Triplets.empty(3), ports=ports)

    def exposures(self) -> Sequence[Exposure]:
        """Open the port to the outside.

        Returns
        -------
        sequence of Exposure
            One.
        """
        return (Exposure(self.name, self.port, self._gives, self.follows, self.signal),)


class Force(_Source):
    """A force on what it is joined to.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    force : array_like or callable
        (x, y), N, in space (x, y, z), or a function of time, s, that returns it.
    follows : bool, optional
        The components are along and across the material frame of the part that gives velocity there, and turn
        with it; by default they are in the fixed frame.

    Attributes
    ----------
    port : Port
        Of translation, to be joined with ``connect``.

    Raises
    ------
    DataError
        If a constant has the wrong shape or is not finite.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    _gives = False

    def __init__(self, name: str, force: Signal, follows: bool = False) -> None:
        super().__init__(name, TRANSLATION, force, follows)


class Moment(_Source):
    """A moment on what it is joined to.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    moment : float, array_like or callable
        N m, in space (x, y, z), or a function of time, s, that returns it.
    follows : bool, optional
        In space: the components are along the axes of the material frame of the part that gives angular velocity
        there, and turn with it; by default they are in the fixed frame.

    Attributes
    ----------
    port : Port
        Of rotation, to be joined with ``connect``.

    Raises
    ------
    DataError
        If a constant has the wrong shape or is not finite.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    _gives = False

    def __init__(self, name: str, moment: Signal, follows: bool = False) -> None:
        super().__init__(name, ROTATION, moment, follows)


class Velocity(_Source):
    """A prescribed velocity of what it is joined to.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    velocity : array_like or callable
        (x, y), m/s, in space (x, y, z), or a function of time, s, that returns it.
    follows : bool, optional
        The components are along the axes of the material frame of the first part that it moves, and turn with it; by
        default they are in the fixed frame.

    Attributes
    ----------
    port : Port
        Of translation, to be joined with ``connect``.

    Raises
    ------
    DataError
        If a constant has the wrong shape or is not finite.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    _gives = True

    def __init__(self, name: str, velocity: Signal, follows: bool = False) -> None:
        super().__init__(name, TRANSLATION, velocity, follows)


class AngularVelocity(_Source):
    """A prescribed angular velocity of what it is joined to.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    angular_velocity : float, array_like or callable
        rad/s, in space (x, y, z), or a function of time, s, that returns it.
    follows : bool, optional
        In space: the components are along the axes of the material frame of the first part that it turns, and turn
        with it; by default they are in the fixed frame.

    Attributes
    ----------
    port : Port
        Of rotation, to be joined with ``connect``.

    Raises
    ------
    DataError
        If a constant has the wrong shape or is not finite.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    _gives = True

    def __init__(self, name: str, angular_velocity: Signal, follows: bool = False) -> None:
        super().__init__(name, ROTATION, angular_velocity, follows)


class Voltage(_Source):
    """A voltage between a junction and the reference; a pressure in a hydraulic domain.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    voltage : float or callable
        V, or a function of time, s, that returns it.
    domain : Domain, optional
        Electrical by default.

    Attributes
    ----------
    port : Port
        To be joined with ``connect``.

    Raises
    ------
    DataError
        If a constant has the wrong shape or is not finite.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    _gives = True

    def __init__(self, name: str, voltage: Signal, domain: Domain = ELECTRICAL) -> None:
        super().__init__(name, require_scalar_domain(f"Voltage {name!r} domain", domain), voltage)


class Current(_Source):
    """A current from the reference into a junction; a volume flow in a hydraulic domain.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    current : float or callable
        A, or a function of time, s, that returns it.
    domain : Domain, optional
        Electrical by default.

    Attributes
    ----------
    port : Port
        To be joined with ``connect``.

    Raises
    ------
    DataError
        If a constant has the wrong shape or is not finite.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    _gives = False

    def __init__(self, name: str, current: Signal, domain: Domain = ELECTRICAL) -> None:
        super().__init__(name, require_scalar_domain(f"Current {name!r} domain", domain), current)
