"""Who eats how much of whom: a living world and its record say the same."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.view.flows import by_meals
from ecs_eco.view.live import Live
from ecs_eco.view.past import Past
from ecs_eco.view.replay import Replay

GOATS = {
    "space.size": [30, 30],
    "species.goat.count": 40,
    "species.green.count": 150,
    "species.yellow.count": 80,
    "species.red.count": 10,
}


@pytest.fixture(scope="module")
def replay(tmp_path_factory):
    out = tmp_path_factory.mktemp("flows") / "run"
    run_to_folder(
        load("reflexes", GOATS), seed=3, ticks=60, out=out, policies="untrained", learn=False, report=False
    )
    return Replay(out)


def watched(ticks, every):
    """A living world's points, one every so many ticks."""
    live = Live(World.from_config(load("reflexes", GOATS), seed=3, policies="untrained", learn=False))
    for _ in range(0, ticks, every):
        live.sample()
        live.world.run(every)
        live.passed()
    live.sample()
    return live.series(-1)


def test_a_living_world_and_its_record_say_the_same(replay):
    recorded, living = replay.series(-1), watched(60, 10)
    assert recorded["flows"]["goat"].keys() == living["flows"]["goat"].keys()
    assert "shared" not in recorded
    for what in ("eaten: green", "eaten: yellow", "burnt", "taken in", "lost"):
        each, again = (of["flows"]["goat"][what] for of in (recorded, living))
        assert again[2:] == pytest.approx(each[1:], rel=1e-5, abs=1e-9), what  # of ticks 1 to 59


def test_what_it_gained_from_foods_is_what_it_took_in(replay):
    flows = replay.series(-1)["flows"]["goat"]
    foods = np.sum([line[1:] for what, line in flows.items() if what.startswith("eaten: ")], axis=0)
    assert foods == pytest.approx(flows["taken in"][1:], abs=1e-4)


def test_a_record_of_before_shares_energy_among_foods_by_meals(replay, monkeypatch):
    groups = [
        group._replace(names=tuple(n for n in group.names if not n.startswith("eaten: ")))
        for group in replay.recording.series.groups
    ]
    replay = Replay(replay.recording.path)
    monkeypatch.setattr(replay.recording.series, "groups", groups)
    replay.past = Past(replay.recording)
    said = replay.series(-1)
    assert said["shared"] is True
    goat = said["flows"]["goat"]
    assert "eaten: yellow" not in goat  # what it gains by is known to be green alone
    ate = np.array(said["causes"]["green"]["eaten by goat"][1:]) > 0
    gained = np.array(goat["eaten: green"][1:])
    assert gained[ate] == pytest.approx(np.array(goat["taken in"][1:])[ate])
    assert not gained[~ate].any()


def test_meals_are_shares_of_what_was_taken_in():
    shares = by_meals(np.array([6.0, 4.0, 0.0]), np.array([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]))
    assert shares.tolist() == [[2.0, 0.0, 0.0], [4.0, 0.0, 0.0]]


def test_a_world_that_is_not_recorded_says_nothing_of_flows():
    live = Live(World.from_config(load("reflexes", GOATS), seed=3, policies="untrained", record=False))
    live.sample()
    live.world.run(2)
    live.passed()
    live.sample()
    assert "flows" not in live.series(-1)
