"""Scenes written with spatial data: the components that are left, and the same answer as with all twelve."""

import numpy as np
import pytest

import phblocks as ph

SECTION = ph.Section(axial=2e3, shear=(1e3, 1.2e3), bending=(10.0, 15.0), mass=1.0, rotary=(2e-2, 3e-2), torsion=8.0)
LINEAR = ph.Approximation(large_rotation=False)
ELEMENTS = 6
#: States of one component of a clamped-free beam: 6 of one side of the switch, 6 of the other and the continued one.
COUNT = 7
#: Fields of one direction.
PAIRS = (("V1", "N1"), ("W3", "M3"))


def cantilever(force=None, moment=None, start=(0.0, 0.0, 0.0), end=(1.0, 0.0, 0.0), follows=True, **options):
    d = ph.Diagram("cantilever")
    beam = d.add(ph.Beam("beam", SECTION, start, end, ELEMENTS, **options))
    d.weld(d.ground, beam.start)
    if force is not None:
        d.connect(beam.end.translation, d.add(ph.Force("F", force, follows=follows)).port)
    if moment is not None:
        d.connect(beam.end.rotation, d.add(ph.Moment("M", moment, follows=follows)).port)
    return d, beam


def fields(system):
    """The fields that are computed."""
    whole = ("orientation", "positions", "nonlinearity")
    return [e.name for e in system.effects.select(status="kept") if e.name not in whole]


def readings(beam):
    return [
        *(lambda s, p=p: s.velocity(beam, p, frame="material") for p in (0.0, 0.4, 1.0)),
        *(lambda s, p=p: s.spin(beam, p) for p in (0.4, 1.0)),
        *(lambda s, p=p: s.force(beam, p) for p in (0.0, 0.6)),
        *(lambda s, p=p: s.moment(beam, p) for p in (0.0, 0.6)),
        lambda s: s.energy.total,
    ]


def assert_alike(d, beam, t_end=0.5, dt=0.01, more=()):
    """The pruned run is the whole one, to 1e-12 of the largest value of each reading, and keeps energy."""
    pruned, whole = d.compile(), d.compile(effects="all")
    mine, theirs = (ph.simulate(s, t_end, dt) for s in (pruned, whole))
    moved = 0
    for read in [*readings(beam), *more]:
        a, b = read(mine), read(theirs)
        assert a.shape == b.shape
        np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-12 * np.abs(b).max())
        moved += bool(np.abs(b).max() > 0.0)
    assert moved >= 4
    for run in (mine, theirs):
        gained = run.energy.total - run.energy.total[0] - run.energy.supplied
        assert np.abs(gained).max() <= 1e-12 * run.energy.total.max()
    return pruned, whole, mine


CASES = {
    "axial": ({"force": (1.0, 0.0, 0.0)}, "V1 N1"),
    "torsion": ({"moment": (1.0, 0.0, 0.0)}, "W1 M1"),
    "plane": ({"force": (1.0, 2.0, 0.0)}, "V1 V2 W3 N1 N2 M3"),
    "plane by a moment": ({"moment": (0.0, 0.0, 2.0)}, "V1 V2 W3 N1 N2 M3"),
    "the other plane": ({"force": (0.0, 0.0, 2.0)}, "V1 V3 W2 N1 N3 M2"),
    "across, linear": ({"force": (0.0, 2.0, 0.0), "approximation": LINEAR}, "V2 W3 N2 M3"),
    "across the other way, linear": ({"force": (0.0, 0.0, 2.0), "approximation": LINEAR}, "V3 W2 N3 M2"),
    "all": (
        {"force": (1.0, 2.0, 1.0), "moment": (1.0, 0.0, 0.0)},
        "V1 V2 V3 W1 W2 W3 N1 N2 N3 M1 M2 M3",
    ),
}


@pytest.mark.parametrize(("scene", "left"), CASES.values(), ids=CASES)
def test_what_is_left_and_what_comes_out(scene, left):
    loads = {
        key: (lambda t, v=v: np.array(v) * np.sin(3.0 * t)) if key == "approximation" else v
        for key, v in scene.items()
        if key != "approximation"
    }
    small = 1e-2 if "approximation" in scene else 1.0  # the linear theory is one of small turns
    loads = {key: tuple(small * c for c in v) for key, v in loads.items()}
    options = {key: v for key, v in scene.items() if key == "approximation"}
    d, beam = cantilever(**loads, **options)
    pruned, whole, run = assert_alike(d, beam)
    assert fields(pruned) == left.split()
    assert (pruned.n, whole.n) == (COUNT * len(left.split()), 12 * COUNT)
    # the state of one component alone is linear: no product of two that differ from zero is left
    assert pruned.linear == (len(left.split()) < 6)
    for name in {f"{f}{i}" for f in "VWNM" for i in "123"} - set(left.split()):
        np.testing.assert_array_equal(run.state(f"beam.{name}[0]"), 0.0)


