"""What is kept of a run, recomputed independently from the states."""

import dataclasses
import itertools

import numpy as np
import pytest
import scipy.sparse as sp


def middles(solution):
    """Midpoint states, orientations and steps, from the ends of the steps."""
    x, theta, t = solution.x, solution.recording.theta, solution.t
    return 0.5 * (x[1:] + x[:-1]), 0.5 * (theta[1:] + theta[:-1]), np.diff(t)


def inputs(solution) -> np.ndarray:
    """What was imposed in each step."""
    return np.diff(solution.recording.input_integral, axis=0) / np.diff(solution.t)[:, None]


def test_stored_energy_by_block_and_kind(solution):
    system, stored = solution.system, solution.recording.ledger.stored
    assert stored.shape == (solution.t.size, len(system.parts), 2)
    E = system.E.toarray()
    kinetic = np.array([unit in ("m/s", "rad/s") for unit in system.state_units])
    for b, part in enumerate(system.parts):
        for kind, states in enumerate((kinetic, ~kinetic)):
            own = np.zeros(system.n, dtype=bool)
            own[part.states] = True
            x = np.where(own & states, solution.x, 0.0)
            np.testing.assert_allclose(
                stored[:, b, kind], 0.5 * np.einsum("ti,ij,tj->t", x, E, x), rtol=1e-12, atol=1e-15
            )


def test_points_move_with_the_velocity_in_the_middle_of_each_step(solution):
    z, theta, dt = middles(solution)
    system = solution.system
    material = (system.point_velocity @ z.T).T.reshape(dt.size, -1, 2)
    angle = system.point_angles.at(theta.T).T
    c, s = np.cos(angle), np.sin(angle)
    velocity = np.stack(
        [c * material[..., 0] - s * material[..., 1], s * material[..., 0] + c * material[..., 1]], axis=-1
    )
    moved = system.start.points + np.cumsum(dt[:, None, None] * velocity, axis=0)
    np.testing.assert_allclose(solution.recording.points[1:], moved, atol=1e-12)
    np.testing.assert_array_equal(solution.recording.points[0], system.start.points)


def test_potential_energy_is_weight_times_height(solution):
    system = solution.system
    risen = solution.recording.points - solution.recording.points[0]
    total = -np.einsum("m,tmd,d->t", system.point_mass, risen, system.gravity)
    np.testing.assert_allclose(solution.recording.ledger.potential.sum(axis=1), total, atol=1e-11)
    for b, part in enumerate(system.parts):
        own = -np.einsum("m,tmd,d->t", system.point_mass[part.points], risen[:, part.points], system.gravity)
        np.testing.assert_allclose(solution.recording.ledger.potential[:, b], own, atol=1e-11)


def test_supplied_energy_is_the_sum_over_steps(solution):
    z, theta, dt = middles(solution)
    u = inputs(solution)
    y = np.array([solution.system.G(a).T @ x for a, x in zip(theta, z, strict=True)])
    supplied = np.cumsum(dt[:, None] * u * y, axis=0).reshape(dt.size, -1)
    ledger = solution.recording.ledger
    np.testing.assert_allclose(ledger.supplied[1:], supplied, atol=1e-12 * max(1.0, np.abs(supplied).max(initial=0.0)))
    np.testing.assert_allclose(ledger.supplied_to.sum(axis=1), ledger.supplied.sum(axis=1), atol=1e-12)
    assert not ledger.supplied[0].any() and ledger.supplied.shape == (solution.t.size, solution.system.n_inputs)


def test_inputs_are_integrated_with_their_value_in_the_middle(solutions):
    solution = solutions["shaken"]
    t = 0.5 * (solution.t[1:] + solution.t[:-1])
    expected = np.stack([0.4 * np.sin(8.0 * t), 0.1 * np.cos(5.0 * t), 0.0 * t], axis=1)
    np.testing.assert_allclose(inputs(solution), expected, atol=1e-12)


def test_what_goes_through_each_connection(solution):
    """Force times velocity of the taking port in the middle of each step."""
    z, theta, dt = middles(solution)
    connections, system = solution.system.connections, solution.system
    for c in range(len(connections.names)):
        here = connections.number == c
        i, j, f = (axis[here] for axis in connections.entries.indices)
        phi = system.angles.features(theta.T).T
        power = (connections.entries.values[here] * phi[:, f] * z[:, i] * z[:, j]).sum(axis=1)
        found = solution.recording.ledger.transferred[:, c]
        np.testing.assert_allclose(found[1:], np.cumsum(dt * power), atol=1e-12 * max(1.0, np.abs(found).max()))


