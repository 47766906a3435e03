import numpy as np
import pytest

from ecs_eco.components import Physical
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import Compress
from ecs_eco.systems.compress import equalise
from ecs_eco.testing import act, arrange

DIVER = {
    "body": {"compressible": True},
    "properties": {"pressure": 101_325.0},
    "lethal": [{"property": "pressure", "max": 200_000.0, "cause_above": "crushed"}],
}
SEA = {"space": {"size": [20.0, 20.0, 50.0], "edges": "walls"}, "water": {"density": 1000.0}}


@pytest.mark.definition("1 pressure", "3 physical rules", "3 staying alive")
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


def test_a_pressure_that_is_not_said_to_follow_stays_as_it_was_at_birth(meadow):
    limits = [{"property": "pressure", "max": 20_000.0, "cause_above": "burst"}]  # of the blood
    world = meadow(world=SEA, properties={"pressure": 13_000.0}, lethal=limits).run(3)
    deer = world.tables["deer"]
    assert deer[Physical].pressure[deer.rows()].tolist() == [13_000, 13_000]


def test_objects_are_compressed_too(meadow):
    float_ = {
        "at": [[5.0, 5.0, 40.0]],
        "body": {"radius": 0.5, "compressible": True},
        "properties": {"pressure": 101_325.0},
    }
    world = meadow(world=SEA | {"objects": {"float": float_}})
    act(world, Compress)
    assert world.tables["float"][Physical].pressure[0] == pytest.approx(101_325 + 98_100)


def test_a_compressible_body_needs_a_pressure_and_stays_one(meadow):
    with pytest.raises(ConfigError, match=r"deer\.properties\.pressure\n  is missing"):
        meadow(body={"compressible": True})
    world = meadow(world=SEA, **DIVER)
    with pytest.raises(ConfigError, match=r"compressible.*\n.*cannot change during a run"):
        world.intervene({"kind": "set", "set": {"species.deer.body.compressible": False}})


def test_worlds_without_compressible_bodies_have_no_such_system(meadow):
    assert Compress not in [type(system) for system in meadow().systems]


def test_the_kernel_is_its_slow_twin():
    rng = np.random.default_rng(1)
    alive, around, pressure = rng.random(30) < 0.5, *rng.random((2, 30)).astype(np.float32)
    expected = np.where(alive, around, pressure)
    equalise(alive, around, pressure)
    assert (pressure == expected).all()
