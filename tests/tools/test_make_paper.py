"""The paper's numbers come from results, and a place that names none is refused."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))
import make_paper


def test_places_become_what_was_measured():
    assert make_paper.written("{resume | split points that change a bit} changed") == "0 of 160 changed"
    assert make_paper.written("no place") == "no place"
    assert int(make_paper.written("{goals}")) >= int(make_paper.written("{not met}")) >= 0
    assert float(make_paper.written("{bench: animals | animals=1000 | M organism-steps/s}")) > 0


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("{resume | split point that}", "0 lines of resume begin with 'split point that'"),
        ("{resmue | split}", "did you mean 'resume'"),
        ("{bench: animals | animals=7 | M organism-steps/s}", "no row with animals=7"),
        ("{bench: animals | animals=1000 | steps}", "no column 'steps'"),
    ],
)
def test_a_place_that_names_no_number_is_refused(place, words):
    with pytest.raises(ValueError, match=words):
        make_paper.written(place)
