"""How far organisms see, as a page draws it."""

import math

import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.config import load
from ecs_eco.view.live import Live
from tests.view.parks import small


def of(live, name):
    return next(kind for kind in live.hello()["species"] if kind["name"] == name)


def test_a_page_learns_whom_each_species_sees_and_how_far():
    live = Live(small())
    seen = {(eye["kind"], *eye["targets"], eye["reach"]) for eye in of(live, "deer")["sees"]}
    assert seen == {("nearest", "grass", 6.0), ("nearest", "deer", 6.0), ("nearest", "wolf", 6.0)}
    assert all(eye["fov"] == pytest.approx(2 * math.pi) for eye in of(live, "deer")["sees"])
    assert "sees" not in of(live, "grass")
    assert of(live, "grass")["opaque"] is False
    assert "opaque" not in of(live, "deer")


def test_rays_say_how_many_they_are_and_where_they_point():
    world = World.from_config(load("island"), seed=1, policies="random", record=False)
    (eye,) = of(Live(world), "wolf")["sees"]
    assert eye["kind"] == "rays"
    assert eye["count"] > 1
    assert "deer" in eye["targets"]


def test_who_sees_by_light_sees_less_far_in_the_dark():
    world = World.from_config(
        load("diel-migration", {"species.krill.count": 5}), seed=1, policies="random", record=False
    )
    live = Live(world)
    (number,) = (eye["number"] for eye in of(live, "krill")["sees"] if eye["kind"] == "nearest")
    uid = int(world.tables["krill"].uid[world.tables["krill"].rows()[0]])
    reach = []
    for tick in (75, 225):  # noon, midnight
        world.tick = tick
        reach.append(live.organism(uid).get("reach", {})[str(number)])
    sensor = world.config.species["krill"].sensors[number]
    assert reach[1] == pytest.approx(sensor.blind, abs=0.01)
    assert sensor.blind < reach[0] <= sensor.range


def test_how_far_a_target_is_follows_from_its_reading_and_the_range():
    # a deer that stands still 3 m to the south of the only tuft
    world = World.from_config(
        load("predator-prey", {"species.grass.count": 1, "species.deer.count": 1, "species.wolf.count": 0}),
        seed=1,
        policies="random",
        record=False,
    )
    deer, tuft = (world.tables[name][Position] for name in ("deer", "grass"))
    deer.x[0], deer.y[0], deer.heading[0], tuft.x[0], tuft.y[0] = 50.0, 50.0, 0.0, 50.0, 53.0
    world.run(1)
    assert (
        "saw grass (food) 3.0 m to the left;"
        in Live(world).organism(int(world.tables["deer"].uid[0]))["sentence"]
    )
