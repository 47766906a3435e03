"""The sense of kin: who counts as whose relative, near and far, and after a death; against plain Python."""

import itertools
import math

import numpy as np
import pytest

from ecs_eco.components import Parentage
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import Reproduce, Sense
from ecs_eco.testing import act, all_threads, arrange, difference, shuffle, state

F = np.float32


def sees(kin, **more):
    return {"kind": "nearest", "target": "deer", "range": 8.0, "kin": kin} | more


def readings(world):
    """What each deer senses, in the order of uids: f32[n, channels]."""
    act(world, Sense)
    deer = world.tables["deer"]
    nerves = deer.species.nerves
    order = np.argsort(deer.uid[nerves.rows])
    return nerves.x[order]


def herd(meadow, sensors, mother=(0, 0, 1, 1, 2), father=(0, 0, 2, 0, 0), **more):
    """Five deer in a row, 2 m apart, all facing east; whose parents are given by their places, from 1."""
    n = len(mother)
    world = meadow(count=n, sensors=sensors, happiness=None, **more)
    deer = world.tables["deer"]
    uid = np.concatenate([[0], deer.uid[deer.by_uid()]])
    arrange(
        world,
        "deer",
        x=2.0 + 2 * np.arange(n),
        y=5.0,
        heading=0.0,
        mother=uid[list(mother)],
        father=uid[list(father)],
    )
    return world


@pytest.mark.definition("3 sensor property")
def test_each_sees_its_own_mother_however_many_are_nearer(meadow):
    x = readings(herd(meadow, [sees("mother")]))
    # the third and the fourth are 4 and 6 m east of the first, the fifth 6 m east of the second
    assert x[:2].tolist() == [[0, 0, 0]] * 2
    assert x[2:] == pytest.approx(np.array([[-1, 0, 0.5], [-1, 0, 0.25], [-1, 0, 0.25]]))


def test_father_offspring_and_siblings(meadow):
    near = {
        kin: readings(herd(meadow, [sees(kin)]))[:, 2].tolist() for kin in ("father", "offspring", "siblings")
    }
    assert near["father"] == [0, 0, 0.75, 0, 0]
    assert near["offspring"] == [0.5, 0.75, 0, 0, 0]  # of the second: the third, whose father it is
    # the third and the fourth have a mother, the third's father is the fifth's mother: no sibling
    assert near["siblings"] == [0, 0, 0.75, 0.75, 0]


def test_who_has_no_known_parents_is_nobodys_sibling(meadow):
    assert not readings(herd(meadow, [sees("siblings")], (0,) * 5, (0,) * 5)).any()


def test_a_dead_mother_reads_as_nothing(meadow):
    world = herd(meadow, [sees("mother")])
    deer = world.tables["deer"]
    world.kill(int(deer.uid[deer.by_uid()[0]]))
    world.flush()
    assert readings(world)[:, 2].tolist() == [0, 0, 0, 0.25]


def test_radius_field_of_view_and_torus_limit_it(meadow):
    assert readings(herd(meadow, [sees("mother", range=5.0)]))[2:, 2] == pytest.approx([0.2, 0, 0])
    assert not readings(herd(meadow, [sees("mother", fov=math.pi)])).any()  # she is behind
    world = herd(meadow, [sees("mother")])
    arrange(world, "deer", x=[1.0, 9.0, 19.0, 9.0, 9.0])
    assert readings(world)[2] == pytest.approx([1, 0, 0.75])


def test_a_property_of_kin(meadow):
    brood = {"kind": "property", "property": "energy", "of": "deer", "range": 5.0, "kin": "offspring"}
    world = herd(
        meadow,
        [brood, brood | {"report": "mean"}, brood | {"decay": "linear"}],
        (0, 0, 1, 1, 1),
        (0, 0, 0, 0, 0),
    )
    arrange(world, "deer", x=[5, 5, 6, 7, 11], energy=[0.5, 0.5, 0.25, 0.75, 1.0])
    x = readings(world)
    assert x[0] == pytest.approx([1.0, 0.5, 0.25 * 0.8 + 0.75 * 0.6])
    assert not x[1:].any()
    assert world.tables["deer"].species.nerves.channels[0] == "deer_offspring_energy_1"


