"""Random planar diagrams of every block: what a diagram can be.

A diagram grows in four steps. *Links* join places in the plane, and each place gets a *fitting* that the links meet
at. Then what meets is put together: parts that give velocity are held together by *joints*, all others go to one of
them. Last come *devices*: sources, springs and gears between shafts, circuits, matrices and energies of the user's.

Until it is committed the diagram is a list of nodes, each a list of ports to be joined, so that a device can be
attached anywhere. The structure is drawn by hypothesis and so can be shrunk; the numbers come from a seed.
"""

from dataclasses import dataclass, field
from functools import partial

import numpy as np
import sympy
from hypothesis import strategies as st

import phblocks as ph

MAGNETIC = ph.Domain("magnetic", ph.Quantity("magnetomotive force", "A"), ph.Quantity("flux rate", "V"))
SCALARS = (ph.ELECTRICAL, ph.HYDRAULIC, MAGNETIC)
#: What a port does with the common quantity of its domain, such as velocity.
GIVES, TAKES, EITHER = "gives", "takes", "either"
#: Translation and rotation of an end of a beam whose causality is fixed.
ENDS = {"free": (GIVES, GIVES), "pinned": (TAKES, GIVES), "clamped": (TAKES, TAKES), "guided": (GIVES, TAKES)}
STEPS = [(1.0, 0.0), (0.0, 1.0), (0.6, -0.3), (-0.5, 0.8), (0.2, 0.1), None]


@dataclass(eq=False)
class Node:
    """Ports that will be joined; ``role`` is GIVES if one of them certainly gives, EITHER if one may."""

    ports: list
    role: str

    @property
    def domain(self):
        return self.ports[0].domain

    @property
    def held(self):
        """By the ground, a reference or a source: an input that is summed would do nothing here."""
        return any(isinstance(p.block, (ph.Velocity, ph.AngularVelocity, ph.Voltage)) or p.block.shared for p in self.ports)

    def attach(self, port, role=TAKES):
        self.ports.append(port)
        if role == GIVES or self.role == TAKES:
            self.role = role


@dataclass
class Member:
    """An anchor that meets others at a place: the roles of its translation and of its rotation."""

    anchor: ph.Anchor
    translation: str
    rotation: str


@dataclass
class Sketch:
    """A diagram while it is drawn."""

    draw: object
    rng: np.random.Generator
    diagram: ph.Diagram
    nodes: list = field(default_factory=list)

    def choose(self, options):
        return self.draw(st.sampled_from(options))

    def size(self, low, high):
        return float(10.0 ** self.rng.uniform(np.log10(low), np.log10(high)))

    def add(self, kind, *arguments, **options):
        """Add a block with a name of its own, and return it."""
        return self.diagram.add(kind(self.name(kind.__name__), *arguments, **options))

    def name(self, kind):
        return f"{kind} {len(self.diagram.network.blocks)}"

    def signal(self, domain):
        """A wave or a constant of the components of a domain."""
        amplitude, rate, phase = self.size(1e-2, 3.0), self.size(1.0, 50.0), self.rng.uniform(0.0, 6.0)
        if domain.turns_with == "translation":
            wave = lambda t: amplitude * np.array([np.cos(rate * t + phase), np.sin(rate * t + phase)])  # noqa: E731
        else:
            wave = lambda t: amplitude * np.cos(rate * t + phase)  # noqa: E731
        return self.choose([wave, wave(0.0)])

    def node(self, port, role):
        self.nodes.append(Node([port], role))
        return self.nodes[-1]

    def places_for(self, domain, role):
        """Nodes of a domain where a port of this role can be attached."""
        fits = (GIVES, EITHER) if role == TAKES else (EITHER, TAKES)
        return [n for n in self.nodes if n.domain == domain and n.role in fits]

    def attach(self, port, role, acts=False):
        """Attach a port to a node that was there; make one if there is none where it fits."""
        places = [n for n in self.places_for(port.domain, role) if not (acts and n.held)]
        if role == TAKES and port.domain == ph.ROTATION and not acts:
            places.append(None)
        if not places:
            if role == TAKES and port.domain in SCALARS:
                add_circuit(self, port.domain)
                places = self.places_for(port.domain, role)
            elif role == TAKES:
                body = self.add(ph.RigidBody, self.size(0.1, 10.0), self.size(1e-2, 1.0), self.rng.normal(size=2))
                nodes = [self.node(own, GIVES) for own in body.centre.ports]
                places = [node for node in nodes if node.domain == port.domain]
            else:
                self.node(port, role)
                return
        node = self.choose(places)
        if node is None:
            self.diagram.connect(port, self.diagram.ground.rotation)
        else:
            node.attach(port, role)


