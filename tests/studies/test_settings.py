"""What methods are called in tables."""

import pytest

import phblocks as ph
from phblocks.studies.settings import name_of, named_methods


class Plain:
    def __repr__(self):
        return "Plain(3)"


@pytest.mark.parametrize(
    ("method", "name"),
    [
        (None, "default"),
        (ph.Midpoint(), "Midpoint()"),
        (ph.Midpoint(newton=ph.ModifiedNewton(), allow_energy_error=True), "Midpoint(allow_energy_error=True)"),
        (Plain(), "Plain(3)"),
        (ph.Midpoint, repr(ph.Midpoint)),
    ],
)
def test_options_that_are_not_the_defaults(method, name):
    assert name_of(method) == name


def test_arguments_of_each_method():
    midpoint = ph.Midpoint()
    named = named_methods(
        "test", {"a": midpoint, "b": {"method": midpoint, "save_every": 5}, "c": None}, {"save_every": 2}
    )
    assert named == {
        "a": {"method": midpoint, "save_every": 2},
        "b": {"method": midpoint, "save_every": 5},
        "c": {"save_every": 2},
    }
