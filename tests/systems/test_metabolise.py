import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Metabolism, Velocity
from ecs_eco.systems import Decide, Feed, Metabolise, Sense
from ecs_eco.systems.metabolise import burn
from ecs_eco.testing import act, arrange

F = np.float32


def test_living_and_moving_are_paid_by_the_second(meadow):
    world = meadow(world={"dt": 0.5}, metabolism={"basal": 0.125})
    deer = arrange(world, "deer", energy=[1, 0.5], cost=[0.25, 0], digesting=[1, 3])
    act(world, Metabolise)
    m = deer[Metabolism]
    assert m.energy[:2].tolist() == [0.8125, 0.4375]
    assert m.burnt[:2].tolist() == [0.1875, 0.0625]
    assert m.digesting[:2].tolist() == [0, 2]
    assert deer[Velocity].cost[:2].tolist() == [0.25, 0]


def test_what_cannot_be_paid_stays_owed(meadow):
    world = meadow(metabolism={"basal": 0.25})
    deer = arrange(world, "deer", energy=[0.125, 0.25])
    act(world, Metabolise)
    assert deer[Metabolism].energy[:2].tolist() == [-0.125, 0]
    world.run(1)
    assert world.tables["deer"].n == 0


def test_who_does_not_burn_keeps_its_energy(meadow):
    world = meadow()
    act(world, Metabolise)
    assert world.tables["grass"][Metabolism].energy[:2].tolist() == [0.5, 0.5]


def test_the_kernel_is_its_slow_twin():
    rng = np.random.default_rng(2)
    n = 40
    alive = rng.random(n) < 0.6
    cost, energy, burnt = (rng.random(n).astype(F) for _ in range(3))
    digesting = rng.integers(0, 3, n, np.int32)
    before = [a.copy() for a in (energy, digesting, burnt)]
    scale = rng.random(n).astype(F)
    burn(0, n, alive, scale, cost, True, F(0.1), F(0.5), F(-np.inf), energy, digesting, burnt)
    paid = np.where(alive, (0.1 * scale + cost) * 0.5, 0)
    assert energy == pytest.approx(before[0] - paid, abs=1e-6)
    assert burnt == pytest.approx(before[2] + paid, abs=1e-6)
    assert digesting.tolist() == np.where(alive, np.maximum(before[1] - 1, 0), before[1]).tolist()


def test_who_burns_nothing_digests_all_the_same(meadow):
    trap = {
        "count": 1,
        "body": {"radius": 0.5},
        "metabolism": {"energy": 0.5, "handling_time": 2.0},
        "diet": [{"eats": "grass", "gain": 0.1}],
        "sensors": [{"kind": "own", "property": "energy"}],
        "actions": {"eat": ["eat"]},
        "always_on": ["eat"],
    }
    world = meadow(world={"species": {"trap": trap}})
    arrange(world, "trap", digesting=2)
    act(world, Metabolise)
    assert world.tables["trap"][Metabolism].digesting[0] == 1


def test_a_single_one_in_the_smallest_of_tables_pays_for_moving():
    world = World((10, 10))
    table = world.add_table("hermit", Metabolism, Velocity, capacity=1)
    world.spawn("hermit", Metabolism(energy=1), Velocity(cost=0.25))
    world.flush()
    world.add_system(Metabolise())
    world.run(1)
    assert (table.capacity, table[Metabolism].energy[0]) == (1, 0.75)


def test_digestion_ends_after_as_many_ticks_as_it_lasts(meadow):
    world = meadow(
        world={"dt": 0.1}, count=1, grass={"count": 1}, metabolism={"handling_time": 400.0, "energy": 0.5}
    )
    deer = arrange(world, "deer", x=5, y=5, energy=0.5)
    arrange(world, "grass", x=5, y=5)
    for system in (Sense, Decide, Feed):
        act(world, system)
    left, passed = deer[Metabolism].digesting, 0
    while left[deer.rows()[0]] > 0:
        act(world, Metabolise)
        passed += 1
    assert passed == 4000
