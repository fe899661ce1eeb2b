"""The examples run from the command line, and their numbers are right."""

import importlib.util
import subprocess
import sys
from contextlib import redirect_stdout
from dataclasses import dataclass
from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest

FOLDER = Path(__file__).resolve().parents[2] / "examples"
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(scope="module")
def example():
    """Load an example by name, as a script beside the package is loaded."""

    def load(name):
        spec = importlib.util.spec_from_file_location(f"examples_{name}", FOLDER / f"{name}.py")
        module = importlib.util.module_from_spec(spec)
        sys.modules[spec.name] = module  # dataclasses look there
        spec.loader.exec_module(module)
        return module

    return load


@dataclass
class CommandLine:
    """What an example left when it ran once from the command line."""

    result: Any
    printed: str
    files: list[Path]


@pytest.fixture(scope="module")
def ran(example, tmp_path_factory):
    """Run an example once, by name, as from the command line."""

    @cache
    def run(name):
        out = tmp_path_factory.mktemp(name) / "new" / "folder"
        with redirect_stdout(StringIO()) as printed:
            result = example(name).main(["--out", str(out)])
        return CommandLine(result, printed.getvalue(), sorted(out.iterdir()))

    return run


@pytest.fixture(scope="module")
def four_bar(example):
    return example("four_bar")


@pytest.fixture(scope="module")
def fall(ran):
    return ran("four_bar").result


@pytest.fixture(scope="module")
def cantilever(example):
    return example("cantilever_modes")


def test_every_example_is_tested():
    tests = Path(__file__).read_text(encoding="utf-8")
    assert [p.stem for p in FOLDER.glob("*.py") if f'ran("{p.stem}")' not in tests] == []


@pytest.mark.parametrize(
    ("name", "figures"),
    [
        ("four_bar", 5),
        ("pendulum", 2),
        ("cantilever_modes", 2),
        ("dc_motor_arm", 1),
        ("slider_crank", 1),
        ("spring_lattice", 1),
        ("double_pendulum", 1),
        ("duffing", 1),
        ("matrices_in_a_loop", 1),
        ("accuracy_and_time", 2),
        ("flying_spaghetti", 1),
        ("buckling_column", 2),
        ("snap_through_arch", 1),
        ("rotating_blade", 1),
        ("truss_bridge", 1),
        ("wave_absorber", 1),
        ("falling_chain", 1),
    ],
)
def test_command_line(ran, name, figures):
    found = ran(name)
    assert len(found.files) == figures
    assert all(path.read_bytes().startswith(PNG) and str(path) in found.printed for path in found.files)
    assert plt.get_fignums() == []


# The four-bar, in the setting of the paper


def test_reference_of_the_four_bar(four_bar, references):
    known = references["four_bar"]["P_flexible_t"]
    np.testing.assert_array_equal(four_bar.REFERENCE, [known[str(t)] for t in range(11)])


def test_four_bar_keeps_its_energy(fall):
    assert fall.solution.status.ok
    assert fall.start_energy == pytest.approx(392.0, abs=0.5)
    assert fall.energy_drift < 1e-11 * 392.0
    assert fall.solution.max_power_balance_error < 1e-11 * 392.0


def test_four_bar_stays_closed(fall):
    """By both positions; measured: 9.5e-4 m from strain, 1.2e-4 m from velocity."""
    assert len(fall.gaps) == 4
    assert max(max(gaps) for gaps in fall.gaps.values()) < 2e-3


def test_four_bar_path(fall, four_bar):
    """Measured: 1.1e-3 m from the reference at 1 s; 6e-3 m in time and 7e-3 m in space, which partly cancel."""
    assert fall.P_seconds.shape == (11, 2)
    np.testing.assert_array_equal(fall.P_seconds[0], (2.75, 1.5))
    np.testing.assert_array_equal(fall.P_seconds, fall.P[::50])
    np.testing.assert_array_equal(fall.distances, np.linalg.norm(fall.P[::50] - four_bar.REFERENCE, axis=1))
    assert fall.distances[1] < 1e-2


def test_four_bar_with_finer_elements_and_steps(four_bar):
    """Space is resolved (degree 2); what is left is the error of the midpoint rule in time, 3.5e-4 m at this step."""
    fine = four_bar.run(elements=(4, 4, 4), degree=2, dt=0.005, t_end=1.0)
    assert fine.distances[1] < 5e-4
    assert fine.energy_drift < 1e-11 * 392.0


