"""Every message about causality says in which lines of the user's file the trouble was made."""

import inspect
import re

import pytest

import phblocks as ph
from phblocks import errors
from phblocks.errors import CausalityError

SOFT = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)


def beam(name, x, **options):
    return ph.Beam(name, SOFT, (x, 0.0), (x + 1.0, 0.0), **({"elements": 2} | options))


# In each, the calls that a message must point at end in "# here".


def several(d):
    a = d.add(beam("a", 0, elements=1))
    d.weld(a.start, d.ground)  # here


def of_several_kinds(d):
    d.add(beam("a", 0, causality="pinned-free"))  # here
    b = d.add(beam("b", 1, causality="free-free"))
    d.pin(b.end, d.ground)  # here


def dangling(d):
    d.add(beam("a", 0, causality="pinned-free"))  # here


def declared_free(d):
    a = d.add(beam("a", 0, causality="pinned-free"))
    d.free(a.start)  # here


def two_give(d):
    a, b = d.add(beam("a", 0, causality="free-free")), d.add(beam("b", 1, causality="free-free"))
    d.connect(a.end.translation, b.start.translation)  # here


def two_impose(d):
    a = d.add(beam("a", 0))
    one = d.add(ph.Velocity("one", (1.0, 0.0)))  # here
    d.connect(a.start.translation, one.port)  # here
    d.expose(a.start.translation, "two", imposes="velocity")  # here


def none_gives(d):
    a, b = d.add(beam("a", 0, causality="free-pinned")), d.add(beam("b", 1, causality="pinned-free"))
    d.pin(a.end, b.start)  # here


def force_on_nothing(d):
    a = d.add(beam("a", 0, causality="pinned-free"))
    d.expose(a.start.translation, "push", imposes="force")  # here


def held(d):
    a = d.add(beam("a", 0))
    d.pin(a.start, d.ground)  # here
    d.expose(a.start.translation, "push", imposes="force")  # here


def held_by_a_source(d):
    a, drive = d.add(beam("a", 0)), d.add(ph.Velocity("drive", (1.0, 0.0)))
    push = d.add(ph.Force("push", (1.0, 0.0)))  # here
    d.connect(a.start.translation, drive.port, push.port)  # here


CASES = {
    several: "CausalityError",
    of_several_kinds: "CausalityError",
    dangling: "DanglingPortError",
    declared_free: "DanglingPortError",
    two_give: "OverdeterminedError",
    two_impose: "OverdeterminedError",
    none_gives: "UnderdeterminedError",
    force_on_nothing: "UnderdeterminedError",
    held: "HeldPortError",
    held_by_a_source: "HeldPortError",
}


@pytest.mark.parametrize("build", CASES, ids=lambda f: f.__name__)
def test_the_lines_are_named(build):
    d = ph.Diagram()
    build(d)
    with pytest.raises(CausalityError) as caught:
        d.compile()
    assert type(caught.value).__name__ == CASES[build]
    lines, first = inspect.getsourcelines(build)
    expected = {first + i for i, line in enumerate(lines) if line.rstrip().endswith("# here")}
    named = {int(line) for line in re.findall(r"test_messages\.py:(\d+)", caught.value.got)}
    assert expected and expected <= named
    for conflict in d.check().conflicts:
        assert re.search(r"(pin|weld|connect|expose|add|free) at test_messages\.py:\d+", conflict.text)


def test_every_class_is_among_them():
    classes = [c for c in vars(errors).values() if isinstance(c, type) and issubclass(c, CausalityError)]
    assert {c.__name__ for c in classes} == set(CASES.values())


def test_what_a_repair_puts_in_is_traced_to_the_joint_it_stands_for():
    d = ph.Diagram()
    a, b = (d.add(ph.RigidBody(n, 1.0, 1.0, (x, 0.0), {"p": (1.0, 0.0)})) for x, n in enumerate("ab"))
    line = inspect.currentframe().f_lineno + 1
    d.pin(a["p"], b.centre)
    bushing = next(r for r in d.check().repairs if r.cost.stiffness is not None)
    mended = bushing.apply(d)
    assert mended.network.added["pin a b"] == f"pin at test_messages.py:{line}"
    assert all(f"test_messages.py:{line}" in j.made_by for j in mended.network.joined)
