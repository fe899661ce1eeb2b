"""Mechanisms: links from place to place, what a place is fitted with, and the joints between what meets there."""

from dataclasses import dataclass
from functools import partial

import numpy as np

import phblocks as ph
from tests.properties.sketch import EITHER, GIVES, TAKES

#: Translation and rotation of an end of a beam whose causality is fixed.
ENDS = {"free": (GIVES, GIVES), "pinned": (TAKES, GIVES), "clamped": (TAKES, TAKES), "guided": (GIVES, TAKES)}


@dataclass
class Member:
    """An anchor that meets others at a place: the roles of its translation and of its rotation."""

    anchor: ph.Anchor
    translation: str
    rotation: str


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
    places = [p.anchor.position for p in first[0].ports if p.anchor is not None and p.anchor.position is not None]
    guided = ["guide", "slot"] if places else []
    kind = sketch.choose(["pin", "slider", *(["weld", "rail", "bushing", *guided] if turning else [])])
    if kind == "bushing":
        stiffness = np.array([[3e3, 2e2, 10.0], [2e2, 2e3, 5.0], [10.0, 5.0, 40.0]]) * sketch.size(0.1, 100.0)
        damping = sketch.choose([None, np.diag([1.0, 0.0, 0.1]), stiffness * 1e-3])
        joint = sketch.add(ph.Bushing, stiffness, damping, angle=sketch.rng.uniform(-3.0, 3.0))
        ports = [anchor.ports for anchor in (joint.first, joint.second)]
    elif kind in ("guide", "slot"):  # a slider on a guide that turns with the first side
        along, turns = tuple(sketch.rng.normal(size=2)), kind == "slot"
        joint = sketch.add(ph.Slider, along, turns=turns, guide="first", start=places[0], end=places[0])
        ports = [[joint.first, joint.first_rotation], [joint.second, *([] if turns else [joint.second_rotation])]]
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
