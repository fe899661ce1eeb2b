"""FMUs in FMPy: valid, with the units of the ports, and with the run of ``simulate`` and its energies."""

import sys
import zipfile
from unittest.mock import patch

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, ExportError, ExtraMissingError
from phblocks.fmu.interface import base_units, structured
from phblocks.fmu.runtime import Runtime

SECTION = ph.Section(axial=4e4, shear=2e4, bending=60.0, mass=1.2, rotary=2e-3)


def arm() -> ph.Diagram:
    """A pendulum with internal damping, a force at its tip, a moment at its root and a load of its own."""
    d = ph.Diagram("arm no. 1", gravity=(0.0, -9.81))
    load = ph.LineLoad("wind", (3.0, 0.5))
    damping = ph.Damping(viscous=0.1, internal=1e-3)
    b = d.add(ph.Beam("arm", SECTION, (0.1, 0.2), (0.9, 0.8), elements=4, damping=damping, loads=load))
    d.pin(b.start, d.ground)
    d.expose(b.end.translation, "tip")
    d.expose(b.start.rotation, "drive")
    return d


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    pytest.importorskip("pythonfmu3")
    return ph.fmu.write(arm(), tmp_path_factory.mktemp("fmu") / "arm.fmu", step=0.005)


def test_valid_in_fmpy(written):
    pytest.importorskip("fmpy")
    from fmpy import read_model_description
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(written)) == []
    model = read_model_description(str(written))
    assert model.fmiVersion == "3.0" and model.coSimulation is not None and model.modelName == "arm_no_1"
    units = {v.name: (v.causality, v.unit) for v in model.modelVariables}
    assert units["tip.x"] == ("input", "N") and units["tip.y_velocity"] == ("output", "m/s")
    assert units["drive"] == ("input", "N m") and units["drive_angular_velocity"] == ("output", "rad/s")
    assert units["wind.x"] == ("input", "N/m") and units["energy.error"] == ("output", "J")
    starts = {v.name: float(v.start) for v in model.modelVariables if v.start is not None}
    assert (starts["wind.x"], starts["wind.y"], starts["tip.x"], starts["longest_step"]) == (3.0, 0.5, 0.0, 0.005)
    base = {u.name: u.baseUnit for u in model.unitDefinitions}["N m"]
    assert (base.kg, base.m, base.s) == (1, 2, -2)


def test_it_carries_no_pickle(written):
    with zipfile.ZipFile(written) as archive:
        names = archive.namelist()
        assert "resources/diagram.json" in names and not any(name.endswith((".pkl", ".pickle")) for name in names)
        assert b'"format": "phblocks diagram"' in archive.read("resources/diagram.json")


def test_the_run_of_simulate_in_fmpy(written):
    """0.5 s in communication steps of 0.02 s, each of four steps of the midpoint rule, with constant inputs."""
    fmpy = pytest.importorskip("fmpy")
    columns = ["tip.x_velocity", "tip.y_velocity", "drive_angular_velocity"]
    energies = ["energy.stored", "energy.gravity", "energy.supplied", "energy.dissipated", "energy.error"]
    found = fmpy.simulate_fmu(
        str(written),
        stop_time=0.5,
        step_size=0.02,
        output_interval=0.02,
        output=columns + energies,
        start_values={"tip.x": 1.0, "tip.y": 2.0, "drive": 0.3},
    )
    system = arm().compile()
    inputs = {"tip": (1.0, 2.0), "drive": 0.3}
    solution = ph.simulate(system, t_end=0.5, dt=0.005, inputs=inputs, save_every=4)
    y = [system.G(theta, x).T @ x for theta, x in zip(solution.recording.theta, solution.x, strict=True)]
    for k, name in enumerate(columns):
        place = [n.replace(" ", "_") for n in system.output_names].index(name)
        np.testing.assert_allclose(found[name], np.array(y)[:, place], rtol=1e-9, atol=1e-9, err_msg=f"{k}")
    energy = solution.energy
    for name in ("gravity", "supplied", "dissipated"):
        np.testing.assert_allclose(found[f"energy.{name}"], getattr(energy, name), rtol=1e-9, atol=1e-9)
    size = np.abs(energy.supplied).max()
    assert found["energy.error"][-1] < 1e-12 * size and energy.dissipated[-1] > 1e-3 * size
    total = found["energy.stored"] + found["energy.gravity"] - found["energy.supplied"] + found["energy.dissipated"]
    assert np.abs(total - total[0]).max() < 1e-11 * size


