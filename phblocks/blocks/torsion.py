"""Torsion springs and dampers between two things that turn."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from phblocks.blocks.block import Block, Replacement
from phblocks.blocks.branch import Lumped, branch_form, state
from phblocks.blocks.checks import require_finite, require_positive
from phblocks.blocks.form import NO_ENERGY, Form
from phblocks.ports import ROTATION, Port
from phblocks.space import PLANAR, Space


class _Torsion(Lumped):
    """Two rotation ports, ``first`` and ``second``, and a moment M between them, positive if it turns first forward."""

    called: ClassVar[str]

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.first = self._add_port("first", ROTATION)
        self.second = self._add_port("second", ROTATION)

    @property
    def space(self) -> Space:
        """The plane, where a moment is one number."""
        return PLANAR

    def _replaced(self, other: _Torsion, whole: _Torsion, inner: tuple[Port, Port]) -> Replacement:
        """The part from the outer port of this one to that of the other."""
        outer = (self._opposite(inner[0]), other._opposite(inner[1]))
        what = f"make one {self.called} of {self.name!r} and {other.name!r} in series"
        return Replacement(whole, dict(zip(outer, (whole.first, whole.second), strict=True)), what)

    def _opposite(self, port: Port) -> Port:
        return self.second if port is self.first else self.first

    def _form(self, gives: Mapping[str, bool], energy: str, e: float, r: float, start: float = 0.0) -> Form:
        ends = {self.second: 1.0, self.first: -1.0}
        return branch_form(ends, gives, state("M3", "N m", energy), e, r, start)


class TorsionSpring(_Torsion):
    """A torsion spring: ``M / k`` is the angle that second is ahead of first, less that at rest.

    Its state is the moment M, with ``M' / k = w_second - w_first``: angle and moment never separate. M turns first
    forward and second back.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    stiffness : float
        k, N m/rad.
    twist : float, optional
        Angle of second less that of first at the start, less that at rest, rad.

    Attributes
    ----------
    first, second : Port
        Ports of rotation, to be joined with ``connect``; they take angular velocity.

    Raises
    ------
    DataError
        If a number is out of its range.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    called = "torsion spring"

    def __init__(self, name: str, stiffness: float, twist: float = 0.0) -> None:
        super().__init__(name)
        self.stiffness = require_positive(f"TorsionSpring {name!r} stiffness", stiffness)
        self.twist = require_finite(f"TorsionSpring {name!r} twist", twist)

    def in_series_with(self, other: Block, name: str, inner: tuple[Port, Port]) -> Replacement | None:
        """Make one part of this one and another in series: ``1/k = 1/k_1 + 1/k_2``, twists added.

        Parameters
        ----------
        other : Block
            The other one.
        name : str
            Of the new part.
        inner : (Port, Port)
            The ports that are joined to each other.

        Returns
        -------
        Replacement or None
            ``None`` if the other is no torsion spring.
        """
        if not isinstance(other, TorsionSpring):
            return None
        stiffness = 1.0 / (1.0 / self.stiffness + 1.0 / other.stiffness)
        # from the outer port of this one to that of the other
        twist = (self.twist if inner[0] is self.second else -self.twist) + (
            other.twist if inner[1] is other.first else -other.twist
        )
        return self._replaced(other, TorsionSpring(name, stiffness, twist), inner)

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the spring to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            Always false.

        Returns
        -------
        Form
            One state, M3.
        """
        return self._form(gives, "strain", 1.0 / self.stiffness, 0.0, self.stiffness * self.twist)


class TorsionDamper(_Torsion):
    """A torsion damper: ``M = c (w_second - w_first)`` turns first forward and second back.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    damping : float
        c, N m s/rad.

    Attributes
    ----------
    first, second : Port
        Ports of rotation, to be joined with ``connect``; they take angular velocity.

    Raises
    ------
    DataError
        If a number is out of its range.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    called = "torsion damper"

    def __init__(self, name: str, damping: float) -> None:
        super().__init__(name)
        self.damping = require_positive(f"TorsionDamper {name!r} damping", damping)

    def in_series_with(self, other: Block, name: str, inner: tuple[Port, Port]) -> Replacement | None:
        """Make one part of this one and another in series: ``1/c = 1/c_1 + 1/c_2``.

        Parameters
        ----------
        other : Block
            The other one.
        name : str
            Of the new part.
        inner : (Port, Port)
            The ports that are joined to each other.

        Returns
        -------
        Replacement or None
            ``None`` if the other is no torsion damper.
        """
        if not isinstance(other, TorsionDamper):
            return None
        damping = 1.0 / (1.0 / self.damping + 1.0 / other.damping)
        return self._replaced(other, TorsionDamper(name, damping), inner)

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the damper to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            Always false.

        Returns
        -------
        Form
            One state without energy, M3.
        """
        return self._form(gives, NO_ENERGY, 0.0, 1.0 / self.damping)
