"""Diagrams as JSON: what comes back is the same to the last bit, and what is damaged or hostile is refused by name."""

import copy
import inspect
import json
import re
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
import sympy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import phblocks as ph
from phblocks.blocks.block import Block
from phblocks.blocks.expressions import expression_of, text_of
from phblocks.errors import (
    ArgumentTypeError,
    DataError,
    ExportError,
    GapError,
    PhblocksError,
    PortInUseError,
    UnknownNameError,
)
from phblocks.triplets import Triplets
from tests.properties import planar

ROOT = Path(__file__).resolve().parents[1]
PUBLIC = [name for name in ph.__all__ if isinstance(getattr(ph, name), type) and issubclass(getattr(ph, name), Block)]
SECTION = ph.Section.rectangle(width=0.05, height=0.04, young=2.1e11, poisson=0.3, density=2710.0)


def assert_same_system(got: ph.System, expected: ph.System) -> None:
    """All arrays, entry by entry, without a tolerance; all names."""
    for key in ("state_names", "state_units", "input_names", "output_names", "theta_names", "name"):
        assert getattr(got, key) == getattr(expected, key), key
    for key in ("E", "J0", "R0", "T", "G0", "rates", "input_rates", "kinematics_u", "point_velocity"):
        a, b = (sp.coo_array(getattr(s, key)) for s in (got, expected))
        assert a.shape == b.shape, key
        for x, y in zip((*a.coords, a.data), (*b.coords, b.data), strict=True):
            np.testing.assert_array_equal(x, y, err_msg=key)
    for key in ("K", "K_u", "K_g", "kinematics"):
        a, b = getattr(got, key), getattr(expected, key)
        assert isinstance(a, Triplets)
        for x, y in zip((*a.indices, a.values), (*b.indices, b.values), strict=True):
            np.testing.assert_array_equal(x, y, err_msg=key)
    for key in ("x", "theta", "points"):
        np.testing.assert_array_equal(getattr(got.start, key), getattr(expected.start, key))
    for a, b in zip(got.inputs, expected.inputs, strict=True):
        assert (a.exposure, a.common) == (b.exposure, b.common)
        assert np.array_equal(a.signal, b.signal)


def there_and_back(diagram: ph.Diagram, folder: Path) -> ph.Diagram:
    return ph.load(diagram.save(folder / "diagram.json"))


