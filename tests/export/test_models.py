"""Models for python-control, pyMOR and SciPy: the same transfer function from all of them, and from files."""

import re
import sys
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np
import pytest
from scipy.signal import freqresp

import phblocks as ph
from phblocks.errors import ExtraMissingError, StructureError
from phblocks.export import read, write
from phblocks.export.control import to_control
from phblocks.export.pymor import to_pymor
from phblocks.export.scipy import to_scipy
from phblocks.export.statespace import legal_names, state_space, transfer

OMEGA = np.array([0.1, 0.7, 2.0, 9.0, 60.0])  # rad/s
SECTION = ph.Section(axial=3e4, shear=1e4, bending=50.0, mass=1.2, rotary=3e-3)


@pytest.fixture(scope="module")
def plant() -> SimpleNamespace:
    """Matrices of the user's in which all of P, S and N are full; the transfer function is written out."""
    rng = np.random.default_rng(3)
    n, m = 5, 2
    a, b, g = rng.normal(size=(n, n)), rng.normal(size=(n, n)), rng.normal(size=(n, m))
    loss = rng.normal(size=(n + m, n + m))
    loss = loss @ loss.T
    J, Q, N = a - a.T, b @ b.T + np.eye(n), np.array([[0.0, 1.3], [-1.3, 0.0]])
    R, P, S = loss[:n, :n], loss[:n, n:], loss[n:, n:]
    d = ph.Diagram("plant no. 1")
    ports = {
        "left": ph.SystemPort(ph.ELECTRICAL, [0], "voltage"),
        "right": ph.SystemPort(ph.ELECTRICAL, [1], "current"),
    }
    block = d.add(ph.SystemBlock("block", J=J, R=R, Q=Q, G=g, P=P, S=S, N=N, ports=ports))
    d.expose(block["left"], "in", imposes="current")
    d.expose(block["right"], "out", imposes="voltage")

    def expected(s):
        return (g + P).T @ Q @ np.linalg.solve(s * np.eye(n) - (J - R) @ Q, g - P) + S + N

    return SimpleNamespace(system=d.compile(), responses=[expected(1j * w) for w in OMEGA], N=N)


@pytest.fixture(scope="module")
def damped() -> ph.System:
    """A beam with internal damping between a wall and a force; its viscous stresses have no energy."""
    d = ph.Diagram("damped")
    beam = d.add(ph.Beam("b", SECTION, (0, 0), (1, 0), elements=3, damping=ph.Damping(internal=1e-3)))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "tip")
    return d.compile()


def largest(found, expected):
    """The largest relative difference of responses at all frequencies."""
    return max(np.abs(a - b).max() / np.abs(b).max() for a, b in zip(found, expected, strict=True))


def of_scipy(model):
    """Responses of a scipy model, each input on its own."""
    columns = []
    for k in range(model.B.shape[1]):
        rows = [
            freqresp((model.A, model.B[:, [k]], c[None], model.D[[i]][:, [k]]), OMEGA)[1] for i, c in enumerate(model.C)
        ]
        columns.append(rows)
    return np.array(columns).transpose(2, 1, 0)


@pytest.mark.parametrize("energy_variables", [False, True])
def test_matrices_have_the_transfer_function(plant, energy_variables):
    m = plant.system.matrices(energy_variables=energy_variables)
    assert largest([transfer(m, 1j * w) for w in OMEGA], plant.responses) < 1e-10
    if energy_variables:
        assert all(abs(getattr(m, key)).max() > 0.1 for key in "PSN")
        np.testing.assert_allclose(m.N.toarray(), plant.N, rtol=1e-12)
    else:
        assert largest([transfer(m.tangent, 1j * w) for w in OMEGA], plant.responses) < 1e-10


