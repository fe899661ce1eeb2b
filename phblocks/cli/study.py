"""``phblocks study``: what accuracy costs, measured on this machine."""

from __future__ import annotations

import math
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from phblocks.cli.answer import Answer
from phblocks.cli.plot import write_figure
from phblocks.cli.run import simulated
from phblocks.cli.scene import Maker, Source
from phblocks.cli.values import METHODS, Output, add_run_options, inputs_of, method_of, projection_of
from phblocks.errors import DataError, ExportError, UnreachedError

HELP = "measure convergence, error against time, or which effects are needed"
EPILOG = """\
kinds of studies:
  convergence      how the error falls over dt, elements or degree (--over, --values)
  work-precision   error and time of --methods with --steps; the setting for --tolerance or --seconds
  effects          which effects can be left out within --tolerance, with --steps
  shares           how much each effect has to do with the scene, from one run

--elements and --degree are given to the function `diagram` of FILE if it takes them, otherwise to all blocks that have
them (beams). exit code 1 if a run of the study failed, or no setting reaches what is asked for.

examples:
  phblocks study crane.py --over dt --values 0.02 0.01 0.005 --t-end 1 --quantity position:jib:1.0
  phblocks study crane.py --over elements --values 2 4 8 --dt 0.005 --t-end 1 --quantity position:jib:1.0
  phblocks study crane.py --kind work-precision --methods midpoint gauss2 --steps 0.02 0.01 --t-end 1 \\
      --quantity position:jib:1.0 --tolerance 1e-3
  phblocks study crane.py --kind shares --t-end 1 --dt 0.01
"""
KINDS = ("convergence", "work-precision", "effects", "shares")


def add_options(parser: ArgumentParser) -> None:
    """Add the options of the command.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        Of the command.
    """
    parser.add_argument("file", metavar="FILE", help="diagram: .json, or .py that defines `diagram`")
    parser.add_argument("--kind", choices=KINDS, default=KINDS[0], help="convergence by default")
    group = parser.add_argument_group("what is varied and judged")
    group.add_argument("--over", choices=("dt", "elements", "degree"), default="dt", help="convergence: dt by default")
    group.add_argument("--values", type=float, nargs="+", metavar="V", help="convergence: of it")
    group.add_argument("--steps", type=float, nargs="+", metavar="S", help="work-precision, effects: steps, s")
    group.add_argument("--methods", choices=sorted(METHODS), nargs="+", metavar="M", help="work-precision: methods")
    group.add_argument(
        "--tolerances", type=float, nargs="+", metavar="R", help="work-precision: of scipy-..., which choose steps"
    )
    group.add_argument("--elements", type=int, nargs="+", metavar="N", help="of all beams; several: work-precision")
    group.add_argument("--degree", type=int, metavar="K", help="of all beams")
    group.add_argument("--quantity", metavar="KIND:BLOCK:PLACE", help="what the error is of: position:crank:0.5")
    group.add_argument("--times", type=float, nargs="+", metavar="S", help="when, s; at the end by default")
    group.add_argument("--tolerance", type=float, metavar="E", help="error that is allowed, in its unit")
    group.add_argument("--seconds", type=float, metavar="S", help="work-precision: time that a run may take, s")
    group.add_argument("--repeats", type=int, default=3, metavar="N", help="how often a run is timed (3)")
    written = parser.add_argument_group("result")
    written.add_argument("--table", metavar="FILE", help="write all columns to .csv, or those shown to .md")
    written.add_argument("--picture", metavar="FILE", help="draw the study: .png, .svg or .pdf")
    add_run_options(parser, required=False)


def carry_out(options: Namespace) -> Answer:
    """Make a study.

    Parameters
    ----------
    options : argparse.Namespace
        What was typed.

    Returns
    -------
    Answer
        No if a run failed, or nothing reaches what is asked for.

    Raises
    ------
    DataError
        If an option is missing, or out of its range.
    ExportError
        If a table or picture cannot be written.
    PhblocksError
        If the file cannot be read, the diagram does not compile, or there is nothing to measure errors against.
    """
    _require_places(options)
    source = Source.of(options.file)
    made: dict[str, Callable[[Source, Namespace], Any]] = {
        "convergence": _convergence,
        "work-precision": _work_precision,
        "effects": _effects,
        "shares": _shares,
    }
    table = made[options.kind](source, options)
    ok = all(getattr(row, "status", "success") == "success" for row in table)
    data = {"file": options.file, "kind": options.kind, "rows": [asdict(row) for row in table], "notes": table.notes}
    text = [str(table)]
    for name in ("order", "rate"):
        if options.kind == "convergence" and (name == "rate") == (options.over == "degree"):
            data[name] = getattr(table, name)
            ok = ok and not math.isnan(data[name])
    try:
        for name, row in _chosen(table, options).items():
            data[name] = asdict(row)
            text += ["", f"{name.replace('_', ' ')}: {row}"]
    except UnreachedError as error:
        ok, data["unreached"] = False, str(error)
        text += ["", str(error)]
    text += [""] if options.table or options.picture else []
    text += _written(table, options)
    data |= {"table": options.table, "picture": options.picture}
    return Answer("\n".join(text), data, ok)


