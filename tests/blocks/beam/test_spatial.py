"""A beam in space in its own coordinates: matrices of any frame, starts, what is read without large rotations."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.blocks.form import FIXED, History
from phblocks.errors import DataError, OrientationError, SpaceError

SECTION = ph.Section(axial=2e3, shear=(1e3, 1.2e3), bending=(10.0, 15.0), mass=1.5, rotary=(2e-2, 3e-2), torsion=8.0)
LINEAR = ph.Approximation(large_rotation=False)
END = (1.0, 2.0, -2.0)
FREE = dict.fromkeys(("start.translation", "start.rotation", "end.translation", "end.rotation"), True)
TAKING = dict.fromkeys(FREE, False)
MIXED = {**FREE, "start.translation": False, "end.rotation": False}


def beam(**options):
    return ph.Beam("beam", SECTION, (0.0, 0.0, 0.0), **{"end": END, "elements": 4, "degree": 2, **options})


@pytest.mark.parametrize("gives", [FREE, TAKING, MIXED], ids=["free", "taking", "mixed"])
def test_matrices_do_not_depend_on_where_it_is(gives):
    here, there = beam().form(gives), beam(end=(0.0, 3.0, 0.0), normal=(1.0, 0.0, 0.4)).form(gives)
    for mine, theirs in ((here.E, there.E), (here.J0, there.J0), (here.T, there.T)):
        np.testing.assert_array_equal(np.stack(mine.indices), np.stack(theirs.indices))
        np.testing.assert_allclose(mine.values, theirs.values, rtol=1e-14)
    assert here.unoriented and here.points is None and not here.rotation_states.size
    assert [run.field for run in here.runs] == [f"{f}{i}" for f in "VWNM" for i in (1, 2, 3)]


@pytest.mark.parametrize("curvature", [None, 0.5])
def test_a_rigid_motion_is_the_velocity_of_every_cross_section(curvature):
    """And keeps its energy: 1/2 m v^2 + 1/2 w I w about the centre of mass, of a straight rod."""
    body = beam(curvature=curvature, elements=8)
    form = body.form(FREE)
    v, w, about = np.array([0.3, -0.2, 0.5]), np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.2, 0.3])
    x = form.moving(v, w, about)
    for s in (0.0, 0.25, 1.0):  # nodes
        at, frame = body.placement.at(np.array([s * body.length]))[0], body.placement.frame(s * body.length)
        velocity = [form.value(History(x[None], np.empty((1, 0)), None), f"V{i}", s)[0] for i in (1, 2, 3)]
        spin = [form.value(History(x[None], np.empty((1, 0)), None), f"W{i}", s)[0] for i in (1, 2, 3)]
        np.testing.assert_allclose(velocity, frame.T @ (v + np.cross(w, at - about)), atol=1e-13)
        np.testing.assert_allclose(spin, frame.T @ w, atol=1e-13)
    if curvature is None:
        mass, axes, length = 1.5 * body.length, body.placement.axes, body.length
        rod = np.array([0.0, mass * length**2 / 12.0, mass * length**2 / 12.0])
        local = axes.T @ w
        of_section = length * np.array([5e-2, 2e-2, 3e-2])
        centre = v + np.cross(w, 0.5 * np.array(END) - about)
        energy = 0.5 * mass * centre @ centre + 0.5 * local @ ((rod + of_section) * local)
        E = form.E.csr((form.size, form.size))
        assert 0.5 * x @ (E @ x) == pytest.approx(energy, rel=1e-13)


@pytest.mark.parametrize("gives", [FREE, TAKING, MIXED], ids=["free", "taking", "mixed"])
@pytest.mark.parametrize("curvature", [None, 0.4])
def test_small_turns_are_read_as_positions(gives, curvature):
    """A small rigid turn about the start: from strain (theta = turn, no strain) every place moves by turn x lever."""
    body = beam(curvature=curvature, elements=16, approximation=LINEAR)
    form = body.reduced_form(gives)
    assert form.frozen and not form.unoriented and not form.T.values.size
    turn = np.array([1e-3, -2e-3, 1.5e-3])
    moved = form.moving(np.zeros(3), turn, np.zeros(3))
    theta = moved[form.rotation_states]
    assert theta.size == form.rotation_states.size > 0
    history = History(np.zeros((1, form.size)), theta[None], None)
    for first, second in ((0.0, 1.0), (0.2, 0.65), (0.9, 0.1)):
        span = np.diff(body.placement.at(body.length * np.array([first, second])), axis=0)[0]
        expected = span + np.cross(turn, span)
        # on an arc the small turns of frames are interpolated, and to first order where W is discontinuous
        close = 1e-15 if curvature is None else 1e-6
        np.testing.assert_allclose(form.chord(history, first, second)[0], expected, atol=close)
    # the same from velocity: the material points move by turn x place
    points = form.points
    rates = points.velocity.csr((points.start.size, form.size)) @ moved
    close = 1e-15 if curvature is None else 1e-5
    np.testing.assert_allclose(rates.reshape(-1, 3), np.cross(turn, points.start), atol=close)
    history = History(np.zeros((1, form.size)), theta[None], (points.start + rates.reshape(-1, 3))[None])
    for s in (0.0, 0.37, 1.0):
        at = body.placement.at(np.array([s * body.length]))[0]
        np.testing.assert_allclose(form.position(history, s)[0], at + np.cross(turn, at), atol=max(close, 1e-14))


def test_reading_an_arc_from_small_turns_converges():
    """Where W is discontinuous theta is to first order in the arc of an element: the error falls with its square."""
    errors = []
    for elements in (4, 8, 16):
        body = beam(curvature=0.4, elements=elements, degree=1, approximation=LINEAR)
        form = body.reduced_form(TAKING)
        turn = np.array([1.0, -2.0, 1.5])
        theta = form.moving(np.zeros(3), turn, np.zeros(3))[form.rotation_states]
        span = body.placement.at(np.array([0.3 * body.length]))[0]
        read = form.chord(History(np.zeros((1, form.size)), theta[None], None), 0.0, 0.3)[0]
        errors.append(np.abs(read - span - np.cross(turn, span)).max())
    assert (np.log2(np.array(errors[:-1]) / errors[1:]) > 1.7).all() and errors[-1] < 1e-3


def test_loads_are_sums_of_velocities_along_the_beam():
    wind, snow = ph.LineLoad("wind", (1.0, 2.0, 3.0), follows=True), ph.LineLoad("snow", (0.0, 0.0, -1.0))
    body = beam(loads=(wind, snow), approximation=LINEAR)
    form = body.reduced_form(FREE)
    v = np.array([0.3, -0.2, 0.5])
    x = form.moving(v, np.zeros(3), np.zeros(3))
    for name, frame in (("load wind", body.placement.axes.T), ("load snow", np.eye(3))):
        (piece,) = form.loads[name]
        assert piece.frame is FIXED
        np.testing.assert_allclose(piece.output.csr((3, form.size)) @ x, body.length * frame @ v, atol=1e-14)


def test_what_is_refused():
    with pytest.raises(DataError, match=r"Section torsion: expected GJ for a spatial beam"):
        ph.Beam("b", ph.Section(1.0, 1.0, 1.0, 1.0, 1.0), (0, 0, 0), (1, 0, 0), 2)
    with pytest.raises(SpaceError, match=r"loads 'wind': expected 3 components on a spatial beam, got 2"):
        beam(loads=ph.LineLoad("wind", (1.0, 2.0)))
    with pytest.raises(SpaceError, match=r"loads 'wind': expected 2 components on a planar beam, got 3"):
        ph.Beam("b", SECTION, (0, 0), (1, 0), 2, loads=ph.LineLoad("wind", (1.0, 2.0, 3.0)))
    with pytest.raises(OrientationError, match=r"flexible=False: expected a planar beam"):
        beam(approximation=ph.Approximation(flexible=False)).choices()
    form = beam().form(FREE)
    history = History(np.zeros((1, form.size)), np.empty((1, 0)), None)
    for read in (lambda: form.position(history, 0.5), lambda: form.chord(history, 0.0, 1.0)):
        with pytest.raises(OrientationError, match=r"position on a beam in space: .*one that turns"):
            read()
    with pytest.raises(OrientationError, match=r"angle of a beam in space"):
        form.angle(history, 0.5)


def test_pieces_of_a_cut_beam_lie_on_it():
    whole = beam(curvature=0.5, normal=(0.1, 0.2, 1.0))
    first, second = whole.split(0.3)
    np.testing.assert_allclose(first.end.position, whole.placement.at(np.array([0.3 * whole.length]))[0], atol=1e-15)
    assert first.length + second.length == pytest.approx(whole.length)
    np.testing.assert_allclose(first.end.frame, second.start.frame, atol=1e-14)
    np.testing.assert_allclose(first.start.frame, whole.start.frame, atol=1e-14)
    np.testing.assert_allclose(second.end.frame, whole.end.frame, atol=1e-14)