def workshop() -> ph.Diagram:
    """One block of every public kind but joints made by pin, with every kind of argument."""
    d = ph.Diagram("Werkstatt № 1", gravity=(0.1, -9.81))
    damping = ph.Damping(viscous=0.3, internal=(1e-4, 2e-4, 3e-4))
    loads = [ph.LineLoad("wind", (3.0, 0.0)), ph.LineLoad("pressure", np.array([0.0, -7.0]), follows=True)]
    beam = d.add(
        ph.Beam(
            "Träger",
            SECTION,
            (0, 0),
            np.array([1, 0]),
            elements=(0.0, 0.3, 1.0),
            degree=2,
            curvature=0.2,
            causality=("clamped", "free"),
            damping=damping,
            loads=loads,
        )
    )
    d.weld(beam.start, d.ground)
    body = d.add(ph.RigidBody("body", 2.0, 0.3, (1.5, 0.0), {"left": (-0.5, 0.0)}, coordinates="body", angle=0.1))
    bushing = d.add(ph.Bushing("bushing", np.diag([1e4, 2e4, 3.0]), damping=np.diag([1.0, 2.0, 0.0]), angle=0.2))
    d.connect(bushing.first.translation, beam.end.translation)
    d.connect(bushing.first.rotation, beam.end.rotation)
    d.connect(bushing.second.translation, body.centre.translation)
    d.connect(bushing.second.rotation, body.centre.rotation)
    mass = d.add(ph.Mass("mass", 0.7, (2.0, 0.0)))
    spring = d.add(ph.Spring("spring", 300.0, (2.0, 0.0), (3.0, 1.0), free_length=0.0))
    damper = d.add(ph.Damper("damper", 5.0, (2.0, 0.0), (3.0, 0.0)))
    slider = d.add(ph.Slider("slider", (1.0, 2.0)))
    d.connect(spring.start.translation, damper.start.translation, mass.centre.translation, slider.second)
    d.pin(spring.end, d.ground)
    d.pin(damper.end, d.ground)
    d.connect(slider.first, d.ground.translation)
    force = d.add(ph.Force("force", (1.0, 2.0), follows=True))
    d.connect(force.port, body["left"].translation)
    shaft = d.add(ph.RigidBody("shaft", 1.0, 0.1, (5.0, 0.0)))
    parts = [ph.TorsionSpring("torsion spring", 9.0, twist=0.1), ph.TorsionDamper("torsion damper", 0.2)]
    for part in parts:
        d.add(part)
    moment = d.add(ph.Moment("moment", 0.4))
    motor = d.add(ph.DCMotor("motor", 0.5, 0.02, inductance=1e-3, current=0.1))
    d.connect(shaft.centre.rotation, parts[0].first, parts[1].first, moment.port, motor.ports["shaft"])
    for part in parts:
        d.connect(part.second, d.ground.rotation)
    earth = d.add(ph.Reference("earth"))
    source = d.add(ph.Voltage("battery", 12.0))
    resistor = d.add(ph.Resistor("resistor", 0.1))
    d.connect(source.port, resistor.p)
    d.connect(resistor.n, motor.ports["p"])
    d.connect(motor.ports["n"], earth.port)
    d.connect(motor.ports["stator"], d.ground.rotation)
    hydraulic = [
        ph.Capacitor("accumulator", 1e-9, voltage=2e5, domain=ph.HYDRAULIC, energy="pressure"),
        ph.Inductor("pipe", 1e6, current=1e-4, domain=ph.HYDRAULIC),
        ph.Current("pump", 1e-4, ph.HYDRAULIC),
        ph.Reference("tank", ph.HYDRAULIC),
    ]
    accumulator, pipe, pump, tank = (d.add(block) for block in hydraulic)
    d.connect(accumulator.p, pipe.p, pump.port)
    d.connect(accumulator.n, tank.port)
    d.connect(pipe.n, tank.port)
    line = ph.Domain("line", ph.Quantity("velocity", "m/s"), ph.Quantity("force", "N"))
    gyrator = d.add(ph.Gyrator("gyrator", 2.0, ph.ELECTRICAL, line))
    trolley = d.add(ph.Capacitor("trolley", 3.0, domain=line, energy="kinetic"))
    rail = d.add(ph.Reference("rail", line))
    winding = d.add(ph.Inductor("winding", 1e-2))
    d.connect(gyrator.first, winding.p)
    d.connect(winding.n, earth.port)
    d.connect(gyrator.second, trolley.p)
    d.connect(trolley.n, rail.port)
    wheel = d.add(ph.RigidBody("wheel", 1.0, 0.1, (6.0, 0.0)))
    gear = d.add(ph.Transformer("gear", -2.5, multiplier=True))
    d.connect(gear.first, wheel.centre.rotation)
    other = d.add(ph.RigidBody("other", 1.0, 0.2, (7.0, 0.0)))
    d.connect(gear.second, other.centre.rotation)
    matrices = ph.SystemBlock(
        "matrices",
        J=[[0.0, 1.0], [-1.0, 0.0]],
        R=np.diag([0.1, 0.0]),
        G=[[1.0], [0.0]],
        start=(0.1, 0.2),
        units=["m", ""],
        S=[[0.3]],
        ports={"port": ph.SystemPort(ph.ELECTRICAL, [0], "current")},
    )
    d.add(matrices)
    d.expose(matrices["port"], "in")
    q, p = sympy.symbols("q p")
    d.add(
        ph.CustomBlock.from_sympy(
            "pendulum",
            p**2 / sympy.Float(0.3) - 2 * sympy.cos(q) + sympy.Rational(1, 3) * sympy.sqrt(1 + q**2),
            [q, p],
            J=[[0, 1], [-1, 0]],
            R=sympy.Matrix([[0, 0], [0, 1 + q**2]]),
            start=[0.3, 0.0],
        )
    )
    tray = d.add(ph.Beam("tray", SECTION, (8, 0), (9, 0), elements=2))
    shake = d.add(ph.Velocity("shake", np.array([0.1, 0.0])))
    turn = d.add(ph.AngularVelocity("turn", 0.5))
    shelf = d.add(ph.Beam("shelf", SECTION, (8, 1), (9, 1), 2, approximation=ph.Approximation(extension=False)))
    d.connect(shake.port, tray.start.translation, shelf.start.translation, apart=True)
    d.connect(turn.port, tray.start.rotation)
    d.free(tray.end.rotation)
    d.expose(tray.end.translation, "tip", imposes="force")
    d.pin(other.centre, d.ground, multiplier=True)
    return d


