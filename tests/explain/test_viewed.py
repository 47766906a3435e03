"""Sweeps in the viewer: entries of its story, and a second world without their allele."""

import json
from dataclasses import asdict

import pytest

from ecs_eco import World
from ecs_eco.explain import Edit
from ecs_eco.explain.viewed import sweeps_in
from ecs_eco.view.pair import Pair
from ecs_eco.view.replay import Replay
from tests.explain.newts import WORLD, recorded

HUNGRY = Edit("newt", "letter", "hunger", 0, "B", "A")
SWEEP = {"species": "newt", "lead": "letter B", "gene": "hunger", "first": 0.2, "last": 0.9, "half": 2}
SENTENCES = ["It rose.", "It rose together with nothing.", "In 2 forks, it did."]


def test_a_sweep_is_in_the_story_and_opens_a_world_without_its_allele(tmp_path):
    run = recorded(tmp_path / "run", ticks=3)
    sweeps = [SWEEP | {"sentences": SENTENCES, "edit": edit} for edit in (asdict(HUNGRY), None)]
    (run / "explain.json").write_text(json.dumps({"sweeps": sweeps}))
    pair = Pair(Replay(run), sweeps=sweeps_in(run))
    (story,) = [message for message in pair.greeting() if message["kind"] == "story"]
    first, second = [entry for entry in story["entries"] if entry["kind"] == "sweep"]
    assert (first["tick"], first["colour"], first["sweep"]) == (2, "gene:hunger", 0)
    assert first["text"] == "letter B of newt rose from 20% to 90%"
    assert first["cause"] == "It rose together with nothing. In 2 forks, it did."
    assert "sweep" not in second
    pair.handle({"kind": "seek", "tick": 1})
    (said,) = pair.handle({"kind": "whatif", "tick": None, "sweep": 0})
    assert said["text"] == "branched at tick 1: all newt lose letter B"
    pair.second.follow(60)
    table = pair.second.source.world.table("newt")
    assert table.n == pair.first.counts()["newt"]
    origin = World.from_config(WORLD, seed=1, record=False).table("newt")
    pair.handle({"kind": "seek", "tick": 2})
    pair.second.follow(60)
    assert pair.second.tick == 2
    assert (table.born[HUNGRY.carriers(table)[0]] == 2).all()  # by mutation, after the change
    assert len(HUNGRY.carriers(table)[0]) < len(HUNGRY.carriers(origin)[0]) / 4
    assert pair.second.told["recipe"] is None
    for wrong in (1, 2, -1, "0", True):
        with pytest.raises(ValueError, match="expected a sweep with effects of its allele"):
            pair.handle({"kind": "whatif", "sweep": wrong})


@pytest.mark.parametrize("text", ["", "[]", '{"sweeps": [{}]}', "[" * 9999])
def test_a_damaged_explanation_shows_no_sweeps(tmp_path, text):
    assert sweeps_in(tmp_path) == []
    (tmp_path / "explain.json").write_text(text)
    assert sweeps_in(tmp_path) == []
