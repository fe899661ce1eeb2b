"""Flexible mechanisms and other port-Hamiltonian systems as block diagrams.

The names below are in the order of their use: make sections and blocks, join them in a diagram, check and
compile it to a system, simulate it, read the solution.
"""

from phblocks.blocks.beam.section import Section
from phblocks.blocks.beam.beam import Beam
from phblocks.diagram import Diagram
