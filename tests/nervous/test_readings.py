"""Sensor, the component: what each has sensed, made of what `Sense` leaves, when somebody looks."""

import esper
import numpy as np
import pytest

from ecs_eco import System, World
from ecs_eco.components import Genome, Metabolism, Nervous, Position, Senses, Sensor
from ecs_eco.config import load
from ecs_eco.debug import StaleHandle
from ecs_eco.engine.errors import UnknownName
from ecs_eco.record.freeze import freeze

SMALL = {
    "space.size": [30.0, 30.0],
    "species.goat.count": 20,
    "species.red.count": 10,
    "species.yellow.count": 40,
    "species.green.count": 200,
}
GENE = {"name": "eye", "trait": "sensors.green.range", "letters": 4, "low": 1.0, "high": 4.0}


def goats(**changes):
    """Goats of the shipped world `reflexes`, few of them, after three ticks."""
    return World.from_config(load("reflexes", SMALL | changes), policies="random", seed=1).run(3)


def sensed(table):
    """What each has sensed, by uid, as the nervous system has it."""
    nerves = table.species.nerves
    return {int(uid): x for uid, x in zip(table.uid[nerves.rows], nerves.x, strict=True)}


def test_everyone_who_senses_has_its_readings_by_name():
    world = goats()
    table = world.table("goat")
    expected = sensed(table)
    assert len(expected) == table.n
    for uid, sensor in world.each(Sensor):
        assert sensor.readings.tolist() == expected[uid].tolist()
    assert sensor.readings[0] != sensor.readings[4]
    assert table.species.nerves.channels[0] == "energy"
    assert sensor.readings.shape == (len(table.species.nerves.channels),)
    with world:
        organisms = esper.get_components(Sensor, Metabolism, Nervous, Genome)
        assert len(organisms) == table.n
        for entity, (sensor, *_) in organisms:
            assert sensor.readings.tolist() == expected[world.uid(entity)].tolist()


def test_readings_are_those_of_the_last_tick_whatever_rows_their_owners_live_in():
    world = goats()
    table = world.table("goat")
    handle = world.get(int(table.uid[table.rows()[2]]), Sensor)
    before = handle.readings.copy()
    world.run(1)
    assert not np.array_equal(handle.readings, before)
    expected = sensed(table)
    table.reorder(np.random.default_rng(1).permutation(table.rows()))
    for uid, sensor in world.each(Sensor):
        assert sensor.readings.tolist() == expected[uid].tolist()


def test_a_newborn_has_read_nothing_until_it_senses():
    world = goats()
    table = world.table("goat")
    world.kill(int(table.uid[0]))
    world.spawn("goat", Position(x=3.0, y=3.0), n=200)
    world.flush()
    rows = table.by_uid()
    blind = np.isnan(table[Sensor].readings[rows]).all(axis=1)
    assert blind.tolist() == [False] * (len(rows) - 200) + [True] * 200
    assert np.isnan(table[Sensor].readings[~table.alive]).all()
    world.run(1)
    seen = table[Sensor].readings[[world.locate(uid)[1] for uid in sensed(table) if (table.uid == uid).any()]]
    assert np.isfinite(seen).all()


def test_reach_and_place_are_the_species_own_or_what_genes_say():
    world = goats()
    assert next(sensor.radius.tolist() for _, sensor in world.each(Sensor)) == [0, 0, 0, 0, 3]
    assert (world.table("goat")[Sensor].forward == 0).all()
    genes = [gene.model_dump(exclude_none=True) for gene in world.config.species["goat"].genome.genes]
    world = goats(**{"species.goat.genome.genes": [*genes, GENE]})
    table = world.table("goat")
    assert table[Sensor].radius is table[Senses].radius
    assert len(set(table[Sensor].radius[table.rows(), 4].tolist())) > 5


def test_a_system_may_need_it_and_reads_what_was_sensed_in_this_tick():
    class Look(System):
        needs = (Sensor, Metabolism)
        phase = "decide"
        seen = []

        def update(self, table, world):
            rows = table.rows()
            assert np.array_equal(table[Sensor].readings[rows, 0], table[Metabolism].energy[rows])
            self.seen.append(table.name)

    world = World.from_config(load("reflexes", SMALL), policies="random", systems=[Look()]).run(3)
    assert Look.seen == ["goat"] * 3
    assert "Sensor" not in {component.__name__ for component in world.table("goat").columns}


def test_a_sense_of_ones_own_that_looks_while_sensing_finds_nothing_yet():
    looks = []

    def look(world, table, seekers, out, first):
        looks.append(bool(np.isnan(table[Sensor].readings).all()))
        out[:, first] = 1

    sensors = [{"kind": "own", "property": "energy"}, {"kind": "custom", "function": look, "width": 1}]
    snail = {"count": 5, "body": {"radius": 0.1}, "actions": {"hide": ["hide"]}, "sensors": sensors}

    class Hide(System):
        acts = ("hide",)

        def process(self, *_):
            pass

    config = {"format": 1, "name": "w", "space": {"size": [9.0, 9.0]}, "species": {"snail": snail}}
    world = World.from_config(config, systems=[Hide()]).run(2)
    assert looks == [True, True]
    assert world.table("snail")[Sensor].readings[:5, 1].tolist() == [1] * 5


def test_it_is_no_part_of_digests_and_checkpoints_and_is_made_when_somebody_looks():
    world, other = goats(), goats()
    readings = world.table("goat").derived[Sensor]
    assert readings._column is None
    assert np.isfinite(world.table("goat")[Sensor].readings).any()
    assert world.digest() == other.digest()
    assert not [name for name in freeze(world)[1] if "Sensor" in name]
    copy = world.copy()
    assert np.isnan(copy.table("goat")[Sensor].readings).all(), "what was sensed is not saved"
    assert copy.run(1).digest() == world.run(1).digest() == other.run(1).digest()
    assert np.array_equal(
        copy.table("goat")[Sensor].readings, world.table("goat")[Sensor].readings, equal_nan=True
    )


def test_it_is_read_and_not_written():
    world = goats()
    table = world.table("goat")
    uid = int(table.uid[table.rows()[0]])
    sensor = world.get(uid, Sensor)
    with pytest.raises(ValueError, match="read-only"):
        sensor.readings[0] = 1
    with pytest.raises(ValueError, match="read-only"):
        sensor.radius = 1
    with pytest.raises(TypeError, match=r"Sensor\.readings is read-only"):
        table[Sensor].readings = table[Sensor].readings
    with pytest.raises(TypeError, match="spawn 'goat': Sensor is read-only and cannot be set"):
        world.spawn("goat", Sensor())
    with pytest.raises(ValueError, match="table 'goat' already has Sensor"):
        table.add_component(Sensor)
    with pytest.raises(
        AttributeError, match="Sensor has no field 'range'; its fields are readings, radius, forward, left"
    ):
        print(table[Sensor].range)
    with pytest.raises(UnknownName, match="table 'green': unknown component 'Sensor'"):
        world.table("green")[Sensor]


def test_in_debug_mode_a_handle_kept_too_long_is_caught(monkeypatch):
    monkeypatch.setenv("ECS_ECO_DEBUG", "1")
    world = goats()
    table = world.table("goat")
    uid = int(table.uid[table.rows()[0]])
    sensor = world.get(uid, Sensor)
    assert np.isfinite(sensor.readings).all()
    world.kill(uid)
    world.flush()
    with pytest.raises(StaleHandle, match=f"uid {uid} is dead"):
        print(sensor.readings)
