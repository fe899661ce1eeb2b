"""Random planar diagrams of every block: what a diagram can be.

A diagram grows in four steps. *Links* join places in the plane, and each place gets a *fitting* that the links meet
at. Then what meets is put together: parts that give velocity are held together by *joints*, all others go to one of
them (``mechanisms``). Last come ``devices``. What was drawn may be nested in another diagram, once or twice.
"""

import numpy as np
from hypothesis import strategies as st

import phblocks as ph
from tests.properties.devices import DEVICES
from tests.properties.mechanisms import LINKS, add_fitting, join
from tests.properties.sketch import TAKES, Sketch

STEPS = [(1.0, 0.0), (0.0, 1.0), (0.6, -0.3), (-0.5, 0.8), (0.2, 0.1), None]


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
            d.connect(*node.ports, apart=True)
    for node in joined:
        if node.domain == ph.ROTATION and node not in welded:
            d.connect(*node.ports, apart=True)
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
    if spare:
        torsion = outer.add(ph.TorsionSpring("between", 10.0))
        port = draw(st.sampled_from(spare))
        ends = [twin[port.block].ports[port.name] for twin in twins]
        outer.connect(torsion.first, ends[0])
        outer.connect(torsion.second, ends[1] if copies == 2 else outer.ground.rotation)
    return outer
