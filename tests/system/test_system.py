"""The assembled system: names, units, and its matrices as functions of state and configuration."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import DataError, UnknownNameError


@pytest.fixture
def system(scene) -> ph.System:
    return scene.compile()


def random_state(system: ph.System, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States of unit energy, any configuration, inputs."""
    rng = np.random.default_rng(seed)
    x = rng.standard_normal(system.n) / np.sqrt(system.E.diagonal())
    return x, rng.standard_normal(system.start.theta.size), rng.standard_normal(system.n_inputs)


def test_names_units_and_places(scenes):
    system = scenes["arm"].compile()
    assert system.name == "arm" and system.dimension == 2
    names = system.state_names
    assert len(names) == len(set(names)) == system.n == len(system.state_units) == system.state_positions.size
    assert names[0] == "arm.V1[0]" and system.state_units[0] == "m/s" and system.state_positions[0] > 0.0
    last = names.index("arm.W3[0]"), names.index("arm.N1[0]"), names.index("arm.M3[0]")
    assert [system.state_units[i] for i in last] == ["rad/s", "N", "N m"]
    assert system.state_positions.max() == pytest.approx(1.0)
    assert system.input_names == ("drive", "force.x", "force.y", "moment")
    assert system.output_names == ("drive moment", "force.x velocity", "force.y velocity", "moment angular velocity")
    assert [i.imposed.unit for i in system.inputs] == ["rad/s", "N", "N", "N m"]
    assert system.energy_kinds == ("kinetic", "strain")
    kinds = np.array(system.energy_kinds)[system.energy_kind_of_state]
    assert all(
        (kind == "kinetic") == (unit in ("m/s", "rad/s")) for kind, unit in zip(kinds, system.state_units, strict=True)
    )


def test_names_of_rotation_states(scenes):
    system = scenes["arm"].compile()
    assert len(system.theta_names) == system.start.theta.size == len(set(system.theta_names))
    driven = int(np.flatnonzero(system.input_rates.toarray()[:, 0])[0])
    assert system.theta_names[driven].startswith("turned[")
    assert system.theta_names[0] == "arm.theta[0]" and system.state_names[system.rates.indices[0]].startswith("arm.W3[")


def test_parts_are_looked_up_by_name(scenes):
    system = scenes["four-bar"].compile()
    assert [p.name for p in system.parts] == ["ground", "crank", "coupler", "rocker"]
    crank = system.part("crank")
    assert all(name.startswith("crank.") for name in system.state_names[crank.states])
    with pytest.raises(UnknownNameError, match="one of ground, crank, coupler, rocker, got 'slider'"):
        system.part("slider")


def test_j_is_skew_and_conserves_energy_in_any_configuration(system):
    for seed in range(3):
        x, theta, _ = random_state(system, seed)
        J = system.J(x, theta)
        assert abs(J + J.T).max() <= 1e-15 * abs(J).max()
        assert abs(x @ (J @ x)) <= 1e-14 * np.linalg.norm(x) * np.linalg.norm(J @ x)


def test_j_is_affine_in_the_state(system):
    x, theta, _ = random_state(system, 1)
    y, _, _ = random_state(system, 2)
    zero = np.zeros(system.n)
    affine = system.J(x, theta) + system.J(y, theta) - system.J(zero, theta)
    assert abs(system.J(x + y, theta) - affine).max() <= 1e-13 * abs(affine).max()
    assert abs(system.J(theta=theta) - system.J(zero, theta)).max() == 0.0
    assert abs(system.J() - system.J(zero, system.start.theta)).max() == 0.0


def test_force_is_the_sum_of_its_parts(system):
    x, theta, u = random_state(system, 3)
    f = (system.J(x, theta) - system.R) @ x + system.gravity_force(theta) + system.G(theta) @ u
    np.testing.assert_allclose(system.force(x, theta, u), f, rtol=1e-14)
    np.testing.assert_allclose(system.force(x, theta), f - system.G(theta) @ u, rtol=1e-9, atol=1e-9 * abs(f).max())
    np.testing.assert_allclose(system.force(np.zeros(system.n)), system.gravity_force(), rtol=1e-14)


def test_energy_is_the_quadratic_form(system):
    x, _, _ = random_state(system, 4)
    assert system.energy(x) == pytest.approx(0.5 * x @ system.E.toarray() @ x, rel=1e-14)
    assert (system.Q.toarray() == np.eye(system.n)).all()
    assert system.R.nnz == 0


def test_gravity_weighs_what_is_there(scenes):
    """The force of gravity against a rigid translation is the weight, whatever the angles."""
    for name in ("four-bar", "frame", "arm"):
        system = scenes[name].compile()
        theta = np.zeros(system.start.theta.size)
        for direction in np.eye(2):
            x = system.rigid_motion(velocity=direction).x
            power = x @ system.gravity_force(theta)
            # end velocities of pinned ends are not states, so nothing is lost: masses are all inside
            assert power == pytest.approx(system.point_mass.sum() * system.gravity @ direction, rel=0.02, abs=1e-9)


