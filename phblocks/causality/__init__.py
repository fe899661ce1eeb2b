"""Who gives and who takes at every junction: assigned, explained, and mended where it cannot be.

Exactly one port of a junction gives the common quantity (velocity), the others take it and give the summed one
(force). Blocks say what their ports are able to do and which choices depend on each other. The stages, each in a
file of its own: the :mod:`problem <phblocks.causality.problem>` in numbers, forced choices
(:mod:`propagation <phblocks.causality.propagation>`), the cheapest choice for what is left
(:mod:`program <phblocks.causality.program>`), and for what is impossible the smallest set that cannot hold together
(:mod:`conflicts <phblocks.causality.conflicts>`) and what to change (:mod:`repairs <phblocks.causality.repairs>`).
"""

from phblocks.causality.assignment import assign_causality
from phblocks.causality.conflicts import Conflict
from phblocks.causality.repairs import Cost, Repair
from phblocks.causality.report import Assignment, CausalityReport

__all__ = ["Assignment", "CausalityReport", "Conflict", "Cost", "Repair", "assign_causality"]