def test_python_control(plant):
    pytest.importorskip("control")
    model = plant.system.to_control(eliminate=True)
    assert largest([model(1j * w) for w in OMEGA], plant.responses) < 1e-10
    assert model.nstates == 5 and model.name == "plant_no_1"
    assert model.input_labels == ["in", "out"] and model.output_labels == ["in_voltage", "out_current"]
    assert model.state_labels[0] == "block_x0_0"
    from_matrices = to_control(plant.system.matrices(energy_variables=True))
    assert largest([from_matrices(1j * w) for w in OMEGA], plant.responses) < 1e-10


@pytest.mark.parametrize("energy_variables", [False, True])
def test_pymor(plant, energy_variables):
    """N as it stands in pyMOR has the opposite sign; with ours, the response would differ by twice it."""
    pytest.importorskip("pymor")
    model = plant.system.to_pymor(energy_variables=energy_variables)
    assert largest([model.transfer_function.eval_tf(1j * w) for w in OMEGA], plant.responses) < 1e-10
    assert type(model).__name__ == "PHLTIModel"


def test_scipy(plant):
    assert largest(of_scipy(plant.system.to_scipy(eliminate=True)), plant.responses) < 1e-10


@pytest.mark.parametrize("suffix", [".mat", ".npz", ".mtx"])
@pytest.mark.parametrize("energy_variables", [False, True])
def test_files(plant, tmp_path, suffix, energy_variables):
    write(plant.system.matrices(energy_variables=energy_variables), tmp_path / f"plant{suffix}")
    m = read(tmp_path / f"plant{suffix}")
    assert largest([transfer(m, 1j * w) for w in OMEGA], plant.responses) < 1e-10
    assert largest(of_scipy(to_scipy(m, eliminate=True)), plant.responses) < 1e-10


def test_files_to_other_tools(plant, tmp_path):
    pytest.importorskip("control")
    pytest.importorskip("pymor")
    plant.system.export(tmp_path / "plant.mat")
    m = read(tmp_path / "plant.mat")
    assert largest([to_control(m, eliminate=True)(1j * w) for w in OMEGA], plant.responses) < 1e-10
    assert largest([to_pymor(m).transfer_function.eval_tf(1j * w) for w in OMEGA], plant.responses) < 1e-10


def test_viscous_stresses_are_eliminated_exactly(damped):
    m = damped.matrices()
    model = to_scipy(m, eliminate=True)
    assert len(model.A) == damped.n - int(damped.algebraic.sum())
    one = np.eye(len(model.A))
    found = [model.C @ np.linalg.solve(1j * w * one - model.A, model.B) + model.D for w in OMEGA]
    assert largest(found, [transfer(m.tangent, 1j * w) for w in OMEGA]) < 1e-10


def test_about_a_state_of_a_solution(four_bar):
    """The tangent at a time of a run, E times the A that was found being that of linearize."""
    system = four_bar((2, 2, 2)).compile()
    state = ph.simulate(system, t_end=0.2, dt=0.02).at(0.2)
    model, linear = system.to_scipy(state), system.linearize(state)
    A = linear.A.toarray()
    assert np.abs(linear.E @ model.A - A).max() < 1e-12 * np.abs(A).max()
    assert np.abs(model.A - system.to_scipy().A).max() > 1.0


def test_singular_e_is_refused(damped):
    with pytest.raises(StructureError, match=re.escape("no rate of b.N1v[0]")) as error:
        damped.to_scipy()
    assert "eliminate=True" in error.value.fix
    d = ph.Diagram("multiplier")
    one, two = d.add(ph.Mass("one", 1.0, (0, 0))), d.add(ph.Mass("two", 1.0, (0, 0)))
    d.pin(one.centre, two.centre, multiplier=True)
    d.expose(one.centre.translation, "push")
    with pytest.raises(StructureError, match="constraints among"):
        d.compile().to_scipy(eliminate=True)


def test_names_are_legal_and_different():
    assert legal_names(["a.b[0]", "a.b 0", "a-b.0", "Träger", "..."]) == [
        "a_b_0",
        "a_b_0_2",
        "a_b_0_3",
        "Träger",
        "unnamed",
    ]


