"""The assembled system: its matrices, the configuration that modulates them, linear models of it."""

from phblocks.system.angles import Angles
from phblocks.system.constraints import consistent_start, find_constraints, require_independent
from phblocks.system.exchange import Exchange
from phblocks.system.linearization import Linearization
from phblocks.system.lines import Lines
from phblocks.system.parts import DROPPED, STILL, Connections, Guide, Input, Part, Site, State
from phblocks.system.pruning import Pruning
from phblocks.system.sharing import Sharing
from phblocks.system.system import System

__all__ = [
    "DROPPED",
    "STILL",
    "Angles",
    "Connections",
    "Exchange",
    "Guide",
    "Input",
    "Linearization",
    "Lines",
    "Part",
    "Pruning",
    "Sharing",
    "Site",
    "State",
    "System",
    "consistent_start",
    "find_constraints",
    "require_independent",
]