def test_four_bar_table(fall, four_bar):
    table = four_bar.tabulate(fall)
    assert "t (s)" in table
    assert len([line for line in table.splitlines() if line.strip().split(" ")[0].isdigit()]) == 11
    for gap in (gap for gaps in fall.gaps.values() for gap in gaps):
        assert f"{gap:.1e}" in table
    assert "Newton iterations a step" in table
    assert f"{fall.wall_time:.2f} s" in table


def test_figure_of_the_readme(four_bar):
    """It is there, small, and has the name of a figure of this example."""
    root = FOLDER.parent
    [line] = [line for line in (root / "README.md").read_text(encoding="utf-8").splitlines() if line.startswith("![")]
    assert line.endswith("](docs/images/four_bar.png)")
    picture = (root / "docs" / "images" / "four_bar.png").read_bytes()
    assert picture.startswith(PNG)
    assert len(picture) < 80_000


def test_command_of_the_readme():
    """One line from nothing to tables and figures."""
    lines = (FOLDER.parent / "README.md").read_text(encoding="utf-8").splitlines()
    [command] = [line for line in lines if "examples/" in line and " && " in line]
    assert command.startswith("python3 -m venv .venv && ")
    assert command.endswith(" && .venv/bin/python examples/four_bar.py")


# Pendulums


@pytest.fixture(scope="module")
def swing(ran):
    return ran("pendulum").result


def test_rubber_pendulum(swing, references):
    known = references["rubber_pendulum"]
    for tip in swing.tips.values():
        np.testing.assert_allclose(tip, known["tip(1)"], rtol=0.0, atol=known["tolerance"])


def test_rigid_pendulum(swing, references):
    """Measured: 2e-7 rad and 3.5e-6 s, both from the step of 1e-3 s and from how stiff the bar is."""
    known = references["rigid_pendulum"]["uniform bar L=1 from horizontal"]
    assert swing.angle == pytest.approx(known["theta(1)_from_downward"], abs=1e-6)
    assert swing.period == pytest.approx(known["period_s"], abs=1e-5)


# The cantilever


def test_reference_of_the_cantilever(cantilever, references):
    known = references["timoshenko_frequencies_rad_s"]
    np.testing.assert_array_equal(cantilever.BENDING, known["modes"]["clamped-free"])
    section = cantilever.SECTION
    assert [section.bending, section.mass, section.rotary, section.axial, section.shear] == pytest.approx(
        [known["beam"][name] for name in ("EI", "rhoA", "rhoI", "EA", "kGA")], rel=1e-15
    )


def test_cantilever_frequencies(ran):
    """16 elements of degree 3."""
    result = ran("cantilever_modes").result
    assert result.axial.tolist() == [False, False, True, False, False, False, True, False]
    assert np.abs(result.errors).max() < 2e-5
    assert np.abs(result.errors[0]) < 1e-10


def test_cantilever_convergence(cantilever):
    """Order 2 k, and small in the end."""
    for k, bound in ((1, 1e-4), (2, 1e-7), (3, 1e-11)):
        error = cantilever.converge(degrees=(k,))[k][:, 0]
        assert np.log2(error[-2] / error[-1]) == pytest.approx(2.0 * k, abs=0.2)
        assert error[-1] < bound


def test_cantilever_shapes(cantilever, ran):
    """The mode i of bending has i - 1 nodes; all start at the clamp and are largest at the tip."""
    result = ran("cantilever_modes").result
    for nodes, mode in enumerate(np.flatnonzero(~result.axial)[:4]):
        place, value = cantilever.deflection(result, mode)
        assert (np.diff(place) >= 0.0).all()
        assert np.abs(value[0]) < 0.05
        assert value[-1] == pytest.approx(1.0)
        inner = value[np.abs(value) > 0.02]
        assert (np.diff(np.sign(inner)) != 0).sum() == nodes


def test_motor_and_arm(ran):
    found = ran("dc_motor_arm").result
    # the arm is so soft that its root overshoots the speed without load, to which all settles: 12 V / (20 * 0.05 V s)
    assert found.rigid[-1] == pytest.approx(12.0, rel=1e-9)
    assert found.speed[-200:].mean() == pytest.approx(12.0, rel=5e-3)
    assert np.degrees(found.lag) == pytest.approx(14.84, rel=1e-2)  # 14.84 with 8 elements and half the step
    assert found.energy_error < 1e-11 * found.solution.energy.supplied[-1]
    assert "of it heat in the winding 1.2597" in ran("dc_motor_arm").printed


