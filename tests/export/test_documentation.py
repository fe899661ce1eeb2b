"""What docs/export.md says is so, and its code runs."""

import re
import shutil
import subprocess
import warnings
from pathlib import Path

import numpy as np
import pytest

import phblocks as ph
from phblocks.export import write
from phblocks.export.record import ALL_LABELS, ALL_MATRICES, ALL_VECTORS, TEXTS

DOCS = Path(__file__).resolve().parents[2] / "docs" / "export.md"
S = 2j * np.pi * 100.0  # the frequency of the examples
OCTAVE = shutil.which("octave-cli")


def blocks(language: str) -> list[str]:
    """Code blocks of the documentation, each at its own line numbers."""
    text = DOCS.read_text(encoding="utf-8")
    pattern = rf"^```{language}\n(.*?)^```$"
    found = re.finditer(pattern, text, flags=re.MULTILINE | re.DOTALL)
    return ["\n" * text.count("\n", 0, block.start(1)) + block[1] for block in found]


def needs(block: str) -> list[str]:
    """The packages of extras that a block imports."""
    return [name for name in ("control", "pymor", "fmpy") if re.search(rf"^(import|from) {name}\b", block, re.M)]


def test_python_of_the_documentation(tmp_path, monkeypatch, beam, response):
    """All but the recipes for packages of extras."""
    for suffix in (".mat", ".npz", ".mtx"):
        write(beam, tmp_path / f"beam{suffix}")
    monkeypatch.chdir(tmp_path)
    session = {"__name__": "docs"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for block in blocks("python"):
            if not needs(block):
                exec(compile(block, str(DOCS), "exec"), session)
    expected = response(beam.E, beam.J, beam.R, beam.Q, beam.G, S)
    for key in ("H_mat", "H_npz", "H_mtx"):
        np.testing.assert_allclose(session[key], expected, rtol=1e-12)


@pytest.mark.filterwarnings("default")  # those of the packages are their own
def test_recipes_for_other_packages(tmp_path, monkeypatch, capsys):
    """After the pendulum of the page: a brake that damps, a reduction that keeps what is slow, an FMU that runs."""
    recipes = [block for block in blocks("python") if needs(block)]
    assert [needs(block) for block in recipes] == [["control"], ["pymor"], ["fmpy"]]
    for block in recipes:
        for name in needs(block):
            pytest.importorskip(name)
    monkeypatch.chdir(tmp_path)
    session = {"np": np}
    [pendulum] = [block for block in blocks("python") if "to_scipy()" in block]
    for block in (pendulum, *recipes):
        exec(compile(block, str(DOCS), "exec"), session)
    assert session["full"].order == int(re.search(r"from (\d+) states to 6", DOCS.read_text(encoding="utf-8"))[1])
    assert session["small"].order == 6 and session["error"] < 0.02
    assert session["result"]["energy.error"].max() < 1e-12 and session["result"]["tip.y_velocity"][-1] != 0.0


def test_the_chain_of_the_documentation_is_the_published_one(references):
    """The code of the page, run on its own, against the numbers of the collection and not those of the page."""
    session = {"np": np}
    for block in blocks("python"):
        if "with_states" in block or "Reference" in block:
            exec(compile(block, str(DOCS), "exec"), session)
    expected = references["mass_spring_damper_chain"]["matrices"]
    found = session["published"]
    for key, name in {"J": "J", "R": "R", "Q": "Q", "G": "B"}.items():
        np.testing.assert_allclose(getattr(found, key).toarray(), expected[name], rtol=0, atol=1e-14, err_msg=key)
    np.testing.assert_allclose(found.E.toarray(), np.eye(6), rtol=0, atol=1e-14)
    for key in "PSN":
        assert abs(getattr(found, key)).max() <= 1e-14


def test_documentation_names_every_field():
    text = DOCS.read_text(encoding="utf-8")
    for key in (*TEXTS, *ALL_LABELS, *ALL_VECTORS, *ALL_MATRICES):
        assert f"`{key}`" in text, key


@pytest.mark.skipif(OCTAVE is None, reason="Octave is not installed")
def test_matlab_code_of_the_documentation_in_octave(tmp_path, beam, response):
    write(beam, tmp_path / "beam.mat")
    [block] = blocks("matlab")
    code = block + "printf('%.17g %.17g\\n', [real(full(H(:))) imag(full(H(:)))]')"
    command = [OCTAVE, "--quiet", "--no-gui", "--norc", "--eval", code]
    output = subprocess.run(command, cwd=tmp_path, capture_output=True, encoding="utf-8", check=True).stdout
    *lines, h11, h21, h12, h22 = output.splitlines()
    expected = response(beam.E, beam.J, beam.R, beam.Q, beam.G, S)
    got = np.array([complex(*map(float, h.split())) for h in (h11, h12, h21, h22)]).reshape(2, 2)
    assert np.abs(got - expected).max() <= 1e-10 * np.abs(expected).max()
    assert lines == [
        f"{name} [m/s]: {abs(value):g}" for name, value in zip(beam.output_names, expected[:, 0], strict=True)
    ]


@pytest.mark.skipif(OCTAVE is None, reason="Octave is not installed")
def test_nonlinear_equations_of_the_documentation_in_octave(tmp_path, scenes):
    """The rates at a state and input are those of the library."""
    system = scenes["arm"].compile()
    system.export(tmp_path / "arm.mat")
    rng = np.random.default_rng(2)
    x, theta, u = (rng.normal(size=k) for k in (system.n, system.start.theta.size, system.n_inputs))
    block = blocks("octave")[0]
    given = "; ".join(f"{name} = {vector.tolist()}'" for name, vector in (("x", x), ("th", theta), ("u", u)))
    code = f"{block}{given}; printf('%.17g\\n', full(rate(x, th, u)))"
    command = [OCTAVE, "--quiet", "--no-gui", "--norc", "--eval", code]
    output = subprocess.run(command, cwd=tmp_path, capture_output=True, encoding="utf-8", check=True).stdout
    found = np.array([float(line) for line in output.split()])
    expected = system.force(x, theta, u)
    np.testing.assert_allclose(system.rate_matrix @ found, expected, rtol=1e-10, atol=1e-10 * np.abs(expected).max())


@pytest.mark.skipif(OCTAVE is None, reason="Octave is not installed")
def test_midpoint_rule_of_the_documentation_in_octave(tmp_path, scenes):
    """A hundred steps from the start of the scene: the states and angles of the library."""
    system = scenes["arm"].compile()
    system.export(tmp_path / "arm.mat")
    code = "".join(blocks("octave")) + "printf('%.17g\\n', full([x; th]))"
    command = [OCTAVE, "--quiet", "--no-gui", "--norc", "--eval", code]
    output = subprocess.run(command, cwd=tmp_path, capture_output=True, encoding="utf-8", check=True).stdout
    found = np.array([float(line) for line in output.split()])
    solution = ph.simulate(system, 0.1, 1e-3, inputs={"drive": 0.0})
    end = solution.at(solution.t[-1])
    expected = np.concatenate([end.x, end.theta])
    assert np.abs(expected).max() > 0.1
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(expected).max())
