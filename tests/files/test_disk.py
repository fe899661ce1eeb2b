"""Full disks and places that cannot be written to: the run stops with a status, and keeps what it has."""

import errno
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, ResultFileError
from phblocks.files import envelope
from phblocks.files.stored import chunk_of, folder_of

RUN = {"t_end": 0.25, "dt": 0.002, "inputs": {"tip": lambda t: (0.5 * np.sin(3.0 * t), 0.2 * t)}}


def full_at(monkeypatch, count):
    """The disk is full from the given write on."""
    true, calls = envelope.write_all, []

    def write_all(file, data):
        calls.append(1)
        if len(calls) >= count:
            true(file, data[:100])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        true(file, data)

    for module in ("envelope", "journal"):
        monkeypatch.setattr(f"phblocks.files.{module}.write_all", write_all)


@pytest.mark.parametrize("count", [2, 4, 7, 8])
def test_a_disk_that_is_full_during_the_run(systems, tmp_path, same, monkeypatch, count):
    system, path = systems["arm"], tmp_path / "run.h5"
    whole = ph.simulate(system, save=ph.Stream(tmp_path / "whole.h5", chunk=20), **RUN)
    with monkeypatch.context() as patched:
        full_at(patched, count)
        solution = ph.simulate(system, save=ph.Stream(path, chunk=20), **RUN)
    status = solution.status
    assert not status.ok and status.name == "not written" and str(path) in status.text
    assert "No space left on device" in status.text and "ph.resume" in status.text
    assert status.error.errno == errno.ENOSPC
    # in memory: all up to there; the chunks before, read from the disk
    assert solution.statistics.steps == min(20 * (count - 1), 125) == solution.statistics.newton_iterations.size
    assert solution.t[-1] == status.time and solution.t.size == solution.statistics.steps + 1
    np.testing.assert_array_equal(solution.x[:-1], whole.x[: solution.t.size - 1])
    assert np.isfinite(solution.position("beam", 1.0)).all() and solution.max_power_balance_error < 1e-12
    # on the disk: the chunks before, complete, and nothing half written
    assert sorted(p.name for p in folder_of(path).iterdir()) == [*(f"{i:08d}.h5" for i in range(count - 1)), "lock"]
    assert ph.read(path).t.size in (20 * (count - 2), 20 * (count - 2) + 1)
    same(whole, ph.resume(path, system, inputs=RUN["inputs"]))


def test_a_disk_that_is_full_when_chunks_are_gathered(systems, tmp_path, same, monkeypatch):
    """The chunks stay, and are all there is to know."""
    system, path = systems["arm"], tmp_path / "run.h5"
    whole = ph.simulate(system, save=ph.Stream(tmp_path / "whole.h5", chunk=20), **RUN)
    with monkeypatch.context() as patched:
        full_at(patched, 10)
        solution = ph.simulate(system, save=ph.Stream(path, chunk=20), **RUN)
    assert solution.status.name == "not written" and not path.exists()
    same(whole, solution)
    assert ph.read(path).status.ok
    same(whole, ph.resume(path, system, inputs=RUN["inputs"]))
    assert path.exists() and not folder_of(path).exists()