def test_gravity_turns_with_the_beam(scenes):
    """Turning the whole free arm by an angle turns its weight the other way in the material frame."""
    system = scenes["arm"].compile()
    velocity = system.point_velocity.toarray().reshape(-1, 2, system.n)
    for turn in (0.0, 0.4, -2.0):
        theta = np.full(system.start.theta.size, turn)
        angle = np.arctan2(0.6, 0.8) + turn
        material = np.array([-9.81 * np.sin(angle), -9.81 * np.cos(angle)])
        expected = np.einsum("m,c,mcn->n", system.point_mass, material, velocity)
        np.testing.assert_allclose(system.gravity_force(theta), expected, atol=1e-12)


def test_inputs_in_the_fixed_frame_turn_with_the_port(scenes):
    system = scenes["arm"].compile()
    start = system.G().toarray()[:, 1:3]
    tip = [system.state_names.index(n) for n in system.state_names if n.startswith("arm.V")]
    rows = np.flatnonzero(np.abs(start).sum(axis=1))
    assert set(rows) <= set(tip) and rows.size == 2
    for turn in (0.0, 1.0, 3.0):
        angle = np.arctan2(0.6, 0.8) + turn
        G = system.G(np.full(system.start.theta.size, turn)).toarray()[rows, 1:3]
        np.testing.assert_allclose(G, [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]], atol=1e-14)


def test_outputs_are_power_conjugate_to_inputs(system):
    """d/dt of the stored energy is u^T y plus the power of gravity."""
    x, theta, u = random_state(system, 5)
    y = system.G(theta).T @ x
    np.testing.assert_allclose(
        x @ system.force(x, theta, u), u @ y + x @ system.gravity_force(theta), rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize("name", ["four-bar", "frame", "arm", "shaken", "free"])
def test_without_outputs_only_what_the_physics_needs_is_kept(scenes, name):
    full, lean = scenes[name].compile(), scenes[name].compile(outputs=None)
    assert abs(full.J() - lean.J()).max() <= 1e-15 * abs(full.J()).max()
    np.testing.assert_allclose(full.gravity_force(), lean.gravity_force(), atol=1e-13)
    assert abs(full.G() - lean.G()).max() <= 1e-15 if full.n_inputs else lean.n_inputs == 0
    heavy = bool(full.gravity.any())
    assert (lean.point_mass.size > 0) == heavy
    assert lean.start.theta.size <= full.start.theta.size
    if not heavy:
        assert lean.start.theta.size < full.start.theta.size


# Rigid motion


def test_a_rigid_motion_has_the_momentum_and_energy_of_the_body(scenes):
    """Two free beams: velocity of the centre of mass, and the parallel axis theorem."""
    system = scenes["free"].compile()
    v, spin, about = np.array([0.3, -0.2]), 1.3, np.array([0.4, 0.1])
    start = system.rigid_motion(v, spin, about)
    angle = system.point_angles.at(start.theta)
    material = (system.point_velocity @ start.x).reshape(-1, 2)
    c, s = np.cos(angle), np.sin(angle)
    fixed = np.stack([c * material[:, 0] - s * material[:, 1], s * material[:, 0] + c * material[:, 1]], axis=1)
    lever = system.start.points - about
    np.testing.assert_allclose(fixed, v + spin * np.stack([-lever[:, 1], lever[:, 0]], axis=1), atol=1e-13)
    lengths = {"first": np.hypot(1.0, 0.3), "second": 1.0}
    rotary = sum(lengths.values()) * 2e-3
    kinetic = 0.5 * system.point_mass @ (fixed**2).sum(axis=1) + 0.5 * rotary * spin**2
    assert system.energy(start.x) == pytest.approx(kinetic, rel=1e-12)
    np.testing.assert_array_equal(start.theta, system.start.theta)
    np.testing.assert_array_equal(start.points, system.start.points)


def test_a_rigid_motion_of_some_blocks(scenes):
    system = scenes["free"].compile()
    x = system.rigid_motion(velocity=(1.0, 0.0), blocks=["second"]).x
    assert not x[system.part("first").states].any() and x[system.part("second").states].any()
    with pytest.raises(UnknownNameError, match="third"):
        system.rigid_motion(spin=1.0, blocks=["third"])


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("velocity", (1.0,)),
        ("velocity", (np.nan, 0.0)),
        ("about", (1.0, 2.0, 3.0)),
        ("spin", np.inf),
        ("spin", (1.0, 2.0)),
    ],
)
def test_rigid_motions_out_of_range(scenes, name, value):
    with pytest.raises(DataError, match=f"rigid_motion {name}"):
        scenes["free"].compile().rigid_motion(**{name: value})
