"""Random planar diagrams of all mechanical blocks: refused with a typed error, or port-Hamiltonian and balanced.

Links of all kinds join places in the plane; masses, bodies and the ground are put there, and what meets is pinned,
welded, held by multipliers or by a bushing. Torsion springs and dampers, sources, sliders and exposed ports take what
is left open.
"""

import os
from collections import Counter
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st

import phblocks as ph

STEPS = 10
#: Energies below this are round-off of nothing: a scene that is held entirely, J.
NOTHING = 1e-30
LINKS = ("body", "beam", "spring", "damper", "body")
FULL = np.array([[3e3, 2e2, 10.0], [2e2, 2e3, 5.0], [10.0, 5.0, 40.0]])


@dataclass
class Scene:
    """A diagram, the signals of its exposed ports, and what the run starts from and how it steps."""

    diagram: ph.Diagram
    inputs: dict[str, object]
    seed: int
    energy: float
    dt: float


def size(low, high):
    return st.floats(np.log10(low), np.log10(high)).map(lambda exponent: float(10.0**exponent))


def add_link(draw, d, kind, name, a, b):
    """Add a block from a to b; return its anchors at the two ends, and its spare ones there for what takes."""
    length = float(np.hypot(*(b - a)))
    if kind == "beam":
        section = ph.Section(
            axial=draw(size(1e3, 1e7)),
            shear=draw(size(1e3, 1e7)),
            bending=draw(size(1.0, 1e5)),
            mass=draw(size(0.1, 10.0)),
            rotary=draw(size(1e-5, 1e-1)),
        )
        curvature = draw(st.sampled_from([None, None, 1.0 / length, -1.5 / length]))
        beam = ph.Beam(name, section, a, b, elements=2, degree=draw(st.integers(1, 2)), curvature=curvature)
        d.add(beam)
        return (beam.start, beam.end), (None, None)
    if kind == "spring":
        free = length * draw(st.sampled_from([1.0, 0.0, 0.7, 1.2]))
        spring = d.add(ph.Spring(name, draw(size(1.0, 1e5)), a, b, free_length=free))
        return (spring.start, spring.end), (None, None)
    if kind == "damper":
        damper = d.add(ph.Damper(name, draw(size(1e-2, 1e2)), a, b))
        return (damper.start, damper.end), (None, None)
    mass, angle = draw(size(0.1, 10.0)), draw(st.floats(-3.0, 3.0))
    centre = a + draw(st.floats(0.0, 1.0)) * (b - a) + draw(st.sampled_from([0.0, 0.1])) * (b - a)[::-1]
    places = {"a": a, "b": b, "spare a": a, "spare b": b}
    body = d.add(ph.RigidBody(name, mass, mass * length**2 * draw(size(0.05, 1.0)), centre, places, angle=angle))
    return (body["a"], body["b"]), (body["spare a"], body["spare b"])


def gives(anchor):
    return isinstance(anchor.block, (ph.RigidBody, ph.Mass)) or anchor.block.shared


def join(draw, d, name, anchors, spares):
    """Join what meets at a place, most often in a way that may work."""
    if draw(st.integers(0, 9)) == 7:  # as it comes
        if len(anchors) > 1:
            d.pin(*anchors, multiplier=draw(st.booleans()))
        return
    givers = [a for a in anchors if gives(a)]
    takers = [a for a in anchors if not gives(a)]
    if len(givers) > 1:
        turning = all(a.turns for a in givers)
        held = d.weld if turning and draw(st.booleans()) else d.pin
        held(*givers, multiplier=True)
        hub = [a for a in spares if a is not None] + [a for a in givers if a.block.shared]
    else:
        hub = givers
    if takers and hub and hub[0].turns and takers[0].turns and draw(st.integers(0, 3)) == 2:
        bushing = d.add(ph.Bushing(f"{name} bushing", FULL * draw(size(0.1, 100.0)), FULL * draw(size(1e-3, 1e-1))))
        d.weld(hub[0], bushing.first)
        if len(takers) > 1:
            d.pin(*takers[1:], takers[0], bushing.second)
            d.connect(takers[0].rotation, bushing.second.rotation)
        else:
            d.weld(takers[0], bushing.second)
        return
    meeting = [*hub[:1], *takers]
    if len(meeting) > 1:
        if all(a.turns for a in meeting) and draw(st.booleans()):
            d.weld(*meeting)
        else:
            d.pin(*meeting)


