"""Values typed on the command line: methods, inputs, quantities."""

from __future__ import annotations

from argparse import ArgumentParser
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from phblocks.errors import DataError, UnknownNameError

if TYPE_CHECKING:
    from phblocks.diagram import Diagram
    from phblocks.results.solution import Solution
    from phblocks.solvers.adaptive import Adaptive
    from phblocks.solvers.method import Integrator, Method
    from phblocks.solvers.projection import Projection
    from phblocks.triplets import Floats

#: What is typed -> class of the library, and its arguments.
METHODS: dict[str, tuple[str, dict[str, Any]]] = {
    "midpoint": ("Midpoint", {}),
    "gauss2": ("GaussLegendre", {"stages": 2}),
    "gauss3": ("GaussLegendre", {"stages": 3}),
    "radau2": ("RadauIIA", {"stages": 2}),
    "radau3": ("RadauIIA", {"stages": 3}),
    "discrete-gradient": ("DiscreteGradient", {}),
    "linearly-implicit": ("LinearlyImplicit", {}),
    "scipy-radau": ("ScipyIVP", {"method": "Radau"}),
    "scipy-bdf": ("ScipyIVP", {"method": "BDF"}),
    "scipy-dop853": ("ScipyIVP", {"method": "DOP853"}),
}
#: Read-outs of a point, with what their components are called where there are two (in the plane) or three (in space);
#: material axis 1 is along a beam, 2 and 3 across it.
KINDS: dict[str, dict[int, tuple[str, ...]]] = {
    "position": {2: ("x", "y"), 3: ("x", "y", "z")},
    "velocity": {2: ("x", "y"), 3: ("x", "y", "z")},
    "force": {2: ("axial", "shear"), 3: ("axial", "shear 2", "shear 3")},
    "angle": {},
    "spin": {},
    "moment": {3: ("torsion", "bending 2", "bending 3")},
}


def add_run_options(parser: ArgumentParser, required: bool) -> None:
    """Add what a simulation is asked for.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        Of a command.
    required : bool
        Only the end of the run and its step are missing if they are not given.
    """
    group = parser.add_argument_group("simulation")
    group.add_argument("--t-end", type=float, metavar="S", help="duration, s")
    group.add_argument("--dt", type=float, metavar="S", help="step, s (the first one with --rtol)")
    group.add_argument(
        "--method", choices=sorted(METHODS), help="time method; what suits the energy of the system by default"
    )
    group.add_argument("--rtol", type=float, metavar="R", help="adapt the steps to this relative tolerance")
    group.add_argument("--atol", type=float, metavar="A", help="absolute tolerance, J^(1/2); needs --rtol")
    group.add_argument(
        "--project", type=int, metavar="N", help="close loops of joints after every N-th step (1: after every step)"
    )
    group.add_argument(
        "--input",
        action="append",
        default=[],
        metavar="PORT=VALUE",
        help="constant input of an exposed port, components separated by commas: --input tip=0,-10",
    )
    if required:
        group.add_argument("--save-every", type=int, metavar="N", help="save every so many steps")
        group.add_argument("--max-halvings", type=int, metavar="N", help="of a step that fails (12)")


def method_of(
    name: str | None, rtol: float | None = None, atol: float | None = None
) -> tuple[Method | Integrator | None, Adaptive | None]:
    """Make a method.

    Parameters
    ----------
    name : str or None
        One of ``METHODS``; ``None`` leaves the choice to ``simulate``.
    rtol, atol : float, optional
        Tolerances.

    Returns
    -------
    method : Method, Integrator or None
        The method.
    adaptive : Adaptive or None
        How its steps are adapted; a method that chooses its steps itself is given the tolerances.

    Raises
    ------
    DataError
        If there is an absolute tolerance without a relative one, or one is out of its range.
    """
    import phblocks as ph

    if atol is not None and rtol is None:
        raise DataError("--atol", expected="--rtol beside it", got="--atol alone", fix="Give --rtol too.")
    tolerances: dict[str, Any] = {key: value for key, value in (("rtol", rtol), ("atol", atol)) if value is not None}
    if name is None:
        return None, ph.Adaptive(**tolerances) if tolerances else None
    kind, arguments = METHODS[name]
    if kind == "ScipyIVP":  # chooses its steps itself
        return ph.ScipyIVP(**arguments, **tolerances), None
    return getattr(ph, kind)(**arguments), ph.Adaptive(**tolerances) if tolerances else None


