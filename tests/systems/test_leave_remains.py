import numpy as np
import pytest

from ecs_eco.components import Body, Chemistry, Physical, Position
from ecs_eco.testing import arrange

WORLD = {
    "substances": {"salt": "", "water": ""},
    "objects": {"carcass": {"body": {"radius": 0.1, "mass": 1.0}}},
}
DEER = {
    "body": {"radius": 0.5, "mass": 60.0},
    "remains": "carcass",
    "properties": {"temperature": 310.0},
    "substances": {"water": 0.7, "salt": 0.1},
}


@pytest.fixture
def world(meadow):
    return meadow(world=WORLD, count=3, **DEER)


@pytest.mark.definition("3 remains")
def test_the_dead_leave_an_object_with_their_place_mass_and_substances(world):
    arrange(
        world,
        "deer",
        x=[1, 2, 3],
        y=[4, 5, 6],
        heading=0.5,
        energy=[0.5, -1, 0.5],
        temperature=[310, 290, 310],
        mass=[60, 55, 60],
    )
    arrange(world, "grass", x=15, y=15)
    uid = int(np.sort(world.tables["deer"].uid)[-2])
    born = []
    world.on_birth.append(lambda table, rows, parents, _: born.append((table.name, parents.tolist())))
    world.run(1)
    carcass = world.tables["carcass"]
    assert (world.tables["deer"].n, carcass.n) == (2, 1)
    p = carcass[Position]
    assert (p.x[0], p.y[0], p.heading[0]) == (2, 5, 0.5)
    assert (carcass[Body].radius[0], carcass[Body].mass[0]) == (0.5, 55)
    assert carcass[Physical].temperature[0] == 290
    assert carcass[Chemistry].molarity[0].tolist() == pytest.approx([0.1, 0.7])
    assert born == [("carcass", [uid])]  # the dead is its parent


def test_the_eaten_leave_nothing(world):
    uids = np.sort(world.tables["deer"].uid)[-3:].tolist()
    world.kill(uids[0], "eaten by wolf", killer=uids[1])
    world.kill(uids[1], "drowned")
    world.run(1)
    assert world.tables["carcass"].n == 1
    assert world.tables["deer"].n == 1


def test_also_the_culled_leave_a_body_when_killed_between_ticks_or_late_in_one(world):
    from ecs_eco import System

    class Cull(System):
        phase = "die"  # after all systems of the phase that were there before

        def process(self, *_):
            self.world.kill(max(self.world.tables["deer"].uid.tolist()))

    world.kill(max(world.tables["deer"].uid.tolist()))
    world.flush()
    assert world.tables["carcass"].n == 1
    world.add_system(Cull())
    world.run(1)
    assert world.tables["carcass"].n == 2


def test_who_leaves_no_remains_just_dies(meadow):
    world = meadow(world=WORLD | {"objects": {"carcass": {"count": 1, "body": {"radius": 0.1}}}})
    world.kill(int(world.tables["deer"].uid[0]))
    world.run(1)
    assert world.tables["carcass"].n == 1
