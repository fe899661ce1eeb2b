"""The bushing: statics against its matrix, momentum and deflection in motion, damping."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import DataError, StructureError

STIFFNESS = np.array([[400.0, 50.0, 10.0], [50.0, 300.0, -20.0], [10.0, -20.0, 150.0]])
DAMPING = np.array([[0.6, 0.1, 0.0], [0.1, 0.4, 0.0], [0.0, 0.0, 0.3]])


def two_bodies(stiffness=STIFFNESS, damping=None):
    d = ph.Diagram("two bodies")
    one = d.add(ph.RigidBody("one", 1.0, 0.1, (0.0, 0.0), anchors={"end": (0.5, 0.0)}))
    two = d.add(ph.RigidBody("two", 2.0, 0.2, (0.8, 0.0), anchors={"end": (0.5, 0.0)}))
    bushing = d.add(ph.Bushing("bushing", stiffness, damping))
    d.weld(one["end"], bushing.first)
    d.weld(bushing.second, two["end"])
    return d.compile(), one, two


def deflection(solution, one, two):
    gap, angle = solution.position(two["end"]) - solution.position(one["end"]), solution.angle(one.centre)
    c, s = np.cos(angle), np.sin(angle)
    turned = solution.angle(two.centre) - angle
    return np.stack([c * gap[:, 0] + s * gap[:, 1], c * gap[:, 1] - s * gap[:, 0], turned], axis=1)


def run(dt, damping=None):
    system, one, two = two_bodies(damping=damping)
    start = system.rigid_motion((1.0, 2.0), 3.0, blocks=["one"])
    return ph.simulate(system, t_end=1.0, dt=dt, start=start), one, two


def cross(a, b):
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


@pytest.mark.parametrize("damping", [None, DAMPING])
def test_momenta_and_deflection_in_motion(damping):
    drift, gap = [], []
    values, vectors = np.linalg.eigh(STIFFNESS)
    for dt in (0.01, 0.005):
        solution, one, two = run(dt, damping)
        energy = solution.energy
        assert solution.max_power_balance_error < 1e-11 * energy.total[0]
        np.testing.assert_allclose(energy.total + energy.dissipated, energy.total[0], rtol=1e-10)
        velocities = [solution.velocity(body.centre) for body in (one, two)]
        momentum = velocities[0] + 2.0 * velocities[1]
        np.testing.assert_allclose(momentum - momentum[0], 0.0, atol=1e-12)
        spins = [solution.spin(body, (0.0, 0.0)) for body in (one, two)]
        places = [solution.position(body.centre) for body in (one, two)]
        L = cross(places[0], velocities[0]) + 2.0 * cross(places[1], velocities[1]) + 0.1 * spins[0] + 0.2 * spins[1]
        drift.append(np.abs(L - L[0]).max())
        elastic = np.stack([solution.state(f"bushing.elastic{i}[0]") for i in range(3)], axis=1)
        gap.append(np.abs(deflection(solution, one, two) - (elastic / values) @ vectors.T).max())
        if damping is not None:
            assert energy.dissipated[-1] > 0.1 * energy.total[0]
    assert drift[0] / drift[1] == pytest.approx(4.0, rel=0.1) and drift[1] < 1e-4
    assert gap[0] / gap[1] == pytest.approx(4.0, rel=0.1) and gap[1] < 1e-4


def test_statics():
    d = ph.Diagram("loaded")
    body = d.add(ph.RigidBody("body", 1.0, 1.0, (0.0, 0.0)))
    bushing = d.add(ph.Bushing("bushing", STIFFNESS, 0.02 * STIFFNESS, angle=0.4))
    force, moment = d.add(ph.Force("force", (0.3, -0.2))), d.add(ph.Moment("moment", 0.5))
    d.weld(d.ground, bushing.first)
    d.connect(bushing.second.translation, body.centre.translation, force.port)
    d.connect(bushing.second.rotation, body.centre.rotation, moment.port)
    solution = ph.simulate(d.compile(), t_end=20.0, dt=0.02)
    c, s = np.cos(0.4), np.sin(0.4)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    expected = turn @ np.linalg.solve(STIFFNESS, turn.T @ [0.3, -0.2, 0.5])
    found = [*solution.position(body.centre)[-1], solution.angle(body.centre)[-1]]
    np.testing.assert_allclose(found, expected, atol=1e-8)
    assert solution.max_power_balance_error < 1e-13


def test_directions_without_stiffness_are_free():
    system, _, _ = two_bodies(np.diag([100.0, 100.0, 0.0]))
    assert [n for n in system.state_names if "elastic" in n] == ["bushing.elastic0[0]", "bushing.elastic1[0]"]
    solution = ph.simulate(
        system, t_end=0.5, dt=0.01, start=system.rigid_motion(spin=1.0, about=(0.8, 0.0), blocks=["two"])
    )
    assert solution.status.ok and np.ptp(solution.energy.total) < 1e-11


def test_what_is_refused():
    with pytest.raises(DataError, match=r"Bushing 'b' stiffness.*shape \(3, 3\)"):
        ph.Bushing("b", np.eye(2))
    with pytest.raises(StructureError, match="a symmetric matrix"):
        ph.Bushing("b", np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
    with pytest.raises(StructureError, match="eigenvalue -1"):
        ph.Bushing("b", np.eye(3), damping=np.diag([1.0, 1.0, -1.0]))
    with pytest.raises(DataError, match="some stiffness"):
        ph.Bushing("b", np.zeros((3, 3)))
