"""The nonlinear model in a file: its equations, evaluated from the file alone, are those of the system."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

import phblocks as ph
from phblocks.errors import DataError, StructureError
from phblocks.export import read
from phblocks.export.nonlinear import LENGTHS, SHAPES, parts_of
from phblocks.system.nonlinear import nonlinear_model


def springs() -> ph.Diagram:
    """Lines of action of both kinds, a guide that turns and a bushing: spans, distances, products of states."""
    d = ph.Diagram("springs", gravity=(0.0, -9.81))
    body = d.add(ph.RigidBody("body", 2.0, 0.3, (1.0, 0.2), {"a": (0.0, 0.0), "b": (2.0, 0.5)}))
    d.pin(body["a"], d.ground, multiplier=True)
    bead = d.add(ph.Mass("bead", 0.7, (1.5, 0.375)))
    guide = d.add(ph.Slider("guide", (2.0, 0.5), guide="first", start=(0.0, 0.0), end=(1.5, 0.375)))
    hub = d.add(ph.RigidBody("hub", 1.0, 0.2, (0.0, 0.0)))
    d.connect(guide.first, hub.centre.translation)
    d.connect(guide.first_rotation, hub.centre.rotation)
    spring = d.add(ph.Spring("spring", 300.0, (2.0, 0.5), (2.5, 1.5), free_length=0.9))
    damper = d.add(ph.Damper("damper", 3.0, (1.5, 0.375), (2.0, -1.0)))
    d.connect(spring.start.translation, body["b"].translation)
    d.pin(spring.end, d.ground)
    d.connect(damper.start.translation, bead.centre.translation, guide.second)
    d.pin(damper.end, d.ground)
    d.expose(body["b"].translation, "push")
    return d


def equations(m, x, theta, u):
    """E x', theta' and y from the fields of a model, as docs/export.md writes them."""
    n, inputs = m.G.shape
    csr = sp.csr_array
    folded = lambda M, v, columns: (csr(M) @ v).reshape(n, columns, order="F")  # noqa: E731
    a, b = m.alpha0 + csr(m.alpha) @ theta, m.beta0 + csr(m.beta) @ theta
    first, second = csr(m.r1) @ x, csr(m.r2) @ x
    length = np.where(m.taut == 1.0, m.free + csr(m.stretch) @ x, np.hypot(first, second))
    e1, e2 = (np.cos(b) * first + np.sin(b) * second) / length, (np.cos(b) * second - np.sin(b) * first) / length
    phi = np.concatenate([[1.0], np.cos(a), np.sin(a), e1, e2])
    G = m.G.toarray() + folded(m.Ku, phi, inputs)
    A = m.J0.toarray() + folded(m.T, x, n) + folded(m.K, phi, n) + folded(m.V, phi, n) - m.R.toarray()
    force = A @ x + csr(m.Kg) @ phi + (G + m.Vu.toarray()) @ u
    return force, csr(m.W) @ theta_free(m, x) + csr(m.Wu) @ u, G.T @ x


def theta_free(m, x):
    """The rates of rotation states act on the states alone."""
    assert m.W.shape == (len(m.theta_names), x.size)
    return x


@pytest.mark.parametrize("name", ["four-bar", "frame", "arm", "shaken", "free", "springs"])
def test_equations_of_a_file_are_those_of_the_system(scenes, tmp_path, name):
    system = (springs() if name == "springs" else scenes[name]).compile()
    system.export(tmp_path / "model.npz")
    m = read(tmp_path / "model.npz").nonlinear
    rng = np.random.default_rng(5)
    x = system.start.x + rng.normal(size=system.n) * 0.1
    theta, u = 0.5 * rng.normal(size=system.start.theta.size), rng.normal(size=system.n_inputs)
    force, turning, y = equations(m, x, theta, u)
    expected = system.force(x, theta, u)
    np.testing.assert_allclose(force, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(turning, system.rates @ x + system.input_rates @ u, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(y, system.G(theta, x).T @ x, rtol=1e-12, atol=1e-13)
    assert (system.rate_matrix != m.E).nnz == 0


@pytest.mark.parametrize("suffix", [".mat", ".npz", ".mtx"])
def test_every_format_gives_it_back(scenes, tmp_path, suffix):
    system = scenes["arm"].compile()
    system.export(tmp_path / f"arm{suffix}")
    got, expected = parts_of(read(tmp_path / f"arm{suffix}").nonlinear), parts_of(nonlinear_model(system))
    for key in SHAPES:
        np.testing.assert_array_equal(got[key].toarray(), expected[key].toarray(), err_msg=key)
    for key in LENGTHS:
        np.testing.assert_array_equal(got[key], expected[key])
    assert got["theta_names"] == system.theta_names
    assert got["point_names"][0] == "arm[0]" and len(got["point_names"]) == len(system.start.points)


def test_as_matlab_folds_it(scenes, tmp_path):
    """reshape(T*x, n, n) of what loadmat reads is J(x) - J0: rows of T are counted by columns of J."""
    system = scenes["frame"].compile()
    system.export(tmp_path / "frame.mat")
    m = scipy.io.loadmat(tmp_path / "frame.mat")
    x = np.random.default_rng(0).normal(size=system.n)
    phi = system.features(system.start.theta, x)
    J = m["nl_J0"].toarray() + np.reshape(m["nl_T"] @ x + m["nl_K"] @ phi, (system.n, system.n), order="F")
    np.testing.assert_allclose(J, system.J(x).toarray(), rtol=1e-13, atol=1e-13)


def test_it_starts_at_the_state_that_is_exported(scenes, tmp_path):
    system = scenes["arm"].compile()
    state = ph.simulate(system, t_end=0.1, dt=0.05, inputs={"drive": 2.0}).at(0.1)
    system.export(tmp_path / "arm.npz", state)
    m = read(tmp_path / "arm.npz")
    np.testing.assert_array_equal(m.x0, state.x)
    np.testing.assert_array_equal(m.nonlinear.theta0, state.theta)
    np.testing.assert_array_equal(m.nonlinear.points0, state.points.ravel())


def test_an_energy_of_the_users_is_left_out(tmp_path):
    d = ph.Diagram("custom")
    block = ph.CustomBlock("c", 1, lambda x: x[0] ** 4, lambda x: 4 * x**3, lambda x: [[12 * x[0] ** 2]], start=[1.0])
    d.add(block)
    system = d.compile()
    system.export(tmp_path / "custom.npz")
    assert read(tmp_path / "custom.npz").nonlinear is None
    with pytest.raises(StructureError, match="another one in 'c'"):
        nonlinear_model(system)


def test_shapes_are_checked(scenes):
    model = nonlinear_model(scenes["arm"].compile())
    with pytest.raises(DataError, match="T: expected shape"):
        replace(model, T=sp.coo_array((3, 3)))
    with pytest.raises(DataError, match="alpha0: expected finite"):
        replace(model, alpha0=model.alpha0 * np.nan)
    with pytest.raises(DataError, match="K: expected"):
        replace(model, Kg=sp.coo_array((model.E.shape[0], 2)))
    with pytest.raises(DataError, match="expected a matrix"):
        replace(model, R="R")


@pytest.mark.parametrize("suffix", [".npz", ".mat", ".mtx"])
def test_spatial_points_have_three_coordinates(tmp_path, suffix):
    section = ph.Section(
        axial=2e3, shear=(1e3, 1.2e3), bending=(10.0, 15.0), mass=1.0, rotary=(2e-2, 3e-2), torsion=8.0
    )
    d = ph.Diagram("cantilever in space")
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0, 0.0), (0.0, 1.0, 1.0), 3))
    d.weld(d.ground, beam.start)
    d.expose(beam.end.translation, "tip")
    system = d.compile(approximation=ph.Approximation(large_rotation=False))
    system.export(tmp_path / f"beam{suffix}")
    model = ph.export.read(tmp_path / f"beam{suffix}").nonlinear
    assert model.points.shape == (3 * len(model.point_names), system.n) and len(model.point_names) > 3
    np.testing.assert_allclose(model.points.toarray(), system.point_velocity.toarray())
    np.testing.assert_allclose(model.points0, system.start.points.ravel())
