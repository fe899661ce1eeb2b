"""A process that simulates and is killed: resumes the run in argv[1] if it is there, else begins it."""

import sys
from pathlib import Path

import numpy as np

import phblocks as ph
from phblocks.files.stored import chunk_of


def pendulum() -> ph.System:
    """A beam on a pin with multipliers, under gravity and a force."""
    section = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)
    d = ph.Diagram("pendulum", gravity=(0.0, -9.81))
    hub = d.add(ph.RigidBody("hub", 1.0, 0.1, (0.0, 0.0), {"rim": (0.2, 0.0)}))
    beam = d.add(ph.Beam("beam", section, (0.2, 0.0), (1.2, 0.0), elements=2))
    d.pin(hub.centre, d.ground, multiplier=True)
    d.weld(hub["rim"], beam.start)
    d.expose(beam.end.translation, "tip")
    return d.compile()


def tip(t: float) -> tuple[float, float]:
    return 0.5 * float(np.sin(3.0 * t)), 0.2 * t


if __name__ == "__main__":
    path, steps = Path(sys.argv[1]), int(sys.argv[2])
    system = pendulum()
    print("ready", flush=True)
    if path.exists() or chunk_of(path, 0).exists():
        solution = ph.resume(path, system, inputs={"tip": tip})
    else:
        save = ph.Stream(path, chunk=20)
        solution = ph.simulate(system, steps * 0.001, 0.001, inputs={"tip": tip}, save=save)
    print("done" if solution.status.ok else solution.status, flush=True)