# --- links: from place to place --------------------------------------------------------------------------------------


def add_beam(sketch, a, b, fittings):
    """A beam whose ends choose, or are fixed as what they meet allows."""
    size, length = sketch.size, float(np.hypot(*(b - a)))
    section = ph.Section(
        axial=size(1e3, 1e7), shear=size(1e3, 1e7), bending=size(1.0, 1e5), mass=size(0.1, 10.0), rotary=size(1e-5, 0.1)
    )
    elements = sketch.choose([2, 3, 2, 3, 2, (0.0, 0.3, 1.0), (0.0, 0.3, 1.0), 1])
    ends, causality = ("auto", "auto"), "auto"
    if sketch.choose([False, False, True]):
        ends = tuple(
            sketch.choose(["clamped", "pinned", "guided", "free"] if what in ("ground", "disc") else ["free", "pinned"])
            for what in fittings
        )
        ends = ends if elements != 1 else (ends[0], ends[0])
        causality = sketch.choose([ends, "-".join(ends)])
    loads = [
        ph.LineLoad(f"{sketch.name('load')} {i}", sketch.signal(ph.TRANSLATION), follows=follows)
        for i, follows in enumerate(sketch.choose([[], [], [False], [True], [False, True]]))
    ]
    beam = ph.Beam(
        sketch.name("Beam"),
        section,
        a,
        b,
        elements=elements,
        degree=sketch.choose([1, 2, 3]),
        causality=causality,
        curvature=sketch.choose([None, 1.0 / length, -1.5 / length]),
        switch_at=sketch.choose([0.5, 0.1]),
        damping=sketch.choose(
            [None, ph.Damping(viscous=size(0.1, 10.0), rotary=size(1e-4, 0.1)), ph.Damping(internal=(1e-4, 0.0, 1e-3))]
        ),
        loads=loads,
    )
    if ends == ("auto", "auto") and sketch.choose([False, False, False, True]):
        first, second = (sketch.diagram.add(part) for part in beam.split(0.4))
        sketch.diagram.weld(first.end, second.start)
    else:
        first = second = sketch.diagram.add(beam)
    roles = [ENDS.get(end, (EITHER, EITHER)) for end in ends]
    return [Member(anchor, *role) for anchor, role in zip((first.start, second.end), roles, strict=True)]


def add_line(kind, low, high, sketch, a, b, _):
    options = {}
    if kind is ph.Spring:
        options["free_length"] = float(np.hypot(*(b - a))) * sketch.choose([1.0, 0.0, 0.7, 1.2])
    line = sketch.add(kind, sketch.size(low, high), a, b, **options)
    return [Member(line.start, TAKES, None), Member(line.end, TAKES, None)]


def add_body(sketch, a, b, _):
    """A rigid body with an anchor at each end, given in the fixed frame or in its own."""
    mass, angle = sketch.size(0.1, 10.0), sketch.rng.uniform(-3.0, 3.0)
    centre = a + sketch.rng.uniform() * (b - a) + sketch.choose([0.0, 0.1]) * (b - a)[::-1]
    inertia = mass * float((b - a) @ (b - a)) * sketch.size(0.05, 1.0)
    c, s = np.cos(angle), np.sin(angle)
    frame = sketch.choose(["world", "body"])
    places = {"a": a, "b": b}
    if frame == "body":
        places = {key: np.array([[c, s], [-s, c]]) @ (place - centre) for key, place in places.items()}
    body = sketch.add(ph.RigidBody, mass, inertia, centre, places, coordinates=frame, angle=angle)
    return [Member(body["a"], GIVES, GIVES), Member(body["b"], GIVES, GIVES)]


