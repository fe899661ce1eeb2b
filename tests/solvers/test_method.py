"""What simulate takes for a method: anything that satisfies the protocol."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError
from phblocks.solvers.method import Integrator, Method, Stepper
from phblocks.solvers.step import Step


class States:
    """The unknowns are the states."""

    @staticmethod
    def pack(x):
        return x

    unpack = pack


class Splitting:
    """A method of the user's, explicit: half a step of the spins, a step of the moments, half a step of the spins."""

    order = 2

    def prepare(self, system):
        return SplitSteps(system)


class SplitSteps:
    stage, nodes, weights = States(), (0.5,), (1.0,)

    def __init__(self, system):
        self.system = system
        self.rates = (system.J().toarray().T / system.E.diagonal()).T
        self.spins = np.array([name.startswith("disc.") for name in system.state_names])

    def step(self, x, theta, dt, u):
        end = x.copy()
        for part, share in ((self.spins, 0.5), (~self.spins, 1.0), (self.spins, 0.5)):
            end[part] += share * dt * self.rates[part] @ end
        z = 0.5 * (x + end)
        turned = dt * (self.system.rates @ z)
        return Step(end, theta + turned, z[None], (theta + 0.5 * turned)[None], u, dt, 0)


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
    assert "order" in type(method).__doc__ and "Cost" in type(method).__doc__ and method.order in (2, 4, 6)


def test_scipys_say_what_they_keep_and_cost():
    text = ph.ScipyIVP.__doc__
    assert isinstance(ph.ScipyIVP(), Integrator) and "Conserved: nothing. Cost of a step" in text and "order 5" in text


def test_a_method_of_the_users(oscillator):
    """Its energy oscillates and is reported so."""
    assert isinstance(Splitting(), Method)
    start = oscillator.rigid_motion(spin=1.0)
    exact, solution = (
        ph.simulate(oscillator, 1.0, 0.01, start=start, method=m) for m in (ph.GaussLegendre(3), Splitting())
    )
    assert 0.0 < np.abs(solution.x - exact.x).max() < 2e-3 * np.abs(exact.x).max()
    drift = np.abs(solution.energy.total - solution.energy.total[0]).max()
    assert 1e-6 < drift < 1e-3 and solution.max_power_balance_error > 1e-7
    adapted = ph.simulate(oscillator, 1.0, 0.01, start=start, method=Splitting(), adaptive=ph.Adaptive(1e-6))
    assert adapted.status.ok and np.abs(adapted.x[-1] - exact.x[-1]).max() < 1e-4 * np.abs(exact.x).max()


@pytest.mark.parametrize("method", [ph.Midpoint, ph.GaussLegendre, ph.ScipyIVP, 3, "midpoint", object()])
def test_what_is_not_a_method(oscillator, method):
    with pytest.raises(ArgumentTypeError, match="simulate method"):
        ph.simulate(oscillator, 1.0, 0.1, method=method)