def test_slider_crank(ran):
    found = ran("slider_crank").result
    assert found.solution.status.ok
    # quasi-static: the rod's first frequency is 580 rad/s, the crank turns with 40 rad/s; measured: 0.5 % of the bow
    assert np.abs(found.bow_static).max() == pytest.approx(4.82e-4, rel=2e-3)
    assert np.abs(found.bow - found.bow_static).max() < 0.01 * np.abs(found.bow_static).max()
    assert found.angle[-1] == pytest.approx(40.0 * (0.7 - 0.5 * 0.3), rel=1e-6)
    assert np.abs(found.piston - found.piston_rigid).max() < 1e-5  # measured: 4.8e-6
    assert found.guide < 1e-12
    kinetic = found.solution.energy.kinetic.max()
    assert found.energy_error < 1e-11 * kinetic and found.solution.max_power_balance_error < 1e-11 * kinetic
    assert "largest bow 0.4836 mm" in ran("slider_crank").printed


def test_spring_lattice(ran):
    """Measured: 2e-13 rad/s; the run is as good as interpolated zeros of a swing are."""
    found = ran("spring_lattice").result
    assert found.found.size == 32
    np.testing.assert_allclose(found.found, found.exact, rtol=1e-12)
    assert found.swing == pytest.approx(found.swing_exact, rel=1e-5)
    assert np.ptp(found.solution.energy.total) < 1e-11 * found.solution.energy.total[0]


def test_double_pendulum(ran, references, example):
    found = ran("double_pendulum").result
    np.testing.assert_array_equal(
        example("double_pendulum").REFERENCE, references["double_pendulum_uniform_bars"]["theta(1)"]
    )
    assert len(found.constraints) == 4
    assert not any(s.system.is_dae for s in found.flexible.values())
    # measured at the end: 4.2e-5 and 5.0e-5, of which 8e-6 of the beams is not an error in time
    for errors, off in ((found.rigid_errors, 0.05), (found.flexible_errors, 0.12)):
        largest = np.abs(errors).max(axis=1)
        np.testing.assert_allclose(np.log2(largest[:-1] / largest[1:]), 2.0, atol=off)
        assert largest[-1] < 1e-4
    for solution in (*found.rigid.values(), *found.flexible.values()):
        assert np.ptp(solution.energy.total) < 1e-11


# What accuracy costs


def test_accuracy_and_time(ran, example):
    """The setting that is chosen keeps what it promises; orders of a sudden release are rough, measured: 2.13."""
    found, module = ran("accuracy_and_time").result, example("accuracy_and_time")
    assert len(found.study) == 18 and all(row.ok for row in found.study)
    assert found.cheapest.error_bound <= module.TOLERANCE
    assert found.again == pytest.approx(found.cheapest.error, rel=1e-6)
    slower = found.study.filter(lambda row: row.error_bound <= module.TOLERANCE)
    assert found.cheapest.seconds == min(slower.column("seconds"))
    assert found.orders.order == pytest.approx(2.0, abs=0.3)
    assert f"cheapest to {module.TOLERANCE:g} m:" in ran("accuracy_and_time").printed


# Large motions and loss of stability


def test_flying_spaghetti(ran, references, example):
    command, module = ran("flying_spaghetti"), example("flying_spaghetti")
    found, known = command.result, references["flying_spaghetti_2d"]
    for time, ends in found.ends.items():
        np.testing.assert_array_equal(
            module.REFERENCE[time], [known[f"t={time:g}"][e] for e in ("loaded_end", "other_end")]
        )
        assert np.abs(ends - module.REFERENCE[time]).max() < known["tolerance"]
    assert found.energy_drift < 1e-11 * found.solution.energy.supplied[-1]
    assert 1e-3 < np.abs(found.momentum - [20.0, 0.0]).max() < 1.1e-2  # kept to second order only
    assert f"{found.solution.energy.supplied[-1]:.4f} J" in command.printed


