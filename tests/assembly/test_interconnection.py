"""The assembled matrices against the blocks put together by hand, junction by junction."""

import dataclasses

import numpy as np
import pytest

import phblocks as ph
from phblocks.assembly import assemble
from phblocks.errors import DataError


@pytest.fixture
def system(scene) -> ph.System:
    return scene.compile()


def dense_output(system: ph.System, path: str) -> np.ndarray:
    """What a port gives, as rows over all states; here one piece at most, in the frame of the anchor."""
    block, _, name = path.partition(".")
    part = system.part(block)
    components = 2 if name.endswith("translation") else 1
    rows = np.zeros((components, system.n))
    for piece in part.form.ports[name].pieces:
        assert piece.frame is None
        rows[:, part.states] += piece.output.csr((components, part.form.size)).toarray()
    return rows


def rotation(system: ph.System, path: str, theta: np.ndarray) -> np.ndarray:
    """From the frame of the port's anchor to the fixed frame."""
    if path.endswith("rotation"):
        return np.eye(1)
    places, weights, reference = system.anchor_angles[path.removesuffix(".translation")]
    angle = reference + theta[places] @ weights
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def test_joints_exchange_velocity_and_force_in_the_fixed_frame(scene, system):
    """v_t = Lambda_t^T Lambda_g v_g for every taking port, and the same matrix transposed for the forces."""
    report = scene.check()
    gives = {a.port: a.gives for a in report.assignments}
    for seed in range(2):
        theta = np.random.default_rng(seed).standard_normal(system.start.theta.size)
        J = np.zeros((system.n, system.n))
        for part in system.parts:
            J[part.states, part.states] = part.form.J0.csr((part.form.size, part.form.size)).toarray()
        for junction in scene.network.junctions():
            for g in (p for p in junction.ports if gives[p]):
                for t in (p for p in junction.ports if not gives[p]):
                    turn = rotation(system, t.path, theta).T @ rotation(system, g.path, theta)
                    exchange = dense_output(system, t.path).T @ turn @ dense_output(system, g.path)
                    J += exchange - exchange.T
        np.testing.assert_allclose(system.J(theta=theta).toarray(), J, atol=1e-14 * abs(J).max())


def test_inputs_act_on_the_side_that_takes_them(scene, system):
    """A force from outside acts on the giving port of its junction, a velocity on all taking ports."""
    gives = {a.port: a.gives for a in scene.check().assignments}
    theta = np.random.default_rng(1).standard_normal(system.start.theta.size)
    G = np.zeros((system.n, system.n_inputs))
    for junction in scene.network.junctions():
        for exposure in junction.exposures:
            columns = [i for i, entry in enumerate(system.inputs) if entry.exposure == exposure.name]
            assert all(system.inputs[i].common == exposure.gives for i in columns)
            for port in junction.ports:
                if gives[port] != exposure.gives:
                    G[:, columns] += dense_output(system, port.path).T @ rotation(system, port.path, theta).T
    np.testing.assert_allclose(system.G(theta).toarray(), G, atol=1e-15)
    assert system.n_inputs == 0 or np.linalg.norm(G, axis=0).min() > 0.5


def test_matrices_of_blocks_are_stacked(system):
    for name, order in (("E", 2), ("R", 2), ("T", 3)):
        matrix = getattr(system, name).toarray()
        stacked = np.zeros_like(matrix)
        for part in system.parts:
            entries = getattr(part.form, name)
            stacked[(part.states,) * order] = entries.coo((part.form.size,) * order).toarray()
        np.testing.assert_array_equal(matrix, stacked)


def test_every_anchor_starts_at_its_angle(scene, system):
    anchors = [a for b in scene.network.blocks.values() for a in b.anchors.values()]
    assert set(system.anchor_angles) == {a.path for a in anchors}
    for anchor in anchors:
        assert system.anchor_angles[anchor.path][2] == pytest.approx(anchor.angle, abs=1e-15)


