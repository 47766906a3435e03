import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Body, Metabolism, Position, Sensor
from ecs_eco.engine.random import lot
from ecs_eco.systems import Feed, Sense
from ecs_eco.testing import act


def _energy(world, name="deer"):
    table = world.tables[name]
    return table[Metabolism].energy[table.by_uid()].tolist()


def _eaten(world, name="grass"):
    """Return who was eaten by whom, by the order of uids."""
    table, uids = world.tables[name], []
    for other in world.tables.values():
        uids += other.uid[other.by_uid()].tolist() if other is not table or name == "deer" else []
    rows = table.by_uid()
    return [world.causes[c - 1] if c else None for c in table.cause[rows]], table.killer[rows].tolist()


EATER = {
    "count": 0,
    "body": {"radius": 0.125, "opaque": False},
    "metabolism": {"energy": 0.5, "energy_max": 9.0},
    "diet": [{"eats": "grass", "reach": 3.0, "chance": 1.0, "gain": 0.25}],
}
GRASS = {"count": 0, "body": {"radius": 0.125, "opaque": False}}


def _world(species, places, seed=1, **section):
    """Return a world with some of each species at these x, y = 10, or at x, y."""
    world = World.from_config(
        {"format": 1, "name": "w", "space": {"size": [64.0, 64.0]}, "species": species, **section}, seed=seed
    )
    for name, x in places.items():
        at = np.array([(p, 10.0) if isinstance(p, float) else p for p in x], np.float32)
        world.table(name).request(
            np.zeros(len(at), np.uint64), {(Position, "x"): at[:, 0], (Position, "y"): at[:, 1]}
        )
    world.flush()
    return world


def test_equally_near_eaters_of_two_species_get_half_of_the_food_each():
    x = np.arange(300) % 15 * 4 + 2.0
    y = np.arange(300) // 15 * 3 + 2.0
    world = _world(
        {"red": EATER, "grass": GRASS, "blue": EATER},
        {"red": np.stack([x - 0.5, y], 1), "blue": np.stack([x + 0.5, y], 1), "grass": np.stack([x, y], 1)},
    )
    act(world, Feed)
    gained = {name: np.array(_energy(world, name)) > 0.5 for name in ("red", "blue")}
    assert gained["red"].sum() + gained["blue"].sum() == 300
    assert 120 < gained["red"].sum() < 180  # 150 expected, standard deviation 8.7


def test_equally_near_eaters_of_one_species_get_half_of_the_food_each():
    x, y = np.arange(300) % 15 * 4 + 2.0, np.arange(300) // 15 * 3 + 2.0
    world = _world(
        {"red": EATER, "grass": GRASS},
        {"red": np.stack([np.append(x - 0.5, x + 0.5), np.append(y, y)], 1), "grass": np.stack([x, y], 1)},
    )
    act(world, Feed)
    older = np.array(_energy(world, "red")[:300]) > 0.5
    assert 120 < older.sum() < 180


@pytest.mark.parametrize("names", [("aaa", "zzz"), ("zzz", "aaa")])
def test_the_nearer_eater_gets_the_food_whatever_the_order_of_species(names):
    far, close = names
    for order in (names, names[::-1]):
        world = _world(
            dict.fromkeys(order, EATER) | {"grass": GRASS}, {far: [12.5], close: [10.5], "grass": [10.0]}
        )
        act(world, Feed)
        assert (_energy(world, far), _energy(world, close)) == ([0.5], [0.75])


def test_an_eater_of_several_kinds_takes_the_nearest_first_whatever_the_order_of_its_diet():
    for digestion, gained in ((5.0, 0.25), (0.0, 0.75)):
        for order in (("grass", "herb"), ("herb", "grass")):
            gain = {"grass": 0.25, "herb": 0.5}
            eater = EATER | {
                "diet": [{"eats": name, "reach": 3.0, "chance": 1.0, "gain": gain[name]} for name in order],
                "metabolism": {"energy": 0.5, "energy_max": 9.0, "handling_time": digestion},
            }
            world = _world(
                {"red": eater, "grass": GRASS, "herb": GRASS},
                {"red": [10.0], "grass": [11.0], "herb": [12.0]},
            )
            act(world, Feed)
            assert _energy(world, "red") == [0.5 + gained]
            assert _eaten(world, "herb")[0] == [None if digestion else "eaten by red"]


