"""The study of `ecs-eco why`: labels follow from what is changed, the short form is right,
and so is the kept result."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ecs_eco.config import load
from studies import why
from studies.common.disasters import CLASSES, WEBS, web
from studies.common.study import RESULTS


@pytest.mark.parametrize("label", CLASSES)
def test_variants_are_worlds_of_their_own_and_the_same_again(label: str) -> None:
    worlds = [web(seed, label) for seed in range(40)]
    for config, drawn in worlds[:5]:
        assert load(config).species[drawn["who"]].diet
    assert len({json.dumps(config) for config, _ in worlds}) == 40
    assert len({config["space"]["size"][0] for config, _ in worlds}) == 40
    assert web(3, label) == worlds[3]
    assert sum(drawn["plant"] != WEBS[0][0] for _, drawn in worlds) >= 20


@pytest.mark.slow
def test_six_variants_are_told_apart(tmp_path: Path) -> None:
    record = why.STUDY.execute(short=True, results=tmp_path)
    right = sum(c["case"]["label"] == c["result"]["said"] for c in record["cases"])
    assert len(record["cases"]) == len(CLASSES)
    assert right >= 5


def test_the_kept_result_is_right_in_four_of_five() -> None:
    test = json.loads((RESULTS / "why.json").read_text())["cases"]
    assert {label: sum(c["case"]["label"] == label for c in test) for label in CLASSES} == dict.fromkeys(
        CLASSES, 10
    )
    assert sum(c["case"]["label"] == c["result"]["said"] for c in test) >= 0.8 * len(test)
    assert sum(c["result"]["drawn"]["plant"] != WEBS[0][0] for c in test) >= 0.5 * len(test)
