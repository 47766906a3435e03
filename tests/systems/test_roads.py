"""Roads: those on them are faster or slower, and pay more or less."""

import numpy as np
import pytest

from ecs_eco.components import Position, Velocity
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.space import Space, Terrain
from tests.systems.interventions import world
from tests.systems.test_fences import go, walkers

ROAD = {"kind": "road", "at": 0, "line": [[10.0, 30.0], [50.0, 30.0]], "width": 4.0, "pace": 2.0, "cost": 0.5}
ALONE = {"species.deer.count": 3, "species.deer.reproduction.rate": 0.0}


def _walked(w):
    """Let three deer run for a tick, on the road, beside it, and on it; return the ways and costs."""
    w.run(1)
    deer = walkers(w, [20.0, 20.0, 35.0], [30.0, 36.0, 31.0], 0.0)
    go(w, 1)
    rows = deer.by_uid()[:3]
    return deer[Position].x[rows] - [20, 20, 35], deer[Velocity].cost[rows]


@pytest.mark.definition("4 space")
def test_who_is_on_a_road_goes_by_its_pace_and_pays_by_its_cost():
    way, cost = _walked(world(ROAD, **ALONE))
    assert way == pytest.approx([2 * way[1], way[1], 2 * way[1]], rel=1e-5)
    assert cost == pytest.approx([cost[1] / 2, cost[1], cost[1] / 2], rel=1e-5)
    assert cost[1] > 0


def test_a_road_that_is_taken_away_is_no_more():
    plan = [ROAD, {"kind": "road", "at": 0, "remove": True}]
    way, _ = _walked(world(*plan, **ALONE))
    assert way == pytest.approx([way[1]] * 3, rel=1e-5)


def test_roads_cover_the_cells_on_the_strip_and_those_of_the_line():
    terrain = Terrain(
        Space((10, 10)),
        1.0,
        roads=[
            {"line": [[1.5, 4.0], [5.5, 4.0]], "width": 2.0, "pace": 2.0, "cost": 0.5},
            {"line": [[0.2, 9.5], [9.8, 9.5]], "width": 0.1, "pace": 0.5, "cost": 3.0},
        ],
    )
    on = np.argwhere(terrain.pace == 2)
    assert on[:, 0].min() == 3
    assert on[:, 0].max() == 4
    # centres within one metre of the line from 1.5 to 5.5, .5 above and below: .87 beyond its ends
    assert sorted(set(on[:, 1].tolist())) == [1, 2, 3, 4, 5]
    assert (terrain.pace[9] == 0.5).all()
    assert (terrain.toll[9] == 3).all()
    assert (terrain.toll[:3] == 1).all()


def test_a_road_goes_on_around_a_torus():
    terrain = Terrain(Space((10, 10)), 1.0)
    terrain.pave(np.array([[5.0, 0.0], [9.0, 0.0]]), 2.0, 2.0, 1.0)
    assert (terrain.pace[[0, 9], 7] == 2).all()


def test_resumed_worlds_keep_their_roads(tmp_path):
    from ecs_eco import World

    one = world(ROAD, **{"species.deer.count": 20})
    one.run(3)
    two = World.restore(one.save(tmp_path / "roads.safetensors"))
    assert [r.line.tolist() for r in two.terrain.roads] == [ROAD["line"]]
    assert (two.terrain.pace == one.terrain.pace).all()
    assert two.run(5).digest() == one.run(5).digest()


def test_a_road_makes_another_digest():
    one, two = (world(*plan, **{"species.deer.count": 0}).run(2) for plan in ([], [ROAD]))
    assert one.digest() != two.digest()


@pytest.mark.parametrize(
    ("road", "fault"),
    [
        ({"line": [[10.0, 30.0], [70.0, 30.0]]}, "outside the world"),
        ({"line": None}, "is missing"),
        ({"remove": True}, "no such road"),
        ({"pace": 0.0}, "pace"),
    ],
)
def test_roads_that_cannot_be_are_refused(road, fault):
    with pytest.raises(ConfigError, match=fault):
        world({k: v for k, v in (ROAD | road).items() if v is not None})


def test_roads_may_lie_there_from_the_start():
    line = {k: v for k, v in ROAD.items() if k not in ("kind", "at")}
    config = load(
        {
            "format": 1,
            "name": "trail",
            "space": {"size": [60.0, 60.0]},
            "terrain": {"roads": [line]},
            "species": {"ox": {"count": 1, "body": {"radius": 1.0}}},
        }
    )
    from ecs_eco import World

    assert (World.from_config(config).terrain.pace == 2).sum() > 100
