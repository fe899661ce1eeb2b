"""Shares of effects in the energy of a run, against numbers by hand."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError


def test_a_bar_that_spins_about_its_end():
    """Kinetic energies of a rigid spin: rho A w^2 L^3 / 6 of translation, rho I w^2 L / 2 of the cross sections."""
    section, length = ph.Section(axial=1e9, shear=1e9, bending=1e7, mass=2.0, rotary=0.3), 1.5
    d = ph.Diagram()
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (length, 0.0), elements=2, degree=2))
    d.pin(beam.start, d.ground)
    system = d.compile()
    solution = ph.simulate(system, 1e-4, 1e-4, start=system.rigid_motion(spin=3.0, about=(0.0, 0.0)))
    shares = ph.studies.effect_shares(solution)
    rotary = (0.3 * length / 2.0) / (2.0 * length**3 / 6.0 + 0.3 * length / 2.0)
    assert shares.of("rotary_inertia")["beam"] == pytest.approx(rotary, rel=1e-3)
    assert shares.of("large_rotation")["beam"] == pytest.approx(3e-4, rel=1e-3)
    assert shares.of("flexible")["beam"] < 1e-3 and "gravity" not in shares.column("effect")


def test_shear_and_bending_of_a_loaded_cantilever():
    """Energies of an end load P: P^2 L / (2 kGA) in shear, P^2 L^3 / (6 EI) in bending; inertia all but gone."""
    shear, bending, length = 2e3, 300.0, 1.0
    section = ph.Section(axial=1e6, shear=shear, bending=bending, mass=1e-3, rotary=1e-6)
    d = ph.Diagram()
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (length, 0.0), elements=4, degree=2))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "load")
    solution = ph.simulate(d.compile(), 2.0, 0.01, inputs={"load": lambda t: (0.0, 0.5 * t)})
    shares = ph.studies.effect_shares(solution)
    ratio = (length / (2.0 * shear)) / (length**3 / (6.0 * bending))
    energies = {name: shares.of(name)["beam"] for name in ("shear", "flexible", "extension")}
    assert energies["shear"] / (energies["flexible"] - energies["shear"]) == pytest.approx(ratio, rel=0.02)
    assert energies["extension"] < 1e-6


def test_damping_and_weight():
    d = ph.Diagram(gravity=(0.0, -9.81))
    section = ph.Section.circle(0.01, 5e6, 0.3, 1000.0)
    damping = ph.Damping(internal=0.02)
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.0), elements=3, degree=2, damping=damping))
    d.pin(beam.start, d.ground)
    solution = ph.simulate(d.compile(), 0.5, 0.005)
    shares = ph.studies.effect_shares(solution)
    whole = max(solution.energy.kinetic + solution.energy.strain)
    whole = max(whole, float(np.ptp(solution.energy.gravity)))
    assert shares.of("internal_damping")["beam"] == pytest.approx(solution.energy.dissipated[-1] / whole, rel=1e-9)
    assert shares.of("gravity")["beam"] == pytest.approx(np.ptp(solution.energy.gravity) / whole, rel=1e-9)


def test_turns_of_what_stays_still_and_of_what_is_not_kept():
    """A bar that is pulled beside a disc that is turned: M t^2 / (2 I) of the disc, nothing of the bar."""
    d = ph.Diagram()
    bar = d.add(ph.Beam("bar", ph.Section(1e6, 1e6, 1e3, 1.0, 1e-2), (0.0, 0.0), (1.0, 0.0), elements=2))
    d.weld(bar.start, d.ground)
    d.connect(bar.end.translation, d.add(ph.Force("pull", (1.0, 0.0))).port)
    disc = d.add(ph.RigidBody("disc", 1.0, 2.0, (5.0, 5.0)))
    d.connect(disc.centre.rotation, d.add(ph.Moment("turn", 8.0)).port)
    shares = ph.studies.effect_shares(ph.simulate(d.compile(), 0.5, 0.1))
    assert shares.of("large_rotation") == {"bar": 0.0, "disc": pytest.approx(0.5)}
    unknown = ph.studies.effect_shares(ph.simulate(d.compile(outputs=None), 0.5, 0.1)).of("large_rotation")
    assert np.isnan(unknown["disc"])


def test_only_solutions_have_shares():
    with pytest.raises(ArgumentTypeError):
        ph.studies.effect_shares("run")
