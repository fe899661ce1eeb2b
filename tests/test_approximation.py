"""What can be asked for, and what is refused before anything is computed."""

import dataclasses

import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError


def test_everything_is_kept_unless_said_otherwise():
    approximation = ph.Approximation()
    assert {f.name: getattr(approximation, f.name) for f in dataclasses.fields(approximation)} == {
        "large_rotation": True,
        "shear": True,
        "extension": True,
        "rotary_inertia": True,
        "flexible": True,
        "internal_damping": True,
        "gravity": True,
        "insist": False,
    }
    with pytest.raises(dataclasses.FrozenInstanceError):
        approximation.shear = False


@pytest.mark.parametrize("field", [f.name for f in dataclasses.fields(ph.Approximation)])
@pytest.mark.parametrize("value", [None, 0, 1.0, "no", "second order", [False]])
def test_other_values_are_refused(field, value):
    with pytest.raises(ArgumentTypeError, match=f"Approximation {field}"):
        ph.Approximation(**{field: value})


def test_second_order_is_for_rotations_only():
    assert ph.Approximation(large_rotation="second-order").large_rotation == "second-order"
    with pytest.raises(ArgumentTypeError, match="shear"):
        ph.Approximation(shear="second-order")


def test_blocks_and_diagrams_want_an_approximation(bar):
    d = ph.Diagram()
    d.add(ph.Mass("m", 1.0, (0.0, 0.0)))
    for make in (
        lambda: ph.Beam("b", bar, (0, 0), (1, 0), elements=2, approximation=False),
        lambda: ph.RigidBody("r", 1.0, 1.0, (0, 0), approximation="rigid"),
        lambda: ph.Mass("n", 1.0, (0, 0), approximation={"gravity": False}),
        lambda: d.compile(approximation=True),
    ):
        with pytest.raises(ArgumentTypeError, match="expected an Approximation, or None"):
            make()
