"""From a configuration to a world: what is declared is what there is."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import (
    Biology,
    Body,
    Carrier,
    Chemistry,
    HeatExchange,
    Load,
    Matter,
    Metabolism,
    Nervous,
    Physical,
    Position,
    Route,
    Velocity,
)
from ecs_eco.engine.errors import ConfigError


@pytest.fixture(scope="module")
def world(menagerie):
    return World.from_config(menagerie(), policies="untrained")


def test_tables_are_objects_then_species_by_name_with_the_components_they_need(world):
    # landmarks come last
    assert list(world.tables) == [
        "boulder",
        "cairn",
        "carcass",
        "cone",
        "lynx",
        "moss",
        "ram",
        "rocks",
        "lakes",
    ]
    assert [t.place for t in world.tables.values()] == list(range(9))
    has = {name: set(t.columns) for name, t in world.tables.items()}
    body = {Position, Body}
    assert has["boulder"] == body | {Physical, Chemistry, HeatExchange}
    assert has["carcass"] == body | {Physical, Chemistry, Matter, Metabolism}  # what rams are made of
    assert has["cone"] == body | {Route, Carrier}
    assert has["cairn"] == body
    assert has["moss"] == body | {Metabolism, Biology}
    assert has["ram"] == body | {Metabolism, Biology, Nervous, Velocity, Physical, Chemistry, Matter}
    assert has["lynx"] == body | {Metabolism, Biology, Nervous, Velocity, Physical, HeatExchange, Load}
    assert world.tables["carcass"].species.radius == 0.5  # as large as the largest that leaves one


def test_numbers_places_and_values_at_birth(world):
    assert {name: table.n for name, table in world.tables.items()} == {
        "boulder": 2,
        "cairn": 0,
        "carcass": 0,
        "cone": 12,
        "lynx": 8,
        "moss": 150,
        "ram": 40,
        "rocks": 1,
        "lakes": 1,
    }
    for name, table in world.tables.items():
        p, rows = table[Position], table.rows()
        x, y = p.x[rows], p.y[rows]
        if name == "moss":  # a site of 2 m is open where its centre is
            x, y = x // 2 * 2 + 1, y // 2 * 2 + 1
        if name not in ("boulder", "carcass", "rocks", "lakes"):
            assert world.terrain.free(x, y).all(), name
    assert world.tables["boulder"][Position].x[:2].tolist() == [20, 33]
    ram = world.tables["ram"]
    rows = ram.rows()
    assert set(ram[Body].radius[rows].tolist()) == {0.5}
    assert set(ram[Body].mass[rows].tolist()) == {80}
    assert ram[Chemistry].molarity[0].tolist() == pytest.approx([0.005, 0.008, 4e-8])
    assert set(ram[Biology].sex[rows].tolist()) == {1, 2}
    assert ram[Biology].fertility[0] == np.float32(0.8)
    energy = ram[Metabolism].energy[rows]
    assert (energy >= 0.45 - 1e-6).all()
    assert (energy <= 0.75 + 1e-6).all()
    assert energy.std() > 0.03
    assert set(world.tables["moss"][Metabolism].energy[world.tables["moss"].rows()].tolist()) == {
        np.float32(0.1)
    }


def test_surroundings_fields_and_terrain_are_as_declared(world):
    assert world.ambient == {"temperature": 280.0, "pressure": 101_325.0, "light": 0.8}
    assert world.fields["musk"].shape == (20, 15, 1)
    assert world.terrain.slope_cost == 2.0
    assert world.substances == ["glucose", "oxygen", "hydron"]
    assert (world.dt, world.seed, world.name, world.space.edges) == (0.5, 3, "menagerie", "walls")


def test_seed_policies_and_learning_can_be_chosen(menagerie):
    first, second = (World.from_config(menagerie(), seed=s, policies="untrained") for s in (1, 2))
    assert first.digest() != second.digest()
    assert World.from_config(menagerie(), seed=1, policies="untrained").digest() == first.digest()
    random = World.from_config(menagerie(), policies="random").tables["ram"].species.nerves
    assert (random.policy, random.brain, random.learning) == (True, None, False)
    assert World.from_config(menagerie(), learn=True).tables["ram"].species.nerves.learning
    learns = menagerie(species={"ram": {"policy": {"learn": True}}})
    assert World.from_config(learns).tables["ram"].species.nerves.learning
    assert not World.from_config(learns, learn=False).tables["ram"].species.nerves.learning


def test_two_species_of_plants_do_not_stand_in_the_same_places(menagerie):
    moss = menagerie()["species"]["moss"]
    changes = {"terrain": None, "fields": {"pond": {"only": None}}, "species": {"fern": moss}}
    world = World.from_config(menagerie(**changes), policies="untrained")
    places = [world.tables[n][Position] for n in ("moss", "fern")]
    sites = [{(int(x / 2), int(y / 2)) for x, y in zip(p.x[:150], p.y[:150], strict=True)} for p in places]
    assert len(sites[0]) == len(sites[1]) == 150
    assert len(sites[0] & sites[1]) == pytest.approx(150 * 150 / 300, abs=30)
    assert not set(places[0].x[:150].tolist()) & set(places[1].x[:150].tolist())


def test_plants_that_find_too_few_free_sites_are_as_many_as_fit(menagerie):
    lake = {"cell": 1.0, "lakes": [{"at": [20.0, 15.0], "radius": 14.0}]}
    sensing = {"count": 200, "sensors": [{"kind": "own", "property": "energy"}]}
    world = World.from_config(
        menagerie(
            terrain=lake | {"rocks": [], "hills": None},
            objects={"boulder": {"at": [[1.0, 1.0]]}},
            species={"moss": sensing},
        ),
        policies="untrained",
    )
    moss = world.tables["moss"]
    assert moss.n == 300 - sum(
        not world.terrain.free(np.array([x + 0.0]), np.array([y + 0.0]))[0]
        for x in range(1, 40, 2)
        for y in range(1, 30, 2)
    )
    assert moss.n < 200
    world.run(2)


@pytest.mark.parametrize(
    ("policies", "message"),
    [
        ("trane", 'trane(.|\n)*did you mean "trained"'),
        ("/nowhere/at/all", "/nowhere/at/all(.|\n)*or a folder of <species>.safetensors"),
    ],
)
def test_policies_that_are_not_there_are_refused(menagerie, policies, message):
    with pytest.raises(ValueError, match=message):
        World.from_config(menagerie(), policies=policies)


def test_a_folder_without_the_species_file_or_with_another_network_is_refused(menagerie, tmp_path):
    with pytest.raises(ValueError, match=r"ram.safetensors\"?\n? *missing; expected: <species>.safetensors"):
        World.from_config(menagerie(), policies=str(tmp_path))
    from safetensors.numpy import save_file

    save_file({"trunk.0.weight": np.zeros((2, 2), np.float32)}, tmp_path / "ram.safetensors")
    with pytest.raises(ValueError, match=r"ram.safetensors(.|\n)*weights .* missing or unknown"):
        World.from_config(menagerie(), policies=str(tmp_path))


def test_a_configuration_that_is_wrong_is_refused_before_anything_is_built(menagerie):
    with pytest.raises(ConfigError, match=r'species.ram.diet.0.eats.*\n.*did you mean "moss"'):
        World.from_config(menagerie(species={"ram": {"diet": [{"eats": "mos", "gain": 0.1}]}}))


def test_lakes_rocks_and_mountains_are_inanimate_objects():
    from ecs_eco import World
    from ecs_eco.components import Body, Position

    moss = {"count": 5, "body": {"radius": 0.2}}
    terrain = {
        "cell": 1.0,
        "lakes": [{"at": [10.0, 12.0], "radius": 3.0}, {"at": [30.0, 5.0], "radius": 2.0}],
        "mountains": [{"at": [20.0, 20.0], "radius": 6.0, "height": 9.0}],
    }
    fells = {
        "format": 1,
        "name": "fells",
        "space": {"size": [40.0, 40.0]},
        "terrain": terrain,
        "species": {"moss": moss},
    }
    world = World.from_config(fells)
    lakes = world.tables["lakes"]
    assert (lakes.n, world.tables["mountains"].n, "rocks" in world.tables) == (2, 1, False)
    assert lakes[Position].x[lakes.by_uid()].tolist() == [10.0, 30.0]
    assert lakes[Body].radius[lakes.by_uid()].tolist() == [3.0, 2.0]
    world.run(3)
    assert world.recorder.names == ["moss"]
