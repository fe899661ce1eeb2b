"""Pictures of diagrams, systems and solutions; each function draws into axes and returns them.

Matplotlib is loaded by the first plot, not by importing this package.
"""

from phblocks.plots.comparison import comparison
from phblocks.plots.diagram import diagram
from phblocks.plots.energy import energy
from phblocks.plots.gap import gap
from phblocks.plots.motion import motion
from phblocks.plots.power_flow import power_flow
from phblocks.plots.sparsity import sparsity
from phblocks.plots.spectrum import spectrum
from phblocks.plots.studies import convergence, effects, work_precision

__all__ = [
    "comparison",
    "convergence",
    "diagram",
    "effects",
    "energy",
    "gap",
    "motion",
    "power_flow",
    "sparsity",
    "spectrum",
    "work_precision",
]
