"""``phblocks export``: matrices, the diagram itself, or an FMU, by the suffix of the file."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from phblocks.cli.answer import Answer
from phblocks.cli.run import simulated
from phblocks.cli.scene import Source
from phblocks.cli.values import add_run_options
from phblocks.errors import DataError, ExportError

if TYPE_CHECKING:
    from phblocks.system import State, System

HELP = "write matrices (.mat, .npz, .mtx), the diagram (.json) or a co-simulation unit (.fmu)"
EPILOG = """\
Matrices are those of the start, unless a time is asked for: of a stored run (--result run.h5 --at 2.5), or of one that
is made for it (--dt 0.01 --at 2.5).

examples:
  phblocks export crane.py --to crane.json
  phblocks export crane.py --to crane.mat
  phblocks export crane.py --to bent.mat --at 2.5 --dt 0.01
  phblocks export crane.py --to bent.npz --at 2.5 --result crane.h5
"""
MATRICES = (".mat", ".npz", ".mtx")


def add_options(parser: ArgumentParser) -> None:
    """Add the options of the command.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        Of the command.
    """
    parser.add_argument("file", metavar="FILE", help="diagram: .json, or .py that defines `diagram`")
    parser.add_argument("--to", required=True, metavar="FILE", help="where to; by suffix .mat .npz .mtx .json .fmu")
    parser.add_argument("--at", type=float, metavar="S", help="time of a run, s, whose state is linearised about")
    parser.add_argument("--result", metavar="RUN.h5", help="that run; otherwise it is made with --dt")
    parser.add_argument("--step", type=float, default=0.01, metavar="S", help="longest step of an FMU, s (0.01)")
    parser.add_argument(
        "--effects", choices=("auto", "all"), default="auto", help="compute what is called for (auto), or everything"
    )
    add_run_options(parser, required=False)


def carry_out(options: Namespace) -> Answer:
    """Write one file, or several.

    Parameters
    ----------
    options : argparse.Namespace
        What was typed.

    Returns
    -------
    Answer
        The files.

    Raises
    ------
    ExportError
        If the suffix is unknown, or the file cannot be written.
    DataError
        If a time is asked for without a run, or of what has none.
    PhblocksError
        If the file cannot be read, or the diagram does not compile.
    """
    suffix = Path(options.to).suffix.lower()
    if suffix not in (*MATRICES, ".json", ".fmu"):
        raise ExportError(
            f"file {options.to}",
            expected="a suffix out of .mat, .npz, .mtx, .json, .fmu",
            got=repr(suffix) if suffix else "none",
            fix="The suffix chooses the format.",
        )
    asked = [name for name in ("at", "result") if getattr(options, name) is not None]
    if asked and (suffix not in MATRICES or options.at is None):
        raise DataError(
            f"export --{asked[0]}",
            expected="matrices (.mat, .npz, .mtx) and --at SECONDS",
            got=f"--to {options.to}{'' if options.at is None else f' --at {options.at:g}'}",
            fix="A diagram has no time.",
        )
    source = Source.of(options.file)
    diagram = source.diagram()
    data = {"file": options.file, "name": diagram.name, "time": options.at}
    if suffix == ".json":
        files = [diagram.save(options.to)]
    elif suffix == ".fmu":
        from phblocks.fmu import write

        files = [write(diagram, options.to, step=options.step)]
    else:
        system = diagram.compile(effects=options.effects)
        state = None if options.at is None else _state(source, system, options)
        files = list(system.export(options.to, state=state))
        data |= {"states": system.n, "inputs": list(system.input_names), "outputs": list(system.output_names)}
    return Answer("\n".join(map(str, files)), {**data, "files": [str(path) for path in files]})


def _state(source: Source, system: System, options: Namespace) -> State:
    """The state of a run at a time."""
    import phblocks as ph

    if options.result is not None:
        return ph.read(options.result, system).at(options.at)
    if options.at == 0.0:
        return system.start
    options.t_end = options.at if options.t_end is None else options.t_end
    solution = simulated(source, system, options)
    if not solution.status.ok:
        raise DataError(
            "export --at",
            expected=f"a run that reaches {options.at:g} s",
            got=str(solution.status),
            fix="Ask for an earlier time.",
        )
    return solution.at(options.at)