LINKS = [add_beam, add_beam, add_body, partial(add_line, ph.Spring, 1.0, 1e5), partial(add_line, ph.Damper, 0.01, 1e2)]


# --- fittings and joints: what meets at a place ----------------------------------------------------------------------


def add_fitting(sketch, what, place):
    """What is at a place besides the links: a list of one member or none."""
    if what == "mass":
        return [Member(sketch.add(ph.Mass, sketch.size(0.1, 10.0), place).centre, GIVES, None)]
    if what == "disc":
        disc = sketch.add(ph.RigidBody, sketch.size(0.1, 10.0), sketch.size(1e-3, 1.0), place)
        return [Member(disc.centre, GIVES, GIVES)]
    return [Member(sketch.diagram.ground, GIVES, GIVES)] if what == "ground" else []


def add_joint(sketch, first, second):
    """Hold two hubs (a node of translation, and one of rotation or None) together by a joint that takes velocity."""
    turning = first[1] is not None and second[1] is not None
    kind = sketch.choose(["pin", "slider", *(["weld", "guide", "bushing"] if turning else [])])
    if kind == "bushing":
        stiffness = np.array([[3e3, 2e2, 10.0], [2e2, 2e3, 5.0], [10.0, 5.0, 40.0]]) * sketch.size(0.1, 100.0)
        damping = sketch.choose([None, np.diag([1.0, 0.0, 0.1]), stiffness * 1e-3])
        joint = sketch.add(ph.Bushing, stiffness, damping, angle=sketch.rng.uniform(-3.0, 3.0))
        ports = [anchor.ports for anchor in (joint.first, joint.second)]
    else:
        turns = kind in ("pin", "slider")
        if kind in ("pin", "weld"):
            joint = sketch.add(ph.RigidJoint, turns=turns)
        else:
            joint = sketch.add(ph.Slider, sketch.choose([(1.0, 0.0), tuple(sketch.rng.normal(size=2))]), turns=turns)
        ports = [[joint.first], [joint.second]]
        if not turns:
            ports = [[joint.first, joint.first_rotation], [joint.second, joint.second_rotation]]
    for hub, side in zip((first, second), ports, strict=True):
        for node, port in zip(hub, side, strict=False):
            node.attach(port, TAKES)


def add_hub(sketch, giver, others):
    """Join what can be joined without a constraint: one that gives velocity, or may, and others that take it.

    Return the node of translation, and that of rotation if something turns with the hub.
    """
    here = sketch.node(giver.anchor.translation, giver.translation)
    hub = add_shaft(sketch, giver) if giver.anchor.turns else None
    for member in others:
        here.attach(member.anchor.translation, member.translation)
        if not member.anchor.turns:
            continue
        welded = member.rotation == TAKES or (member.rotation == EITHER and sketch.choose([False, True]))
        if hub is not None and welded:
            hub.attach(member.anchor.rotation, member.rotation)
        else:
            own = add_shaft(sketch, member)
            hub = own if hub is None else hub
    return here, hub


def add_shaft(sketch, member):
    """Leave the rotation of an anchor open, or hold it if it can only take."""
    if member.rotation != TAKES:
        return sketch.node(member.anchor.rotation, member.rotation)
    shaft = sketch.node(sketch.diagram.ground.rotation, GIVES)
    shaft.attach(member.anchor.rotation)
    return shaft


def join(sketch, members):
    """Put together what meets at a place."""
    givers = [m for m in members if m.translation == GIVES]
    if len(members) == len(givers) > 1 and sketch.choose([False, True]):  # the verbs for bodies
        anchors = [m.anchor for m in members]
        turning = all(anchor.turns for anchor in anchors)
        held = sketch.choose([sketch.diagram.pin, sketch.diagram.weld]) if turning else sketch.diagram.pin
        held(*anchors, multiplier=True)
        if held == sketch.diagram.pin:
            for m in members:
                if m.anchor.turns:
                    sketch.node(m.anchor.rotation, GIVES)
        return
    flexible = [m for m in members if m.translation == EITHER]
    takers = [m for m in members if m.translation == TAKES]
    if not givers and not flexible:
        position = members[0].anchor.position
        givers = add_fitting(sketch, sketch.choose(["mass", "disc"]), position)
    elif flexible and (not givers or sketch.choose([False, False, True])):  # an end of a beam for a hub
        givers.append(flexible.pop())
    others = [[] for _ in givers]
    for member in [*takers, *flexible]:
        sketch.choose(others).append(member)
    hubs = [add_hub(sketch, giver, rest) for giver, rest in zip(givers, others, strict=True)]
    for hub in hubs[1:]:
        add_joint(sketch, hubs[0], hub)