# Round trips


def test_all_public_blocks(tmp_path):
    d = workshop()
    assert {type(block).__name__ for block in d.blocks.values()} >= set(PUBLIC)
    back = there_and_back(d, tmp_path)
    assert_same_system(back.compile(), d.compile())
    assert list(back.blocks) == list(d.blocks)
    assert back.network.junction_of[back.blocks["tray"].ports["end.rotation"]].ports == (
        back.blocks["tray"].ports["end.rotation"],
    )


def test_scenes(scene, tmp_path):
    back = there_and_back(scene, tmp_path)
    assert_same_system(back.compile(), scene.compile())
    again = tmp_path / "again.json"
    back.save(again)
    assert again.read_bytes() == (tmp_path / "diagram.json").read_bytes()


def test_in_space(tmp_path):
    """The space is told by the coordinates, and written beside them; components that follow a frame say so."""
    section = ph.Section(1e3, (1e3, 2e3), (1.0, 2.0), 1.0, (1e-2, 2e-2), torsion=1.0, polar=0.1)
    d = ph.Diagram("space", gravity=(0.0, 0.0, 0.0))
    load = ph.LineLoad("wind", (0.0, 1.0, 2.0), follows=True)
    beam = d.add(ph.Beam("b", section, (0, 0, 0), (1, 0, 1), 3, normal=(0.0, 1.0, 0.3), curvature=0.2, loads=load))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "tip", follows=True)
    d.connect(beam.end.rotation, d.add(ph.Moment("twist", (1.0, 2.0, 3.0), follows=True)).port)
    back = there_and_back(d, tmp_path)
    assert_same_system(back.compile(), d.compile())
    assert back.network.space == d.network.space
    np.testing.assert_array_equal(back.blocks["b"].end.frame, beam.end.frame)
    data = json.loads((tmp_path / "diagram.json").read_text(encoding="utf-8"))
    assert data["space"] == "spatial" and data["exposed"][0]["follows"] is True
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.Draft202012Validator(SCHEMA).validate(data)
    for change, says in (
        ({"space": "planar"}, "space: expected 'spatial', as its coordinates say"),
        ({"exposed": [{**data["exposed"][0], "follows": 1}]}, "follows: expected true or false"),
    ):
        (tmp_path / "wrong.json").write_text(json.dumps(data | change), encoding="utf-8")
        with pytest.raises(ExportError, match=says):
            ph.load(tmp_path / "wrong.json")


def test_nested(scenes, tmp_path):
    outer, arm = ph.Diagram("outer", gravity=(0.0, -9.81)), scenes["arm"]
    for name in ("left", "right"):
        outer.add(arm, name)
    robot, leaf = ph.Diagram("robot"), ph.Diagram("leaf")
    leaf.add(ph.Beam("b", SECTION, (0, 0), (1, 0), elements=2, loads=ph.LineLoad("wind", (1.0, 2.0))))
    robot.add(leaf)
    outer.add(robot)
    back = there_and_back(outer, tmp_path)
    assert_same_system(back.compile(), outer.compile())
    assert "robot/leaf/b" in back.blocks and "left/drive" in {i.exposure for i in back.compile().inputs}
    back.add(arm, "third")  # it can be gone on with


@settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(diagram=planar.diagrams())
def test_random_diagrams(diagram, tmp_path_factory):
    diagram = diagram if isinstance(diagram, ph.Diagram) else diagram[0]
    try:
        back = there_and_back(diagram, tmp_path_factory.mktemp("random"))
    except ExportError as error:
        assert "got a function" in str(error) or "names of letters" in str(error), error
        return
    try:
        expected = diagram.compile()
    except PhblocksError as error:
        with pytest.raises(type(error)):
            back.compile()
        return
    assert_same_system(back.compile(), expected)