def test_every_step_balances(solution):
    scale = max(1.0, np.abs(solution.recording.ledger.stored).max())
    assert solution.max_power_balance_error <= 1e-12 * scale
    assert solution.recording.ledger.block_error.max() <= 1e-12 * scale
    assert solution.recording.ledger.connection_error.max(initial=0.0) <= 1e-13 * scale


def test_damping_is_booked(run, scenes):
    """With a damping matrix put in by hand: what is missing is what was dissipated, block by block."""
    system = scenes["free"].compile()
    rates = np.where([u in ("m/s", "rad/s") for u in system.state_units], 3.0, 0.0)
    R = sp.csr_array(sp.diags_array(rates * system.E.diagonal()))
    damped = dataclasses.replace(system, R0=R)
    solution = run("free", system=damped)
    z, _, dt = middles(solution)
    dissipated = np.cumsum(dt * np.einsum("ti,ij,tj->t", z, R.toarray(), z))
    np.testing.assert_allclose(solution.energy.dissipated[1:], dissipated, rtol=1e-11)
    assert solution.energy.dissipated[-1] > 0.1 * solution.energy.supplied[-1] > 0.0
    balance = solution.energy.total + solution.energy.dissipated - solution.energy.supplied
    np.testing.assert_allclose(balance, balance[0], atol=1e-13)
    assert solution.max_power_balance_error < 1e-14
    for block in solution.power.blocks.values():
        np.testing.assert_allclose(
            block["stored"] + block["gravity"], block["received"] + block["supplied"] - block["dissipated"], atol=1e-13
        )


@pytest.mark.parametrize("chunk", [1, 7, 40])
def test_chunks_leave_no_trace(run, solutions, name, chunk, cut_chunks):
    counts = cut_chunks(chunk)
    one, other = solutions[name].recording, run(name).recording
    assert max(counts) == chunk and len(counts) == -(-40 // chunk)
    for field in ("t", "x", "theta", "points", "input_integral"):
        np.testing.assert_allclose(getattr(other, field), getattr(one, field), rtol=1e-13, atol=1e-13)
    for field in dataclasses.fields(one.ledger):
        a, b = getattr(one.ledger, field.name), getattr(other.ledger, field.name)
        if field.name.endswith("error"):
            assert b.shape == a.shape and np.abs(b).max(initial=0.0) < 1e-10
        else:
            np.testing.assert_allclose(b, a, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize(("chunk", "every"), [(5, 7), (7, 5), (4, 40), (128, 3)])
def test_saving_less_keeps_the_books_over_all_steps(run, solutions, name, chunk, every, cut_chunks):
    cut_chunks(chunk)
    full, some = run(name), run(name, save_every=every)
    steps = full.t.size - 1
    saved = [*range(0, steps, every), steps] if steps % every else list(range(0, steps + 1, every))
    for field in ("t", "x", "theta", "points", "input_integral"):
        np.testing.assert_array_equal(getattr(some.recording, field), getattr(full.recording, field)[saved])
    for field in ("stored", "potential", "transferred", "supplied", "supplied_to", "dissipated"):
        np.testing.assert_array_equal(
            getattr(some.recording.ledger, field), getattr(full.recording.ledger, field)[saved]
        )
    errors = full.recording.ledger.balance_error
    windows = [errors[0], *(errors[a + 1 : b + 1].max() for a, b in itertools.pairwise(saved))]
    np.testing.assert_array_equal(some.recording.ledger.balance_error, windows)
    np.testing.assert_array_equal(some.recording.ledger.block_error, full.recording.ledger.block_error)
    np.testing.assert_array_equal(some.recording.ledger.connection_error, full.recording.ledger.connection_error)


def test_halved_steps_are_booked_and_not_saved(run, monkeypatch, without_numba):
    from phblocks.solvers.midpoint import MidpointStepper

    true_step = MidpointStepper.step

    def step(self, x, theta, dt, u, guess=None):
        return true_step(self, x, theta, dt, u, guess) if dt < 0.006 else None

    monkeypatch.setattr(MidpointStepper, "step", step)
    halved = run("arm")
    monkeypatch.undo()
    fine = run("arm", dt=0.005, save_every=2)
    assert halved.statistics.steps == fine.statistics.steps == 80 and halved.statistics.halvings == 40
    np.testing.assert_allclose(halved.x, fine.x, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(halved.energy.supplied, fine.energy.supplied, rtol=1e-9, atol=1e-12)
    assert halved.max_power_balance_error < 1e-12