# --- devices: on anything --------------------------------------------------------------------------------------------


def add_circuit(sketch, domain):
    """A reference, a node or two, and branches between them."""
    start = sketch.node(sketch.add(ph.Reference, domain).port, GIVES)
    nodes = [start]
    for i in range(sketch.choose([1, 2])):
        for _ in range(2 - i):
            kind = sketch.choose([ph.Resistor, ph.Inductor, ph.Capacitor])
            branch = sketch.add(kind, sketch.size(0.1, 10.0), domain=domain)
            nodes[-1].attach(branch.p, TAKES)
            if len(nodes) == i + 1:
                nodes.append(sketch.node(branch.n, EITHER))
            else:
                nodes[-1].attach(branch.n, EITHER)


def add_branch(kind, sketch):
    """A resistor or the like between two nodes of a circuit."""
    domain = sketch.choose(SCALARS)
    branch = sketch.add(kind, sketch.size(0.1, 10.0), domain=domain)
    sketch.attach(branch.p, TAKES)
    places = [n for n in sketch.places_for(domain, TAKES) if branch.p not in n.ports]
    if places:
        sketch.choose(places).attach(branch.n, TAKES)
    else:
        sketch.node(branch.n, EITHER)


def add_moving_support(sketch, domain):
    """The far end of a new spring, for a source to move."""
    if domain == ph.ROTATION:
        spring = sketch.add(ph.TorsionSpring, sketch.size(1.0, 1e3))
        near, far = spring.first, spring.second
    else:
        spring = sketch.add(ph.Spring, sketch.size(1.0, 1e4), sketch.rng.normal(size=2), 3.0 + sketch.rng.normal(size=2))
        near, far = spring.start.translation, spring.end.translation
    sketch.attach(near, TAKES)
    sketch.node(far, TAKES)


def add_source(kind, domain, role, sketch):
    """A source of a quantity, fixed in space or following what it acts on."""
    options = {}
    if domain is None:
        domain = options["domain"] = sketch.choose(SCALARS)
        if not sketch.places_for(domain, TAKES):
            add_circuit(sketch, domain)
    if kind is ph.Force:
        options["follows"] = sketch.choose([False, True])
    if role == GIVES and domain not in SCALARS and not sketch.places_for(domain, GIVES):
        add_moving_support(sketch, domain)  # all else has a velocity already
    sketch.attach(sketch.add(kind, sketch.signal(domain), **options).port, role, acts=role == TAKES)


def add_exposure(sketch):
    """An input without a signal of its own."""
    nodes = [n for n in sketch.nodes if not n.held]
    if nodes:
        node = sketch.choose(nodes)
        port = sketch.choose(node.ports)
        imposes = None
        if node.role != GIVES and sketch.choose([False, True]):
            imposes, node.role = node.domain.common.name, GIVES
        elif node.role == GIVES:
            imposes = node.domain.summed.name
        sketch.diagram.expose(port, sketch.name(f"input {len(sketch.diagram.network.exposed)}"), imposes)


def add_torsion(kind, sketch):
    options = {"twist": sketch.rng.uniform(-0.5, 0.5)} if kind is ph.TorsionSpring else {}
    torsion = sketch.add(kind, sketch.size(0.1, 100.0), **options)
    for port in (torsion.first, torsion.second):
        sketch.attach(port, TAKES)


def add_motor(sketch):
    motor = sketch.add(
        ph.DCMotor, sketch.size(0.1, 10.0), sketch.size(0.01, 1.0), inductance=sketch.choose([0.0, 0.1, 1e-3])
    )
    for port in (motor.p, motor.n, motor.shaft, motor.stator):
        sketch.attach(port, TAKES)


