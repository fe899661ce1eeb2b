"""Runs whose loops are closed: what that changes, what it costs in energy, and that both are told."""

import itertools

import matplotlib.pyplot as plt
import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.solvers.loops import Loops
from tests.solvers.test_loops import frame

METHODS = {"midpoint": ph.Midpoint(), "gauss": ph.GaussLegendre(2), "radau": ph.RadauIIA(2)}


@pytest.fixture(params=METHODS)
def method(request):
    return METHODS[request.param]


def largest_gap(solution: ph.Solution) -> float:
    return max(float(gap.max()) for gap in solution.closure().values())


def balanced(solution: ph.Solution) -> float:
    """What the energies at the saved times miss, relative to the largest that gravity moved."""
    energy = solution.energy
    lost = energy.dissipated + energy.numerical_loss - energy.projected - energy.supplied
    return float(np.abs(energy.total + lost - energy.total[0]).max() / np.abs(energy.gravity).max())


@pytest.mark.parametrize("scene", ["four-bar", "rigid"])
def test_loops_are_closed_and_the_energy_is_told(four_bar, scene, method):
    system = four_bar().compile() if scene == "four-bar" else frame()
    steps = 25 if scene == "four-bar" else 50  # the bars fall slowly at first
    open_run, closed = (
        ph.simulate(system, steps * 0.02, 0.02, method=method, projection=projection)
        for projection in (None, ph.Projection())
    )
    assert largest_gap(open_run) > 1e-8
    assert largest_gap(closed) < 1e-11
    energy, statistics, ledger = closed.energy, closed.statistics, closed.recording.ledger
    assert 0.7 * steps < statistics.projections <= steps and statistics.largest_gap > 1e-10
    assert energy.projected[-1] == pytest.approx(statistics.projection_energy_change, abs=1e-10)
    assert energy.projected[-1] != 0.0 and abs(energy.projected[-1]) < 1e-2 * np.abs(energy.gravity).max()
    assert balanced(closed) < 1e-12
    assert closed.max_power_balance_error < 1e-12 * np.abs(energy.gravity).max()
    for row in closed.power.blocks.values():
        gained = row["received"] + row["supplied"] - row["dissipated"] - row["numerical_loss"] + row["projected"]
        np.testing.assert_allclose(row["stored"] + row["gravity"], gained, atol=1e-10 * np.abs(energy.gravity).max())
    assert "projected" in str(closed.power) and "projected" not in str(open_run.power)
    assert f"loops closed {statistics.projections} times" in str(statistics)
    # the strain that it cost is nothing: links turn on their pins
    assert np.abs(ledger.projected).max() < 0.1
    assert not open_run.energy.projected.any() and open_run.statistics.projections == 0


def test_it_is_told_everywhere(tmp_path):
    """Files, plots, report: what the method took, and what closing loops added."""
    options = {"method": ph.RadauIIA(2), "projection": ph.Projection(every=2)}
    solution = ph.simulate(frame(), 1.0, 0.02, save=tmp_path / "run.h5", **options)
    read = ph.read(tmp_path / "run.h5")
    for name in ("numerical_loss", "projected"):
        assert solution.energy[name][-1] != 0.0
        np.testing.assert_array_equal(read.energy[name], solution.energy[name])
        assert name.replace("_", " ") in str(read.power)
    assert read.statistics.projection_energy_change == solution.statistics.projection_energy_change != 0.0
    assert read.settings["projection"] == {"class": "Projection", "every": 2}
    labels = [line.get_label() for line in ph.plots.energy(read).lines]
    assert {"numerical loss", "projected"} <= set(labels)
    written = {text.get_text().split(" ")[0] for text in ph.plots.power_flow(solution).texts}
    assert {"numerical", "projected"} <= written
    plt.close("all")
    page = solution.report(tmp_path / "run.html").read_text(encoding="utf-8")
    for text in ("numerical loss", "projected", "energy the method took away", "energy that closing loops added"):
        assert text in page


