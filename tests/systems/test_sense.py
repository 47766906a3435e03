import time

import numpy as np
import pytest

from ecs_eco.space import Index, Seekers
from ecs_eco.systems import Sense
from ecs_eco.testing import act, arrange

SENSORS = [
    {"kind": "own", "property": "energy", "scale": 2.0},
    {"kind": "nearest", "target": "grass", "range": 5.0},
    {"kind": "light", "zero": 0.5, "scale": 2.0},
]


@pytest.mark.definition("5 sense")
def test_the_vector_x_has_the_channels_in_order_for_everyone_in_canonical_order(meadow):
    world = meadow(sensors=SENSORS, count=3, grass={"count": 1})
    table = arrange(world, "deer", x=[19, 1, 10], y=[1, 1, 10], energy=[1, 2, 3], heading=[0, np.pi, 0])
    arrange(world, "grass", x=0, y=1)
    act(world, Sense)
    nerves = table.species.nerves
    assert nerves.channels == ("energy", "grass_forward", "grass_left", "grass_near", "light")
    by_uid = nerves.x[np.argsort(table.uid[nerves.rows])]
    expected = [[0.5, 1, 0, 0.8, 0.25], [1.0, 1, 0, 0.8, 0.25], [1.5, 0, 0, 0, 0.25]]
    assert by_uid.ravel() == pytest.approx(np.ravel(expected), abs=1e-6)
    assert nerves.rows.tolist() == world.index(table).rows.tolist()


def test_what_was_sensed_last_is_forgotten_when_numbers_change(meadow):
    world = meadow(sensors=SENSORS, count=40)
    act(world, Sense)
    world.kill(int(world.tables["deer"].uid[5]))
    world.spawn("deer", n=60)
    world.flush()
    act(world, Sense)
    nerves = world.tables["deer"].species.nerves
    assert nerves.x.shape == (99, 5)
    assert np.isfinite(nerves.x).all()
    assert (nerves.x[:, 4] == 0.25).all()


@pytest.mark.parametrize("threads", [1, 2])
def test_what_is_read_together_is_what_each_sense_reads_alone(meadow, threads):
    nostrils = [
        {"kind": "smell", "field": field, "at": [1.0, side], "half_saturation": scale, "name": field + way}
        for way, side, scale in (("_left", 0.5, 1.0), ("_right", -0.5, 2.0))
        for field in ("musk", "hay")
    ]
    properties = [
        {"kind": "own", "property": name, "scale": scale}
        for name, scale in (("energy", 2.0), ("mass", 3.0), ("volume", 0.5), ("age", 7.0), ("sex", 1.0))
    ]
    world = meadow(
        sensors=[properties[0], SENSORS[1], *nostrils, *properties[1:]],
        count=70,
        grass={"count": 9},
        options={"threads": threads},
        world={"fields": {name: {"cell": 1.0} for name in ("musk", "hay")}},
    )
    table, rng = world.tables["deer"], np.random.default_rng(1)
    for field in world.fields.values():
        field.value[:] = rng.random(field.value.shape)
    for grow in (False, True):
        if grow:  # columns are others then
            world.spawn("deer", n=300)
            world.flush()
        act(world, Sense)
        nerves, seekers, first = table.species.nerves, Seekers(world, table), 0
        alone = np.full(nerves.x.shape, np.nan, np.float32, order="F")
        for sense, width in nerves.senses:
            sense(world, table, seekers, alone, first)
            first += width
        assert nerves.x.tobytes() == alone.tobytes()


def test_senses_of_two_threads_that_look_at_the_same_kind_share_one_neighbour_index(meadow, monkeypatch):
    """Both threads want the index of the grass, which is stale while that of the deer is not:
    one builds it, the other waits."""
    at_work, most, build = [], [], Index.build

    def slow(index, *columns):
        at_work.append(index)
        time.sleep(0.05)
        most.append(at_work.count(index))
        build(index, *columns)
        at_work.remove(index)

    sensors = [
        SENSORS[0],
        {"kind": "touch", "target": "grass"},
        {"kind": "touch", "target": "grass", "name": "again"},
        SENSORS[1],
    ]
    world = meadow(sensors=sensors, count=500, grass={"count": 3000}, options={"threads": 2})
    act(world, Sense)
    world.tables["grass"].version += 1
    monkeypatch.setattr(Index, "build", slow)
    act(world, Sense)
    assert most == [1]
