"""Co-simulation: a diagram as an FMU of FMI 3.0, which other tools step together with their own models.

The FMU carries the diagram as JSON. It needs Python with phblocks, and steps as :func:`phblocks.simulate` does.
"""

from phblocks.fmu.builder import write

__all__ = ["write"]
