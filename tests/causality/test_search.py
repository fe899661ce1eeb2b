"""The choice of teams where there are too many ports for a proof, against the proven one where there are not."""

import random

import pytest

import phblocks as ph
from phblocks.causality import program

SECTION = ph.Section(axial=3e4, shear=1e4, bending=50.0, mass=1.2, rotary=3e-3)


def grid(n: int, kind: str, seed: int = 0) -> ph.Diagram:
    """A square grid of beams, held at two corners; nodes are pinned, welded, or welded in part."""
    draw = random.Random(seed)
    d = ph.Diagram("grid")
    at: dict[tuple[int, int], list[ph.Anchor]] = {}
    for i in range(n):
        for j in range(n):
            for end in ((i + 1, j), (i, j + 1)):
                if max(end) < n and (kind != "sparse" or draw.random() < 0.8):
                    beam = d.add(ph.Beam(f"{i},{j}-{end[0]},{end[1]}", SECTION, (i, j), end, elements=2))
                    at.setdefault((i, j), []).append(beam.start)
                    at.setdefault(end, []).append(beam.end)
    for place, anchors in at.items():
        joined = [*anchors, d.ground] if place in ((0, 0), (0, n - 1)) else anchors
        if len(joined) < 2:
            continue
        if d.ground in joined or kind == "pinned":
            d.pin(*joined)
        elif kind == "mixed":
            (d.weld if draw.random() < 0.5 else d.pin)(*joined)
        else:
            d.connect(*[a.translation for a in joined])
            d.connect(*[a.rotation for a in joined[:2]])
    return d


def cost(report: ph.CausalityReport) -> float:
    return len(report.switches) - program.SAVING * sum(len(team) - 1 for team in report.shared)


@pytest.mark.parametrize("kind", ["half", "mixed", "sparse"])
@pytest.mark.parametrize("seed", range(4))
def test_close_to_the_proven_choice(monkeypatch, kind, seed):
    d = grid(4, kind, seed)
    proven = d.check()
    monkeypatch.setattr(program, "PROVEN", 0)
    found = d.check()
    assert found.ok and proven.ok
    assert cost(proven) - 1e-9 <= cost(found) <= cost(proven) + 2.0
    d.compile()


@pytest.mark.parametrize("kind", ["half", "mixed"])
def test_a_thousand_beams_have_hardly_any_switches(kind):
    """Seconds for all of this file: without the search, one of these took minutes."""
    report = grid(23, kind).check()
    assert report.ok and len(report.switches) <= 5 and len(report.shared) > 400
    chosen = [a for a in report.assignments if a.port.path == "11,11-12,11.start.translation"]
    assert chosen and "cheapest" in report.explain("11,11-12,11.start.translation")


def test_the_search_does_not_depend_on_the_order_of_adding(monkeypatch):
    monkeypatch.setattr(program, "PROVEN", 0)
    d = grid(4, "half")
    blocks = [b for b in d.network.blocks.values() if not b.shared]
    other = ph.Diagram("grid")
    for block in reversed(blocks):
        other.add(block)
    for junction in reversed(d.network.joined):
        other.connect(*[other.ground.translation if p.block.shared else p for p in reversed(junction.ports)])
    assert {a.port.path: a.gives for a in d.check().assignments} == {
        a.port.path: a.gives for a in other.check().assignments
    }
