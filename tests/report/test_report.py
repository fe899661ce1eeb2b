"""The report is one valid page, and its numbers are those of the solution."""

import json
from dataclasses import replace
from html import escape
from html.parser import HTMLParser

import numpy as np
import pytest

import phblocks as ph

VOID = {"meta", "input", "br", "img", "link", "hr"}
SECTIONS = ["diagram", "motion", "causality", "effects", "energies", "health", "cost"]


class Page(HTMLParser):
    """Reads a page strictly: every element is closed in its turn, ids are there once."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.elements, self.texts = [], [], [], {}
        self.tables, self.scripts = {}, {}
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        assert len(attrs) == len(dict(attrs))
        self.ids += [value for key, value in attrs if key == "id"]
        if tag not in VOID:
            self.open.append((tag, dict(attrs)))
        if tag == "tr":
            self.table.append([])
        elif tag == "table":
            self.table = self.tables[dict(attrs)["id"]] = []
        elif tag in ("td", "th"):
            self.table[-1].append(dict(attrs).get("data-value") or "")

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self.ids += [value for key, value in attrs if key == "id"]

    def handle_endtag(self, tag):
        assert self.open.pop()[0] == tag

    def handle_data(self, data):
        tags = [tag for tag, _ in self.open]
        if tags and tags[-1] in ("td", "button") and ("td" in tags or "th" in tags):
            row = self.table[-1]
            row[-1] = float(row[-1]) if tags[-1] == "td" and "data-value" in self.open[-1][1] else row[-1] + data
        if tags:
            self.texts[tags[-1]] = self.texts.get(tags[-1], "") + data
        if tags and tags[-1] == "script":
            self.scripts[self.open[-1][1].get("id")] = data


@pytest.fixture(scope="module")
def solution(four_bar):
    return ph.simulate(four_bar().compile(), t_end=1.0, dt=0.01)


@pytest.fixture(scope="module")
def text(solution, tmp_path_factory):
    path = solution.report(tmp_path_factory.mktemp("report") / "four bar.html")
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_valid_and_small(page, text):
    assert text.startswith("<!DOCTYPE html>")
    assert len(page.ids) == len(set(page.ids))
    assert len(text.encode()) < 2e6
    sections = [a["id"] for tag, a in page.elements if tag == "section"]
    assert sections == SECTIONS
    assert {a["href"] for tag, a in page.elements if tag == "a"} == {f"#{name}" for name in SECTIONS}


def test_every_reference_stays_within(page):
    """Nothing to load, and whatever is referred to is there."""
    assert not [a for _, a in page.elements if "src" in a]
    links = [a[key] for _, a in page.elements for key in ("href", "xlink:href") if key in a]
    links += [a["clip-path"][4:-1] for _, a in page.elements if "clip-path" in a]
    assert links and all(link[0] == "#" and link[1:] in page.ids for link in links)
    assert not [tag for tag, _ in page.elements if tag in ("link", "img", "iframe")]


def test_scene(page, solution):
    """What is animated is the solution, to the width of a hair."""
    scene = json.loads(page.scripts["scene"])
    np.testing.assert_allclose(scene["t"], solution.t, atol=1e-9)
    low, unit = np.array(scene["low"]), scene["unit"]
    assert [line["name"] for line in scene["lines"]] == ["crank", "coupler", "rocker"]
    for line in scene["lines"]:
        places = low + unit * np.array(line["places"]).reshape(solution.t.size, -1, 2)
        for k, s in ((0, 0.0), (10, 0.5), (20, 1.0)):
            np.testing.assert_allclose(places[:, k], solution.position(line["name"], s), atol=unit)
    largest = scene["colour"]["largest"]
    middle = np.array(scene["lines"][0]["values"])[:, 10] * largest / 100.0
    form, history = solution.system.part("crank").form, solution._history(solution.system.part("crank"))
    np.testing.assert_allclose(middle, form.value(history, "M3", 0.5), atol=0.006 * largest)
    assert scene["colour"]["unit"] == "N m"
    assert len(scene["trails"]) == 2  # the joints that move


def test_tables(page, solution):
    _, *rows = page.tables["energy-table"]
    assert [row[0] for row in rows] == list(solution.energy)
    for name, start, end, least, most in rows:
        series = solution.energy[name]
        assert (start, end, least, most) == (series[0], series[-1], series.min(), series.max())
    _, *rows = page.tables["ledger"]
    for name, stored, gravity, received, supplied, dissipated in rows:
        row = solution.power.blocks[name]
        assert stored == row["stored"][-1]
        assert stored + gravity == pytest.approx(received + supplied - dissipated, abs=1e-9)
    _, *rows = page.tables["ports"]
    given = {row[0]: row[2] for row in rows}
    expected = {a.port.path: a.given for a in solution.system.report.assignments if not a.port.block.shared}
    assert given == expected
    _, *rows = page.tables["health-table"]
    assert [row[:2] for row in rows] == [[f.name, f.value] for f in solution.health.findings]
    assert rows[0][1] == pytest.approx(solution.max_power_balance_error / solution.recording.sums.energy[0], rel=1e-9)
    assert {row[3] for row in rows} == {"ok", "noted"}
    assert all(attributes.get("class") != "bad" for _, attributes in page.elements)
    _, *rows = page.tables["iterations"]
    assert sum(row[1] for row in rows) == solution.statistics.steps
    assert sum(row[0] * row[1] for row in rows) == solution.statistics.newton_iterations.sum()


def test_diagram_is_inline(page):
    assert [a["id"] for tag, a in page.elements if tag == "figure"] == ["drawing", "energy", "flow"]
    assert all(name in page.texts["text"] for name in ("crank", "coupler", "rocker"))


NAME = '</script><script>alert("x")</script> --> & $x_ <b>'


def test_names_are_escaped(bar, tmp_path):
    d = ph.Diagram(NAME)
    beam = d.add(ph.Beam("</text><b>&$", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(beam.start, d.ground)
    d.expose(beam.end.translation, "<i>$_")
    solution = ph.simulate(d.compile(), t_end=0.1, dt=0.05, inputs={"<i>$_": (0.0, 1.0)})
    page = Page(solution.report(tmp_path / "x.html").read_text(encoding="utf-8"))
    assert not {tag for tag, _ in page.elements} & {"b", "i"}
    assert page.texts["title"] == page.texts["h1"] == NAME
    assert [tag for tag, _ in page.elements].count("script") == 2
    assert json.loads(page.scripts["scene"])["name"] == NAME


def test_a_system_that_is_nowhere(tmp_path):
    """A circuit has no motion to show."""
    d = ph.Diagram("circuit")
    source, earth = d.add(ph.Voltage("source", 1.0)), d.add(ph.Reference("earth"))
    resistor, capacitor = d.add(ph.Resistor("resistor", 1.0)), d.add(ph.Capacitor("capacitor", 1.0))
    d.connect(source.port, resistor.p)
    d.connect(resistor.n, capacitor.p)
    d.connect(capacitor.n, earth.port)
    solution = ph.simulate(d.compile(), t_end=1.0, dt=0.1)
    page = Page(solution.report(tmp_path / "x.html").read_text(encoding="utf-8"))
    assert [a["id"] for tag, a in page.elements if tag == "section"] == [s for s in SECTIONS if s != "motion"]


def test_effects_left_out_are_told(four_bar, tmp_path):
    system = four_bar().compile(approximation=ph.Approximation(shear=False))
    assert system.approximations
    solution = ph.simulate(system, t_end=0.05, dt=0.01)
    page = Page(solution.report(tmp_path / "x.html").read_text(encoding="utf-8"))
    _, *rows = page.tables["effects-table"]
    assert rows == [[e.block or "the whole", e.name, e.status, e.states, e.reason] for e in system.effects]
    assert {e.name for e in system.effects.select(status="approximated")} == {"shear"}


def test_what_is_over_its_limit_is_said_in_a_sentence(solution, tmp_path):
    strict = replace(solution, limits=ph.Limits(closure=1e-9))
    text = strict.report(tmp_path / "x.html").read_text(encoding="utf-8")
    (over,) = strict.health.findings.over
    assert f'<li class="bad">{escape(str(over))}</li>' in text and "closure of joints" in str(over)


def test_wrong_arguments(solution, tmp_path):
    with pytest.raises(ph.errors.ExportError, match="html"):
        solution.report(tmp_path / "x.pdf")
    with pytest.raises(ph.errors.DataError, match="moment"):
        solution.report(tmp_path / "x.html", colour="blue")
