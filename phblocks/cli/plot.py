"""``phblocks plot``: a picture, a film or a page, of a diagram or of a run."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from phblocks.cli.answer import Answer
from phblocks.cli.run import simulated
from phblocks.cli.scene import Source
from phblocks.cli.values import add_run_options
from phblocks.errors import DataError, ExportError

if TYPE_CHECKING:
    from phblocks.results.readings import Readings
    from phblocks.results.solution import Solution

HELP = "draw a diagram, or a run"
EPILOG = """\
kinds of pictures (.png, .svg, .pdf):
  of a diagram:         diagram, sparsity (of J), spectrum (natural frequencies)
  of a run:             motion, energy, balance (what a step leaves over), gap, power-flow
  of a run, not .png:   animation (.html, .gif, .mp4), report (.html, one page with everything)

A run is stored (--result run.h5, beside FILE), or made for the picture (--t-end, --dt). Energy and balance of a stored
run need no diagram.

examples:
  phblocks plot crane.py --out crane.svg
  phblocks plot crane.h5 --kind energy
  phblocks plot crane.py --result crane.h5 --kind motion --out motion.png
  phblocks plot crane.py --t-end 2 --dt 0.01 --kind report --out crane.html
"""
OF_DIAGRAM = ("diagram", "sparsity", "spectrum")
OF_READINGS = ("energy", "balance")
OF_RUN = (*OF_READINGS, "motion", "gap", "power-flow", "animation", "report")
#: Suffixes of a kind that is no picture, the first of them the default.
SUFFIXES = {"animation": (".html", ".gif", ".mp4"), "report": (".html",)}
PICTURES = (".png", ".svg", ".pdf")
#: Dots per inch: Matplotlib can draw neither text with less nor large pictures with more.
LEAST_DPI, MOST_DPI = 10.0, 2400.0


def add_options(parser: ArgumentParser) -> None:
    """Add the options of the command.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        Of the command.
    """
    parser.add_argument("file", metavar="FILE|RESULT", help="diagram (.json, .py), or a stored run (.h5)")
    parser.add_argument("--kind", choices=(*OF_DIAGRAM, *OF_RUN), help="diagram by default; energy of a stored run")
    parser.add_argument("--result", metavar="RUN.h5", help="the stored run of FILE")
    parser.add_argument("--out", metavar="FILE", help="where to; FILE_KIND.png by default")
    parser.add_argument("--times", type=float, nargs="+", metavar="S", help="of the snapshots of motion, s")
    parser.add_argument("--modes", type=int, default=20, metavar="N", help="in the spectrum (20)")
    parser.add_argument("--dpi", type=float, default=150.0, metavar="N", help="dots per inch, 10 to 2400 (150)")
    add_run_options(parser, required=False)


def carry_out(options: Namespace) -> Answer:
    """Draw one picture.

    Parameters
    ----------
    options : argparse.Namespace
        What was typed.

    Returns
    -------
    Answer
        Where it is; no if the run in it ended early.

    Raises
    ------
    DataError
        If the kind needs a run, or a diagram, that is not given, or an option is out of its range.
    ExportError
        If the suffix is unknown, or the file cannot be written.
    PhblocksError
        If a file cannot be read, or the diagram does not compile.
    """
    if not LEAST_DPI <= options.dpi <= MOST_DPI:
        raise DataError(
            "plot --dpi", expected=f"{LEAST_DPI:g} to {MOST_DPI:g}", got=f"{options.dpi:g}", fix="Such as --dpi 150."
        )
    stored = Path(options.file).suffix.lower() == ".h5"
    kind = options.kind or ("energy" if stored or options.result else "diagram")
    out = _place(options, kind)
    run: Readings | None = None
    if stored and kind not in OF_READINGS:
        raise DataError(
            f"plot --kind {kind}",
            expected="the diagram of the run too",
            got=options.file,
            fix=f"phblocks plot FILE --result {options.file} --kind {kind}, with the diagram for FILE.",
        )
    if kind in OF_DIAGRAM:
        draw = _of_diagram(kind, options)
    else:
        import phblocks as ph

        run = ph.read(options.file) if stored else _run(options)
        draw = _of_run(kind, run, options)
    draw(out)
    status = None if run is None else {key: getattr(run.status, key) for key in ("ok", "name", "text", "time")}
    text = f"{out}" if run is None or run.status.ok else f"{out}\nstatus   {run.status}"
    data = {"file": options.file, "kind": kind, "out": str(out), "status": status}
    return Answer(text, data, run is None or run.status.ok)


def _place(options: Namespace, kind: str) -> Path:
    suffixes = SUFFIXES.get(kind, PICTURES)
    default = f"{Path(Source.of(options.file).stem if ':' in options.file else options.file).stem}_{kind}{suffixes[0]}"
    out = Path(options.out or default)
    if out.suffix.lower() not in suffixes:
        raise ExportError(
            f"file {out}",
            expected=f"for {kind} a suffix out of {', '.join(suffixes)}",
            got=repr(out.suffix) if out.suffix else "none",
            fix="The suffix chooses the format.",
        )
    if not out.parent.is_dir():
        raise ExportError(
            f"file {out}", expected="a folder that exists", got=f"{out.parent}", fix="Make the folder first."
        )
    return out


def _run(options: Namespace) -> Solution:
    """The run of a diagram, stored or made."""
    import phblocks as ph

    source = Source.of(options.file)
    system = source.diagram().compile()
    return simulated(source, system, options) if options.result is None else ph.read(options.result, system)


def _written(write: Callable[[Path], object], out: Path) -> None:
    try:
        write(out)
    except OSError as error:
        raise _not_written(out, error) from error


def _of_diagram(kind: str, options: Namespace) -> Callable[[Path], object]:
    from phblocks import plots

    diagram = Source.of(options.file).diagram()
    if kind == "diagram":
        return lambda out: write_figure(lambda: plots.diagram(diagram), out, options.dpi)
    system = diagram.compile()
    if kind == "sparsity":
        return lambda out: write_figure(lambda: plots.sparsity(system, "J"), out, options.dpi)
    modes = system.modes(options.modes)
    return lambda out: write_figure(lambda: plots.spectrum(modes, dt=options.dt), out, options.dpi)


def _of_run(kind: str, run: Any, options: Namespace) -> Callable[[Path], object]:
    from phblocks import plots

    if kind in SUFFIXES:
        return partial(_written, run.animate if kind == "animation" else run.report)
    drawn: dict[str, Callable[[], Any]] = {
        "energy": lambda: plots.energy(run),
        "balance": lambda: plots.energy(run, increments=True),
        "motion": lambda: plots.motion(run, options.times),
        "gap": lambda: plots.gap(run),
        "power-flow": lambda: plots.power_flow(run),
    }
    return lambda out: write_figure(drawn[kind], out, options.dpi)


def write_figure(draw: Callable[[], Any], out: Path, dpi: float = 150.0) -> None:
    """Draw, write and forget a figure.

    Parameters
    ----------
    draw : callable
        Draws and returns axes, or a figure.
    out : pathlib.Path
        Where to.
    dpi : float, optional
        Dots per inch.

    Raises
    ------
    ExportError
        If it cannot be written.
    """
    import matplotlib

    matplotlib.use("Agg")  # there is no window to open
    import matplotlib.pyplot as plt

    figure = draw().figure
    try:
        figure.savefig(out, dpi=dpi, bbox_inches="tight")
    except OSError as error:
        raise _not_written(out, error) from error
    finally:
        plt.close(figure)


def _not_written(out: Path, error: OSError) -> ExportError:
    return ExportError(
        f"file {out}", expected="a place to write to", got=str(error), fix="Check folder, permissions and space."
    )
