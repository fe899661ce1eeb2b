"""Devices that can be attached to anything: sources, springs and gears between shafts, circuits, users' matrices."""

from functools import partial

import numpy as np
import sympy

import phblocks as ph
from tests.properties.sketch import EITHER, GIVES, MAGNETIC, SCALARS, TAKES, add_circuit


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
        spring = sketch.add(
            ph.Spring, sketch.size(1.0, 1e4), sketch.rng.normal(size=2), 3.0 + sketch.rng.normal(size=2)
        )
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
    """A gear, held by a constraint or driving something that may take; or a lever, or a rack and its pinion."""
    kind = sketch.choose(["gear", "gear", "lever", "rack"])
    if kind == "lever":
        matrix = sketch.choose([-0.5, [[0.3, 1.0], [-2.0, 0.4]]])
        lever = sketch.add(ph.Transformer, matrix, ph.TRANSLATION, ph.TRANSLATION, multiplier=True)
        sketch.attach(lever.first, TAKES)
        sketch.attach(lever.second, TAKES)
        return
    if kind == "rack":
        along = tuple(sketch.rng.normal(size=2))
        rack = sketch.add(ph.Transformer, 0.3, ph.ROTATION, ph.TRANSLATION, multiplier=True, second_direction=along)
        sketch.attach(rack.first, TAKES)
        sketch.attach(rack.second, TAKES)
        return
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


def matrices_of_state(sketch, n, m, x):
    """J, R, G and perhaps P, S, N, each constant, a function of the state or a sympy matrix: ``A + B sin(x[k])``."""
    rng, k = sketch.rng, int(sketch.rng.integers(n))
    root, some = rng.normal(size=(n + m, n + m)), rng.uniform(0.0, 0.9, n + m)
    loss, part = root @ root.T, (root * some) @ root.T  # loss + part sin(x) is definite
    inner, outer = slice(n), slice(n, None)
    pairs = [
        {"J": (skew(rng, n), skew(rng, n))},
        {"G": (rng.normal(size=(n, m)), 0.5 * rng.normal(size=(n, m)))},
    ]
    blocks = {"R": (inner, inner)}
    if sketch.choose([False, True]):
        blocks |= {"P": (inner, outer), "S": (outer, outer)}
        pairs.append({"N": (skew(rng, m), skew(rng, m))})
    if len(blocks) == 3 or sketch.choose([False, True]):
        pairs.append({letter: (loss[at], part[at]) for letter, at in blocks.items()})

    def varying(A, B):
        return lambda x: A + B * np.sin(x[k])

    made = {}
    for together in pairs:
        kind = sketch.choose(["constant", "function", "expression"])
        for letter, (A, B) in together.items():
            if kind == "expression":
                made[letter] = sympy.Matrix(A) + sympy.sin(x[k]) * sympy.Matrix(B)
            else:
                made[letter] = A if kind == "constant" else varying(A, B)
    return made


def add_energy(sketch):
    """A block with an energy that is not quadratic, and matrices that depend on the state."""
    ports, roles, m = typed_ports(sketch)
    rng, n = sketch.rng, m + sketch.choose([0, 1])
    x = sympy.symbols(f"x:{n}")
    square = sum(xi**2 for xi in x)
    H = sketch.choose([square / 2 + square**2 / 4, sympy.sqrt(1 + square), sum(sympy.cosh(xi) for xi in x)])
    options = matrices_of_state(sketch, n, m, x)
    name = sketch.name("CustomBlock")
    start = 0.1 * rng.normal(size=n)
    block = sketch.diagram.add(ph.CustomBlock.from_sympy(name, H, x, **options, ports=ports, start=start))
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
