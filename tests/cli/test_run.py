"""``phblocks run``: numbers of a free fall, files, methods, runs that end early, progress."""

import re

import numpy as np
import pytest

import phblocks as ph


def test_a_stone_falls(phblocks):
    said = phblocks("run stone.py --t-end 1 --dt 0.1 --output position:stone:centre energy:kinetic")
    assert said.code == 0 and said.err == ""
    assert "status   success" in said.out and "10 steps" in said.out
    rows = {line.split()[0]: line.split()[1:] for line in said.out.splitlines() if line.strip()}
    assert [float(cell) for cell in rows["kinetic"]] == [0.0, 100.0, 100.0]  # m g^2 t^2 / 2
    assert [float(cell) for cell in rows["gravity"]] == [0.0, -100.0, 0.0]
    assert [float(cell) for cell in rows["0.5"]] == [0.0, -1.25, 25.0]


def test_the_same_for_programs(phblocks):
    said = phblocks("run stone.py --t-end 1 --dt 0.1 --input push=4,0 --output velocity:stone:0,0 --json")
    data = said.data
    assert said.code == 0 and data["ok"] and data["status"]["name"] == "success" and data["out"] is None
    assert data["statistics"]["steps"] == 10 and data["statistics"]["halvings"] == 0
    velocity = np.array(data["outputs"]["velocity:stone:0,0"])
    t = np.array(data["outputs"]["t"])
    assert velocity == pytest.approx(np.stack([2.0 * t, -10.0 * t], axis=1), abs=1e-12)
    assert data["energy"]["supplied"]["end"] == pytest.approx(4.0, rel=1e-12)  # 4 N over 1 m
    assert data["max_power_balance_error"] < 1e-12
    assert data["gap"] is None or data["gap"] < 1e-12  # NaN is not JSON


@pytest.mark.parametrize("method", ["midpoint", "gauss2", "gauss3", "discrete-gradient", "linearly-implicit"])
def test_methods_keep_the_energy(phblocks, method):
    data = phblocks(f"run rod.py --t-end 0.1 --dt 0.01 --method {method} --json").data
    assert data["ok"] and data["max_power_balance_error"] < 1e-10
    assert data["energy"]["kinetic"]["end"] == pytest.approx(0.433, rel=1e-2)  # 3/8 m g^2 t^2 of a rigid rod


@pytest.mark.parametrize("method", ["scipy-radau", "scipy-bdf", "scipy-dop853"])
def test_methods_of_scipy_take_tolerances(phblocks, method):
    data = phblocks(f"run stone.py --t-end 1 --dt 0.1 --rtol 1e-8 --atol 1e-8 --method {method} --json").data
    assert data["energy"]["kinetic"]["end"] == pytest.approx(100.0, rel=1e-6)


def test_every_method_of_the_library_can_be_asked_for():
    from phblocks.cli.values import METHODS, method_of

    made = {type(method_of(name)[0]) for name in METHODS}
    own = {ph.Midpoint, ph.GaussLegendre, ph.RadauIIA, ph.DiscreteGradient, ph.LinearlyImplicit}
    assert made == {*own, ph.ScipyIVP}
    assert all(name.startswith("scipy-") == (type(method_of(name)[0]) is ph.ScipyIVP) for name in METHODS)
    assert method_of("radau2")[0] == ph.RadauIIA(stages=2) and method_of("radau3")[0] == ph.RadauIIA(stages=3)
    assert method_of("gauss3")[0] == ph.GaussLegendre(stages=3)
    assert method_of(None, 1e-3) == (None, ph.Adaptive(rtol=1e-3))


def test_steps_are_adapted(phblocks):
    """The first step of a microsecond grows."""
    data = phblocks("run rod.py --t-end 0.2 --dt 1e-5 --rtol 1e-2 --json").data
    assert data["ok"] and data["statistics"]["steps"] < 500
    said = phblocks("run rod.py --t-end 0.2 --dt 1e-3 --atol 1e-2")
    assert said.code == 2 and "--rtol" in said.err


