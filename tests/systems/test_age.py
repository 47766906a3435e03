from ecs_eco.components import Biology
from ecs_eco.systems import Age
from ecs_eco.testing import act, arrange


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
