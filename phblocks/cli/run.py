"""``phblocks run``: simulate, say how it went, write the result."""

from __future__ import annotations

import math
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from phblocks.cli.answer import Answer, table
from phblocks.cli.scene import Source
from phblocks.cli.values import Output, add_run_options, inputs_of, method_of, projection_of
from phblocks.errors import DataError, ExportError

if TYPE_CHECKING:
    from phblocks.results.solution import Solution
    from phblocks.system import System

HELP = "simulate a diagram, and write the result"
EPILOG = """\
--out result.h5 is written while the run goes on (needs h5py) and can be resumed after a crash, with --resume, and
read with ph.read; --out result.npz is written at the end, plain arrays for NumPy.

exit code 1 if the run ended before --t-end; what it reached is in the result.

examples:
  phblocks run crane.py --t-end 10 --dt 0.01
  phblocks run crane.py --t-end 10 --dt 0.01 --method gauss2 --output position:jib:1.0 --output energy:total
  phblocks run crane.json --t-end 10 --dt 0.01 --input hook=0,-500 --out crane.h5
  phblocks run crane.json --input hook=0,-500 --out crane.h5 --resume
"""
#: Lines of the table of outputs.
LINES = 11
#: What is not for a run that is resumed: it has them in its file, or is to stay.
KNOWN = ("t_end", "dt", "method", "rtol", "atol", "save_every", "max_halvings", "project", "replace")


def add_options(parser: ArgumentParser) -> None:
    """Add the options of the command.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        Of the command.
    """
    parser.add_argument("file", metavar="FILE", help="diagram: .json, or .py that defines `diagram`")
    add_run_options(parser, required=True)
    group = parser.add_argument_group("result")
    group.add_argument(
        "--output",
        "--outputs",
        dest="outputs",
        nargs="+",
        action="extend",
        default=[],
        metavar="SERIES",
        help="show a series: KIND:BLOCK:PLACE such as position:crank:0.5 or angle:crank:end, state:NAME, energy:KIND",
    )
    group.add_argument("--out", metavar="FILE", help="write the result: .h5 or .npz")
    group.add_argument("--replace", action="store_true", help="replace a result that is already there")
    group.add_argument("--resume", action="store_true", help="go on with the run in --out, which knows its own options")
    group.add_argument(
        "--frequencies", action="store_true", help="compare them with the step, too: many states take seconds"
    )
    parser.add_argument(
        "--effects", choices=("auto", "all"), default="auto", help="compute what is called for (auto), or everything"
    )


def carry_out(options: Namespace) -> Answer:
    """Simulate.

    Parameters
    ----------
    options : argparse.Namespace
        What was typed.

    Returns
    -------
    Answer
        No if the run ended early.

    Raises
    ------
    DataError
        If an option is missing, or out of its range.
    ExportError
        If the result cannot be written.
    PhblocksError
        If the file cannot be read, the diagram does not compile, or a step of the run is refused at its start.
    """
    source, out = Source.of(options.file), _place(options)
    diagram = source.diagram()
    outputs = [Output.of(text, diagram) for text in options.outputs]
    system = diagram.compile(effects=options.effects)
    solution = simulated(source, system, options, out)
    series = {output.text: output.read(solution) for output in outputs}
    if out is not None and out.suffix.lower() == ".npz":
        _write(out, solution, series)
    found = solution.health.findings if options.frequencies else solution.health.watched
    data = {"file": options.file, "name": system.name, **_described(solution)}
    data["health"] = {"name": system.name, "status": solution.status.name, "findings": found.to_json()}
    data["outputs"] = {"t": solution.t, **series} if outputs else {}
    data["out"] = None if out is None else str(out)
    text = [_told(solution), "", str(found)]
    if outputs:
        text += ["", _sampled(solution, outputs, list(series.values()))]
    if out is not None:
        text += ["", f"result in {out}"]
    return Answer("\n".join(text), data, solution.status.ok)


def simulated(source: Source, system: System, options: Namespace, out: Path | None = None) -> Solution:
    """Simulate with the options of ``add_run_options``.

    Parameters
    ----------
    source : Source
        The file, for its inputs.
    system : System
        The system.
    options : argparse.Namespace
        What was typed.
    out : pathlib.Path, optional
        Where the run is written while it goes on, if it ends in .h5.

    Returns
    -------
    Solution
        The run.

    Raises
    ------
    DataError
        If the end or the step is missing.
    """
    import phblocks as ph

    inputs = source.inputs(inputs_of(options.input))
    stream = out is not None and out.suffix.lower() != ".npz"
    if stream and options.resume:
        return ph.resume(str(out), system, inputs=inputs, progress=options.progress)
    missing = [name for name, value in (("--t-end", options.t_end), ("--dt", options.dt)) if value is None]
    if missing:
        raise DataError(
            "simulation",
            expected="its duration and its step, s",
            got=f"no {' and no '.join(missing)}",
            fix="Such as --t-end 10 --dt 0.01.",
        )
    method, adaptive = method_of(options.method, options.rtol, options.atol)
    halvings = getattr(options, "max_halvings", None)
    return ph.simulate(
        system,
        t_end=options.t_end,
        dt=options.dt,
        method=method,
        inputs=inputs,
        adaptive=adaptive,
        projection=projection_of(options.project),
        save_every=getattr(options, "save_every", None),
        **({} if halvings is None else {"max_halvings": halvings}),
        progress=options.progress,
        save=ph.Stream(str(out), replace=options.replace) if stream else None,
    )


