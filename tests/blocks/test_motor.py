"""The direct-current motor: its step response, and where the energy goes."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import DataError

R, L, K, INERTIA, FRICTION, VOLTAGE = 0.5, 0.01, 0.1, 0.002, 0.001, 12.0


def spin_up(inductance: float = L, dt: float = 0.001) -> tuple[ph.RigidBody, ph.Solution]:
    d = ph.Diagram("motor")
    source, earth = d.add(ph.Voltage("source", VOLTAGE)), d.add(ph.Reference("earth"))
    motor = d.add(ph.DCMotor("motor", R, K, inductance))
    rotor = d.add(ph.RigidBody("rotor", 1.0, INERTIA, (0.0, 0.0)))
    friction = d.add(ph.TorsionDamper("friction", FRICTION))
    d.connect(source.port, motor.p)
    d.connect(motor.n, earth.port)
    d.connect(motor.shaft, rotor.centre.rotation, friction.second)
    d.connect(d.ground.rotation, motor.stator, friction.first)
    return rotor, ph.simulate(d.compile(), t_end=0.5, dt=dt)


def exact(t, inductance):
    if inductance == 0.0:
        end = K * VOLTAGE / (R * FRICTION + K**2)
        return end * (1.0 - np.exp(-t * (FRICTION + K**2 / R) / INERTIA))
    A = np.array([[-R / inductance, -K / inductance], [K / INERTIA, -FRICTION / INERTIA]])
    values, vectors = np.linalg.eig(A)
    end = -np.linalg.solve(A, [VOLTAGE / inductance, 0.0])
    return (end[:, None] - (vectors * np.linalg.solve(vectors, end)) @ np.exp(np.outer(values, t)))[1].real


@pytest.mark.parametrize("inductance", [L, 0.0])
def test_step_response(inductance):
    errors = []
    for dt in (0.002, 0.001):
        rotor, solution = spin_up(inductance, dt)
        errors.append(np.abs(solution.spin(rotor, (0.0, 0.0)) - exact(solution.t, inductance)).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    assert errors[1] < 1e-3 * exact(0.5, inductance)


def test_energy_of_winding_friction_and_rotor_adds_up():
    _, solution = spin_up()
    energy, blocks = solution.energy, solution.power.blocks
    assert energy.supplied[-1] == pytest.approx(energy.total[-1] + energy.dissipated[-1], rel=1e-13)
    assert solution.max_power_balance_error < 1e-14 * energy.supplied[-1]
    assert blocks["motor"]["dissipated"][-1] > blocks["friction"]["dissipated"][-1] > 0.0
    assert energy.magnetic[-1] == pytest.approx(0.5 * L * solution.state("motor.current[0]")[-1] ** 2)


def test_what_is_refused():
    for bad in ({"resistance": 0.0, "constant": K}, {"resistance": R, "constant": K, "inductance": -1.0}):
        with pytest.raises(DataError, match="DCMotor 'm'"):
            ph.DCMotor("m", **bad)
