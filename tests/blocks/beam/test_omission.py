"""Compliances and inertias of zero: which entries of E, T and R are left."""

import dataclasses
import math

import numpy as np
import pytest

import phblocks as ph
from phblocks.blocks.beam.omission import kept_coefficients, kept_damping
from phblocks.errors import ConstraintError

A = ph.Approximation
SECTION = ph.Section(axial=3e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)


def beam(approximation=None, section=SECTION, **options):
    """A free beam of four elements: its system."""
    d = ph.Diagram("free", gravity=(0.0, -9.81))
    options = {"elements": 4, "degree": 2} | options
    d.add(ph.Beam("b", section, (0, 0), (1, 0), approximation=approximation, **options))
    return d.compile()


def fields_without_energy(system):
    idle = system.E.diagonal() == 0.0
    return {name.split(".")[1].split("[")[0] for name, i in zip(system.state_names, idle, strict=True) if i}


@pytest.mark.parametrize(
    ("approximation", "fields"),
    [
        (A(), set()),
        (A(shear=False), {"N2"}),
        (A(extension=False), {"N1"}),
        (A(rotary_inertia=False), {"W3"}),
        (A(shear=False, extension=False, rotary_inertia=False), {"N1", "N2", "W3"}),
    ],
)
def test_their_energy_is_gone_and_nothing_else(approximation, fields):
    """E has no row for them, not even of stored zeros; J0 is the same; T has no product that they modulate."""
    full, system = beam(), beam(approximation)
    assert fields_without_energy(system) == fields
    assert (system.J0 != full.J0).nnz == 0
    gone = np.array([name.split(".")[1].split("[")[0] in fields for name in system.state_names])
    np.testing.assert_array_equal(system.algebraic, gone)
    kept = ~gone
    np.testing.assert_array_equal(system.E.toarray(), full.E.toarray() * np.outer(kept, kept))
    np.testing.assert_array_equal(system.T.toarray(), full.T.toarray() * kept)  # the last axis modulates


def test_second_order_drops_the_products_of_axial_strain_only():
    full, system = beam(), beam(A(large_rotation="second-order"))
    modulates = np.array([".N1[" not in name for name in system.state_names])
    np.testing.assert_array_equal(system.T.toarray(), full.T.toarray() * modulates)
    assert 0 < system.T.nnz < full.T.nnz
    for matrix in ("E", "J0", "R0"):
        assert (getattr(system, matrix) != getattr(full, matrix)).nnz == 0


def test_coefficients_of_a_spatial_beam_too():
    """Both shear compliances and all three rotary inertias."""
    kept, modulating = kept_coefficients(np.arange(1.0, 13.0), A(shear=False, rotary_inertia=False))
    assert kept.tolist() == [1, 2, 3, 0, 0, 0, 7, 0, 0, 10, 11, 12]
    assert modulating is kept
    full = np.arange(1.0, 13.0)
    kept, modulating = kept_coefficients(full, A(large_rotation="second-order"))
    assert kept is full and modulating.tolist() == [1, 2, 3, 4, 5, 6, 0, 8, 9, 10, 11, 12]


def test_no_strain_no_viscous_stress():
    damping = ph.Damping(viscous=0.3, rotary=0.1, internal=(1e-4, 2e-4, 3e-4))
    assert kept_damping(damping, A(shear=False)).internal == (1e-4, 0.0, 3e-4)
    assert kept_damping(damping, A(extension=False)).internal == (0.0, 2e-4, 3e-4)
    drag = kept_damping(damping, A(internal_damping=False))
    assert (drag.viscous, drag.rotary, drag.internal) == (0.3, 0.1, (0.0, 0.0, 0.0))
    full = beam(damping=damping)
    for approximation, left in ((A(shear=False), {"N1v", "M3v"}), (A(internal_damping=False), set())):
        names = {n.split(".")[1].split("[")[0] for n in beam(approximation, damping=damping).state_names}
        assert names == {"V1", "V2", "W3", "N1", "N2", "M3"} | left
    assert full.n == beam(A(internal_damping=False), damping=damping).n + 3 * 8


