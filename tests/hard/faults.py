"""Diagrams and data at random, most of it right, some of it NaN, huge, of the wrong kind or in the wrong place.

Whatever is done, the library answers with a ``PhblocksError`` or does it; any other exception ends the program and
fails the test.
"""

import math
from collections import Counter
from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np

import phblocks as ph

WRONG: tuple[Any, ...] = (
    math.nan,
    math.inf,
    -math.inf,
    -1.0,
    0.0,
    -0.0,
    1e300,
    -1e300,
    1.7e308,
    1e-300,
    5e-324,
    1e160,
    1e-160,
    True,
    None,
    "1.0",
    "",
    "a.b",
    b"x",
    1 + 2j,
    10**400,
    -3,
    [],
    [1.0],
    (1.0, 2.0, 3.0),
    [[1.0, 2.0], [3.0, 4.0]],
    [1.0, [2.0, 3.0]],
    (math.nan, 0.0),
    (1e300, -1e300),
    (0.0, math.inf),
    ("a", "b"),
    (None, 1.0),
    {},
    {"x": 1.0},
    {1.0, 2.0},
    object(),
    np.array([1.0, math.nan]),
    np.array(["a"]),
    np.array([object()]),
    np.zeros((0, 2)),
    np.zeros((2, 0)),
    np.array(1.0),
    np.float32(2.5),
    np.int8(-1),
    np.datetime64("2020-01-01"),
    lambda: 1.0,
    lambda t: t,
    lambda t: math.nan,
    lambda t: "x",
    lambda t: 1.0 / (t - t),
    ph.Beam,
    ph,
)


