"""A beam as matrices: rigid motions and equilibria are exact in all sixteen causalities; read-outs of exact fields."""

import itertools
import math

import numpy as np
import pytest

import phblocks as ph
from phblocks.blocks.beam.ends import ENDS
from phblocks.blocks.beam.form import BeamForm, arc, quadrature
from phblocks.blocks.form import Form, History
from phblocks.errors import UnknownNameError
from phblocks.triplets import Triplets

SECTION = ph.Section(axial=900.0, shear=300.0, bending=7.0, mass=1.3, rotary=0.2)
CAUSALITIES = ["-".join(pair) for pair in itertools.product(ENDS, repeat=2)]
PLACES = (0.0, 0.11, 0.5, 0.87, 1.0)
every_causality = pytest.mark.parametrize("causality", CAUSALITIES)


def beam_of(causality: str, degree: int = 2, **options) -> ph.Beam:
    arguments = {"start": (1.0, -0.5), "end": (2.0, 0.9), "elements": (0.0, 0.3, 0.5, 0.6, 1.0)}
    return ph.Beam("b", SECTION, causality=causality, degree=degree, **(arguments | options))


def form_of(beam: ph.Beam) -> BeamForm:
    assert beam.ends is not None
    names = ["start.translation", "start.rotation", "end.translation", "end.rotation"]
    return beam.form(dict(zip(names, itertools.chain(*beam.ends), strict=True)))


def square(form: Form, entries: Triplets) -> np.ndarray:
    return entries.csr((form.size, form.size)).toarray()


def fill(form: BeamForm, **fields) -> np.ndarray:
    """States that interpolate functions of the place s (m)."""
    return np.concatenate(
        [fields[run.field](run.positions) if run.field in fields else 0.0 * run.positions for run in form.runs]
    )


def rows_of(form: BeamForm, *names: str) -> np.ndarray:
    return np.concatenate([np.full(run.positions.size, run.field in names) for run in form.runs])


def port_forces(form: BeamForm, taken: dict[str, np.ndarray]) -> np.ndarray:
    """What the ports take, as a force on the states."""
    total = np.zeros(form.size)
    for name, port in form.ports.items():
        value = np.atleast_1d(taken[name])
        total += port.pieces[0].output.csr((value.size, form.size)).T @ value
    return total


def at_rest(form: BeamForm) -> History:
    points = form.points
    assert points is not None
    return History(np.zeros((1, form.size)), np.zeros((1, form.rotation_states.size)), points.start[None])


@every_causality
@pytest.mark.parametrize("degree", [1, 3])
def test_structure_to_the_last_bit(causality, degree):
    form = form_of(beam_of(causality, degree, curvature=0.4))
    E, J0 = square(form, form.E), square(form, form.J0)
    T = form.T.coo((form.size,) * 3).toarray()
    assert np.array_equal(E, E.T) and np.linalg.eigvalsh(E).min() > 0.0
    assert np.array_equal(J0, -J0.T)
    assert np.array_equal(T, -np.swapaxes(T, 0, 1)) and np.abs(T).max() > 1e-4


@every_causality
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_a_rigid_motion_strains_nothing(causality, degree):
    """With the ends that take velocities driven along, the right-hand sides of both strain equations vanish."""
    form = form_of(beam_of(causality, degree))
    v, spin, length = np.array([0.7, -0.4]), 1.7, form.mesh.boundaries[-1]
    x = fill(form, V1=lambda s: v[0] + 0 * s, V2=lambda s: v[1] + spin * s, W3=lambda s: spin + 0 * s)
    taken = {}
    for end, s in (("start", 0.0), ("end", length)):
        velocity = {"translation": v + np.array([0.0, spin * s]), "rotation": spin}
        for kind, value in velocity.items():
            taken[f"{end}.{kind}"] = np.zeros_like(value) if form.ports[f"{end}.{kind}"].gives else value
    rate = square(form, form.J0) @ x + port_forces(form, taken)
    np.testing.assert_allclose(rate[rows_of(form, "N1", "N2", "M3")], 0.0, atol=2e-13)
    given = {
        name: port.pieces[0].output.csr((len(np.atleast_1d(taken[name])), form.size)) @ x
        for name, port in form.ports.items()
    }
    for name, port in form.ports.items():
        if port.gives:  # velocity of the end, in its frame
            s = length if name.startswith("end") else 0.0
            expected = [v[0], v[1] + spin * s] if name.endswith("translation") else [spin]
            np.testing.assert_allclose(given[name], expected, atol=1e-13)