def test_arguments_are_as_they_were_given(tmp_path):
    """What changes after the block was made does not change the file; neither does pruning or a repair the block."""
    start = np.array([0.0, 0.0])
    d = ph.Diagram("later")
    d.add(ph.Beam("b", SECTION, start, (1, 0), elements=2))
    start[:] = 5.0
    assert there_and_back(d, tmp_path).blocks["b"].start.position.tolist() == [0.0, 0.0]


def test_a_block_of_the_users(tmp_path):
    class Heavy(ph.Mass):
        """Ten kilograms."""

        def __init__(self, name, position):
            super().__init__(name, 10.0, position)

    d = ph.Diagram("own")
    d.add(Heavy("h", (0, 0)))
    back = there_and_back(d, tmp_path).blocks["h"]
    assert type(back) is Heavy and back.mass == 10.0
    assert json.loads((tmp_path / "diagram.json").read_text())["blocks"][0]["kind"].endswith("Heavy")
    del Block.kinds[Heavy.kind]


# What has no place in a file


@pytest.mark.parametrize(
    "block",
    [
        ph.Force("f", lambda t: (t, 0.0)),
        ph.Beam("f", SECTION, (0, 0), (1, 0), elements=1, loads=ph.LineLoad("w", lambda t: (t, 0.0))),
        ph.CustomBlock("f", 1, lambda x: x[0] ** 2, lambda x: 2 * x, lambda x: [[2.0]]),
        ph.CustomBlock.from_sympy("f", sympy.Symbol("q") ** 2, [sympy.Symbol("q")], R=lambda x: [[x[0] ** 2]]),
    ],
    ids=["signal", "load", "energy", "matrix"],
)
def test_functions_are_refused(block, tmp_path):
    d = ph.Diagram("functions")
    d.add(block)
    with pytest.raises(ExportError, match=r"'f' argument '\w+'.*got a function"):
        d.save(tmp_path / "x.json")
    assert not (tmp_path / "x.json").exists()


def test_other_things_are_refused(tmp_path):
    d = ph.Diagram("other")
    block = d.add(ph.Mass("m", 1.0, (0, 0)))
    for argument in (object(), {1: 2}, {"$a": 1}, sympy.Symbol("a b"), sympy.Function("f")(sympy.Symbol("q"))):
        block._given = (("m", argument, (0, 0)), {})
        with pytest.raises(ExportError, match="'m' argument 'mass'"):
            d.save(tmp_path / "x.json")
    with pytest.raises(ExportError, match="place to write to"):
        ph.Diagram("d").save(tmp_path / "no" / "x.json")
    for path in (None, 3):
        with pytest.raises(ArgumentTypeError):
            ph.Diagram("d").save(path)
        with pytest.raises(ArgumentTypeError):
            ph.load(path)


# Damaged, foreign and hostile files


@pytest.fixture
def content(tmp_path):
    return json.loads(workshop().save(tmp_path / "workshop.json").read_text(encoding="utf-8"))


def write(tmp_path, data) -> Path:
    path = tmp_path / "x.json"
    path.write_text(data if isinstance(data, str) else json.dumps(data), encoding="utf-8")
    return path


def entry(data, name):
    return next(block for block in data["blocks"] if block["name"] == name)


