"""A diagram on paper shows every block and connection, who gives what, and what is wrong."""

import itertools
from xml.etree import ElementTree

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import same_color
from matplotlib.patches import Rectangle
from matplotlib.text import Annotation

import phblocks as ph
from phblocks import plots


@pytest.fixture
def beam(bar):
    def make(name, start, end, **options):
        return ph.Beam(name, bar, start, end, elements=2, **options)

    return make


def chain(beam, n):
    d = ph.Diagram("chain")
    links = [d.add(beam(f"link {i}", (i, 0.0), (i + 1.0, 0.0))) for i in range(n)]
    d.pin(links[0].start, d.ground)
    for left, right in itertools.pairwise(links):
        d.pin(left.end, right.start)
    return d


def star(beam, n):
    d = ph.Diagram("star")
    angles = 2.0 * np.pi * np.arange(n) / n
    d.weld(*[d.add(beam(f"blade {i}", (0.0, 0.0), (np.cos(a), np.sin(a)))).start for i, a in enumerate(angles)])
    return d


def ladder(beam, n):
    """n rungs between two posts, of 3 n - 2 beams."""
    d = ph.Diagram("ladder")
    at = {}
    for i in range(n):
        bars = {f"rung {i}": ((0.0, i), (1.0, i))}
        if i + 1 < n:
            bars |= {f"left {i}": ((0.0, i), (0.0, i + 1)), f"right {i}": ((1.0, i), (1.0, i + 1))}
        for name, (start, end) in bars.items():
            b = d.add(beam(name, start, end))
            at.setdefault(start, []).append(b.start)
            at.setdefault(end, []).append(b.end)
    for (_, y), anchors in at.items():
        d.pin(*anchors, *([d.ground] if y == 0 else []))
    return d


def frame(beam):
    d = ph.Diagram("frame")
    places = ((0.0, 0.0), (0.0, 3.0), (4.0, 3.0), (4.0, 0.0))
    left, top, right = (
        d.add(beam(name, a, b))
        for name, a, b in zip(("left column", "top", "right column"), places, places[1:], strict=False)
    )
    d.weld(left.start, d.ground)
    d.weld(left.end, top.start)
    d.weld(top.end, right.start)
    d.weld(right.end, d.ground)
    return d


def boxes(ax):
    """Name -> Rectangle."""
    return {patch.get_label(): patch for patch in ax.patches if isinstance(patch, Rectangle)}


def arrows(ax):
    """(tail, head, colour) of each."""
    return [
        (np.array(t.xyann), np.array(t.xy), t.arrow_patch.get_edgecolor())
        for t in ax.texts
        if isinstance(t, Annotation)
    ]


def junctions(ax):
    return [line for line in ax.lines if line.get_marker() == "o"]


