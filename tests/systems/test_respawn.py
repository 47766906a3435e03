import numpy as np

from ecs_eco import World
from ecs_eco.components import Metabolism, Position
from ecs_eco.systems import Respawn
from ecs_eco.systems.respawn import scatter
from ecs_eco.testing import act


def _training(menagerie, **changes):
    return World.from_config(menagerie(**changes), training=True, policies="untrained", learn=False)


def test_the_dead_are_replaced_within_the_tick_with_the_energy_of_newborn(menagerie):
    world = _training(menagerie)
    table = world.tables["ram"]
    uids = np.sort(table.uid[table.rows()])
    for uid in uids[:5].tolist():
        world.kill(uid)
    before, first = world.next_uid, table.uid[table.rows()].tolist()
    world.run(1)
    assert table.n == 40
    new = [u for u in table.uid[table.rows()].tolist() if u not in first]
    assert len(new) == 5
    assert min(new) >= before
    assert [world.get(u, Metabolism).energy for u in new] == [np.float32(0.6)] * 5


def test_numbers_are_held_and_nobody_gives_birth(menagerie):
    world = _training(menagerie)
    world.run(60)
    assert (world.tables["ram"].n, world.tables["lynx"].n) == (40, 8)
    assert sum(world.series().to_pydict()["deaths"]) > 10


def test_plants_are_not_respawned(menagerie):
    world = _training(menagerie, species={"moss": {"reproduction": None}})
    world.kill(int(world.tables["moss"].uid[0]))
    world.flush()
    act(world, Respawn)
    world.flush()
    assert world.tables["moss"].n == 149


def test_newcomers_land_on_open_ground_all_over_the_space(menagerie):
    world = _training(menagerie)
    who = np.arange(1, 2001, dtype=np.uint64)
    values = scatter(world.tables["ram"], world, who)
    x, y = values[Position, "x"], values[Position, "y"]
    assert world.terrain.free(x, y).all()
    assert ((x >= 0) & (x < 40) & (y >= 0) & (y < 30)).all()
    # 125 expected, less where rock or water is
    assert np.histogram2d(x, y, 4, [(0, 40), (0, 30)])[0].min() > 40
    other = scatter(world.tables["lynx"], world, who)
    assert abs(np.corrcoef(x, other[Position, "x"])[0, 1]) < 0.1  # two kinds do not land in the same places
