"""Tables keep, order, print and read back their rows."""

import math

import pytest

from phblocks import errors
from phblocks.studies import WorkPrecisionStudy
from tests.studies.rows import make_run


@pytest.fixture
def study():
    return WorkPrecisionStudy(
        (
            make_run("slow, |good|", 2.0, 1e-5, dt=0.1 + 0.2),
            make_run("fails", 0.1, status_text='said "no",\nand stopped'),
            make_run("fast", 0.5, 1e-2, shared_machine=True),
        )
    )


def test_is_a_sequence_of_records(study):
    assert len(study) == 3
    assert [row.method for row in study] == study.column("method") == ["slow, |good|", "fails", "fast"]
    assert study[2].seconds == 0.5
    assert {"method", "error", "seconds", "gap", "cpu", "numpy"} <= set(study.columns)


def test_filter(study):
    assert study.filter(method="fast").rows == (study[2],)
    assert study.filter(lambda row: row.ok, shared_machine=False).rows == (study[0],)
    assert len(study.filter(method="none")) == 0


def test_sort_puts_what_is_no_number_last(study):
    assert study.sort("error").column("method") == ["slow, |good|", "fast", "fails"]
    assert study.sort("error", reverse=True).column("method") == ["fast", "slow, |good|", "fails"]
    assert study.sort("shared_machine", "seconds").column("method") == ["fails", "slow, |good|", "fast"]


def test_unknown_column(study):
    for ask in (study.column, study.sort, lambda name: study.filter(**{name: 1})):
        with pytest.raises(errors.UnknownNameError, match="seconds_max"):
            ask("speed")


def test_csv_gives_back_every_digit(study, tmp_path):
    path = study.to_csv(tmp_path / "study.csv")
    again = WorkPrecisionStudy.from_csv(path)
    assert again[0] == study[0] and again[2] == study[2]
    assert again[0].dt == 0.1 + 0.2
    assert math.isnan(again[1].error) and again[1].status_text == 'said "no",\nand stopped'
    again.to_csv(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == path.read_bytes()


def test_files_that_are_something_else(study, tmp_path):
    path = study.to_csv(tmp_path / "study.csv")
    text = path.read_text()
    for wrong in ("", "a,b\n1,2\n", text.replace("seconds_max", "seconds_most"), text.replace("True", "1")):
        path.write_text(wrong)
        with pytest.raises(errors.ExportError, match="WorkPrecisionStudy"):
            WorkPrecisionStudy.from_csv(path)
    with pytest.raises(errors.ExportError):
        WorkPrecisionStudy.from_csv(tmp_path / "none.csv")
    with pytest.raises(errors.ExportError):
        study.to_csv(tmp_path / "no folder" / "study.csv")
    with pytest.raises(errors.ArgumentTypeError):
        study.to_csv(3)


def test_printed(study):
    header, *lines = str(study).splitlines()
    assert "dt (s)" in header and "energy error (relative)" in header and "gap (m)" in header
    assert "1e-05" in lines[0] and "success" in lines[0]
    assert " - " in lines[1] and "step failed" in lines[1]
    assert "shared a machine" in str(study)
    assert 'fails, elements=4, dt = 0 s: step failed in 0.1 s: said "no"' in str(study)


def test_markdown(study):
    lines = study.to_markdown().splitlines()
    assert lines[0].startswith("| method | mesh | dt (s) | ")
    assert set(lines[1]) == set("| -")
    assert lines[2].startswith("| slow, \\|good\\| | elements=4 | 0.3 | ")
    assert {line.count("|") - line.count("\\|") for line in lines[:5]} == {12}
    assert "shared a machine" in study.to_markdown()
    assert "shared a machine" not in study.filter(shared_machine=False).to_markdown()


def test_empty(study):
    assert str(study.filter(method="none")).startswith("method")