def projection_of(every: int | None) -> Projection | None:
    """Make what closes loops.

    Parameters
    ----------
    every : int or None
        Steps from one time to the next; ``None``: never.

    Returns
    -------
    Projection or None
        For ``simulate``.

    Raises
    ------
    DataError
        If it is not positive.
    """
    import phblocks as ph

    return None if every is None else ph.Projection(every)


def inputs_of(texts: list[str]) -> dict[str, float | tuple[float, ...]]:
    """Read constant inputs.

    Parameters
    ----------
    texts : list of str
        ``PORT=VALUE`` or ``PORT=VALUE,VALUE``.

    Returns
    -------
    dict
        By the name of the port.

    Raises
    ------
    DataError
        If one is something else.
    """
    found: dict[str, float | tuple[float, ...]] = {}
    for text in texts:
        name, sign, value = text.rpartition("=")
        try:
            numbers = tuple(map(float, value.split(",")))
        except ValueError:
            numbers = ()
        if not (sign and name and numbers):
            raise DataError("--input", expected="PORT=VALUE or PORT=VALUE,VALUE", got=repr(text), fix="Correct it.")
        found[name] = numbers if len(numbers) > 1 else numbers[0]
    return found


@dataclass(frozen=True)
class Output:
    """A series that is read of a run.

    Parameters
    ----------
    text : str
        As it was typed.
    kind : str
        One of ``KINDS``, "state" or "energy".
    name : str
        Of the block, the state or the kind of energy.
    place : float or tuple of float, optional
        On the block.
    """

    text: str
    kind: str
    name: str
    place: Any = None

    @classmethod
    def of(cls, text: str, diagram: Diagram) -> Output:
        """Read what was typed.

        Parameters
        ----------
        text : str
            ``KIND:BLOCK:PLACE``, with a place on the block (``0.5``, ``0.1,0``) or the name of an anchor (``end``);
            ``state:NAME``; or ``energy:KIND``.
        diagram : Diagram
            With the block.

        Returns
        -------
        Output
            The series.

        Raises
        ------
        DataError
            If it is something else.
        UnknownNameError
            If there is no such block, or anchor.
        """
        kind, _, rest = text.partition(":")
        if kind in ("state", "energy") and rest:
            return cls(text, kind, rest)
        block, _, place = rest.rpartition(":")
        if kind not in KINDS or not block or not place:
            raise DataError(
                "output",
                expected=f"KIND:BLOCK:PLACE with KIND one of {', '.join(KINDS)}; state:NAME; or energy:KIND",
                got=repr(text),
                fix="Such as position:crank:0.5 or angle:crank:end.",
            )
        if block not in diagram.blocks:
            raise UnknownNameError(
                f"output {text}",
                expected=f"a block out of {', '.join(diagram.blocks)}",
                got=repr(block),
                fix="Correct it.",
            )
        try:
            numbers = tuple(map(float, place.split(",")))
        except ValueError:
            anchor = diagram.blocks[block].anchors.get(place)
            if anchor is None:
                raise UnknownNameError(
                    f"output {text}",
                    expected=f"a number, or an anchor out of {', '.join(diagram.blocks[block].anchors) or '(none)'}",
                    got=repr(place),
                    fix="Correct it.",
                ) from None
            return cls(text, kind, block, anchor.place)
        return cls(text, kind, block, numbers if len(numbers) > 1 else numbers[0])

    def columns(self, series: Floats) -> list[str]:
        """Name the components of what was read.

        Parameters
        ----------
        series : numpy.ndarray
            Shape (times,) or (times, components).

        Returns
        -------
        list of str
            Headings, one for each component; numbers where components have no names.
        """
        if series.ndim == 1:
            return [self.text]
        count = series.shape[1]
        parts = KINDS.get(self.kind, {}).get(count, tuple(str(i + 1) for i in range(count)))
        return [f"{self.text} {part}" for part in parts]

    @property
    def quantity(self) -> tuple[str, str, Any]:
        """For studies; of a point."""
        if self.kind not in KINDS:
            raise DataError(
                "--quantity", expected=f"one of {', '.join(KINDS)}", got=repr(self.text), fix="Name a point of a block."
            )
        return self.kind, self.name, self.place

    def read(self, solution: Solution) -> Floats:
        """Read it.

        Parameters
        ----------
        solution : Solution
            Of a run.

        Returns
        -------
        numpy.ndarray
            Shape (times,) or (times, components): two in the plane, three in space.
        """
        if self.kind == "state":
            return solution.state(self.name)
        if self.kind == "energy":
            return solution.energy[self.name]
        series: Floats = getattr(solution, self.kind)(self.name, self.place)
        return series
