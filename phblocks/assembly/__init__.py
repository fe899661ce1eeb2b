"""From a network and its causality to one system: layout, interconnection, verification of the structure."""

from phblocks.assembly.interconnection import Effects, Outputs, assemble
from phblocks.assembly.remaking import revalued

__all__ = ["Effects", "Outputs", "assemble", "revalued"]