def test_buckling_column(ran, example):
    """Southwell's line and the elastica; both are those of slender columns (L/h = 200)."""
    command, module = ran("buckling_column"), example("buckling_column")
    found = command.result
    np.testing.assert_allclose(found.frequencies, found.theory, rtol=1e-3)
    assert abs(module.EULER - 431.8) < 0.05  # pi^2 * 2.1e11 * 0.02 * 0.005^3 / 12
    assert found.shortening[-1] == pytest.approx(found.elastica, rel=1e-3)
    assert module.elastica(1.0 + 1e-9) == pytest.approx(0.0, abs=1e-6)
    before = found.force < 0.9
    assert np.abs(found.shortening[before]).max() < 1e-3 < 0.4 < found.shortening[-1]
    assert f"{found.shortening[-1]:.5f} m" in command.printed


def test_snap_through_arch(ran):
    """A moved crown has a limit of force; a loaded one jumps there, 0.8 % above as the load grows on."""
    command = ran("snap_through_arch")
    found = command.result
    assert found.moved.status.ok and found.loaded.status.ok
    assert found.limit == pytest.approx(2948.0, rel=2e-3)  # 2947.1 N with less drag
    assert found.limit < found.snap < 1.02 * found.limit
    trough = found.path[(found.path[:, 0] > 0.03) & (found.path[:, 0] < 0.06), 1].min()
    assert trough < 0.55 * found.limit
    energy = found.loaded.energy
    assert energy.supplied[-1] == pytest.approx(energy.total[-1] + energy.dissipated[-1], rel=1e-11)
    # the work under the curve of the moved crown is what the arch stores there
    work = np.trapezoid(found.path[:, 1], found.path[:, 0])
    assert work == pytest.approx(found.moved.energy.supplied[-1], rel=5e-3)
    assert f"{found.limit:.1f} N" in command.printed


def test_rotating_blade(ran, example):
    """Known values have four digits and are those of a blade without shear, rotary inertia and stretch."""
    command, module = ran("rotating_blade"), example("rotating_blade")
    found = command.result
    np.testing.assert_allclose(found.frequencies["full"], module.KNOWN, rtol=1e-3)
    np.testing.assert_allclose(found.frequencies["second order"], found.frequencies["full"], rtol=5e-4)
    assert found.frequencies["full"][-1] > 1.4 * found.still
    assert np.isnan(found.linear[-1]) and found.refusal.startswith("[PH403]")
    assert found.refusal in command.printed


def test_truss_bridge(ran):
    """Pinned bars only pull and push; that they vibrate themselves takes more from each higher mode."""
    command = ran("truss_bridge")
    found = command.result
    off = 1.0 - 2.0 * np.pi * found.modes.hertz / found.plain
    np.testing.assert_allclose(off, [0.0098, 0.031, 0.097], rtol=0.03)
    assert len(found.system.constraint_names) == 1  # of the roller
    assert f"{found.modes.hertz[0]:.4f}" in command.printed


def test_wave_absorber(ran):
    command = ran("wave_absorber")
    for run in command.result.values():
        assert run.reflected == pytest.approx(run.expected, abs=2e-3)
        assert run.absorbed == pytest.approx(1.0 - run.expected**2, abs=1e-3)
        assert run.solution.system.linear
        assert run.solution.max_power_balance_error < 1e-12 * run.solution.energy.supplied[-1]
    assert f"{command.result['Z'].absorbed:.4f}" in command.printed


def test_falling_chain(ran, example):
    """Faster than a stone, as one without friction should be; links of finite length are a little slower in the end."""
    command, module = ran("falling_chain"), example("falling_chain")
    found = command.result
    for fallen, off in ((0.5, 0.01), (1.0, 0.02), (1.4, 0.05)):
        speed = np.interp(fallen, found.fallen[:1000], found.speed[:1000])
        assert speed == pytest.approx(module.theory(fallen), rel=off)
        assert speed > np.sqrt(2.0 * 9.81 * fallen)
    assert found.speed.max() > 15.0
    assert found.energy_drift < 1e-10
    assert not found.solution.system.constraint_names
    assert f"{found.speed.max():.1f} m/s" in command.printed


# The Duffing oscillator


def test_duffing(ran):
    command = ran("duffing")
    exact, midpoint = command.result["discrete gradient"], command.result["midpoint"]
    assert exact.energy_error < 1e-11
    assert 1e-3 < midpoint.energy_error < 1e-1
    assert midpoint.energy_error == pytest.approx(9.1e-3, rel=0.01)  # the number of docs/theory.md
    for run in (exact, midpoint):
        errors = list(run.position_errors.values())
        assert np.log2(errors[-2] / errors[-1]) == pytest.approx(2.0, abs=0.05)
    assert f"{midpoint.energy_error:.2e}" in command.printed


