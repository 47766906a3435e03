"""What is wired on the island: thirst, breath, frost, carcasses that ravens eat."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Chemistry, Metabolism, Nervous, Physical, Position, Velocity
from ecs_eco.config import load

NOBODY = {f"species.{name}.count": 0 for name in ("tree", "grass", "deer", "wolf", "raven")}


def _island(**changes):
    return World.from_config(load("island", NOBODY | changes), policies="untrained", seed=5, record=False)


def _substance(world, name):
    return world.substances.index(name)


def _fed(world, ticks):
    """Run so many ticks in which no deer is hungry."""
    for _ in range(ticks):
        world.tables["deer"][Metabolism].energy[:] = 1.0
        world.run(1)


@pytest.mark.slow
def test_a_parched_deer_walks_to_the_lake_and_drinks():
    world = _island(
        **{
            "species.deer.count": 1,
            "species.deer.reproduction.rate": 0.0,
            "species.deer.metabolism.basal": 0.0,
            "species.deer.heat.regulate.cost": 0.0,
        }
    )
    deer, water = world.tables["deer"], _substance(world, "water")
    _fed(world, 200)  # until the humid air of the lake has spread
    row = deer.rows()[0]
    lake = load("island").terrain.lakes[0]
    deer[Position].x[row], deer[Position].y[row] = lake.at[0] + lake.radius + 25, lake.at[1]
    deer[Chemistry].molarity[row, water] = 0.7
    for _ in range(100):
        _fed(world, 1)
        if deer[Chemistry].molarity[row, water] > 1.0:
            break
    assert deer[Chemistry].molarity[row, water] > 1.0
    assert np.hypot(deer[Position].x[row] - lake.at[0], deer[Position].y[row] - lake.at[1]) < lake.radius + 8


def test_running_takes_the_breath_away_and_who_has_none_cannot_run():
    world = _island(**{"species.wolf.count": 12})
    wolf, oxygen = world.tables["wolf"], _substance(world, "oxygen")
    rows, nerves = wolf.rows(), wolf.species.nerves
    wolf[Chemistry].molarity[rows[:6], oxygen] = 0.05
    world.run(1)
    runs = nerves.doing(wolf, "run")[rows]
    assert not runs[:6].any()
    breathless = wolf[Nervous].decision[rows[:6], nerves.column("run")]
    assert (breathless <= 0).all()
    before = wolf[Chemistry].molarity[rows[6:], oxygen].copy()
    world.run(1)
    ran = nerves.doing(wolf, "run")[rows[6:]]
    after = wolf[Chemistry].molarity[rows[6:], oxygen]
    assert (after[ran] < before[ran]).all()
    assert (after[~ran] >= before[~ran]).all()
    assert wolf[Velocity].speed[rows[:6]].max() <= 0.7 + 1e-6  # they walk at most


@pytest.mark.parametrize(("season", "cold"), [(0.33, False), (0.83, True)])
def test_a_deer_without_a_coat_freezes_in_winter_and_not_in_summer(season, cold):
    world = _island(
        **{
            "species.deer.count": 5,
            "species.deer.reproduction.rate": 0.0,
            "species.deer.heat.insulation": 0.0,
            "year.start": season,
            "species.deer.heat.regulate.warming": 1.0,
            "species.deer.metabolism.energy": 1.0,
        }
    )
    deer = world.tables["deer"]
    _fed(world, 120)
    assert deer.n == (0 if cold else 5)
    assert cold or (deer[Physical].temperature[deer.rows()] > 305).all()


def test_a_raven_eats_a_carcass_and_gives_its_nitrogen_to_the_soil():
    world = _island(
        **{
            "species.deer.count": 30,
            "species.raven.count": 30,
            "space.size": [40.0, 40.0],
            "terrain.lakes.0.at": [8.0, 8.0],
            "terrain.lakes.0.radius": 4.0,
            "species.deer.metabolism.energy": 0.01,
        }
    )
    soil = world.fields["soil"].held()
    world.run(10)
    assert world.tables["deer"].n == 0  # starved
    lying = world.tables["carcass"].n
    assert lying > 0
    world.run(60)
    assert world.tables["carcass"].n < lying
    assert world.fields["soil"].held() > soil
