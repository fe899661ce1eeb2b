"""The command line: ``phblocks check | run | export | plot | study FILE``, described in ``docs/cli.md``.

A command is a file with two functions: one adds its options to the parser, the other one carries it out and gives an
:class:`~phblocks.cli.answer.Answer`. What is heavy is imported there, so that help is quick.
"""

from phblocks.cli.entry import main

__all__ = ["main"]
