import numpy as np
import pytest

from ecs_eco.components import Body, Defence, Metabolism, Nervous, Traits
from ecs_eco.engine import random
from ecs_eco.engine.errors import ConfigError
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


def test_another_diet_or_another_metabolism_holds_from_the_next_meal_on(meadow):
    world = meadow(count=1, grass={"count": 3})
    deer = arrange(world, "deer", x=5, y=5, energy=0.125)
    species, grass = deer.species, arrange(world, "grass", x=[5.25, 4.5, 5.75], y=5)
    _eat(world)
    assert _energy(world) == [0.375]
    grass.cause[:], deer[Metabolism].digesting[:] = 0, 0
    diet = [species.diet[0].model_copy(update={"gain": 0.125})]
    species.section = species.section.model_copy(update={"diet": diet})
    _eat(world)
    assert _energy(world) == [0.5]
    grass.cause[:], deer[Metabolism].digesting[:] = 0, 0
    metabolism = species.metabolism.model_copy(update={"energy_max": 0.5625})
    species.section = species.section.model_copy(update={"metabolism": metabolism})
    _eat(world)
    assert _energy(world) == [0.5625]


def test_the_full_the_digesting_and_the_unwilling_do_not_eat(meadow):
    block = {"connections": [{"sensor": "energy", "action": "eat", "weight": -1, "below": 0.1}]}
    world = meadow(
        count=5,
        grass={"count": 5},
        reflex=block,
        metabolism={"energy": 0.5, "energy_max": 1.0, "handling_time": 3.0},
    )
    deer = arrange(
        world,
        "deer",
        x=[2, 6, 10, 14, 18],
        y=5,
        energy=[1.0, 0.5, 0.05, 0.875, 0.5],
        digesting=[0, 1, 0, 0, 0],
    )
    arrange(world, "grass", x=[2, 6, 10, 14, 18], y=5)
    _eat(world)
    assert _energy(world) == pytest.approx([1.0, 0.5, 0.05, 1.0, 0.75])
    assert deer[Metabolism].taken[deer.by_uid()].tolist() == [0, 0, 0, 0.125, 0.25]
    assert deer[Metabolism].digesting[deer.by_uid()].tolist() == [0, 1, 0, 3, 3]


def test_until_says_when_it_has_enough(meadow):
    world = meadow(count=2, grass={"count": 2}, diet=[{"eats": "grass", "gain": 0.25, "satiation": 0.5}])
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
        "always_on": ["eat"],
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
        diet=[{"eats": "berry", "gain": 0.125}],
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
    assert (causes, killers) in (
        (["eaten by deer", None, None], [second, 0, 0]),
        ([None, "eaten by deer", None], [0, first, 0]),
    )
    assert _energy(world) == ([0.5, 0.75, 0.5] if causes[0] else [0.75, 0.5, 0.5])


