"""Damping of beams: decay rates against exact ones, for every causality, and what it costs."""

import dataclasses
import itertools

import numpy as np
import pytest

import phblocks as ph
from phblocks.blocks.beam.ends import ENDS

#: Thick (length / height = 10).
SECTION = ph.Section(axial=1200.0, shear=384.6153846153846, bending=1.0, mass=1.0, rotary=1.0 / 1200.0)
BOTH = ph.Damping(viscous=0.3, rotary=1e-4, internal=(1e-3, 5e-4, 2e-3))


def cantilever(damping=None, elements=8, degree=2, section=SECTION):
    """A beam clamped at its start."""
    d = ph.Diagram("cantilever")
    beam = ph.Beam("beam", section, start=(0, 0), end=(1, 0), elements=elements, degree=degree, damping=damping)
    d.add(beam)
    d.weld(beam.start, d.ground)
    return d, beam


def lowest(damping, n=4, **kwargs):
    """Growth and frequency of the lowest modes."""
    modes = cantilever(damping, **kwargs)[0].compile().modes(n)
    return modes.growth, modes.frequencies


def test_uniform_drag_makes_every_mode_decay_at_half_its_rate():
    c = 0.1
    growth, _ = lowest(ph.Damping(viscous=c, rotary=c * SECTION.rotary / SECTION.mass))
    np.testing.assert_allclose(growth, -0.5 * c / SECTION.mass, rtol=1e-9)


def test_viscous_damping_of_a_slender_cantilever():
    slender = ph.Section(axial=1.2e7, shear=3.8e6, bending=1.0, mass=2.0, rotary=2.0 / 1.2e7)
    growth, _ = lowest(ph.Damping(viscous=0.1), n=1, section=slender)
    assert growth[0] == pytest.approx(-0.1 / (2.0 * slender.mass), rel=1e-3)


def test_kelvin_voigt_damping_ratio_grows_with_frequency():
    time = 1e-3
    growth, frequencies = lowest(ph.Damping(internal=time), n=3)
    _, undamped = lowest(None, n=3)
    ratio = -growth / np.hypot(growth, frequencies)
    np.testing.assert_allclose(ratio, 0.5 * time * undamped, rtol=1e-9)


def test_time_of_one_strain_damps_the_modes_that_have_it():
    growth, frequencies = lowest(ph.Damping(internal=(1e-3, 0.0, 0.0)), n=4)
    axial = np.argmin(np.abs(frequencies - 0.5 * np.pi * np.sqrt(SECTION.axial)))
    np.testing.assert_allclose(growth[np.arange(4) != axial], 0.0, atol=1e-10)
    assert growth[axial] == pytest.approx(-0.5e-3 * frequencies[axial] ** 2, rel=1e-3)


def rates_inside(ends, elements):
    """Growth and frequencies of three beams in a row, the damped middle one with given ends; in bending."""
    d = ph.Diagram("row")
    parts = [
        d.add(ph.Beam(name, SECTION, (x, 0), (x + 1 / 3, 0), elements, degree=2, causality=causality, damping=damping))
        for name, x, causality, damping in (
            ("a", 0, "auto", None),
            ("b", 1 / 3, ends, BOTH),
            ("c", 2 / 3, "auto", None),
        )
    ]
    d.weld(parts[0].start, d.ground)
    d.weld(parts[0].end, parts[1].start)
    d.weld(parts[1].end, parts[2].start)
    system = d.compile()
    J = system.J(np.random.default_rng(1).normal(size=system.E.shape[0]))
    assert np.abs((J + J.T).data).max(initial=0.0) == 0.0
    modes = system.modes(8)  # waves that the mesh does not resolve may be damped so much that they turn slow
    slow = np.flatnonzero(-modes.growth < modes.frequencies)[:3]
    return modes.growth[slow], modes.frequencies[slow]


def test_all_end_causalities_agree():
    names = list(itertools.product(ENDS, repeat=2))
    assert len(names) == 16
    reference = np.array(rates_inside(("free", "free"), 16))
    for ends in names:
        found = np.array(rates_inside(ends, 4))
        np.testing.assert_allclose(found, reference, rtol=2e-3, err_msg=str(ends))


@pytest.mark.parametrize("ends", ["pinned-pinned", "clamped-free", "guided-clamped"])
def test_causalities_converge_to_the_same_rates(ends):
    reference = np.array(rates_inside(("free", "free"), 16))
    coarse, fine = (np.abs(np.array(rates_inside(ends, n)) / reference - 1.0).max() for n in (2, 4))
    assert fine < coarse / 8.0  # order 4


