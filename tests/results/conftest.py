"""Runs that several tests read."""

from collections.abc import Callable

import numpy as np
import pytest

import phblocks as ph
from phblocks import loop
from phblocks.results import recording

SIGNALS = {
    "four-bar": {},
    "frame": {"load": lambda t: (3.0 * np.sin(9.0 * t), -2.0)},
    "arm": {"drive": lambda t: 2.0 * np.sin(3.0 * t), "force": (0.3, 0.3), "moment": lambda t: 0.2 * t},
    "shaken": {"table": lambda t: (0.4 * np.sin(8.0 * t), 0.1 * np.cos(5.0 * t)), "hold": 0.0},
    "free": {"joint": lambda t: (1.0, 2.0 * t), "push": (0.0, 0.5)},
}


@pytest.fixture(scope="session")
def run(scenes):
    """A function that simulates a scene by name, with inputs that vary, from rest."""

    def simulate(name: str, t_end: float = 0.4, dt: float = 0.01, **options) -> "ph.Solution":
        system = options.pop("system", None) or scenes[name].compile()
        return ph.simulate(system, t_end=t_end, dt=dt, inputs=SIGNALS[name], **options)

    return simulate


@pytest.fixture(params=list(SIGNALS))
def name(request) -> str:
    """One scene after the other."""
    return request.param


@pytest.fixture(scope="session")
def solutions(run):
    """One run of each scene."""
    return {name: run(name) for name in SIGNALS}


@pytest.fixture
def solution(solutions, name):
    return solutions[name]


@pytest.fixture
def cut_chunks(monkeypatch) -> Callable[[int], list[int]]:
    """Take and evaluate so many steps together; returns a list of how many there were each time."""

    def cut(chunk: int) -> list[int]:
        counts: list[int] = []
        flush = recording.Recorder._flush
        monkeypatch.setattr(recording, "CHUNK", chunk)
        monkeypatch.setattr(recording, "together", lambda n: 1)
        monkeypatch.setattr(loop, "together", lambda n, whole: chunk)
        monkeypatch.setattr(recording.Recorder, "_flush", lambda self: counts.append(self._count) or flush(self))
        return counts

    return cut
