"""Steps many at a time end where single ones would: at inputs that fail, steps that fail, numbers too large."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.solvers.equal_steps import EqualSteps


@pytest.fixture(params=["compiled", "interpreted"])
def path(request, monkeypatch) -> None:
    """Both codes."""
    if request.param == "compiled":
        pytest.importorskip("numba")
    else:
        monkeypatch.setattr("phblocks.solvers.compiled.find_spec", lambda _: None)


@pytest.fixture
def runs(path, monkeypatch):
    """Simulate with as many steps at a time as possible, and one by one."""

    def both(*arguments, **options) -> list[ph.Solution]:
        solutions = [ph.simulate(*arguments, **options)]
        begin = EqualSteps.__init__
        with monkeypatch.context() as patch:
            patch.setattr(EqualSteps, "__init__", lambda self, *a: begin(self, *a[:5], 1))
            solutions.append(ph.simulate(*arguments, **options))
        return solutions

    return both


def pushed(approximation: ph.Approximation | None = None) -> ph.System:
    """A cantilever, pushed at its end from outside."""
    section = ph.Section(axial=3e4, shear=1e4, bending=50.0, mass=1.2, rotary=3e-3)
    d = ph.Diagram("pushed")
    arm = d.add(ph.Beam("arm", section, (0.0, 0.0), (1.0, 0.0), elements=2, approximation=approximation))
    d.weld(d.ground, arm.start)
    d.expose(arm.end.translation, "push")
    return d.compile()


SYSTEMS = {"linear": ph.Approximation(large_rotation=False), "nonlinear": None}


@pytest.fixture(params=SYSTEMS.values(), ids=SYSTEMS)
def system(request) -> ph.System:
    return pushed(request.param)


def same(many: ph.Solution, single: ph.Solution) -> None:
    assert many.status.text == single.status.text
    assert many.statistics.steps == single.statistics.steps
    assert many.statistics.halvings == single.statistics.halvings
    np.testing.assert_array_equal(many.t, single.t)
    np.testing.assert_array_equal(many.statistics.newton_iterations, single.statistics.newton_iterations)
    np.testing.assert_array_equal(many.x, single.x)


def test_the_same_run(runs, system):
    many, single = runs(system, 0.305, 0.01, inputs={"push": lambda t: (0.0, 2.0 * np.sin(9.0 * t))}, save_every=7)
    same(many, single)
    assert many.status.ok and many.statistics.steps == 31
    np.testing.assert_allclose(many.energy.total, single.energy.total, rtol=1e-12)


class Memory:
    """A signal that is asked in the order of time, once each, and has no answer after so many."""

    def __init__(self, answers: int) -> None:
        self.left, self.asked = answers, []

    def __call__(self, t: float) -> tuple[float, float]:
        self.asked.append(t)
        self.left -= 1
        if self.left < 0:
            raise LookupError("no more")
        return 0.0, 1.0


def test_a_signal_with_a_memory_is_asked_once(system):
    """Before a run: is it a function at all, does the beam spin, which must not. Then step by step."""
    signal = Memory(10_000)
    ph.simulate(system, 0.01, 0.01, inputs={"push": signal})
    before = len(signal.asked) - 1
    signal = Memory(before + 25)
    run = ph.simulate(system, 0.4, 0.01, inputs={"push": signal})
    assert run.status.name == "input failed" and run.statistics.steps == 25 and run.t[-1] == pytest.approx(0.25)
    np.testing.assert_allclose(signal.asked[before:], 0.005 + 0.01 * np.arange(26))


@pytest.mark.parametrize("wrong", [np.nan, "no number"])
def test_an_input_that_fails_ends_the_run_there(runs, system, wrong):
    """The steps before are kept: the one from 0.12 s to 0.13 s is the first that looks after 0.123 s."""
    many, single = runs(system, 0.3, 0.01, inputs={"push": lambda t: (0.0, 1.0 if t < 0.123 else wrong)})
    same(many, single)
    assert not many.status.ok and many.t[-1] == pytest.approx(0.12) and many.statistics.steps == 12


def test_numbers_too_large_end_the_run_alike(runs, system):
    """A push that nothing withstands from 0.05 s on: the five steps before are kept."""
    many, single = runs(system, 0.3, 0.01, inputs={"push": lambda t: (0.0, 1.0 if t < 0.05 else 1e170)}, max_halvings=0)
    same(many, single)
    assert not many.status.ok and many.statistics.newton_iterations.size == 5 and many.t[-1] == pytest.approx(0.05)


def test_steps_that_fail_are_halved_alike(runs, four_bar):
    method = ph.Midpoint(ph.ModifiedNewton(max_iterations=6))
    many, single = runs(four_bar().compile(), 1.2, 0.08, method=method, limits=ph.Limits.none())
    same(many, single)
    assert many.statistics.halvings > 0


def test_a_stretch_asks_each_input_once(system):
    asked: list[float] = []
    ph.simulate(system, 0.2, 0.01, inputs={"push": lambda t: asked.append(t) or (0.0, 1.0)})
    assert asked[0] == 0.0  # whether it is a function at all
    np.testing.assert_allclose(asked[-20:], 0.005 + 0.01 * np.arange(20))


def test_chunks_end_where_they_should(system, tmp_path, monkeypatch):
    pytest.importorskip("h5py")
    from phblocks.files.journal import Journal

    steps, write = [], Journal.write
    watched = lambda self, rows, *a, **k: steps.append(rows["newton_iterations"].size) or write(self, rows, *a, **k)  # noqa: E731
    monkeypatch.setattr(Journal, "write", watched)
    whole = ph.simulate(system, 1.0, 0.01, inputs={"push": (0.0, 1.0)})
    stream = ph.Stream(tmp_path / "run.h5", chunk=30)
    stored = ph.simulate(system, 1.0, 0.01, inputs={"push": (0.0, 1.0)}, save=stream)
    np.testing.assert_allclose(stored.x, whole.x, atol=1e-9 * np.abs(whole.x).max())
    assert stored.statistics.steps == 100 and [size for size in steps if size] == [30, 30, 30, 10]


@pytest.mark.parametrize(("every", "chunk"), [(7, 10), (7, 110), (50, 30), (1000, 20)])
def test_a_run_on_disk_that_fails_keeps_the_last_state(system, tmp_path, every, chunk):
    """Also where the chunk ends just there."""
    pytest.importorskip("h5py")
    options = {"inputs": {"push": lambda t: (0.0, 1.0 if t < 1.1 else np.nan)}, "save_every": every}
    whole = ph.simulate(system, 2.0, 0.01, **options)
    stored = ph.simulate(system, 2.0, 0.01, save=ph.Stream(tmp_path / "run.h5", chunk=chunk), **options)
    assert whole.statistics.steps == stored.statistics.steps == 110
    np.testing.assert_allclose(stored.t, whole.t, rtol=1e-14)
    assert stored.t[-1] == pytest.approx(1.1)
    np.testing.assert_allclose(stored.x, whole.x, atol=1e-9 * np.abs(whole.x).max())
    np.testing.assert_allclose(stored.energy.total, whole.energy.total, atol=1e-12)