@every_causality
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_a_loaded_beam_is_in_equilibrium(causality, degree):
    """Constant force and linear moment, with the ends that take forces loaded accordingly, accelerate nothing."""
    form = form_of(beam_of(causality, degree))
    n, m0, length = np.array([3.0, -2.0]), 0.8, form.mesh.boundaries[-1]
    x = fill(form, N1=lambda s: n[0] + 0 * s, N2=lambda s: n[1] + 0 * s, M3=lambda s: m0 - n[1] * s)
    on_beam = {  # forces and moments on the beam: minus the internal ones at its start
        "start.translation": -n,
        "start.rotation": -m0,
        "end.translation": n,
        "end.rotation": m0 - n[1] * length,
    }
    taken = {name: on_beam[name] if port.gives else np.zeros_like(on_beam[name]) for name, port in form.ports.items()}
    rate = square(form, form.J0) @ x + port_forces(form, taken)
    np.testing.assert_allclose(rate[rows_of(form, "V1", "V2", "W3")], 0.0, atol=2e-13)
    for name, port in form.ports.items():
        if not port.gives:  # force on the beam
            value = np.atleast_1d(on_beam[name])
            np.testing.assert_allclose(port.pieces[0].output.csr((value.size, form.size)) @ x, value, atol=1e-13)


@every_causality
def test_a_ring_turns_about_its_centre_without_strain(causality):
    """On an arc V1 = -W/K0: exact also with the discrete curvature."""
    form = form_of(beam_of(causality, 2, curvature=-0.8))
    spin, radius = 1.7, 1.0 / -0.8
    x = fill(form, V1=lambda s: spin * radius + 0 * s, W3=lambda s: spin + 0 * s)
    motion = {"translation": np.array([spin * radius, 0.0]), "rotation": spin}
    taken = {
        name: np.zeros_like(motion[name.split(".")[1]]) if port.gives else motion[name.split(".")[1]]
        for name, port in form.ports.items()
    }
    rate = square(form, form.J0) @ x + port_forces(form, taken)
    np.testing.assert_allclose(rate[rows_of(form, "N1", "N2", "M3")], 0.0, atol=2e-13)


@every_causality
@pytest.mark.parametrize(("curvature", "angle"), [(0.0, 2.0), (-0.5, -3.0)])
def test_at_the_start_every_read_out_is_the_geometry(causality, curvature, angle):
    end = (1.0 + 1.7 * math.cos(angle), -0.5 + 1.7 * math.sin(angle))
    beam = beam_of(causality, 3, end=end, curvature=curvature, elements=7)
    form, start = form_of(beam), np.array([1.0, -0.5])
    history = at_rest(form)
    for place in (0.0, 0.11, 1.0):
        s = place * beam.length
        here = start + arc(curvature, beam.start_angle, np.array([s]))
        np.testing.assert_allclose(form.angle(history, place), beam.start_angle + curvature * s, rtol=1e-13)
        np.testing.assert_allclose(start + form.chord(history, 0.0, place), here, atol=1e-12)
        np.testing.assert_allclose(form.position(history, place), here, atol=1e-12)
    np.testing.assert_allclose(form.chord(history, 0.0, 1.0)[0], np.array(end) - start, atol=1e-12)
    np.testing.assert_allclose(form.chord(history, 0.8, 0.1), -form.chord(history, 0.1, 0.8), atol=1e-14)
    assert form.chord(history, 0.4, 0.4).tolist() == [[0.0, 0.0]]
    assert form.points is not None
    centre = form.points.mass @ form.points.start / form.points.mass.sum()
    np.testing.assert_allclose(start + form.mean_chord(history)[0], centre, atol=1e-12)


@every_causality
def test_a_bent_and_stretched_beam_is_read_exactly(causality):
    """Angle, strain and position of a known deformed shape, from nodal values, whatever is continuous where."""
    beam = beam_of(causality, 3, start=(0.0, 0.0), end=(2.0, 0.0), elements=4)
    form = form_of(beam)
    c = dict(zip(("N1", "N2", "M3"), form.compliance[[6, 7, 11]], strict=True))

    def turn(s):  # about the initial orientation
        return 0.1 * s + 0.05 * s**2 - 0.02 * s**3

    x = fill(
        form,
        M3=lambda s: (0.1 + 0.1 * s - 0.06 * s**2) / c["M3"],
        N1=lambda s: (0.02 - 0.01 * s) / c["N1"],
        N2=lambda s: 0.03 * s / c["N2"],
        V1=lambda s: s**2,
    )
    theta = np.concatenate([turn(run.positions) for run in form.runs if run.field == "W3"])
    history = History(x[None], theta[None], None)

    def shape(s):  # r' = Lambda (e1 + Gamma), by a fine Simpson rule
        t = np.linspace(0.0, s, 201)
        cos, sin = np.cos(turn(t)), np.sin(turn(t))
        g1, g2 = 1.02 - 0.01 * t, 0.03 * t
        weights = np.full(t.size, 2.0)
        weights[1::2], weights[0], weights[-1] = 4.0, 1.0, 1.0
        return np.array([weights @ (cos * g1 - sin * g2), weights @ (sin * g1 + cos * g2)]) * (t[1] - t[0]) / 3.0

    for place in PLACES:
        s = 2.0 * place
        np.testing.assert_allclose(form.angle(history, place), turn(s), atol=1e-13)
        np.testing.assert_allclose(form.chord(history, 0.0, place)[0], shape(s), atol=1e-9)
        np.testing.assert_allclose(form.value(history, "V1", place), s**2, atol=1e-13)
        np.testing.assert_allclose(form.value(history, "N1", place) * c["N1"], 0.02 - 0.01 * s, atol=1e-14)
        np.testing.assert_allclose(form.value(history, "M3", place) * c["M3"], 0.1 + 0.1 * s - 0.06 * s**2, atol=1e-13)
    elements, xi, weights = quadrature(form.mesh)
    spots = np.array(
        [shape(form.mesh.boundaries[e] + t * form.mesh.lengths[e]) for e, t in zip(elements, xi, strict=True)]
    )
    moved = History(x[None], theta[None], spots[None])
    for place in (0.0, 0.3, 1.0):  # from the points: the projection onto cubics leaves little
        np.testing.assert_allclose(form.position(moved, place)[0], shape(2.0 * place), atol=2e-5)
    np.testing.assert_allclose(form.mean_chord(history)[0], weights @ spots / weights.sum(), atol=1e-9)


