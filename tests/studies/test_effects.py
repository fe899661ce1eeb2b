"""The audit of effects: what it tries, what it finds, and that its table says what was run."""

import math

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, StudyError, UnknownNameError, UnreachedError
from phblocks.studies.effects import merged

SOFT, STIFF = 5e6, 2.1e11
TIP = ("position", "beam", 1.0)


def pendulum(young: float, approximation=None, damping=None) -> ph.System:
    section = ph.Section.circle(0.01, young, 0.3, 1000.0)
    d = ph.Diagram("pendulum", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("beam", section, (0.0, 0.0), (1.0, 0.0), elements=3, degree=2, damping=damping))
    d.pin(beam.start, d.ground)
    return d.compile(approximation=approximation)


def soft(approximation) -> ph.System:
    return pendulum(SOFT, approximation)


def stiff(approximation) -> ph.System:
    return pendulum(STIFF, approximation)


@pytest.fixture(scope="module")
def of_stiff():
    return ph.studies.effects(stiff, TIP, 1e-3, t_end=0.4, steps=(0.02, 0.01, 0.005), repeats=2, progress=False)


@pytest.fixture(scope="module")
def of_soft():
    return ph.studies.effects(soft, TIP, 1e-3, t_end=0.4, steps=(0.02, 0.005, 0.0025), repeats=1, progress=False)


def row_of(study, left_out: str):
    (row,) = study.filter(left_out=left_out)
    return row


def test_a_stiff_pendulum_may_be_rigid_and_a_soft_one_not(of_stiff, of_soft):
    assert row_of(of_stiff, "flexible 'beam'").within and not row_of(of_soft, "flexible 'beam'").within
    assert any("flexible 'beam'" in row.left_out for row in of_stiff if "," in row.left_out)
    assert not any("flexible" in row.left_out for row in of_soft if "," in row.left_out)
    for study in (of_stiff, of_soft):
        assert study.cheapest.seconds == min(row.seconds for row in study if row.within)


def test_the_rigid_row_is_a_rigid_pendulum(of_stiff):
    """Energies of a rigid bar: the period and so the tip differ only by what the bar bends."""
    row = row_of(of_stiff, "flexible 'beam'")
    rigid = pendulum(STIFF, of_stiff.choice_of(row))
    assert (row.unknowns, row.states) == (rigid.n, int(rigid.carries_energy.sum()))
    assert row.states_saved == pendulum(STIFF).n - row.states > 0
    full, left = (ph.simulate(s, 0.4, 0.005).position("beam", 1.0)[-1] for s in (pendulum(STIFF), rigid))
    assert row.change == pytest.approx(float(np.linalg.norm(full - left)), rel=1e-12)


def test_states_without_energy_are_counted_apart(of_stiff):
    row, full = row_of(of_stiff, "extension"), row_of(of_stiff, "nothing")
    assert row.unknowns == full.unknowns and row.states_saved == 7  # V1 of degree 2, N1 discontinuous: or the reverse
    assert full.error == full.numerical_error and full.change == 0.0 and full.time_saved == 1.0


def test_errors_hold_what_the_steps_add(of_stiff, of_soft):
    for study in (of_stiff, of_soft):
        numerical = row_of(study, "nothing").numerical_error
        for row in study:
            assert row.within is (row.error <= 1e-3)
            assert row.error >= row.change - row.numerical_error - numerical - 1e-15
            assert row.time_saved == pytest.approx(row_of(study, "nothing").seconds / row.seconds)


def test_each_row_has_the_largest_step_that_is_accurate_enough(of_soft):
    full, steps = soft({}), (0.02, 0.005, 0.0025)
    ends = [ph.simulate(full, 0.4, dt).position("beam", 1.0)[-1] for dt in steps]
    errors = [float(np.linalg.norm(e - ends[-1]) + np.linalg.norm(ends[-1] - ends[-2]) / 3.0) for e in ends]
    expected = next((dt for dt, error in zip(steps, errors, strict=True) if error <= 2e-4), steps[-1])
    row = row_of(of_soft, "nothing")
    assert row.dt == expected and row.numerical_error == pytest.approx(errors[steps.index(expected)], rel=1e-9)


