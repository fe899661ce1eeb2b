"""A run that is left and resumed is the run that was never left, to the last bit."""

import dataclasses

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, MethodError, ResultFileError
from phblocks.files.stored import folder_of

RUN = {"t_end": 0.25, "dt": 0.002, "inputs": {"tip": lambda t: (0.5 * np.sin(3.0 * t), 0.2 * t)}}
CASES = {
    "default": ("arm", {}),
    "newton": ("arm", {"method": ph.Midpoint(ph.Newton())}),
    "gauss 2": ("arm", {"method": ph.GaussLegendre(2)}),
    "gauss 3": ("arm", {"method": ph.GaussLegendre(3)}),
    "radau iia 2": ("arm", {"method": ph.RadauIIA(2)}),
    "radau iia 3": ("arm", {"method": ph.RadauIIA(3)}),
    "linearly implicit": ("arm", {"method": ph.LinearlyImplicit()}),
    "corrected": ("arm", {"method": ph.LinearlyImplicit(corrections=1)}),
    "discrete gradient": ("arm", {"method": ph.DiscreteGradient()}),
    "projected": ("truss", {"projection": ph.Projection(every=3)}),
    "projected, damped": ("truss", {"method": ph.RadauIIA(2), "projection": ph.Projection()}),
    "projected, adaptive": ("truss", {"adaptive": ph.Adaptive(1e-3, atol=1e-2), "projection": ph.Projection(every=2)}),
    "adaptive": ("arm", {"adaptive": ph.Adaptive(1e-3, atol=1e-2)}),
    "adaptive gauss": ("beam", {"method": ph.GaussLegendre(2), "adaptive": ph.Adaptive(1e-3, atol=1e-2)}),
    "adaptive outputs": ("beam", {"adaptive": ph.Adaptive(1e-3, atol=1e-2, outputs=("tip.x velocity",))}),
    "few saved": ("arm", {"save_every": 7}),
    "one saved": ("arm", {"save_every": 1000}),
    "times": ("arm", {"times": [0.013, 0.1001, 0.2]}),
    "radau": ("beam", {"method": ph.ScipyIVP("Radau", rtol=1e-4, atol=1e-4)}),
    "bdf": ("beam", {"method": ph.ScipyIVP("BDF", rtol=1e-3, atol=1e-3)}),
}


@pytest.mark.parametrize(("case", "at"), [("default", 0.003), *((case, 0.16) for case in CASES)])
def test_to_the_bit_for_every_method(systems, tmp_path, same, cut, case, at):
    name, options = CASES[case]
    system, options = systems[name], RUN | options
    whole = ph.simulate(system, save=ph.Stream(tmp_path / "whole.h5", chunk=20), **options)
    assert whole.status.ok
    cut(system, ph.Stream(tmp_path / "cut.h5", chunk=20), at, **options)
    assert not (tmp_path / "cut.h5").exists() and folder_of(tmp_path / "cut.h5").is_dir()
    resumed = ph.resume(tmp_path / "cut.h5", system, inputs=options["inputs"])
    assert resumed.status.ok and sorted(p.name for p in tmp_path.iterdir()) == ["cut.h5", "whole.h5"]
    same(whole, resumed)
    for name in ("start_energy_change", "projections", "largest_gap", "projection_energy_change"):
        assert getattr(whole.statistics, name) == getattr(resumed.statistics, name)
    assert ("projected" in case) == (resumed.statistics.projections > 0)


def test_to_the_bit_for_an_energy_that_is_not_quadratic(systems, tmp_path, same, monkeypatch):
    """Killed by the method itself, because there is no input."""
    from phblocks.solvers.midpoint import MidpointStepper

    system, options = systems["duffing"], {"t_end": 5.0, "dt": 0.02}
    whole = ph.simulate(system, save=ph.Stream(tmp_path / "whole.h5", chunk=20), **options)
    calls, step = [], MidpointStepper.step

    def stopping(self, *arguments):
        calls.append(1)
        if len(calls) == 130:
            raise KeyboardInterrupt
        return step(self, *arguments)

    with monkeypatch.context() as patched:
        patched.setattr(MidpointStepper, "step", stopping)
        with pytest.raises(KeyboardInterrupt):
            ph.simulate(system, save=ph.Stream(tmp_path / "cut.h5", chunk=20), **options)
    assert ph.read(tmp_path / "cut.h5").t.size >= 120
    same(whole, ph.resume(tmp_path / "cut.h5", system))


class Refusing:
    """The midpoint rule, which refuses long steps."""

    order = 2

    def prepare(self, system):
        stepper = ph.Midpoint().prepare(system)

        class Steps:
            stage, nodes, weights = stepper.stage, stepper.nodes, stepper.weights

            def step(self, x, theta, dt, u):
                return stepper.step(x, theta, dt, u) if dt < 2e-4 else None

        return Steps()