# Matrices of the user's in a loop


def test_matrices_in_a_loop(ran):
    command = ran("matrices_in_a_loop")
    poles = command.result.poles
    np.testing.assert_allclose(poles["diagram"], poles["by hand"], rtol=1e-9)
    # one mode of a Bernoulli beam: measured 1.4e-3 (shear, rotary inertia, the other modes)
    np.testing.assert_allclose(poles["diagram"], poles["one mode"], rtol=3e-3)
    # Den Hartog's absorber on this beam: both modes across it are damped alike, 10 %
    damping = -poles["diagram"].real / np.abs(poles["diagram"])
    np.testing.assert_allclose(damping[[0, 2]], 0.097, rtol=0.02)
    for name, solution in command.result.runs.items():
        energy = solution.energy
        assert solution.status.ok
        assert solution.max_power_balance_error < 1e-12 * energy.total.max(), name
        left = energy.supplied[-1] - energy.dissipated[-1]
        assert energy.total[-1] == pytest.approx(left, abs=1e-12 * energy.total.max())
    alone, loop = command.result.runs.values()
    assert alone.energy.dissipated[-1] == 0.0
    assert loop.energy.total[-1] < 0.06 * loop.energy.supplied[-1]
    assert f"{poles['diagram'][0].imag:.4f}" in command.printed


# Models for other tools


def test_standalone_four_bar(ran, fall, tmp_path, monkeypatch):
    """From the exported file alone: states, angles and places of the run of the library, to 1e-10."""
    fall.solution.system.export(tmp_path / "four_bar.npz")
    monkeypatch.chdir(tmp_path)
    command = ran("standalone_four_bar")
    t, x, theta, points, stored, work = command.result
    recording, steps = fall.solution.recording, t.size
    assert steps == 101 and t[-1] == pytest.approx(2.0)
    scale = np.sqrt(fall.solution.system.E.diagonal())  # energies, so that forces and velocities count alike
    expected = recording.x[:steps] * scale
    assert np.abs(x * scale - expected).max() < 1e-10 * np.abs(expected).max()
    assert np.abs(theta - recording.theta[:steps]).max() < 1e-10
    assert np.abs(points - recording.points[:steps]).max() < 1e-10
    assert np.abs(recording.points[steps - 1] - recording.points[0]).max() > 0.5
    assert np.abs(stored - work - stored[0]).max() < 1e-10 * fall.start_energy
    assert "141 states, 100 steps" in command.printed and command.files[0].name == "motion.npz"


def test_standalone_four_bar_does_without_the_library(fall, tmp_path):
    fall.solution.system.export(tmp_path / "f.npz")
    code = (
        "import runpy, sys; sys.modules['phblocks'] = None; sys.argv[1:] = ['f.npz', '--t-end', '0.1'];"
        f"runpy.run_path({str(FOLDER / 'standalone_four_bar.py')!r}, run_name='__main__')"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "141 states, 5 steps" in done.stdout


@pytest.mark.filterwarnings("default")  # those of pyMOR are its own
def test_reduced_four_bar(ran):
    """pH-IRKA keeps the structure, and the error falls with the order: measured 3e-1, 4e-2, 9e-3, 2e-3."""
    pytest.importorskip("pymor")
    command = ran("reduced_four_bar")
    result, errors = command.result, [r.error for r in command.result.reductions]
    assert result.states == 141 and [r.order for r in result.reductions] == [8, 12, 16, 20]
    assert result.turned == pytest.approx(0.743, abs=2e-3)
    np.testing.assert_array_less(errors, [0.5, 0.07, 0.02, 0.005])
    assert errors == sorted(errors, reverse=True)
    for reduction in result.reductions:
        assert reduction.skew_defect < 1e-12 and reduction.least_loss > -1e-9
        assert f"{reduction.error:.1e}" in command.printed
    # at low frequency all spin as a rigid linkage under drag
    assert abs(result.reductions[-1].response[0]) == pytest.approx(abs(result.response[0]), rel=5e-3)
    assert [path.name for path in command.files] == ["reduced_four_bar.png"]
