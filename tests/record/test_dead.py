"""What a record keeps of the dying."""

import numpy as np

from ecs_eco import World
from ecs_eco.components import Metabolism, Position
from ecs_eco.record.dead import dead, total


def test_each_of_the_dying_is_kept_with_place_energy_age_cause_and_flows_in_the_order_given():
    world = World((10, 10))
    table = world.add_table("ant", Position, Metabolism)
    for i in range(5):
        world.spawn("ant", Position(x=i, y=2 * i), Metabolism(energy=0.5 + i))
    world.flush()
    m = table[Metabolism]
    m.taken[:5], m.burnt[:5], m.given[:5] = range(5), range(10, 15), range(20, 25)
    table.cause[[3, 1]], table.killer[3], table.born[1] = 7, 42, -4
    died = np.zeros(256, np.int32)
    one = dead(table, np.array([3, 1]), 6, 0.5, died)
    assert one.uid.tolist() == [4, 2]
    assert (one.x.tolist(), one.y.tolist(), one.z.tolist()) == ([3, 1], [6, 2], [0, 0])
    assert (one.energy.tolist(), one.age.tolist()) == ([3.5, 1.5], [3.0, 5.0])
    assert (one.cause.tolist(), one.killer.tolist()) == ([7, 7], [42, 0])
    assert one.sums.tolist() == [4.0, 24.0, 44.0, 5.0]
    assert died.nonzero()[0].tolist() == [7]
    assert died[7] == 2
    assert total(one.energy) == 5.0


def test_what_the_table_lacks_is_zero():
    world = World((10, 10))
    table = world.add_table("stone")
    world.spawn("stone", n=2)
    world.flush()
    one = dead(table, np.array([0, 1]), 0, 1.0, np.zeros(256, np.int32))
    assert one.uid.tolist() == [1, 2]
    assert not any(a.any() for a in (one.x, one.y, one.z, one.energy, one.sums))
