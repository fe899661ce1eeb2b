"""A diagram while it is drawn: nodes, each a list of ports to be joined, so that anything can be attached anywhere.

The structure is drawn by hypothesis and so can be shrunk; the numbers come from a seed.
"""

from dataclasses import dataclass, field

import numpy as np
from hypothesis import strategies as st

import phblocks as ph

MAGNETIC = ph.Domain("magnetic", ph.Quantity("magnetomotive force", "A"), ph.Quantity("flux rate", "V"))
SCALARS = (ph.ELECTRICAL, ph.HYDRAULIC, MAGNETIC)
#: What a port does with the common quantity of its domain, such as velocity.
GIVES, TAKES, EITHER = "gives", "takes", "either"


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
        return any(p.block.shared or any(e.gives for e in p.block.exposures()) for p in self.ports)

    def attach(self, port, role=TAKES):
        self.ports.append(port)
        if role == GIVES or self.role == TAKES:
            self.role = role


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
