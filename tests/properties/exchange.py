"""What blocks exchange, port by port: force times velocity, and what both do to the states, from the forms alone.

Nothing here asks the assembled matrices or the assembly how they came about. A port gives what its pieces say, turned
into the fixed frame; at a junction all take the velocity of the one that gives, and that one takes the sum of what the
others give, with the opposite sign; what a port takes enters its block through the transposed outputs.
"""

from dataclasses import dataclass, field

import numpy as np

from phblocks.blocks.form import AngleRows
from phblocks.system.scaling import state_scale


@dataclass
class Exchanged:
    """At one state: the force that every block feels from its ports, and who passes how much power to whom.

    Powers are W, by (giving port, taking port) and by input; forces stand in the coordinates of all blocks.
    """

    force: np.ndarray
    between: dict[tuple[str, str], float] = field(default_factory=dict)
    into: dict[tuple[str, str], float] = field(default_factory=dict)
    supplied: float = 0.0


def turned(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def to_fixed_frame(system, port, piece, x, theta):
    """The matrix from what a piece of a port gives to components in the fixed frame."""
    part = system.part(port.block.name)
    if piece.line is not None:
        line = part.form.lines[piece.line]
        span = x[line.span : line.span + 2]
        length = np.hypot(*span) if line.stretch is None else line.free + line.stretch[1] * x[line.stretch[0]]
        return (span / length)[:, None]
    if port.domain.turns_with != "translation":
        return np.eye(1)
    if isinstance(piece.frame, AngleRows):
        return turned(
            piece.frame.reference[0] + theta[part.theta[piece.frame.rows.indices[1]]] @ piece.frame.rows.values
        )
    return turned(orientation(system, port.anchor if piece.frame is None else piece.frame, theta))


def orientation(system, anchor, theta):
    if anchor is None:  # a port of matrices: its vectors are in the fixed frame
        return 0.0
    places, weights, reference = system.anchor_angles[anchor.path]
    return reference + theta[places] @ weights


def outputs(system, port, pieces, coordinates, theta):
    """Rows of what a port gives in the fixed frame, over the coordinates of its block."""
    part = system.part(port.block.name)
    total = np.zeros((2 if port.domain.turns_with == "translation" else 1, part.form.size))
    for piece in pieces:
        frame = to_fixed_frame(system, port, piece, coordinates[part.states], theta)
        total += frame @ piece.output.csr((frame.shape[1], part.form.size)).toarray()
    return total


def exchanged(system, network, x, theta, u):
    """Go from junction to junction."""
    z = system.sharing.expansion @ x
    result = Exchanged(np.zeros(z.size))
    gives = {a.port: a.gives for a in system.report.assignments}
    inputs = {
        e.name: [i for i, entry in enumerate(system.inputs) if entry.exposure == e.name] for e in network.exposures()
    }

    def rows(port):
        pieces = system.part(port.block.name).form.ports[port.name].pieces
        return outputs(system, port, pieces, z, theta)

    def take(port, rows, taken):
        """Let a port feel what it takes; return the power that its block receives."""
        states = system.part(port.block.name).states
        result.force[states] += rows.T @ taken
        return float(taken @ (rows @ z[states]))

    def imposed(exposure, port):
        value = u[inputs[exposure.name]]
        return turned(orientation(system, port.anchor, theta)) @ value if exposure.follows and value.size > 1 else value

    for junction in network.junctions():
        givers = [p for p in junction.ports if gives[p]]
        takers = [p for p in junction.ports if not gives[p]]
        for port in takers:
            for giver in givers[:1]:
                output, states = rows(giver), system.part(giver.block.name).states
                mine = rows(port)
                given = mine @ z[system.part(port.block.name).states]
                pair = (giver.path, port.path)
                result.between[pair] = take(port, mine, output @ z[states])
                result.into[pair] = take(giver, output, -given)
        for exposure in junction.exposures:
            for port in takers if exposure.gives else givers[:1]:
                result.supplied += take(port, rows(port), imposed(exposure, port))
    for exposure in network.exposures():
        pieces = system.part(exposure.port.block.name).form.loads.get(exposure.port.name, ())
        for piece in pieces:
            angle = 0.0
            if isinstance(piece.frame, AngleRows):
                places = system.part(exposure.port.block.name).theta[piece.frame.rows.indices[1]]
                angle = piece.frame.reference[0] + theta[places] @ piece.frame.rows.values
            elif piece.frame is not None:
                angle = orientation(system, piece.frame, theta)
            local = piece.output.csr((2, system.part(exposure.port.block.name).form.size)).toarray()
            result.supplied += take(exposure.port, turned(angle) @ local, u[inputs[exposure.name]])
    return result


def inside(system, x):
    """What J of the blocks alone does to their states: ``(J0 + T z) z``, and functions of the state."""
    z = system.sharing.expansion @ x
    force = np.zeros(z.size)
    for part in system.parts:
        form, own = part.form, z[part.states]
        n = form.size
        J = form.J0.csr((n, n)).toarray()
        i, j, k = form.T.indices
        np.add.at(J, (i, j), form.T.values * own[k])
        if form.modulation is not None:
            J[np.ix_(form.modulation.on, form.modulation.on)] += form.modulation.interconnection(
                own[form.modulation.by]
            )
        force[part.states] = J @ own
    return force


def assert_ports_exchange_what_matrices_say(system, network, seed, count=2):
    """At random states and orientations, with random inputs, relative to the largest of each.

    Powers across each junction add up to nothing; the books of the ledger have the same powers; and J and G do to the
    states what the ports do.
    """
    rng = np.random.default_rng(seed)
    scale = state_scale(system)
    for _ in range(count):
        theta = rng.uniform(-10.0, 10.0, system.start.theta.size)
        x = system.start.x + scale * rng.standard_normal(system.n)
        u = rng.standard_normal(system.n_inputs)
        found = exchanged(system, network, x, theta, u)
        own = inside(system, x)
        expected = system.sharing.expansion.T @ (own + found.force)
        given = system.J(x, theta) @ x + system.G(theta, x) @ u
        size = abs(system.J(x, theta)) @ abs(x) + abs(system.G(theta, x)) @ abs(u)
        largest = (scale * size).max(initial=0.0)
        assert np.abs(scale * (given - expected)).max(initial=0.0) <= 1e-12 * largest

        entries, number = system.connections.entries, system.connections.number
        i, j, f = entries.indices
        z = system.sharing.expansion @ x
        each = entries.values * system.features(theta, x)[f] * z[i] * z[j]
        assert set(system.connections.names) <= set(found.between)
        booked = dict.fromkeys(found.between, 0.0)
        for c, pair in enumerate(system.connections.names):
            booked[pair] = each[number == c].sum()
        for pair, power in found.between.items():
            bound = 1e-12 * max(largest, np.abs(each).max(initial=0.0))
            assert abs(power + found.into[pair]) <= bound, pair
            assert abs(power - booked[pair]) <= bound, pair
        y = system.G(theta, x).T @ x
        assert abs(found.supplied - u @ y) <= 1e-12 * max(largest, np.abs(u * y).max(initial=0.0))