def test_drag_needs_no_inertia():
    """R on W is c_r times the mass matrix of the shape functions, whatever rho I is: at spin w it takes c_r w^2 L."""
    system = beam(A(rotary_inertia=False), damping=ph.Damping(rotary=0.7))
    spin = np.array([1.0 if ".W3[" in name else 0.0 for name in system.state_names])
    assert spin @ (system.R @ spin) == pytest.approx(0.7 * 1.0, rel=1e-13)
    assert (system.R != beam(damping=ph.Damping(rotary=0.7)).R).nnz == 0


def test_a_state_that_one_of_two_welded_beams_gives_energy_keeps_it():
    """Their ends share W: without rotary inertia in one of them, the other's is left."""
    for first, second in ((None, A(rotary_inertia=False)), (A(rotary_inertia=False), None)):
        d = ph.Diagram("frame")
        a = d.add(ph.Beam("a", SECTION, (0, 0), (1, 0), elements=2, causality="free-free", approximation=first))
        b = d.add(ph.Beam("b", SECTION, (1, 0), (1, 1), elements=2, causality="free-free", approximation=second))
        d.weld(a.end, b.start)
        system = d.compile()
        assert system.report.shared
        np.testing.assert_array_equal(system.carries_energy, system.E.diagonal() > 0.0)
        solution = ph.simulate(system, 0.1, 0.001, start=system.rigid_motion(spin=3.0, about=(1.0, 0.0)))
        assert solution.status.ok and solution.max_power_balance_error < 1e-12


@pytest.mark.parametrize("name", ["four-bar", "frame", "shaken", "free"])
@pytest.mark.parametrize(
    "approximation",
    [
        A(extension=False),
        A(shear=False, rotary_inertia=False),
        A(shear=False, extension=False, rotary_inertia=False),
        A(large_rotation="second-order"),
    ],
    ids=["inextensible", "Euler-Bernoulli", "elastica", "second-order"],
)
def test_energy_balances_in_every_scene(scenes, name, approximation):
    inputs = {
        "four-bar": {},
        "frame": {"load": lambda t: (30.0 * np.sin(9.0 * t), 0.0)},
        "shaken": {"table": lambda t: (0.1 * np.sin(5.0 * t), 0.0), "hold": lambda t: 0.1 * np.sin(2.0 * t)},
        "free": {"joint": (0.3, 0.1), "push": lambda t: (0.0, np.sin(t))},
    }[name]
    solution = ph.simulate(scenes[name].compile(approximation=approximation), 0.5, 0.005, inputs=inputs)
    assert solution.status.ok
    size = max(abs(solution.energy["kinetic"]).max(), abs(solution.energy["strain"]).max())
    assert solution.max_power_balance_error < 1e-12 * max(size, 1.0)
    assert solution.power.block_errors and max(solution.power.block_errors.values()) < 1e-11 * max(size, 1.0)


def test_a_start_that_stretches_what_cannot_be_stretched_is_projected():
    """V1 = s on a free beam of 1 m and 1.2 kg becomes its mean 1/2: rhoA L / 24 less energy, and no force after."""
    d = ph.Diagram("free")
    d.add(ph.Beam("b", SECTION, (0, 0), (1, 0), elements=4, degree=2, approximation=A(extension=False)))
    system = d.compile()
    along = [i for i, name in enumerate(system.state_names) if ".V1[" in name]
    x = np.zeros(system.n)
    x[along] = system.state_positions[along]
    start = ph.State(x, system.start.theta, system.start.points)
    solution = ph.simulate(system, 1.0, 0.01, start=start)
    assert solution.statistics.start_energy_change == pytest.approx(-1.2 / 24.0, rel=1e-12)
    np.testing.assert_allclose(solution.x[:, along], 0.5, rtol=1e-12)
    force = [i for i, name in enumerate(system.state_names) if ".N1[" in name]
    assert np.abs(solution.x[:, force]).max() < 1e-10


