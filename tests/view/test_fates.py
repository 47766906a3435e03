"""Deaths of animals, with their places: what a page marks."""

import json

import pytest

from ecs_eco.components import Position
from ecs_eco.view.live import Live
from ecs_eco.view.player import Player
from ecs_eco.view.replay import Replay
from tests.view.parks import Page, small


def test_the_dead_are_told_once_with_their_places():
    world = small()
    live = Live(world)
    world.run(2)
    before = {
        int(u): (float(x), float(y))
        for t in (world.tables["deer"],)
        for u, x, y in zip(t.uid[t.rows()], t[Position].x[t.rows()], t[Position].y[t.rows()], strict=True)
    }
    world.intervene({"kind": "cull", "species": "deer", "count": 5})
    tick = world.tick
    world.run(1)
    told = [fate for fate in live.fates(-1) if fate[0] == tick and fate[2] in before]
    assert len(told) >= 5
    assert all(fate[3:5] == pytest.approx(before[fate[2]], abs=1.1) for fate in told)  # a step at the most
    assert {fate[1] for fate in told} == {live.species.index("deer")}
    assert live.fates(world.tick) == []
    json.dumps(live.fates(-1), allow_nan=False)


def test_plants_are_not_among_them_and_old_deaths_are_forgotten():
    world = small()
    live = Live(world)
    world.run(1)
    world.intervene({"kind": "cull", "species": "grass", "count": 50})
    world.intervene({"kind": "cull", "species": "wolf", "count": 12})
    tick = world.tick
    world.run(1)
    assert sum(fate[1] == live.species.index("wolf") for fate in live.fates(-1)) == 12
    assert not any(fate[1] == live.species.index("grass") for fate in live.fates(-1))
    world.run(6)
    assert all(fate[0] > tick for fate in live.fates(-1))


def test_a_page_gets_them_with_its_frames():
    world = small()
    player = Player(Live(world, 8), playing=False)
    page = Page(player, {3: {"kind": "cull", "species": "deer", "share": 0.5}})
    player.halted = lambda: world.tick >= 8 and page.ticks[-1:] == [8]
    player.source.run(player.turn)
    culled = [fate for message in page.got("fates") for fate in message["list"] if fate[0] == 3]
    assert 25 <= len({fate[2] for fate in culled}) == len(culled)


def test_a_recorded_run_tells_the_same(tmp_path):
    from ecs_eco.config import load
    from ecs_eco.record import run_to_folder
    from tests.view.parks import SMALL

    config = load("predator-prey", SMALL | {"species.deer.metabolism.energy": 0.01})  # they starve at once
    run_to_folder(config, seed=5, ticks=12, out=tmp_path / "run", policies="random", report=False)
    replay = Replay(tmp_path / "run")
    deaths = replay.recording.deaths.between(0, 11, ("tick", "uid", "species"))
    replay.handle({"kind": "seek", "tick": 6})
    told = {(fate[0], fate[2]) for fate in replay.fates(-1)}
    animals = [replay.recording.species.index(name) for name in ("deer", "wolf")]
    assert told == {
        (int(t), int(u))
        for t, u, s in zip(deaths["tick"], deaths["uid"], deaths["species"], strict=True)
        if 2 <= t <= 6 and s in animals
    }
    assert told
