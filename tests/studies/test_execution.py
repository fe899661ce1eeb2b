"""Others do the runs: threads, processes, a cluster. The same numbers come back."""

from concurrent.futures import Executor, Future, ThreadPoolExecutor

import pytest

import phblocks as ph
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


class Lost(Executor):
    """Workers that never come back."""

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        future.set_exception(MemoryError("worker killed"))
        return future


def test_a_lost_worker():
    with pytest.raises(ph.errors.StudyError, match="MemoryError: worker killed"):
        study(Lost())
