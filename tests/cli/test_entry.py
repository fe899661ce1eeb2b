"""Exit codes, errors without tracebacks, JSON with nothing around it: in this process and in processes of their own."""

import json
import subprocess
import sys

import pytest

import phblocks as package
from phblocks.cli import entry, main

LINE = [sys.executable, "-W", "error", "-m", "phblocks"]


def run(line: str, **options) -> subprocess.CompletedProcess:
    return subprocess.run([*LINE, *line.split()], capture_output=True, text=True, check=False, **options)


def test_as_a_process_of_its_own(folder):
    """What the shell sees: exit codes 0, 1 and 2, the answer on stdout, all else on stderr."""
    done = run("run stone.py --t-end 1 --dt 0.1 --json --progress")
    assert done.returncode == 0 and json.loads(done.stdout)["energy"]["kinetic"]["end"] == pytest.approx(100.0)
    assert "stone" in done.stderr or done.stderr == ""  # the bar waits for a second
    no = run("check bodies.py")
    assert no.returncode == 1 and "not causal" in no.stdout and no.stderr == ""
    wrong = run("check none.json")
    assert wrong.returncode == 2 and wrong.stdout == "" and wrong.stderr.startswith("phblocks: error: [PH501]")


def test_help_loads_no_solver(folder):
    code = "import sys, phblocks.cli as c; c.main(['run', '--help']); print(*sys.modules, file=sys.stderr)"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "examples:" in said.stdout
    assert {"scipy", "scipy.sparse", "matplotlib", "networkx", "sympy"} & set(said.stderr.split()) == set()


def test_a_reader_that_has_seen_enough(folder):
    """``phblocks check ... | head -1`` ends without a complaint."""
    line = " ".join([*LINE, "check", "stone.py", "|", "true"])
    done = subprocess.run(["bash", "-c", f"set -o pipefail; {line}"], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and done.stderr == ""


def test_help_and_version(phblocks):
    for command in ("check", "run", "export", "plot", "study"):
        said = phblocks(f"{command} --help")
        assert said.code == 0 and f"  phblocks {command} " in said.out and "--json" in said.out
    said = phblocks("--help")
    assert said.code == 0 and "exit codes:" in said.out
    assert phblocks("--version").out == f"phblocks {package.__version__}\n"
    assert phblocks("").code == 2
    assert phblocks("simulate stone.py").code == 2


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("raises.py", "x = 1\nx = x / 0\n", "raises.py, line 2"),
        ("syntax.py", "x = 1\ndef\n", "syntax.py, line 2"),
        ("exits.py", "import sys\nsys.exit(3)\n", "exits.py, line 2"),
        ("empty.py", "", "no such name"),
        ("number.py", "diagram = 3\n", "got int"),
        ("raises_later.py", "def diagram():\n    raise KeyError('a')\n", "raises_later.py, line 2"),
        ("ours.py", "import phblocks as ph\nph.Mass('a', -1.0, (0.0, 0.0))\n", "(ours.py, line 2)"),
        ("inputs.py", "import phblocks as ph\ndiagram = ph.Diagram()\ninputs = 3\n", "PH10"),
        ("damaged.json", '{"format": "phblocks diagram",', "expected JSON"),
        ("other.json", "[1, 2]", "phblocks diagram"),
        ("binary.json", "\x00\xff", "JSON"),
        ("text.txt", "", ".json, or .py"),
    ],
)
def test_files_that_are_not_what_they_should_be(phblocks, folder, name, text, told):
    (folder / name).write_text(text, encoding="utf-8")
    said = phblocks(f"run {name} --t-end 1 --dt 0.1")
    assert said.code == 2 and told in said.err and said.out == ""
    assert said.err.startswith("phblocks: error: [PH") and said.err.count("\n") == 1
    data = phblocks(f"run {name} --t-end 1 --dt 0.1 --json").data
    assert not data["ok"] and data["error"]["code"].startswith("PH") and data["error"]["fix"]


def test_a_traceback_if_asked_for(phblocks, folder):
    (folder / "raises.py").write_text("x = 1 / 0\n")
    for flag in ("--traceback", "--debug"):
        said = phblocks(f"check raises.py {flag}")
        assert said.code == 2 and "Traceback" in said.err and "ZeroDivisionError" in said.err
    assert "Traceback" not in phblocks("check raises.py").err


def test_what_a_file_prints_is_not_in_the_answer(phblocks, folder):
    (folder / "loud.py").write_text("print('hello')\n" + (folder / "stone.py").read_text())
    said = phblocks("check loud.py --json")
    assert said.data["ok"] and said.err == "hello\n"


def test_other_names_and_tuples(phblocks, folder):
    (folder / "many.py").write_text((folder / "stone.py").read_text() + "def both():\n    return diagram(), 1\n")
    assert phblocks("check many.py:both --json").data["name"] == "stone"
    assert "no such name" in phblocks("check many.py:none").err


def test_a_file_that_has_changed_is_read_again(phblocks, folder):
    assert phblocks("check stone.py --json").data["name"] == "stone"
    (folder / "stone.py").write_text((folder / "stone.py").read_text().replace('"stone"', '"pebble"'))
    assert phblocks("check stone.py --json").data["name"] == "pebble"


def test_modules_beside_the_file(phblocks, folder, monkeypatch):
    monkeypatch.setattr(sys, "path", sys.path[:])
    (folder / "beside_the_scene.py").write_text("NAME = 'from beside'\n")
    (folder / "with_module.py").write_text(
        "import phblocks as ph\nfrom beside_the_scene import NAME\ndiagram = ph.Diagram(NAME)\n"
        "diagram.add(ph.Mass('m', 1.0, (0.0, 0.0)))\n"
    )
    assert phblocks("check with_module.py --json").data["name"] == "from beside"


def test_warnings_are_a_line_and_in_the_answer(phblocks, folder):
    (folder / "turns.py").write_text(
        (folder / "rod.py")
        .read_text()
        .replace("degree=2)", "degree=2, approximation=ph.Approximation(large_rotation=False))")
    )
    said = phblocks("run turns.py --t-end 0.5 --dt 0.01 --json")
    assert said.code == 0 and said.err.startswith("phblocks: warning: block 'rod' turned by")
    assert len(said.data["warnings"]) == 1 and "turned by" in said.data["warnings"][0]


def test_faults_and_interruptions(phblocks, monkeypatch):
    def fail(options):
        raise RuntimeError("never")

    def interrupt(options):
        raise KeyboardInterrupt

    monkeypatch.setattr(entry.check, "carry_out", fail)
    said = phblocks("check stone.py --json")
    assert said.code == 3 and said.data["error"] == {"type": "RuntimeError", "message": "RuntimeError: never"}
    assert "fault of the program" in said.err
    monkeypatch.setattr(entry.check, "carry_out", interrupt)
    said = phblocks("check stone.py")
    assert said.code == 130 and said.err == "phblocks: interrupted\n"


def test_arguments_of_the_process(folder, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["phblocks", "check", "stone.py", "--json"])
    assert main() == 0
    assert json.loads(capsys.readouterr().out)["name"] == "stone"