def open_ports(d, domain):
    """Ports of beams, bodies and masses that nothing is joined to."""
    return [
        port
        for block in d.network.blocks.values()
        if isinstance(block, (ph.Beam, ph.RigidBody, ph.Mass))
        for port in block.ports.values()
        if port.domain == domain and port not in d.network.junction_of
    ]


def wave(amplitude, rate, vector):
    def signal(t):
        value = amplitude * np.array([np.cos(rate * t + 0.3), np.sin(rate * t + 0.3)])
        return value if vector else value[0]

    return signal


def attach(draw, d, kind, name, inputs):
    """Put something on open ports."""
    domain = ph.TRANSLATION if kind in TRANSLATIONS else ph.ROTATION
    ports = open_ports(d, domain)
    if "velocity" in kind and draw(st.integers(0, 7)) != 5:  # a body has a velocity already
        ports = [port for port in ports if isinstance(port.block, ph.Beam)]
    if not ports:
        return
    port = draw(st.sampled_from(ports))
    vector = domain == ph.TRANSLATION
    signal = wave(draw(size(1e-2, 10.0)), draw(st.floats(1.0, 50.0)), vector)
    if kind == "force":
        d.connect(d.add(ph.Force(name, draw(st.sampled_from([signal, signal(0.0)])), draw(st.booleans()))).port, port)
    elif kind == "moment":
        d.connect(d.add(ph.Moment(name, signal)).port, port)
    elif kind == "velocity":
        d.connect(d.add(ph.Velocity(name, signal)).port, port)
    elif kind == "angular velocity":
        d.connect(d.add(ph.AngularVelocity(name, signal)).port, port)
    elif kind == "expose":
        d.expose(port, name)
        inputs[name] = signal
    elif kind == "slider":
        guide = d.add(ph.Slider(name, (draw(st.floats(0.1, 1.0)), draw(st.floats(-1.0, 1.0)))))
        d.connect(guide.first, d.ground.translation)
        d.connect(guide.second, port)
    elif kind == "guide":
        guide_on(draw, d, name, port)
    elif kind == "lever":
        others = [p for p in ports if p.block is not port.block]
        matrix = draw(st.sampled_from([-0.5, [[0.3, 1.0], [-2.0, 0.4]]]))
        lever = d.add(ph.Transformer(name, matrix, ph.TRANSLATION, ph.TRANSLATION, multiplier=draw(st.booleans())))
        d.connect(lever.first, port)
        d.connect(lever.second, draw(st.sampled_from([d.ground.translation, *others])))
    elif kind == "rack":
        shafts = [p for p in open_ports(d, ph.ROTATION) if p.block is not port.block]
        rack = d.add(ph.Transformer(name, 0.3, ph.ROTATION, ph.TRANSLATION, draw(st.booleans()), None, (0.3, 1.0)))
        d.connect(rack.second, port)
        d.connect(rack.first, draw(st.sampled_from([d.ground.rotation, *shafts])))
    else:
        torsion = d.add(
            ph.TorsionSpring(name, draw(size(0.1, 1e3)), draw(st.floats(-0.5, 0.5)))
            if kind == "torsion spring"
            else ph.TorsionDamper(name, draw(size(1e-3, 10.0)))
        )
        others = [p for p in ports if p is not port]
        d.connect(torsion.first, port)
        d.connect(torsion.second, draw(st.sampled_from([d.ground.rotation, *others])))


