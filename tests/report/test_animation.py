"""Films: as many pictures as asked for, of the deformed shapes, coloured by what the beams carry."""

import subprocess
import sys

import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

import phblocks as ph
from phblocks.report.animation import draw_scene, nearest_frames
from phblocks.report.scene import make_scene


@pytest.fixture(scope="module")
def loaded(bar):
    """A cantilever that a force at its tip bends, damped until it is at rest."""
    d = ph.Diagram("cantilever")
    beam = d.add(ph.Beam("beam", bar, (0.0, 0.0), (2.0, 0.0), elements=4, degree=2, damping=ph.Damping(internal=0.01)))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "tip")
    return beam, ph.simulate(d.compile(), t_end=2.0, dt=0.01, inputs={"tip": (0.0, -100.0)})


def test_colours_are_moment_and_energy(loaded, bar):
    """Statics: M = -F (l - s), and the energy a length F^2 (l - s)^2 / (2 EI) + F^2 / (2 GA)."""
    _, solution = loaded
    s = 2.0 * np.array(solution.system.part("beam").form.outline())
    last = np.array([solution.t.size - 1])
    moment = make_scene(solution, last, "moment").lines[0].values[0]
    density = make_scene(solution, last, "energy").lines[0].values[0]
    np.testing.assert_allclose(moment, -100.0 * (2.0 - s), atol=0.5)
    expected = (100.0 * (2.0 - s)) ** 2 / (2.0 * bar.bending[-1]) + 100.0**2 / (2.0 * np.atleast_1d(bar.shear)[0])
    np.testing.assert_allclose(density, expected, atol=5e-3 * expected.max())
    total = np.trapezoid(density, s)
    assert total == pytest.approx(solution.energy["strain"][-1], rel=0.01)


def test_frames(loaded):
    _, solution = loaded
    assert solution.t[nearest_frames(solution, 5, 100)] == pytest.approx([0.0, 0.5, 1.0, 1.5, 2.0])
    assert nearest_frames(solution, 10_000, 40).size == 40


def test_drawn_shapes_are_the_solution(four_bar):
    d = four_bar()
    coupler = d.network.blocks["coupler"]
    solution = ph.simulate(d.compile(), t_end=0.5, dt=0.02)
    scene = make_scene(solution, nearest_frames(solution, 6, 6), trails=[coupler.at(0.5)])
    figure, update = draw_scene(scene)
    update(5)
    collections = {c.get_label(): c for c in figure.axes[0].collections}
    assert list(collections) == ["crank", "coupler", "rocker"]
    ends = collections["coupler"].get_segments()
    assert ends[0][0] == pytest.approx(solution.position("coupler", 0.0)[-1])
    assert ends[-1][1] == pytest.approx(solution.position("coupler", 1.0)[-1])
    lines = {line.get_label(): line for line in figure.axes[0].lines}
    trail = lines["trail of coupler at 0.5"].get_xydata()
    assert trail[-1] == pytest.approx(solution.position("coupler", 0.5)[-1]) and len(trail) == 6
    np.testing.assert_allclose(sorted(lines["ground"].get_xydata().tolist()), [[0.0, 0.5], [2.5, 0.5]])
    assert figure.axes[1].get_ylabel() == "bending moment (N m)"
    plt.close(figure)


def test_springs_and_masses(tmp_path):
    """A spring is a line from end to end, a mass a dot."""
    d = ph.Diagram("oscillator", gravity=(0.0, -9.81))
    mass = d.add(ph.Mass("mass", 1.0, (0.0, -1.0)))
    spring = d.add(ph.Spring("spring", 50.0, (0.0, 0.0), (0.0, -1.0)))
    d.pin(spring.start, d.ground)
    d.pin(spring.end, mass.centre)
    solution = ph.simulate(d.compile(), t_end=1.0, dt=0.01)
    scene = make_scene(solution, np.arange(solution.t.size))
    lines = {line.name: line for line in scene.lines}
    assert lines["mass"].dot and not lines["spring"].dot
    np.testing.assert_allclose(lines["spring"].places[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(lines["spring"].places[:, 1], solution.position(mass.centre), atol=1e-3)
    assert scene.largest == 0.0 and solution.animate(tmp_path / "x.html").exists()


def test_gif(four_bar, tmp_path):
    solution = ph.simulate(four_bar().compile(), t_end=0.2, dt=0.02)
    path = solution.animate(tmp_path / "x.gif", fps=20.0, colour="energy")
    with Image.open(path) as film:
        assert film.n_frames == 5
        film.seek(4)
        assert np.asarray(film.convert("L")).std() > 5.0


def test_mp4(four_bar, tmp_path):
    """Read back by the program that wrote it: as many pictures as asked for, none of them empty."""
    ffmpeg = pytest.importorskip("imageio_ffmpeg").get_ffmpeg_exe()
    path = ph.simulate(four_bar().compile(), t_end=0.2, dt=0.02).animate(tmp_path / "x.mp4", fps=20.0)
    subprocess.run([ffmpeg, "-loglevel", "error", "-i", str(path), str(tmp_path / "%d.png")], check=True)
    pictures = []
    for number in range(1, len(list(tmp_path.glob("*.png"))) + 1):
        with Image.open(tmp_path / f"{number}.png") as picture:
            pictures.append(np.asarray(picture.convert("L")))
    assert len(pictures) == 5 and all(picture.std() > 5.0 for picture in pictures)
    assert np.abs(pictures[0].astype(float) - pictures[-1]).max() > 50.0  # it moves


def test_no_ffmpeg(four_bar, tmp_path, monkeypatch):
    monkeypatch.setattr("phblocks.report.animation.which", lambda _: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ph.errors.ExtraMissingError, match=r"phblocks\[film\]"):
        ph.simulate(four_bar().compile(), t_end=0.1, dt=0.02).animate(tmp_path / "x.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({"path": "x.avi"}, ph.errors.ExportError),
        ({"path": "x.html", "speed": 0.0}, ph.errors.DataError),
        ({"path": "x.html", "fps": -1.0}, ph.errors.DataError),
        ({"path": "x.html", "colour": "red"}, ph.errors.DataError),
        ({"path": "x.html", "trails": ["beam"]}, ph.errors.ArgumentTypeError),
    ],
)
def test_wrong_arguments(loaded, arguments, error):
    with pytest.raises(error):
        loaded[1].animate(**arguments)
