"""Pictures of diagrams, systems and solutions; each function draws into axes and returns them.

Matplotlib is loaded by the first plot, not by importing this package.
"""

from phblocks.plots.diagram import diagram
from phblocks.plots.energy import energy
from phblocks.plots.motion import motion
from phblocks.plots.sparsity import sparsity
from phblocks.plots.studies import convergence, effects, work_precision

__all__ = ["convergence", "diagram", "effects", "energy", "motion", "sparsity", "work_precision"]
