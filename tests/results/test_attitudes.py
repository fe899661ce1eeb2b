"""Reading runs in space: in the frames of the parts, and in the fixed one where a frame stays."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import OrientationError

SECTION = ph.Section(axial=2e3, shear=(1e3, 1.2e3), bending=(10.0, 15.0), mass=1.0, rotary=(2e-2, 3e-2), torsion=8.0)
END = (0.6, 0.0, 0.8)


@pytest.fixture(scope="module")
def turning():
    """A cantilever that bends far, in two beams."""
    d = ph.Diagram("turning")
    parts = [d.add(part) for part in ph.Beam("arm", SECTION, (0.0, 0.0, 0.0), END, 4, degree=2).split(0.5)]
    d.weld(d.ground, parts[0].start)
    d.weld(parts[0].end, parts[1].start)
    d.expose(parts[1].end.translation, "push", follows=True)
    d.expose(parts[1].end.rotation, "twist", follows=True)
    inputs = {"push": lambda t: (t, 9.0 * t, -5.0 * t), "twist": lambda t: (2.0 * t, t, -t)}
    return *parts, ph.simulate(d.compile(), 0.5, 5e-3, inputs=inputs)


def test_ends_agree_with_the_fields_there(turning):
    first, second, run = turning
    for kind in ("velocity", "force"):
        read = getattr(run, kind)
        np.testing.assert_allclose(
            read(first.end, frame="material"), read(second.start, frame="material"), rtol=0.0, atol=1e-12
        )
    np.testing.assert_allclose(run.spin(first.end), run.spin(second.start), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(run.velocity(first, 1.0, frame="material"), run.velocity(first.end, frame="material"))
    assert run.moment(first.start).shape == run.spin(first, 0.3).shape == (run.t.size, 3)
    # the force of the tip is what is applied there; towards it N is discontinuous
    assert np.abs(run.force(second, 0.95)[-1] - (0.5, 4.5, -2.5)).max() < 0.3


def test_the_fixed_frame_where_it_is_known(turning):
    """At the clamp the frame stays as it was at the start."""
    first, _, run = turning
    frame = first.start.frame
    force = run.force(first.start, frame="fixed")
    np.testing.assert_allclose(force, run.force(first.start) @ frame.T, rtol=1e-14)
    np.testing.assert_allclose(run.force(first, 0.0, frame="fixed"), force)
    assert not run.velocity(first.start).any()
    with pytest.raises(ph.errors.DataError, match="frame"):
        run.velocity(first.start, frame="world")


@pytest.mark.parametrize(
    "read",
    [
        lambda run, beam: run.velocity(beam.end),
        lambda run, beam: run.velocity(beam, 0.5),
        lambda run, beam: run.force(beam.end, frame="fixed"),
        lambda run, beam: run.force(beam, 0.5, frame="fixed"),
        lambda run, beam: run.position(beam.end),
        lambda run, beam: run.position(beam, 0.5, source="strain"),
        lambda run, beam: run.position(beam, 0.5, source="velocity"),
        lambda run, beam: run.angle(beam.end),
        lambda run, beam: run.angle(beam, 0.5),
        lambda run, beam: run.closure(),
        lambda run, beam: run.closure("velocity"),
        lambda run, beam: ph.plots.motion(run),
        lambda run, beam: ph.plots.motion(run, path=beam.end),
        lambda run, beam: run.animate("never.html"),
        lambda run, beam: run.report("never.html"),
    ],
)
def test_what_needs_an_orientation_that_turns_is_refused(turning, read, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    first, _, run = turning
    with pytest.raises(OrientationError, match=r"PH405.*(not computed yet)") as caught:
        read(run, first)
    assert "material" in caught.value.fix or "spin" in caught.value.fix
    assert not list(tmp_path.iterdir())


def test_what_needs_none_works(turning):
    *_, run = turning
    assert run.max_power_balance_error <= 1e-14 * run.energy.total.max()
    ports = {name for pair in run.power.connections for name in pair}
    assert "ground.anchor.translation" not in ports
    assert max(run.power.connection_errors.values(), default=0.0) <= 1e-15
    assert "arm-1" in str(run.power)
    for plot in (ph.plots.energy, ph.plots.power_flow):
        plot(run)


def test_pictures_of_what_stays_are_seen_along_z(tmp_path):
    d = ph.Diagram("linear")
    beam = d.add(ph.Beam("arm", SECTION, (0.0, 0.0, 0.0), END, 4, degree=2))
    d.weld(d.ground, beam.start)
    d.connect(beam.end.translation, d.add(ph.Force("F", lambda t: (0.0, t, 0.0))).port)
    run = ph.simulate(d.compile(approximation=ph.Approximation(large_rotation=False)), 0.2, 0.01)
    axes = ph.plots.motion(run, path=beam.end)
    path, start = axes.get_lines()[0].get_xydata(), axes.get_lines()[1].get_xydata()
    np.testing.assert_allclose(path, run.position(beam.end)[:, :2])
    np.testing.assert_allclose(start[[0, 20]], [[0.0, 0.0], [0.6, 0.0]], atol=1e-14)
    assert run.animate(tmp_path / "run.html").stat().st_size > 0
    assert run.report(tmp_path / "report.html").stat().st_size > 0
