"""The benchmark scripts run; what they measure is in docs/performance.md, not asserted here."""

import phblocks as ph
from tests.benchmarks import compilation, newton_iteration, tables


def test_an_iteration_is_measured():
    unknowns, width, ours, theirs = newton_iteration.measure((2, 2, 2), rounds=1)
    assert unknowns == ph.Midpoint().prepare(newton_iteration.build(elements=(2, 2, 2))[0].compile()).stage.n
    assert width <= 8 and ours > 0.0 and theirs > 0.0


def test_diagrams_are_made():
    for make in (compilation.chain, compilation.truss):
        d = make(8)
        assert len(d.network.blocks) == 9 and d.check().ok


def test_tables_are_markdown():
    assert tables.markdown(["a", "b"], [["1", "2"]]).splitlines() == ["| a | b |", "| --- | --- |", "| 1 | 2 |"]
