import math

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Metabolism
from ecs_eco.systems import Decay
from ecs_eco.systems.decay import rot
from ecs_eco.testing import act, check_system
from ecs_eco.testing.stores import Stores


def _cheeses(**store):
    return World.from_config(
        {
            "format": 1,
            "name": "larder",
            "space": {"size": [10.0, 10.0]},
            "dt": 0.5,
            "objects": {"cheese": {"count": 2, "body": {"radius": 0.1}, "energy": store}},
            "species": {"mouse": {"count": 0, "body": {"radius": 0.1}}},
        }
    )


def test_what_is_kept_rots_by_its_share_in_each_second():
    world = _cheeses(initial=8.0, decay=math.log(4.0))  # half of it in half a second
    act(world, Decay)
    act(world, Decay)
    m = world.tables["cheese"][Metabolism]
    assert m.energy[:2] == pytest.approx([2.0, 2.0])
    assert m.burnt[:2] == pytest.approx([6.0, 6.0])


def test_it_is_no_more_when_its_time_is_over():
    world = _cheeses(initial=8.0, decay=math.log(4.0), left=0.125)  # three ticks
    stores, numbers, burnt = Stores(world), [], []
    for _ in range(4):
        numbers.append(world.run(1).tables["cheese"].n)
        stores.note()
        burnt.append(stores.ledger["cheese"]["burnt"])
    assert numbers == [2, 2, 2, 0]
    assert burnt == pytest.approx([8, 12, 14, 15])
    assert stores.ledger["cheese"]["lost"] == pytest.approx(1)
    assert stores.ledger["cheese"]["stock_after"] == 0
    assert "decayed" in world.causes


def test_what_does_not_decay_keeps_its_energy():
    world = _cheeses(initial=8.0)
    world.run(20)
    assert world.tables["cheese"][Metabolism].energy[:2].tolist() == [8, 8]


def test_the_kernel_is_its_slow_twin():
    rng = np.random.default_rng(4)
    alive, born = rng.random(30) < 0.7, rng.integers(0, 9, 30)
    energy, burnt = rng.random(30).astype(np.float32), rng.random(30).astype(np.float32)
    cause, before = rng.integers(0, 2, 30).astype(np.uint8), (energy.copy(), burnt.copy())
    dead = cause.copy()
    rot(alive, born, 10, 4.5, np.float32(0.25), 7, energy, burnt, cause)
    assert energy == pytest.approx(np.where(alive, 0.75 * before[0], before[0]), abs=1e-6)
    assert burnt == pytest.approx(np.where(alive, before[1] + 0.25 * before[0], before[1]), abs=1e-6)
    assert cause.tolist() == np.where(alive & (dead == 0) & (10 - born >= 4.5), 7, dead).tolist()


def test_the_system_conforms():
    check_system(Decay, lambda threads: _cheeses(initial=1.0, decay=0.1))