@pytest.mark.parametrize(
    ("change", "error", "says"),
    [
        (lambda d: d.update(format="other"), ExportError, "format = 'phblocks diagram', got 'other'"),
        (lambda d: d.pop("format"), ExportError, "got one without"),
        (lambda d: d.update(version=2), ExportError, "expected version 1, got 2"),
        (lambda d: d.update(version=True), ExportError, "expected version 1"),
        (lambda d: d.pop("junctions"), ExportError, "none named junctions"),
        (lambda d: d.update(extra=1), ExportError, "no keys but .*got extra"),
        (lambda d: d.update(blocks={}), ExportError, "blocks: expected a list"),
        (lambda d: d.update(gravity=[1]), DataError, "two or three finite components"),
        (lambda d: d.update(name=3), ArgumentTypeError, "name of a diagram"),
        (lambda d: d["blocks"].append(3), ExportError, r"blocks\[\d+\]: expected an object"),
        (lambda d: entry(d, "mass").update(kind="Block"), ExportError, "kind: expected one of"),
        (lambda d: entry(d, "mass").update(kind="os.system"), ExportError, "kind: expected one of"),
        (lambda d: entry(d, "mass").update(kind=["Mass"]), ExportError, "kind: expected one of"),
        (lambda d: entry(d, "mass").update(maker="from_sympy"), ExportError, "maker: expected none"),
        (lambda d: entry(d, "pendulum").update(maker="__init__"), ExportError, "from_sympy, got __init__"),
        (lambda d: entry(d, "mass").update(arguments=[1]), ExportError, "arguments: expected an object"),
        (
            lambda d: entry(d, "mass")["arguments"].update(weight=1),
            ExportError,
            "mass, position, approximation, got weight",
        ),
        (
            lambda d: entry(d, "mass")["arguments"].update(mass=-1),
            DataError,
            "'mass' mass: expected a finite number > 0",
        ),
        (lambda d: entry(d, "mass")["arguments"].update(mass="1"), ArgumentTypeError, "Mass 'mass' mass"),
        (lambda d: entry(d, "mass")["arguments"].pop("mass"), ExportError, "missing 1 required positional"),
        (lambda d: entry(d, "mass").update(name="a.b"), DataError, "without dots"),
        (lambda d: entry(d, "mass")["arguments"].update(mass={"$type": "Popen"}), ExportError, "type out of Section"),
        (lambda d: entry(d, "mass")["arguments"].update(mass={"$import": "os"}), ExportError, "expected .type"),
        (lambda d: entry(d, "Träger")["arguments"]["section"].pop("axial"), ExportError, "a complete Section"),
        (lambda d: entry(d, "Träger")["arguments"]["section"].update(a=1), ExportError, "of Section axial"),
        (lambda d: entry(d, "Träger")["arguments"].update(elements=10**12), DataError, "at most 1000000"),
        (lambda d: d["junctions"].append({"ports": ["nobody.x"]}), UnknownNameError, "a block out of"),
        (lambda d: d["junctions"].append({"ports": ["mass.x"]}), UnknownNameError, "one of its ports"),
        (lambda d: d["junctions"].append({"ports": [3]}), ExportError, "a port such as"),
        (lambda d: d["junctions"].append({"ports": []}), ExportError, "a list of ports"),
        (lambda d: d["junctions"].append(d["junctions"][0]), PortInUseError, "a port that is not joined yet"),
        (lambda d: [j.pop("apart", 0) for j in d["junctions"]], GapError, "anchors in the same place"),
        (lambda d: d["exposed"][0].update(imposes="love"), DataError, "imposes"),
    ],
)
def test_what_is_wrong_is_named(content, tmp_path, change, error, says):
    change(content)
    with pytest.raises(error, match=says) as caught:
        ph.load(write(tmp_path, content))
    assert type(caught.value) is error


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "null",
        "[]",
        "3",
        '{"format": "phblocks diagram", "format": 1}',
        '{"format": NaN}',
        "[" * 100_000,
        '{"format": ' + "9" * 5000 + "}",
        "\x00\x01",
    ],
)
def test_what_is_not_json_or_not_a_diagram(tmp_path, text):
    with pytest.raises(ExportError):
        ph.load(write(tmp_path, text))
    with pytest.raises(ExportError, match="can be read"):
        ph.load(tmp_path / "none.json")


def test_truncated(content, tmp_path):
    text = json.dumps(content, indent=1)
    for end in range(0, len(text) - 1, 97):
        with pytest.raises(ExportError):
            ph.load(write(tmp_path, text[:end]))


HOSTILE = [
    *(None, True, 0, -1, 1e308, -0.5, 10**30, "", "a.b", "__class__", "\u0000", [], [[]], [1, [2]], {}, {"a": 1}),
    *({"$type": "Section"}, {"$type": 3}, {"$number": "nan"}, {"$number": "inf"}, {"$domain": "x"}, {"$symbol": "q"}),
    *({"$expression": "().__class__"}, {"$expression": "9**9**9**9"}, {"$matrix": [["q"], ["1", "2"]]}, {"$": {}}),
]


def spots(data, path=()):
    """All places in a tree."""
    yield path
    for key in data if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else ():
        yield from spots(data[key], (*path, key))


