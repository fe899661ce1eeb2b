"""Others do the runs: threads, processes, a cluster. The same numbers come back."""

import os
import subprocess
import sys
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path

import pytest

import phblocks as ph
from phblocks.studies import execution
from tests.studies import scenes


def study(executor, **more):
    return ph.studies.work_precision(
        more.pop("make_system", scenes.oscillator),
        [ph.Midpoint()],
        [0.1, 0.05],
        quantity=("position", "mass", (0.0, 0.0)),
        t_end=1.0,
        executor=executor,
        **{"repeats": 2, **more},
    )


@pytest.fixture(scope="module")
def alone():
    return study(None)


def same(found, alone):
    """The numbers of runs on their own, with marks that they were not."""
    for name in ("method", "dt", "error", "steps", "newton_iterations", "reference_uncertainty", "repeats", "status"):
        assert found.column(name) == alone.column(name)
    assert all(found.column("shared_machine")) and not any(alone.column("shared_machine"))
    for text in (str(found), found.to_markdown()):
        assert "Runs shared a machine" in text


def test_threads(alone):
    with ThreadPoolExecutor(2) as executor:
        same(study(executor, make_system=lambda: scenes.oscillator()), alone)


def test_processes(alone):
    with ph.studies.processes(1) as executor:
        same(study(executor), alone)
        with pytest.raises(ph.errors.ArgumentTypeError, match="Define make_system"):
            study(executor, make_system=lambda: scenes.oscillator())


def test_dask(alone):
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 1, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with (
        distributed.LocalCluster(**options) as cluster,
        distributed.Client(cluster) as client,
        client.get_executor() as executor,
    ):
        same(study(executor), alone)


def test_a_machine_for_each_run_can_be_declared(alone):
    with ThreadPoolExecutor(1) as executor:
        assert not any(study(executor, shared_machine=False).column("shared_machine"))


def test_what_is_not_timed_goes_to_processes(alone, monkeypatch):
    """The runs of the reference, and of orders: the same numbers; times are those of runs that were alone."""
    monkeypatch.setattr(execution, "PATIENCE", 0.0)
    monkeypatch.setattr(os, "cpu_count", lambda: 1)  # one worker is started sooner
    sent, send = [], execution._send
    monkeypatch.setattr(execution, "_send", lambda jobs, *rest: sent.append(len(jobs)) or send(jobs, *rest))
    found = study(None)
    assert sent == [2] and not any(found.column("shared_machine"))  # no mesh: two runs give the reference
    for name in ("error", "reference_uncertainty", "steps"):
        assert found.column(name) == alone.column(name)
    untimed = study(None, repeats=0)
    assert sent[1:] == [4] and all(untimed.column("shared_machine")) and untimed.column("repeats") == [1, 1]
    assert untimed.column("error") == alone.column("error")
    options = {"quantity": ("position", "mass", (0.0, 0.0)), "t_end": 1.0}
    orders = ph.studies.convergence(scenes.oscillator, "dt", [0.1, 0.05, 0.025], **options)
    assert sent[2:] == [3] and orders.order == pytest.approx(2.0, abs=0.02)
    assert all(orders.column("shared_machine"))
    # what cannot be sent is made here, and nobody is asked to mend it
    here = ph.studies.convergence(lambda: scenes.oscillator(), "dt", [0.1, 0.05, 0.025], **options)
    assert len(sent) == 3 and here.column("error") == orders.column("error")
    assert not any(here.column("shared_machine"))


def test_short_studies_start_no_processes(monkeypatch):
    monkeypatch.setattr(execution, "processes", None)
    monkeypatch.setattr(execution, "PATIENCE", float("inf"))  # however slow the machine
    assert not any(study(None, repeats=0).column("shared_machine"))


SCRIPT = """
import phblocks as ph
from phblocks.studies import execution

print("read")
execution.PATIENCE = 0.0

def make():
    d = ph.Diagram("oscillator")
    spring = d.add(ph.Spring("spring", 4.0, (0.0, 0.0), (1.0, 0.0), free_length=0.9))
    mass = d.add(ph.Mass("mass", 1.0, (1.0, 0.0)))
    d.pin(spring.start, d.ground)
    d.pin(spring.end, mass.centre)
    return d.compile()

def main():
    orders = ph.studies.convergence(
        make, "dt", [0.2, 0.1, 0.05], quantity=("position", "mass", (0.0, 0.0)), t_end=1.0
    )
    print("shared" if all(orders.column("shared_machine")) else "alone")

"""


@pytest.mark.parametrize(("guard", "says"), [('if __name__ == "__main__":\n    ', "shared"), ("", "alone")])
def test_scripts_with_and_without_a_guard(tmp_path, guard, says):
    """Without it, workers would start the study again when they read the script: they are not started."""
    path = tmp_path / "script.py"
    path.write_text(f"{SCRIPT}{guard}main()\n", encoding="utf-8")
    root = Path(__file__).resolve().parents[2]
    done = subprocess.run(
        [sys.executable, path], capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(root)}, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == says and done.stderr == ""
    assert guard or done.stdout.splitlines() == ["read", "alone"]


class Lost(Executor):
    """Workers that never come back."""

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        future.set_exception(MemoryError("worker killed"))
        return future


def test_a_lost_worker():
    with pytest.raises(ph.errors.StudyError, match="MemoryError: worker killed"):
        study(Lost())