def test_halved_steps(systems, tmp_path, same, cut):
    """No checkpoint within a step that was halved: chunks of 10 steps, intervals of 16."""
    limits = ph.Limits(halvings=1.0)
    options = RUN | {"t_end": 0.03, "method": Refusing(), "limits": limits}
    whole = ph.simulate(systems["arm"], save=ph.Stream(tmp_path / "whole.h5", chunk=10), **options)
    assert whole.statistics.steps == 15 * 16
    cut(systems["arm"], ph.Stream(tmp_path / "cut.h5", chunk=10), 0.0157, **options)
    resumed = ph.resume(tmp_path / "cut.h5", systems["arm"], inputs=RUN["inputs"], method=Refusing(), limits=limits)
    same(whole, resumed)


def test_checkpoints_change_round_off_only(systems, tmp_path):
    """The method starts anew at each of them; a run without them is the same to the tolerance of the iteration."""
    plain = ph.simulate(systems["arm"], **RUN)
    saved = ph.simulate(systems["arm"], save=ph.Stream(tmp_path / "run.h5", chunk=20), **RUN)
    np.testing.assert_allclose(saved.x, plain.x, rtol=0.0, atol=1e-9 * np.abs(plain.x).max())
    np.testing.assert_array_equal(saved.t, plain.t)
    assert saved.max_power_balance_error < 1e-12
    for name, energy in plain.energy.items():
        np.testing.assert_allclose(saved.energy[name], energy, atol=1e-10)
    one = ph.simulate(systems["arm"], save=ph.Stream(tmp_path / "one.h5", chunk=1000), **RUN)
    np.testing.assert_array_equal(one.x, plain.x)  # no checkpoint but the first
    for name, energy in plain.energy.items():
        np.testing.assert_array_equal(one.energy[name], energy)


def test_again_and_again(systems, tmp_path, same, cut):
    system, path = systems["arm"], tmp_path / "cut.h5"
    whole = ph.simulate(system, save=ph.Stream(tmp_path / "whole.h5", chunk=20), **RUN)
    cut(system, ph.Stream(path, chunk=20), 0.1, **RUN)

    class Stopped(BaseException):
        pass

    for at in (0.1, 0.12, 0.121, 0.2):

        def tip(t, at=at):
            if t > at:
                raise Stopped
            return RUN["inputs"]["tip"](t)

        with pytest.raises(Stopped):
            ph.resume(path, system, inputs={"tip": tip})
        assert at - 0.05 <= ph.read(path).t[-1] <= at
    same(whole, ph.resume(path, system, inputs=RUN["inputs"]))


def test_after_a_run_that_ended_early(systems, tmp_path, same):
    """It was gathered in one file, with results past its last checkpoint; these are computed once more."""
    system, path = systems["arm"], tmp_path / "run.h5"
    whole = ph.simulate(system, save=ph.Stream(tmp_path / "whole.h5", chunk=20), **RUN)

    def lost(t):
        if t > 0.16:
            raise RuntimeError("sensor lost")
        return RUN["inputs"]["tip"](t)

    for start in (
        lambda **o: ph.simulate(system, save=ph.Stream(path, chunk=20), **RUN | o),
        lambda **o: ph.resume(path, system, **o),
    ):
        early = start(inputs={"tip": lost})
        assert early.status.name == "input failed" and early.t[-1] == pytest.approx(0.16)
        assert sorted(p.name for p in tmp_path.iterdir()) == ["run.h5", "whole.h5"]
        read = ph.read(path, system)
        same(early, read)
        assert read.status == early.status and isinstance(early.status.error, RuntimeError)
    same(whole, ph.resume(path, system, inputs=RUN["inputs"]))


def test_a_finished_run_is_returned(systems, tmp_path, same):
    whole = ph.simulate(systems["arm"], save=tmp_path / "run.h5", **RUN)
    before = (tmp_path / "run.h5").read_bytes()
    again = ph.resume(tmp_path / "run.h5", systems["arm"])
    same(whole, again)
    assert again.status.ok and (tmp_path / "run.h5").read_bytes() == before


def test_chunks_that_were_not_gathered(systems, tmp_path, same, monkeypatch):
    """Killed after the last step, while its chunks are put together: also between the new file and the old folder."""
    from phblocks.files import journal

    path = tmp_path / "run.h5"
    whole = ph.simulate(systems["arm"], save=ph.Stream(tmp_path / "whole.h5", chunk=20), **RUN)

    def stopped(*arguments, **options):
        raise KeyboardInterrupt

    for name in ("write_large", "shutil.rmtree"):
        with monkeypatch.context() as patched:
            patched.setattr(f"phblocks.files.journal.{name}", stopped)
            with pytest.raises(KeyboardInterrupt):
                ph.simulate(systems["arm"], save=ph.Stream(path, chunk=20, replace=True), **RUN)
        assert path.exists() == (name == "shutil.rmtree") and folder_of(path).is_dir()
        read = ph.read(path, systems["arm"])
        assert read.status.ok
        same(whole, read)
        same(whole, ph.resume(path, systems["arm"], inputs=RUN["inputs"]))
        assert path.exists()
    assert journal.shutil


