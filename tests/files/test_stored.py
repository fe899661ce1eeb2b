"""What a file holds, without the system and with it; and that a run needs no more memory the longer it is."""

import os
import subprocess
import sys
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import UnknownNameError

RUN = {"t_end": 0.25, "dt": 0.002, "inputs": {"tip": lambda t: (0.5 * np.sin(3.0 * t), 0.2 * t)}}


@pytest.fixture(scope="module")
def run(systems, tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.h5"
    return ph.simulate(systems["arm"], save=ph.Stream(path, chunk=20), **RUN), path


def test_without_the_system(run, systems, same):
    solution, path = run
    read = ph.read(path)
    same(solution, read)
    assert read.status == solution.status and read.status.ok
    assert read.labels.state_names == systems["arm"].state_names and read.labels.input_names == ("tip.x", "tip.y")
    np.testing.assert_array_equal(read.state("beam.V1[0]"), solution.state("beam.V1[0]"))
    with pytest.raises(UnknownNameError):
        read.state("nothing")
    for name, energy in solution.energy.items():
        np.testing.assert_array_equal(read.energy[name], energy)
    assert str(read.power) == str(solution.power) and read.power.worst == solution.power.worst
    assert str(read.statistics).split(",")[:3] == str(solution.statistics).split(",")[:3]
    assert repr(read) == "<SavedRun of 'arm': 126 times to 0.25 s, success>"
    assert read.settings["dt"] == 0.002 and read.settings["method"]["class"] == "Midpoint"


def test_drawn_without_the_system(run):
    solution, path = run
    one, two = (ph.plots.energy(s) for s in (solution, ph.read(path)))
    assert [line.get_label() for line in one.lines] == [line.get_label() for line in two.lines]
    plt.close("all")


def test_with_the_system(run, systems):
    solution, path = run
    read = ph.read(path, systems["arm"])
    assert isinstance(read, ph.Solution)
    np.testing.assert_array_equal(read.position("beam", 1.0), solution.position("beam", 1.0))
    np.testing.assert_array_equal(read.force("beam", 0.0), solution.force("beam", 0.0))
    some = read.sliced(np.array([3, 5]))
    np.testing.assert_array_equal(some.position("beam", 1.0), solution.position("beam", 1.0)[[3, 5]])
    again = ph.simulate(systems["arm"], 0.01, 0.002, start=read.at(0.1))
    assert again.status.ok


def test_other_programs_read_it(run):
    solution, path = run
    with h5py.File(path) as file:
        np.testing.assert_array_equal(file["rows/x"][:], solution.x)
        names = file["labels/state_names"].asstr()[:]
        assert names[0] == solution.system.state_names[0] and file["rows/x"].shape == (solution.t.size, names.size)


def test_while_it_goes_on(systems, tmp_path):
    """Read from the signal of the very run."""
    path, seen = tmp_path / "run.h5", []

    def tip(t):
        if t > 0.1 and len(seen) < 2:
            run = ph.read(path)
            seen.append((run.status, run.t))
        return 0.0, 0.0

    solution = ph.simulate(systems["beam"], save=ph.Stream(path, chunk=20), **RUN | {"inputs": {"tip": tip}})
    status, t = seen[0]
    assert status.name == "interrupted" and status.time == pytest.approx(0.08) == t[-1]
    np.testing.assert_array_equal(ph.read(path).x, solution.x)


LONG = """
import sys
import phblocks as ph

section = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)
d = ph.Diagram("long", gravity=(0.0, -9.81))
b = d.add(ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.0), elements=100))
d.weld(b.start, d.ground)
system = d.compile().small_motions()


def peak(steps, save):
    path = ph.Stream(f"{sys.argv[1]}/{steps}.h5", chunk=100) if save else None
    assert ph.simulate(system, steps * 1e-3, 1e-3, save=path).statistics.steps == steps
    (line,) = [line for line in open("/proc/self/status") if line.startswith("VmHWM")]
    return int(line.split()[1]) / 1024


print(peak(2000, True), peak(5000, True), peak(5000, False))
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="asks Linux for the peak of memory")
def test_memory_does_not_grow_with_the_run(tmp_path):
    """Peak memory of the process, MB: more than twice the steps on disk, and then in memory (some 16 kB a step)."""
    env = os.environ | {"PYTHONPATH": str(Path(ph.__file__).parents[1]), "OMP_NUM_THREADS": "1"}
    ran = subprocess.run([sys.executable, "-c", LONG, str(tmp_path)], capture_output=True, text=True, env=env)
    assert ran.returncode == 0, ran.stderr
    short, long, plain = map(float, ran.stdout.split())
    assert plain - short > 50.0
    # measured: 124 MB, then 132 and flat from 2000 to 8000 steps (steppers that wait for the garbage collector)
    assert long - short < 8.0