@pytest.mark.parametrize("degree", [1, 2])
def test_a_planar_scene_written_with_spatial_data_is_the_planar_one(degree):
    """Two beams in the x-y plane at an angle, the first on a hinge, with loads in the plane: the same numbers."""
    force, moment = (lambda t: (0.5 * np.sin(4.0 * t), 2.0 * t, 0.0)), (lambda t: np.cos(5.0 * t))
    end = (np.cos(0.5), np.sin(0.5))
    runs = []
    for flat in (True, False):
        d = ph.Diagram("scene")
        put = (lambda p: p) if flat else (lambda p: (*p, 0.0))
        beam = d.add(ph.Beam("beam", SECTION, put((0.0, 0.0)), put(end), 4, degree=degree))
        other = d.add(ph.Beam("other", SECTION, put(end), put((end[0], end[1] + 0.5)), 2, degree=degree))
        d.pin(d.ground, beam.start)
        d.weld(beam.end, other.start)
        pull = (lambda t: force(t)[:2]) if flat else force
        twist = moment if flat else (lambda t: (0.0, 0.0, moment(t)))
        d.connect(other.end.translation, d.add(ph.Force("F", pull, follows=True)).port)
        d.connect(other.end.rotation, d.add(ph.Moment("M", twist, follows=True)).port)
        system = d.compile()
        runs.append((system, beam, other, ph.simulate(system, 1.0, 0.01)))
    (planar, beam, other, flat), (spatial, _, _, run) = runs
    # a function of time could move anything: the spatial run has all twelve components, and finds six of them zero
    translation, rotation = (sum(name.split(".")[1][:2] in pair for name in planar.state_names) for pair in PAIRS)
    assert (planar.n, spatial.n) == (2 * translation + rotation, 3 * (translation + rotation))
    for block in (beam.name, other.name):
        for place in (0.0, 0.3, 1.0):
            for read, inside in (("velocity", [0, 1]), ("force", [0, 1]), ("spin", 2), ("moment", 2)):
                options = {"frame": "material"} if read == "velocity" else {}
                mine = getattr(run, read)(block, place, **options)
                theirs = getattr(flat, read)(block, place, **options)
                size = max(
                    np.abs(getattr(flat, read)(b, p, **options)).max() for b in ("beam", "other") for p in (0, 1)
                )
                np.testing.assert_allclose(mine[:, inside], theirs, rtol=0.0, atol=1e-12 * size)
                assert not np.delete(mine, inside, axis=1).any()
    np.testing.assert_allclose(run.energy.total, flat.energy.total, rtol=1e-12, atol=1e-15)


def test_a_planar_scene_with_constant_loads_has_the_states_of_the_planar_one():
    flat = ph.Diagram("flat")
    beam = flat.add(ph.Beam("beam", SECTION, (0.0, 0.0), (1.0, 0.0), ELEMENTS))
    flat.weld(flat.ground, beam.start)
    flat.connect(beam.end.translation, flat.add(ph.Force("F", (1.0, 2.0), follows=True)).port)
    d, _ = cantilever((1.0, 2.0, 0.0))
    mine, theirs = d.compile(), flat.compile(outputs=None)
    assert mine.state_names == theirs.state_names
    assert abs(mine.J0 - theirs.J0).max() == abs(mine.E - theirs.E).max() == 0.0
    a, b = (ph.simulate(s, 0.5, 0.01) for s in (mine, theirs))
    np.testing.assert_allclose(a.x, b.x, rtol=0.0, atol=1e-12 * np.abs(b.x).max())


def test_a_line_load_along_the_beam_leaves_two_fields_and_across_it_six():
    for force, left in (((3.0, 0.0, 0.0), 2), ((0.0, 3.0, 0.0), 6), ((0.0, 3.0, 1.0), 12)):
        d, beam = cantilever(loads=ph.LineLoad("wind", force, follows=True))
        pruned, whole, _ = assert_alike(d, beam)
        assert 12 * pruned.n == left * whole.n


def test_a_start_that_moves_something_else_is_refused():
    d, _ = cantilever((1.0, 0.0, 0.0))
    pruned, whole = d.compile(), d.compile(effects="all")
    spinning = whole.rigid_motion(spin=(0.0, 0.1, 0.0))
    assert ph.simulate(whole, 0.01, 0.01, start=spinning).status.ok
    with pytest.raises(ph.errors.PrunedError, match="V3 of 'beam'"):
        pruned.rigid_motion(spin=(0.0, 0.1, 0.0))


@pytest.mark.parametrize("along", range(3))
def test_frames_that_stay_let_a_fixed_load_through(along):
    """Linear scenes: of a beam along an axis of the fixed frame a force along it leaves two fields, one across four."""
    axis, across = np.eye(3)[along], np.eye(3)[(along + 1) % 3]
    d, beam = cantilever(tuple(1e-2 * axis), end=tuple(axis), follows=False, approximation=LINEAR)
    more = [lambda s: s.position(beam, 1.0), lambda s: s.position(beam, 0.3, source="strain")]
    pruned, _, run = assert_alike(d, beam, more=more)
    assert fields(pruned) == ["V1", "N1"]
    stretch = (run.position(beam, 1.0) - axis) @ axis
    assert 9e-6 < stretch.max() < 10.1e-6  # suddenly pulled: at most twice F L / EA = 5e-6 m
    d, beam = cantilever(tuple(1e-2 * across), end=tuple(axis), follows=False, approximation=LINEAR)
    pruned, _, _ = assert_alike(d, beam, more=more)
    assert len(fields(pruned)) == 4 and fields(pruned)[0] in ("V2", "V3")