def legend(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def distance(box, point):
    """From a point to a box, zero inside."""
    low = np.array(box.get_xy())
    high = low + np.array([box.get_width(), box.get_height()])
    return float(np.linalg.norm(point - np.clip(point, low, high)))


def test_four_bar(four_bar):
    ax = plots.diagram(four_bar())
    assert list(boxes(ax)) == ["crank", "coupler", "rocker"]
    assert len(junctions(ax)) == 4
    assert len(arrows(ax)) == 8
    assert sum(line.get_label() == "ground" for line in ax.lines) == 2
    labels = [t.get_text() for t in ax.texts if not isinstance(t, Annotation)]
    assert sorted(labels) == sorted([*boxes(ax), *["start", "end"] * 3])
    assert legend(ax) == ["translation: velocity (m/s) along the arrow, force (N) against it"]
    assert ax.get_title() == "four-bar"


def test_arrows_go_where_velocity_goes(four_bar):
    """The coupler gives velocity at both ends: arrows leave it, and arrive at the other two."""
    ax = plots.diagram(four_bar())
    named = boxes(ax)
    leaving = {name: sum(distance(b, tail) < 1e-6 for tail, _, _ in arrows(ax)) for name, b in named.items()}
    arriving = {name: sum(distance(b, head) < 1e-6 for _, head, _ in arrows(ax)) for name, b in named.items()}
    assert leaving == {"crank": 0, "coupler": 2, "rocker": 0}
    assert arriving == {"crank": 2, "coupler": 0, "rocker": 2}


def test_domains_have_colours(beam):
    """A weld is two junctions, and one ground."""
    d = ph.Diagram("cantilever")
    b = d.add(beam("beam", (0.0, 0.0), (1.0, 0.0)))
    d.weld(b.start, d.ground)
    d.expose(b.end.translation, "tip")
    ax = plots.diagram(d)
    assert sum(line.get_label() == "ground" for line in ax.lines) == 1
    assert [text.split(":")[0] for text in legend(ax)] == ["translation", "rotation"]
    assert "(N m)" in legend(ax)[1]
    colours = [colour for _, _, colour in arrows(ax)]
    assert sum(same_color(c, "tab:blue") for c in colours) == 4
    assert sum(same_color(c, "tab:orange") for c in colours) == 2
    assert "tip" in [t.get_text() for t in ax.texts]


def test_conflicts_are_red(beam):
    d = ph.Diagram("bad")
    a = d.add(beam("first", (0.0, 0.0), (1.0, 0.0), causality="free-free"))
    b = d.add(beam("second", (1.0, 0.0), (2.0, 0.0), causality="free-free"))
    c = d.add(beam("third", (2.0, 0.0), (3.0, 0.0), causality="pinned-pinned"))
    d.pin(a.end, b.start)
    d.pin(b.end, c.start)
    ax = plots.diagram(d)
    red = [line for line in junctions(ax) if same_color(line.get_markeredgecolor(), "tab:red")]
    assert len(red) == len(d.check().conflicts) == 2
    assert len(junctions(ax)) == 3
    assert sum(same_color(colour, "tab:red") for _, _, colour in arrows(ax)) == 3
    written = [t.get_text() for t in ax.texts]
    assert "2 give velocity" in written
    assert "nobody gives velocity" in written
    assert ax.get_title() == "bad: not causal"
    assert legend(ax)[1] == "conflict"


def test_repairs_are_written_and_what_the_first_changes_is_green(beam):
    d = ph.Diagram("bad")
    a = d.add(beam("first", (0.0, 0.0), (1.0, 0.0), causality="free-free"))
    b = d.add(beam("second", (1.0, 0.0), (2.0, 0.0), causality="free-free"))
    c = d.add(beam("third", (2.0, 0.0), (3.0, 0.0)))
    d.pin(a.end, b.start)
    d.pin(b.end, c.start)
    repairs = d.check().repairs
    mended = repairs[0].apply(d).network.blocks
    ax = plots.diagram(d)
    written = [" ".join(text.split()) for text in legend(ax) if text.startswith("repair")]
    assert written == [f"repair {i}: {repair.what}" for i, repair in enumerate(repairs[:2], start=1)]
    green = {name for name, box in boxes(ax).items() if same_color(box.get_edgecolor(), "tab:green")}
    assert green == {name for name, block in d.network.blocks.items() if mended[name] is not block} != set()
    ax.figure.draw_without_rendering()
    assert ax.get_legend().get_window_extent().y0 >= 0.0


def test_the_giving_side_is_marked(four_bar):
    d = four_bar()
    ax = plots.diagram(d)
    gives = {a.port.path: a.gives for a in d.check().assignments}
    given = sum(a.gives for a in d.check().assignments if len(a.junction.ports) > 1 and not a.port.block.shared)
    marks = [line for line in ax.lines if line.get_marker() == "s"]
    assert len(gives) > len(marks) == 8  # six ends and the ground, twice
    full = [m for m in marks if m.get_label() == "_gives"]
    assert len(full) == given + 2
    assert all(same_color(m.get_markerfacecolor(), m.get_color()) for m in full)
    assert all(same_color(m.get_markerfacecolor(), "white") for m in marks if m not in full)


def test_a_source_is_the_outside(beam):
    """It is drawn once, as the block that gives."""
    d = ph.Diagram("pushed")
    b, force = d.add(beam("beam", (0.0, 0.0), (1.0, 0.0))), d.add(ph.Velocity("shaker", (1.0, 0.0)))
    d.connect(b.start.translation, force.port)
    ax = plots.diagram(d)
    assert [t.get_text() for t in ax.texts].count("shaker") == 1
    tails = [tail for tail, _, _ in arrows(ax)]
    assert sum(distance(boxes(ax)["shaker"], tail) < 1e-6 for tail in tails) == 1


@pytest.mark.parametrize("suffix", [".svg", ".png"])
def test_files(four_bar, tmp_path, suffix):
    path = tmp_path / f"four_bar{suffix}"
    plots.diagram(four_bar(), path=path)
    if suffix == ".png":
        height, width = plt.imread(path).shape[:2]
        assert width > height > 500
    else:
        assert ElementTree.parse(path).getroot().tag.endswith("svg")


def test_other_files(four_bar):
    with pytest.raises(ph.errors.ExportError, match="svg"):
        plots.diagram(four_bar(), path="four_bar.doc")


def test_names_are_no_mathematics(beam):
    d = ph.Diagram("$x_")
    d.add(beam("$a^", (0.0, 0.0), (1.0, 0.0)))
    plots.diagram(d).figure.draw_without_rendering()


@pytest.mark.parametrize("draw", [chain, lambda beam, n: ladder(beam, n // 3)])
def test_sixty_blocks_can_be_read(beam, draw):
    """Folded into rows that fill the sheet; no line through a box."""
    ax = plots.diagram(draw(beam, 60))
    named = boxes(ax)
    check_layout(ax, len(named))
    assert len(named) >= 58
    width, height = ax.figure.get_size_inches()
    assert 0.5 < width / height < 2.0
    names = [t for t in ax.texts if t.get_text() in named]
    assert min(t.get_fontsize() for t in names) > 4.0
    labels = [t.get_window_extent() for t in ax.texts if t.get_text() in ("start", "end")]
    outside = sum(not any(a.overlaps(b.get_window_extent()) for b in named.values()) for a in labels)
    assert outside >= 0.9 * len(labels)


def test_a_held_port_open_to_the_outside_is_red(beam):
    d = ph.Diagram("held")
    b = d.add(beam("beam", (0.0, 0.0), (1.0, 0.0)))
    d.pin(b.start, d.ground)
    d.expose(b.start.translation, "push")
    assert not d.check().ok
    assert "held: the outside cannot act" in [t.get_text() for t in plots.diagram(d).texts]


def test_report(four_bar):
    """A report is drawn like its diagram, without the name."""
    d = four_bar()
    ax = plots.diagram(d.check())
    assert list(boxes(ax)) == ["crank", "coupler", "rocker"]
    assert ax.get_title() == ""


@pytest.mark.parametrize("n", range(3, 13))
@pytest.mark.parametrize("draw", [chain, star])
def test_boxes_do_not_overlap(beam, draw, n):
    check_layout(plots.diagram(draw(beam, n)), n)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_boxes_of_ladders_do_not_overlap(beam, n):
    check_layout(plots.diagram(ladder(beam, n)), 3 * n - 2)


def test_boxes_of_a_frame_do_not_overlap(beam):
    check_layout(plots.diagram(frame(beam)), 3)


def check_layout(ax, n):
    """No box on another or on a junction, each name within its box, everything within the figure."""
    ax.figure.draw_without_rendering()
    extents = [box.get_window_extent() for box in boxes(ax).values()]
    assert len(extents) == n
    assert not any(a.overlaps(b) for a, b in itertools.combinations(extents, 2))
    spots = [line.get_window_extent() for line in junctions(ax)]
    assert not any(a.overlaps(b) for a in extents for b in spots)
    for text in ax.texts:
        if text.get_text() in boxes(ax):
            inside, around = text.get_window_extent(), boxes(ax)[text.get_text()].get_window_extent()
            assert around.x0 < inside.x0 < inside.x1 < around.x1
            assert around.y0 < inside.y0 < inside.y1 < around.y1
    page = ax.figure.bbox
    assert all(page.x0 <= e.x0 and e.x1 <= page.x1 and page.y0 <= e.y0 and e.y1 <= page.y1 for e in extents)


def test_small_axes(four_bar):
    """In given axes everything shrinks together."""
    _, axes = plt.subplots(2, 2, figsize=(6.0, 5.0))
    ax = plots.diagram(four_bar(), ax=axes[0, 0])
    assert ax is axes[0, 0]
    check_layout(ax, 3)


def test_same_picture_every_time(beam):
    first, second = (plots.diagram(ladder(beam, 3)) for _ in range(2))
    assert [b.get_xy() for b in boxes(first).values()] == [b.get_xy() for b in boxes(second).values()]


def test_hardly_anything(beam):
    d = ph.Diagram("empty")
    assert boxes(plots.diagram(d)) == {}
    d.add(beam("alone", (0.0, 0.0), (1.0, 0.0)))
    assert list(boxes(plots.diagram(d))) == ["alone"]


def test_many_blocks(beam):
    assert len(boxes(plots.diagram(chain(beam, 100)))) == 100


def test_no_diagram(four_bar):
    with pytest.raises(ph.errors.ArgumentTypeError):
        plots.diagram(four_bar().compile())