def test_newborn_know_their_parents(meadow):
    way = {"kind": "asexual", "rate": 100.0, "energy_min": 0.1, "energy_given": 0.05, "dispersal": 5.0}
    world = meadow(
        count=1,
        sensors=[sees("mother")],
        happiness=None,
        reproduction=way,
        world={"dt": 0.01},
        body={"opaque": False},
    )
    deer = world.tables["deer"]
    first = deer.uid[deer.by_uid()[0]]
    while deer.n < 3:
        act(world, Reproduce)
        world.tick += 1
        world.flush()
    assert deer[Parentage].mother[deer.by_uid()][:2].tolist() == [0, first]
    assert not deer[Parentage].father[deer.by_uid()].any()


def plain(uids, x, y, mother, father, kin, reach, size):
    """Uid of the nearest relative of each, by loops; 0 for none."""
    out = []
    for i in range(len(uids)):
        best = (math.inf, 0)
        for j in range(len(uids)):
            theirs = {
                "mother": mother[i] == uids[j],
                "father": father[i] == uids[j],
                "offspring": uids[i] in (mother[j], father[j]),
                "siblings": (mother[i] and mother[i] == mother[j]) or (father[i] and father[i] == father[j]),
            }
            away = [min(abs(a), size - abs(a)) for a in (x[i] - x[j], y[i] - y[j])]
            if i != j and theirs[kin] and math.hypot(*away) <= reach:
                best = min(best, (math.hypot(*away), uids[j]))
        out.append(best)
    return out


@pytest.mark.parametrize("kin", ["mother", "father", "offspring", "siblings"])
def test_it_is_what_plain_python_finds(meadow, kin):
    generator = np.random.Generator(np.random.Philox(3))
    n = 60
    parents = generator.integers(0, 12, (2, n))
    world = herd(meadow, [sees(kin)], *parents.tolist(), body={"opaque": False})
    x, y = generator.uniform(0, 20, (2, n)).astype(F)
    deer = arrange(world, "deer", x=x, y=y)
    rows = deer.by_uid()
    uids, p = deer.uid[rows].tolist(), deer[Parentage]
    wanted = plain(
        uids,
        x.astype(float),
        y.astype(float),
        p.mother[rows].tolist(),
        p.father[rows].tolist(),
        kin,
        8.0,
        20.0,
    )
    near = [0.0 if not uid else 1 - away / 8 for away, uid in wanted]
    assert readings(world)[:, 2] == pytest.approx(near, abs=1e-5)
    assert 10 < np.count_nonzero(near) < n


def test_it_depends_neither_on_rows_nor_on_threads(meadow):
    def lived(threads, seed=None):
        mother = np.arange(80) // 8 + 1
        sensors = [sees(kin) for kin in ("mother", "siblings")]
        world = herd(meadow, sensors, mother, [0] * 80, options={"threads": threads})
        if seed is not None:
            shuffle(world, seed)
        return state(world.run(5))

    alone = lived(1)
    with all_threads():
        assert not difference(alone, lived(2))
    assert not difference(alone, lived(1, 4))


@pytest.mark.parametrize(
    ("sensor", "place"),
    [
        (sees("mother", target="grass"), "sensors.0.target"),
        (sees("uncle"), "sensors.0.kin"),
        (sees("mother", occlusion=True), "sensors.0.occlusion"),
        (sees("mother", sight=3.0), "sensors.0.sight"),
        ({"kind": "property", "property": "energy", "range": 5.0, "kin": "mother"}, "sensors.0.of"),
    ],
)
def test_wrong_values_are_refused_by_name(meadow, sensor, place):
    with pytest.raises(ConfigError) as error:
        meadow(sensors=[sensor], happiness=None)
    assert place in str(error.value)


def test_species_without_a_use_for_kin_have_no_parents_column(meadow):
    assert all(Parentage not in t for t in meadow().tables.values())
    tables = meadow(sensors=[sees("mother")], happiness=None).tables
    assert {name: Parentage in table for name, table in tables.items()} == {"deer": True, "grass": False}


def test_all_four_at_once_are_told_apart_by_name(meadow):
    names = list(
        itertools.chain(
            *(
                s.channels(2)
                for s in meadow(sensors=[sees("mother"), sees("father"), sees("mother")], happiness=None)
                .config.species["deer"]
                .sensors
            )
        )
    )
    assert names[::3] == ["deer_mother_1_forward", "deer_father_forward", "deer_mother_2_forward"]
