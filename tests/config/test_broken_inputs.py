"""Broken worlds and command lines get one error each, with the suggestion that helps or none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tools.suggestions import answer, inputs, label

INPUTS = inputs()


@pytest.mark.parametrize("case", INPUTS, ids=map(label, INPUTS))
def test_a_broken_input_gets_one_error_and_the_right_suggestion(
    case: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    given = answer(case)
    assert given["suggestion"] == case["suggestion"], given["message"]
    assert (given["problems"], given["code"]) == (1, 2), given["message"]
    assert case.get("says", "") in given["message"]


def test_there_are_sixty_broken_inputs() -> None:
    assert len({label(case) for case in INPUTS}) == len(INPUTS) >= 60


def test_the_value_is_quoted_as_the_file_has_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    case = {"old": "cell = 2.0", "new": "cell = 1_000e-1", "suggestion": ""}
    assert "fields.smoke.cell = 1_000e-1\n" in answer(case)["message"]
    case = {"old": 'kind = "touch", target = "stone"', "new": "kind='touch', target='stone', at=[1.0, 1]"}
    assert "species.goat.sensors.3.at = [1.0, 1]\n" in answer(case)["message"]
