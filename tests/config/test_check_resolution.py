"""Steps that float32 rounds away are refused."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Metabolism
from ecs_eco.config import load
from ecs_eco.config.checks.resolution import resolution
from ecs_eco.debug import DebugError
from ecs_eco.engine.errors import ConfigError


@pytest.mark.parametrize("value", [1e-30, 1.0, 50.0, 240.0, 2.0**23, 1e7, 1e8, 3e38])
def test_the_resolution_is_that_of_float32(value):
    below = np.nextafter(np.float32(value), np.float32(0))
    assert resolution(value) == float(np.float32(value) - below)


RICH = {"species.deer.metabolism.energy_max": 1e8}
WIDE = {"space.size": [1e7, 1e7], "space.cell": 1e4}
REFUSED = {
    "species.deer.metabolism.basal": (
        RICH | {"species.deer.metabolism.basal": 3.0},
        "at least 64 per second",
    ),
    "species.deer.locomotion.speed": (WIDE | {"species.deer.locomotion.speed.walk": 0.4}, "at least 8 m/s"),
    "species.deer.locomotion.cost": (
        RICH | {"species.deer.locomotion.cost.walk": 3.0},
        "at least 64 per second",
    ),
    "species.grass.metabolism.photosynthesis": (
        {"species.grass.metabolism.energy_max": 1e8, "species.grass.metabolism.photosynthesis": 3.0},
        "at least 64 per second",
    ),
    "species.deer.locomotion.turn": (
        {"dt": 1e-4, "species.deer.locomotion.turn": 0.03},
        "at least 0.0381 rad/s",
    ),
    "fields.grass_smell.decay": ({"fields.grass_smell.decay": 4e-7}, "at least 4.77e-07 per second"),
    "species.deer.diet.0.gain": (RICH | {"species.deer.diet.0.gain": 3.0}, "at least 64;"),
}


@pytest.mark.parametrize("key", REFUSED)
def test_steps_that_are_rounded_away_are_refused(key):
    changes, allowed = REFUSED[key]
    with pytest.raises(ConfigError) as error:
        load("predator-prey", changes)
    problem = next(p for p in error.value.problems if ".".join(map(str, p.key)).startswith(key))
    assert "round to 0" in problem.what
    assert allowed in problem.allowed


def test_debug_mode_says_where_energy_no_longer_falls(monkeypatch):
    monkeypatch.setenv("ECS_ECO_DEBUG", "1")
    world = World.from_config("predator-prey", policies="random")
    deer = world.tables["deer"]
    deer[Metabolism].energy[3] = 1e8
    lost = (
        r"Metabolism.energy of uid \d+ \(row 3\) is 100000000.0, where a step of .* is lost to rounding; "
        r"the smallest float32 step there is 8"
    )
    with pytest.raises(DebugError, match=lost):
        world.run(1)
