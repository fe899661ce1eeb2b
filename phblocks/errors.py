"""What can go wrong, and how it is said: where, expected, got, what to do.

Every error of the library derives from :class:`PhblocksError` and from the builtin it is a case of, so both
``except PhblocksError`` and ``except ValueError`` work.  The ``code`` of a class is stable; see ``docs/errors.md``.
"""

from __future__ import annotations

from functools import partial
from typing import Any


class PhblocksError(Exception):
    """Root of all errors raised by phblocks.

    Parameters
    ----------
    where : str
        The block, port, junction or argument concerned.
    expected : str
        What would have been right.
    got : str
        What was found instead.
    fix : str
        What the user can do about it.
    """

    code = "PH000"

    def __init__(self, where: str, *, expected: str, got: str, fix: str) -> None:
        self.where = where
        self.expected = expected
        self.got = got
        self.fix = fix
        super().__init__(f"[{self.code}] {where}: expected {expected}, got {got}. {fix}")

    def __reduce__(self) -> tuple[Any, ...]:
        """Keep the four parts when pickled, as on the way back from a worker process."""
        parts = {"where": self.where, "expected": self.expected, "got": self.got, "fix": self.fix}
        return partial(type(self), **parts), ()

    def __str__(self) -> str:
        """Return the message as it is (``KeyError`` would quote it)."""
        return str(self.args[0])


class DataError(PhblocksError, ValueError):
    """A number or array given to a block, a diagram or a simulation is out of its range."""

    code = "PH101"


class ArgumentTypeError(PhblocksError, TypeError):
    """An argument is of the wrong kind."""

    code = "PH102"


class DuplicateNameError(PhblocksError, ValueError):
    """Two blocks, or two exposed ports, of one diagram carry the same name."""

    code = "PH201"


class UnknownNameError(PhblocksError, KeyError):
    """A block, port, state, field, energy or input is asked for that does not exist."""

    code = "PH202"


class ForeignBlockError(PhblocksError, ValueError):
    """A block is joined in a diagram it was not added to."""

    code = "PH203"


class PortTypeError(PhblocksError, TypeError):
    """Ports of different domains are joined."""

    code = "PH204"


class PortInUseError(PhblocksError, ValueError):
    """A port is joined a second time."""

    code = "PH205"


class GapError(PhblocksError, ValueError):
    """Two anchors are joined that are not in the same place, or one is not where a slider was told it is."""

    code = "PH206"


class NestingError(PhblocksError, ValueError):
    """A diagram is put inside itself, or inside one with another gravity."""

    code = "PH207"


class SpaceError(PhblocksError, ValueError):
    """Planar and spatial parts are in one diagram, or a part is asked for in space that only the plane has."""

    code = "PH208"


class CausalityError(PhblocksError, ValueError):
    """No assignment of who gives and who takes makes the diagram causal."""

    code = "PH301"


class DanglingPortError(CausalityError):
    """A port that can only take is joined to nothing."""

    code = "PH303"


class OverdeterminedError(CausalityError):
    """Two ports of a junction give the common quantity."""

    code = "PH304"


class UnderdeterminedError(CausalityError):
    """No port of a junction gives the common quantity."""

    code = "PH305"


class HeldPortError(CausalityError):
    """An exposed quantity acts on nothing, because the ground or another opening holds the junction."""

    code = "PH306"


class ConstraintError(PhblocksError, ValueError):
    """A constraint follows from others, or holds nothing."""

    code = "PH302"


class UndeterminedError(ConstraintError):
    """Nothing determines what happens at some ports: a ring without loss or storage, a circuit without reference."""

    code = "PH307"


class StructureError(PhblocksError, ValueError):
    """Matrices violate the port-Hamiltonian structure (skewness, symmetry, definiteness)."""

    code = "PH401"


class MethodError(PhblocksError, ValueError):
    """A time method does not suit a system: it would not keep its energy, or cannot integrate it."""

    code = "PH402"


class ApproximationError(PhblocksError, ValueError):
    """An effect is to be left out where that is known to be wrong."""

    code = "PH403"


class PrunedError(PhblocksError, ValueError):
    """A start or an input moves what the compilation proved to stay zero, and left out."""

    code = "PH404"


class OrientationError(PhblocksError, NotImplementedError):
    """The orientation of a frame that turns in space would be needed, which this version does not compute."""

    code = "PH405"


class ExportError(PhblocksError, ValueError):
    """A file cannot be written or read."""

    code = "PH501"


class ResultFileError(PhblocksError, ValueError):
    """A file of results cannot be written or read, is damaged, or belongs to something else."""

    code = "PH502"


class ExtraMissingError(PhblocksError, ImportError):
    """A package that an exporter needs is not installed."""

    code = "PH503"


class StudyError(PhblocksError, RuntimeError):
    """A study cannot be carried out (its reference fails, a worker is lost), or has no such result."""

    code = "PH601"


class UnreachedError(PhblocksError, ValueError):
    """No setting of a study reaches what is asked for."""

    code = "PH602"


class PhblocksWarning(UserWarning):
    """Root of all warnings of phblocks: the result stands, but something about it has to be known."""


class ApproximationWarning(PhblocksWarning):
    """A run left the range in which an effect may be left out."""


class HealthWarning(PhblocksWarning):
    """A run reached its end, but a number of ``solution.health`` is above its limit."""
