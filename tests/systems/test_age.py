import numpy as np
import pytest

from ecs_eco.components import Biology
from ecs_eco.systems import Age
from ecs_eco.systems.age import grow_old
from ecs_eco.testing import act, arrange


@pytest.mark.definition("1 age")
def test_everyone_is_dt_older_after_a_tick(meadow):
    world = meadow(world={"dt": 0.5})
    deer = arrange(world, "deer", age=[0, 10])
    act(world, Age)
    assert deer[Biology].age[:2].tolist() == [0.5, 10.5]
    assert world.tables["grass"][Biology].age[:2].tolist() == [0.5, 0.5]


def test_a_newborn_is_of_age_zero(meadow):
    world = meadow().run(3)
    world.kill(int(world.tables["deer"].uid[0]))
    world.flush()
    world.spawn("deer")
    world.flush()
    assert world.tables["deer"][Biology].age[:2].tolist() == [0, 3]


def test_an_age_of_many_small_steps_is_exact(meadow):
    world = meadow(world={"dt": 0.1})
    world.tick = 10_000_000
    deer = arrange(world, "deer", age=1e6)  # born at tick 0
    for _ in range(1000):
        act(world, Age)
        world.tick += 1
    # steps of .1 in float32 would be of .125 there
    assert deer[Biology].age[:2].tolist() == [np.float32(1_000_100.0)] * 2


def test_an_age_that_was_set_is_counted_from_there(meadow):
    world = meadow(world={"dt": 0.1})
    deer = world.tables["deer"]
    act(world, Age)
    deer[Biology].age[0] = 7.3
    for _ in range(200):
        world.tick += 1
        act(world, Age)
    assert deer[Biology].age[:2].tolist() == [np.float32(np.float32(7.3) + 200 * 0.1), np.float32(201 * 0.1)]


def test_the_kernel_agrees_with_its_plain_twin():
    generator = np.random.default_rng(1)
    alive, born = generator.random(50) < 0.8, generator.integers(0, 90, 50)
    age, head_start = generator.random(50).astype(np.float32) * 50, generator.random(50) * 10
    known = generator.random(50) < 0.5
    age[known] = np.float32((100 - born - 1) * 0.3 + head_start)[known]
    start = np.where(
        age == np.float32((100 - born - 1) * 0.3 + head_start), head_start, age - (100 - born - 1) * 0.3
    )
    expected = (
        np.where(alive, np.float32((100 - born) * 0.3 + start), age),
        np.where(alive, start, head_start),
    )
    grow_old(0, 50, alive, born, 100, 0.3, age, head_start)
    assert np.array_equal(age, expected[0])
    assert np.array_equal(head_start, expected[1])