def test_npz(phblocks):
    assert phblocks("run stone.py --t-end 1 --dt 0.25 --out fall.npz --output position:stone:centre").code == 0
    with np.load("fall.npz") as run:
        assert run["t"].tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
        assert run["state_names"].tolist() == ["stone.vx[0]", "stone.vy[0]"]
        assert run["x"][:, 1] == pytest.approx(-10.0 * run["t"])
        assert run["position:stone:centre"][-1] == pytest.approx([0.0, -5.0])
        assert run["energy kinetic"][-1] == pytest.approx(100.0) and run["status"][0] == "success"
    again = phblocks("run stone.py --t-end 1 --dt 0.25 --out fall.npz")
    assert again.code == 2 and "--replace" in again.err
    assert phblocks("run stone.py --t-end 1 --dt 0.5 --out fall.npz --replace").code == 0
    with np.load("fall.npz") as run:
        assert run["t"].size == 3


def test_hdf5_is_read_back_and_resumed(phblocks):
    pytest.importorskip("h5py")
    assert phblocks("run stone.py --t-end 1 --dt 0.25 --out fall.h5").code == 0
    assert ph.read("fall.h5").energy.kinetic[-1] == pytest.approx(100.0)
    said = phblocks("run stone.py --out fall.h5 --resume --json")
    assert said.code == 0 and said.data["energy"]["kinetic"]["end"] == pytest.approx(100.0)
    assert said.data["statistics"]["steps"] == 4  # it had ended; nothing is done again
    assert phblocks("run stone.py --t-end 1 --dt 0.5 --out fall.h5").code == 2
    assert phblocks("run stone.py --t-end 1 --dt 0.5 --out fall.h5 --replace").code == 0
    assert phblocks("run stone.py --resume").code == 2
    assert phblocks("run rod.py --out fall.h5 --resume").code == 2  # the run of another diagram


def test_inputs_of_the_file_and_of_the_line(phblocks, folder):
    (folder / "pushed.py").write_text(
        (folder / "stone.py").read_text() + 'inputs = {"push": lambda t: (6.0 * t, 0.0)}\n'
    )
    line = "run pushed.py --t-end 1 --dt 0.1 --output position:stone:centre --json"
    assert phblocks(line).data["energy"]["supplied"]["end"] == pytest.approx(2.25, rel=5e-3)  # (3 t^2 / 2)^2, t = 1
    assert phblocks(line, "--input", "push=0,0").data["energy"]["supplied"]["end"] == 0.0
    for wrong, told in (("tip=1,0", "tip"), ("push=1", "push"), ("push", "PORT=VALUE"), ("push=a", "PORT=VALUE")):
        said = phblocks("run stone.py --t-end 1 --dt 0.1 --input", wrong)
        assert said.code == 2 and told in said.err


def test_a_run_that_ends_early_is_told(phblocks, folder):
    (folder / "failing.py").write_text(
        (folder / "stone.py").read_text()
        + 'def push(t):\n    return (1.0 / (0.5 - t) if t < 0.5 else float("nan"), 0.0)\n'
        + 'inputs = {"push": push}\n'
    )
    said = phblocks("run failing.py --t-end 1 --dt 0.1 --json")
    assert said.code == 1
    assert not said.data["ok"] and said.data["status"]["name"] == "input not finite"
    assert 0.4 < said.data["t_end"] < 0.6


