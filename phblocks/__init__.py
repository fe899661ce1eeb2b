"""Flexible mechanisms and other port-Hamiltonian systems as block diagrams.

The names below are in the order of their use: make sections and blocks, join them in a diagram, check and
compile it to a system, simulate it, read the solution.
"""

from phblocks import errors, plots
from phblocks.blocks.beam.beam import Beam
from phblocks.blocks.beam.section import Section
from phblocks.blocks.body import Mass, RigidBody
from phblocks.blocks.spring import Damper, Spring
from phblocks.causality import CausalityReport
from phblocks.diagram import Diagram
from phblocks.errors import PhblocksError
from phblocks.ports import Anchor, Port
from phblocks.results.solution import Solution
from phblocks.simulation import simulate
from phblocks.solvers.midpoint import Midpoint
from phblocks.solvers.newton import Newton
from phblocks.system import State, System

__all__ = [
    "Anchor",
    "Beam",
    "CausalityReport",
    "Damper",
    "Diagram",
    "Mass",
    "Midpoint",
    "Newton",
    "PhblocksError",
    "Port",
    "RigidBody",
    "Section",
    "Solution",
    "Spring",
    "State",
    "System",
    "errors",
    "plots",
    "simulate",
]
__version__ = "0.1.0"
