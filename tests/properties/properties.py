"""What holds for every diagram that compiles, and what an error has to say for every other one."""

import numpy as np

import phblocks as ph
from phblocks import export
from phblocks.network import Junction, Network
from phblocks.system.scaling import state_scale

STEPS = 8
#: Energies below this are round-off of nothing: a scene that is held entirely, J.
NOTHING = 1e-30


def describe(diagram):
    """What hypothesis prints of a diagram for which something does not hold."""
    network = diagram.network
    blocks = [f"{b!r} {vars(b)}" for b in network.blocks.values()]
    exposed = [f"expose {e.port.path} as {e.name!r}, {'common' if e.gives else 'summed'}" for e in network.exposed]
    return "\n".join([f"gravity {network.gravity}", *blocks, *(j.name for j in network.joined), *exposed])


def assert_error_helps(error):
    assert error.where and error.expected and error.got and error.fix and str(error).startswith(f"[{error.code}]")


def wave(domain, seed):
    """A signal for an exposed port: of force or velocity, with a rate and phase of its own."""
    rng = np.random.default_rng(seed)
    amplitude, rate, phase = rng.uniform(0.1, 2.0), rng.uniform(1.0, 50.0), rng.uniform(0.0, 6.0)
    if domain.turns_with == "translation":
        return lambda t: amplitude * np.array([np.cos(rate * t + phase), np.sin(rate * t + phase)])
    return lambda t: amplitude * np.cos(rate * t + phase)


def inputs_of(diagram, seed):
    """A wave for each exposed port that has no signal."""
    open_ports = [e for e in diagram.network.exposures() if e.signal is None]
    return {e.name: wave(e.port.domain, seed + i) for i, e in enumerate(open_ports)}


def moving(system, seed, energy):
    """A start with random velocities of about this energy, J; springs and spans as they are."""
    rng = np.random.default_rng(seed)
    kinetic = system.energy_kind_of_state == (*system.energy_kinds, "kinetic").index("kinetic")
    x = system.start.x.copy()
    mass = system.E.diagonal()[kinetic]
    v = rng.standard_normal(mass.size) / np.sqrt(mass)
    x[kinetic] = v * np.sqrt(2.0 * energy / max(1.0, float(mass @ v**2)))
    return ph.State(x, system.start.theta, system.start.points)


def start_of(system, seed):
    """At rest, with random velocities, or moving as a rigid body."""
    if seed % 4 == 3:
        return system.rigid_motion((0.3, -0.2), spin=1.5, about=(0.5, 0.0))
    return moving(system, seed, [0.0, 1e-2, 1.0][seed % 4])


def assert_symmetric_semidefinite(matrix):
    size = np.abs(matrix).max(initial=0.0)
    assert np.abs(matrix - matrix.T).max(initial=0.0) <= 1e-12 * size
    assert np.linalg.eigvalsh((matrix + matrix.T) / 2.0).min(initial=0.0) >= -1e-12 * size


def assert_structure(system, seed):
    """E and R symmetric and semidefinite, E definite on what carries energy, J skew; in units of energy."""
    scale = state_scale(system)
    E = scale[:, None] * system.E.toarray() * scale
    assert_symmetric_semidefinite(E)
    stored = system.carries_energy
    assert np.linalg.eigvalsh(E[np.ix_(stored, stored)]).min(initial=1.0) > 0.0
    assert not E[~stored].any() and not E[:, ~stored].any()
    rng = np.random.default_rng(seed)
    for theta in (system.start.theta, rng.uniform(-10.0, 10.0, system.start.theta.size)):
        x = system.start.x + scale * rng.standard_normal(system.n)
        assert_symmetric_semidefinite(scale[:, None] * system.R_at(x).toarray() * scale)
        J = scale[:, None] * system.J(x, theta).toarray() * scale
        assert np.abs(J + J.T).max() <= 1e-12 * np.abs(J).max()


def energy_scale(solution):
    """The largest energy that is stored, exchanged, dissipated or can be felt in the scene, J."""
    system, energy, power = solution.system, solution.energy, solution.power
    series = [energy.total, energy.dissipated, *power.inputs.values(), *power.connections.values()]
    series += [block[kind] for block in power.blocks.values() for kind in ("stored", "dissipated", "supplied")]
    weight = system.point_mass * np.linalg.norm(system.gravity)
    height = float(weight @ np.linalg.norm(solution.recording.points[0], axis=1))
    return max(height, *(float(np.abs(s).max()) for s in series))


def assert_balanced(solution):
    """Each step, each block, each junction: below 1e-11 of the energies that are about."""
    scale = energy_scale(solution)
    power, energy = solution.power, solution.energy
    received = sum(block["received"] for block in power.blocks.values())
    errors = {
        "step": solution.max_power_balance_error,
        "block": max(power.block_errors.values()),
        "junction": max(power.connection_errors.values(), default=0.0),
        "all junctions": float(np.abs(received).max()),
        "sum of steps": float(np.ptp(energy.total - energy.supplied + energy.dissipated)) / STEPS,
    }
    assert max(errors.values()) <= max(1e-11 * scale, NOTHING), (errors, scale)
    assert (np.diff(energy.dissipated) >= -1e-11 * scale).all()
    return max(errors.values()) / max(scale, NOTHING)


def shuffled(diagram, seed):
    """The same diagram with blocks added, ports joined and openings made in another order."""
    rng, old = np.random.default_rng(seed), diagram.network

    def mixed(items):
        items = list(items)
        return [items[i] for i in rng.permutation(len(items))]

    new = Network(old.name, old.gravity, old.space, blocks=dict(mixed(old.blocks.items())))
    for junction in mixed(old.joined):
        new.join(Junction(tuple(mixed(junction.ports)), junction.made_by))
    new.exposed = mixed(old.exposed)
    return diagram.with_network(new)


def assert_order_does_not_matter(diagram, system, seed, effects="auto"):
    """The same assignment, and the same matrices after ordering states by name."""
    other = shuffled(diagram, seed).compile(effects=effects)
    gives = [{a.port.path: a.gives for a in s.report.assignments} for s in (system, other)]
    assert gives[0] == gives[1]
    assert set(other.state_names) == set(system.state_names)
    states = [other.state_names.index(name) for name in system.state_names]
    at = np.ix_(states, states)
    x = system.start.x + state_scale(system) * np.random.default_rng(seed).standard_normal(system.n)
    same = np.empty_like(x)
    same[states] = x
    pairs = [(system.R_at(x), other.R_at(same)), (system.J(x), other.J(same)), (system.J(), other.J())]
    for mine, its in ((system.E, other.E), *pairs):
        np.testing.assert_allclose(its.toarray()[at], mine.toarray(), rtol=0.0, atol=1e-12 * abs(mine).max())


def assert_pruned_moves_alike(diagram, solution, run):
    """Without orientations and positions for reading: the same trajectory."""
    pruned = diagram.compile(outputs=None)
    assert pruned.state_names == solution.system.state_names
    x = run(pruned).x
    assert x.shape == solution.x.shape
    scale = state_scale(pruned)
    size = np.abs(solution.x / scale).max()
    assert np.abs((x - solution.x) / scale).max() <= 1e-8 * size


def assert_export_reads_back(system, path):
    """Matrices, names and units of the file are those of the system."""
    system.export(path)
    read = export.read(path)
    for name in ("E", "J", "R", "G"):
        mine = getattr(system, name)
        mine = mine() if callable(mine) else mine
        assert abs(getattr(read, name) - mine).max() == 0.0 if mine.size else True
    assert tuple(read.state_names) == system.state_names and tuple(read.input_names) == system.input_names
