"""Equations in the place of which differences are solved: which they are, and what that buys."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.solvers import compiled
from phblocks.solvers.equations import Equations
from phblocks.solvers.stage import StageEquation

DAMPING = ph.Damping(viscous=0.4, internal=0.02)


def section(axial: float) -> ph.Section:
    return ph.Section(axial=axial, shear=axial / 3.0, bending=1.0, mass=1.0, rotary=1.0 / axial)


def scenes() -> dict[str, ph.Diagram]:
    """Ends that give and that take, turn in joints, are shared, and a beam that switches within."""
    cantilever = ph.Diagram("cantilever")
    beam = cantilever.add(ph.Beam("beam", section(1e4), (0, 0), (1, 0), elements=4, degree=2, damping=DAMPING))
    cantilever.weld(beam.start, cantilever.ground)
    cantilever.expose(beam.end.translation, "load")

    chain = ph.Diagram("chain", gravity=(0.0, -9.81))
    a, b = (
        chain.add(ph.Beam(n, section(1e4), (i, 0), (i + 1, 0), elements=3, degree=1, damping=DAMPING))
        for i, n in enumerate("ab")
    )
    chain.pin(a.start, chain.ground)
    chain.pin(a.end, b.start)
    body = chain.add(ph.Mass("m", 0.5, (2, 0)))
    chain.pin(b.end, body.centre)

    frame = ph.Diagram("frame")
    a = frame.add(ph.Beam("a", section(1e4), (0, 0), (1, 0), elements=2, causality="free-free", damping=DAMPING))
    b = frame.add(ph.Beam("b", section(1e4), (1, 0), (1, 1), elements=2, causality="free-free", damping=DAMPING))
    frame.weld(a.end, b.start)

    rods = ph.Diagram("rods")  # all that bends them is pruned
    for i, n in enumerate("ab"):
        rod = rods.add(ph.Beam(n, section(1e4), (0, i), (1, i), elements=3, degree=2, damping=DAMPING))
        rods.weld(rod.start, rods.ground)
        rods.connect(rod.end.translation, rods.add(ph.Force(f"pull {n}", (1.0, 0.0))).port)
    return {"cantilever": cantilever, "chain": chain, "frame": frame, "rods": rods}


@pytest.mark.parametrize("name", ["cantilever", "chain", "frame", "rods"])
def test_all_viscous_stresses_follow_their_stress(name):
    """Their equations are 0 = C N' - C/time N_v, and none of any other state is touched."""
    system = scenes()[name].compile()
    names = np.array(system.state_names)
    viscous = np.flatnonzero([n.split(".")[1].split("[")[0].endswith("v") for n in names])
    elastic = np.array([np.flatnonzero(names == names[i].replace("v[", "["))[0] for i in viscous])
    assert viscous.size and (names[viscous] != names[elastic]).all()
    assert (np.array(system.pruning.states) < 0).any() == (name == "rods")
    assert (system.J0[viscous] != system.J0[elastic]).nnz == 0  # what is subtracted goes to the last bit
    equations = Equations.of(system)
    changed = np.flatnonzero(np.diff(sp_rows(equations.rate_matrix != system.rate_matrix)))
    np.testing.assert_array_equal(changed, viscous)
    assert (equations.rate_matrix[viscous] + system.E[elastic]).nnz == 0
    assert equations.J0[viscous].nnz == 0 and not np.isin(equations.T.indices[0], viscous).any()
    assert (equations.R0 != system.R0).nnz == 0
    others = np.setdiff1d(np.arange(system.n), viscous)
    assert (equations.J0[others] != system.J0[others]).nnz == 0
    np.testing.assert_array_equal(equations.scale[viscous], equations.scale[elastic])


def sp_rows(matrix) -> np.ndarray:
    matrix = matrix.tocsr()
    matrix.eliminate_zeros()
    return matrix.indptr


def test_without_internal_damping_equations_stay_as_they_are():
    d = ph.Diagram("drag")
    d.add(ph.Beam("beam", section(1e4), (0, 0), (1, 0), elements=4, damping=ph.Damping(viscous=1.0, rotary=0.1)))
    system = d.compile()
    equations = Equations.of(system)
    assert equations.J0 is system.J0 and equations.scale is equations.size


