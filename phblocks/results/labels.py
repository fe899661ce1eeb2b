"""The names in a result: enough to read most of it without the system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phblocks.system import System
from phblocks.triplets import Ints


@dataclass(frozen=True)
class Labels:
    """Names of what is in a recording.

    Parameters
    ----------
    name : str
        Of the system.
    state_names, state_units : tuple of str
        Of each state.
    theta_names : tuple of str
        Of each rotation state.
    energy_kinds : tuple of str
        Kinds of energy that are stored.
    blocks : tuple of str
        The blocks.
    connections : tuple of (str, str)
        Giving and taking port of each connection.
    connected : numpy.ndarray
        Numbers of the giving and of the taking block, shape (connections, 2).
    input_names, output_names : tuple of str
        Of each input, and of the output conjugate to it.
    groups : tuple of tuple of int
        Numbers of the blocks that share states.
    """

    name: str
    state_names: tuple[str, ...]
    state_units: tuple[str, ...]
    theta_names: tuple[str, ...]
    energy_kinds: tuple[str, ...]
    blocks: tuple[str, ...]
    connections: tuple[tuple[str, str], ...]
    connected: Ints
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    groups: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, system: System) -> Labels:
        """Collect those of a system.

        Parameters
        ----------
        system : System
            The system.

        Returns
        -------
        Labels
            Its names.
        """
        return cls(
            system.name,
            system.state_names,
            system.state_units,
            system.theta_names,
            system.energy_kinds,
            tuple(part.name for part in system.parts),
            tuple(system.connections.names),
            np.asarray(system.connections.blocks, dtype=np.int64).reshape(-1, 2),
            system.input_names,
            system.output_names,
            tuple(tuple(int(i) for i in group) for group in system.sharing.groups),
        )
