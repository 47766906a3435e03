import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Body, Defence, Metabolism, Nervous, Position, Sensor
from ecs_eco.engine import random
from ecs_eco.systems import Decide, Feed, Sense
from ecs_eco.testing import act, arrange

# deer: radius .5, reach .25; grass: radius .25: contact up to 1.0; gain .25


def _eat(world):
    act(world, Sense)
    act(world, Decide)
    act(world, Feed)


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


def test_an_animal_takes_the_nearest_food_in_reach(meadow):
    world = meadow(grass={"count": 4})
    deer = arrange(world, "deer", x=[5, 15], y=5, energy=0.5)
    arrange(world, "grass", x=[5.5, 5.9, 16.01, 3], y=5)
    _eat(world)
    first = int(deer.uid[deer.by_uid()][0])
    assert _energy(world) == [0.75, 0.5]
    assert deer[Metabolism].taken[deer.by_uid()].tolist() == [0.25, 0]
    assert _eaten(world) == (["eaten by deer", None, None, None], [first, 0, 0, 0])
    world.flush()
    assert world.tables["grass"].n == 3


def test_one_item_goes_to_the_nearest_of_those_that_want_it(meadow):
    world = meadow(count=4, grass={"count": 2})
    deer = arrange(world, "deer", x=[4.5, 5.75, 14.75, 15.5], y=5, energy=0.5)
    arrange(world, "grass", x=[5, 15], y=5)
    _eat(world)
    assert _energy(world) == [0.75, 0.5, 0.75, 0.5]
    assert _eaten(world)[1] == [int(deer.uid[deer.by_uid()][0]), int(deer.uid[deer.by_uid()][2])]


EATER = {"count": 0, "body": {"radius": 0.125, "opaque": False},
         "metabolism": {"energy": 0.5, "energy_max": 9.0},
         "diet": [{"eats": "grass", "reach": 3.0, "chance": 1.0, "gain": 0.25}]}
GRASS = {"count": 0, "body": {"radius": 0.125, "opaque": False}}


def _world(species, places, seed=1, **section):
    """Return a world with some of each species at these x, y = 10, or at x, y."""
    world = World.from_config({"format": 1, "name": "w", "space": {"size": [64.0, 64.0]}, "species": species,
                               **section}, seed=seed)
    for name, x in places.items():
        at = np.array([(p, 10.0) if isinstance(p, float) else p for p in x], np.float32)
        world.table(name).request(np.zeros(len(at), np.uint64),
                                  {(Position, "x"): at[:, 0], (Position, "y"): at[:, 1]})
    world.flush()
    return world


def test_equally_near_eaters_of_two_species_get_half_of_the_food_each():
    x = np.arange(300) % 15 * 4 + 2.0
    y = np.arange(300) // 15 * 3 + 2.0
    world = _world({"red": EATER, "grass": GRASS, "blue": EATER},
                   {"red": np.stack([x - 0.5, y], 1), "blue": np.stack([x + 0.5, y], 1),
                    "grass": np.stack([x, y], 1)})
    act(world, Feed)
    gained = {name: np.array(_energy(world, name)) > 0.5 for name in ("red", "blue")}
    assert gained["red"].sum() + gained["blue"].sum() == 300
    assert 120 < gained["red"].sum() < 180  # 150 expected, standard deviation 8.7


def test_equally_near_eaters_of_one_species_get_half_of_the_food_each():
    x, y = np.arange(300) % 15 * 4 + 2.0, np.arange(300) // 15 * 3 + 2.0
    world = _world({"red": EATER, "grass": GRASS},
                   {"red": np.stack([np.append(x - 0.5, x + 0.5), np.append(y, y)], 1),
                    "grass": np.stack([x, y], 1)})
    act(world, Feed)
    older = np.array(_energy(world, "red")[:300]) > 0.5
    assert 120 < older.sum() < 180