@pytest.mark.parametrize("edges", ["torus", "walls"])
def test_who_eats_what_is_that_of_the_slow_twin(meadow, edges):
    n, m = 150, 80
    rng = np.random.default_rng(8)
    size = [20.0, 15.0]
    world = meadow(
        world={"space": {"size": size, "edges": edges}},
        count=n,
        grass={"count": m},
        diet=[{"eats": "grass", "gain": 0.25, "chance": 0.6}],
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
        if (
            willing
            and distance[i, j] <= 0.75
            and random.draw_many(world.key, uid[i : i + 1], random.FEED)[0] < 0.6
        ):
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
    world = meadow(
        count=2, grass={"count": 1}, diet=[{"eats": "grass", "reach": 0.25, "gain": 0.25, "deadly": True}]
    )
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


EYES = [
    {"kind": "own", "property": "energy"},
    {"kind": "nearest", "name": "eye", "target": "grass", "range": 3.0, "fov": np.pi},
]
CONFUSED = [{"eats": "grass", "reach": 0.25, "gain": 0.25, "chance": 0.8, "confusion": "eye"}]


@pytest.mark.parametrize("dt", [1.0, 0.5])
def test_prey_in_view_confuse_their_eater(meadow, dt):
    n = 400  # places, 10 m apart, each with a deer that looks east
    size = {"dt": dt, "space": {"size": [200.0, 200.0]}}
    world = meadow(world=size, count=n, grass={"count": 4 * n}, diet=CONFUSED, sensors=EYES)
    x, y = 5.0 + 10 * (np.arange(n) % 20), 5.0 + 10 * (np.arange(n) // 20)
    deer = arrange(world, "deer", x=x, y=y, heading=0, energy=0.5)
    # one in reach, one 2 m to the northeast, one behind, and one beyond the range: two are in view
    east, north = np.array([0.5, np.sqrt(2), -1.0, 3.5]), np.array([0.0, np.sqrt(2), 0.0, 0.0])
    arrange(world, "grass", x=(x[:, None] + east).ravel(), y=(y[:, None] + north).ravel())
    _eat(world)
    ate = np.array(_energy(world)) > 0.6
    chance = np.float32(1 - (1 - 0.8 / 2) ** dt)
    assert (ate == (random.draw_many(world.key, deer.uid[deer.by_uid()], random.FEED) < chance)).all()
    assert 0 < ate.mean() < 1


def test_prey_behind_are_not_caught_by_an_eater_that_aims(meadow):
    for confusion in (None, "eye"):
        diet = [CONFUSED[0] | {"chance": 1.0, "confusion": confusion}]
        world = meadow(count=2, grass={"count": 2}, diet=diet, sensors=EYES)
        arrange(world, "deer", x=[5, 15], y=5, heading=[0, np.pi], energy=0.5)
        arrange(world, "grass", x=[5.5, 15.5], y=5)
        _eat(world)
        assert _energy(world) == [0.75, 0.5 if confusion else 0.75]


def test_a_gene_for_the_field_of_view_decides_how_many_prey_confuse(meadow):
    gene = {"name": "view", "trait": "sensors.eye.fov", "letters": 1, "values": [0.5, 0.5, 6.28, 6.28]}
    diet = [CONFUSED[0] | {"chance": 1.0}]
    size = {"space": {"size": [200.0, 200.0]}}
    n = 400
    world = meadow(
        world=size, count=n, grass={"count": 4 * n}, diet=diet, sensors=EYES, genome={"genes": [gene]}
    )
    x, y = 5.0 + 10 * (np.arange(n) % 20), 5.0 + 10 * (np.arange(n) // 20)
    deer = arrange(world, "deer", x=x, y=y, heading=0, energy=0.5)
    east = np.array([0.5, -1.5, -2.0, -2.5])  # one ahead; three behind, to the left
    arrange(world, "grass", x=(x[:, None] + east).ravel(), y=(y[:, None] + [0, 1, 1, 1]).ravel())
    _eat(world)
    rows = deer.by_uid()
    wide = deer[Traits].value[rows, 0] > 1
    draws = random.draw_many(world.key, deer.uid[rows], random.FEED)
    assert 0.3 < wide.mean() < 0.7
    assert ((np.array(_energy(world)) > 0.6) == np.where(wide, draws < 0.25, True)).all()


def test_an_eater_without_the_sensor_cannot_aim(meadow):
    gene = {"name": "blind", "trait": "sensors.eye.present", "letters": 1, "values": [0, 0, 1, 1]}
    size, diet = {"space": {"size": [400.0, 20.0]}}, [CONFUSED[0] | {"chance": 1.0}]
    world = meadow(
        world=size, count=40, grass={"count": 40}, diet=diet, sensors=EYES, genome={"genes": [gene]}
    )
    x = 5.0 + 9.0 * np.arange(40)
    deer = arrange(world, "deer", x=x, y=5, heading=0, energy=0.5)
    arrange(world, "grass", x=x + 0.5, y=5)
    _eat(world)
    sees = deer[Traits].value[deer.by_uid(), 0] == 1
    assert 5 < sees.sum() < 35
    assert _energy(world) == np.where(sees, 0.75, 0.5).tolist()


def test_a_sensor_that_does_not_see_the_food_cannot_aim_at_it(meadow):
    with pytest.raises(ConfigError, match=r"eyes"):
        meadow(diet=[CONFUSED[0] | {"confusion": "eyes"}], sensors=EYES)
    with pytest.raises(ConfigError, match=r"confusion"):
        meadow(diet=CONFUSED, sensors=[*EYES[:1], EYES[1] | {"target": "deer"}])


@pytest.mark.parametrize("dt", [0.125, 0.5, 2.0])
def test_bites_into_tough_food_succeed_as_often_in_a_second_whatever_the_tick(meadow, dt):
    world = meadow(
        world={"dt": dt, "space": {"size": [80.0, 80.0]}},
        count=400,
        grass={"count": 400, "defence": {"toughness": 0.6}},
    )
    at = 2.0 + 4.0 * np.stack(np.divmod(np.arange(400), 20), 1)
    for name in ("deer", "grass"):
        arrange(world, name, x=at[:, 0], y=at[:, 1], energy=0.5)
    _eat(world)
    chance = 1 - 0.6**dt
    eaten = int((world.tables["grass"].cause > 0).sum())
    assert abs(eaten - 400 * chance) < 4 * np.sqrt(400 * chance * (1 - chance))


@pytest.mark.parametrize("dt", [0.125, 1.0])
def test_bites_into_tough_food_succeed_with_the_chance_of_each_eater(meadow, dt):
    gene = {"name": "skill", "trait": "diet.grass.chance", "letters": 1, "values": [0.1, 0.2, 0.5, 1.0]}
    world = meadow(
        world={"dt": dt, "space": {"size": [80.0, 80.0]}},
        count=400,
        grass={"count": 400, "defence": {"toughness": 0.5}},
        diet=[{"eats": "grass", "gain": 0.25, "chance": 0.9}],
        genome={"genes": [gene]},
    )
    at = 2.0 + 4.0 * np.stack(np.divmod(np.arange(400), 20), 1)
    deer = arrange(world, "deer", x=at[:, 0], y=at[:, 1], energy=0.5)
    arrange(world, "grass", x=at[:, 0], y=at[:, 1], energy=0.5)
    _eat(world)
    rows = deer.by_uid()
    chance = 1 - (1 - 0.5 * deer[Traits].value[rows, 0].astype(float)) ** dt
    draws = random.draw_many(world.key, deer.uid[rows], random.FEED)
    assert ((np.array(_energy(world)) > 0.6) == (draws < chance.astype(np.float32))).all()
    assert np.unique(chance).size == 4


def test_each_plant_is_as_tough_and_as_poisonous_as_its_genes(meadow):
    genes = [
        {"name": "thorn", "trait": "defence.toughness", "letters": 1, "values": [0, 0, 1, 1]},
        {"name": "venom", "trait": "defence.poison", "letters": 1, "values": [0, 0.5, 0, 0.5]},
    ]
    world = meadow(
        world={"space": {"size": [400.0, 20.0]}}, count=60, grass={"count": 60, "genome": {"genes": genes}}
    )
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
