"""docs/cli.md: its file is written, its commands run, its program gets its answer, its table is that of the code."""

import re
import shlex
from pathlib import Path

import pytest

from phblocks.cli import answer, export, main, plot, values
from tests.test_readme import python_blocks

PAGE = Path(__file__).parents[2] / "docs" / "cli.md"
TEXT = PAGE.read_text(encoding="utf-8")


def test_commands_and_programs_run(tmp_path, monkeypatch, capsys):
    pytest.importorskip("h5py")
    monkeypatch.chdir(tmp_path)
    scene, program = python_blocks(TEXT)
    assert scene.strip().startswith("# crane.py")
    Path("crane.py").write_text(scene, encoding="utf-8")
    lines = [line for block in re.findall(r"^```sh\n(.*?)^```$", TEXT, re.S | re.M) for line in block.splitlines()]
    assert len(lines) > 12
    for line in lines:
        name, *arguments = shlex.split(line)
        assert name == "phblocks" and main(arguments) == 0, (line, capsys.readouterr().err)
    written = {path.name for path in tmp_path.iterdir()}
    named = set(re.findall(r"(?:--to|--out|--table) (\S+)", "\n".join(lines))) - {"bent.mtx"}
    assert named <= written and "bent.mtx.json" in written and "crane_energy.png" in written
    monkeypatch.setenv("PYTHONPATH", str(PAGE.parents[1]))
    exec(compile(program, str(PAGE), "exec"), {"__name__": "page"})
    assert float(capsys.readouterr().out.split()[-2]) > 0.0


def test_exit_codes_are_those_of_the_program():
    codes = [int(code) for code in re.findall(r"^\| (\d+) \|", TEXT, re.M)]
    assert codes == [answer.DONE, answer.NO, answer.WRONG, answer.FAULT, answer.INTERRUPTED]


def test_everything_that_can_be_chosen_is_on_the_page():
    for name in (*values.METHODS, *values.KINDS, *plot.OF_DIAGRAM, *plot.OF_RUN, *export.MATRICES, ".json", ".fmu"):
        assert f"`{name}`" in TEXT, name