@settings(max_examples=400, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_anything_in_the_place_of_anything(data, tmp_path_factory):
    """Loads or is refused by a typed error; nothing else comes out."""
    if not hasattr(test_anything_in_the_place_of_anything, "content"):
        path = workshop().save(tmp_path_factory.mktemp("fuzz") / "w.json")
        test_anything_in_the_place_of_anything.content = json.loads(path.read_text(encoding="utf-8"))
    content = copy.deepcopy(test_anything_in_the_place_of_anything.content)
    *path, last = data.draw(st.sampled_from(list(spots(content))[1:]))
    target = content
    for key in path:
        target = target[key]
    if data.draw(st.booleans()):
        target[last] = data.draw(st.sampled_from(HOSTILE))
    elif isinstance(target, dict):
        target[data.draw(st.sampled_from(["name", "x", "$type", "kind"]))] = target.pop(last)
    else:
        target.append(target.pop(last))
    try:
        ph.load(write(tmp_path_factory.getbasetemp(), content))
    except PhblocksError as error:
        assert error.fix


# Expressions


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('touch /tmp/never')",
        "q.__class__",
        "(lambda: 1)()",
        "[q for q in (1,)]",
        "open('x')",
        "sin(q, q)",
        "sin(x=q)",
        "'text'",
        "True",
        "q if q else 1",
        "q; q",
        "q = 1",
        "unknown + 1",
        "1/0",
        "9**9**9**9",
        "((9**200)**200)**200",
        "q // 2",
        "(" * 1000 + "q" + ")" * 1000,
        "1" * 11_000,
        "1e999",
        "",
        3,
    ],
)
def test_texts_that_are_no_expressions(text):
    with pytest.raises(ExportError, match="expected an expression"):
        expression_of(text, {"q": sympy.Symbol("q")}, "here")


def test_expressions_come_back():
    q, p = sympy.symbols("q p")
    for expression in (
        p**2 / (2 * sympy.Float(0.1)) + sympy.cos(q),
        sympy.Rational(1, 3) * q**-2 + sympy.pi * sympy.exp(-p / 7),
        sympy.sqrt(q**2 + 1e-300) * sympy.tanh(3 * p) + sympy.E,
        sympy.Integer(4),
    ):
        back = expression_of(text_of(expression, "here"), {"q": q, "p": p}, "here")
        assert back == expression


# The schema and its page


SCHEMA = json.loads((ROOT / "phblocks" / "diagram.schema.json").read_text(encoding="utf-8"))


def test_files_satisfy_the_schema(content, scenes, tmp_path):
    jsonschema = pytest.importorskip("jsonschema")
    validator = jsonschema.Draft202012Validator(SCHEMA)
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    validator.validate(content)
    for scene in scenes.values():
        validator.validate(json.loads(scene.save(tmp_path / "s.json").read_text(encoding="utf-8")))
    for change in (
        lambda d: d.update(version=2),
        lambda d: d.pop("name"),
        lambda d: d["blocks"][0].pop("kind"),
        lambda d: d["junctions"][0].update(ports=[]),
        lambda d: d.update(extra=1),
    ):
        wrong = copy.deepcopy(content)
        change(wrong)
        assert not validator.is_valid(wrong)


def test_the_page_names_all_blocks_and_their_arguments():
    text = (ROOT / "docs" / "diagram-json.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", text, re.M))
    for name in PUBLIC:
        cls = getattr(ph, name)
        made = inspect.signature(getattr(cls, cls.makers[0]) if cls.makers else cls)
        names = [p for p, what in made.parameters.items() if p != "name" and what.kind is not what.VAR_KEYWORD]
        assert set(names) <= set(re.findall(r"`(\w+)`", rows[name])), name
    example = re.search(r"^```json\n(.*?)^```$", text, re.S | re.M)[1]
    assert json.loads(example)["format"] == "phblocks diagram"


def test_the_example_of_the_page_swings(tmp_path):
    text = (ROOT / "docs" / "diagram-json.md").read_text(encoding="utf-8")
    example = re.search(r"^```json\n(.*?)^```$", text, re.S | re.M)[1]
    system = ph.load(write(tmp_path, example)).compile()
    solution = ph.simulate(system, t_end=0.5, dt=0.01)
    assert solution.status.ok and solution.max_power_balance_error < 1e-10
    assert solution.energy.kinetic[-1] > 0.1
