"""The pages of the manual: their code runs, their links lead somewhere, and the contents list them all."""

import re
import shutil
import subprocess
import warnings
from pathlib import Path
from urllib.parse import unquote

import matplotlib.pyplot as plt
import pytest

import phblocks as ph

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.glob("*.md"))
#: Everything that is read on the host of the repository.
TEXTS = [*PAGES, ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "tests" / "README.md"]

#: Pages whose code runs in a test of their own, because it takes a start or an end that the page does not show.
OWN_TESTS = {
    "cli.md": "tests/cli/test_page.py",
    "errors.md": "tests/test_errors_page.py",
    "export.md": "tests/export/test_documentation.py",
    "effects.md": "tests/effects/test_documentation.py",
    "studies.md": "tests/studies/test_documentation.py",
    "files.md": "tests/files/test_documentation.py",
    "pictures.md": "tests/test_pictures_page.py",
    "approximations.md": "tests/test_approximations_page.py",
    "damping.md": "tests/test_damping_page.py",
}
#: Languages of code blocks: what checks them.
LANGUAGES = {
    "python": "the tests of this file",
    "matlab": "in Octave, here and in tests/export/test_documentation.py",
    "octave": "tests/export/test_documentation.py, in Octave",
    "julia": "the files it reads are written on its page",
    "json": "tests/test_description.py",
    "text": "shown, not run",
    "sh": "commands, tests/test_readme.py for those of the README",
}

OCTAVE = shutil.which("octave-cli")
FENCE = re.compile(r"^(`{3,})([^\n]*)\n(.*?)^\1\s*$", re.M | re.S)


def code(text, language):
    """Code blocks of a language, each at its own line numbers so that a traceback points into the page."""
    return [
        "\n" * text.count("\n", 0, block.start(3)) + block[3]
        for block in FENCE.finditer(text)
        if block[2].strip() == language
    ]


def prose(text):
    """A page without its code, at the same line numbers."""
    text = FENCE.sub(lambda block: "\n" * block[0].count("\n"), text)
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^(?: {4}|\t).*$", "", text, flags=re.M))


def slug(heading):
    """What a heading is linked by, on the host of the repository and in the built manual."""
    plain = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").strip().lower()
    return re.sub(r"[^\w\- ]", "", plain).replace(" ", "-")


def headings(path):
    """Anchors of a page; of equal ones the second has -1 at its end, and so on."""
    found = []
    for heading in re.findall(r"^#{1,6} +(.+?)\s*$", FENCE.sub("", path.read_text(encoding="utf-8")), re.M):
        name = slug(heading)
        again = sum(old == name or re.fullmatch(rf"{re.escape(name)}-\d+", old) is not None for old in found)
        found.append(f"{name}-{again}" if again else name)
    return found


def links(path):
    """Line and target of each link and picture of a page."""
    text = prose(path.read_text(encoding="utf-8"))
    for link in re.finditer(r"\[(?:[^]]*)\]\(\s*<?([^)\s>]+)>?[^)]*\)", text):
        yield text.count("\n", 0, link.start()) + 1, link[1]


def broken(path):
    """Links of a page that lead nowhere: files that are not there, headings that no page has. No network."""
    for line, target in links(path):
        if re.match(r"[a-z]+:", target):
            if not re.match(r"https://[\w.-]+\.[a-z]+(/|$)", target):
                yield f"{path.name}:{line}: {target} is no address"
            continue
        name, _, anchor = target.partition("#")
        file = (path.parent / unquote(name)).resolve() if name else path
        if not file.exists() or ROOT not in file.parents:
            yield f"{path.name}:{line}: {target} does not exist"
        elif anchor and file.suffix == ".md" and anchor not in headings(file):
            yield f"{path.name}:{line}: no heading #{anchor} in {file.name}"


# Links and contents


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.stem)
def test_links(path):
    assert list(broken(path)) == []


def test_links_that_lead_nowhere_are_found(tmp_path, monkeypatch):
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    page = tmp_path / "page.md"
    page.write_text(
        "# One Heading (1)\n## Again\n## Again\n[a](#one-heading-1) [b](other.md) [c](page.md#nothing) `[d](e.md)`\n"
        "[f](http://x.org) [g](https://x.org/y) [h](#again-1)\n```python\n[i](j.md)\n```\n![k](l.png)\n"
        "[a link over\ntwo lines](m.md)\n",
        encoding="utf-8",
    )
    assert [problem.split(": ")[1].split()[0] for problem in broken(page)] == [
        "other.md", "no", "http://x.org", "l.png", "m.md",
    ]  # fmt: skip
    assert headings(page) == ["one-heading-1", "again", "again-1"]


def test_every_page_is_in_the_contents():
    """All but the index itself, each once."""
    trees = re.findall(r"^```\{toctree\}\n(.*?)^```", (DOCS / "index.md").read_text(encoding="utf-8"), re.M | re.S)
    entries = [line.strip() for tree in trees for line in tree.splitlines() if line.strip() and line[0] != ":"]
    assert len(entries) == len(set(entries))
    pages = {path.stem for path in DOCS.iterdir() if path.suffix in (".md", ".rst")} - {"index"}
    assert pages - set(entries) == set()
    assert set(entries) - pages == {"gallery/index"}  # made from examples/


def test_readme_links_to_the_pages():
    linked = {target for _, target in links(ROOT / "README.md")}
    for page in PAGES:
        assert f"docs/{page.name}" in linked or page.name == "index.md", f"README.md does not lead to {page.name}"


# Code


def test_every_code_block_has_a_language_that_something_checks():
    for path in PAGES:
        for block in FENCE.finditer(path.read_text(encoding="utf-8")):
            language = block[2].strip()
            assert language in LANGUAGES or language.startswith("{"), f"{path.name}: {language!r}"


