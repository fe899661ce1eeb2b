"""Systems with energies and matrices of the user's, at a state: matrices, tangent and files against the equations."""

import numpy as np
import pytest
import sympy
from scipy.linalg import eig, eigvals

import phblocks as ph
from phblocks.errors import StructureError
from phblocks.export import read, suffixes
from phblocks.system.linearization import followed

LINE = ph.Domain("line", ph.Quantity("velocity", "m/s"), ph.Quantity("force", "N"))
INERTIA = np.array([1.0, 2.0, 3.0])
INPUT = np.array([[1.0], [0.5], [-1.0]])
AT, TORQUE = np.array([0.7, -1.1, 0.4]), np.array([0.3])


def cross(x):
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])


def energy(x):
    return (x * x / INERTIA).sum() / 2 + x[0] ** 4


def gradient(x):
    return x / INERTIA + np.array([4.0 * x[0] ** 3, 0.0, 0.0])


def rates(x, u):
    return (cross(x) - np.diag(x**2)) @ gradient(x) + INPUT @ u


def differences(function, at, h=1e-6):
    return np.stack([(function(at + d) - function(at - d)) / (2.0 * h) for d in h * np.eye(at.size)], axis=-1)


def dense(matrices) -> dict:
    return {key: getattr(matrices, key).toarray() for key in "EJRQGPSN"}


def body() -> ph.System:
    d = ph.Diagram("tumbling")
    block = d.add(
        ph.CustomBlock(
            "body",
            3,
            energy,
            gradient,
            lambda x: np.diag(1.0 / INERTIA + [12.0 * x[0] ** 2, 0.0, 0.0]),
            J=cross,
            R=lambda x: np.diag(x**2),
            G=INPUT,
            ports={"jet": ph.SystemPort(LINE, (0,), "velocity")},
        )
    )
    d.expose(block["jet"], "jet")
    return d.compile()


@pytest.fixture
def system() -> ph.System:
    return body()


@pytest.fixture
def state(system) -> ph.State:
    """Energy variables alone: what follows from them is found."""
    return ph.State(np.concatenate([AT, np.zeros(3)]), system.start.theta, system.start.points)


def test_the_tangent_is_the_derivative_of_the_vector_field(system, state):
    tangent = system.matrices(state, TORQUE).tangent
    np.testing.assert_array_equal(tangent.E.toarray(), np.eye(3))
    np.testing.assert_allclose(tangent.A.toarray(), differences(lambda x: rates(x, TORQUE), AT), atol=1e-8)
    np.testing.assert_array_equal(tangent.B.toarray(), INPUT)
    np.testing.assert_allclose(tangent.C.toarray(), differences(lambda x: INPUT.T @ gradient(x), AT), atol=1e-8)
    assert tangent.state_names == tuple(f"body.x{i}[0]" for i in range(3))


def test_the_matrices_have_rate_output_and_energy_of_the_state(system, state):
    matrices = system.matrices(state, TORQUE)
    m, x0, f0 = dense(matrices), matrices.x0, matrices.f0
    np.testing.assert_array_equal(m["E"], np.eye(3))
    np.testing.assert_array_equal(m["J"], cross(AT))
    np.testing.assert_array_equal(m["R"], np.diag(AT**2))
    np.testing.assert_allclose(m["Q"], differences(gradient, AT), atol=1e-8)
    np.testing.assert_allclose(m["Q"] @ x0, gradient(AT), atol=1e-14)
    rate = (m["J"] - m["R"]) @ m["Q"] @ x0 + f0 + m["G"] @ TORQUE
    np.testing.assert_allclose(rate, rates(AT, TORQUE), atol=1e-14)
    np.testing.assert_allclose(m["G"].T @ m["Q"] @ x0, INPUT.T @ gradient(AT), atol=1e-14)
    d = 1e-3 * np.array([1.0, -0.5, 0.7])
    change = ((x0 + d) @ m["Q"] @ (x0 + d) - x0 @ m["Q"] @ x0) / 2.0
    assert change == pytest.approx(energy(AT + d) - energy(AT), abs=1e-8)
    assert "'body' to second order about its x = [0.7, -1.1, 0.4]" in matrices.about
    np.testing.assert_array_equal(system.R_at(state.x).toarray()[3:, 3:], np.diag(AT**2))


def test_modes_about_a_state_are_those_of_the_vector_field(system, state):
    values = eigvals(differences(lambda x: rates(x, TORQUE), AT))
    modes = system.modes(3, state, TORQUE)
    swinging = values[values.imag > 1e-9]
    assert swinging.size == 1
    np.testing.assert_allclose(modes.frequencies, swinging.imag, rtol=1e-7)
    np.testing.assert_allclose(modes.growth, swinging.real, rtol=1e-7)


