"""Where everything stands in the assembled system: states, rotation states, inputs, orientation of each anchor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from phblocks.assembly.sharing import Team, same_states, same_turns
from phblocks.blocks.form import FIXED, AngleRows, Form
from phblocks.causality import CausalityReport
from phblocks.frames import Attitude, Orientation, Turn, standing
from phblocks.network import Junction, Network
from phblocks.ports import ROTATION, Anchor, Exposure, Port
from phblocks.system import DROPPED, STILL, Input
from phblocks.triplets import Floats, Ints, Triplets

AXES = "xyz"


@dataclass
class Layout:
    """Numbering of a network with its causality.

    Parameters
    ----------
    network : Network
        Blocks and junctions.
    forms : dict of str to Form
        Every block in its own coordinates.
    first_state, first_theta, first_line : dict of str to int
        Where the states, rotation states and lines of each block begin.
    n, n_theta : int
        Numbers of states and rotation states, those driven from outside included.
    theta_rows, theta_states : numpy.ndarray
        Rotation states and the states they are the time integrals of.
    inputs : list of Input
        All scalar inputs.
    first_input : dict of str to int
        Where the inputs of each exposure begin.
    port_gives : dict of Port to bool
        The assignment.
    junction_of : dict of Port to Junction
        Where each port is joined; the ground's left out.
    teams : sequence of sequence of Port
        Ports that give together at a junction, and share their states.
    theta_same : numpy.ndarray
        For each rotation state of a block the one that stands for it, itself unless it is shared.
    turning_same : dict of int to int
        Of frames of space that turn with shared states: the first of these states, and that of the port that stands for
        all of its team.
    """

    network: Network
    forms: dict[str, Form]
    first_state: dict[str, int]
    first_theta: dict[str, int]
    first_line: dict[str, int]
    n: int
    n_theta: int
    theta_rows: Ints
    theta_states: Ints
    inputs: list[Input]
    first_input: dict[str, int]
    port_gives: dict[Port, bool]
    junction_of: dict[Port, Junction]
    teams: Sequence[Team]
    theta_same: Ints
    turning_same: dict[int, int]
    _driven: dict[str, int] = field(default_factory=dict)
    _turns: dict[Anchor, Orientation] = field(default_factory=dict)
    _numbers: dict[str, int] = field(default_factory=dict)

    def gives(self, port: Port) -> bool:
        """Tell whether a port gives the common quantity.

        Parameters
        ----------
        port : Port
            The port.

        Returns
        -------
        bool
            True if it gives velocity and takes force.
        """
        return self.port_gives[port]

    def block_number(self, name: str) -> int:
        """Number of a block in the order of adding.

        Parameters
        ----------
        name : str
            Of the block.

        Returns
        -------
        int
            Its number.
        """
        if not self._numbers:
            self._numbers.update({block: i for i, block in enumerate(self.forms)})
        return self._numbers[name]

    @property
    def still(self) -> Orientation:
        """The orientation of the fixed frame."""
        return standing(self.network.space)

    def pieces(self, port: Port) -> list[tuple[Orientation | int, Triplets]]:
        """Return what a port gives, as rows over all states, each part with where it points.

        Parameters
        ----------
        port : Port
            The port.

        Returns
        -------
        list of (Turn or Attitude or int, Triplets)
            The orientation of its frame and entries of shape (components, n), or the number of the line it points
            along and entries of shape (1, n).
        """
        name = port.block.name
        result: list[tuple[Orientation | int, Triplets]] = []
        for piece in self.forms[name].ports[port.name].pieces:
            output = piece.output.shifted(0, self.first_state[name])
            if piece.line is not None:
                result.append((self.first_line[name] + piece.line, output))
            else:
                result.append((self._frame(name, port.anchor if piece.frame is None else piece.frame), output))
        return result

    def load_pieces(self, port: Port) -> list[tuple[Orientation, Triplets]]:
        """Return what answers a load that a block brings along, as rows over all states.

        Parameters
        ----------
        port : Port
            Of the exposure.

        Returns
        -------
        list of (Turn or Attitude, Triplets)
            Orientation of the frame and entries of shape (components, n); none for a port that can be joined.
        """
        name = port.block.name
        return [
            (
                self._frame(name, FIXED if piece.frame is None else piece.frame),
                piece.output.shifted(0, self.first_state[name]),
            )
            for piece in self.forms[name].loads.get(port.name, ())
        ]

    def span_at(self, port: Port) -> tuple[int, float] | None:
        """Tell whether a port is an end of a line.

        Parameters
        ----------
        port : Port
            The port.

        Returns
        -------
        (int, float) or None
            First state of the span, and +1 at the end or -1 at the start.
        """
        name = port.block.name
        for line in self.forms[name].lines:
            if port.name in (line.start, line.end):
                return self.first_state[name] + line.span, 1.0 if port.name == line.end else -1.0
        return None

    def orientation(self, port: Port) -> Orientation:
        """Return the orientation of the anchor of a port.

        Parameters
        ----------
        port : Port
            The port.

        Returns
        -------
        Turn or Attitude
            In terms of all rotation states; no turn for a port without anchor.
        """
        return self._orientation(port.anchor)

    def followed(self, exposure: Exposure, port: Port) -> Orientation:
        """Return the orientation of the frame that what comes from outside has its components in.

        Parameters
        ----------
        exposure : Exposure
            From where.
        port : Port
            One that it acts on.

        Returns
        -------
        Turn or Attitude
            The fixed frame, unless it follows; then that of the port that was opened if this has a place, else that of
            the port acted on.
        """
        if not exposure.follows:
            return self.still
        anchor = exposure.port.anchor
        placed = anchor is not None and anchor.name in self.forms[anchor.block.name].orientations
        return self.orientation(exposure.port if placed else port)

    def _frame(self, block: str, frame: AngleRows | Attitude | Anchor | None) -> Orientation:
        return self._orientation(frame) if frame is None or isinstance(frame, Anchor) else self._turn(block, frame)

    def _turn(self, block: str, angle: AngleRows | Attitude) -> Orientation:
        if angle is FIXED:
            return self.still
        if isinstance(angle, Attitude):
            if not isinstance(angle.turning, int):
                return angle
            first = self.first_state[block] + angle.turning
            return Attitude(angle.start, self.turning_same.get(first, first))
        places, weights = self.theta_same[self.first_theta[block] + angle.rows.indices[1]], angle.rows.values
        return Turn(tuple(places.tolist()), tuple(weights.tolist()), float(angle.reference[0]))

    def _orientation(self, anchor: Anchor | None) -> Orientation:
        if anchor is None:
            return self.still
        if anchor not in self._turns:
            rows = self.forms[anchor.block.name].orientations[anchor.name]
            self._turns[anchor] = self._taken(anchor) if rows is None else self._turn(anchor.block.name, rows)
        return self._turns[anchor]

    def _taken(self, anchor: Anchor) -> Orientation:
        """Follow the angular velocity that an anchor takes to its source: it turns with that."""
        junction = self.junction_of[anchor.rotation]
        for port in junction.ports:
            if self.gives(port) and port.anchor is not None:
                return self._orientation(port.anchor).carrying(anchor)
        name = next(e.name for e in junction.exposures if e.gives)
        if anchor.frame is not None:
            return Attitude(anchor.frame, name)
        if name not in self._driven:
            self._driven[name] = self.n_theta
            self.n_theta += 1
        return Turn((self._driven[name],), (1.0,), anchor.angle)

    def driven_rows(self) -> tuple[Ints, Ints]:
        """List the rotation states that inputs drive.

        Returns
        -------
        rows, inputs : numpy.ndarray
            The rotation state and the input whose time integral it is.
        """
        rows = list(self._driven.values())
        inputs = [self.first_input[name] for name in self._driven]
        return np.array(rows, dtype=np.int64), np.array(inputs, dtype=np.int64)

    def anchor_angles(self, place: Ints) -> dict[str, tuple[Ints, Floats, float]]:
        """List the orientation of every anchor in terms of the rotation states that are kept.

        Parameters
        ----------
        place : numpy.ndarray
            New number of each rotation state, :data:`DROPPED`, or :data:`STILL` if it stays zero.

        Returns
        -------
        dict
            Path of the anchor -> places, weights, initial angle; anchors that turn with a dropped rotation
            state are left out.
        """
        result = {}
        for anchor, turn in self._turns.items():
            if not isinstance(turn, Turn):
                continue
            places = place[np.array(turn.places, dtype=np.int64)]
            if (places != DROPPED).all():
                turning = places != STILL
                result[anchor.path] = (places[turning], np.array(turn.weights)[turning], turn.reference)
        return result

    @property
    def attitudes(self) -> dict[str, Attitude]:
        """How every anchor stands in space, by its path; none in the plane."""
        return {anchor.path: turn for anchor, turn in self._turns.items() if isinstance(turn, Attitude)}


def lay_out(network: Network, report: CausalityReport) -> Layout:
    """Reduce all blocks to their forms and number everything.

    Parameters
    ----------
    network : Network
        Blocks and junctions.
    report : CausalityReport
        Who gives and who takes.

    Returns
    -------
    Layout
        With the orientation of every anchor found.
    """
    gives: dict[str, dict[str, bool]] = {name: {} for name in network.blocks}
    for a in report.assignments:
        gives[a.port.block.name][a.port.name] = a.gives
    forms = {name: block.reduced_form(gives[name]) for name, block in network.blocks.items()}
    first_state = _firsts(forms, [form.size for form in forms.values()])
    first_theta = _firsts(forms, [form.rotation_states.size for form in forms.values()])
    theta_states = np.concatenate([first_state[name] + f.rotation_states for name, f in forms.items()])
    inputs: list[Input] = []
    first_input = {}
    for exposure in network.exposures():
        first_input[exposure.name] = len(inputs)
        domain = exposure.port.domain
        components = domain.components(network.space)
        imposed, answered = (domain.common, domain.summed) if exposure.gives else (domain.summed, domain.common)
        for c in components:
            name = exposure.name if len(components) == 1 else f"{exposure.name}.{AXES[c]}"
            inputs.append(Input(name, imposed, answered, exposure.name, exposure.gives, exposure.signal))

    def coordinates(port: Port) -> Ints:
        (piece,) = forms[port.block.name].ports[port.name].pieces
        return first_state[port.block.name] + piece.output.indices[1]

    turning = [team for team in report.shared if team[0].domain == ROTATION]
    # frames of space are kept by what they turn with; the components of their turns differ if they do
    alike, teams = (turning, []) if not network.space.turns("rotation") else ([], turning)
    layout = Layout(
        network=network,
        forms=forms,
        first_state=first_state,
        first_theta=first_theta,
        first_line=_firsts(forms, [len(form.lines) for form in forms.values()]),
        n=sum(form.size for form in forms.values()),
        n_theta=theta_states.size,
        theta_rows=np.arange(theta_states.size),
        theta_states=theta_states,
        inputs=inputs,
        first_input=first_input,
        port_gives={a.port: a.gives for a in report.assignments},
        junction_of={port: j for j in network.junctions() for port in j.ports if not port.block.shared},
        teams=report.shared,
        theta_same=same_turns(alike, coordinates, theta_states),
        turning_same=same_states(teams, coordinates),
    )
    for block in network.blocks.values():
        for anchor in block.anchors.values():
            layout._orientation(anchor)
    return layout


def _firsts(forms: dict[str, Form], sizes: list[int]) -> dict[str, int]:
    return dict(zip(forms, np.concatenate([[0], np.cumsum(sizes)])[:-1].astype(int).tolist(), strict=True))
