"""Some malicious files and messages of studies/malicious.py, which has the rest; and its controls,
which are to leave their marks."""

import sys
from collections.abc import Iterator
from types import ModuleType

import pytest

from studies import malicious
from studies.common.malicious import surroundings
from studies.common.malicious.ground import TRACEBACK, UNNAMED, Attack, Ground, ground, judged


@pytest.fixture
def place() -> Iterator[Ground]:
    """A ground where nothing was allowed."""
    with ground() as prepared:
        yield prepared


@pytest.mark.parametrize(
    ("what", "number"), [("world", 3), ("checkpoint", 4), ("manifest", 2), ("message", 20)]
)
def test_malicious_files_and_messages_leave_no_mark(what: str, number: int, place: Ground) -> None:
    for attack in malicious.BY_MUTATION[what](place, 7, number):
        outcome = judged(place, attack)
        assert not outcome["marks"]
        assert not outcome["imported"]
        assert not outcome["counts"][UNNAMED] + outcome["counts"][TRACEBACK], outcome


def test_modules_of_other_worlds_are_no_finding_and_stay() -> None:
    other = sys.modules["_ecs_eco_code_0_other"] = ModuleType("_ecs_eco_code_0_other")
    try:
        with ground() as place:
            assert judged(place, Attack("harmless", [], [("nothing", str)]))["imported"] == []
        assert sys.modules[other.__name__] is other
    finally:
        del sys.modules[other.__name__]


def test_payloads_that_are_run_on_purpose_leave_their_marks(place: Ground) -> None:
    assert [c["label"] for c in surroundings.controls(place) if not c["marked"]] == []


def test_a_mark_and_an_import_are_noticed(place: Ground) -> None:
    outcome = judged(place, Attack("careless", [], [("import", lambda: __import__("evil").__name__ * 0)]))
    assert outcome["marks"] == ["module"]
    assert outcome["imported"] == ["evil"]
