import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError


def _orchard(**apple):
    return {
        "format": 1,
        "name": "orchard",
        "space": {"size": [50.0, 50.0]},
        "objects": {"apple": {"count": 400, "body": {"radius": 0.1}} | apple},
        "species": {"boar": {"count": 0, "body": {"radius": 0.5}}},
    }


def test_each_that_is_missing_comes_back_by_chance():
    world = World.from_config(_orchard(renewal=0.6931472))  # half of them in a second
    apples = world.tables["apple"]
    for uid in apples.uid[apples.rows()][:400].tolist():
        world.kill(uid)
    numbers = [world.run(1).tables["apple"].n for _ in range(12)]
    assert 160 < numbers[0] < 240
    assert 260 < numbers[1] < 340
    assert numbers[-1] >= 395
    assert max(numbers) <= 400


def test_they_come_back_anywhere():
    world = World.from_config(_orchard(renewal=1e9))
    before = world.tables["apple"][Position].x[:400].copy()
    for uid in world.tables["apple"].uid[:400].tolist():
        world.kill(uid)
    world.run(1)
    x = world.tables["apple"][Position].x[world.tables["apple"].rows()]
    assert x.size == 400
    assert 10 < x.std() < 20
    assert len(np.intersect1d(x, before)) < 5


def test_without_renewal_what_is_gone_stays_gone():
    world = World.from_config(_orchard())
    world.kill(int(world.tables["apple"].uid[0]))
    assert world.run(20).tables["apple"].n == 399


def test_renewal_may_begin_with_the_world_alone():
    world = World.from_config(_orchard())
    assert "Renew" not in [type(s).__name__ for s in world.systems]
    with pytest.raises(ConfigError, match="cannot change during a run"):
        world.intervene({"kind": "set", "set": {"objects.apple.renewal": 0.5}})


def test_renewal_may_change_while_a_world_lives():
    world = World.from_config(_orchard(renewal=1e-9))
    world.kill(int(world.tables["apple"].uid[0]))
    world.run(2)
    world.intervene({"kind": "set", "set": {"objects.apple.renewal": 1e9}})
    assert world.run(2).tables["apple"].n == 400


def test_renewal_without_a_number_is_refused():
    with pytest.raises(ConfigError, match=r"objects\.apple\.renewal"):
        load(_orchard(count=0, at=[[1.0, 1.0]], renewal=0.1))