def test_rows_that_are_equal_by_chance_stay_as_they_are():
    """A heavy, fast body and a dashpot, beside a damped pendulum: M v' = u, 0 = u - w, so w = u to every digit."""
    mass, speed, push = 1e8, 100.0, 3.0
    d = ph.Diagram("series", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("beam", section(1e4), (0, 0), (1, 0), elements=2, damping=DAMPING))
    d.pin(beam.start, d.ground)
    block = d.add(
        ph.SystemBlock(
            "pair",
            E=np.diag([mass, 0.0]),
            J=np.zeros((2, 2)),
            R=np.diag([0.0, 1.0]),
            G=[[1.0], [1.0]],
            ports={"port": ph.SystemPort(ph.ELECTRICAL, (0,), gives="voltage")},
            start=[speed, 0.0],
        )
    )
    d.expose(block["port"], "push", imposes="current")
    system = d.compile()
    followers = Equations.of(system).followers
    assert followers.size and all(system.state_names[i].startswith("beam.") for i in followers)
    run = ph.simulate(system, 1.0, 0.01, inputs={"push": push})
    assert run.status.ok and not system.linear
    np.testing.assert_allclose(run.state("pair.x1[0]")[1:], push, rtol=1e-14)
    np.testing.assert_allclose(run.state("pair.x0[0]"), speed + push / mass * run.t, rtol=1e-13)


def test_the_solution_satisfies_the_equations_of_the_system():
    """Every row of E x' = (J - R) x + G u in the middle of a step, those of viscous stresses too."""
    system = scenes()["cantilever"].compile()
    stepper = ph.Midpoint().prepare(system)
    x, theta, dt, u = stepper.stage.pack(system.start.x), system.start.theta, 0.01, np.array([[0.5, -1.0]])
    step = stepper.step(x, theta, dt, u)
    z, before = stepper.stage.unpack(step.z[0]), stepper.stage.unpack(x)
    residual = system.E @ (2.0 / dt * (z - before)) - system.force(z, step.theta_z[0], u[0])
    assert np.abs(residual).max() < 1e-12 * np.abs(system.force(z, step.theta_z[0], u[0])).max() < np.inf
    assert np.abs(z).max() > 0.1


@pytest.mark.parametrize(
    "method", [ph.Midpoint(), ph.Midpoint(newton=ph.Newton()), ph.GaussLegendre(2), ph.GaussLegendre(3)], ids=str
)
@pytest.mark.parametrize("numba", [True, False])
@pytest.mark.parametrize("axial", [1e6, 1e10, 1e14])
def test_no_stiffness_is_too_much(method, numba, axial, monkeypatch):
    """A thin beam that is bent and damped: no step is halved, with few iterations, and the balance holds."""
    if not numba:
        monkeypatch.setattr(compiled, "find_spec", lambda _: None)
    d = ph.Diagram("thin")
    beam = d.add(ph.Beam("beam", section(axial), (0, 0), (1, 0), elements=4, degree=2, damping=DAMPING))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "load")
    run = ph.simulate(
        d.compile(), 2.0, 0.1, method=method, max_halvings=0, inputs={"load": lambda t: (0.0, -2.0 * min(t, 1.0))}
    )
    assert run.status.ok and run.statistics.newton_iterations.max() <= 10
    assert run.max_power_balance_error < 1e-13
    assert run.x[:, [".N1v" in name for name in run.system.state_names]].any()


def test_the_linear_theory_takes_them_too():
    """A stiff damped beam in small motions: the static deflection P L^3 / (3 E I) is left, P = 1e-3 N."""
    d = ph.Diagram("small")
    damping = ph.Damping(viscous=8.0, internal=0.05)
    beam = d.add(ph.Beam("beam", section(1e13), (0, 0), (1, 0), elements=4, degree=3, damping=damping))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "load")
    system = d.compile().small_motions()
    run = ph.simulate(system, 60.0, 0.1, inputs={"load": (0.0, -1e-3)})
    assert run.status.ok and StageEquation(system).constant
    assert run.position(beam, 1.0)[-1, 1] == pytest.approx(-1e-3 / 3.0, rel=1e-7)  # short waves still move, by 4e-8
