"""``phblocks study``: orders and choices, from a file as it is or with a mesh from the command line."""

import csv
from pathlib import Path

import pytest

SWING = "--t-end 0.2 --quantity position:rod:1.0 --json"


def test_the_order_in_the_step(phblocks):
    said = phblocks(f"study rod.py --over dt --values 0.02 0.01 0.005 {SWING} --table steps.csv --picture steps.png")
    data = said.data
    assert said.code == 0 and data["order"] == pytest.approx(2.0, abs=0.1)
    errors = [row["error"] for row in data["rows"]]
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)
    with open("steps.csv", newline="") as file:
        assert [float(row["dt"]) for row in csv.DictReader(file)] == [0.02, 0.01, 0.005]
    assert Path("steps.png").read_bytes()[:4] == b"\x89PNG"


def test_gauss_legendre_is_of_fourth_order(phblocks):
    data = phblocks(f"study rod.py --method gauss2 --values 0.01 0.005 0.0025 {SWING}").data
    assert data["order"] == pytest.approx(4.0, abs=0.4)


@pytest.mark.parametrize("file", ["rod.py", "rod.json"])
def test_over_elements_of_a_function_and_of_any_diagram(phblocks, file):
    """The function takes them; in a JSON file the beams get them. Both are the same systems."""
    phblocks("export rod.py --to rod.json")
    data = phblocks(f"study {file} --over elements --values 1 2 4 --dt 0.01 {SWING}").data
    states = [row["states"] for row in data["rows"]]
    assert states[1] - states[0] == (states[2] - states[1]) / 2 > 0
    errors = [row["error"] for row in data["rows"]]
    assert errors[0] > 4.0 * errors[1] > 16.0 * errors[2] > 0.0


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


def test_inputs_reach_the_runs(phblocks, folder):
    (folder / "pushed.py").write_text(
        (folder / "stone.py").read_text() + 'inputs = {"push": lambda t: (12.0 * t * t, 0.0)}\n'
    )
    line = "study pushed.py --values 0.2 0.1 0.05 --t-end 1 --quantity velocity:stone:0,0 --json"
    data = phblocks(line).data
    assert data["order"] == pytest.approx(2.0, abs=1e-6)  # the midpoint rule: dt^2 t / 24 times f'' / m
    assert data["rows"][0]["error"] == pytest.approx(0.2**2 / 2.0, rel=1e-6)


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
