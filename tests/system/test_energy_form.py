"""Matrices in energy variables: hand-derived ones, the same transfer function, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

import phblocks as ph
from phblocks.errors import StructureError
from phblocks.system.energy_form import in_energy_variables

SECTION = ph.Section(axial=3e4, shear=1e4, bending=50.0, mass=1.2, rotary=3e-3)


def response(m, s):
    """From inputs to outputs."""
    E, J, R, Q, G, P, S, N = (getattr(m, k).toarray() for k in ("E", "J", "R", "Q", "G", "P", "S", "N"))
    return (G + P).T @ Q @ np.linalg.solve(s * E - (J - R) @ Q, G - P) + S + N


def beam():
    """With internal damping, whose stress has no energy, between its ends a damper that has none either."""
    d = ph.Diagram("beam")
    b = d.add(ph.Beam("b", SECTION, (0, 0), (1, 0), elements=3, degree=2, damping=ph.Damping(internal=1e-3)))
    d.weld(b.start, d.ground)
    turn = d.add(ph.TorsionDamper("turn", 0.3))
    d.connect(turn.first, b.end.rotation)
    d.connect(turn.second, d.ground.rotation)
    d.expose(b.end.translation, "tip")
    return d


def circuit():
    """A voltage on resistor r1 in series with resistor r2 and a capacitor beside each other."""
    d = ph.Diagram("circuit")
    ground = d.add(ph.Reference("zero", ph.ELECTRICAL))
    r1, r2 = d.add(ph.Resistor("r1", 2.0)), d.add(ph.Resistor("r2", 5.0))
    c = d.add(ph.Capacitor("c", 0.1))
    d.connect(r1.n, r2.p, c.p)
    d.connect(r2.n, ground.port)
    d.connect(c.n, ground.port)
    d.expose(r1.p, "volt", imposes="voltage")
    return d


def test_a_circuit_by_hand():
    """q' = -(1/2 + 1/5) q/C + u/2, i = (u - q/C)/2: half of the input goes through P, and S is 1/r1."""
    m = circuit().compile().matrices(energy_variables=True)
    assert m.state_names == ("E c.voltage[0]",) and m.state_units == ("J/V",)
    values = {k: getattr(m, k).toarray().item() for k in ("E", "J", "R", "Q", "G", "P", "S", "N")}
    assert values == pytest.approx({"E": 1, "J": 0, "R": 0.7, "Q": 10, "G": 0, "P": -0.5, "S": 0.5, "N": 0}, abs=1e-14)


@pytest.mark.parametrize("draw", [beam, circuit])
def test_the_same_system(draw):
    """E = 1, Q symmetric, R and the feedthrough dissipative, and the same outputs at all frequencies."""
    system = draw().compile()
    m, full = system.matrices(energy_variables=True), system.matrices()
    k = len(m.state_names)
    assert k == system.carries_energy.sum() < system.n
    assert (sp.eye_array(k) != m.E).nnz == 0 and m.tangent is None
    Q, J = m.Q.toarray(), m.J.toarray()
    assert (Q == Q.T).all() and (J == -J.T).all() and np.linalg.eigvalsh(Q).min() > 0.0
    loss = np.block([[m.R.toarray(), m.P.toarray()], [m.P.toarray().T, m.S.toarray()]])
    assert np.linalg.eigvalsh(loss).min() > -1e-12 * np.abs(loss).max()
    for s in (0.1j, 30j, 2.0 + 500j):
        expected = response(full, s)
        np.testing.assert_allclose(response(m, s), expected, rtol=1e-8, atol=1e-10 * np.abs(expected).max())


def test_energy_and_start_stay():
    """1/2 y^T Q y of y = E x is the energy of x."""
    system = beam().compile()
    rng = np.random.default_rng(4)
    x = np.where(system.carries_energy, rng.standard_normal(system.n), 0.0)
    m = system.matrices(ph.State(x, system.start.theta, system.start.points), energy_variables=True)
    assert 0.5 * m.x0 @ (m.Q @ m.x0) == pytest.approx(system.energy(x), rel=1e-10)


def test_spans_are_left_out_and_gravity_stays():
    """A mass on a spring in the plane, at rest: momenta and the elongation, weight as a constant load."""
    d = ph.Diagram("hung", gravity=(0.0, -10.0))
    mass = d.add(ph.Mass("mass", 2.0, (0.0, -1.0)))
    spring = d.add(ph.Spring("spring", 50.0, (0.0, 0.0), (0.0, -1.0)))
    d.pin(spring.start, d.ground)
    d.pin(spring.end, mass.centre)
    m = d.compile(effects="all").matrices(energy_variables=True)
    assert len(m.state_names) == 3 and m.state_units == ("J/(m/s)", "J/(m/s)", "J/N")
    np.testing.assert_allclose(m.f0, [0.0, -20.0, 0.0])
    np.testing.assert_allclose(m.Q.toarray(), np.diag([0.5, 0.5, 50.0]))
    np.testing.assert_allclose(np.abs(m.J.toarray()), [[0, 0, 0], [0, 0, 1], [0, 1, 0]], atol=1e-15)


def test_energy_variables_of_the_users_own_keep_their_names():
    d = ph.Diagram("custom")
    port = ph.SystemPort(ph.ELECTRICAL, (0,), gives="current")
    block = d.add(
        ph.CustomBlock(
            "coil",
            hamiltonian=lambda x: float(x[0] ** 2 + x[0] ** 4),
            gradient=lambda x: 2.0 * x + 4.0 * x**3,
            hessian=lambda x: np.diag(2.0 + 12.0 * x**2),
            J=[[0.0]],
            G=[[1.0]],
            ports={"p": port},
            size=1,
            start=[0.5],
        )
    )
    d.expose(block["p"], "volt", imposes="voltage")
    system = d.compile()
    m = system.matrices(energy_variables=True)
    assert m.state_names == system.matrices().state_names
    assert m.Q.toarray().item() == pytest.approx(5.0) and m.E.toarray().item() == 1.0


def test_constraints_are_refused():
    d = ph.Diagram("rods")
    one, two = d.add(ph.Mass("one", 1.0, (0.0, 0.0))), d.add(ph.Mass("two", 1.0, (0.0, 0.0)))
    d.pin(one.centre, two.centre, multiplier=True)
    with pytest.raises(StructureError, match=r"follow from the others, got constraints among pin one two"):
        d.compile().matrices(energy_variables=True)


def test_a_load_on_a_state_without_energy_is_refused():
    m = circuit().compile().matrices()
    f0 = np.where(m.E.diagonal() == 0.0, 1.0, 0.0)
    with pytest.raises(StructureError, match="no constant load"):
        in_energy_variables(replace(m, f0=f0), m.state_names, m.state_units)
