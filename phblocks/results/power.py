"""The power ledger: who gave energy to whom, and how well every step adds up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from phblocks.results.recording import Recording
from phblocks.system import System
from phblocks.triplets import Floats


@dataclass(frozen=True, repr=False)
class PowerLedger:
    """Energies exchanged since the start, at the saved times.

    Parameters
    ----------
    system : System
        The system.
    recording : Recording
        Of a run of it.
    """

    system: System
    recording: Recording

    @property
    def connections(self) -> Mapping[tuple[str, str], Floats]:
        """Energy through each connection, keyed by (giving port, taking port).

        Positive from the block of the giving port into that of the taking port; shape (times,), J.
        """
        transferred = self.recording.ledger.transferred
        return {names: transferred[:, i] for i, names in enumerate(self.system.connections.names)}

    @property
    def inputs(self) -> Mapping[str, Floats]:
        """Energy supplied through each input, shape (times,), J."""
        supplied = self.recording.ledger.supplied
        return {name: supplied[:, i] for i, name in enumerate(self.system.input_names)}

    @property
    def blocks(self) -> Mapping[str, Mapping[str, Floats]]:
        """For each block stored, gravity, received (from blocks), supplied (from outside), dissipated.

        Each of shape (times,), J, as changes since the start; for every block
        ``stored + gravity = received + supplied - dissipated``.
        """
        ledger = self.recording.ledger
        stored = ledger.stored.sum(axis=2)
        result = {}
        for b, part in enumerate(self.system.parts):
            giving, taking = self.system.connections.blocks.T
            received = ledger.transferred[:, taking == b].sum(axis=1) - ledger.transferred[:, giving == b].sum(axis=1)
            received += ledger.shared[:, b]
            result[part.name] = {
                "stored": stored[:, b] - stored[0, b],
                "gravity": ledger.potential[:, b],
                "received": received,
                "supplied": ledger.supplied_to[:, b],
                "dissipated": ledger.dissipated[:, b],
            }
        return result

    @property
    def block_errors(self) -> Mapping[str, float]:
        """Largest residual of the balance of each block in any step, J."""
        errors = self.recording.ledger.block_error
        return {part.name: float(errors[i]) for i, part in enumerate(self.system.parts)}

    @property
    def connection_errors(self) -> Mapping[tuple[str, str], float]:
        """Largest sum of the energies on both sides of each connection in any step, J."""
        errors = self.recording.ledger.connection_error
        return {names: float(errors[i]) for i, names in enumerate(self.system.connections.names)}

    @property
    def worst(self) -> tuple[str, float]:
        """The block or connection with the largest residual in any step, and that residual, J."""
        named = {**self.block_errors, **{" -> ".join(k): v for k, v in self.connection_errors.items()}}
        name = max(named, key=lambda key: named[key], default="")
        return name, named.get(name, 0.0)

    def __repr__(self) -> str:
        """Return the table."""
        return str(self)

    def __str__(self) -> str:
        """Format the balance of each block at the end as a table."""
        columns = ("stored", "gravity", "received", "supplied", "dissipated", "worst step")
        lines = [f"{'block':<16}" + "".join(f"{c:>14}" for c in columns)]
        for name, row in self.blocks.items():
            cells = "".join(f"{float(np.asarray(series)[-1]):>14.6g}" for series in row.values())
            lines.append(f"{name:<16}{cells}{self.block_errors[name]:>14.2e}")
        return "\n".join(lines)