@pytest.mark.parametrize(("page", "test"), OWN_TESTS.items(), ids=list(OWN_TESTS))
def test_pages_with_tests_of_their_own_have_them(page, test):
    text = (ROOT / test).read_text(encoding="utf-8")
    assert page in text and "exec(" in text
    assert code((DOCS / page).read_text(encoding="utf-8"), "python")


@pytest.mark.parametrize("path", [p for p in PAGES if p.name not in OWN_TESTS], ids=lambda path: path.stem)
def test_code_runs(path, tmp_path, monkeypatch, capsys):
    """The blocks follow each other like the cells of one session, and raise no warning; blocks of text are printed."""
    text = path.read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    session = {"__name__": "page"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for block in code(text, "python"):
            exec(compile(block, str(path), "exec"), session)
    plt.close("all")
    printed = {line.rstrip() for line in capsys.readouterr().out.splitlines()}
    for shown in code(text, "text"):
        if any(line.startswith(("port ", "conflict:", "repair:")) for line in shown.splitlines()):
            for line in filter(lambda line: line.strip(" -"), shown.splitlines()):
                pattern = ".*".join(re.escape(part) for part in line.rstrip().split("..."))
                assert any(re.fullmatch(pattern, real) for real in printed), line
    for language, name in (("matlab", r"load\('([^']+)'\)"), ("octave", r"load\('([^']+)'\)"), ("julia", r'"([^"]+)"')):
        for block in code(text, language):
            for file in re.findall(name, block):
                if "." in file:
                    assert (tmp_path / file).exists(), f"{file} is not written"


@pytest.mark.skipif(OCTAVE is None, reason="Octave is not installed")
def test_matlab_of_the_quick_start_in_octave(tmp_path, monkeypatch):
    text = (DOCS / "quick-start.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    session = {"__name__": "page"}
    for block in code(text, "python"):
        exec(compile(block, "quick-start.md", "exec"), session)
    plt.close("all")
    [block] = code(text, "matlab")
    command = [OCTAVE, "--quiet", "--no-gui", "--norc", "--eval", block]
    output = subprocess.run(command, cwd=tmp_path, capture_output=True, encoding="utf-8", check=True).stdout
    n = session["system"].n
    assert f"{n} states, {n - 1} of them with a rate" in output and "motor" in output
    assert session["system"].constraint_names == ("guide.force0[0]",)


@pytest.mark.parametrize("path", [p for p in PAGES if p.name in OWN_TESTS], ids=lambda path: path.stem)
def test_files_that_other_languages_load_are_named(path):
    """On a page with a test of its own the Python code, or the text, writes what others load."""
    text = path.read_text(encoding="utf-8")
    for language, name in (
        ("matlab", r"load\('([^']+)'\)"),
        ("octave", r"load\('([^']+)'\)"),
        ("julia", r'"(\S+\.\S+)"'),
    ):
        for block in code(text, language):
            for file in re.findall(name, block):
                assert f'"{file}"' in text or f"`{file}`" in text or f'export("{file}")' in text, file


# What pages say in numbers and words


def test_the_table_of_causality():
    """Who may give: docs/causality.md against the blocks themselves."""
    text = (DOCS / "causality.md").read_text(encoding="utf-8")
    rows = {
        name: (gives.strip(), takes.strip())
        for cells, gives, takes in re.findall(r"^\| (.*?) \| (.*?) \| (.*?) \|", text, re.M)
        for name in re.findall(r"`(\w+)`", cells)
    }
    blocks = {
        "Mass": ph.Mass("m", 1.0, (0, 0)),
        "RigidBody": ph.RigidBody("b", 1.0, 1.0, (0, 0)),
        "Reference": ph.Reference("r"),
        "Spring": ph.Spring("s", 1.0, (0, 0), (1, 0)),
        "Damper": ph.Damper("c", 1.0, (0, 0), (1, 0)),
        "TorsionSpring": ph.TorsionSpring("t", 1.0),
        "TorsionDamper": ph.TorsionDamper("t", 1.0),
        "Bushing": ph.Bushing("b", [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]),
        "Slider": ph.Slider("s", (1, 0)),
        "RigidJoint": ph.RigidJoint("j", turns=True),
        "Resistor": ph.Resistor("r", 1.0),
        "Inductor": ph.Inductor("l", 1.0),
        "Capacitor": ph.Capacitor("c", 1.0),
        "Force": ph.Force("f", (0, 1)),
        "Moment": ph.Moment("m", 1.0),
        "Current": ph.Current("i", 1.0),
    }
    words = {"always": {(True, False)}, "never": {(False, True)}, "yes": {(True, True)}}
    for name, block in blocks.items():
        can = {(choice.may_give, choice.may_take) for choice in block.choices()[0]}
        assert can == words[rows[name][0]], name
        assert rows[name][1] == {"always": "never", "never": "always", "yes": "yes"}[rows[name][0]], name
    for block, opposite in ((ph.Transformer("t", 2.0), True), (ph.Gyrator("g", 1.0, ph.HYDRAULIC, ph.ROTATION), False)):
        ([choice, other], [tie]) = block.choices()
        assert choice.may_give and choice.may_take and other.may_give and other.may_take
        assert tie.cost is None and tie.opposite is opposite
        assert rows[type(block).__name__][0] == ("one of its ports" if opposite else "both ports or none")


def test_causality_links_every_code():
    text = (DOCS / "causality.md").read_text(encoding="utf-8")
    for value in vars(ph.errors).values():
        if isinstance(value, type) and issubclass(value, ph.PhblocksError):
            assert f"[{value.code}](errors.md#{value.code.lower()}-{value.__name__.lower()})" in text, value.code