@pytest.mark.parametrize("names", [("aaa", "zzz"), ("zzz", "aaa")])
def test_the_nearer_eater_gets_the_food_whatever_the_order_of_species(names):
    far, close = names
    for order in (names, names[::-1]):
        world = _world(dict.fromkeys(order, EATER) | {"grass": GRASS},
                       {far: [12.5], close: [10.5], "grass": [10.0]})
        act(world, Feed)
        assert (_energy(world, far), _energy(world, close)) == ([0.5], [0.75])


def test_an_eater_of_several_kinds_takes_the_nearest_first_whatever_the_order_of_its_diet():
    for digestion, gained in ((5.0, 0.25), (0.0, 0.75)):
        for order in (("grass", "herb"), ("herb", "grass")):
            gain = {"grass": 0.25, "herb": 0.5}
            eater = EATER | {"diet": [{"eats": name, "reach": 3.0, "chance": 1.0, "gain": gain[name]}
                                      for name in order],
                             "metabolism": {"energy": 0.5, "energy_max": 9.0, "digestion": digestion}}
            world = _world({"red": eater, "grass": GRASS, "herb": GRASS},
                           {"red": [10.0], "grass": [11.0], "herb": [12.0]})
            act(world, Feed)
            assert _energy(world, "red") == [0.5 + gained]
            assert _eaten(world, "herb")[0] == [None if digestion else "eaten by red"]


def test_an_eater_that_is_full_after_its_nearest_food_leaves_the_other():
    eater = EATER | {"diet": [{"eats": name, "reach": 3.0, "chance": 1.0, "gain": 0.5, "until": 0.75}
                              for name in ("grass", "herb")]}
    world = _world({"red": eater, "grass": GRASS, "herb": GRASS},
                   {"red": [10.0], "grass": [12.0], "herb": [11.0]})
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
        world = _world({"red": EATER, "grass": GRASS, "wolf": hunter},
                       {"red": [10.0], "grass": [11.0], "wolf": [x]})
        act(world, Feed)
        assert _energy(world, "red") == [0.5 + gained]
        assert _energy(world, "wolf") == [1.0]
        assert _eaten(world, "red")[0] == ["eaten by wolf"]
        assert _eaten(world, "grass")[0] == ["eaten by red" if gained else None]


def test_food_exactly_in_reach_is_eaten_as_touch_reads_1_there():
    eater = EATER | {"diet": [{"eats": "grass", "chance": 1.0, "gain": 0.25, "reach": 0.0}],
                     "sensors": [{"kind": "touch", "target": "grass"}]}
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


def test_another_diet_or_another_metabolism_holds_from_the_next_meal_on(meadow):
    world = meadow(count=1, grass={"count": 3})
    deer = arrange(world, "deer", x=5, y=5, energy=0.125)
    species, grass = deer.species, arrange(world, "grass", x=[5.25, 4.5, 5.75], y=5)
    _eat(world)
    assert _energy(world) == [0.375]
    grass.cause[:], deer[Metabolism].digesting[:] = 0, 0
    species.diet = [species.diet[0].model_copy(update={"gain": 0.125})]
    _eat(world)
    assert _energy(world) == [0.5]
    grass.cause[:], deer[Metabolism].digesting[:] = 0, 0
    metabolism = species.config.metabolism.model_copy(update={"energy_max": 0.5625})
    species.config = species.config.model_copy(update={"metabolism": metabolism})
    _eat(world)
    assert _energy(world) == [0.5625]


def test_the_full_the_digesting_and_the_unwilling_do_not_eat(meadow):
    block = {"connections": [{"sensor": "energy", "action": "eat", "weight": -1, "below": 0.1}]}
    world = meadow(count=5, grass={"count": 5}, reflex=block,
                   metabolism={"energy": 0.5, "energy_max": 1.0, "digestion": 3.0})
    deer = arrange(world, "deer", x=[2, 6, 10, 14, 18], y=5, energy=[1.0, 0.5, 0.05, 0.875, 0.5],
                   digesting=[0, 1, 0, 0, 0])
    arrange(world, "grass", x=[2, 6, 10, 14, 18], y=5)
    _eat(world)
    assert _energy(world) == pytest.approx([1.0, 0.5, 0.05, 1.0, 0.75])
    assert deer[Metabolism].taken[deer.by_uid()].tolist() == [0, 0, 0, 0.125, 0.25]
    assert deer[Metabolism].digesting[deer.by_uid()].tolist() == [0, 1, 0, 3, 3]


