"""Where a row was measured, and on one thread."""

from importlib.util import find_spec

import numpy as np
from threadpoolctl import threadpool_info

from phblocks.studies import machine


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
    assert (find_spec("numba") is None) is (here.numba == "none") is ("no numba" in str(here))