@pytest.fixture(scope="module")
def swing():
    """A damped cantilever, bent far by a force that ends."""
    d, beam = cantilever(BOTH, elements=4)
    d.expose(beam.end.translation, "tip")
    return ph.simulate(d.compile(), 1.0, 0.01, inputs={"tip": lambda t: (0.0, 4.0 * (t < 0.5))}), beam


def test_what_is_lost_is_what_was_dissipated(swing):
    solution, beam = swing
    energy = solution.energy
    supplied = solution.power.inputs["tip.y"] + solution.power.inputs["tip.x"]
    scale = np.abs(supplied).max()
    assert scale > 0.1
    stored = solution.power.blocks["beam"]["stored"]
    np.testing.assert_allclose(stored - supplied, -energy.dissipated, atol=1e-12 * scale)
    assert (np.diff(energy.dissipated) >= 0.0).all() and energy.dissipated[-1] > 0.05 * scale
    assert solution.angle(beam.at(1.0)).max() > 0.5  # far from the linear range


def test_viscous_stress_is_time_times_the_rate_of_the_elastic_one(swing):
    solution, _ = swing
    states = solution.system.state_names
    elastic, viscous = (
        solution.x[:, [i for i, n in enumerate(states) if n.startswith(f"beam.{f}[")]] for f in ("M3", "M3v")
    )
    rate = (elastic[2:] - elastic[:-2]) / 0.02
    np.testing.assert_allclose(viscous[1:-1], 2e-3 * rate, atol=1e-9 * np.abs(rate).max())


def test_force_that_is_read_is_that_of_both_parts(swing):
    solution, _ = swing
    part = solution.system.part("beam")
    history = solution._history(part)
    elastic = dataclasses.replace(history, x=history.x.copy())
    elastic.x[:, part.form.mesh.size :] = 0.0
    for name in ("N1", "N2", "M3"):
        whole, viscous = (part.form.value(history, n, 0.4) for n in (name, name + "v"))
        np.testing.assert_allclose(whole, part.form.value(elastic, name, 0.4) + viscous, atol=1e-12)
        assert np.abs(viscous).max() > 0.0


def test_dissipation_is_positive_semidefinite():
    for ends in itertools.product(ENDS, repeat=2):
        beam = ph.Beam("beam", SECTION, (0, 0), (1, 0), (0, 0.2, 1.0), degree=3, causality=ends, damping=BOTH)
        form = beam.form(
            {
                f"{a}.{q}": g
                for a, e in zip(("start", "end"), ends, strict=True)
                for q, g in zip(("translation", "rotation"), ENDS[e], strict=True)
            }
        )
        R = form.R.csr((form.size, form.size)).toarray()
        np.testing.assert_array_equal(R, R.T)
        size = np.sqrt(np.where(np.diag(R) > 0.0, np.diag(R), 1.0))
        assert np.linalg.eigvalsh(R / np.outer(size, size)).min() > -1e-14


def test_viscous_damping_adds_no_states_and_none_changes_nothing():
    plain = cantilever()[0].compile()
    for damping in (ph.Damping(), ph.Damping(viscous=1.0, rotary=1.0)):
        system = cantilever(damping)[0].compile()
        assert system.state_names == plain.state_names
        for name in ("E", "J0", "G0"):
            np.testing.assert_array_equal(getattr(system, name).toarray(), getattr(plain, name).toarray())
        np.testing.assert_array_equal(system.T.data, plain.T.data)
        assert (system.R.nnz == 0) == (damping == ph.Damping())


def test_halves_of_a_beam_and_repairs_keep_the_damping():
    beam = cantilever(BOTH)[1]
    assert [half.damping for half in beam.split(0.3)] == [BOTH, BOTH]


@pytest.mark.parametrize(
    ("kwargs", "error"),
    [
        ({"viscous": -1.0}, ph.errors.DataError),
        ({"rotary": float("nan")}, ph.errors.DataError),
        ({"internal": float("inf")}, ph.errors.DataError),
        ({"internal": (1.0, 2.0)}, ph.errors.ArgumentTypeError),
        ({"internal": (1.0, 2.0, -3.0)}, ph.errors.DataError),
        ({"viscous": "much"}, ph.errors.ArgumentTypeError),
    ],
)
def test_numbers_out_of_range_are_refused(kwargs, error):
    with pytest.raises(error, match="Damping"):
        ph.Damping(**kwargs)


def test_damping_of_another_kind_is_refused():
    with pytest.raises(ph.errors.ArgumentTypeError, match="damping"):
        cantilever(0.1)