VARIANTS = {
    "internal damping": ({"damping": ph.Damping(viscous=1.0, internal=1e-4)}, None, False),
    "no extension": ({}, ph.Approximation(extension=False), False),
    "rigid": ({}, ph.Approximation(flexible=False), False),
    "no rotary inertia": ({}, ph.Approximation(rotary_inertia=False), False),
    "welded corner": ({}, None, True),
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_whatever_the_beams_are(variant):
    """Dampers do not resist, strains without compliance stay zero, corners stay corners."""
    options, approximation, welded = VARIANTS[variant]
    bar = ph.Section.rectangle(0.05, 0.05, young=2.1e11, poisson=0.3, density=2710.0, shear_factor=1.0)
    d = ph.Diagram("four-bar", gravity=(0.0, -9.81))
    corners = [(0.0, 0.5), (2.0, 1.5), (3.5, 1.5), (2.5, 0.5)]
    bars = [
        d.add(ph.Beam(name, bar, *ends, 3, 2, **options))
        for name, ends in zip(("crank", "coupler", "rocker"), itertools.pairwise(corners), strict=True)
    ]
    d.pin(bars[0].start, d.ground)
    (d.weld if welded else d.pin)(bars[0].end, bars[1].start)
    d.pin(bars[1].end, bars[2].start)
    d.pin(bars[2].end, d.ground)
    system = d.compile(**({} if approximation is None else {"approximation": approximation}))
    for method in (ph.Midpoint(), ph.RadauIIA(2)):
        closed = ph.simulate(system, 0.2, 0.01, method=method, projection=ph.Projection())
        assert closed.status.ok and closed.statistics.halvings == 0 and closed.statistics.projections > 10
        assert largest_gap(closed) < 1e-11 and balanced(closed) < 1e-11
        assert np.abs(closed.energy.projected).max() < 1e-3 * np.abs(closed.energy.gravity).max()
        if variant == "no extension":
            assert closed.energy.strain[-1] > 0.0


def test_one_projection_by_hand():
    """What one projection changes, from the states before and after it: stored energy, and masses that were lifted."""
    system = frame()
    before = ph.simulate(system, 1.0, 0.02)
    after = ph.simulate(system, 1.0, 0.02, projection=ph.Projection(every=50))
    assert after.statistics.projections == 1
    np.testing.assert_array_equal(before.x[:-1, ~system.algebraic], after.x[:-1, ~system.algebraic])
    stored = [system.energy(s.x[-1]) for s in (before, after)]
    height = [-(s.recording.points[-1] @ system.gravity) @ system.point_mass for s in (before, after)]
    change = stored[1] - stored[0] + height[1] - height[0]
    assert after.energy.projected[-1] == pytest.approx(change, abs=1e-13)
    assert after.energy.projected[-2] == 0.0 and change != 0.0
    assert largest_gap(after.sliced(np.array([50]))) < 1e-12 < 1e-5 < largest_gap(before.sliced(np.array([50])))


@pytest.mark.parametrize(("method", "steps"), [(ph.Midpoint(), (40, 80, 160)), (ph.RadauIIA(2), (40, 80, 160))])
def test_the_order_of_the_method_stays(method, steps):
    """Of rigid bars, whose loops are opened by time steps alone; the reference is not projected."""
    system, moving = frame(), slice(0, 9)
    exact, errors = ph.simulate(system, 1.0, 1 / 800, method=ph.GaussLegendre(3)), []
    for n in steps:
        run = ph.simulate(system, 1.0, 1 / n, method=method, projection=ph.Projection())
        assert run.statistics.projections > 0.5 * n
        apart = (run.x - exact.x[:: 800 // n])[:, moving]
        errors.append((np.abs(apart).max(), np.abs(run.recording.theta[-1] - exact.recording.theta[-1]).max()))
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert np.abs(order - method.order).max() < 0.2
    assert errors[-1][0] < {2: 3e-3, 3: 1e-5}[method.order]


def test_velocities_of_joints_with_multipliers_are_projected_too():
    """What Gauss-Legendre collocation loses there in order comes back."""
    system = frame()
    exact, errors = ph.simulate(system, 1.0, 1 / 400, method=ph.GaussLegendre(3), projection=ph.Projection()), []
    for projection in (None, ph.Projection()):
        run = ph.simulate(system, 1.0, 1 / 40, method=ph.GaussLegendre(2), projection=projection)
        errors.append(np.abs((run.x - exact.x[::10])[:, :9]).max())
    assert errors[0] > 1e-3 and errors[1] < 1e-5


def soft_loop(elements: int, degree: int = 1) -> ph.System:
    """Three soft beams on four pins, the first turned by a moment of the user's."""
    section = ph.Section.rectangle(0.2, 0.2, young=1e6, poisson=0.3, density=2710.0, shear_factor=1.0)
    d = ph.Diagram("loop")
    a = d.add(ph.Beam("a", section, (0.0, 0.0), (0.0, 1.0), elements, degree))
    b = d.add(ph.Beam("b", section, (0.0, 1.0), (1.5, 1.0), elements, degree))
    c = d.add(ph.Beam("c", section, (1.5, 1.0), (1.5, 0.0), elements, degree))
    d.pin(a.start, d.ground)
    d.pin(a.end, b.start)
    d.pin(b.end, c.start)
    d.pin(c.end, d.ground)
    d.expose(b.start.rotation, "drive")
    return d.compile()


DRIVE = {"drive": lambda t: 60.0 * np.sin(np.pi * t) ** 8}


def test_the_part_of_the_mesh():
    """Beams: a part of the gap that no step takes away, but finer meshes do; the angle is as good as without."""
    gaps = {}
    for elements in (2, 4, 8):
        system = soft_loop(elements)
        runs = [ph.simulate(system, 0.6, dt, method=ph.GaussLegendre(2), inputs=DRIVE) for dt in (0.02, 0.01)]
        gaps[elements] = [largest_gap(run) for run in runs]
        assert gaps[elements][1] == pytest.approx(gaps[elements][0], rel=0.05)
    assert gaps[2][0] / gaps[4][0] > 3.5 and gaps[4][0] / gaps[8][0] > 3.5
    system = soft_loop(2)
    exact = ph.simulate(system, 0.6, 0.0025, method=ph.GaussLegendre(3), inputs=DRIVE, projection=ph.Projection())
    errors = []
    for n in (1, 2, 4):
        run = ph.simulate(system, 0.6, 0.02 / n, inputs=DRIVE, projection=ph.Projection(), save_every=n)
        errors.append(np.abs(run.angle("b", 0.5) - exact.angle("b", 0.5)[::8]).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.abs(orders - 2.0).max() < 0.15


def test_constraints_hold_where_loops_were_closed(method):
    from phblocks.system.constraints import find_constraints

    system = frame()
    run = ph.simulate(system, 1.0, 0.02, method=method, projection=ph.Projection())
    for t in run.t[-10:]:
        found = find_constraints(system, run.at(t))
        assert np.abs(found.rows @ (run.at(t).x / found.scale)).max() < 1e-12


def test_what_has_no_loop_is_left_alone():
    section = ph.Section.rectangle(0.05, 0.05, young=2.1e9, poisson=0.3, density=2710.0)
    d = ph.Diagram("pendulum", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(beam.start, d.ground)
    system = d.compile()
    plain, projected = (ph.simulate(system, 0.2, 0.02, projection=p) for p in (None, ph.Projection()))
    np.testing.assert_array_equal(plain.x, projected.x)
    assert projected.statistics.projections == 0


def test_with_steps_adapted(four_bar):
    solution = ph.simulate(
        four_bar().compile(), 0.1, 0.01, adaptive=ph.Adaptive(1e-2, atol=1e-3), projection=ph.Projection(every=2)
    )
    assert solution.status.ok and balanced(solution) < 1e-12
    assert solution.statistics.projections > 5 and largest_gap(solution) < 1e-11


def test_a_loop_that_cannot_be_closed_ends_the_run(monkeypatch):
    system = frame()
    monkeypatch.setattr(Loops, "_displaced", lambda self, state, jumps: state)
    solution = ph.simulate(system, 1.0, 0.02, projection=ph.Projection())
    assert solution.status.name == "step failed" and "could not be closed" in solution.status.text


@pytest.mark.parametrize("every", [0, -1])
def test_numbers_out_of_range(every):
    with pytest.raises(DataError, match="Projection every"):
        ph.Projection(every)


@pytest.mark.parametrize("every", [1.5, "1", True, None])
def test_options_of_the_wrong_kind(every):
    with pytest.raises(ArgumentTypeError, match="Projection every"):
        ph.Projection(every)


def test_where_it_does_not_belong():
    system = frame()
    with pytest.raises(ArgumentTypeError, match="simulate projection"):
        ph.simulate(system, 0.1, 0.01, projection=True)
    with pytest.raises(ArgumentTypeError, match="simulate projection"):
        ph.simulate(system, 0.1, 0.01, method=ph.ScipyIVP(), projection=ph.Projection())


def pulled(speed, second_support_moves: bool = True) -> ph.System:
    """Two soft bars as a roof on two pins, one of which is drawn outwards."""
    section = ph.Section(axial=2e3, shear=8e4, bending=40.0, mass=1.5, rotary=1e-3)
    d = ph.Diagram("roof", gravity=None if second_support_moves else (0.0, -9.81))
    left = d.add(ph.Beam("left", section, (0.0, 0.0), (1.0, 1.0), elements=2))
    right = d.add(ph.Beam("right", section, (1.0, 1.0), (2.0, 0.0), elements=2))
    drive = d.add(ph.Velocity("drive", lambda t: (speed * np.sin(t) ** 2, 0.0))).port
    d.pin(left.start, d.ground)
    d.pin(left.end, right.start)
    if second_support_moves:
        d.connect(right.end.translation, drive)
    else:  # the loop is on the ground, what is pulled hangs on it
        tail = d.add(ph.Beam("tail", section, (5.0, 0.0), (6.0, 0.0), elements=2))
        d.pin(right.end, d.ground)
        d.connect(tail.end.translation, drive)
    return d.compile(outputs="all")


def test_a_start_that_an_imposed_motion_has_displaced_is_refused():
    """A state does not tell how far the support had come: the loop would be closed onto the place where it began."""
    system = pulled(0.3)
    whole = ph.simulate(system, 1.0, 0.01, projection=ph.Projection())
    came = 0.3 * (0.25 - np.sin(1.0) / 4.0)  # integral of the speed to 0.5 s; three joints share the gap
    assert Loops(system).unaccounted(whole.at(0.5)) == pytest.approx(came / 3.0, rel=1e-3)
    with pytest.raises(DataError, match=r"simulate start of system 'roof'.*a gap of 0\.00396 m.*ph\.resume"):
        ph.simulate(system, 0.5, 0.01, start=whole.at(0.5), projection=ph.Projection())
    start = system.rigid_motion((0.0, 0.0))
    assert ph.simulate(system, 0.1, 0.01, start=start, projection=ph.Projection()).status.ok


def test_a_start_that_was_displaced_elsewhere_is_not_refused():
    """Only gaps that an imposed motion can cause are in doubt: others are closed, as the user asks."""
    system = pulled(0.3, second_support_moves=False)
    x = system.start.x.copy()
    x[[i for i, name in enumerate(system.state_names) if "left.N1" in name]] = 20.0
    start = ph.State(x, system.start.theta, system.start.points)
    assert Loops(system).unaccounted(start) == 0.0
    closed = ph.simulate(system, 0.1, 0.01, start=start, projection=ph.Projection())
    assert closed.statistics.largest_gap > 1e-3 and largest_gap(closed.sliced(np.array([10]))) < 1e-11