def test_inputs_may_change_between_steps(tmp_path):
    """The work of a force that changes is what the ledger of the FMU books: F . velocity over each step."""
    runtime = Runtime(arm().save(tmp_path / "arm.json"), 0.01)
    system, rng = runtime.system, np.random.default_rng(0)
    for _ in range(20):
        runtime.u = rng.normal(size=system.n_inputs)
        assert runtime.advance(0.025)
    balance = runtime.energy["stored"] + runtime.energy["gravity"] + runtime.energy["dissipated"]
    assert balance == pytest.approx(runtime.energy["supplied"], abs=1e-11)
    assert runtime.time == pytest.approx(0.5) and abs(runtime.energy["supplied"]) > 1e-3


def test_an_energy_of_the_users_and_constraints(tmp_path):
    """A Duffing oscillator takes the discrete gradient; masses held together by a multiplier start consistently."""
    import sympy

    q, p = sympy.symbols("q p")
    d = ph.Diagram("duffing")
    d.add(ph.CustomBlock.from_sympy("d", p**2 / 2 + q**4, (q, p), J=[[0, 1], [-1, 0]], start=(1.0, 0.0)))
    one, two = d.add(ph.Mass("one", 1.0, (0, 0))), d.add(ph.Mass("two", 3.0, (0, 0)))
    d.pin(one.centre, two.centre, multiplier=True)
    d.expose(one.centre.translation, "push")
    runtime = Runtime(d.save(tmp_path / "d.json"), 0.01)
    runtime.u[:] = (8.0, 0.0)
    runtime.begin()
    assert runtime.advance(1.0)
    assert runtime.outputs()[0] == pytest.approx(2.0)  # 8 N on 4 kg for 1 s
    assert runtime.energy["error"] < 1e-12
    assert runtime.energy["stored"] == pytest.approx(1.0 + 8.0)


def test_a_step_that_cannot_be_taken(tmp_path):
    runtime = Runtime(arm().save(tmp_path / "arm.json"), 0.01)
    assert runtime.advance(0.0)
    for duration in (-0.1, float("nan"), 1e12):
        assert not runtime.advance(duration)
    runtime.u[0] = float("nan")
    assert not runtime.advance(0.01)


def test_refused(tmp_path):
    with pytest.raises(ArgumentTypeError, match=r"fmu\.write: expected a Diagram"):
        ph.fmu.write(arm().compile(), tmp_path / "x.fmu")
    with pytest.raises(ExportError, match=r"crane\.fmu"):
        ph.fmu.write(arm(), tmp_path / "x.zip")
    with pytest.raises(DataError, match="step"):
        ph.fmu.write(arm(), tmp_path / "x.fmu", step=0.0)
    with patch.dict(sys.modules, pythonfmu3=None), pytest.raises(ExtraMissingError, match=r"phblocks\[fmu\]"):
        ph.fmu.write(arm(), tmp_path / "x.fmu")
    pytest.importorskip("pythonfmu3")
    d = arm()
    d.add(ph.Force("f", lambda t: (t, 0.0)))
    with pytest.raises(ph.PhblocksError):
        ph.fmu.write(d, tmp_path / "x.fmu")
    with pytest.raises(ExportError, match="place to write to"):
        ph.fmu.write(arm(), tmp_path / "no" / "folder" / "x.fmu")
    assert not list(tmp_path.glob("*"))


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ("N m", {"kg": 1, "m": 2, "s": -2}),
        ("m/s", {"m": 1, "s": -1}),
        ("m^3/s", {"m": 3, "s": -1}),
        ("V", {"kg": 1, "m": 2, "s": -3, "A": -1}),
        ("", None),
        ("apples", None),
    ],
)
def test_units(unit, expected):
    assert base_units(unit) == expected


def test_names():
    assert structured(["tip.x", "tip.x velocity", "Böe.1", "a b", "a-b"]) == [
        "tip.x",
        "tip.x_velocity",
        "B_e._1",
        "a_b",
        "a_b_4",
    ]