def test_welded_ends_turn_together_and_pinned_ones_do_not(scenes):
    system = scenes["frame"].compile()
    places = {path: tuple(entry[0].tolist()) for path, entry in system.anchor_angles.items()}
    assert places["left.end"] == places["top.start"] != ()
    assert places["top.end"] == places["right.start"] != places["left.end"]
    assert places["left.start"] == places["right.end"] == ()  # on the ground
    assert system.K.values.size == 0  # corners keep their angle: constant matrices
    system = scenes["four-bar"].compile()
    places = {path: tuple(entry[0].tolist()) for path, entry in system.anchor_angles.items()}
    assert len({places[p] for p in ("crank.start", "crank.end", "coupler.start", "coupler.end", "rocker.start")}) == 5
    assert system.K.values.size > 0


def test_an_imposed_angular_velocity_drives_an_orientation_of_its_own(scenes):
    system = scenes["arm"].compile()
    places, weights, _ = system.anchor_angles["arm.start"]
    assert weights.tolist() == [1.0]
    rates, driven = system.rates.toarray(), system.input_rates.toarray()
    assert not rates[places[0]].any()
    np.testing.assert_array_equal(driven[places[0]], [1.0, 0.0, 0.0, 0.0])
    assert driven.sum() == 1.0


def test_rotation_states_are_integrals_of_spins(system):
    for row in system.rates.toarray():
        states = np.flatnonzero(row)
        assert states.size <= 1 and (row[states] == 1.0).all()
        assert all(".W3[" in system.state_names[i] for i in states)


def test_sites(scenes):
    sites = {s.name: s for s in scenes["four-bar"].compile().sites}
    assert list(sites) == [
        "crank.start = ground.anchor",
        "crank.end = coupler.start",
        "coupler.end = rocker.start",
        "rocker.end = ground.anchor",
    ]
    assert [s.known for s in sites.values()] == [True, False, False, True]
    assert sites["coupler.end = rocker.start"].places == (("coupler", 1.0), ("rocker", 0.0))
    np.testing.assert_array_equal(sites["crank.end = coupler.start"].start, [2.0, 1.5])
    (_, table) = scenes["shaken"].compile().sites
    assert table.known and table.inputs == (0, 1) and table.name == "lower.start"
    (joint,) = scenes["free"].compile().sites
    assert not joint.known and joint.inputs == ()


def test_connections_are_named_from_giver_to_taker(scenes):
    system = scenes["four-bar"].compile()
    assert system.connections.names == (
        ("coupler.start.translation", "crank.end.translation"),
        ("coupler.end.translation", "rocker.start.translation"),
    )
    numbers = {part.name: i for i, part in enumerate(system.parts)}
    for names, blocks in zip(system.connections.names, system.connections.blocks, strict=True):
        assert [numbers[name.split(".")[0]] for name in names] == blocks.tolist()


def test_a_lone_beam_has_no_connections(bar):
    d = ph.Diagram()
    d.add(ph.Beam("b", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    system = d.compile()
    assert system.connections.names == () and system.sites == () and system.angles.reference.size == 0
    assert not system.linear  # the products of states remain


def test_the_order_of_adding_permutes_the_states_and_changes_nothing_else(bar, four_bar):
    first = four_bar().compile()
    d = ph.Diagram("reversed", gravity=(0.0, -9.81))
    blocks = four_bar().network.blocks
    rocker, coupler, crank = (d.add(blocks[name]) for name in ("rocker", "coupler", "crank"))
    d.pin(d.ground, rocker.end)
    d.pin(rocker.start, coupler.end)
    d.pin(coupler.start, crank.end)
    d.pin(d.ground, crank.start)
    second = d.compile()
    order = [second.state_names.index(name) for name in first.state_names]
    x = np.random.default_rng(0).standard_normal(first.n) / np.sqrt(first.E.diagonal())
    y = np.empty(second.n)
    y[order] = x
    np.testing.assert_allclose(second.force(y)[order], first.force(x), rtol=1e-12, atol=1e-9)
    assert second.energy(y) == pytest.approx(first.energy(x), rel=1e-14)


def test_outputs_have_two_values(scene):
    with pytest.raises(DataError, match='"all" or None'):
        assemble(scene.network, scene.check(), "some")


def test_compiling_twice_gives_equal_systems_that_share_nothing(scene):
    first, second = scene.compile(), scene.compile()
    np.testing.assert_array_equal(first.J0.toarray(), second.J0.toarray())
    assert not np.shares_memory(first.E.data, second.E.data)
    assert dataclasses.replace(first, name="copy").n == second.n
