"""The power ledger: every block and every connection balances."""

import numpy as np
import pytest


def test_every_block_balances(solution):
    scale = max(1.0, np.abs(solution.energy.total).max(), np.abs(solution.energy.supplied).max())
    for row in solution.power.blocks.values():
        residual = row["stored"] + row["gravity"] - row["received"] - row["supplied"] + row["dissipated"]
        assert all(series.shape == solution.t.shape for series in row.values())
        np.testing.assert_allclose(residual, 0.0, atol=1e-11 * scale)
        assert row["stored"][0] == row["received"][0] == row["gravity"][0] == 0.0


def test_connections_pass_on_what_they_get(solution):
    """What blocks receive from each other adds up to nothing, and each block's share is that of its connections."""
    ledger, blocks = solution.power.connections, solution.power.blocks
    assert set(ledger) == set(solution.system.connections.names)
    scale = max([1.0, *(np.abs(series).max() for series in ledger.values())])
    np.testing.assert_allclose(sum(row["received"] for row in blocks.values()), 0.0, atol=1e-12 * scale)
    for name, row in blocks.items():
        own = np.zeros_like(solution.t)
        for (giver, taker), series in ledger.items():
            own += series * ((taker.split(".")[0] == name) - (giver.split(".")[0] == name) * 1.0)
        np.testing.assert_allclose(row["received"], own, atol=1e-12 * scale)


def test_blocks_add_up_to_the_whole(solution):
    blocks, energy = solution.power.blocks.values(), solution.energy
    scale = max(1.0, np.abs(energy.total).max())
    stored = sum(row["stored"] for row in blocks)
    np.testing.assert_allclose(stored, energy.kinetic + energy.strain - energy.total[0], atol=1e-11 * scale)
    np.testing.assert_allclose(sum(row["gravity"] for row in blocks), energy.gravity, atol=1e-11 * scale)
    np.testing.assert_allclose(sum(row["supplied"] for row in blocks), energy.supplied, atol=1e-11 * scale)
    np.testing.assert_allclose(
        sum(solution.power.inputs.values(), 0.0 * solution.t), energy.supplied, atol=1e-11 * scale
    )
    assert tuple(solution.power.inputs) == solution.system.input_names


def test_energy_flows_through_the_joints_that_are_there(solutions):
    power = solutions["four-bar"].power
    assert set(power.blocks) == {"ground", "crank", "coupler", "rocker"}
    assert all(np.abs(series).max() > 1.0 for series in power.connections.values())  # the coupler drives both bars
    assert not any(np.abs(series).any() for series in power.blocks["ground"].values())


def test_the_worst_residual_is_named(solution):
    power = solution.power
    name, value = power.worst
    named = {**power.block_errors, **{" -> ".join(pair): e for pair, e in power.connection_errors.items()}}
    assert value == max(named.values()) == named[name]
    scale = max(1.0, np.abs(solution.energy.total).max())
    assert value <= 1e-12 * scale


def test_the_ledger_prints_one_line_a_block(solutions):
    lines = str(solutions["four-bar"].power).splitlines()
    assert lines[0].split() == ["block", "stored", "gravity", "received", "supplied", "dissipated", "worst", "step"]
    assert [line.split()[0] for line in lines[1:]] == ["ground", "crank", "coupler", "rocker"]
    crank = solutions["four-bar"].power.blocks["crank"]
    assert float(lines[2].split()[1]) == pytest.approx(crank["stored"][-1], rel=1e-4)
