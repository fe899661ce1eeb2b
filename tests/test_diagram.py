"""The verbs of the diagram, and everything they refuse."""

import math

import networkx as nx
import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import (
    ArgumentTypeError,
    CausalityError,
    DataError,
    DuplicateNameError,
    ForeignBlockError,
    GapError,
    PortInUseError,
    PortTypeError,
)


@pytest.fixture
def pair(bar) -> tuple[ph.Diagram, ph.Beam, ph.Beam]:
    """Two beams that meet at (1, 0), added and not joined."""
    d = ph.Diagram("pair")
    a = d.add(ph.Beam("a", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    b = d.add(ph.Beam("b", bar, (1.0, 0.0), (1.0, 1.0), elements=2))
    return d, a, b


def beam(bar, name="c", start=(1.0, 0.0), end=(2.0, 0.0)) -> ph.Beam:
    return ph.Beam(name, bar, start, end, elements=2)


# The diagram itself


def test_a_new_diagram():
    d = ph.Diagram("four-bar", gravity=(0, -9.81))
    assert d.name == "four-bar" and ph.Diagram().name == "diagram"
    np.testing.assert_array_equal(d.network.gravity, [0.0, -9.81])
    assert list(d.network.blocks) == ["ground"] and d.ground.position is None
    assert isinstance(d.graph, nx.Graph)


@pytest.mark.parametrize(
    ("gravity", "error"),
    [
        ((0.0, 0.0, 0.0, -9.81), DataError),
        ((0.0,), DataError),
        (-9.81, DataError),
        ((math.nan, 0.0), DataError),
        ((0.0, math.inf), DataError),
        (((0.0, -9.81),), DataError),
        ("down", ArgumentTypeError),
        (("0", "-9.81"), ArgumentTypeError),
        ((0.0, None), ArgumentTypeError),
        ((0.0, (1.0, 2.0)), ArgumentTypeError),
        (True, ArgumentTypeError),
        (1j, ArgumentTypeError),
        ({}, ArgumentTypeError),
    ],
)
def test_gravity(gravity, error):
    with pytest.raises(error, match=r"Diagram 'd' gravity.*gravity=\(0\.0, -9\.81\)"):
        ph.Diagram("d", gravity=gravity)


def test_gravity_is_a_copy():
    g = np.array([0.0, -9.81])
    d = ph.Diagram("d", gravity=g)
    g[1] = 0.0
    assert d.network.gravity[1] == -9.81


@pytest.mark.parametrize("name", [None, 1, True, ["a"]])
def test_a_name_that_is_no_text(name):
    with pytest.raises(ArgumentTypeError, match="name of a diagram"):
        ph.Diagram(name)


def test_a_diagram_without_blocks_does_not_compile():
    with pytest.raises(DataError, match=r"diagram 'empty'.*none but the ground.*add\(\)"):
        ph.Diagram("empty").compile()


@pytest.mark.parametrize("outputs", ["none", "All", 1, True, []])
def test_outputs(pair, outputs):
    with pytest.raises(DataError, match=r'compile outputs.*"all" or None'):
        pair[0].compile(outputs=outputs)


# add


def test_adding_returns_the_block(bar):
    d, c = ph.Diagram(), beam(bar)
    assert d.add(c) is c and d.network.blocks["c"] is c


@pytest.mark.parametrize("name", ["a", "ground"])
def test_a_name_in_use(pair, bar, name):
    with pytest.raises(DuplicateNameError, match=rf"diagram 'pair'.*got '{name}'.*other name than ground, a, b"):
        pair[0].add(beam(bar, name))


def test_a_block_added_twice(pair):
    d, a, _ = pair
    with pytest.raises(DuplicateNameError):
        d.add(a)


@pytest.mark.parametrize("thing", [None, "a", 1, ph.Beam, ph.Diagram])
def test_adding_something_else(pair, thing):
    with pytest.raises(ArgumentTypeError, match=r"Diagram\.add: expected a block such as ph\.Beam"):
        pair[0].add(thing)


# pin, weld, connect


def test_a_pin_joins_translations_and_a_weld_rotations_too(pair):
    d, a, b = pair
    d.pin(a.start, d.ground)
    d.weld(a.end, b.start)
    assert [j.name for j in d.network.joined] == [
        "a.start.translation = ground.anchor.translation",
        "a.end.translation = b.start.translation",
        "a.end.rotation = b.start.rotation",
    ]


@pytest.mark.parametrize("verb", ["pin", "weld"])
def test_a_gap(pair, verb):
    d, a, b = pair
    with pytest.raises(GapError, match=rf"{verb} a\.start and b\.start.*\[0\.0, 0\.0\] and \[1\.0, 0\.0\], 1 m apart"):
        getattr(d, verb)(a.start, b.start)
    assert not d.network.joined


def test_a_gap_to_a_third(pair, bar):
    d, a, b = pair
    c = d.add(beam(bar, start=(1.0, 1e-6)))
    with pytest.raises(GapError, match=r"pin a\.end and c\.start.*1e-06 m apart"):
        d.pin(a.end, b.start, c.start)


@pytest.mark.parametrize("far", [0.0, 1e6])
def test_round_off_is_no_gap(bar, far):
    d = ph.Diagram()
    a = d.add(beam(bar, "a", (far, 0.0), (far + 0.1 + 0.2, 0.0)))
    b = d.add(beam(bar, "b", (far + 0.3, 0.0), (far, 1.0)))
    d.pin(a.end, b.start)
    assert len(d.network.joined) == 1


@pytest.mark.parametrize("verb", ["pin", "weld"])
def test_anchors_only(pair, verb):
    d, a, b = pair
    for thing in (a, "a.end", None, a.end.translation, (1.0, 0.0)):
        with pytest.raises(ArgumentTypeError, match=rf"{verb}: expected an anchor such as beam\.end.*not blocks"):
            getattr(d, verb)(b.start, thing)


@pytest.mark.parametrize("verb", ["pin", "weld", "connect"])
def test_at_least_two(pair, verb):
    d, a, _ = pair
    one = a.end.translation if verb == "connect" else a.end
    for things in ((), (one,)):
        with pytest.raises(DataError, match=rf"{verb}: expected at least two, got {len(things)}"):
            getattr(d, verb)(*things)
    assert not d.network.joined


def test_ports_only(pair):
    d, a, b = pair
    for thing in ("a.end.translation", None, a):
        with pytest.raises(ArgumentTypeError, match=r"connect: expected a port such as beam\.end\.translation"):
            d.connect(b.start.translation, thing)
    with pytest.raises(ArgumentTypeError, match=r"Name one of its ports, \.translation or \.rotation"):
        d.connect(b.start.translation, a.end)


def test_force_to_moment(pair):
    d, a, b = pair
    with pytest.raises(
        PortTypeError,
        match=r"connect a\.end\.translation to b\.start\.rotation: expected a port of force/velocity, "
        r"got one of moment/angular velocity",
    ):
        d.connect(a.end.translation, b.start.rotation)
    with pytest.raises(PortTypeError):
        d.connect(a.end.translation, d.ground.rotation)


@pytest.mark.parametrize("verb", ["pin", "weld"])
def test_a_shaft_has_no_translation(pair, verb):
    d, a, _ = pair
    motor = d.add(ph.DCMotor("motor", 1.0, 0.1))
    with pytest.raises(PortTypeError, match=r"motor\.shaft\.translation: expected one of the ports of .*connect\(\)"):
        getattr(d, verb)(a.end, motor.shaft.anchor)


@pytest.mark.parametrize("verb", ["pin", "weld"])
def test_a_block_that_was_not_added(pair, bar, verb):
    d, a, _ = pair
    with pytest.raises(ForeignBlockError, match=r"c\.start: expected a block of diagram 'pair'.*add\(\)"):
        getattr(d, verb)(a.end, beam(bar).start)
    namesake = beam(bar, "b")  # also if a block of that name was
    with pytest.raises(ForeignBlockError, match=r"b\.start"):
        getattr(d, verb)(a.end, namesake.start)
    with pytest.raises(ForeignBlockError, match=r"ground\.anchor"):
        getattr(d, verb)(a.start, ph.Diagram().ground)


def test_connecting_and_exposing_a_block_that_was_not_added(pair, bar):
    d, a, _ = pair
    c = beam(bar)
    with pytest.raises(ForeignBlockError, match=r"c\.start\.translation"):
        d.connect(a.end.translation, c.start.translation)
    with pytest.raises(ForeignBlockError, match=r"c\.end\.translation"):
        d.expose(c.end.translation, "load")


def test_a_port_joined_twice(pair, bar):
    d, a, b = pair
    c = d.add(beam(bar))
    d.pin(a.end, b.start)
    for verb in ("pin", "weld"):
        with pytest.raises(
            PortInUseError,
            match=r"a\.end\.translation: expected a port that is not joined yet, got one joined in "
            r"\[a\.end\.translation = b\.start\.translation\] \(pin at test_diagram\.py:\d+\).*pin\(a, b, c\)",
        ):
            getattr(d, verb)(a.end, c.start)
    with pytest.raises(PortInUseError, match=r"b\.start\.translation"):
        d.connect(c.start.translation, b.start.translation)
    d.connect(a.end.rotation, b.start.rotation)  # the rotations are free still
    assert len(d.network.joined) == 2


def test_a_weld_that_fails_leaves_nothing_behind(pair, bar):
    d, a, b = pair
    c = d.add(beam(bar))
    d.connect(b.start.rotation, c.start.rotation)
    with pytest.raises(PortInUseError, match=r"b\.start\.rotation"):
        d.weld(a.end, b.start)
    assert len(d.network.joined) == 1


def test_one_port_named_twice(pair):
    d, a, _ = pair
    with pytest.raises(PortInUseError, match=r"a\.end\.translation.*got it twice"):
        d.pin(a.end, a.end)


def test_the_ground_serves_any_number_of_joints(pair):
    d, a, b = pair
    for anchor in (a.start, a.end, b.end):
        d.pin(anchor, d.ground)
    assert len(d.network.joined) == 3


def test_a_point_has_no_orientation_to_weld(pair):
    d, a, _ = pair
    ball = d.add(ph.Mass("ball", 1.0, (1.0, 0.0)))
    with pytest.raises(PortTypeError, match=r"weld ball\.centre: expected an anchor with orientation.*pin\(\)"):
        d.weld(a.end, ball.centre)
    assert not d.network.joined
    d.pin(a.end, ball.centre)


# expose


@pytest.mark.parametrize("thing", [None, "a.end.translation", 1])
def test_exposing_ports_only(pair, thing):
    with pytest.raises(ArgumentTypeError, match="expose: expected a port"):
        pair[0].expose(thing, "load")


def test_exposing_an_anchor_names_its_ports(pair):
    d, a, _ = pair
    with pytest.raises(ArgumentTypeError, match=r"\.translation or \.rotation"):
        d.expose(a.end, "load")


def test_an_exposed_name_in_use(pair):
    d, a, b = pair
    d.expose(a.end.translation, "load")
    with pytest.raises(DuplicateNameError, match="got 'load'"):
        d.expose(b.end.translation, "load")


@pytest.mark.parametrize(
    ("name", "error"), [("", DataError), ("load.x", DataError), (None, ArgumentTypeError), (1, ArgumentTypeError)]
)
def test_names_of_exposed_ports(pair, name, error):
    """With a dot, "load.x" could be a moment and the first component of a force "load" at once."""
    d, a, _ = pair
    with pytest.raises(error, match=r"expose a\.end\.translation name"):
        d.expose(a.end.translation, name)


@pytest.mark.parametrize("imposes", ["moment", "Force", "", 1, True])
def test_imposing_what_the_port_has_not(pair, imposes):
    d, a, _ = pair
    with pytest.raises(DataError, match=r'expose a\.end\.translation.*imposes="force" or imposes="velocity"'):
        d.expose(a.end.translation, "load", imposes=imposes)


def test_the_ground_cannot_be_exposed(pair):
    d, a, _ = pair
    d.pin(a.start, d.ground)
    for imposes in (None, "force", "velocity"):
        with pytest.raises(
            DataError, match=r"expose ground\.anchor\.translation: expected a port of a block that can move"
        ):
            d.expose(d.ground.translation, "shake", imposes=imposes)


def test_a_refused_exposure_leaves_nothing_behind(pair):
    d, a, _ = pair
    for name, imposes in (("", None), ("load", "moment")):
        with pytest.raises(DataError):
            d.expose(a.end.translation, name, imposes=imposes)
    assert not d.network.exposed and d.compile().n_inputs == 0


def test_two_loads_on_one_joint(pair):
    d, a, b = pair
    d.pin(a.end, b.start)
    d.expose(a.end.translation, "one")
    d.expose(b.start.translation, "two")
    system = d.compile()
    G = system.G().toarray()
    assert system.input_names == ("one.x", "one.y", "two.x", "two.y")
    np.testing.assert_array_equal(G[:, :2], G[:, 2:])
    np.testing.assert_allclose(np.linalg.norm(G, axis=0), 1.0, rtol=1e-14)


def test_an_impossible_diagram_does_not_compile(bar):
    d = ph.Diagram()
    d.add(ph.Beam("a", bar, (0.0, 0.0), (1.0, 0.0), elements=2, causality="pinned-free"))
    assert not d.check().ok
    with pytest.raises(CausalityError):
        d.compile()


def test_expose_asks_the_junction_who_can_give():
    """Of a beam end that can only take, joined to what gives, the force is exposed; joined to nothing that gives, the
    velocity."""
    section = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)
    for taken, imposed in ((True, "velocity"), (False, "force")):
        d = ph.Diagram()
        a = d.add(ph.Beam("a", section, (0, 0), (1, 0), elements=2, causality="free-pinned"))
        b = d.add(ph.Beam("b", section, (1, 0), (2, 0), elements=2, causality="pinned-free" if taken else "free-free"))
        d.pin(a.end, b.start)
        d.expose(a.end.translation, "joint")
        assert d.check().ok
        assert [i.imposed.name for i in d.compile().inputs] == [imposed] * 2


def test_connect_asks_before_it_joins_what_is_apart():
    d = ph.Diagram()
    a, b = d.add(ph.Mass("a", 1.0, (0.0, 0.0))), d.add(ph.Mass("b", 1.0, (0.0, 3.0)))
    s = d.add(ph.Spring("s", 1e3, (1.0, 0.0), (2.0, 0.0)))
    with pytest.raises(GapError, match=r"connect a\.centre and s\.start.*1 m apart.*apart=True"):
        d.connect(a.centre.translation, s.start.translation)
    d.connect(a.centre.translation, b.centre.translation, apart=True)  # as if on one sledge
    d.connect(d.add(ph.Force("push", (3.0, 0.0))).port, s.start.translation)  # a source is nowhere in particular
    assert len(d.network.joined) == 2


def test_one_source_shakes_both_feet(bar):
    """The feet of a portal frame have the velocity of one source, and keep their distance."""
    d = ph.Diagram("portal")
    left = d.add(ph.Beam("left", bar, (0.0, 0.0), (0.0, 1.0), elements=2))
    girder = d.add(ph.Beam("girder", bar, (0.0, 1.0), (1.0, 1.0), elements=2))
    right = d.add(ph.Beam("right", bar, (1.0, 0.0), (1.0, 1.0), elements=2))
    d.weld(left.end, girder.start)
    d.weld(girder.end, right.end)
    ground = d.add(ph.Velocity("quake", lambda t: (0.01 * math.sin(20.0 * t), 0.0)))
    d.connect(ground.port, left.start.translation, right.start.translation, apart=True)
    for foot in (left.start, right.start):
        d.connect(foot.rotation, d.ground.rotation)
    solution = ph.simulate(d.compile(), 0.2, 0.005)
    places = [solution.position(foot) for foot in (left.start, right.start)]
    np.testing.assert_allclose(places[1] - places[0], [[1.0, 0.0]] * len(solution.t), atol=1e-9)
    assert places[0][-1, 0] == pytest.approx(0.01 * (1.0 - math.cos(4.0)) / 20.0, rel=1e-2)
    assert solution.max_power_balance_error < 1e-9


def test_the_ground_joined_to_itself_is_refused():
    d = ph.Diagram("ground")
    d.add(ph.Mass("mass", 1.0, (0.0, 0.0)))
    with pytest.raises(ph.errors.PortInUseError, match="twice"):
        d.pin(d.ground, d.ground)
    with pytest.raises(ph.errors.PortInUseError, match="twice"):
        d.connect(d.ground.rotation, d.ground.rotation)


@pytest.mark.parametrize("flag", [1.0, "yes", np.zeros((0, 2)), None])
def test_flags_are_truth_values(flag):
    d = ph.Diagram("flags")
    mass = d.add(ph.Mass("mass", 1.0, (0.0, 0.0)))
    for join in (
        lambda: d.pin(mass.centre, d.ground, multiplier=flag),
        lambda: d.connect(mass.centre.translation, d.ground.translation, apart=flag),
        lambda: ph.RigidJoint("joint", flag),
        lambda: ph.Force("force", (1.0, 0.0), follows=flag),
        lambda: ph.LineLoad("load", (1.0, 0.0), follows=flag),
    ):
        with pytest.raises(ph.errors.ArgumentTypeError, match="True or False"):
            join()