def test_an_eater_that_is_full_after_its_nearest_food_leaves_the_other():
    eater = EATER | {
        "diet": [
            {"eats": name, "reach": 3.0, "chance": 1.0, "gain": 0.5, "satiation": 0.75}
            for name in ("grass", "herb")
        ]
    }
    world = _world(
        {"red": eater, "grass": GRASS, "herb": GRASS}, {"red": [10.0], "grass": [12.0], "herb": [11.0]}
    )
    act(world, Feed)
    assert _energy(world, "red") == [1.0]
    assert (_eaten(world, "herb")[0], _eaten(world, "grass")[0]) == (["eaten by red"], [None])


def _cannibals(places, seed=1):
    cannibal = EATER | {"diet": [{"eats": "red", "reach": 3.0, "chance": 1.0, "gain": 0.25}]}
    world = _world({"red": cannibal}, {"red": places}, seed)
    act(world, Feed)
    table = world.tables["red"]
    return [bool(c) for c in table.cause[table.by_uid()]], _energy(world, "red")


def test_of_two_cannibals_one_lives_and_has_eaten():
    lived = []
    for seed in range(40):
        died, energy = _cannibals([10.0, 11.0], seed)
        assert sorted(died) == [False, True]
        assert energy[died.index(False)] == 0.75
        assert energy[died.index(True)] == 0.5
        lived.append(died.index(False))
    assert 8 <= sum(lived) <= 32


def test_a_ring_and_a_chain_of_cannibals():
    died, energy = _cannibals([(10.0, 10.0), (11.0, 10.0), (10.5, 10.75)])  # the sides: 1, .9, .9
    assert 1 <= sum(died) <= 2
    assert any(e == 0.75 and not d for e, d in zip(energy, died, strict=True))
    # the second and the third are nearest to each other; the first wants the second, the fourth the third
    died, energy = _cannibals([10.0, 12.0, 13.0, 15.0])
    assert sum(died) == 1
    assert died.index(True) in (1, 2)
    assert energy[1 if died[2] else 2] == 0.75
    # each wants the next, which is nearer and nearer: the last pair settles it, and the first eats the second
    died, energy = _cannibals([10.0, 12.0, 13.5, 14.5])
    assert died[:2] == [False, True]
    assert sum(died) == 2
    assert (energy[:2], sorted(energy[2:])) == ([0.75, 0.5], [0.5, 0.75])


def test_an_animal_that_eats_and_is_then_eaten_has_had_its_energy_before_the_meal():
    hunter = EATER | {"diet": [{"eats": "red", "reach": 3.0, "chance": 1.0, "gain": 0.0, "efficiency": 1.0}]}
    for x, gained in ((12.0, 0.25), (10.5, 0.0)):  # grass first, the hunter first
        world = _world(
            {"red": EATER, "grass": GRASS, "wolf": hunter}, {"red": [10.0], "grass": [11.0], "wolf": [x]}
        )
        act(world, Feed)
        assert _energy(world, "red") == [0.5 + gained]
        assert _energy(world, "wolf") == [1.0]
        assert _eaten(world, "red")[0] == ["eaten by wolf"]
        assert _eaten(world, "grass")[0] == ["eaten by red" if gained else None]


def test_food_exactly_in_reach_is_eaten_as_touch_reads_1_there():
    eater = EATER | {
        "diet": [{"eats": "grass", "chance": 1.0, "gain": 0.25, "reach": 0.0}],
        "sensors": [{"kind": "touch", "target": "grass"}],
    }
    for x, reads in ((10.25, 1), (10.250001, 0)):
        world = _world({"red": eater, "grass": GRASS}, {"red": [10.0], "grass": [x]})
        act(world, Sense)
        act(world, Feed)
        red = world.tables["red"]
        assert red[Sensor].readings[red.rows()][:, 0].tolist() == [reads]
        assert _energy(world, "red") == [0.5 + 0.25 * reads]


def test_a_meal_does_not_depend_on_the_bodies_of_the_dead():
    for largest in (0.75, 0.125, np.nan):
        world = _world({"red": EATER, "grass": GRASS}, {"red": [10.0, 30.0], "grass": [13.25]})
        red = world.tables["red"]
        red[Body].radius[red.by_uid()[1]] = 0.75
        world.kill(int(red.uid[red.by_uid()[1]]))
        world.flush()
        red[Body].radius[~red.alive] = largest
        act(world, Feed)
        assert _energy(world, "red") == [0.75]


