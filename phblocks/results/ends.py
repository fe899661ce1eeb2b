"""What an anchor gives and takes: exact values at the ends of blocks, from the junctions they are in.

A discontinuous field has no value at an end. But what a port takes there is what the other ports of its junction give:
the velocity of the giving one, or the negative sum of the forces of the taking ones.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from phblocks.blocks.form import AngleRows, Piece
from phblocks.causality import Assignment, CausalityReport
from phblocks.frames import rotate
from phblocks.ports import Anchor, Port
from phblocks.results.recording import Recording
from phblocks.system import DROPPED, STILL, Part, System
from phblocks.triplets import Floats


class Ends:
    """Values at the ports of a run.

    Parameters
    ----------
    system : System
        The system.
    recording : Recording
        Of a run of it.
    """

    def __init__(self, system: System, recording: Recording) -> None:
        self._system = system
        self._recording = recording
        assert isinstance(system.report, CausalityReport)
        self._assignments = {a.port: a for a in system.report.assignments}

    def port(self, part: Part, place: object, kind: str) -> Port | None:
        """Find the port of a block at a place.

        Parameters
        ----------
        part : Part
            The block.
        place : object
            Where on it.
        kind : {"translation", "rotation"}
            Which port.

        Returns
        -------
        Port or None
            ``None`` if there is no anchor.
        """
        for anchor in part.block.anchors.values():
            if anchor.place == place:
                for port in anchor.ports:
                    if port.domain.turns_with == kind:
                        return port
        return None

    def common(self, port: Port) -> Floats | None:
        """Return the common quantity (velocity) at a port, in the fixed frame; see :meth:`_piece` for space.

        Parameters
        ----------
        port : Port
            The port.

        Returns
        -------
        numpy.ndarray or None
            Shape (times, components); ``None`` if an input imposes it.
        """
        here = self._assignments[port]
        if here.gives:
            return self._given([here], self._components(port))
        givers = [a for a in self._others(here) if a.gives][:1]
        return self._given(givers, self._components(port)) if givers else None

    def summed(self, port: Port) -> Floats | None:
        """Return the summed quantity (force) on the block at a port, in the fixed frame; see :meth:`_piece` for space.

        Parameters
        ----------
        port : Port
            The port.

        Returns
        -------
        numpy.ndarray or None
            Shape (times, components); ``None`` if an input contributes to it, or it is among states that are shared.
        """
        here = self._assignments[port]
        if not here.gives:
            return self._given([here], self._components(port))
        if here.junction.exposures or any(a.gives for a in self._others(here)):
            return None
        total = self._given(self._others(here), self._components(port))
        return None if total is None else -total

    def _components(self, port: Port) -> int:
        return len(port.domain.components(self._system.space))

    def _others(self, here: Assignment) -> list[Assignment]:
        """The other ports of a junction; the ground's, which is in many, is known to give."""
        return [self._assignments[p] for p in here.junction.ports if p is not here.port]

    def _given(self, assignments: Sequence[Assignment], components: int) -> Floats | None:
        """Sum of what ports give; ``None`` if an orientation it needs was not kept."""
        total = np.zeros((self._recording.t.size, components))
        for assignment in assignments:
            port, part = assignment.port, self._system.part(assignment.port.block.name)
            for piece in part.form.ports[port.name].pieces:
                value = self._piece(port, part, piece, components)
                if value is None:
                    return None
                total += value
        return total

    def _piece(self, port: Port, part: Part, piece: Piece, components: int) -> Floats | None:
        """What a piece gives, in the fixed frame; in space in that frame turned as all ports of the junction have."""
        form, recording = part.form, self._recording
        x = self._system.sharing.of_block(recording.x, part.states)
        if piece.line is not None:
            line = form.lines[piece.line]
            span = x[:, line.span : line.span + 2]
            length = line.free + line.stretch[1] * x[:, line.stretch[0]] if line.stretch else np.hypot(*span.T)
            along = (piece.output.csr((1, form.size)) @ x.T).T
            return np.asarray(along * span / length[:, None])
        local = (piece.output.csr((components, form.size)) @ x.T).T
        if not self._system.space.turns(port.domain.turns_with):
            return np.asarray(local)
        frame = port.anchor if piece.frame is None else piece.frame
        if self._system.attitudes:
            return np.asarray(
                local @ self._system.attitudes[frame.path].start.T if isinstance(frame, Anchor) else local
            )
        if not isinstance(frame, AngleRows):
            assert isinstance(frame, Anchor)
            known = self._system.anchor_angles.get(frame.path)
            if known is None:
                return None
            places, weights, reference = known
            angle = reference + recording.theta[:, places] @ weights
        else:
            places = part.theta[frame.rows.indices[1]]
            if (places == DROPPED).any():
                return None
            turning = places != STILL
            angle = frame.reference[0] + recording.theta[:, places[turning]] @ frame.rows.values[turning]
        return rotate(angle, local)