def _convergence(source: Source, options: Namespace) -> Any:
    from phblocks.studies import convergence

    _require(options, "values", "quantity")
    meshed = options.over != "dt"
    mesh = _mesh(options, None if options.over == "elements" else options.elements)
    mesh = {key: value for key, value in mesh.items() if key != options.over}
    values = [_integer(value) for value in options.values] if meshed else options.values
    method, adaptive = method_of(options.method, options.rtol, options.atol)
    more: dict[str, Any] = {} if adaptive is None else {"adaptive": adaptive}
    return convergence(
        Maker(source),
        options.over,
        values,
        **_common(source, options),
        dt=options.dt,
        mesh=mesh,
        method=method,
        **more,
    )


def _work_precision(source: Source, options: Namespace) -> Any:
    from phblocks.studies import work_precision

    _require(options, "steps", "quantity")
    names = options.methods or [options.method or "midpoint"]
    return work_precision(
        Maker(source),
        {name: method_of(name)[0] for name in names},
        options.steps,
        [_mesh(options, [number]) for number in options.elements] if options.elements else [_mesh(options, None)],
        **_common(source, options),
        tolerances=options.tolerances,
        repeats=options.repeats,
    )


def _effects(source: Source, options: Namespace) -> Any:
    from phblocks.studies import effects

    _require(options, "steps", "quantity", "tolerance")
    common = _common(source, options)
    mesh = _mesh(options, options.elements)
    return effects(
        Maker(source, tuple(mesh.items())),
        common.pop("quantity"),
        options.tolerance,
        **common,
        steps=options.steps,
        method=method_of(options.method)[0],
        repeats=options.repeats,
    )


def _shares(source: Source, options: Namespace) -> Any:
    from phblocks.studies import effect_shares

    system = Maker(source)(**_mesh(options, options.elements))
    return effect_shares(simulated(source, system, options))


def _common(source: Source, options: Namespace) -> dict[str, Any]:
    """What all studies but the last are asked."""
    _require(options, "t_end")
    inputs, projection = source.inputs(inputs_of(options.input)), projection_of(options.project)
    return {
        "quantity": Output.of(options.quantity, source.diagram()).quantity,
        "t_end": options.t_end,
        "times": options.times,
        "progress": options.progress,
        **({"inputs": inputs} if inputs else {}),
        **({} if projection is None else {"projection": projection}),
    }


def _mesh(options: Namespace, elements: list[int] | None) -> dict[str, Any]:
    if elements is not None and len(elements) > 1:
        raise DataError(
            f"study --kind {options.kind} --elements",
            expected="one number",
            got=" ".join(map(str, elements)),
            fix="Use --over elements --values, or --kind work-precision.",
        )
    mesh = {"degree": options.degree, "elements": None if elements is None else elements[0]}
    return {key: value for key, value in mesh.items() if value is not None}


def _chosen(table: Any, options: Namespace) -> dict[str, Any]:
    """The settings to use."""
    from phblocks.studies import best_within, cheapest

    if options.kind != "work-precision":
        return {}
    found = {} if options.tolerance is None else {"cheapest": cheapest(table, options.tolerance)}
    return found if options.seconds is None else {**found, "best_within": best_within(table, options.seconds)}


def _integer(value: float) -> int:
    if not value.is_integer():
        raise DataError("study --values", expected="integers", got=f"{value:g}", fix="Correct them.")
    return int(value)


def _require(options: Namespace, *names: str) -> None:
    missing = [f"--{name.replace('_', '-')}" for name in names if getattr(options, name) is None]
    if missing:
        raise DataError(
            f"study --kind {options.kind}",
            expected=f"{' and '.join(missing)}",
            got="none",
            fix="phblocks study --help has examples.",
        )


def _require_places(options: Namespace) -> None:
    """Check before the study what would lose it."""
    suffixes = {"table": (".csv", ".md"), "picture": (".png", ".svg", ".pdf")}
    for name, known in suffixes.items():
        path = getattr(options, name)
        if path is None:
            continue
        if Path(path).suffix.lower() not in known or not Path(path).parent.is_dir():
            raise ExportError(
                f"file {path}",
                expected=f"a suffix out of {', '.join(known)}, in a folder that exists",
                got=repr(Path(path).suffix) if Path(path).parent.is_dir() else f"no folder {Path(path).parent}",
                fix="The suffix chooses the format.",
            )
    if options.picture and options.kind == "shares":
        raise DataError("study --picture", expected="another kind", got="shares", fix="Use --kind effects, or --table.")


def _written(table: Any, options: Namespace) -> list[str]:
    if options.table:
        if Path(options.table).suffix.lower() == ".csv":
            table.to_csv(options.table)
        else:
            try:
                Path(options.table).write_text(table.to_markdown() + "\n", encoding="utf-8")
            except OSError as error:
                raise ExportError(
                    f"file {options.table}", expected="a place to write to", got=str(error), fix="Check permissions."
                ) from error
    if options.picture:
        write_figure(table.plot, Path(options.picture))
    return [path for path in (options.table, options.picture) if path]