@pytest.mark.parametrize("suffix", suffixes())
def test_files(system, state, tmp_path, suffix):
    system.export(tmp_path / f"body{suffix}", state, TORQUE)
    back, matrices = read(tmp_path / f"body{suffix}"), system.matrices(state, TORQUE)
    for letter, value in dense(matrices).items():
        np.testing.assert_array_equal(dense(back)[letter], value)
    assert back.about == matrices.about
    assert back.state_names == matrices.state_names
    np.testing.assert_array_equal(back.x0, matrices.x0)
    np.testing.assert_array_equal(back.tangent.A.toarray(), matrices.tangent.A.toarray())


def test_where_the_energy_is_no_minimum_to_second_order():
    q, p = sympy.symbols("q p")
    d = ph.Diagram("well")
    d.add(ph.CustomBlock.from_sympy("well", p**2 / 2 - q**2 / 2 + q**4 / 4, (q, p), J=[[0, 1], [-1, 0]]))
    system = d.compile()
    with pytest.raises(StructureError, match=r"matrices of 'well' at x = \[0\.0, 0\.0\].*eigenvalue -1"):
        system.matrices()
    x = np.array([1.0, 0.0, 0.0, 0.0])
    matrices = system.matrices(ph.State(x, system.start.theta, system.start.points))
    np.testing.assert_allclose(matrices.Q.toarray(), np.diag([2.0, 1.0]))
    np.testing.assert_allclose(matrices.x0, 0.0)


def transducer() -> ph.System:
    """A mass on a hardening spring, driven through a G(x), an inductance and a resistance; feedthrough S."""
    q, p = sympy.symbols("q p")
    block = ph.CustomBlock.from_sympy(
        "cone",
        p**2 / 2 + q**2 / 2 + q**4,
        (q, p),
        J=[[0, 1], [-1, 0]],
        R=sympy.diag(0, 1 + p**2),
        G=sympy.Matrix([0, 2 * sympy.cos(q)]),
        S=[[0.5]],
        ports={"coil": ph.SystemPort(ph.ELECTRICAL, (0,), "voltage")},
    )
    d = ph.Diagram("transducer")
    d.add(block)
    inductor = d.add(ph.Inductor("L", 0.2))
    d.connect(inductor.n, block["coil"])
    d.expose(inductor.p, "volt", imposes="voltage")
    return d.compile()


def transducer_rates(s, u):
    q, p, i = s
    factor = 2.0 * np.cos(q)
    return np.array([p, -q - 4 * q**3 - (1 + p**2) * p + factor * i, (u[0] - factor * p - 0.5 * i) / 0.2])


def test_through_a_matrix_that_depends_on_the_state():
    system, s, u = transducer(), np.array([0.4, -0.6, 0.9]), np.array([0.3])
    names = ("cone.x0[0]", "cone.x1[0]", "L.current[0]")
    x = np.zeros(system.n)
    x[[system.state_names.index(name) for name in names]] = s
    state = ph.State(x, system.start.theta, system.start.points)
    at = followed(system, state, u)
    assert at[system.state_names.index("cone.taken0[0]")] == pytest.approx(0.9)
    assert at[system.state_names.index("cone.given0[0]")] == pytest.approx(2 * np.cos(0.4) * -0.6 + 0.5 * 0.9)
    linear = system.linearize(state, u)
    np.testing.assert_allclose(linear.A.toarray(), differences(lambda v: system.force(v, u=u), at), atol=1e-7)
    A, B = differences(lambda v: transducer_rates(v, u), s), differences(lambda v: transducer_rates(s, v), u)
    C = np.array([[0.0, 0.0, 1.0]])  # conjugate to the voltage: the current
    for tangent in (linear, system.matrices(state, u).tangent):
        E, a, b, c, d = (m.toarray() for m in (tangent.E, tangent.A, tangent.B, tangent.C, tangent.D))
        for frequency in (0.3, 2.0j, 1.0 + 5.0j):
            expected = C @ np.linalg.solve(frequency * np.eye(3) - A, B)
            np.testing.assert_allclose(c @ np.linalg.solve(frequency * E - a, b) + d, expected, rtol=1e-6)
    found = eig(a, E, right=False)
    found = found[np.isfinite(found) & (np.abs(found) < 1e6)]
    np.testing.assert_allclose(np.poly(found).real, np.poly(A), rtol=1e-6)
    np.testing.assert_allclose(system.modes(2, state, u).frequencies, max(eigvals(A).imag), rtol=1e-6)


def test_matrices_of_the_whole_carry_f0_at_the_state():
    system, u = transducer(), np.array([0.3])
    x = system.start.x.copy()
    x[system.state_names.index("cone.x0[0]")] = 0.5
    m = system.matrices(ph.State(x, system.start.theta, system.start.points), u)
    right = (m.J - m.R) @ (m.Q @ m.x0) + m.f0 + m.G @ u
    rate = dict(zip(m.state_names, right, strict=True))
    expected = transducer_rates([0.5, 0.0, 0.0], u)
    assert rate["cone.x1[0]"] == pytest.approx(expected[1])
    assert rate["L.current[0]"] == pytest.approx(0.2 * expected[2])
    assert rate["cone.taken0[0]"] == pytest.approx(0.0, abs=1e-14)
    assert rate["cone.given0[0]"] == pytest.approx(0.0, abs=1e-14)