@every_causality
def test_mass_points_weigh_the_beam(causality):
    form = form_of(beam_of(causality, 2, curvature=0.3))
    points = form.points
    assert points is not None
    assert points.mass.sum() == pytest.approx(1.3 * form.mesh.boundaries[-1], rel=1e-14)
    x = fill(form, V1=lambda s: 1.0 + s, V2=lambda s: 2.0 - s)
    elements, xi, _ = quadrature(form.mesh)
    s = form.mesh.boundaries[elements] + xi * form.mesh.lengths[elements]
    velocity = points.velocity.csr((2 * s.size, form.size)) @ x
    np.testing.assert_allclose(velocity.reshape(-1, 2), np.stack([1.0 + s, 2.0 - s], axis=1), atol=1e-14)


@every_causality
def test_a_rigid_start_moves_every_end_as_the_body(causality):
    beam = beam_of(causality, 2, curvature=0.3, elements=6)
    form = form_of(beam)
    v, spin, about = np.array([0.3, -0.2]), 1.1, np.array([0.5, 0.5])
    x = form.moving(v, spin, about)
    assert not x[rows_of(form, "N1", "N2", "M3")].any()
    for anchor in (beam.start, beam.end):
        if form.ports[anchor.translation.name].gives:
            material = form.ports[anchor.translation.name].pieces[0].output.csr((2, form.size)) @ x
            c, s = math.cos(anchor.angle), math.sin(anchor.angle)
            lever = anchor.position - about
            expected = v + spin * np.array([-lever[1], lever[0]])
            np.testing.assert_allclose(np.array([[c, -s], [s, c]]) @ material, expected, atol=1e-13)


def test_which_ends_know_their_orientation():
    form = form_of(beam_of("clamped-free"))
    assert form.orientations["start"] is None  # takes its angular velocity, and with it its orientation
    free = form.orientations["end"]
    assert free is not None and free.reference[0] == pytest.approx(math.atan2(1.4, 1.0))
    assert free.rows.values.tolist() == [1.0]


def test_unknown_fields_and_untracked_positions():
    form = form_of(beam_of("free-free"))
    history = at_rest(form)
    for name in ("V3", "M1", "x", "N"):
        with pytest.raises(UnknownNameError, match=rf"V1, V2, W3, N1, N2, M3, got '{name}'"):
            form.value(history, name, 0.5)
    with pytest.raises(UnknownNameError, match="tracks positions"):
        form.position(History(history.x, history.theta, None), 0.5)


def test_a_block_without_read_outs_says_so():
    none = Triplets.empty()
    form = Form(0, (), none, none, none, Triplets.empty(3), {})
    history = History(np.zeros((1, 0)), np.zeros((1, 0)), None)
    for read in (
        lambda: form.value(history, "V1", 0.0),
        lambda: form.angle(history, 0.0),
        lambda: form.position(history, 0.0),
        lambda: form.chord(history, 0.0, 1.0),
        lambda: form.mean_chord(history),
    ):
        with pytest.raises(UnknownNameError, match="expected a block with"):
            read()
    assert form.moving(np.ones(2), 1.0, np.zeros(2)).size == 0


@pytest.mark.parametrize("curvature", [0.0, 1e-9, 0.7, -2.0])
def test_arcs(curvature):
    """r' is the unit tangent and turns with the curvature."""
    s, h = np.linspace(0.0, 1.5, 7), 1e-5
    slope = (arc(curvature, 0.3, s + h) - arc(curvature, 0.3, s - h)) / (2 * h)
    angle = 0.3 + curvature * s
    np.testing.assert_allclose(slope, np.stack([np.cos(angle), np.sin(angle)], axis=1), atol=1e-9)
    np.testing.assert_array_equal(arc(curvature, 0.3, np.zeros(1)), np.zeros((1, 2)))