class Program:
    """Things made so far, and what is done with them next."""

    def __init__(self, random: Random, wrong: float) -> None:
        self.random, self.wrong = random, wrong
        self.log: list[str] = []
        self.counter: Counter[str] = Counter()
        self.diagrams = [ph.Diagram("first", gravity=(0.0, -9.81))]
        self.places = [(0.0, 0.0), (1.0, 0.0), (0.3, 1.0), (1.5, -0.5)]
        self.blocks: list[Any] = []
        self.systems: list[ph.System] = []

    # --- values ------------------------------------------------------------------------------------------------------

    def maybe(self, value: Any) -> Any:
        """The value, or something wrong in its place."""
        return self.random.choice(WRONG) if self.random.random() < self.wrong else value

    def size(self) -> Any:
        return self.maybe(10.0 ** self.random.uniform(-2.0, 3.0))

    def place(self) -> Any:
        return self.maybe(self.random.choice(self.places))

    def name(self) -> Any:
        return self.maybe(f"{self.random.choice('abcdefgh')}{self.random.randrange(30)}")

    def anchor(self) -> Any:
        anchors = [self.diagrams[-1].ground] + [a for b in self.blocks for a in getattr(b, "anchors", {}).values()]
        return self.maybe(self.random.choice(anchors))

    def port(self) -> Any:
        ports = [p for b in self.blocks for p in b.ports.values()] + list(self.diagrams[-1].ground.ports)
        return self.maybe(self.random.choice(ports))

    def diagram(self) -> ph.Diagram:
        return self.random.choice(self.diagrams)

    # --- deeds -------------------------------------------------------------------------------------------------------

    def attempt(self, what: str, deed: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
        """Do it; a typed error that helps is as good as a result."""
        self.log.append(f"{what} {arguments} {options}")
        try:
            result = deed(*arguments, **options)
        except ph.PhblocksError as error:
            assert error.where and error.expected and error.got and error.fix, repr(error)
            self.counter["refused"] += 1
            return None
        self.counter["done"] += 1
        return result

    def section(self) -> Any:
        if self.random.random() < 0.5:
            values = [self.size() for _ in range(2)]
            return self.attempt(
                "rectangle", ph.Section.rectangle, *values, self.size(), self.maybe(0.3), self.size(), self.maybe(0.8)
            )
        keys = ("axial", "shear", "bending", "mass", "rotary")
        return self.attempt("section", ph.Section, **{key: self.size() for key in keys})

    def make(self) -> None:
        """Make a block and add it."""
        choose, size, place, name = self.random.choice, self.size, self.place, self.name
        matrix = self.maybe([[0.0, 1.0], [-1.0, 0.0]])
        kinds: dict[str, Callable[[], Any]] = {
            "Beam": lambda: self.attempt(
                "Beam",
                ph.Beam,
                name(),
                self.maybe(self.section()),
                place(),
                place(),
                self.maybe(choose([1, 2, 3, (0.0, 0.4, 1.0)])),
                self.maybe(choose([1, 2])),
                causality=self.maybe(choose(["auto", "free-free", ("pinned", "free")])),
                curvature=self.maybe(choose([None, 0.3])),
                switch_at=self.maybe(0.5),
                damping=self.maybe(self.attempt("Damping", ph.Damping, size(), internal=size())),
            ),
            "Mass": lambda: self.attempt("Mass", ph.Mass, name(), size(), place()),
            "RigidBody": lambda: self.attempt(
                "RigidBody", ph.RigidBody, name(), size(), size(), place(), self.maybe({"a": place(), "b": place()}),
                coordinates=self.maybe("world"), angle=self.maybe(0.0),
            ),
            "Spring": lambda: self.attempt("Spring", ph.Spring, name(), size(), place(), place()),
            "Damper": lambda: self.attempt("Damper", ph.Damper, name(), size(), place(), place()),
            "Force": lambda: self.attempt("Force", ph.Force, name(), self.maybe((1.0, 0.0)), follows=self.maybe(False)),
            "Moment": lambda: self.attempt("Moment", ph.Moment, name(), size()),
            "Velocity": lambda: self.attempt("Velocity", ph.Velocity, name(), self.maybe((0.1, 0.0))),
            "TorsionSpring": lambda: self.attempt("TorsionSpring", ph.TorsionSpring, name(), size()),
            "Bushing": lambda: self.attempt("Bushing", ph.Bushing, name(), size(), size()),
            "Slider": lambda: self.attempt(
                "Slider", ph.Slider, name(), self.maybe((1.0, 0.0)), guide=self.maybe("fixed")
            ),
            "RigidJoint": lambda: self.attempt("RigidJoint", ph.RigidJoint, name(), self.maybe(True)),
            "Transformer": lambda: self.attempt(
                "Transformer", ph.Transformer, name(), size(), self.maybe(ph.ROTATION), self.maybe(ph.ROTATION)
            ),
            "Gyrator": lambda: self.attempt(
                "Gyrator", ph.Gyrator, name(), size(), self.maybe(ph.ELECTRICAL), self.maybe(ph.ROTATION)
            ),
            "DCMotor": lambda: self.attempt("DCMotor", ph.DCMotor, name(), size(), size(), inductance=size()),
            "Resistor": lambda: self.attempt("Resistor", ph.Resistor, name(), size()),
            "Capacitor": lambda: self.attempt("Capacitor", ph.Capacitor, name(), size()),
            "Inductor": lambda: self.attempt("Inductor", ph.Inductor, name(), size()),
            "Reference": lambda: self.attempt("Reference", ph.Reference, name(), self.maybe(ph.ELECTRICAL)),
            "SystemBlock": lambda: self.attempt(
                "SystemBlock", ph.SystemBlock, name(), E=self.maybe(np.eye(2)), J=matrix, G=self.maybe([[1.0], [0.0]]),
                ports=self.maybe({"p": self.attempt("SystemPort", ph.SystemPort, ph.ELECTRICAL, [0], "voltage")}),
            ),
        }  # fmt: skip
        block = kinds[choose([*["Beam", "Beam", "Mass", "RigidBody", "Spring", "Damper"] * 8, *kinds])]()
        if block is not None:
            self.blocks.append(block)
            if self.random.random() < 0.95:
                self.attempt("add", self.diagrams[-1].add, self.maybe(block))

    def method(self) -> Any:
        choose = self.random.choice
        newton = self.attempt("Newton", ph.Newton, self.maybe(1e-15), self.maybe(15))
        makers: list[Callable[[], Any]] = [
            lambda: None,
            lambda: self.attempt("Midpoint", ph.Midpoint, self.maybe(newton), predict=self.maybe(True)),
            lambda: self.attempt("GaussLegendre", ph.GaussLegendre, self.maybe(2)),
            lambda: self.attempt("LinearlyImplicit", ph.LinearlyImplicit, corrections=self.maybe(0)),
        ]
        return choose(makers)()

    def join(self) -> None:
        """Pin, weld, connect, free or expose, with what there is."""
        d = self.diagram() if self.random.random() < 0.1 else self.diagrams[-1]
        count = self.random.choice([2, 2, 2, 3, 1, 0])
        how = self.random.choice(["pin", "pin", "weld", "connect", "free", "expose"])
        if how in ("pin", "weld"):
            anchors = [self.anchor() for _ in range(count)]
            self.attempt(how, getattr(d, how), *anchors, multiplier=self.maybe(self.random.random() < 0.3))
        elif how == "connect":
            self.attempt("connect", d.connect, *[self.port() for _ in range(count)], apart=self.maybe(True))
        elif how == "free":
            self.attempt("free", d.free, self.random.choice([self.anchor, self.port])())
        else:
            self.attempt("expose", d.expose, self.port(), self.name(), self.maybe(None))

    def fit(self) -> None:
        """Pin what meets in the same place: random ports seldom do."""
        d = self.diagrams[-1]
        for place in self.places:
            anchors = [
                a
                for b in d.network.blocks.values()
                for a in b.anchors.values()
                if a.position is not None
                and np.allclose(a.position, place)
                and a.translation not in d.network.junction_of
            ]
            if place == (0.0, 0.0):
                anchors.append(d.ground)
            elif anchors and all(isinstance(a.block, (ph.Spring, ph.Damper)) for a in anchors):
                mass = self.attempt("Mass", ph.Mass, self.name(), self.size(), place)
                if mass is not None and self.attempt("add", d.add, mass) is not None:
                    anchors.append(mass.centre)
            if len(anchors) > 1:
                self.attempt("pin what meets", d.pin, *anchors)

    def draw(self) -> None:
        """Blocks, what joins them, and perhaps a diagram in a diagram."""
        for _ in range(self.random.randrange(2, 7)):
            self.make()
        if self.random.random() < 0.9:
            self.fit()
        for _ in range(self.random.choice([0, 0, 1, 2, 4])):
            self.join()
        if self.random.random() < 0.2:
            self.nest()

    def nest(self) -> None:
        """Put a diagram into another, or into itself."""
        if self.random.random() < 0.5:
            new = self.attempt("Diagram", ph.Diagram, self.name(), gravity=self.maybe((0.0, -9.81)))
            if new is not None:
                self.diagrams.append(new)
        self.attempt("nest", self.diagram().add, self.maybe(self.diagram()), self.name())

    def run(self) -> None:
        """Compile and simulate, with right and wrong options."""
        d = self.diagrams[-1]
        self.attempt("check", d.check)
        system = self.attempt("compile", d.compile, outputs=self.maybe("all"))
        if system is None:
            return
        self.counter["compiled"] += 1
        start = None
        if self.random.random() < 0.3:
            x = system.start.x.copy()
            if x.size:
                x[self.random.randrange(x.size)] = self.random.choice([1.0, math.nan, 1e3, 1e300, math.inf])
            start = self.maybe(ph.State(x, system.start.theta, system.start.points))
        inputs = {}
        for exposure in d.network.exposures():
            two = exposure.port.domain.turns_with == "translation"
            value = self.maybe((0.1, 0.2) if two else 0.1)
            inputs[exposure.name] = self.random.choice([value, lambda t, value=value: value])
        dt = self.maybe(10.0 ** self.random.uniform(-4.0, -1.0))
        t_end = dt * 4 if isinstance(dt, float) else 0.1
        run = self.attempt(
            "simulate",
            ph.simulate,
            system,
            self.maybe(t_end),
            dt,
            method=self.maybe(self.method()),
            start=start,
            inputs=self.maybe(inputs),
            save_every=self.maybe(1),
            max_halvings=self.random.choice([0, 3]),
            times=self.maybe(None),
            progress=False,
        )
        if run is None:
            return
        self.counter[run.status.name] += 1
        if run.status.ok:
            series = [run.x, run.t, *(run.energy[name] for name in run.energy)]
            finite = all(np.isfinite(s).all() for s in series) and math.isfinite(run.max_power_balance_error)
            assert finite, "a number that is not finite in a run that succeeded"
        if self.blocks:
            block = self.random.choice(self.blocks)
            self.attempt("position", run.position, self.maybe(block), self.maybe(0.5), source=self.maybe("velocity"))
            self.attempt("force", run.force, self.maybe(block), self.maybe(0.5), frame=self.maybe("fixed"))


def play(random: Random, wrong: float, counter: Counter[str], diagram: ph.Diagram | None = None) -> None:
    """Draw a diagram with some faults in it, or take one that was drawn, and run it."""
    program = Program(random, wrong)
    try:
        if diagram is None:
            program.draw()
        else:
            program.diagrams = [diagram]
            program.blocks = list(diagram.network.blocks.values())
        program.run()
    except BaseException:
        print("\n".join(program.log))  # pytest shows it with the failure
        raise
    counter.update(program.counter)
