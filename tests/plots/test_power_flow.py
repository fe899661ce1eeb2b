"""Flows on paper are those of the ledger, and add up at every block."""

import itertools

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.patches import Rectangle
from matplotlib.text import Annotation

import phblocks as ph
from phblocks import plots
from phblocks.plots.power_flow import power_of
from phblocks.results.flows import flows_of


@pytest.fixture(scope="module")
def motor(bar):
    """A source feeds a motor, which turns an arm."""
    d = ph.Diagram("motor")
    source, earth = d.add(ph.Voltage("source", 12.0)), d.add(ph.Reference("earth"))
    motor = d.add(ph.DCMotor("motor", 1.2, 0.5, 2e-3))
    arm = d.add(ph.Beam("arm", bar, (0.0, 0.0), (0.5, 0.0), elements=2))
    d.connect(source.port, motor.p)
    d.connect(motor.n, earth.port)
    d.connect(motor.stator, d.ground.rotation)
    d.connect(motor.shaft, arm.start.rotation)
    d.pin(arm.start, d.ground)
    return ph.simulate(d.compile(), t_end=0.2, dt=0.002)


@pytest.fixture(scope="module")
def four(four_bar):
    return ph.simulate(four_bar().compile(), t_end=1.0, dt=0.01)


def welded(n):
    """A flying beam in pieces that give velocity at both ends and share states where they are welded."""
    section = ph.Section(axial=3e4, shear=1e4, bending=50.0, mass=1.2, rotary=3e-3)
    d = ph.Diagram("pieces", gravity=(0.0, -9.81))
    pieces = [
        d.add(ph.Beam(f"b{i}", section, (i, 0.0), (i + 1.0, 0.0), elements=2, degree=2, causality="free-free"))
        for i in range(n)
    ]
    for left, right in itertools.pairwise(pieces):
        d.weld(left.end, right.start)
    system = d.compile()
    assert [len(group) for group in system.sharing.groups] == [n]
    return ph.simulate(system, t_end=0.2, dt=0.01, start=system.rigid_motion(spin=3.0))


@pytest.fixture(scope="module")
def two():
    return welded(2)


@pytest.fixture(scope="module")
def three():
    return welded(3)


@pytest.mark.parametrize("name", ["motor", "four", "two", "three"])
def test_flows_add_up_to_the_ledger(request, name):
    solution = request.getfixturevalue(name)
    net = dict.fromkeys(solution.power.blocks, 0.0)
    for flow in flows_of(solution):
        for node, sign in ((flow.source, -1.0), (flow.target, 1.0)):
            if node.kind == "block":
                net[node.name] = net[node.name] + sign * flow.energy
    size = max(float(np.abs(s).max()) for s in solution.energy.values())
    for block, row in solution.power.blocks.items():
        np.testing.assert_allclose(net[block], row["received"] + row["supplied"], atol=1e-12 * size)


def test_states_shared_by_three_are_a_node(two, three):
    """Of two it is known who gave; of three only how much each."""
    assert {(f.source.kind, f.target.kind) for f in flows_of(two)} == {("block", "block")}
    assert {(f.source.name, f.target.name) for f in flows_of(three)} == {("b0 + b1 + b2", f"b{i}") for i in range(3)}


def test_two_openings_on_one_beam_are_told_apart(bar):
    """One opening acts on two blocks, another on one of them: what each gives is still known."""
    d = ph.Diagram("two")
    left = d.add(ph.Beam("left", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    right = d.add(ph.Beam("right", bar, (1.0, 0.0), (2.0, 0.0), elements=2))
    d.weld(left.start, d.ground)
    d.weld(left.end, right.start)
    d.expose(left.end.translation, "middle")
    d.expose(right.end.translation, "tip")
    inputs = {"middle": (0.0, -10.0), "tip": (0.0, -5.0)}
    solution = ph.simulate(d.compile(), t_end=0.1, dt=0.01, inputs=inputs)
    supplied = solution.power.inputs
    from_outside = {}
    for flow in flows_of(solution):
        if flow.source.kind == "outside":
            from_outside[flow.source.name] = from_outside.get(flow.source.name, 0.0) + flow.energy
    assert set(from_outside) == {"middle", "tip"}
    for name, energy in from_outside.items():
        np.testing.assert_allclose(energy, supplied[f"{name}.x"] + supplied[f"{name}.y"], atol=1e-15)


def numbers(ax):
    return sorted(
        float(t.get_text().split()[0]) for t in ax.texts if t.get_text().endswith(" W") and t.get_bbox_patch()
    )


def test_what_is_drawn(motor):
    ax = plots.power_flow(motor)
    boxes = [p.get_label() for p in ax.patches if isinstance(p, Rectangle)]
    assert boxes == ["motor", "arm"]
    arrows = [t for t in ax.texts if isinstance(t, Annotation)]
    drawn = [power_of(flow.energy, motor.t, "mean") for flow in flows_of(motor)]
    drawn = [p for p in drawn if abs(p) > 1e-6 * np.abs(drawn).max()]
    assert len(arrows) == len(drawn) == 2
    assert numbers(ax) == pytest.approx(sorted(np.abs(drawn)), rel=5e-3)
    supplied = motor.energy.supplied[-1] / motor.t[-1]
    assert max(numbers(ax)) == pytest.approx(supplied, rel=5e-3)
    written = {t.get_text() for t in ax.texts}
    assert f"dissipated {motor.energy.dissipated[-1] / motor.t[-1]:+.3g} W" in written
    assert "source" in written


def test_arrows_go_where_power_goes(motor):
    """From the source into the motor, from the motor into the arm."""
    ax = plots.power_flow(motor)
    box = next(p for p in ax.patches if p.get_label() == "arm")
    heads = [t.xy for t in ax.texts if isinstance(t, Annotation)]
    corner = np.array(box.get_xy())
    size = np.array([box.get_width(), box.get_height()])
    assert any(((h >= corner - 1e-9) & (h <= corner + size + 1e-9)).all() for h in np.array(heads))


def test_peak(four):
    flow = next(f for f in flows_of(four) if {f.source.name, f.target.name} == {"crank", "coupler"})
    peak = np.abs(np.diff(flow.energy) / np.diff(four.t)).max()
    assert any(n == pytest.approx(peak, rel=5e-3) for n in numbers(plots.power_flow(four, "peak")))


def test_boxes_do_not_overlap(four):
    ax = plots.power_flow(four)
    ax.figure.draw_without_rendering()
    extents = [p.get_window_extent() for p in ax.patches if isinstance(p, Rectangle)]
    assert len(extents) == 3
    assert not any(a.overlaps(b) for i, a in enumerate(extents) for b in extents[:i])
    for text in (t for t in ax.texts if t.get_bbox_patch()):
        assert not any(text.get_window_extent().overlaps(e) for e in extents)


def test_nothing_flows(four_bar):
    still = ph.simulate(four_bar(gravity=None).compile(), t_end=0.1, dt=0.05)
    ax = plots.power_flow(still)
    assert not [t for t in ax.texts if isinstance(t, Annotation)]


def test_wrong_arguments(four, four_bar):
    with pytest.raises(ph.errors.DataError, match="peak"):
        plots.power_flow(four, "median")
    with pytest.raises(ph.errors.ArgumentTypeError):
        plots.power_flow(four_bar())
    with pytest.raises(ph.errors.DataError, match="saved times"):
        plots.power_flow(four.sliced(np.array([0])))


def test_draws_where_asked(four):
    _, axes = plt.subplots(1, 2)
    assert plots.power_flow(four, ax=axes[1]) is axes[1]
