"""The benchmark scripts run; what they measure is in docs/performance.md and docs/accuracy.md, not asserted here."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import phblocks as ph
from tests.benchmarks import compilation, effects, health, import_time, multipliers, newton_iteration, tables


def test_an_iteration_is_measured():
    pytest.importorskip("numba")
    unknowns, width, ours, theirs = newton_iteration.measure((2, 2, 2), rounds=1)
    assert unknowns == ph.Midpoint().prepare(newton_iteration.build(elements=(2, 2, 2))[0].compile()).stage.n
    assert width <= 8 and min(ours) > 0.0 and theirs > 0.0


def test_a_linear_step_is_measured():
    pytest.importorskip("numba")
    unknowns, width, ours, theirs = newton_iteration.measure_linear((2, 2, 2), rounds=1)
    assert unknowns == newton_iteration.measure((2, 2, 2), rounds=1)[0]
    assert width <= 9 and min(ours) > 0.0 and theirs > 0.0


def test_both_codes_swing_the_same_pendulum(tmp_path):
    """Tiny settings of both: they agree on the tip within 1 cm, ours keeps its energy, and it is drawn."""
    pytest.importorskip("exudyn")
    from tests.benchmarks import accuracy, accuracy_figures
    from tests.benchmarks.accuracy_scenes import Sweep, radau, scenes

    scene = replace(
        next(s for s in scenes() if s.name == "rubber_pendulum"),
        ours=[
            Sweep("Midpoint", [{"elements": 4, "degree": 2}], [0.01, 0.005], ph.Midpoint()),
            radau({"elements": 2, "degree": 2}, [1e-2, 1e-3]),
        ],
        peer=[Sweep("Exudyn", [{"elements": 5, "order": 2}], [0.01, 0.005])],
    )
    reference = ph.studies.Reference(scene.published, scene.published_uncertainty, "published")
    result = accuracy.study(scene, 1, reference)
    assert len(result) == 6 and max(result.filter(lambda row: not row.rtol).column("error")) < 1e-2
    scipys = result.filter(lambda row: row.rtol > 0.0)
    assert scipys.column("rtol") == [1e-2, 1e-3] and scipys[1].steps > scipys[0].steps
    assert scipys[0].energy_error > scipys[1].energy_error > 1e-8
    assert {row.method for row in scipys} == {"SciPy's Radau, our system"}
    assert [cells[-1] for cells in map(accuracy.setting_cells, scipys)] == ["rtol 0.01", "rtol 0.001"]
    assert max(row.energy_error for row in result.filter(accuracy.of_ours)) < 1e-12
    # second order of generalised-alpha: half the step, a quarter of the drift, if the energy is that of Exudyn's beam
    coarse, fine = result.filter(accuracy.of_peer).sort("dt", reverse=True).column("energy_error")
    assert coarse / fine > 3.0
    table = accuracy.target_table({name: result for name, _ in accuracy.TARGETS})
    assert len(table.splitlines()) == 2 + len(accuracy.TARGETS)
    assert "Exudyn" in accuracy.front_table(result)
    assert len(accuracy.target_table({}).splitlines()) == 2
    result.to_csv(tmp_path / "accuracy_rubber_pendulum.csv")
    assert accuracy.earlier(tmp_path)["rubber_pendulum"].column("seconds") == result.column("seconds")
    figure = tmp_path / "figure.png"
    accuracy_figures.draw(result, scene.title, figure, accuracy.of_ours, accuracy.of_peer)
    assert 0 < figure.stat().st_size < 150_000
    orders = accuracy.orders_table((0.02, 0.01), 0.005).splitlines()
    assert len(orders) == 7 and orders[2].startswith("| Midpoint | 2 | 6.") and "(2." in orders[2]
    assert "Exudyn" in accuracy.large_table(4, 2, 1) and "exponent" in accuracy.growth_table((4, 8), 1)


def test_cheap_runs_and_those_near_the_front_are_repeated():
    pytest.importorskip("exudyn")
    from tests.benchmarks import accuracy

    runs = [(1.0, 1e-2), (2.0, 1e-3), (1.2, 1e-2), (2.5, 2e-3), (2.7, 1.5e-3), (0.2, 1e-1), (0.29, 2e-1)]
    runners = [
        SimpleNamespace(measured=SimpleNamespace(seconds=[s], value=np.array([[e, 0.0]])), name=(s, e)) for s, e in runs
    ]
    reference = ph.studies.Reference([[0.0, 0.0]])
    front = runs[:4] + runs[5:6]
    for k, expected in ((1, [*front, runs[6]]), (3, front)):
        assert [r.name for r in accuracy.worth_repeating(runners, reference, k)] == expected


def test_diagrams_are_made():
    for make in (compilation.chain, compilation.truss):
        d = make(8)
        assert len(d.network.blocks) == 9 and d.check().ok


def test_finding_effects_is_measured():
    states, check, whole, part = compilation.measure(compilation.chain, 8, rounds=1)
    assert states == 8 * 15 and check > 0.0 and 0.0 < part < whole


def test_pruned_runs_are_measured():
    for make in effects.SCENES.values():
        unknowns, times = effects.measure(make, 4, steps=5, rounds=1)
        assert 0 < unknowns[0] < unknowns[1] and min(times) > 0.0


def test_multipliers_are_measured():
    parts = multipliers.measure(None, ph.Midpoint(), 1e-4, 60)
    assert list(parts) == ["N1", "N2"] and all(0.0 < last < size for size, _, last in parts.values())


def test_linear_runs_are_measured():
    unknowns, (full, loop), (step, solve) = effects.measure_linear(lambda: effects.cantilever(2), steps=5, rounds=1)
    assert unknowns == 20 and min(full, loop, step, solve) > 0.0


def test_imports_are_measured():
    base, [(nothing, ratio), (first, _)] = import_time.measure(["import phblocks", "import phblocks; phblocks.Beam"], 1)
    assert 0.0 < nothing < first and base > 0.0 and ratio == pytest.approx(nothing / base)


def test_tables_are_markdown():
    assert tables.markdown(["a", "b"], [["1", "2"]]).splitlines() == ["| a | b |", "| --- | --- |", "| 1 | 2 |"]


def test_watching_is_measured():
    system = compilation.chain(2).compile()
    step, sums, first, end = health.measure(system, 30, 0.002, rounds=2)
    assert step > 0.0 and sums > 0.0 and first > 0.0 and end > 0.0