LIMITED = """
import resource, signal, sys
import phblocks as ph
from run_to_be_killed import pendulum, tip
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
system = pendulum()
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.RLIM_INFINITY))
solution = ph.simulate(system, 0.2, 0.001, inputs={"tip": tip}, save=ph.Stream(sys.argv[1], chunk=20))
print(solution.status.name, solution.status.error.errno, solution.t.size, solution.statistics.steps, flush=True)
resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
print(ph.resume(sys.argv[1], system, inputs={"tip": tip}).status.ok)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="limits of processes")
def test_a_limit_of_the_operating_system(systems, tmp_path, same):
    """A real one: HDF5 itself, told of it, ends the interpreter with a segmentation fault."""
    from tests.files.run_to_be_killed import pendulum, tip

    system = pendulum()
    whole = ph.simulate(system, 0.2, 0.001, inputs={"tip": tip}, save=ph.Stream(tmp_path / "whole.h5", chunk=20))
    size = (tmp_path / "whole.h5").stat().st_size
    path = tmp_path / "run.h5"
    places = [str(Path(ph.__file__).parents[1]), str(Path(__file__).parent)]
    env = os.environ | {"PYTHONPATH": os.pathsep.join(places)}
    ran = subprocess.run(
        [sys.executable, "-c", LIMITED, str(path), str(size - 20000)], capture_output=True, text=True, env=env
    )
    assert ran.returncode == 0, ran.stderr
    # each chunk is small enough, the whole is not
    assert ran.stdout.split() == ["not", "written", str(errno.EFBIG), "201", "200", "True"], ran.stdout + ran.stderr
    same(whole, ph.read(path, system))


# Places


def test_folders_that_are_not_there(systems, tmp_path):
    with pytest.raises(ResultFileError, match="expected a place to write to") as caught:
        ph.simulate(systems["arm"], save=tmp_path / "no" / "run.h5", **RUN)
    assert isinstance(caught.value.__cause__, OSError) and list(tmp_path.iterdir()) == []


def test_something_is_in_the_way(systems, tmp_path):
    """Files where a folder must be: also root is stopped by them."""
    (tmp_path / "run.h5.parts").write_text("")
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    for path in (tmp_path / "run.h5", tmp_path / "file" / "run.h5", "a\0b.h5"):
        with pytest.raises(ResultFileError, match="expected a place to write to"):
            ph.simulate(systems["arm"], save=path, **RUN)
    with pytest.raises(ResultFileError, match="expected a place to write to"):
        ph.simulate(systems["arm"], save=ph.Stream(tmp_path / "folder", replace=True), **RUN)


def test_a_folder_that_goes_away_during_the_run(systems, tmp_path):
    """Nothing can be written nor read any more: the solution has the chunk that was in memory."""
    path = tmp_path / "run.h5"

    def tip(t):
        if t > 0.1:
            shutil.rmtree(folder_of(path), ignore_errors=True)
        return 0.0, 0.0

    solution = ph.simulate(systems["arm"], save=ph.Stream(path, chunk=20), **RUN | {"inputs": {"tip": tip}})
    assert solution.status.name == "not written" and isinstance(solution.status.error, FileNotFoundError)
    assert solution.t[-1] == solution.status.time == pytest.approx(0.12) and solution.t.size >= 20
    assert np.isfinite(solution.position("beam", 1.0)).all()


def test_a_first_chunk_that_cannot_be_written(systems, tmp_path, monkeypatch):
    """Told before any step is taken."""
    full_at(monkeypatch, 1)
    with pytest.raises(ResultFileError, match="No space left on device"):
        ph.simulate(systems["arm"], save=tmp_path / "run.h5", **RUN)
    monkeypatch.undo()
    assert ph.simulate(systems["arm"], save=tmp_path / "run.h5", **RUN).status.ok  # nothing is in the way


def test_names_that_are_taken(systems, tmp_path, cut):
    system, path = systems["arm"], tmp_path / "run.h5"
    cut(system, ph.Stream(path, chunk=20), 0.1, **RUN)
    with pytest.raises(ResultFileError, match=r"expected a name that is free.*ph\.resume"):
        ph.simulate(system, save=path, **RUN)
    longer = ph.simulate(system, save=ph.Stream(path, chunk=20, replace=True), **RUN)
    assert longer.status.ok and not folder_of(path).exists()
    with pytest.raises(ResultFileError, match="expected a name that is free"):
        ph.simulate(system, save=path, **RUN)
    replaced = ph.simulate(system, save=ph.Stream(path, replace=True), **RUN | {"t_end": 0.1})
    assert replaced.t[-1] == 0.1 == ph.read(path).t[-1] and not chunk_of(path, 0).exists()


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"path": 3}, ArgumentTypeError, "Stream path"),
        ({"path": ""}, ArgumentTypeError, "Stream path"),
        ({"path": "run.h5", "chunk": 9}, DataError, "Stream chunk: expected at least 10"),
        ({"path": "run.h5", "chunk": 20.0}, ArgumentTypeError, "Stream chunk"),
        ({"path": "run.h5", "chunk": True}, ArgumentTypeError, "Stream chunk"),
        ({"path": "run.h5", "replace": 1}, ArgumentTypeError, "Stream replace"),
    ],
)
def test_options(options, error, words):
    with pytest.raises(error, match=words):
        ph.Stream(**options)


def test_what_is_not_a_file(systems):
    with pytest.raises(ArgumentTypeError, match="Stream path"):
        ph.simulate(systems["arm"], save=3, **RUN)
    with pytest.raises(ArgumentTypeError, match="read path"):
        ph.read(None)