def test_options_that_are_missing_or_wrong(phblocks):
    for line, told in (
        ("run stone.py --t-end 1", "no --dt"),
        ("run stone.py", "no --t-end and no --dt"),
        ("run stone.py --t-end 1 --dt -1", "dt"),
        ("run stone.py --t-end 1 --dt 0.1 --out run.txt", ".h5, .npz"),
        ("run stone.py --t-end 1 --dt 0.1 --out nowhere/run.npz", "a folder that exists"),
        ("run stone.py --t-end 1 --dt 0.1 --output speed:stone:centre", "KIND:BLOCK:PLACE"),
        ("run stone.py --t-end 1 --dt 0.1 --output position:pebble:centre", "stone"),
        ("run stone.py --t-end 1 --dt 0.1 --output position:stone:tip", "centre"),
        ("run stone.py --t-end 1 --dt 0.1 --output energy:thermal", "kinetic"),
        ("run stone.py --t-end 1 --dt 0.1 --output state:stone.speed", "stone.vx[0]"),
        ("run stone.py --t-end 1 --dt 0.1 --method euler", "midpoint"),
        ("run stone.py --t-end 1 --dt 0.1 --method radau", "radau2"),
        ("run stone.py --t-end 1 --dt 0.1 --project 0", "Projection every"),
        ("run stone.py --t-end 1 --dt 0.1 --project 1 --method scipy-bdf", "choose its steps itself"),
    ):
        said = phblocks(line)
        assert said.code == 2 and told in said.err and said.out == "", line
        assert "Traceback" not in said.err


def test_a_place_that_cannot_be_written_to(phblocks, folder):
    (folder / "taken.npz").mkdir()
    said = phblocks("run stone.py --t-end 1 --dt 0.1 --out taken.npz --replace")
    assert said.code == 2 and "PH501" in said.err and "a place to write to" in said.err


def test_progress_is_on_stderr(phblocks):
    said = phblocks("run rod.py --t-end 0.05 --dt 0.01 --progress --json")
    assert said.data["ok"]  # nothing but the answer on stdout
    assert phblocks("run rod.py --t-end 0.05 --dt 0.01 --no-progress").err == ""


def test_the_health_of_a_run_is_in_the_answer(phblocks):
    line = "run stone.py --t-end 1 --dt 0.1"
    assert "energy balance, worst step" in phblocks(line).out
    health = phblocks(f"{line} --json").data["health"]
    assert health["status"] == "success"
    assert {f["name"]: f["verdict"] for f in health["findings"]}["energy balance, whole run"] == "ok"


def test_series_of_a_cantilever_in_space(phblocks):
    """Three components each; a push along y bends it about axis 3, and what it supplies is force times way."""
    series = ("position:b:1.0", "velocity:b:1.0", "force:b:0", "spin:b:1.0", "moment:b:0")
    line = f"run cantilever.py --t-end 0.02 --dt 0.001 --output {' '.join(series)} --input"
    said = phblocks(line, "tip=0,1,2")
    assert said.code == 0 and said.err == ""
    heading = said.out.splitlines()[-13]
    wanted = [f"{name} {part}" for name in series[:2] for part in "xyz"]
    wanted += [f"force:b:0 {part}" for part in ("axial", "shear 2", "shear 3")]
    wanted += [f"spin:b:1.0 {part}" for part in (1, 2, 3)]
    wanted += [f"moment:b:0 {part}" for part in ("torsion", "bending 2", "bending 3")]
    assert re.split("  +", heading) == ["t, s", *wanted]
    last = [float(cell) for cell in said.out.splitlines()[-1].split()]
    data = phblocks(line, "tip=0,1,2", "--json").data
    assert last[1:] == pytest.approx(np.concatenate([data["outputs"][name][-1] for name in series]), rel=1e-5)
    end = np.array(data["outputs"]["position:b:1.0"][-1])
    assert data["energy"]["supplied"]["end"] == pytest.approx(1.0 * end[1] + 2.0 * end[2], rel=1e-9)
    alone = phblocks(line, "tip=0,1,0", "--json").data["outputs"]
    moved = {name: [float(np.ptp(part)) > 1e-9 for part in zip(*alone[name], strict=True)] for name in series}
    assert moved["position:b:1.0"] == moved["velocity:b:1.0"] == moved["force:b:0"] == [False, True, False]
    assert moved["spin:b:1.0"] == moved["moment:b:0"] == [False, False, True]


def test_what_space_does_not_have_is_refused(phblocks):
    said = phblocks("run cantilever.py --t-end 0.002 --dt 0.001 --output angle:b:1.0")
    assert said.code == 2 and "PH405" in said.err and said.out == ""


