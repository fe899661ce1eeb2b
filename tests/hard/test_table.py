"""The page of the table shows what was measured, of every scene, and says where something does not hold."""

from tests.hard.table import PAGE, cases, forget, key, page, read


def test_every_scene_was_measured() -> None:
    results = read()
    names = [key(number, scene) for number, _, scenes in cases() for scene in scenes]
    assert sorted({number for number, _, _ in cases()}) == list(range(1, 15))
    assert len(set(names)) == len(names)
    assert [name for name in names if name not in results] == []
    assert forget(results) == results  # no rows of scenes that are no more


def test_what_does_not_hold_is_told() -> None:
    results = read()
    for number, _, scenes in cases():
        for scene in scenes:
            row = results[key(number, scene)]
            assert row["holds"] or scene.open, key(number, scene)
            assert not scene.open or ("does not hold" in row["measured"]) == (not row["holds"])


def test_page_shows_the_results() -> None:
    assert page(read()) in PAGE.read_text(encoding="utf-8")