def test_until_says_when_it_has_enough(meadow):
    world = meadow(count=2, grass={"count": 2}, diet=[{"eats": "grass", "gain": 0.25, "until": 0.5}])
    arrange(world, "deer", x=[2, 6], y=5, energy=[0.5, 0.499])
    arrange(world, "grass", x=[2, 6], y=5)
    _eat(world)
    assert _energy(world) == pytest.approx([0.5, 0.749])


def test_chance_is_per_second_of_contact_and_drawn_by_uid(meadow):
    n, p = 3000, 0.3
    for dt in (1.0, 0.5):
        world = meadow(
            world={"dt": dt, "space": {"size": [400.0, 400.0]}},
            count=n,
            grass={"count": n},
            diet=[{"eats": "grass", "gain": 0.25, "chance": p}],
        )
        x, y = 4.0 + 5 * (np.arange(n) % 75), 4.0 + 5 * (np.arange(n) // 75)
        deer = arrange(world, "deer", x=x, y=y, energy=0.5)
        arrange(world, "grass", x=x, y=y)
        _eat(world)
        ate = np.array(_energy(world)) > 0.6
        expected = 1 - (1 - p) ** dt
        assert abs(ate.mean() - expected) < 4 * np.sqrt(expected * (1 - expected) / n)
        assert (
            ate == (random.draw_many(world.key, deer.uid[deer.by_uid()], random.FEED) < np.float32(expected))
        ).all()


def test_who_is_eaten_eats_no_more_and_the_dead_are_not_eaten_again(meadow):
    wolf = {
        "count": 2,
        "body": {"radius": 0.5},
        "diet": [{"eats": "deer", "gain": 0.5}],
        "sensors": [{"kind": "own", "property": "energy"}],
        "actions": {"eat": ["eat"]},
        "automatic": ["eat"],
        "metabolism": {"energy": 0.25},
    }
    world = meadow(world={"species": {"wolf": wolf}}, grass={"count": 2})
    deer = arrange(world, "deer", x=[5, 15], y=5, energy=0.5)
    arrange(world, "grass", x=[5.75, 15], y=5)
    arrange(world, "wolf", x=[5.5, 10], y=5, energy=0.25)
    _eat(world)
    assert _energy(world, "wolf") == [0.75, 0.25]
    assert _eaten(world, "deer")[0] == ["eaten by wolf", None]
    assert _energy(world) == [0.5, 0.75]
    assert _eaten(world)[0] == [None, "eaten by deer"]
    arrange(world, "wolf", x=[10, 5.5], y=5)
    _eat(world)
    assert _energy(world, "wolf") == [0.75, 0.25]
    assert deer.killer[deer.by_uid()[0]] == world.tables["wolf"].uid[world.tables["wolf"].by_uid()[0]]


def test_objects_can_be_food(meadow):
    world = meadow(
        world={"objects": {"berry": {"at": [[5.0, 5.0], [9.0, 9.0]], "body": {"radius": 0.1}}}},
        diet=[{"eats": "berry", "gain": 0.125}]
    )
    arrange(world, "deer", x=[5, 15], y=5, energy=0.5)
    _eat(world)
    world.flush()
    assert _energy(world) == [0.625, 0.5]
    assert world.tables["berry"].n == 1


def test_eaters_of_their_own_kind_do_not_eat_themselves(meadow):
    world = meadow(count=3, diet=[{"eats": "deer", "gain": 0.25}])
    arrange(world, "deer", x=[5, 5.5, 15], y=5, energy=0.5)
    _eat(world)
    causes, killers = _eaten(world, "deer")
    first, second, _ = (int(u) for u in world.tables["deer"].uid[world.tables["deer"].by_uid()])
    assert (causes, killers) in ((["eaten by deer", None, None], [second, 0, 0]),
                                 ([None, "eaten by deer", None], [0, first, 0]))
    assert _energy(world) == ([0.5, 0.75, 0.5] if causes[0] else [0.75, 0.5, 0.5])


@pytest.mark.parametrize("edges", ["torus", "walls"])
def test_who_eats_what_is_that_of_the_slow_twin(meadow, edges):
    n, m = 150, 80
    rng = np.random.default_rng(8)
    size = [20.0, 15.0]
    world = meadow(
        world={"space": {"size": size, "edges": edges}}, count=n, grass={"count": m},
        diet=[{"eats": "grass", "gain": 0.25, "chance": 0.6}]
    )
    at, there = rng.random((n, 2)) * size, rng.random((m, 2)) * size
    at, there = at.astype(np.float32), there.astype(np.float32)
    deer = arrange(world, "deer", x=at[:, 0], y=at[:, 1], energy=rng.random(n), digesting=rng.random(n) < 0.1)
    grass = arrange(world, "grass", x=there[:, 0], y=there[:, 1])
    uid, rows = deer.uid[deer.by_uid()], deer.by_uid()
    energy = deer[Metabolism].energy[rows].astype(float)
    d = there[None].astype(float) - at[:, None]
    if edges == "torus":
        d -= np.array(size) * np.round(d / np.array(size))
    distance = np.hypot(d[..., 0], d[..., 1])
    wants = {}
    for i in range(n):
        j = distance[i].argmin()
        willing = energy[i] < 1 and not deer[Metabolism].digesting[rows[i]]
        if (willing and distance[i, j] <= 0.75
            and random.draw_many(world.key, uid[i : i + 1], random.FEED)[0] < 0.6):
            wants.setdefault(j, []).append((distance[i, j], uid[i], i))
    killers = np.zeros(m, np.uint64)
    for j, eaters in wants.items():
        _, killers[j], i = min(eaters)
        energy[i] = min(energy[i] + 0.25, 1)
    _eat(world)
    assert (grass.killer[grass.by_uid()] == killers).all()
    assert _energy(world) == pytest.approx(energy.tolist(), abs=1e-6)
    assert len(wants) > 10
    assert deer[Nervous].decision[rows, 6].all()
    assert (deer[Body].radius[rows] == 0.5).all()


def test_food_with_a_negative_gain_harms_and_the_books_say_so(meadow):
    world = meadow(diet=[{"eats": "grass", "gain": -0.25}])
    deer = arrange(world, "deer", x=[5, 15], y=5, energy=0.5)
    arrange(world, "grass", x=[5, 1], y=5)
    _eat(world)
    assert _energy(world) == [0.25, 0.5]
    assert deer[Metabolism].taken[deer.by_uid()].tolist() == [-0.25, 0]


def test_a_larger_one_of_its_kind_reaches_further(meadow):
    world = meadow()
    arrange(world, "deer", x=[5, 15], y=5, energy=0.5, radius=[3.0, 0.5])
    arrange(world, "grass", x=[8, 1], y=5)
    _eat(world)
    assert _energy(world) == [0.75, 0.5]


def test_what_is_deadly_kills_its_eater_and_says_so(meadow):
    world = meadow(count=2, grass={"count": 1},
                   diet=[{"eats": "grass", "reach": 0.25, "gain": 0.25, "deadly": True}])
    deer = arrange(world, "deer", x=[5, 15], y=5, energy=0.5)
    grass = arrange(world, "grass", x=5.5, y=5)
    _eat(world)
    rows = deer.by_uid()
    assert [world.causes[c - 1] if c else None for c in deer.cause[rows]] == ["poisoned by grass", None]
    assert deer.killer[rows].tolist() == [int(grass.uid[grass.rows()[0]]), 0]
    world.flush()
    assert (deer.n, grass.n) == (1, 0)


def test_poison_costs_its_eater_energy(meadow):
    world = meadow(count=1, grass={"count": 1, "defence": {"poison": 0.375}})
    deer = arrange(world, "deer", x=5, y=5, energy=0.5)
    arrange(world, "grass", x=5.5, y=5)
    _eat(world)
    assert _energy(world) == [0.375]  # 0.5 + 0.25 − 0.375
    assert deer[Metabolism].taken[deer.rows()].tolist() == [-0.125]


def test_tough_food_resists_its_share_of_bites(meadow):
    def eaten(toughness):
        size = {"space": {"size": [400.0, 20.0]}}
        world = meadow(world=size, count=150, grass={"count": 150, "defence": {"toughness": toughness}})
        x = np.linspace(1, 398, 150)
        arrange(world, "deer", x=x, y=5, energy=0.5)
        arrange(world, "grass", x=x, y=5.5)
        _eat(world)
        return sum(by is not None for by in _eaten(world)[0])

    assert eaten(0.0) == 150
    assert 85 < eaten(0.3) < 125
    assert eaten(1.0) == 0


@pytest.mark.parametrize("dt", [0.125, 0.5, 2.0])
def test_bites_into_tough_food_succeed_as_often_in_a_second_whatever_the_tick(meadow, dt):
    world = meadow(world={"dt": dt, "space": {"size": [80.0, 80.0]}}, count=400,
                   grass={"count": 400, "defence": {"toughness": 0.6}})
    at = 2.0 + 4.0 * np.stack(np.divmod(np.arange(400), 20), 1)
    for name in ("deer", "grass"):
        arrange(world, name, x=at[:, 0], y=at[:, 1], energy=0.5)
    _eat(world)
    chance = 1 - 0.6**dt
    eaten = int((world.tables["grass"].cause > 0).sum())
    assert abs(eaten - 400 * chance) < 4 * np.sqrt(400 * chance * (1 - chance))


def test_each_plant_is_as_tough_and_as_poisonous_as_its_genes(meadow):
    genes = [{"name": "thorn", "trait": "defence.toughness", "letters": 1, "values": [0, 0, 1, 1]},
             {"name": "venom", "trait": "defence.poison", "letters": 1,
              "values": [0, 0.5, 0, 0.5]}]  # fmt: skip
    world = meadow(world={"space": {"size": [400.0, 20.0]}}, count=60,
                   grass={"count": 60, "genome": {"genes": genes}})
    x = np.linspace(1, 398, 60)
    deer, grass = arrange(world, "deer", x=x, y=5, energy=0.5), arrange(world, "grass", x=x, y=5.5)
    _eat(world)
    for i, j in zip(deer.by_uid(), grass.by_uid(), strict=True):
        tough, poison = grass[Defence].toughness[j], grass[Defence].poison[j]
        assert bool(grass.cause[j]) == (tough == 0)
        assert deer[Metabolism].energy[i] == (0.5 if tough else 0.75 - poison)


def test_what_the_eaten_held_is_gained_to_a_share(meadow):
    diet = [{"eats": "grass", "reach": 0.25, "gain": 0.125, "efficiency": 0.5}]
    world = meadow(count=3, grass={"count": 3}, diet=diet)
    deer = arrange(world, "deer", x=[2, 8, 14], y=5, energy=[0.25, 0.25, 0.875])
    # owing is worth nothing; more than full is lost
    arrange(world, "grass", x=[2, 8, 14], y=5, energy=[0.5, -0.25, 0.5])
    _eat(world)
    assert _energy(world) == [0.625, 0.375, 1.0]
    assert deer[Metabolism].taken[deer.by_uid()].tolist() == [0.375, 0.125, 0.125]


def test_what_all_of_them_gained_is_counted_by_food(meadow):
    world = meadow(count=3, grass={"count": 3}, metabolism={"energy": 0.5, "energy_max": 1.0})
    arrange(world, "deer", x=[2, 8, 14], y=5, energy=[0.5, 0.875, 0.5])
    arrange(world, "grass", x=[2, 8, 18], y=5)
    _eat(world)
    assert world.tables["deer"].species.eaten == {"grass": 0.25 + 0.125}  # one is nearly full, one finds none
    _eat(world)  # what was eaten is still there until the tick is over, but nobody eats it again
    assert world.tables["deer"].species.eaten == {"grass": 0.0}
