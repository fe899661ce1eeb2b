"""Compile and run one large diagram in a process of its own: prints states, CPU seconds and peak memory as JSON."""

import json
import re
import resource
import sys
from pathlib import Path
from time import process_time

import phblocks as ph


def beam(elements: int) -> ph.Diagram:
    """One pendulum of this many elements."""
    section = ph.Section.rectangle(0.05, 0.05, young=2.1e11, poisson=0.3, density=2710.0)
    d = ph.Diagram("beam", gravity=(0.0, -9.81))
    rod = d.add(ph.Beam("beam", section, (0.0, 0.0), (100.0, 0.0), elements=elements))
    d.pin(rod.start, d.ground)
    return d


def chain(blocks: int) -> ph.Diagram:
    """Masses and springs in a row, hung up at one end: this many blocks together."""
    d = ph.Diagram("chain", gravity=(0.0, -9.81))
    meeting = [d.ground]
    for i in range(blocks // 2):
        spring = d.add(ph.Spring(f"spring {i}", 1e4, (float(i), 0.0), (i + 1.0, 0.0)))
        mass = d.add(ph.Mass(f"mass {i}", 1.0, (i + 1.0, 0.0)))
        d.pin(*meeting, spring.start)
        meeting = [spring.end, mass.centre]
    d.pin(*meeting)
    return d


def peak() -> float:
    """The most memory this process had so far, MB; in Linux, ``getrusage`` counts its parent's too."""
    status = Path("/proc/self/status")
    if status.exists():
        return float(re.findall(r"VmHWM:\s*(\d+) kB", status.read_text())[0]) / 1e3
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size / (1e6 if sys.platform == "darwin" else 1e3)


def main() -> None:
    """Measure what is named on the command line."""
    make, size = {"beam": beam, "chain": chain}[sys.argv[1]], int(sys.argv[2])
    ph.simulate(make(4).compile(), 0.002, 0.001, progress=False)  # loads all that is loaded once
    bare, clock = peak(), process_time()
    system = make(size).compile()
    compiled = process_time() - clock
    run = ph.simulate(system, 0.002, 0.001, progress=False)
    energy = run.energy
    error = abs(energy.total - energy.total[0]).max() / max(energy.kinetic.max(), energy.strain.max())
    print(
        json.dumps(
            {
                "ok": run.status.ok,
                "states": system.n,
                "compile": compiled,
                "seconds": process_time() - clock,
                "bare": bare,
                "peak": peak(),
                "energy": float(error),
                "halvings": run.statistics.halvings,
            }
        )
    )


if __name__ == "__main__":
    main()
