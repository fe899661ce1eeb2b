"""The power ledger: every block and every connection balances."""

from dataclasses import replace

import numpy as np
import pytest

import phblocks as ph


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


def sprung():
    """A beam on a spring and a pin, with a damper: ports that point along lines."""
    section = ph.Section(axial=3e4, shear=1e4, bending=50.0, mass=1.2, rotary=3e-3)
    d = ph.Diagram("sprung", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.2), elements=3, degree=2))
    spring = d.add(ph.Spring("spring", 200.0, (0.9, 1.0), (1.0, 0.2)))
    damper = d.add(ph.Damper("damper", 3.0, (1.5, 0.0), (1.0, 0.2)))
    d.pin(beam.start, d.ground)
    d.pin(spring.start, d.ground)
    d.pin(damper.start, d.ground)
    d.pin(beam.end, spring.end, damper.end)
    return d


@pytest.fixture
def diagram(scenes, name):
    return sprung() if name == "sprung" else scenes[name]


SCENES = ("sprung", "four-bar", "frame", "free")


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("version", ["whole", "pruned", "small motions"])
def test_ports_say_what_matrices_say(diagram, version):
    """Force times velocity at the ports, in the stages of all steps; also without orientations, also for small ones."""
    system = diagram.compile(outputs=None) if version == "pruned" else diagram.compile()
    system = system.small_motions() if version == "small motions" else system
    inputs = {i.exposure: (3.0, -2.0) for i in system.inputs}
    power = ph.simulate(system, 0.3, 0.01, start=system.rigid_motion(spin=1.0), inputs=inputs).power
    largest = max(np.abs(series).max() for series in power.connections.values())
    assert largest > 1e-4
    assert max(power.connection_errors.values()) <= 1e-13 * max(largest, 1.0)


@pytest.mark.parametrize("name", SCENES)
def test_wrong_books_are_noticed_at_the_junction(diagram, scale=1.0 + 1e-6):
    """Books that are wrong by a millionth, one connection after the other."""
    system = diagram.compile()
    inputs = {i.exposure: (3.0, -2.0) for i in system.inputs}
    books = system.connections
    start = system.rigid_motion(spin=1.0)
    for number, names in enumerate(books.names):
        entries = books.entries.scaled(np.where(books.number == number, scale, 1.0))
        wrong = replace(system, connections=replace(books, entries=entries))
        errors = ph.simulate(wrong, 0.3, 0.01, start=start, inputs=inputs).power.connection_errors
        assert errors[names] > 1e-10
        assert all(error < 1e-13 for other, error in errors.items() if other != names)
