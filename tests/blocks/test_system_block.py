"""Ready-made matrices: the benchmark chain, feedthrough, joined to mechanisms, and what is refused."""

import numpy as np
import pytest
from scipy.linalg import eigvals

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, StructureError


@pytest.fixture
def chain(references):
    return {k: np.array(v) for k, v in references["mass_spring_damper_chain"]["matrices"].items()}


LINE = ph.Domain("line", ph.Quantity("velocity", "m/s"), ph.Quantity("force", "N"))


def transfer(linear, s):
    E, A, B, C = (m.toarray() for m in (linear.E, linear.A, linear.B, linear.C))
    return C @ np.linalg.solve(s * E - A, B)


def check_poles_and_transfer(system, chain):
    linear = system.linearize()
    values = eigvals(linear.A.toarray(), linear.E.toarray())
    values = values[np.isfinite(values) & (np.abs(values) < 1e6)]
    expected = chain["eig((J-R)Q)"] @ [1.0, 1j]
    assert values.size == expected.size
    assert max(np.abs(values - e).min() for e in expected) < 1e-12
    for s in (0.1j, 1j):
        np.testing.assert_allclose(transfer(linear, s), chain[f"H({s.imag:g}j)"] @ [1.0, 1j], atol=1e-12)


def test_benchmark_chain_as_a_block(chain):
    d = ph.Diagram("chain")
    ports = {name: ph.SystemPort(LINE, (i,), gives="velocity") for i, name in enumerate(("one", "two"))}
    block = d.add(ph.SystemBlock("chain", J=chain["J"], R=chain["R"], Q=chain["Q"], G=chain["B"], ports=ports))
    for name in ports:
        d.expose(block[name], name)
    system = d.compile()
    # Q^T (E x' - (J - R) Q x - G u) = 0: taking Q^T off again gives the published matrices
    left = np.linalg.inv(chain["Q"].T)
    for name, found in (("E", left @ system.E.toarray()), ("G", left @ system.G().toarray())):
        np.testing.assert_allclose(found, chain["B"] if name == "G" else np.eye(6), atol=1e-14)
    for name, found in (("J", system.J()), ("R", system.R)):
        np.testing.assert_allclose(left @ found.toarray() @ left.T, chain[name], atol=1e-14)
    check_poles_and_transfer(system, chain)


def drawn_chain() -> ph.Diagram:
    """Three masses in a line, springs between them and to a wall, dampers to the wall; forces on the first two."""
    d = ph.Diagram("chain")
    wall = d.add(ph.Reference("wall", LINE))
    masses = [d.add(ph.Capacitor(f"mass{i}", 4.0, domain=LINE, energy="kinetic")) for i in range(3)]
    springs = [d.add(ph.Inductor(f"spring{i}", 0.25, domain=LINE, energy="strain")) for i in range(3)]
    dampers = [d.add(ph.Resistor(f"damper{i}", 1.0, domain=LINE)) for i in range(3)]
    for i in range(3):
        at = [masses[i].p, dampers[i].p, springs[i].p] + ([springs[i - 1].n] if i else [])
        d.connect(*at)
        d.connect(masses[i].n, wall.port)
        d.connect(dampers[i].n, wall.port)
    d.connect(springs[2].n, wall.port)
    for i in range(2):
        d.expose(masses[i].p, f"force{i}", imposes="force")
    return d


def published_states(reduced):
    """Displacements and momenta of the masses in turn, from elongations and momenta, as in docs/export.md."""
    T = np.zeros((6, 6))
    place = {name: k for k, name in enumerate(reduced.state_names)}
    for i in range(3):
        for j in range(i, 3):  # spring j is between masses j and j + 1, the last one at the wall
            T[2 * i, place[f"E spring{j}.force[0]"]] = 1.0
        T[2 * i + 1, place[f"E mass{i}.velocity[0]"]] = 1.0
    names = [f"{x}{i}" for i in range(3) for x in "qp"]
    return reduced.with_states(T, names, ["m", "kg m/s"] * 3)


def test_benchmark_chain_drawn(chain):
    """In energy variables and in the published states: all five matrices are the published ones."""
    system = drawn_chain().compile()
    check_poles_and_transfer(system, chain)
    assert system.is_dae and not system.constraint_names  # dampers and the like, without energy
    found = published_states(system.matrices(energy_variables=True))
    expected = {"E": np.eye(6), "J": chain["J"], "R": chain["R"], "Q": chain["Q"], "G": chain["B"]}
    for name, matrix in expected.items():
        np.testing.assert_allclose(getattr(found, name).toarray(), matrix, rtol=0, atol=1e-14, err_msg=name)
    assert not any(abs(getattr(found, name)).max() > 1e-14 for name in "PSN")


def random_system(seed, n=4, m=3):
    rng = np.random.default_rng(seed)
    A, B, W = rng.standard_normal((n, n)), rng.standard_normal((n, n)), rng.standard_normal((n + m, n + m))
    loss, skew = W @ W.T / (n + m), rng.standard_normal((m, m))
    Q = rng.standard_normal((n, n))
    H = A @ A.T + np.eye(n)
    return {
        "E": np.linalg.solve(Q.T, H), "Q": Q, "J": B - B.T, "R": loss[:n, :n], "P": loss[:n, n:], "S": loss[n:, n:],
        "N": skew - skew.T, "G": rng.standard_normal((n, m)),
    }  # fmt: skip


