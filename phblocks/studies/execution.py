"""Who does the runs of a study: this process, or any executor of ``concurrent.futures``."""

from __future__ import annotations

import ast
import linecache
import os
import pickle
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, as_completed
from dataclasses import replace
from time import perf_counter
from types import FrameType

from tqdm import tqdm

from phblocks.errors import ArgumentTypeError, StudyError
from phblocks.studies.measurement import Measurement, Runner, measure
from phblocks.studies.run import Job
from phblocks.system import System

#: What is not timed is made in this process for so long, s; starting others takes about a second.
PATIENCE = 2.0


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

    To an executor that is given each job goes as a whole. Without one, jobs that are not timed come first: in this
    process, and what is left of them after ``PATIENCE`` in processes of their own, where they can be made there. Jobs
    that are timed follow in this process with nothing beside them, all repeats after all first runs, so that what
    disturbs the machine for a while disturbs all settings alike.

    Parameters
    ----------
    jobs : sequence of Job
        The runs.
    executor : concurrent.futures.Executor or None
        Who does them.
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
    if executor is not None and not isinstance(executor, Executor):
        raise ArgumentTypeError(
            f"{name} executor",
            expected="an executor of concurrent.futures",
            got=repr(executor),
            fix="Use ph.studies.processes(), or client.get_executor() of Dask.",
        )
    disable = None if progress is None else not progress
    with tqdm(total=sum(job.repeats for job in jobs), desc=name, unit="run", delay=1.0, disable=disable) as bar:
        if executor is not None:
            return _send(jobs, executor, name, bar.update)
        done: list[Measurement | None] = [None] * len(jobs)
        systems: dict[int, System] = {}
        waiting, clock = [i for i, job in enumerate(jobs) if not job.timed], perf_counter()
        while waiting and (
            len(waiting) == 1 or perf_counter() - clock < PATIENCE or not _can_be_sent([jobs[i] for i in waiting])
        ):
            i = waiting.pop(0)
            done[i] = _alternate([jobs[i]], systems, bar.update)[0]
        if waiting:
            with processes(min(len(waiting), os.cpu_count() or 1)) as pool:
                found = _send([jobs[i] for i in waiting], pool, name, bar.update)
            for i, measured in zip(waiting, found, strict=True):
                done[i] = measured
        timed = iter(_alternate([job for job in jobs if job.timed], systems, bar.update))
        return [next(timed) if measured is None else measured for measured in done]


def _alternate(jobs: Sequence[Job], systems: dict[int, System], count: Callable[[int], object]) -> list[Measurement]:
    """Do them here, one run after the other."""
    runners = [Runner(job, systems) for job in jobs]
    for k in range(max((job.repeats for job in jobs), default=0)):
        for runner in (r for r in runners if k < r.job.repeats):
            runner.repeat()
            count(1)
    return [runner.measured for runner in runners]


def _send(jobs: Sequence[Job], executor: Executor, name: str, count: Callable[[int], object]) -> list[Measurement]:
    """Have them done elsewhere, each with all its repeats."""
    futures: dict[Future[Measurement], Job] = {}
    try:
        futures = {executor.submit(measure, job): job for job in jobs}
        for future in as_completed(futures):
            future.result()
            count(futures[future].repeats)
        return [replace(future.result(), shared=True) for future in futures]
    except Exception as error:  # runs never raise, so this is the way to the worker and back
        for future in futures:
            future.cancel()
        raise _explained(name, jobs[0], error) from error


def _can_be_sent(jobs: Sequence[Job]) -> bool:
    """Whether worker processes will find the functions, and not start this study again when they read the script."""
    try:
        data = pickle.dumps(jobs)
    except Exception:  # pickle raises AttributeError, TypeError or its own
        return False
    main = sys.modules["__main__"]
    if not hasattr(main, "__file__"):  # a prompt or a notebook: workers have nothing of what was defined there
        return b"__main__" not in data
    frame: FrameType | None = sys._getframe()
    while frame and not (frame.f_globals is vars(main) and frame.f_code.co_name == "<module>"):
        frame = frame.f_back
    if frame is None:
        return False
    script, line = ast.parse("".join(linecache.getlines(frame.f_code.co_filename))), frame.f_lineno
    return any(
        isinstance(node, ast.If)
        and "__name__" in ast.unparse(node.test)
        and node.lineno <= line <= (node.end_lineno or node.lineno)
        for node in script.body
    )


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
