"""Where a run was measured, and how it is kept on one thread."""

from __future__ import annotations

import os
import platform
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
import scipy


@dataclass(frozen=True, kw_only=True)
class Machine:
    """The machine and the versions a row was measured with.

    Parameters
    ----------
    platform : str
        Operating system and architecture.
    cpu : str
        Name of the processor.
    cores : int
        Processors of the machine.
    python, numpy, scipy, numba, phblocks : str
        Versions; "none" of numba where it is not installed, and steps are not compiled.
    """

    platform: str
    cpu: str
    cores: int
    python: str
    numpy: str
    scipy: str
    numba: str
    phblocks: str

    def __str__(self) -> str:
        """Describe it in one line."""
        return (
            f"{self.cpu}, {self.cores} cores, {self.platform}; Python {self.python}, "
            f"NumPy {self.numpy}, SciPy {self.scipy}, "
            + (f"numba {self.numba}, " if self.numba != "none" else "no numba, ")
            + f"phblocks {self.phblocks}"
        )


@cache
def this_machine() -> Machine:
    """Describe the machine this process runs on.

    Returns
    -------
    Machine
        Asked for once a process.
    """
    return Machine(
        platform=f"{platform.system()} {platform.release()} {platform.machine()}",
        cpu=_cpu(),
        cores=os.cpu_count() or 1,
        python=platform.python_version(),
        numpy=np.__version__,
        scipy=scipy.__version__,
        numba=_version("numba", "none"),
        phblocks=_version("phblocks", "not installed"),
    )


def _version(package: str, otherwise: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return otherwise


def _cpu() -> str:
    info = Path("/proc/cpuinfo")  # where there is one it says more than Python does
    names = re.findall(r"model name\s*:\s*(.+)", info.read_text(encoding="utf-8")) if info.exists() else []
    return str(names[0]) if names else platform.processor() or platform.machine()


class _Limit:
    """Counts who wants one thread; limits are of the process, so the last one out lifts them."""

    lock = Lock()
    wanted = 0
    limits: Any = None


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep the linear algebra of this process on one thread.

    Yields
    ------
    None
        Several threads of a process may be inside at a time.
    """
    from threadpoolctl import threadpool_limits

    with _Limit.lock:
        if not _Limit.wanted:
            _Limit.limits = threadpool_limits(limits=1, user_api="blas")
        _Limit.wanted += 1
    try:
        yield
    finally:
        with _Limit.lock:
            _Limit.wanted -= 1
            if not _Limit.wanted:
                _Limit.limits.restore_original_limits()