def guide_on(draw, d, name, port):
    """A slider on a guide that turns with the ground or with a part that has both ports of an anchor open."""
    rotations = {p.anchor: p for p in open_ports(d, ph.ROTATION) if p.block is not port.block}
    shafts = [p for p in open_ports(d, ph.TRANSLATION) if p.anchor in rotations]
    first = draw(st.sampled_from([d.ground.translation, *shafts]))
    start = np.zeros(2) if first.block.shared else first.anchor.position
    direction = (draw(st.floats(0.1, 1.0)), draw(st.floats(-1.0, 1.0)))
    turns = not any(p.anchor is port.anchor for p in open_ports(d, ph.ROTATION))
    guide = d.add(ph.Slider(name, direction, turns, guide="first", start=start, end=port.anchor.position))
    d.connect(guide.first, first)
    d.connect(guide.first_rotation, rotations.get(first.anchor, d.ground.rotation))
    d.connect(guide.second, port)
    if not turns:
        d.connect(guide.second_rotation, port.anchor.rotation)


TRANSLATIONS = ("force", "velocity", "slider", "expose", "guide", "lever", "rack")
KINDS = (*TRANSLATIONS, "moment", "angular velocity", "torsion spring", "torsion damper")


@st.composite
def scenes(draw):
    d = ph.Diagram("random", gravity=draw(st.sampled_from([None, (0.0, -9.81), (3.0, 1.0)])))
    places = [np.zeros(2)]
    for _ in range(draw(st.integers(1, 3))):
        angle, length = draw(st.floats(-3.0, 3.0)), draw(size(0.2, 3.0))
        places.append(places[-1] + length * np.array([np.cos(angle), np.sin(angle)]))
    meeting = [[] for _ in places]
    spare = [[] for _ in places]
    for i in range(1, len(places) + draw(st.integers(0, 2))):
        ends = (i - 1, i) if i < len(places) else (0, len(places) - 1)
        if np.hypot(*(places[ends[1]] - places[ends[0]])) < 0.05:
            continue
        anchors, spares = add_link(draw, d, draw(st.sampled_from(LINKS)), f"link {i}", *(places[e] for e in ends))
        for end, anchor, other in zip(ends, anchors, spares, strict=True):
            meeting[end].append(anchor)
            spare[end].append(other)
    for i, place in enumerate(places):
        what = draw(st.sampled_from(["nothing", "ground", "mass", "disc"]))
        takers_only = not any(gives(a) or isinstance(a.block, ph.Beam) for a in meeting[i])
        if what == "nothing" and takers_only:
            what = "mass"  # what two springs join has to have a mass
        if what == "mass":
            meeting[i].append(d.add(ph.Mass(f"mass {i}", draw(size(0.1, 10.0)), place)).centre)
        elif what == "disc":
            disc = d.add(ph.RigidBody(f"disc {i}", 1.0, draw(size(1e-3, 1.0)), place, {"spare": place}))
            meeting[i].append(disc.centre)
            spare[i].append(disc["spare"])
        elif what == "ground":
            meeting[i].append(d.ground)
        join(draw, d, f"place {i}", meeting[i], spare[i])
    inputs = {}
    for i in range(draw(st.sampled_from([1, 3, 2, 0]))):
        attach(draw, d, draw(st.sampled_from(KINDS)), f"extra {i}", inputs)
    return Scene(
        d,
        inputs,
        seed=draw(st.integers(0, 2**32 - 1)),
        energy=draw(st.sampled_from([0.0, 1e-2, 1.0])),
        dt=draw(size(1e-4, 5e-3)),
    )


def moving(system, seed, energy):
    """A start with random velocities of about this energy, J; springs and spans as they are."""
    rng = np.random.default_rng(seed)
    kinetic = system.energy_kind_of_state == (*system.energy_kinds, "kinetic").index("kinetic")
    x = system.start.x.copy()
    mass = system.E.diagonal()[kinetic]
    v = rng.standard_normal(mass.size) / np.sqrt(mass)
    x[kinetic] = v * np.sqrt(2.0 * energy / max(1.0, float(mass @ v**2)))
    return ph.State(x, system.start.theta, system.start.points)