# What is refused


def test_another_system(systems, tmp_path, cut):
    path = tmp_path / "run.h5"
    cut(systems["arm"], ph.Stream(path, chunk=20), 0.15, **RUN)
    with pytest.raises(ResultFileError, match=r"the system 'arm' of the run, got 'beam' with other states"):
        ph.resume(path, systems["beam"], inputs=RUN["inputs"])
    heavier = dataclasses.replace(systems["arm"], E=systems["arm"].E * (1.0 + 1e-15))
    for act in (lambda: ph.resume(path, heavier, inputs=RUN["inputs"]), lambda: ph.read(path, heavier)):
        with pytest.raises(ResultFileError, match="the same states and other numbers"):
            act()
    with pytest.raises(ArgumentTypeError, match="resume: expected a System"):
        ph.resume(path, None)
    with pytest.raises(ArgumentTypeError, match="resume path"):
        ph.resume(3, systems["arm"])


def test_the_same_diagram_drawn_again_is_the_same_system(tmp_path, cut, same):
    from tests.files.conftest import arm

    cut(arm(), ph.Stream(tmp_path / "run.h5", chunk=20), 0.15, **RUN)
    assert ph.resume(tmp_path / "run.h5", arm(), inputs=RUN["inputs"]).status.ok


def test_other_inputs(systems, tmp_path, cut):
    path = tmp_path / "run.h5"
    cut(systems["arm"], ph.Stream(path, chunk=20), 0.15, **RUN)
    for other, got in (
        ({}, r"\[\[0\.0, 0\.0\]\]"),
        ({"tip": lambda t: (0.5 * np.sin(3.0 * t), 0.2 * t + 1e-12)}, r"\[\["),
        ({"tip": lambda t: (np.nan if t else 0.0, 0.0)}, "an exception, or values that are not finite"),
    ):
        with pytest.raises(DataError, match=rf"resume inputs at t = 0\.1.* as in the run, got {got}"):
            ph.resume(path, systems["arm"], inputs=other)
    assert ph.resume(path, systems["arm"], inputs=RUN["inputs"]).status.ok


class Own:
    """A method of the user's: the midpoint rule, under another name."""

    order = 2

    def prepare(self, system):
        return ph.Midpoint().prepare(system)


def test_methods_of_the_users(systems, tmp_path, cut, same):
    whole = ph.simulate(systems["arm"], save=ph.Stream(tmp_path / "whole.h5", chunk=20), method=Own(), **RUN)
    cut(systems["arm"], ph.Stream(tmp_path / "cut.h5", chunk=20), 0.15, method=Own(), **RUN)
    with pytest.raises(ResultFileError, match=r"expected the method Own .*, got none"):
        ph.resume(tmp_path / "cut.h5", systems["arm"], inputs=RUN["inputs"])
    with pytest.raises(ResultFileError, match=r"expected the method of the run, .*Own.*, got Midpoint"):
        ph.resume(tmp_path / "cut.h5", systems["arm"], inputs=RUN["inputs"], method=ph.Midpoint())
    same(whole, ph.resume(tmp_path / "cut.h5", systems["arm"], inputs=RUN["inputs"], method=Own()))


class Walkless:
    """An integrator whose walk cannot be left."""

    def integrate(self, system, drive, start, schedule):
        class Walk:
            stage, weights, nodes, steps, halvings, rejections = None, (1.0,), (0.5,), 0, 0, 0

            def __iter__(self):
                return iter(())

        return Walk()


def test_methods_that_cannot_be_left(systems, tmp_path):
    with pytest.raises(MethodError, match="expected a method whose walk can be left and resumed, got Walk"):
        ph.simulate(systems["arm"], 0.1, 0.01, method=Walkless(), save=tmp_path / "run.h5")
    assert list(tmp_path.iterdir()) == []


def test_two_processes_do_not_write_one_run(systems, tmp_path, cut):
    """The lock falls with its process, however that ends."""
    pytest.importorskip("fcntl")
    from phblocks.files.journal import Journal

    path = tmp_path / "run.h5"
    cut(systems["arm"], ph.Stream(path, chunk=20), 0.15, **RUN)
    other = Journal(path, 20)
    with pytest.raises(ResultFileError, match="another simulation is writing"):
        ph.resume(path, systems["arm"], inputs=RUN["inputs"])
    other.close()
    assert ph.resume(path, systems["arm"], inputs=RUN["inputs"]).status.ok
