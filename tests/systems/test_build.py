import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Metabolism, Position
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import Build, Decide, Sense
from ecs_eco.testing import act, arrange, check_world
from ecs_eco.testing.stores import Stores

BEE = {
    "count": 4,
    "body": {"radius": 0.25},
    "metabolism": {"energy": 0.5, "energy_max": 1.0},
    "sensors": [{"kind": "own", "property": "energy"}],
    "builds": [{"object": "cell", "cost": 0.125, "spacing": 1.0}],
    "actions": {"build": ["cell"]},
    "happiness": {"formula": "energy", "minimum": -1.0},
    "reflex": {"formulas": {"cell": "energy - 0.25"}},
}


def _garden(cell=None, **bee):
    return {
        "format": 1,
        "name": "garden",
        "space": {"size": [20.0, 20.0]},
        "objects": {"cell": {"body": {"radius": 0.1}} | (cell or {})},
        "species": {"bee": BEE | bee},
    }


def _tick(world):
    for system in (Sense, Decide, Build):
        act(world, system)


def _energy(world):
    bees = world.tables["bee"]
    return bees[Metabolism].energy[bees.by_uid()].tolist()


@pytest.mark.definition("2 moves")
def test_a_bee_that_decides_to_pays_for_an_object_where_it_is():
    world = World.from_config(_garden())
    bees = arrange(world, "bee", x=[2, 6, 10, 14], y=5, heading=2, energy=[0.5, 0.25, 0.75, 0.125])
    _tick(world)
    assert _energy(world) == [0.375, 0.25, 0.625, 0.125]
    assert bees[Metabolism].burnt[bees.by_uid()].tolist() == [0.125, 0, 0.125, 0]
    born = []
    world.on_birth.append(lambda table, rows, parents, _: born.append((table.name, parents.tolist())))
    world.run(1)
    uids = bees.uid[bees.by_uid()]
    assert born[0][0] == "cell"
    assert born[0][1][:2] == [uids[0], uids[2]]
    cells = world.tables["cell"]
    assert cells[Position].x[cells.by_uid()][:2].tolist() == [2, 10]


def test_what_it_holds_is_given_to_it():
    world = World.from_config(_garden(cell={"energy": {"initial": 0.25}}, count=2))
    bees = arrange(world, "bee", x=[5, 15], y=5, energy=[0.5, 0.3125])  # needs more than 0.375
    stores = Stores(world)
    _tick(world)
    assert _energy(world) == [0.125, 0.3125]
    m = bees[Metabolism]
    assert (m.given[bees.by_uid()].tolist(), m.burnt[bees.by_uid()].tolist()) == ([0.25, 0], [0.125, 0])
    world.flush()
    cells = world.tables["cell"]
    world.run(1)
    stores.note()
    assert cells[Metabolism].energy[cells.rows()].tolist() == [0.25]
    assert stores.ledger["cell"]["endowed"] == 0.25


def test_none_is_made_closer_than_the_spacing_and_any_may_be_the_first():
    world, made = World.from_config(_garden()), []
    cells = world.tables["cell"]
    for world.tick in range(60):
        arrange(world, "bee", x=[5, 5.75, 6.25, 19.75], y=[5, 5, 5, 5], energy=0.5)
        _tick(world)
        made.append(sorted(cells.births[0][2][Position, "x"].tolist()))
        cells.births = []
    assert {tuple(x) for x in made} == {(5, 6.25, 19.75), (5.75, 19.75)}
    assert abs(made.count([5.75, 19.75]) - 20) < 15  # a third; four standard deviations
    for x in (5.0, 6.25, 19.75):
        world.spawn("cell", Position(x=x, y=5.0))
    world.flush()
    arrange(world, "bee", x=[0.25, 5.5, 7.5, 10], y=5, energy=0.5)  # the first is near, around the torus
    world.run(1)
    assert sorted(cells[Position].x[cells.rows()].tolist()) == [5, 6.25, 7.5, 10, 19.75]


def test_there_are_no_more_than_the_most():
    world = World.from_config(_garden(builds=[{"object": "cell", "cost": 0.0625, "most": 3}]))
    numbers = [world.run(1).tables["cell"].n for _ in range(3)]
    assert numbers == [3, 3, 3]


@pytest.mark.parametrize("names", [("bee", "wasp"), ("wasp", "bee")])
def test_each_individual_of_any_species_has_the_same_share_of_what_is_the_most(names):
    """Seven bees and one wasp want the only place: the wasp gets an eighth."""
    way = BEE | {"builds": [{"object": "cell", "cost": 0.0625, "most": 1}]}
    species = {name: way | {"count": 7 if name == "bee" else 1} for name in names}
    world = World.from_config(_garden() | {"species": species})
    cells, builders = world.tables["cell"], []
    uids = sorted(int(uid) for name in names for uid in world.tables[name].uid[world.tables[name].rows()])
    for world.tick in range(120):
        for name in names:
            arrange(world, name, energy=0.5)
        _tick(world)
        builders += [uids.index(int(uid)) for parents, _, _ in cells.births for uid in parents]
        cells.births = []
    counts = np.bincount(builders, minlength=8)
    assert counts.sum() == 120
    assert np.abs(counts - 15).max() < 15  # four standard deviations
    assert cells.species.refused == 120 * 7


def test_what_costs_nothing_is_built_without_energy():
    world = World.from_config(
        _garden(count=1, actions={}, reflex=None, builds=[{"object": "cell", "cost": 0.0}])
    )
    arrange(world, "bee", energy=0.0)
    act(world, Build)
    assert world.tables["cell"].waiting == 1


def test_without_the_action_it_builds_whenever_it_can():
    world = World.from_config(
        _garden(count=1, actions={}, reflex=None, builds=[{"object": "cell", "cost": 0.125}])
    )
    assert [world.run(1).tables["cell"].n for _ in range(5)] == [1, 2, 3, 3, 3]
    assert _energy(world) == [pytest.approx(0.5 - 0.375, abs=0.13)]


def test_worlds_in_which_animals_build_keep_their_promises():
    config = _garden(
        count=20,
        policy={"kind": "shared", "hidden": [4]},
        reflex=None,
        builds=[{"object": "cell", "cost": 0.03125, "spacing": 1.5}],
        cell={"energy": {"initial": 0.125}},
    )

    check_world(lambda threads: World.from_config(config, policies="random", threads=threads), ticks=20)


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"builds": [{"object": "sell", "cost": 0.1}]}, "cell"),
        ({"builds": []}, "it builds nothing"),
        ({"actions": {"build": ["sell"]}, "reflex": None}, "object in builds"),
    ],
)
def test_what_cannot_be_built_is_refused(changes, fault):
    with pytest.raises(ConfigError, match=fault):
        load(_garden(**changes))
