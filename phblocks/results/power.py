"""The power ledger: who gave energy to whom, and how well every step adds up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from phblocks.results.labels import Labels
from phblocks.results.recording import Recording
from phblocks.triplets import Floats


@dataclass(frozen=True, repr=False)
class PowerLedger:
    """Energies exchanged since the start, at the saved times.

    What is tested, in every step: the balance of each block against what its ports, inputs and losses say; and across
    each connection what the matrices carry against force times velocity at the ports. Blocks that share states
    (``system.sharing``) have no ports between them: what passes from one to another is *defined* as what each of them
    misses otherwise, so that the balance of one says nothing, and only that of all that share is tested.

    Parameters
    ----------
    labels : Labels
        Names of blocks, connections and inputs.
    recording : Recording
        Of a run of it.
    """

    labels: Labels
    recording: Recording

    @property
    def connections(self) -> Mapping[tuple[str, str], Floats]:
        """Energy through each connection, keyed by (giving port, taking port).

        Positive from the block of the giving port into that of the taking port; shape (times,), J.
        """
        transferred = self.recording.ledger.transferred
        return {names: transferred[:, i] for i, names in enumerate(self.labels.connections)}

    @property
    def inputs(self) -> Mapping[str, Floats]:
        """Energy supplied through each input, shape (times,), J."""
        supplied = self.recording.ledger.supplied
        return {name: supplied[:, i] for i, name in enumerate(self.labels.input_names)}

    @property
    def blocks(self) -> Mapping[str, Mapping[str, Floats]]:
        """For each block stored, gravity, received (from blocks), supplied (from outside), and what it loses.

        That is dissipated, numerical_loss (to the time method) and projected (what closing loops added). Each of shape
        (times,), J, as changes since the start; for every block ``stored + gravity = received + supplied - dissipated
        - numerical_loss + projected``. For blocks that share states this defines the part of received that passes
        through them.
        """
        ledger = self.recording.ledger
        stored = ledger.stored.sum(axis=2)
        result = {}
        giving, taking = self.labels.connected.T
        for b, name in enumerate(self.labels.blocks):
            received = ledger.transferred[:, taking == b].sum(axis=1) - ledger.transferred[:, giving == b].sum(axis=1)
            received += ledger.shared[:, b]
            result[name] = {
                "stored": stored[:, b] - stored[0, b],
                "gravity": ledger.potential[:, b],
                "received": received,
                "supplied": ledger.supplied_to[:, b],
                "dissipated": ledger.dissipated[:, b],
                "numerical_loss": ledger.numerical[:, b],
                "projected": ledger.projected[:, b],
            }
        return result

    @property
    def columns(self) -> tuple[str, ...]:
        """The series of :attr:`blocks` to be shown: numerical_loss and projected only if there was any."""
        ledger = self.recording.ledger
        rare = {"numerical_loss": ledger.numerical, "projected": ledger.projected}
        shown = tuple(name for name, series in rare.items() if series.any())
        return ("stored", "gravity", "received", "supplied", "dissipated", *shown)

    @property
    def block_errors(self) -> Mapping[str, float]:
        """Largest residual of a balance in any step, J: of each block, or of all blocks that share states together.

        The latter are named ``"left + right"``.
        """
        errors = self.recording.ledger.block_error
        return {name: float(errors[members[0]]) for name, members in self._balances.items()}

    @property
    def connection_errors(self) -> Mapping[tuple[str, str], float]:
        """Largest difference in any step between what the matrices carry across each connection and its ports say, J.

        The ports: force times velocity, from the outputs of both blocks turned into the fixed frame.
        """
        errors = self.recording.ledger.connection_error
        return {names: float(errors[i]) for i, names in enumerate(self.labels.connections)}

    @property
    def worst(self) -> tuple[str, float]:
        """The block, blocks that share or connection with the largest residual in any step, and that residual, J."""
        named = {**self.block_errors, **{" -> ".join(k): v for k, v in self.connection_errors.items()}}
        name = max(named, key=lambda key: named[key], default="")
        return name, named.get(name, 0.0)

    def __repr__(self) -> str:
        """Return the table."""
        return str(self)

    def __str__(self) -> str:
        """Format the balance of each block at the end as a table; of blocks that share states also that of all."""
        columns, errors = self.columns, self.block_errors
        lines = [f"{'block':<16}" + "".join(f"{c.replace('_', ' '):>16}" for c in (*columns, "worst step"))]
        last = {name: [float(row[c][-1]) for c in columns] for name, row in self.blocks.items()}
        names = self.labels.blocks
        together = {
            name: np.sum([last[names[i]] for i in members], axis=0)
            for name, members in self._balances.items()
            if len(members) > 1
        }
        for name, row in (last | together).items():
            cells = "".join(f"{value:>16.6g}" for value in row)
            worst = f"{errors[name]:.2e}" if name in errors else "shares"
            lines.append(f"{name:<16}{cells}{worst:>16}")
        return "\n".join(lines)

    @property
    def _balances(self) -> Mapping[str, tuple[int, ...]]:
        """The balances that can be tested, and the numbers of the blocks in each."""
        groups = {members[0]: tuple(members) for members in self.labels.groups}
        shared = {i for members in groups.values() for i in members[1:]}
        sets = [groups.get(i, (i,)) for i in range(len(self.labels.blocks)) if i not in shared]
        return {" + ".join(self.labels.blocks[i] for i in members): members for members in sets}