def add_transformer(sketch):
    """A gear, held by a constraint or driving something that may take."""
    domains = sketch.choose([(ph.ROTATION, ph.ROTATION), (ph.ELECTRICAL, ph.ROTATION), (MAGNETIC, ph.HYDRAULIC)])
    multiplier = sketch.choose([False, True])
    gear = sketch.add(ph.Transformer, -sketch.size(0.3, 3.0), *domains, multiplier=multiplier)
    sketch.attach(gear.first, TAKES)
    sketch.attach(gear.second, TAKES if multiplier else GIVES)


def add_gyrator(sketch):
    domains = sketch.choose([(ph.HYDRAULIC, ph.ROTATION), (ph.ELECTRICAL, MAGNETIC), (ph.ROTATION, ph.ELECTRICAL)])
    gyrator = sketch.add(ph.Gyrator, sketch.size(0.3, 3.0), *domains)
    role = sketch.choose([TAKES, TAKES, GIVES])
    sketch.attach(gyrator.first, role)
    sketch.attach(gyrator.second, role)


def typed_ports(sketch):
    """One or two ports of any domain and typing: ports by name, and the role of each."""
    ports, roles, columns = {}, {}, 0
    for i in range(sketch.choose([1, 2])):
        domain = sketch.choose([ph.TRANSLATION, ph.ROTATION, *SCALARS])
        count = 2 if domain == ph.TRANSLATION else 1
        roles[f"port{i}"] = role = sketch.choose([TAKES, TAKES, GIVES])
        gives = domain.common if role == GIVES else domain.summed
        ports[f"port{i}"] = ph.SystemPort(domain, range(columns, columns + count), gives.name)
        columns += count
    return ports, roles, columns


def skew(rng, n):
    A = rng.normal(size=(n, n))
    return A - A.T


def add_matrices(sketch):
    """A system in matrices, with or without feedthrough."""
    ports, roles, m = typed_ports(sketch)
    rng, n = sketch.rng, m + sketch.choose([0, 1])
    A, Q = rng.normal(size=(n, n)), np.eye(n) + 0.1 * np.diag(rng.uniform(size=n))
    options = {"E": np.linalg.solve(Q, A @ A.T + np.eye(n)), "Q": Q, "J": skew(rng, n), "G": rng.normal(size=(n, m))}
    if sketch.choose([False, True]):
        B = rng.normal(size=(n + m, n + m))
        loss = B @ B.T
        options |= {"R": loss[:n, :n], "P": loss[:n, n:], "S": loss[n:, n:], "N": skew(rng, m)}
    block = sketch.add(ph.SystemBlock, **options, ports=ports, start=0.1 * rng.normal(size=n))
    for name, role in roles.items():
        sketch.attach(block[name], role)


def add_energy(sketch):
    """A block with an energy that is not quadratic."""
    ports, roles, m = typed_ports(sketch)
    rng, n = sketch.rng, m + sketch.choose([0, 1])
    x = sympy.symbols(f"x:{n}")
    square = sum(xi**2 for xi in x)
    H = sketch.choose([square / 2 + square**2 / 4, sympy.sqrt(1 + square), sum(sympy.cosh(xi) for xi in x)])
    J, G = skew(rng, n), rng.normal(size=(n, m))
    R = sketch.choose([np.zeros((n, n)), 0.1 * np.eye(n)])
    name = sketch.name("CustomBlock")
    start = 0.1 * rng.normal(size=n)
    block = sketch.diagram.add(ph.CustomBlock.from_sympy(name, H, x, J=J, R=R, G=G, ports=ports, start=start))
    for port, role in roles.items():
        sketch.attach(block[port], role)


DEVICES = [
    partial(add_source, ph.Force, ph.TRANSLATION, TAKES),
    partial(add_source, ph.Moment, ph.ROTATION, TAKES),
    partial(add_source, ph.Velocity, ph.TRANSLATION, GIVES),
    partial(add_source, ph.AngularVelocity, ph.ROTATION, GIVES),
    partial(add_source, ph.Voltage, None, GIVES),
    partial(add_source, ph.Current, None, TAKES),
    *(partial(add_torsion, kind) for kind in (ph.TorsionSpring, ph.TorsionDamper)),
    *(partial(add_branch, kind) for kind in (ph.Resistor, ph.Inductor, ph.Capacitor)),
    add_exposure,
    add_motor,
    add_transformer,
    add_gyrator,
    add_matrices,
    add_energy,
]


