"""What simulate takes for a method: anything that satisfies the protocol."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError
from phblocks.solvers.method import Integrator, Method, Stepper
from phblocks.solvers.step import Step


class Identity:
    """The unknowns are the states."""

    @staticmethod
    def pack(x):
        return x

    unpack = pack


class Verlet:
    """A method of the user's: explicit, for a mass on a torsion spring, states spin and moment in this order."""

    order = 2

    def prepare(self, system):
        E, J = system.E.diagonal(), system.J().toarray()

        class Steps:
            stage, nodes, weights = Identity(), (0.5,), (1.0,)

            def step(self, x, theta, dt, u):
                rates, end = (J.T / E).T, x.copy()
                end[0] += 0.5 * dt * rates[0] @ end
                end[1:] += dt * rates[1:] @ end
                end[0] += 0.5 * dt * rates[0] @ end
                z = 0.5 * (x + end)
                turned = system.rates @ z
                return Step(end, theta + dt * turned, z[None], (theta + 0.5 * dt * turned)[None], u, dt, 0)

        return Steps()


@pytest.fixture
def oscillator() -> ph.System:
    d = ph.Diagram()
    disc, spring = d.add(ph.RigidBody("disc", 1.0, 0.5, (0.0, 0.0))), d.add(ph.TorsionSpring("spring", 8.0))
    d.connect(disc.centre.rotation, spring.second)
    d.connect(spring.first, d.ground.rotation)
    return d.compile()


@pytest.mark.parametrize(
    "method", [ph.Midpoint(), ph.DiscreteGradient(), ph.GaussLegendre(2), ph.GaussLegendre(3), ph.LinearlyImplicit()]
)
def test_our_own_methods_satisfy_the_protocol(method, oscillator):
    assert isinstance(method, Method) and isinstance(method.prepare(oscillator), Stepper)
    assert not isinstance(method, Integrator)
    assert "Conserved" in type(method).__doc__ or "balance of any energy" in type(method).__doc__
    assert {"Order", "order"} & set(type(method).__doc__.split()) and "Cost" in type(method).__doc__


def test_a_method_of_the_users(oscillator):
    """Its energy oscillates and is reported so; two rows of states in an order it knows."""
    spinning = int(np.flatnonzero([name.startswith("disc.W") for name in oscillator.state_names])[0])
    moment = int(np.flatnonzero([name.startswith("spring.") for name in oscillator.state_names])[0])
    permute = [spinning, moment, *(i for i in range(oscillator.n) if i not in (spinning, moment))]
    assert isinstance(Verlet(), Method)
    start = ph.State(np.eye(oscillator.n)[spinning], oscillator.start.theta, oscillator.start.points)
    x = start.x[permute]
    assert x[0] == 1.0
    exact = ph.simulate(oscillator, 1.0, 0.01, start=start, method=ph.GaussLegendre(3))
    if permute[:2] != [0, 1]:
        class Reordered(Identity):
            @staticmethod
            def pack(v):
                return v[..., permute]

            @staticmethod
            def unpack(v):
                out = np.empty_like(v)
                out[..., permute] = v
                return out
        stage = Reordered()
    else:
        stage = Identity()

    class Mine(Verlet):
        def prepare(self, system):
            steps = super().prepare(system)
            steps.stage = stage
            E, J = system.E.diagonal()[permute], system.J().toarray()[np.ix_(permute, permute)]
            rates = (J.T / E).T

            def step(x, theta, dt, u):
                end = x.copy()
                end[0] += 0.5 * dt * rates[0] @ end
                end[1:] += dt * rates[1:] @ end
                end[0] += 0.5 * dt * rates[0] @ end
                z = 0.5 * (x + end)
                return Step(end, theta, z[None], theta[None], u, dt, 0)

            steps.step = step
            return steps

    solution = ph.simulate(oscillator, 1.0, 0.01, start=start, method=Mine())
    assert np.abs(solution.x - exact.x)[:, spinning].max() < 1e-3
    drift = np.abs(solution.energy.total - solution.energy.total[0]).max()
    assert 1e-6 < drift < 1e-2 and solution.max_power_balance_error > 1e-8


@pytest.mark.parametrize("method", [ph.Midpoint, ph.GaussLegendre, ph.ScipyIVP, 3, "midpoint", object()])
def test_what_is_not_a_method(oscillator, method):
    with pytest.raises(ArgumentTypeError, match="simulate method"):
        ph.simulate(oscillator, 1.0, 0.1, method=method)