def test_of_two_capsules_at_the_same_place_the_older_is_eaten_half_of_the_time():
    capsule = GRASS | {"body": {"shape": "capsule", "radius": 0.125, "length": 0.5, "opaque": False}}
    places = np.stack([np.arange(300) % 15 * 4 + 2.0, np.arange(300) // 15 * 3 + 2.0], 1)
    world = _world({"red": EATER, "grass": capsule}, {"red": places, "grass": np.tile(places, (2, 1)) + 0.5})
    act(world, Feed)
    older = [cause is not None for cause in _eaten(world)[0]][:300]
    assert 120 < sum(older) < 180


def test_an_animal_whose_hunter_is_eaten_first_eats():
    hunters = {
        eater: EATER | {"diet": [{"eats": food, "reach": 4.0, "chance": 1.0, "gain": 0.25}]}
        for eater, food in ("ab", "bc", "cd")
    }
    world = _world(hunters | {"d": GRASS}, {"a": [10.0], "b": [11.0], "c": [13.0], "d": [16.0]})
    act(world, Feed)
    assert {name: bool(world.tables[name].cause.any()) for name in "abcd"} == {
        "a": False,
        "b": True,
        "c": False,
        "d": True,
    }
    assert [_energy(world, name) for name in "abc"] == [[0.75], [0.5], [0.75]]


def test_an_animal_that_its_hunter_leaves_eats():
    for digestion, energy in ((5.0, 0.75), (0.0, 0.5)):  # the hunter takes the berry at 1 m, then red at 2 m
        food = [{"eats": name, "reach": 4.0, "chance": 1.0, "gain": 0.25} for name in ("berry", "red")]
        fast = {"energy": 0.5, "energy_max": 9.0, "handling_time": digestion}
        world = _world(
            {
                "red": EATER,
                "grass": GRASS,
                "berry": GRASS,
                "wolf": EATER | {"diet": food, "metabolism": fast},
            },
            {"wolf": [10.0], "berry": [9.0], "red": [12.0], "grass": [14.5]},
        )
        act(world, Feed)
        assert _energy(world, "red") == [energy]
        assert _energy(world, "wolf") == [0.75 if digestion else 1.0]


def _twin(world, reach, until):
    """Return who is eaten and the energies after feeding, by uid: awards, then meals one by one."""
    uids, places, kinds, energy = [], [], [], {}
    for name, table in world.tables.items():
        for row in table.by_uid():
            uids.append(int(table.uid[row]))
            places.append((float(table[Position].x[row]), float(table[Position].y[row])))
            kinds.append(name)
            if Metabolism in table:
                energy[uids[-1]] = float(table[Metabolism].energy[row])
    held, claims = dict(energy), {}
    for i, name in enumerate(kinds):
        for food in world.tables[name].species.diet:
            near = [(np.hypot(*np.subtract(places[i], p)), k) for k, p in enumerate(places) if k != i]
            distance, k = min((d, k) for d, k in near if kinds[k] == food.eats)
            if distance <= reach + 0.25:
                rank = int(lot(world.key, np.uint64(uids[i]), np.uint64(uids[k])))
                claims.setdefault(k, []).append((distance, rank, i))
    slow = {name for name, table in world.tables.items() if table.species.metabolism.handling_time}
    eaten, busy = set(), set()
    for _, _, i, k in sorted((*min(claimed), k) for k, claimed in claims.items()):
        eater, item = uids[i], uids[k]
        if eater not in eaten and eater not in busy and energy[eater] < until:
            energy[eater] += 0.125 + 0.5 * held.get(item, 0.0)
            eaten.add(item)
            busy |= {eater} if kinds[i] in slow else set()
    return eaten, energy


@pytest.mark.parametrize("seed", range(8))
def test_meals_take_place_as_in_the_slow_twin(seed):
    rng, names = np.random.default_rng(seed), ["a", "b", "c", "d"]
    species, reach, until = {"grass": GRASS}, 3.0, 0.75
    for name in names:
        eaten = rng.choice([*names, "grass"], rng.integers(1, 4), replace=False)
        diet = [
            {
                "eats": str(food),
                "reach": reach,
                "chance": 1.0,
                "gain": 0.125,
                "efficiency": 0.5,
                "satiation": until,
            }
            for food in eaten
        ]
        metabolism = {"energy": 0.25, "energy_max": 9.0, "handling_time": float(rng.choice([0.0, 5.0]))}
        species[name] = EATER | {"diet": diet, "metabolism": metabolism}
    world = _world(
        species,
        {name: rng.uniform(5.0, 25.0, (25, 2)) for name in species},
        space={"size": [30.0, 30.0], "edges": "walls"},
    )
    eaten, energy = _twin(world, reach, until)
    act(world, Feed)
    for table in world.tables.values():
        rows = table.by_uid()
        assert [uid in eaten for uid in table.uid[rows].tolist()] == (table.cause[rows] > 0).tolist()
        if table.name != "grass":
            assert table[Metabolism].energy[rows] == pytest.approx(
                [energy[u] for u in table.uid[rows].tolist()]
            )
    assert len(eaten) > 20