def _place(options: Namespace) -> Path | None:
    """Where the result goes, checked before the run."""
    if options.resume:
        typed = {name: getattr(options, name) for name in KNOWN}
        given = [f"--{k.replace('_', '-')}" for k, v in typed.items() if v is not None and v is not False]
        if given or options.out is None or Path(options.out).suffix.lower() == ".npz":
            raise DataError(
                "run --resume",
                expected="--out FILE.h5 of the run, and of options of the simulation --input and --effects only",
                got=" ".join(given) or f"--out {options.out}",
                fix="The run knows the others.",
            )
    if options.out is None:
        return None
    out = Path(options.out)
    if out.suffix.lower() not in (".h5", ".npz"):
        raise ExportError(
            f"file {out}",
            expected="a suffix out of .h5, .npz",
            got=repr(out.suffix) if out.suffix else "none",
            fix="The suffix chooses the format.",
        )
    if not out.parent.is_dir():
        raise ExportError(
            f"file {out}", expected="a folder that exists", got=f"{out.parent}", fix="Make the folder first."
        )
    if out.suffix.lower() == ".npz" and out.exists() and not options.replace:
        raise ExportError(
            f"file {out}", expected="a new file", got="one that exists", fix="Use --replace, or another name."
        )
    return out


def _write(out: Path, solution: Solution, series: dict[str, Any]) -> None:
    """Write plain arrays."""
    system = solution.system
    arrays = {
        "t": solution.t,
        "x": solution.x,
        "state_names": np.array(system.state_names, dtype=str),
        "state_units": np.array(system.state_units, dtype=str),
        "status": np.array([solution.status.name, solution.status.text]),
        **{f"energy {kind}": values for kind, values in solution.energy.items()},
        **series,
    }
    try:
        with out.open("wb") as stream:
            np.savez_compressed(stream, **arrays)
    except OSError as error:
        raise ExportError(
            f"file {out}", expected="a place to write to", got=str(error), fix="Check folder, permissions and space."
        ) from error


def _gap(solution: Solution) -> float:
    """Largest distance at a joint, m, from strain; NaN without joints or where it is not known."""
    from phblocks.studies.measurement import strain_gap

    return strain_gap(solution)


def _described(solution: Solution) -> dict[str, Any]:
    status, statistics = solution.status, solution.statistics
    return {
        "status": {key: getattr(status, key) for key in ("ok", "name", "text", "time")},
        "t_end": float(solution.t[-1]),
        "states": solution.system.n,
        "statistics": {
            "steps": statistics.steps,
            "halvings": statistics.halvings,
            "rejections": statistics.rejections,
            "projections": statistics.projections,
            "projection_energy_change": statistics.projection_energy_change,
            "newton_iterations": int(statistics.newton_iterations.sum()),
            "preparation_seconds": statistics.preparation_seconds,
            "loop_seconds": statistics.loop_seconds,
            "start_energy_change": statistics.start_energy_change,
        },
        "energy": {
            kind: {"start": series[0], "end": series[-1], "largest": series.max()}
            for kind, series in solution.energy.items()
        },
        "max_power_balance_error": solution.max_power_balance_error,
        "gap": _gap(solution),
    }


def _told(solution: Solution) -> str:
    statistics, gap = solution.statistics, _gap(solution)
    lines = [
        f"{solution.system.name}: {solution.system.n} states, {solution.t.size} times to {solution.t[-1]:g} s",
        f"status   {solution.status}",
        f"steps    {statistics}",
        f"balance  {solution.max_power_balance_error:.2g} J, the largest error of a step",
        *([] if math.isnan(gap) else [f"gap      {gap:.2g} m, the largest of the joints and of the two positions"]),
        "",
    ]
    rows = [["energy, J", "start", "end", "largest"]]
    for kind, series in solution.energy.items():
        rows.append([kind, *(f"{value:.6g}" for value in (series[0], series[-1], series.max()))])
    return "\n".join([*lines, table(rows)])


def _sampled(solution: Solution, outputs: Sequence[Output], series: Sequence[Any]) -> str:
    """The series at a few times, evenly over the run."""
    chosen = np.unique(np.linspace(0, solution.t.size - 1, LINES).round().astype(int))
    columns = np.column_stack([solution.t, *series])
    names = ["t, s", *(name for output, values in zip(outputs, series, strict=True) for name in output.columns(values))]
    return table([names, *([f"{value:.6g}" for value in columns[i]] for i in chosen)])
