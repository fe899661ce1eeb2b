"""Others do the runs: threads, processes, a cluster. The same numbers come back."""

from concurrent.futures import Executor, Future, ThreadPoolExecutor

import numpy as np
import pytest
from threadpoolctl import threadpool_info

import phblocks as ph
from phblocks.studies import machine
from tests.studies import scenes


def study(executor, **more):
    return ph.studies.work_precision(
        more.pop("make_system", scenes.oscillator),
        [ph.Midpoint()],
        [0.1, 0.05],
        quantity=("position", "mass", (0.0, 0.0)),
        t_end=1.0,
        repeats=2,
        executor=executor,
        **more,
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
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with (
        distributed.LocalCluster(**options) as cluster,
        distributed.Client(cluster) as client,
        client.get_executor() as executor,
    ):
        same(study(executor), alone)


def test_a_machine_for_each_run_can_be_declared(alone):
    with ThreadPoolExecutor(1) as executor:
        assert not any(study(executor, shared_machine=False).column("shared_machine"))


class Lost(Executor):
    """Workers that never come back."""

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        future.set_exception(MemoryError("worker killed"))
        return future


def test_a_lost_worker():
    with pytest.raises(ph.errors.StudyError, match="MemoryError: worker killed"):
        study(Lost())


def threads():
    return [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]


def test_one_thread_however_many_are_inside():
    """The limit is lifted by the last one out."""
    before = threads()
    assert before  # NumPy brings a library with it
    with machine.one_thread():
        with machine.one_thread():
            assert set(threads()) == {1}
        assert set(threads()) == {1}
    assert threads() == before


def test_machine():
    here = machine.this_machine()
    assert here.numpy == np.__version__ and here.cpu and here.cores >= 1
    assert here.cpu in str(here) and here.python in str(here)
