"""What a system leaves out because it stays zero, and the check that nobody moves it after all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from phblocks.errors import PrunedError
from phblocks.system.parts import STILL, Part
from phblocks.triplets import Floats, Ints

if TYPE_CHECKING:
    from phblocks.system.system import System

#: What is smaller than this, relative to the largest value of its unit, is round-off of a start.
ROUND_OFF = 1e-14
#: What has a smaller amplitude than this, relative to the largest one, is round-off of the run that led to a start;
#: amplitudes are roots of twice the energy.
ROUND_OFF_OF_RUNS = 1e-12

FIX = 'Compile with effects="all", or let the diagram know: give the block the start, or the source the signal.'


@dataclass(frozen=True)
class Pruning:
    """Which states and rotation states of the diagram the system leaves out, and what that rests on.

    Parameters
    ----------
    coordinates : numpy.ndarray
        Coordinates of the blocks that would be states if nothing was left out.
    states : numpy.ndarray
        For each of them the state that it is, or -1.
    rotations : numpy.ndarray
        For each rotation state that there would be the one that it is, or :data:`~phblocks.system.STILL` or
        ``DROPPED``.
    quiet : numpy.ndarray
        Inputs that are zero by the signals of their sources, and must stay so.
    held : numpy.ndarray
        States of the configuration that must start where the diagram has them.
    """

    coordinates: Ints
    states: Ints
    rotations: Ints
    quiet: Ints
    held: Ints

    def constants(self, system: System) -> dict[str, float]:
        """Name the states that are left out.

        Parameters
        ----------
        system : System
            The system.

        Returns
        -------
        dict of str to float
            What each of them stays.
        """
        gone = self.coordinates[self.states < 0]
        if not gone.size:
            return {}
        names = coordinate_names(system.parts)
        return {names[i]: float(system.sharing.constant[i]) for i in gone}

    def restricted(self, system: System, x: Floats, where: str) -> Floats:
        """Take the states out of those there would be if nothing was left out.

        Parameters
        ----------
        system : System
            The system.
        x : numpy.ndarray
            Shape (coordinates.size,).
        where : str
            What it is, for the message.

        Returns
        -------
        numpy.ndarray
            Shape (n,).

        Raises
        ------
        PrunedError
            If what is left out differs from what it stays.
        """
        gone = self.states < 0
        places, values = self.coordinates[gone], x[gone]
        runs = [(part, run) for part in system.parts for run in part.form.runs]
        number = np.repeat(np.arange(len(runs)), [run.positions.size for _, run in runs])
        units = np.unique([run.unit for _, run in runs], return_inverse=True)[1][number]
        largest = np.zeros(int(units.max(initial=-1)) + 1)
        np.maximum.at(largest, units[self.coordinates], np.abs(x))
        size = np.sqrt(np.concatenate([part.form.E.csr((part.form.size,) * 2).diagonal() for part in system.parts]))
        enough = ROUND_OFF_OF_RUNS * (size[self.coordinates] * np.abs(x)).max(initial=0.0)
        missed = np.abs(values - system.sharing.constant[places])
        counts = (size[places] == 0.0) | (size[places] * missed > enough)  # nothing beside the energy of the others
        off = np.flatnonzero((missed > ROUND_OFF * largest[units[places]]) & counts)
        if off.size:
            part, run = runs[number[places[off[0]]]]
            raise PrunedError(
                f"{where}: {run.field} of {part.name!r}",
                expected="zero: nothing in the diagram excites it, so it is not computed"
                if run.energy != "configuration"
                else "what the diagram starts from: nothing in it moves it, so it is not computed",
                got=f"{values[off[0]]:.6g} {run.unit}",
                fix=FIX,
            )
        result = np.empty(system.n)
        result[self.states[~gone]] = x[~gone]
        return result

    def turned(self, theta: Floats, where: str) -> Floats:
        """Take the rotation states out of those there would be if nothing was left out.

        Parameters
        ----------
        theta : numpy.ndarray
            Shape (rotations.size,), rad.
        where : str
            What it is, for the message.

        Returns
        -------
        numpy.ndarray
            Shape (n_theta,), rad.

        Raises
        ------
        PrunedError
            If one that is left out is not zero.
        """
        gone = self.rotations < 0
        if (np.abs(theta[self.rotations == STILL]) > ROUND_OFF_OF_RUNS).any():
            raise PrunedError(
                f"{where}.theta",
                expected="zero for what nothing in the diagram turns",
                got=f"{np.abs(theta[self.rotations == STILL]).max():.6g} rad",
                fix=FIX,
            )
        result = np.empty(int(self.rotations.max(initial=-1)) + 1)
        result[self.rotations[~gone]] = theta[~gone]
        return result

    def require_none(self, system: System, where: str) -> None:
        """Check that no state is left out.

        Parameters
        ----------
        system : System
            The system.
        where : str
            What needs them all, for the message.

        Raises
        ------
        PrunedError
            Naming the blocks and fields that are left out.
        """
        gone = self.coordinates[self.states < 0]
        if not gone.size:
            return
        runs = [(part, run) for part in system.parts for run in part.form.runs]
        number = np.repeat(np.arange(len(runs)), [run.positions.size for _, run in runs])
        names = [f"{runs[i][1].field} of {runs[i][0].name!r}" for i in np.unique(number[gone])]
        raise PrunedError(
            where,
            expected="all states, also those that nothing excites",
            got=f"a system without {', '.join(names[:6])}" + (", ..." if len(names) > 6 else ""),
            fix='Compile with effects="all".',
        )

    def require_held(self, system: System, x: Floats, where: str) -> None:
        """Check that the configuration is where its directions were taken to be constant.

        Parameters
        ----------
        system : System
            The system.
        x : numpy.ndarray
            States, shape (n,).
        where : str
            What they are, for the message.

        Raises
        ------
        PrunedError
            If a span that nothing moves differs from that of the diagram.
        """
        at, start = x[self.held], system.start.x[self.held]
        off = np.flatnonzero(np.abs(at - start) > ROUND_OFF * np.abs(x[system.configuration]).max(initial=0.0))
        if off.size:
            raise PrunedError(
                f"{where}: {system.state_names[self.held[off[0]]]}",
                expected=f"{start[off[0]]:.6g}, where the diagram has it and nothing moves it",
                got=f"{at[off[0]]:.6g}",
                fix=FIX,
            )

    def require_quiet(self, system: System, u: Floats, where: str) -> None:
        """Check that inputs that were taken to be zero are zero.

        Parameters
        ----------
        system : System
            The system.
        u : numpy.ndarray
            Inputs, shape (n_inputs,).
        where : str
            What they are, for the message.

        Raises
        ------
        PrunedError
            Naming the first one that is not.
        """
        loud = np.flatnonzero(u[self.quiet])
        if loud.size:  # but for round-off beside the other components of the port
            ports = [entry.exposure for entry in system.inputs]
            here = [np.abs(u[[port == ports[i] for port in ports]]).max() for i in self.quiet[loud]]
            loud = loud[np.abs(u[self.quiet[loud]]) > ROUND_OFF * np.array(here)]
        if loud.size:
            name = system.input_names[self.quiet[loud[0]]]
            raise PrunedError(
                f"{where}[{name!r}]",
                expected="zero, as its source says: what it alone would move is not computed",
                got="another value",
                fix=FIX,
            )


def coordinate_names(parts: Sequence[Part]) -> list[str]:
    """Name the coordinates of all blocks: block, field, component and number along the block.

    Parameters
    ----------
    parts : sequence of Part
        The blocks.

    Returns
    -------
    list of str
        Such as ``crank.V1[0]``.
    """
    return [
        f"{part.name}.{run.field}[{i}]" for part in parts for run in part.form.runs for i in range(run.positions.size)
    ]
