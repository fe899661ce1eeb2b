"""Names of the causality of a beam end."""

import pytest

from phblocks.blocks.beam.ends import END_NAMES, ENDS, End, parse_causality
from phblocks.errors import ArgumentTypeError, DataError


def test_names_say_what_an_end_takes():
    """Free takes force and moment, pinned velocity and moment, clamped both velocities, guided force and spin."""
    expected = {
        "free": End(velocity=True, spin=True),
        "pinned": End(velocity=False, spin=True),
        "clamped": End(velocity=False, spin=False),
        "guided": End(velocity=True, spin=False),
    }
    assert expected == ENDS
    assert all(END_NAMES[ENDS[name]] == name for name in ENDS)


def test_a_text_and_a_pair_say_the_same():
    clamped_free = (End(False, False), End(True, True))
    for written in ("clamped-free", ("clamped", "free"), ["clamped", "free"]):
        assert parse_causality("beam", written) == clamped_free
    assert parse_causality("beam", "auto") is None


@pytest.mark.parametrize(
    "written", ["free", "free-bad", "free-free-free", "", "auto-auto", ("free",), ("free", "auto")]
)
def test_unknown_names(written):
    with pytest.raises(DataError, match=r"beam 'a'.*two of free, pinned, clamped, guided"):
        parse_causality("beam 'a'", written)


@pytest.mark.parametrize("written", [None, 1, True, ("free", 1), (None, "free"), {"start": "free"}])
def test_no_names_at_all(written):
    with pytest.raises(ArgumentTypeError, match='"auto"'):
        parse_causality("beam 'a'", written)
