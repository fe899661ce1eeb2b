"""system.effects: what it says, selection, and that it survives a worker process."""

import itertools
import pickle

import pytest

import phblocks as ph
from phblocks.effects import Effect, EffectsReport
from phblocks.errors import DataError
from tests.effects.test_pruning import pulled


def test_the_proof_names_pattern_and_excitation():
    effects = pulled()[0].compile().effects
    (kept,), (gone,) = effects.select(block="bar", name="N1"), effects.select(block="bar", name="M3")
    assert kept == Effect("bar", "N1", "kept", 9, "N1 of 'bar' <- V1 of 'bar' <- force 'F.x' (constant)")
    assert gone == Effect("bar", "M3", "pruned", 9, "no path from: force 'F.x' (constant)")


def test_a_product_names_its_other_factor():
    d, _ = pulled(force=(0.0, 1.0))
    (n1,) = d.compile().effects.select(block="bar", name="N1")
    assert n1.reason.endswith("<- force 'F.y' (constant)") and "(times " in n1.reason


def test_exposed_driven_and_started():
    d, bar = pulled(force=lambda t: (t, 0.0))
    d.expose(bar.end.rotation, "twist")
    said = {e.reason.split(" <- ")[-1] for e in d.compile().effects.select(block="bar", status="kept")}
    assert "force 'F.x' (a function of time)" in said and "moment 'twist' (exposed)" in said


def test_selection_and_table():
    effects = pulled()[0].compile().effects
    assert isinstance(effects[:2], EffectsReport) and len(effects[:2]) == 2
    assert [e.name for e in effects.select(block="bar", status="pruned")] == ["V2", "W3", "N2", "M3", "orientation"]
    assert [e.name for e in effects.select(block="")] == ["nonlinearity"]
    table = str(effects).splitlines()
    assert table[0].split() == ["block", "effect", "status", "states", "reason"] and len(table) == len(effects) + 2
    assert repr(effects) == str(effects)
    with pytest.raises(DataError, match="effects status: expected one of kept, pruned, approximated, got 'gone'"):
        effects.select(status="gone")
    more = effects.joined([Effect("bar", "shear", "approximated", 8, "asked for")])
    assert len(more) == len(effects) + 1 and more[-1].status == "approximated"


def test_it_can_be_sent_to_a_worker():
    effects = pulled()[0].compile().effects
    assert list(pickle.loads(pickle.dumps(effects))) == list(effects)


def test_long_ways_are_shortened():
    d = ph.Diagram("chain")
    section = ph.Section.rectangle(0.1, 0.1, 1e9, 0.3, 1e3)
    beams = [d.add(ph.Beam(f"b{i}", section, (i, 0), (i + 1, 0), 1)) for i in range(6)]
    for a, b in itertools.pairwise(beams):
        d.pin(a.end, b.start)
    d.pin(d.ground, beams[0].start)
    d.expose(beams[-1].end.translation, "tip")
    (far,) = d.compile().effects.select(block="b0", name="V1")
    assert " <- ... <- force 'tip." in far.reason and len(far.reason.split(" <- ")) <= 8


def test_unknown_blocks_and_effects_are_refused():
    effects = pulled()[0].compile().effects
    for wrong in ({"block": "baz"}, {"name": "V5"}):
        with pytest.raises(ph.errors.UnknownNameError, match="effects"):
            effects.select(**wrong)


def test_orientations_are_counted_as_kept(bar):
    """Joints of a four-bar need the angles of six ends, pinned to each other and to the ground: not 15 angles."""
    d = ph.Diagram("four-bar")
    places = [(0.0, 0.5), (2.0, 1.5), (3.5, 1.5), (2.5, 0.5)]
    bars = [d.add(ph.Beam(n, bar, p, q, 4)) for n, p, q in zip("abc", places, places[1:], strict=False)]
    for first, second in zip([d.ground, *(b.end for b in bars)], [*(b.start for b in bars), d.ground], strict=True):
        d.pin(first, second)
    d.expose(bars[0].start.rotation, "moment")
    system = d.compile(outputs=None)
    kept = sum(e.states for e in system.effects.select(name="orientation", status="kept"))
    assert kept == len(system.theta_names) < 15
