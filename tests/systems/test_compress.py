import numpy as np
import pytest

from ecs_eco.components import Physical
from ecs_eco.systems import Compress
from ecs_eco.systems.compress import equalise
from ecs_eco.testing import act, arrange

DIVER = {"properties": {"pressure": 101_325.0},
         "lethal": [{"property": "pressure", "max": 200_000.0, "high": "crushed"}]}
SEA = {"space": {"size": [20.0, 20.0, 50.0], "edges": "walls"}, "water": {"density": 1000.0}}


def test_pressure_is_that_of_the_depth_and_kills(meadow):
    world = meadow(count=3, world=SEA, **DIVER)
    arrange(world, "deer", z=[40.0, 39.0, 49.9999])
    act(world, Compress)
    pressure = world.tables["deer"][Physical].pressure[:3]
    assert pressure[:2] == pytest.approx([101_325 + 98_100, 101_325 + 107_910], rel=1e-6)
    died = []
    world.on_death.append(lambda table, rows: died.extend(world.causes[c - 1] for c in table.cause[rows]))
    world.run(1)
    assert (died, world.tables["deer"].n) == (["crushed"], 2)


def test_a_pressure_that_cannot_kill_stays_as_it_was_at_birth(meadow):
    world = meadow(world=SEA, properties={"pressure": 13_000.0})
    act(world, Compress)
    assert world.tables["deer"][Physical].pressure[:2].tolist() == [13_000, 13_000]


def test_a_limit_set_in_a_living_world_is_felt(meadow):
    world = meadow(world=SEA, properties={"pressure": 101_325.0})
    arrange(world, "deer", z=[10.0, 45.0])
    limits = [{"property": "pressure", "max": 200_000.0, "high": "crushed"}]
    world.intervene({"kind": "set", "set": {"species.deer.lethal": limits}})
    world.run(1)
    assert world.tables["deer"].n == 1


def test_worlds_without_pressure_have_no_such_system(meadow):
    assert Compress not in [type(system) for system in meadow().systems]


def test_the_kernel_is_its_slow_twin():
    rng = np.random.default_rng(1)
    alive, around, pressure = rng.random(30) < 0.5, *rng.random((2, 30)).astype(np.float32)
    expected = np.where(alive, around, pressure)
    equalise(alive, around, pressure)
    assert (pressure == expected).all()
