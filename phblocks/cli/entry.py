"""From arguments to an exit code: one command, its answer, or what went wrong, said in a line."""

from __future__ import annotations

import argparse
import json
import os
import sys
import traceback
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from typing import Any

from phblocks.cli import check, export, plot, run, study
from phblocks.cli.answer import FAULT, INTERRUPTED, NO, WRONG, Answer, jsonable
from phblocks.errors import (
    ApproximationError,
    CausalityError,
    ConstraintError,
    PhblocksError,
    PhblocksWarning,
    StructureError,
    StudyError,
)

#: The diagram was read, and cannot work as it is drawn; the runs of a study failed.
ANSWERS_NO = (CausalityError, ConstraintError, StructureError, ApproximationError, StudyError)
EPILOG = """\
FILE is a diagram as JSON (phblocks export scene.py --to scene.json), or a Python file that defines `diagram`: a
Diagram, or a function that returns one. FILE.py:NAME takes another name.

exit codes:
  0  done, and the answer is yes
  1  the answer is no: the diagram is not causal or does not compile, a run ended early, a study failed
  2  wrong usage or input
  3  a fault of the program: please report it, with --traceback

examples:
  phblocks check crane.json
  phblocks run crane.py --t-end 10 --dt 0.01 --out crane.h5
  phblocks plot crane.h5 --kind energy
  phblocks study crane.py --over dt --values 0.02 0.01 0.005 --t-end 1 --quantity position:jib:1.0
"""


def parser() -> argparse.ArgumentParser:
    """Describe all commands and their options.

    Returns
    -------
    argparse.ArgumentParser
        For :func:`main`, and for help.
    """
    wrapped = argparse.RawDescriptionHelpFormatter
    top = argparse.ArgumentParser(
        prog="phblocks",
        description="Flexible mechanisms and other port-Hamiltonian systems as block diagrams.",
        epilog=EPILOG,
        formatter_class=wrapped,
    )
    top.add_argument("--version", action="store_true", help="print the version and exit")
    common = argparse.ArgumentParser(add_help=False)
    shared = common.add_argument_group("options of all commands")
    shared.add_argument("--json", action="store_true", help="write the answer to stdout as JSON")
    shared.add_argument("--traceback", "--debug", action="store_true", help="show where an error was raised")
    shared.add_argument(
        "--progress",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="show a progress bar on stderr; by default on a terminal, after a second",
    )
    commands = top.add_subparsers(dest="command", metavar="COMMAND")
    for command in (check, run, export, plot, study):
        sub = commands.add_parser(
            command.__name__.rpartition(".")[2],
            help=command.HELP,
            description=f"{command.HELP[0].upper()}{command.HELP[1:]}.",
            epilog=command.EPILOG,
            parents=[common],
            formatter_class=wrapped,
        )
        command.add_options(sub)
        sub.set_defaults(carry_out=command.carry_out)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Carry out one command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; those of the process by default.

    Returns
    -------
    int
        The exit code: 0 done, 1 the answer is no, 2 wrong usage or input, 3 a fault of the program, 130 interrupted.
    """
    top = parser()
    try:
        options = top.parse_args(argv)
    except SystemExit as end:  # argparse has said what is wrong, or printed its help
        return int(end.code or 0)
    if options.version:
        from phblocks import __version__

        print(f"phblocks {__version__}")
        return 0
    if options.command is None:
        top.print_help(sys.stderr)
        return WRONG
    said: list[str] = []
    data: dict[str, Any] = {"command": options.command}
    text = None
    try:
        with _warned(said), redirect_stdout(sys.stderr):  # a file that prints does not print into the answer
            answer: Answer = options.carry_out(options)
        data |= {"ok": answer.ok, **answer.data, "warnings": said}
        text, code = answer.text, answer.code
    except KeyboardInterrupt:
        print("phblocks: interrupted", file=sys.stderr)
        return INTERRUPTED
    except Exception as error:
        data |= {"ok": False, "error": _told(error, options.traceback), "warnings": said}
        code = NO if isinstance(error, ANSWERS_NO) else WRONG if isinstance(error, PhblocksError) else FAULT
    try:
        if options.json:
            print(json.dumps(jsonable(data), indent=1, ensure_ascii=False))
        elif text is not None:
            print(text)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader, such as head, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return code


def _told(error: Exception, with_traceback: bool) -> dict[str, Any]:
    """Say on stderr what went wrong; return it for JSON."""
    if with_traceback:
        traceback.print_exception(error)
    ours = isinstance(error, PhblocksError)
    said = str(error) if ours else f"{type(error).__name__}: {error}"
    notes = [str(note) for note in getattr(error, "__notes__", ())]
    hint = [] if ours or with_traceback else ["This is a fault of the program; --traceback shows where."]
    print(" ".join(["phblocks: error:", said, *notes, *hint]), file=sys.stderr)
    parts = {key: getattr(error, key) for key in ("code", "where", "expected", "got", "fix") if ours}
    return {"type": type(error).__name__, "message": " ".join([said, *notes]), **parts}


@contextmanager
def _warned(said: list[str]) -> Iterator[None]:
    """Show warnings of the library as a line on stderr, and keep them; leave others as they are."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", PhblocksWarning)
        show = warnings.showwarning

        def tell(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if not issubclass(category, PhblocksWarning):
                show(message, category, *place, **more)
                return
            said.append(str(message))
            print(f"phblocks: warning: {message}", file=sys.stderr)

        warnings.showwarning = tell
        yield
