"""What nothing determines: motions and forces of states without energy that no storage, loss or source takes part in.

They are the vectors n with ``n^T (J - R) = 0`` that are zero on all states with energy. As J is skew and R positive
semidefinite, ``n^T R n = 0``, so ``R n = 0`` and ``J n = 0`` too: what n describes can be added to any solution, and no
part in it dissipates. A ring with a loss in it (D + D^T > 0) therefore never has one; a ring of gears or gyrators
whose ratios multiply to one has, and so has a circuit without reference.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from phblocks.causality import CausalityReport
from phblocks.errors import UndeterminedError
from phblocks.triplets import Floats

if TYPE_CHECKING:
    from phblocks.system.constraints import Constraints
    from phblocks.system.system import System

#: Parts of a vector smaller than this, relative to the largest, are round-off.
SMALL = 1e-9
#: Ports that are told of one vector.
PORTS = 12


def require_determined(system: System, constraints: Constraints) -> None:
    """Check that every state without energy follows from something, up to multipliers of constraints.

    Parameters
    ----------
    system : System
        The system.
    constraints : Constraints
        Of it: those with a row of zeros hold nothing.

    Raises
    ------
    UndeterminedError
        Naming the blocks, with file and line of the calls that added them, and for every vector what it is at each
        port.
    """
    empty = np.flatnonzero(abs(constraints.rows).sum(axis=1) == 0.0)
    if not empty.size:
        return
    from scipy.linalg import qr

    vectors = constraints.left[empty].toarray() / constraints.scale
    # the same space with vectors that share as little as can be: each has a state of its own
    pivots = np.sort(qr(vectors, mode="r", pivoting=True)[1][: empty.size])
    vectors = np.linalg.solve(vectors[:, pivots], vectors)
    vectors = np.where(np.abs(vectors) > SMALL * np.abs(vectors).max(), vectors, 0.0) * constraints.scale
    told = [_at_ports(system, vector) for vector in vectors]
    of_blocks = (system.sharing.expansion @ vectors.T).T
    blocks = [part.name for part in system.parts if of_blocks[:, part.states].any()]
    calls = [name + made_by(system, name) for name in blocks]
    raise UndeterminedError(
        f"{', '.join(calls)} of system {system.name!r}",
        expected="a storage, a loss or a source that determines what happens at every port",
        got="; and ".join(f"{told_of} can be added to any solution" for told_of in told),
        fix=(
            "Take one of these parts out, put a loss between two of them, or join one to something that stores energy: "
            "a circuit needs a Reference, a joint something that moves."
        ),
    )


def made_by(system: System, block: str) -> str:
    """Return the call that added a block, in parentheses.

    Parameters
    ----------
    system : System
        The system.
    block : str
        Name of the block.

    Returns
    -------
    str
        Such as ``" (add at four_bar.py:12)"``; empty if it is not known.
    """
    report = system.report
    call = report.network.added.get(block) if isinstance(report, CausalityReport) else None
    return f" ({call})" if call else ""


def _at_ports(system: System, vector: Floats) -> str:
    """What a vector of states is at the ports that give it, scaled to a largest value of one."""
    values: dict[str, Floats] = {}
    coordinates = system.sharing.expansion @ vector
    for part in system.parts:
        n = coordinates[part.states]
        for name, port in part.form.ports.items() if n.any() else ():
            given = sum(
                piece.output.csr((piece.output.indices[0].max() + 1, part.form.size)) @ n for piece in port.pieces
            )
            domain = part.block.ports[name].domain
            quantity = (domain.common if port.gives else domain.summed).name
            if np.any(given):
                values[f"{quantity} of {part.name}.{name}"] = np.atleast_1d(given)
    if not values:  # states inside a block
        names = [system.state_names[i] for i in np.flatnonzero(vector)]
        return ", ".join(names[:PORTS])
    largest = max(np.abs(v).max() for v in values.values())
    words = []
    for what, value in list(values.items())[:PORTS]:
        parts = [f"{v / largest:+.3g}" for v in value]
        words.append(f"{what} " + (parts[0] if len(parts) == 1 else f"({', '.join(parts)})"))
    return ", ".join(words) + (", ..." if len(values) > PORTS else "")