def test_frequencies_are_found_on_request_only(phblocks, monkeypatch):
    """They are eigenvalues of full matrices: nobody waits for them unasked."""
    from phblocks.results import health

    asked = []
    card = health.stability_card
    monkeypatch.setattr(health, "stability_card", lambda *given: asked.append(given) or card(*given))
    line = "run rod.py --t-end 0.3 --dt 0.01"
    names = [f["name"] for f in phblocks(f"{line} --json").data["health"]["findings"]]
    assert "h omega_max" not in names and "unresolved share of energy" in names
    assert "h omega_max" not in phblocks(line).out and asked == []
    assert "h omega_max" in phblocks(f"{line} --frequencies").out and len(asked) == 1
    findings = phblocks(f"{line} --frequencies --json").data["health"]["findings"]
    found = {f["name"]: f["value"] for f in findings}
    step, state, system = asked[-1][1], asked[-1][2], asked[-1][0]
    assert step == pytest.approx(0.01) and set(names) <= set(found)
    assert found["h omega_max"] == card(system, step, state).findings["h omega_max"].value > 1.0


def test_a_run_that_is_resumed_takes_no_options_of_its_own(phblocks):
    """Neither values that would be left aside, nor those it has already; whatever else is typed is carried out."""
    pytest.importorskip("h5py")
    assert phblocks("run stone.py --t-end 1 --dt 0.25 --input push=4,0 --effects all --out fall.h5").code == 0
    line = "run stone.py --out fall.h5 --resume"
    for option in (
        "--t-end 3",
        "--dt 0.1",
        "--method midpoint",
        "--rtol 1e-3",
        "--atol 1e-3",
        "--save-every 0",
        "--max-halvings 12",
        "--project 1",
        "--replace",
    ):
        said = phblocks(f"{line} {option}")
        assert said.code == 2 and f"got {option.split()[0]}." in said.err, option
    both = phblocks(f"{line} --dt 0.1 --replace")
    assert both.code == 2 and "got --dt --replace." in both.err
    said = phblocks(f"{line} --input push=4,0 --effects all --output velocity:stone:centre --frequencies --json")
    assert said.code == 0 and said.data["outputs"]["velocity:stone:centre"][-1] == pytest.approx([2.0, -10.0])


def test_radau_iia_tells_what_it_takes(phblocks):
    """What it damps is a series of its own, with which the balance is exact; order 5 damps less than order 3."""
    lost = []
    for method in ("radau2", "radau3"):
        data = phblocks(f"run rod.py --t-end 0.1 --dt 0.01 --method {method} --json").data
        energy = {kind: values["end"] for kind, values in data["energy"].items()}
        assert data["ok"] and data["max_power_balance_error"] < 1e-10
        assert energy["kinetic"] == pytest.approx(0.433, rel=1e-2)  # as above
        assert energy["total"] + energy["numerical_loss"] == pytest.approx(0.0, abs=1e-10)  # it starts from rest
        lost.append(energy["numerical_loss"])
    assert lost[0] > 2.0 * lost[1] > 0.0


def test_loops_are_closed(phblocks):
    """A frame of three rigid bars drifts apart at its pins; closing it costs energy, which is told."""
    line = "run frame.py --t-end 1 --dt 0.02 --json"
    drifting, closed, seldom = (phblocks(f"{line} {more}").data for more in ("", "--project 1", "--project 10"))
    gaps = [
        next(f["value"] for f in data["health"]["findings"] if f["name"] == "closure of joints")
        for data in (drifting, seldom, closed)
    ]
    assert gaps[0] > gaps[1] > gaps[2] and gaps[0] > 1e-6 and gaps[2] < 1e-11
    assert [data["statistics"]["projections"] for data in (drifting, seldom)] == [0, 5]
    assert drifting["energy"]["projected"]["end"] == 0.0
    change = closed["statistics"]["projection_energy_change"]
    assert change != 0.0 and closed["energy"]["projected"]["end"] == pytest.approx(change, abs=1e-10)
