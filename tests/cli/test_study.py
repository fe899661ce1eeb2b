"""``phblocks study``: orders and choices, from a file as it is or with a mesh from the command line."""

import csv
from pathlib import Path

import pytest

SWING = "--t-end 0.2 --quantity position:rod:1.0 --json"


@pytest.fixture
def pushed(folder):
    """Makes a file of a stone that is pushed by a function of time; its velocity is a quadrature."""

    def make(force):
        text = (folder / "stone.py").read_text() + f'inputs = {{"push": lambda t: ({force}, 0.0)}}\n'
        (folder / "pushed.py").write_text(text)

    return make


def test_the_midpoint_rule_is_of_second_order(phblocks, pushed):
    """Error dt^2 t / 24 times the second derivative of the force, over m = 2 kg: dt^2 / 2 at 1 s."""
    pushed("12.0 * t**2")
    line = "study pushed.py --values 0.2 0.1 0.05 --t-end 1 --quantity velocity:stone:0,0"
    said = phblocks(f"{line} --json --table steps.csv --picture steps.png")
    assert said.code == 0 and said.data["order"] == pytest.approx(2.0, abs=1e-6)
    assert said.data["rows"][0]["error"] == pytest.approx(0.2**2 / 2.0, rel=1e-6)
    with open("steps.csv", newline="") as file:
        assert [float(row["dt"]) for row in csv.DictReader(file)] == [0.2, 0.1, 0.05]
    assert Path("steps.png").read_bytes()[:4] == b"\x89PNG"
    text = phblocks(line)
    assert "Fitted order over 3 runs: 2.000" in text.out and text.err == ""


def test_gauss_legendre_is_of_fourth_order(phblocks, pushed):
    """Error dt^4 t / 4320 times the fourth derivative of the force, over m = 2 kg: 2 dt^4 at 1 s."""
    pushed("720.0 * t**4")
    line = "study pushed.py --method gauss2 --values 0.2 0.1 0.05 --t-end 1 --quantity velocity:stone:centre --json"
    data = phblocks(line).data
    assert data["order"] == pytest.approx(4.0, abs=1e-6)
    assert data["rows"][1]["error"] == pytest.approx(2.0 * 0.1**4, rel=1e-6)


@pytest.mark.parametrize("file", ["rod.py", "rod.json"])
def test_over_elements_of_a_function_and_of_any_diagram(phblocks, file):
    """The function takes them; in a JSON file the beams get them. Both are the same systems."""
    phblocks("export rod.py --to rod.json")
    data = phblocks(f"study {file} --over elements --values 2 4 8 --dt 0.01 {SWING}").data
    states = [row["states"] for row in data["rows"]]
    assert states[1] - states[0] == (states[2] - states[1]) / 2 > 0
    errors = [row["error"] for row in data["rows"]]
    assert errors[0] > 10.0 * errors[1] > 100.0 * errors[2] > 0.0


def test_over_the_degree_which_the_function_does_not_take(phblocks):
    data = phblocks(f"study rod.py --over degree --values 1 2 3 --dt 0.01 --elements 3 {SWING}").data
    states = [row["states"] for row in data["rows"]]
    assert states[0] < states[1] < states[2] and data["rate"] > 1.0


def test_work_and_precision(phblocks):
    line = (
        "study rod.py --kind work-precision --methods midpoint gauss2 --steps 0.02 0.01 --elements 2 4 --repeats 1 "
        "--tolerance 0.05"
    )
    said = phblocks(f"{line} {SWING}")
    assert said.code == 0 and len(said.data["rows"]) == 8
    assert {row["method"] for row in said.data["rows"]} == {"midpoint", "gauss2"}
    assert said.data["cheapest"]["error"] <= 0.05
    unreached = phblocks(f"{line[:-4]}1e-15 {SWING}")
    assert unreached.code == 1 and "PH602" in unreached.data["unreached"] and len(unreached.data["rows"]) == 8


def test_effects(phblocks):
    data = phblocks(f"study rod.py --kind effects --steps 0.01 0.005 --tolerance 0.01 --repeats 1 {SWING}").data
    assert data["rows"][0]["left_out"] == "nothing"
    assert all(row["within"] for row in data["rows"] if row["left_out"] == "shear")  # a slender rod


def test_shares(phblocks):
    said = phblocks("study rod.py --kind shares --t-end 0.2 --dt 0.01 --json --table shares.md")
    shares = {row["effect"]: row["share"] for row in said.data["rows"]}
    assert said.code == 0 and 0.0 < shares["shear"] < shares["flexible"] < 0.1
    assert Path("shares.md").read_text(encoding="utf-8").startswith("| block | effect |")


def test_what_is_missing_or_fails(phblocks):
    for line, told, code in (
        (f"study rod.py {SWING}", "--values", 2),
        ("study rod.py --values 0.02 0.01 0.005 --t-end 0.2", "--quantity", 2),
        ("study rod.py --values 0.02 0.01 0.005 --quantity position:rod:1.0", "--t-end", 2),
        (f"study rod.py --values 0.02 0.01 0.005 {SWING} --picture study.txt", ".png", 2),
        (f"study rod.py --over elements --values 1.5 2 4 --dt 0.01 {SWING}", "integers", 2),
        (f"study stone.py --over elements --values 1 2 4 --dt 0.1 --t-end 1 --quantity angle:rod:0 {SWING}", "rod", 2),
        (f"study rod.py --values 0.02 0.01 0.005 {SWING} --elements 2 4", "one number", 2),
        ("study rod.py --values 0.02 0.01 0.005 --t-end 0.2 --quantity energy:total", "a point of a block", 2),
        ("study bodies.py --values 0.02 0.01 0.005 --t-end 0.2 --quantity position:a:0,0", "PH304", 1),
        ("study stone.py --over degree --values 1 2 3 --dt 0.1 --t-end 1 --quantity position:stone:0,0", "degree", 1),
    ):
        said = phblocks(line)
        assert said.code == code and told in said.err, line


def test_a_study_closes_loops_in_all_of_its_runs(phblocks):
    """The order stays, as it must where the gap comes from time steps alone; the errors are others."""
    line = "study frame.py --values 0.04 0.02 0.01 --t-end 0.4 --quantity position:b:start --json"
    drifting, closed = (phblocks(f"{line} {more}").data for more in ("", "--project 1"))
    errors = [[row["error"] for row in data["rows"]] for data in (drifting, closed)]
    assert errors[0] != errors[1] and closed["order"] == pytest.approx(2.0, abs=0.2)