# --- the whole -------------------------------------------------------------------------------------------------------


def commit(sketch):
    """Join the ports of all nodes: with the verbs for anchors where those meet, others with connect, or not at all."""
    d = sketch.diagram
    joined = [node for node in sketch.nodes if len(node.ports) > 1]
    turning = {frozenset(p.anchor for p in n.ports): n for n in joined if n.domain == ph.ROTATION}
    welded = []
    for node in joined:
        anchors = [p.anchor for p in node.ports]
        if node.domain == ph.TRANSLATION and meet(anchors):
            twin = turning.get(frozenset(anchors))
            welded.append(twin)
            (d.pin if twin is None else d.weld)(*anchors)
        elif node.domain != ph.ROTATION:
            d.connect(*node.ports)
    for node in joined:
        if node.domain == ph.ROTATION and node not in welded:
            d.connect(*node.ports)
    exposed = [e.port for e in d.network.exposures()]
    for node in sketch.nodes:
        port = node.ports[0]
        alone = len(node.ports) == 1 and node.role != TAKES and not port.block.shared and port not in exposed
        if alone and sketch.choose([False, False, True]):
            d.free(port)


def meet(anchors):
    """Whether anchors are in one place, or wherever they are needed."""
    if None in anchors:
        return False
    places = [a.position for a in anchors if a.position is not None]
    return all(np.allclose(place, places[0], rtol=0.0, atol=1e-12) for place in places)


def grow(draw, diagram):
    """Draw a mechanism with its devices into a diagram."""
    sketch = Sketch(draw, np.random.default_rng(draw(st.integers(0, 2**32 - 1))), diagram)
    places = [np.zeros(2)]
    for step in draw(st.lists(st.sampled_from(STEPS), min_size=1, max_size=3)):
        places.append(places[-1] + (sketch.rng.normal(size=2) if step is None else step))
    pairs = [(i, i + 1) for i in range(len(places) - 1)]
    for _ in range(draw(st.integers(0, 2))):  # loops
        pairs.append((0, len(places) - 1))
    fittings = [sketch.choose(["ground", "nothing", "disc", "mass"])]
    fittings += [sketch.choose(["nothing", "disc", "mass", "nothing", "ground"]) for _ in places[1:]]
    meeting = [[] for _ in places]
    for a, b in pairs:
        if np.hypot(*(places[b] - places[a])) > 0.05:
            ends = sketch.choose(LINKS)(sketch, places[a], places[b], (fittings[a], fittings[b]))
            for place, member in zip((a, b), ends, strict=True):
                meeting[place].append(member)
    for place, what, members in zip(places, fittings, meeting, strict=True):
        members += add_fitting(sketch, what, place)
        if members:
            join(sketch, members)
    for device in draw(st.lists(st.sampled_from(DEVICES), min_size=2, max_size=6)):
        device(sketch)
    commit(sketch)
    return sketch


@st.composite
def diagrams(draw):
    """A diagram as it is, or nested in another one, once or twice."""
    gravity = draw(st.sampled_from([None, (0.0, -9.81), (3.0, 1.0)]))
    copies = draw(st.sampled_from([0, 0, 0, 1, 2]))
    d = ph.Diagram("random", gravity=gravity)
    sketch = grow(draw, d)
    if copies == 0:
        return d
    outer = ph.Diagram("outer", gravity=gravity)
    twins = [outer.add(d, name) for name in ("left", "right")[:copies]]
    spare = [n.ports[0] for n in sketch.nodes if n.domain == ph.ROTATION and n.role != TAKES and len(n.ports) == 1]
    spare = [p for p in spare if not p.block.shared and p not in d.network.junction_of]
    if spare and copies == 2:
        torsion = outer.add(ph.TorsionSpring("between", 10.0))
        port = draw(st.sampled_from(spare))
        for twin, side in zip(twins, (torsion.first, torsion.second), strict=True):
            outer.connect(twin[port.block].ports[port.name], side)
    return outer
