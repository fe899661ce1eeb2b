"""kill -9 at random moments: nothing is corrupt, and what is resumed ends as if it had never been killed."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import phblocks as ph
from phblocks.files.stored import chunk_of, folder_of

SCRIPT = Path(__file__).with_name("run_to_be_killed.py")


def start(path, steps) -> subprocess.Popen:
    """A process that has compiled its system and goes on with the run."""
    process = subprocess.Popen(
        [sys.executable, str(SCRIPT), str(path), str(steps)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(Path(ph.__file__).parents[1])},
    )
    assert process.stdout.readline() == "ready\n", process.stderr.read()
    return process


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs kill -9")
@pytest.mark.parametrize("kills", [5, pytest.param(20, marks=pytest.mark.slow)])
def test_kills(tmp_path, same, kills):
    """Moments are drawn; each is later in the run than the last, so that there is something left to kill."""
    from tests.files.run_to_be_killed import pendulum, tip

    steps, chunk = 120 * kills, 20
    path, draw = tmp_path / "killed.h5", random.Random(7)
    system = pendulum()
    whole = ph.simulate(
        system, steps * 0.001, 0.001, inputs={"tip": tip}, save=ph.Stream(tmp_path / "whole.h5", chunk=chunk)
    )
    killed, seen = 0, 0
    while killed < kills:
        process = start(path, steps)
        goal = seen + draw.randrange(5)  # chunks that are there when it is killed
        while process.poll() is None and not chunk_of(path, goal).exists():
            time.sleep(0.001)
        time.sleep(draw.random() * 0.03)  # anywhere in the next chunk, or while it is written
        process.send_signal(signal.SIGKILL)
        process.communicate()
        assert process.returncode == -signal.SIGKILL, "it was faster than the kill"
        killed += 1
        run = ph.read(path)  # whole, undamaged, and nothing is lost but the chunk that was not written
        written = len(list(folder_of(path).glob("*.h5")))
        assert run.status.name == "interrupted" and written > goal
        assert run.statistics.newton_iterations.size == (written - 1) * chunk == run.statistics.steps
        assert run.t.size in ((written - 1) * chunk, (written - 1) * chunk + 1)
        assert (run.x == whole.x[: run.t.size]).all()
        seen = written
    process = start(path, steps)
    out, errors = process.communicate()
    assert out == "done\n" and process.returncode == 0, errors
    same(whole, ph.read(path, system))
    assert sorted(os.listdir(tmp_path)) == ["killed.h5", "whole.h5"]