def test_feedthrough_is_exact():
    a = random_system(0)
    d = ph.Diagram("feedthrough")
    volt = ph.SystemPort(ph.ELECTRICAL, (2,), gives="current")
    push = ph.SystemPort(ph.TRANSLATION, (0, 1), gives="velocity")
    block = d.add(ph.SystemBlock("block", **a, ports={"push": push, "volt": volt}))
    d.expose(block["push"], "push")
    d.expose(block["volt"], "volt", imposes="voltage")
    system = d.compile()
    linear = system.linearize()
    for s in (0.3, 2.0j):
        B, C = a["G"] - a["P"], (a["G"] + a["P"]).T @ a["Q"]
        expected = C @ np.linalg.solve(s * a["E"] - (a["J"] - a["R"]) @ a["Q"], B) + a["S"] + a["N"]
        np.testing.assert_allclose(transfer(linear, s), expected, atol=1e-11)
    inputs = {"push": lambda t: (np.sin(t), 1.0), "volt": lambda t: np.cos(3.0 * t)}
    solution = ph.simulate(system, t_end=2.0, dt=0.01, inputs=inputs)
    energy = solution.energy
    assert solution.max_power_balance_error < 1e-13
    assert energy.supplied[-1] == pytest.approx(energy.total[-1] + energy.dissipated[-1], rel=1e-12)
    assert energy.dissipated[-1] > 0.0


def test_a_shaft_of_matrices_turns_a_body():
    """The port of rotation that gives angular velocity carries an orientation: a beam welded to it turns with it."""
    d = ph.Diagram("shaft")
    port = ph.SystemPort(ph.ROTATION, (0,), gives="angular velocity")
    shaft = d.add(
        ph.SystemBlock("shaft", E=[[2.0]], J=[[0.0]], G=[[1.0]], ports={"end": port}, start=[0.5], energy="kinetic")
    )
    beam = d.add(
        ph.Beam("beam", ph.Section(axial=1e6, shear=1e6, bending=1e3, mass=1.0, rotary=1e-3), (0, 0), (1, 0), 3)
    )
    d.pin(beam.start, d.ground)
    d.connect(shaft["end"], beam.start.rotation)
    solution = ph.simulate(d.compile(), t_end=0.5, dt=0.01)
    assert solution.status.ok and np.ptp(solution.energy.total) < 1e-12
    spin = solution.state("shaft.x0[0]")
    turned = np.concatenate([[0.0], np.cumsum(0.01 * (spin[1:] + spin[:-1]) / 2.0)])
    np.testing.assert_allclose(solution.angle(beam.start), turned, atol=1e-13)


@pytest.mark.parametrize(
    ("change", "error", "text"),
    [
        ({"J": np.eye(4)}, StructureError, "J: expected a skew matrix"),
        ({"N": np.eye(3)}, StructureError, "N: expected a skew matrix"),
        ({"R": -np.eye(4)}, StructureError, "R: expected a positive semidefinite"),
        ({"P": 1e3 * np.ones((4, 3))}, StructureError, r"\[\[R, P\], \[P\^T, S\]\]"),
        ({"E": -np.eye(4), "Q": np.eye(4)}, StructureError, r"Q\^T E"),
        ({"Q": np.diag([1.0, 1.0, 1.0, 0.0])}, DataError, "Q: expected an invertible"),
        ({"G": np.ones((3, 3))}, DataError, r"G: expected finite numbers of shape \(4, 3\)"),
        ({"start": [1.0]}, DataError, "start: expected 4 finite numbers"),
        ({"E": np.ones((4, 4)), "Q": np.eye(4)}, DataError, "rows of zeros"),
        ({"J": "skew"}, ArgumentTypeError, "J: expected"),
        ({"units": ["m"]}, DataError, "units"),
        ({"ports": {}}, DataError, "each of the 3 inputs"),
        ({"ports": {"a": ph.SystemPort(ph.ROTATION, (0, 1), "moment")}}, DataError, "columns: expected 1"),
        ({"ports": {"a": ph.SystemPort(ph.ROTATION, (0,), "force")}}, DataError, "gives: expected 'angular velocity'"),
        ({"ports": {"a": ph.ROTATION}}, ArgumentTypeError, "SystemPort"),
    ],
)
def test_what_is_refused(change, error, text):
    ports = {str(i): ph.SystemPort(ph.ROTATION, (i,), gives="angular velocity") for i in range(3)}
    with pytest.raises(error, match=text):
        ph.SystemBlock("block", **({**random_system(1), "ports": ports} | change))


def test_a_state_without_energy_of_the_users_own():
    """E with a row of zeros: x1 = -u / R, a resistor between 0 = -R x1 + ... and the port."""
    d = ph.Diagram("semi")
    port = ph.SystemPort(ph.ELECTRICAL, (0,), gives="current")
    block = d.add(ph.SystemBlock("r", E=[[0.0]], J=[[0.0]], R=[[5.0]], G=[[1.0]], ports={"p": port}))
    source = d.add(ph.Voltage("source", 10.0))
    d.connect(source.port, block["p"])
    solution = ph.simulate(d.compile(), t_end=1.0, dt=0.5)
    assert solution.state("r.x0[0]")[-1] == pytest.approx(2.0)
    assert solution.energy.dissipated[-1] == pytest.approx(20.0)


@pytest.mark.parametrize("ports", [[1.0], 5.0, np.array(1.0)])
def test_ports_that_are_no_mapping(ports):
    with pytest.raises(ph.errors.ArgumentTypeError, match="mapping"):
        ph.SystemBlock("block", J=[[0.0, 1.0], [-1.0, 0.0]], G=[[1.0], [0.0]], ports=ports)
