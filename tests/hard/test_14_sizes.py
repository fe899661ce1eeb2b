"""Case 14: a hundred thousand elements in one beam, ten thousand blocks in one diagram: memory and time stay linear."""

import json
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tests.hard.scene import Check, Outcome, Scene, assert_holds, params

ROOT = Path(__file__).parents[2]
CASE = "Size: 1e5 elements, 1e4 blocks"


def measure(kind: str, size: int) -> dict[str, Any]:
    """Draw, compile and two steps, in a process of its own."""
    command = [sys.executable, "-m", "tests.hard.sizes", kind, str(size)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=600, cwd=ROOT)
    return json.loads(done.stdout)


def grow(kind: str, small: int, large: int, most: float, power_of_time: float = 1.25) -> Outcome:
    """Memory above that of the bare process and CPU time grow with the size to the power of one.

    Times of a second are noisy, so the small sizes only tell linear from quadratic.
    """
    a, b = measure(kind, small), measure(kind, large)

    def power(first: float, second: float) -> float:
        return float(np.log(second / first) / np.log(large / small))

    return Outcome(
        [
            Check("runs that ended early", float(not (a["ok"] and b["ok"])), 0),
            Check(f"peak memory with {b['states']} states, MB", b["peak"], most),
            Check("memory grows with size to the power", power(a["peak"] - a["bare"], b["peak"] - b["bare"]), 1.1),
            Check("CPU time of compile, s", b["compile"], 120.0),
            Check("CPU time grows with size to the power", power(a["seconds"], b["seconds"]), power_of_time),
            Check("energy, over what moves", b["energy"], 1e-4),
        ]
    )


SCENES = [
    Scene("one beam", "1e3 to 5e3 elements, 2 steps", partial(grow, "beam", 1000, 5000, 400.0, 1.5)),
    Scene("masses and springs", "1e3 to 3e3 blocks, 2 steps", partial(grow, "chain", 1000, 3000, 300.0, 1.5)),
    Scene("one beam", "1e4 to 1e5 elements, 2 steps", partial(grow, "beam", 10**4, 10**5, 4000.0), tier="slow"),
    Scene("masses and springs", "1e3 to 1e4 blocks, 2 steps", partial(grow, "chain", 10**3, 10**4, 500.0), tier="slow"),
]


@params(SCENES)
def test_sizes(scene: Scene) -> None:
    assert_holds(scene)
