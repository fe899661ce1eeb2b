"""Who does the runs of a study: this process, or any executor of ``concurrent.futures``."""

from __future__ import annotations

import os
import pickle
from collections.abc import Sequence
from concurrent.futures import Executor, as_completed

from tqdm import tqdm

from phblocks.errors import ArgumentTypeError, StudyError
from phblocks.studies.measurement import Measurement, Runner, measure
from phblocks.studies.run import Job
from phblocks.system import System


def processes(workers: int | None = None) -> Executor:
    """Start an executor with processes on this machine.

    Each has an interpreter of its own (started afresh, the same on every platform), so scripts need the guard
    ``if __name__ == "__main__":``, and functions given to the study have to be importable.

    Parameters
    ----------
    workers : int, optional
        How many; by default one a processor.

    Returns
    -------
    concurrent.futures.Executor
        To be used in a ``with`` statement.
    """
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    return ProcessPoolExecutor(workers or os.cpu_count(), mp_context=get_context("spawn"))


def carry_out(jobs: Sequence[Job], executor: Executor | None, name: str, progress: bool | None) -> list[Measurement]:
    """Do the jobs of a study.

    In this process one run follows the other, all repeats after all first runs, so that what disturbs the machine for
    a while disturbs all settings alike. To an executor each job goes as a whole.

    Parameters
    ----------
    jobs : sequence of Job
        The runs.
    executor : concurrent.futures.Executor or None
        Who does them; ``None``: this process.
    name : str
        On the progress bar.
    progress : bool or None
        Show it; by default if a terminal is attached and it takes longer than a second.

    Returns
    -------
    list of Measurement
        In the order of the jobs.

    Raises
    ------
    ArgumentTypeError
        If it is no executor, or the functions cannot be sent to its workers.
    StudyError
        If a worker was lost.
    """
    disable = None if progress is None else not progress
    if executor is None:
        systems: dict[int, System] = {}
        runners = [Runner(job, systems) for job in jobs]
        with tqdm(total=sum(job.repeats for job in jobs), desc=name, unit="run", delay=1.0, disable=disable) as bar:
            for k in range(max(job.repeats for job in jobs)):
                for runner in (r for r in runners if k < r.job.repeats):
                    runner.repeat()
                    bar.update()
        return [runner.measured for runner in runners]
    if not isinstance(executor, Executor):
        raise ArgumentTypeError(
            f"{name} executor",
            expected="an executor of concurrent.futures",
            got=repr(executor),
            fix="Use ph.studies.processes(), or client.get_executor() of Dask.",
        )
    futures = []
    try:
        futures = [executor.submit(measure, job) for job in jobs]
        for future in tqdm(as_completed(futures), total=len(jobs), desc=name, unit="run", delay=1.0, disable=disable):
            future.result()
        return [future.result() for future in futures]
    except Exception as error:  # runs never raise, so this is the way to the worker and back
        for future in futures:
            future.cancel()
        raise _explained(name, jobs[0], error) from error


def _explained(name: str, job: Job, error: Exception) -> Exception:
    try:
        pickle.dumps(job)
    except Exception as reason:  # pickle raises AttributeError, TypeError or its own
        return ArgumentTypeError(
            f"{name} executor",
            expected="functions and arguments that can be sent to another process",
            got=str(reason),
            fix="Define make_system, quantity and inputs with def at the top of a module (no lambda, no function "
            "inside a function), or leave the executor out.",
        )
    return StudyError(
        f"{name} executor",
        expected="workers that return what they measured",
        got=" ".join(f"{type(error).__name__}: {error}".split()).rstrip("."),
        fix='In a script, start the study under if __name__ == "__main__": and define its functions in the file; '
        "a worker may also have run out of memory.",
    )
