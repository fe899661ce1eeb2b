"""The diagram as data: junctions, exposures, the bipartite graph, and where the user's code called."""

import inspect

import networkx as nx
import pytest

import phblocks as ph
from phblocks.network import Network, call_site


@pytest.fixture
def frame(bar) -> tuple[ph.Diagram, ph.Beam, ph.Beam]:
    """Two beams: the first welded to the ground, the second pinned to the first, its end free."""
    d = ph.Diagram("frame")
    a = d.add(ph.Beam("a", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    b = d.add(ph.Beam("b", bar, (1.0, 0.0), (1.0, 1.0), elements=2))
    d.weld(a.start, d.ground)
    d.pin(a.end, b.start)
    return d, a, b


def test_junctions_made_come_first_and_every_lonely_port_is_one_of_its_own(frame):
    d, _, _ = frame
    junctions = d.network.junctions()
    assert [j.name for j in junctions] == [
        "a.start.translation = ground.anchor.translation",
        "a.start.rotation = ground.anchor.rotation",
        "a.end.translation = b.start.translation",
        "a.end.rotation",
        "b.start.rotation",
        "b.end.translation",
        "b.end.rotation",
    ]
    assert all(j.made_by.startswith("not joined; add at test_network.py:") for j in junctions[3:])
    assert [j.domain.name for j in junctions[:2]] == ["translation", "rotation"]


def test_each_port_is_in_one_junction_but_the_grounds(frame):
    d, a, b = frame
    ports = [p for j in d.network.junctions() for p in j.ports if not p.block.shared]
    assert len(ports) == len(set(ports)) == 8
    assert set(ports) == {*a.ports.values(), *b.ports.values()}


def test_a_port_is_exposed_with_its_junction_whatever_comes_first(bar):
    names = []
    for early in (True, False):
        d = ph.Diagram()
        a = d.add(ph.Beam("a", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
        b = d.add(ph.Beam("b", bar, (1.0, 0.0), (1.0, 1.0), elements=2))
        if early:
            d.expose(b.start.translation, "load")
        d.pin(a.end, b.start)
        if not early:
            d.expose(b.start.translation, "load")
        names.append(d.network.junctions()[0].name)
    assert names == ["a.end.translation = b.start.translation = outside 'load'"] * 2


def test_the_graph_joins_blocks_to_junctions(frame):
    d, a, b = frame
    graph = d.graph
    assert nx.is_bipartite(graph) and nx.is_connected(graph)
    assert set(graph) == {"ground", "a", "b", ".junction 0", ".junction 1", ".junction 2"}
    assert graph.nodes["a"]["block"] is a
    assert graph.nodes[".junction 2"]["junction"].ports == (a.end.translation, b.start.translation)
    assert graph.edges[".junction 2", "b", "b.start.translation"]["port"] is b.start.translation
    assert sorted(graph.neighbors("ground")) == [".junction 0", ".junction 1"]


def test_the_graph_of_an_unjoined_diagram_has_no_edges(bar):
    d = ph.Diagram("heap")
    d.add(ph.Beam("a", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    assert d.graph.number_of_edges() == 0 and d.graph.graph["name"] == "heap"


def test_a_junction_knows_the_line_of_the_user_that_made_it(bar):
    d = ph.Diagram()
    a = d.add(ph.Beam("a", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    here = inspect.currentframe()
    assert here is not None
    line = here.f_lineno + 1
    d.weld(a.start, d.ground)
    assert isinstance(d.network, Network)
    assert [j.made_by for j in d.network.joined] == [f"weld at test_network.py:{line}"] * 2


def test_the_call_site_is_the_innermost_frame_outside_the_package():
    assert call_site().startswith("test_network.py:")
