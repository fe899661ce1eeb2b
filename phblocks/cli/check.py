"""``phblocks check``: who gives and who takes, what cannot work, how to mend it, and what is computed."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections import Counter
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from phblocks.cli.answer import Answer
from phblocks.cli.scene import Source
from phblocks.errors import DataError

if TYPE_CHECKING:
    from phblocks.causality import CausalityReport
    from phblocks.diagram import Diagram
    from phblocks.system import System

HELP = "say who gives and who takes at every junction, and which effects are computed"
EPILOG = """\
exit code 1 if the diagram is not causal, or does not compile.

examples:
  phblocks check crane.json
  phblocks check crane.py --explain jib.start.translation
  phblocks check broken.json --repair 0 --save mended.json
"""


def add_options(parser: ArgumentParser) -> None:
    """Add the options of the command.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        Of the command.
    """
    parser.add_argument("file", metavar="FILE", help="diagram: .json, or .py that defines `diagram`")
    parser.add_argument("--explain", metavar="PORT", help="say why a port gives what it gives: crank.start.translation")
    parser.add_argument("--effects", action="store_true", help="list all effects, also those that are kept")
    parser.add_argument("--repair", type=int, metavar="N", help="make the N-th repair (from 0); with --save")
    parser.add_argument("--save", metavar="FILE", help="write the repaired diagram to this .json file")


def carry_out(options: Namespace) -> Answer:
    """Check a diagram, and compile it if it is causal.

    Parameters
    ----------
    options : argparse.Namespace
        What was typed.

    Returns
    -------
    Answer
        No if the diagram is not causal.

    Raises
    ------
    DataError
        If there is no such repair, or no place to write it to.
    PhblocksError
        If the file cannot be read, or the diagram does not compile.
    """
    diagram = Source.of(options.file).diagram()
    report = diagram.check()
    lines, data = [str(report)], {"file": options.file, "name": diagram.name, **_described(report)}
    if options.explain is not None:
        data["explanation"] = report.explain(options.explain)
        lines += ["", data["explanation"]]
    if options.repair is not None or options.save is not None:
        data["saved"] = _repaired(diagram, report, options.repair, options.save)
        lines += ["", f"repaired diagram in {data['saved']}"]
    if report.ok:
        system = diagram.compile()
        data |= _compiled(system)
        lines += ["", _told(system, options.effects)]
    return Answer("\n".join(lines), data, report.ok)


def _described(report: CausalityReport) -> dict[str, Any]:
    return {
        "causal": report.ok,
        "assignments": [
            {
                "port": a.port.path,
                "gives": a.given,
                "takes": a.taken,
                "fixed": a.fixed,
                "joined_to": [p.path for p in a.junction.ports if p is not a.port]
                + [f"outside {e.name!r}" for e in a.junction.exposures],
            }
            for a in report.assignments
            if not a.port.block.shared
        ],
        "switches": list(report.switches),
        "shared": [[port.path for port in ports] for ports in report.shared] if report.ok else [],
        "conflicts": [{"text": c.text, "advice": c.advice, "code": c.error.code} for c in report.conflicts],
        "repairs": [{"what": repair.what, "cost": asdict(repair.cost)} for repair in report.repairs],
    }


def _repaired(diagram: Diagram, report: CausalityReport, number: int | None, path: str | None) -> str:
    if number is None or path is None:
        raise DataError(
            "check --repair",
            expected="--repair N and --save FILE.json together",
            got="one of them",
            fix="The diagram in FILE is not changed: say where the repaired one goes.",
        )
    if not 0 <= number < len(report.repairs):
        raise DataError(
            "check --repair",
            expected=f"one of the {len(report.repairs)} repairs of the diagram, counted from 0",
            got=str(number),
            fix="phblocks check lists them.",
        )
    return str(report.repairs[number].apply(diagram).save(path))


def _compiled(system: System) -> dict[str, Any]:
    return {
        "states": system.n,
        "constraints": list(system.constraint_names),
        "inputs": list(system.input_names),
        "outputs": list(system.output_names),
        "effects": [asdict(effect) for effect in system.effects],
    }


def _told(system: System, whole: bool) -> str:
    number = Counter(effect.status for effect in system.effects)
    counts = ", ".join(f"{number[status]} {status}" for status in ("kept", "pruned", "approximated"))
    inputs = f", inputs {', '.join(system.input_names)}" if system.input_names else ""
    held = f", {len(system.constraint_names)} constraints" if system.constraint_names else ""
    lines = [f"compiled: {system.n} states{held}{inputs}", f"effects: {counts}"]
    shown = system.effects if whole else type(system.effects)(e for e in system.effects if e.status != "kept")
    return "\n".join([*lines, *([str(shown)] if len(shown) else [])])
