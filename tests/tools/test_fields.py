"""Numbers of the paper and the pages of evidence come from results, and a field that names none is refused."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))
import cells
import fields


def test_fields_become_what_was_measured():
    assert fields.written("{resume | split points that change a bit} changed") == "0 of 160 changed"
    assert fields.written("no place") == "no place"
    assert int(fields.written("{goals}")) >= int(fields.written("{not met}")) >= 0
    assert float(fields.written("{bench: animals | animals=1000 | M organism-steps/s}")) > 0


def test_words_follow_the_outcome():
    words = "{resume | split points that change a bit | passed: the same bytes | failed: other bytes}"
    assert fields.written(words) == "the same bytes"


@pytest.mark.parametrize(
    ("statement", "value", "text"),
    [
        ("runs that persist", "8 of 10", "8 of 10 (49% to 94%)"),  # Wilson: 0.490 to 0.943
        ("tries within 90 % intervals, of 40", 35, "35 of 40 (74% to 95%)"),  # 0.739 to 0.945
    ],
)
def test_a_count_has_wilsons_interval(statement, value, text):
    assert fields.share({"statement": statement, "value": value}) == text


def test_what_is_no_count_is_refused():
    with pytest.raises(ValueError, match=r"'0\.5' is not a count"):
        fields.share({"statement": "share", "value": 0.5})


@pytest.mark.parametrize(
    ("stored", "shown"),
    [
        ([0.5, -0.25, 0.75], "0.5 (−0.25 to 0.75)"),
        ([0.5, None, None], "0.5 (no interval)"),
        ("-0.447 (-0.477 … -0.418), p < .05", "−0.447 (−0.477 to −0.418), p < 0.05"),
        ("1.018 [0.979, 1.059]", "1.018 (0.979 to 1.059)"),
        ("grass→deer, 2-3 at 1e-6, 95 %", "grass→deer, 2-3 at 1e-6, 95%"),
        (12345.6, "12,346"),
    ],
)
def test_stored_values_are_shown_in_the_typography_of_the_pages(stored, shown):
    assert cells.shown(stored) == shown


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("{resume | split point that}", "0 lines of resume begin with 'split point that'"),
        ("{resmue | split}", "did you mean 'resume'"),
        ("{resume}", "matches no number"),
        ("{bench: animals | animals=7 | M organism-steps/s}", "no row with animals=7"),
        ("{bench: animals | animals=1000 | steps}", "no column 'steps'"),
    ],
)
def test_a_place_that_names_no_number_is_refused(place, words):
    with pytest.raises(ValueError, match=words):
        fields.written(place)