def test_control_takes_all_names(full):
    pytest.importorskip("control")
    model = to_control(full_of_numbers(full))
    assert len(set(model.state_labels)) == model.nstates and not any("." in label for label in model.state_labels)


def full_of_numbers(m):
    """The same names with matrices that can be inverted."""
    from dataclasses import replace

    n, p = m.G.shape
    return replace(
        m,
        E=np.eye(n),
        J=np.zeros((n, n)),
        R=np.eye(n),
        Q=np.eye(n),
        G=np.ones((n, p)),
        tangent=None,
        P=np.zeros((n, p)),
        S=np.zeros((p, p)),
        N=np.zeros((p, p)),
    )


# The nonlinear model


@pytest.mark.parametrize("name", ["frame", "arm", "shaken"])
def test_nonlinear_system_of_python_control(scenes, name):
    """Its rates are those that a small step of the library takes, and its linearisation the tangent."""
    control = pytest.importorskip("control")
    system = scenes[name].compile()
    model = system.to_control(nonlinear=True)
    rng = np.random.default_rng(1)
    x, theta = rng.normal(size=system.n), 0.3 * rng.normal(size=system.start.theta.size)
    u = rng.normal(size=system.n_inputs)
    rates = model.dynamics(0.0, np.concatenate([x, theta]), u)
    np.testing.assert_allclose(system.E @ rates[: system.n], system.force(x, theta, u), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(rates[system.n :], system.rates @ x + system.input_rates @ u, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(model.output(0.0, np.concatenate([x, theta]), u), system.G(theta, x).T @ x, rtol=1e-12)
    assert isinstance(model, control.NonlinearIOSystem) and model.ninputs == system.n_inputs
    assert np.isfinite(state_space(system.matrices()).A).all()


def test_a_duffing_oscillator_in_python_control():
    """x'' = -x - x^3 with a Hamiltonian of the user's, as python-control integrates it: H = p^2/2 + q^2/2 + q^4/4."""
    control = pytest.importorskip("control")
    import sympy

    q, p = sympy.symbols("q p")
    d = ph.Diagram("duffing")
    d.add(ph.CustomBlock.from_sympy("d", p**2 / 2 + q**2 / 2 + q**4 / 4, (q, p), J=[[0, 1], [-1, 0]], start=(1.0, 0.0)))
    system = d.compile()
    model = system.to_control(nonlinear=True)
    assert model.nstates == 2
    np.testing.assert_allclose(model.dynamics(0.0, np.array([0.5, 0.2]), np.zeros(0)), [0.2, -0.5 - 0.125], rtol=1e-14)
    t = np.linspace(0.0, 5.0, 51)
    found = control.input_output_response(model, t, 0, [1.0, 0.0], solve_ivp_kwargs={"rtol": 1e-10, "atol": 1e-12})
    H = 0.5 * found.states[1] ** 2 + 0.5 * found.states[0] ** 2 + 0.25 * found.states[0] ** 4
    np.testing.assert_allclose(H, 0.75, rtol=1e-7)


def test_nonlinear_system_with_states_without_a_rate_is_refused(damped):
    with pytest.raises(StructureError, match="all states with a rate"):
        damped.to_control(nonlinear=True)


@pytest.mark.parametrize(("method", "package"), [("to_control", "control"), ("to_pymor", "pymor.models.iosys")])
def test_without_the_extra(plant, method, package):
    extra = package.partition(".")[0]
    arguments = {"eliminate": True} if method == "to_control" else {}
    with patch.dict(sys.modules, {package: None}), pytest.raises(ExtraMissingError) as error:
        getattr(plant.system, method)(**arguments)
    assert f'pip install "phblocks[{extra}]"' in str(error.value)
    assert isinstance(error.value, ImportError)
