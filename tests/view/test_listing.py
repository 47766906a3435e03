"""A table of organisms, sorted and filtered, and points of two of their values."""

import json

import numpy as np
import pytest

from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.view.listing import POINTS, ROWS, scatter, table
from ecs_eco.view.live import Live
from ecs_eco.view.replay import Replay
from tests.view.parks import SMALL, small

HERD = {
    "uid": np.arange(1, 251, dtype=np.uint64),
    "energy": np.linspace(1, 0, 250, dtype=np.float32),
    "happiness": np.where(np.arange(250) % 2, np.nan, 0.5),
}


def herd(name):
    return HERD if name == "deer" else {"uid": np.arange(9, dtype=np.uint64)}


def ask(**request):
    return table(herd, ["deer", "grass"], {"species": "deer"} | request)


def test_rows_come_in_the_order_of_a_column_either_way():
    up, down = ask(sort="energy"), ask(sort="energy", down=True)
    assert up["columns"]["uid"] == list(range(250, 250 - ROWS, -1))
    assert down["columns"]["uid"] == list(range(1, ROWS + 1))
    assert (up["n"], up["found"]) == (250, 250)
    assert ask(**{"sort": "energy", "from": 240})["columns"]["uid"] == list(range(10, 0, -1))


def test_unknown_values_stand_at_the_end_either_way():
    for down in (False, True):
        shown = ask(sort="happiness", down=down)["columns"]["happiness"]
        assert None not in shown
        assert None in ask(**{"sort": "happiness", "down": down, "from": 100})["columns"]["happiness"]


def test_comparisons_keep_those_for_which_all_hold():
    found = ask(where="energy < 0.5, uid <= 200")
    assert found["found"] == 200 - 125
    assert min(found["columns"]["uid"]) == 126
    assert ask(where="uid = 7 and energy >= 0")["columns"]["uid"] == [7]
    assert ask(where="  ")["found"] == 250


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        ({"species": "dear"}, "did you mean 'deer'"),
        ({"sort": "enery"}, "did you mean 'energy'"),
        ({"where": "enrgy < 1"}, "did you mean 'energy'"),
        ({"where": "energy"}, "expected comparisons such as"),
        ({"where": "energy < 1.2.3"}, "not a number"),
        ({"from": -1}, "a whole number"),
    ],
)
def test_what_is_not_known_is_refused_with_what_is(request_, words):
    with pytest.raises(ValueError, match=words):
        ask(**request_)


def test_points_are_of_all_that_have_both_values_and_not_too_many():
    HERD["many"] = HERD["energy"]
    points = scatter(herd, ["deer", "grass"], {"x": "energy", "y": "happiness"})
    assert list(points["points"]) == ["deer"]
    assert len(points["points"]["deer"]["x"]) == 125 <= POINTS
    assert set(points["points"]["deer"]["y"]) == {0.5}
    with pytest.raises(ValueError, match="did you mean 'energy'"):
        scatter(herd, ["deer", "grass"], {"x": "enrgy", "y": "energy"})


def test_a_living_world_lists_its_organisms_and_is_not_changed():
    world, alone = small().run(3), small().run(3)
    live = Live(world)
    (answer,) = live.handle({"kind": "table", "species": "deer", "sort": "energy", "where": "age >= 3"})
    json.dumps(answer, allow_nan=False)
    assert {"uid", "born", "family", "energy", "happiness", "age", "x", "y"} == set(answer["columns"])
    energy = answer["columns"]["energy"]
    assert energy == sorted(energy)
    uid = answer["columns"]["uid"][0]
    assert live.organism(uid)["energy"] == pytest.approx(energy[0], rel=1e-4)
    (points,) = live.handle({"kind": "scatter", "x": "age", "y": "energy"})
    assert {"grass", "deer", "wolf"} == set(points["points"])
    assert world.digest() == alone.digest()


def test_a_recorded_run_lists_those_of_its_tick(tmp_path):
    run_to_folder(
        load("predator-prey", SMALL), seed=5, ticks=6, out=tmp_path / "run", policies="random", report=False
    )
    replay = Replay(tmp_path / "run")
    replay.handle({"kind": "seek", "tick": 4})
    (answer,) = replay.handle({"kind": "table", "species": "wolf", "sort": "uid"})
    assert answer["columns"]["uid"] == replay.organisms("wolf").uid.tolist()
    assert answer["n"] == replay.counts()["wolf"]
    assert replay.frame(1, "family") != replay.frame(1, "species")
    (refused,) = replay.handle({"kind": "scatter", "x": "age", "y": "x"})[:1]
    assert refused["points"]["wolf"]["x"]