def check_structure(system, seed):
    """E symmetric and positive on the states with energy, R semidefinite, J skew to 1e-12, in energy units."""
    mass, stored = system.E.diagonal(), system.carries_energy
    E, R = system.E.toarray(), system.R.toarray()
    scale = np.ones(system.n)
    scale[stored] = 1.0 / np.sqrt(mass[stored])
    assert (mass[stored] > 0.0).all() and not E[~stored].any() and not E[:, ~stored].any()
    unit = scale[:, None] * E * scale
    assert np.abs(unit - unit.T).max() <= 1e-12
    assert np.linalg.eigvalsh(unit[np.ix_(stored, stored)]).min(initial=1.0) > 0.0
    R = scale[:, None] * R * scale
    assert np.abs(R - R.T).max() <= 1e-12 * np.abs(R).max()
    assert np.linalg.eigvalsh((R + R.T) / 2.0).min() >= -1e-12 * np.abs(R).max()
    x = moving(system, seed, 100.0).x
    x[stored] += np.random.default_rng(seed).standard_normal(stored.sum()) * scale[stored]
    for theta in (system.start.theta, np.random.default_rng(seed).uniform(-10.0, 10.0, system.start.theta.size)):
        J = scale[:, None] * system.J(x, theta).toarray() * scale
        assert np.abs(J + J.T).max() <= 1e-12 * np.abs(J).max()


def energy_scale(solution):
    """The largest energy that is stored, exchanged or can be felt in the scene, J."""
    system, energy, power = solution.system, solution.energy, solution.power
    series = [energy.total, energy.dissipated, *power.inputs.values(), *power.connections.values()]
    series += [block["stored"] for block in power.blocks.values()]
    weight = system.point_mass * np.linalg.norm(system.gravity)
    height = float(weight @ np.linalg.norm(solution.recording.points[0], axis=1))
    return max(height, *(float(np.abs(s).max()) for s in series))


def check_balances(solution):
    """Each step, each block, each junction: below 1e-11 of the energies that are about. Return the worst."""
    scale = energy_scale(solution)
    power, energy = solution.power, solution.energy
    received = sum(block["received"] for block in power.blocks.values())
    errors = [
        solution.max_power_balance_error,
        *power.block_errors.values(),
        *power.connection_errors.values(),
        float(np.abs(received).max()),
        float(np.ptp(energy.total - energy.supplied + energy.dissipated)) / STEPS,
    ]
    assert max(errors) <= max(1e-11 * scale, NOTHING), (max(errors), scale)
    assert (np.diff(energy.dissipated) >= -1e-11 * scale).all()


def check(scene, counter):
    try:
        system = scene.diagram.compile()
        solution = ph.simulate(
            system,
            STEPS * scene.dt,
            scene.dt,
            start=moving(system, scene.seed, scene.energy),
            inputs=scene.inputs,
            max_halvings=6,
        )
    except ph.PhblocksError as error:
        counter[type(error).__name__] += 1
        event(type(error).__name__)
        assert error.where and error.expected and error.got and error.fix
        return
    check_structure(system, scene.seed)
    assert solution.status.name in ("success", "step failed")
    counter[solution.status.name] += 1
    for kind in {type(block).__name__ for block in scene.diagram.network.blocks.values()}:
        event(f"ran with {kind}")
    counter["with multipliers" if system.constraint_names else "without multipliers"] += 1
    event(solution.status.name)
    check_balances(solution)


def assert_most_succeeded(counter):
    """Else the property would be about errors and early ends."""
    runs = counter["with multipliers"] + counter["without multipliers"]
    total = counter.total() - runs
    assert counter["success"] >= 0.4 * total, counter
    assert counter["step failed"] <= 0.05 * total, counter
    assert counter["with multipliers"] > 0.05 * total, counter


NO_HURRY = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much]


def test_random_planar():
    """100 diagrams."""
    counter: Counter[str] = Counter()

    @settings(max_examples=100, suppress_health_check=NO_HURRY)
    @given(scenes())
    def run(scene):
        check(scene, counter)

    run()
    assert_most_succeeded(counter)


@pytest.mark.slow
def test_many_random_planar():
    """500, and different ones in every run."""
    counter: Counter[str] = Counter()

    @settings(max_examples=500, derandomize="CI" in os.environ, database=None, suppress_health_check=NO_HURRY)
    @given(scenes())
    def run(scene):
        check(scene, counter)

    run()
    assert_most_succeeded(counter)