@pytest.mark.parametrize(
    ("stiffness", "approximation"),
    [
        ({"axial": math.inf}, A(extension=False)),
        ({"shear": math.inf}, A(shear=False)),
        ({"axial": math.inf, "shear": math.inf}, A(extension=False, shear=False)),
    ],
)
def test_an_infinite_stiffness_leaves_out_the_same(stiffness, approximation):
    """The very same matrices as on request; and what is not there is not offered to be left out."""
    damping = ph.Damping(viscous=0.3, internal=1e-3)
    asked = beam(approximation, damping=damping)
    system = beam(section=dataclasses.replace(SECTION, **stiffness), damping=damping)
    assert system.state_names == asked.state_names
    for name in ("E", "J0", "R0"):
        assert (getattr(system, name) != getattr(asked, name)).nnz == 0
    np.testing.assert_array_equal(system.T.toarray(), asked.T.toarray())
    names = {"axial": "extension", "shear": "shear"}
    part = next(part for part in system.parts if part.name == "b")
    effects = part.block.effects(part.form)
    assert not {names[name] for name in stiffness} & set(effects) and "flexible" in effects


RIGID = ph.Section(axial=math.inf, shear=math.inf, bending=math.inf, mass=1.2, rotary=2e-3)


@pytest.mark.parametrize("damping", [None, ph.Damping(internal=1e-3)])
def test_a_beam_of_no_compliance_at_all_swings_as_a_rigid_one(damping):
    """Held straight by forces of constraint; velocities that are linear along an element are exact from degree 2 on."""

    def swing(section, approximation, dt):
        d = ph.Diagram("pendulum", gravity=(0.0, -9.81))
        bar = d.add(
            ph.Beam("bar", section, (0, 0), (1, 0), elements=3, degree=2, approximation=approximation, damping=damping)
        )
        d.pin(bar.start, d.ground)
        run = ph.simulate(d.compile(), 0.5, dt)
        assert run.status.ok and run.max_power_balance_error < 1e-13
        assert "strain" not in run.energy
        return run.angle(bar, 1.0)

    gap = [np.abs(swing(RIGID, None, dt) - swing(SECTION, A(flexible=False), dt)) for dt in (0.01, 0.005)]
    assert gap[0][1] < 1e-15  # the same accelerations; the steps of the two differ to second order
    assert gap[0][-1] < 1e-3 and gap[0][-1] / gap[1][-1] == pytest.approx(4.0, rel=0.02)


def test_no_compliance_between_two_supports_is_too_much():
    d = ph.Diagram("held")
    bar = d.add(ph.Beam("bar", RIGID, (0, 0), (1, 0), elements=3))
    d.pin(bar.start, d.ground)
    d.pin(bar.end, d.ground)
    with pytest.raises(ConstraintError, match=r"bar\.N1.*imply already"):
        ph.simulate(d.compile(), 0.1, 0.01)


def test_infinite_stiffness_is_stored_and_exported(tmp_path):
    """JSON has no infinity: it is written as a text with a tag. Matrices have finite numbers only."""
    d = ph.Diagram("free")
    bar = d.add(ph.Beam("bar", RIGID, (0, 0), (1, 0), elements=2, damping=ph.Damping(internal=1e-3)))
    d.expose(bar.end.translation, "push")
    d.save(tmp_path / "free.json")
    again = ph.load(tmp_path / "free.json")
    assert again.blocks["bar"].section == RIGID
    system = d.compile()
    system.export(tmp_path / "free.npz")
    with np.load(tmp_path / "free.npz") as file:
        assert all(np.isfinite(file[name]).all() for name in file.files if file[name].dtype.kind == "f")
    assert not any(".M3v" in name for name in system.state_names)