def test_what_turns_and_falls_is_not_tried(of_stiff):
    tried = {row.left_out for row in of_stiff}
    assert {"nothing", "shear", "extension", "rotary_inertia", "flexible 'beam'"} < tried
    assert not any("gravity" in name or "large_rotation" in name for name in tried)
    assert of_stiff.shares.of("large_rotation")["beam"] > 0.1


def test_combinations_take_back_what_changes_most(of_soft):
    alone = [row.left_out for row in of_soft.sort("error") if row.within and "," not in row.left_out]
    together = [row for row in of_soft if "," in row.left_out]
    assert together and set(together[0].left_out.split(", ")) == set(alone) - {"nothing"}
    assert together[-1].within or len(together[-1].left_out.split(", ")) == 2


def test_candidates_of_ones_own_and_failures_are_rows():
    own = {"light": {"beam": ph.Approximation(rotary_inertia=False)}, "unknown": {"rod": ph.Approximation(shear=False)}}
    study = ph.studies.effects(soft, TIP, 1.0, t_end=0.1, steps=(0.02, 0.01), candidates=own, repeats=1)
    light, unknown = row_of(study, "light"), row_of(study, "unknown")
    assert light.within and light.states_saved > 0
    assert not unknown.within and unknown.status == "UnknownNameError" and math.isnan(unknown.error)
    assert "Failed: unknown" in str(study)


def test_nothing_within_the_tolerance():
    study = ph.studies.effects(soft, TIP, 1e-9, t_end=0.1, steps=(0.02, 0.01), candidates={}, repeats=1)
    with pytest.raises(UnreachedError, match="smaller steps"):
        _ = study.cheapest
    assert "not resolved" in str(study)


def test_tables_come_back_from_files(of_stiff, tmp_path):
    again = ph.studies.EffectsStudy.from_csv(of_stiff.to_csv(tmp_path / "effects.csv"))
    assert again.rows == of_stiff.rows


def test_choices_are_merged_by_block():
    first = {"a": ph.Approximation(shear=False), "b": ph.Approximation(large_rotation=False, insist=True)}
    second = {"a": ph.Approximation(large_rotation="second-order"), "c": ph.Approximation(flexible=False)}
    together = merged([first, second])
    assert together["a"] == ph.Approximation(shear=False, large_rotation="second-order")
    assert together["b"] == first["b"] and together["c"] == second["c"]


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"tolerance": 0.0}, DataError),
        ({"t_end": -1.0}, DataError),
        ({"steps": (0.01,)}, DataError),
        ({"repeats": 0}, DataError),
        ({"make_system": 3}, ArgumentTypeError),
        ({"candidates": ["shear"]}, ArgumentTypeError),
        ({"wrong": 1}, UnknownNameError),
    ],
)
def test_wrong_arguments(change, error):
    given = {"make_system": soft, "quantity": TIP, "tolerance": 1e-3, "t_end": 0.1, "steps": (0.02, 0.01)}
    with pytest.raises(error):
        ph.studies.effects(**(given | change))


def test_a_full_system_that_fails_ends_the_study():
    def far(t: float) -> tuple[float, float]:
        return (math.nan if t > 0.05 else 0.0, 0.0)

    def driven(approximation) -> ph.System:
        d = ph.Diagram("driven")
        beam = d.add(ph.Beam("beam", ph.Section.circle(0.01, SOFT, 0.3, 1000.0), (0.0, 0.0), (1.0, 0.0), 2))
        d.expose(beam.end.translation, "push")
        return d.compile(approximation=approximation)

    with pytest.raises(StudyError, match="full system"):
        ph.studies.effects(driven, TIP, 1e-3, t_end=0.1, steps=(0.02, 0.01), inputs={"push": far})


def test_a_function_that_ignores_what_to_leave_out_is_refused():
    with pytest.raises(DataError, match="nothing left out"):
        ph.studies.effects(lambda approximation: stiff(None), TIP, 1e-3, t_end=0.2, steps=(0.02, 0.01), repeats=1)


def test_a_value_at_every_step_needs_times():
    with pytest.raises(DataError, match="times="):
        ph.studies.effects(stiff, lambda s: s.energy.kinetic, 1e-3, t_end=0.2, steps=(0.02, 0.01), repeats=1)
