"""From constants and functions of time to one vector u(t)."""

import math

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, UnknownNameError
from phblocks.inputs import Drive, InputFailed, NotFinite


@pytest.fixture(scope="module")
def system(bar) -> ph.System:
    """A beam driven in angular velocity at its root, with a force and a moment at its tip."""
    d = ph.Diagram()
    b = d.add(ph.Beam("b", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(b.start, d.ground)
    d.expose(b.end.translation, "force")
    d.expose(b.start.rotation, "spin", imposes="angular velocity")
    d.expose(b.end.rotation, "moment")
    return d.compile()


def test_constants_and_functions_stand_where_their_names_do(system):
    assert system.input_names == ("force.x", "force.y", "spin", "moment")
    drive = Drive(system, {"moment": lambda t: 3.0 * t, "force": (1.0, -2.0), "spin": lambda t: [t**2]})
    np.testing.assert_array_equal(drive.at([0.0, 2.0]), [[1.0, -2.0, 0.0, 0.0], [1.0, -2.0, 4.0, 6.0]])


def test_forces_that_are_not_given_are_zero(system):
    np.testing.assert_array_equal(Drive(system, {"spin": 0.5}).at([1.0]), [[0.0, 0.0, 0.5, 0.0]])


def test_an_imposed_velocity_has_to_be_given(system):
    with pytest.raises(DataError, match=r"inputs\['spin'\].*imposes the angular velocity, got none.*0\.0 holds it"):
        Drive(system, {"force": (1.0, 0.0)})


@pytest.mark.parametrize("name", ["nope", "force.x", "", 1, None])
def test_unknown_names(system, name):
    with pytest.raises(
        UnknownNameError, match=r"simulate inputs: expected one of the exposed ports force, spin, moment"
    ):
        Drive(system, {"spin": 0.0, name: 1.0})


def test_a_system_without_inputs(four_bar):
    system = four_bar().compile()
    assert Drive(system, {}).at([0.0, 1.0]).shape == (2, 0)
    with pytest.raises(UnknownNameError, match="there are none"):
        Drive(system, {"load": 1.0})


@pytest.mark.parametrize("signals", [1, "force", ["force"], [("force", (1.0, 2.0))], lambda t: 1.0])
def test_signals_that_are_no_mapping(system, signals):
    with pytest.raises(ArgumentTypeError, match="simulate inputs: expected a mapping"):
        Drive(system, signals)


@pytest.mark.parametrize("value", [1.0, (1.0,), (1.0, 2.0, 3.0), ((1.0, 2.0),), ()])
def test_wrong_shapes_of_a_vector(system, value):
    shape = str(np.shape(value)).replace("(", r"\(").replace(")", r"\)")
    for signal in (value, lambda t: value):
        with pytest.raises(
            DataError, match=rf"inputs\['force'\] at t = 0 s: expected numbers of shape \(2,\), got shape {shape}"
        ):
            Drive(system, {"spin": 0.0, "force": signal})


@pytest.mark.parametrize("value", [(1.0, 2.0), (), ((1.0,),)])
def test_wrong_shapes_of_a_scalar(system, value):
    for signal in (value, lambda t: value):
        with pytest.raises(DataError, match=r"inputs\['moment'\] at t = 0 s: expected a number"):
            Drive(system, {"spin": 0.0, "moment": signal})


@pytest.mark.parametrize("value", ["1.0", None, True, 1j, {}, ("a", "b"), (None, 1.0), [1.0, [2.0]]])
def test_values_that_are_no_numbers(system, value):
    for signal in (value, lambda t: value):
        for name in ("moment", "force"):
            with pytest.raises(ArgumentTypeError, match=rf"inputs\['{name}'\] at t = 0 s"):
                Drive(system, {"spin": 0.0, name: signal})


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_constants_that_are_not_finite(system, value):
    with pytest.raises(DataError, match=r"inputs\['moment'\]: expected finite numbers"):
        Drive(system, {"spin": 0.0, "moment": value})


def test_functions_that_are_not_finite_say_when(system):
    drive = Drive(system, {"spin": 0.0, "force": lambda t: (0.0, math.nan if t == 2.0 else 1.0)})
    np.testing.assert_array_equal(drive.at([1.0])[0], [0.0, 1.0, 0.0, 0.0])
    with pytest.raises(NotFinite) as caught:
        drive.at([1.0, 2.0])
    assert (caught.value.time, caught.value.name) == (2.0, "force")


def test_a_function_may_be_infinite_where_no_step_looks(system):
    with np.errstate(divide="ignore"):
        drive = Drive(system, {"spin": 0.0, "moment": lambda t: 1.0 / np.float64(t)})
    assert drive.at([0.5])[0, 3] == 2.0


def test_a_shape_that_changes_during_the_run(system):
    drive = Drive(system, {"spin": 0.0, "force": lambda t: (1.0, 2.0) if t < 1.0 else (1.0,)})
    with pytest.raises(InputFailed) as caught:
        drive.at([0.5, 1.5])
    assert (caught.value.time, caught.value.name) == (1.5, "force")
    assert isinstance(caught.value.__cause__, DataError) and "(2,), got shape (1,)" in str(caught.value.__cause__)


def test_an_exception_at_once_is_told_before_the_run(system):
    def lost(t):
        raise RuntimeError("sensor lost")

    with pytest.raises(DataError, match=r"inputs\['force'\] at t = 0 s: .* got RuntimeError: sensor lost") as caught:
        Drive(system, {"spin": 0.0, "force": lost})
    assert isinstance(caught.value.__cause__, RuntimeError)


def test_results_do_not_share_memory(system):
    drive = Drive(system, {"spin": 0.5})
    drive.at([0.0])[:] = 9.0
    assert drive.at([0.0])[0, 2] == 0.5
