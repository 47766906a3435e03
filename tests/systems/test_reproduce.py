import numpy as np
import pytest
from scipy.stats import poisson

from ecs_eco.components import Biology, Body, LifeHistory, Metabolism, Position
from ecs_eco.engine import random
from ecs_eco.life import broods
from ecs_eco.systems import Reproduce
from ecs_eco.testing import act, arrange, shuffle

WAY = {
    "kind": "asexual",
    "place": "anywhere",
    "rate": 1.0,
    "energy_min": 0.5,
    "energy_given": 0.25,
}  # 1 − 1/e a second
FREE = WAY | {"energy_min": 0.0, "energy_given": 0.0}


def _born(world):
    """Let deer reproduce; return the uids of parents in the order of the newborn's uids,
    and the rows of the newborn."""
    born = []
    world.on_birth.append(lambda table, rows, parents, _: born.append((parents.tolist(), rows)))
    act(world, Reproduce)
    world.flush()
    return born[0] if born else ([], np.zeros(0, int))


@pytest.mark.definition("3 reproduction")
def test_the_fed_and_grown_give_birth_with_their_chance_and_pay(meadow):
    way = WAY | {"age_min": 10.0}
    world = meadow(count=200, world={"space": {"size": [400.0, 400.0]}}, reproduction=way)
    energy = np.where(np.arange(200) % 4 == 0, 0.49, 0.75)
    age = np.where(np.arange(200) % 4 == 1, 9.0, 20.0)
    deer = arrange(world, "deer", energy=energy, age=age, fertility=0.5)
    uid = deer.uid[deer.by_uid()]
    draws = random.draw_many(world.key, uid, random.BIRTH)
    # a Poisson number at the rate times fertility, at most the two after which it is no longer fed
    times = (draws[:, None] < poisson.sf([0, 1], 0.5)).sum(1) * ((energy >= 0.5) & (age >= 10))
    parents, rows = _born(world)
    assert parents == np.repeat(uid, times).tolist()
    assert sorted(set(times.tolist())) == [0, 1, 2]
    m = deer[Metabolism]
    old = deer.by_uid()[:200]
    assert m.energy[old] == pytest.approx(energy - 0.25 * times, abs=1e-6)
    assert m.given[old].tolist() == (0.25 * times).tolist()
    assert m.energy[rows].tolist() == [0.25] * len(parents)
    assert deer[Biology].age[rows].tolist() == [0] * len(parents)


def test_the_newborn_lands_anywhere_or_within_dispersal_of_its_parent(meadow):
    for way in (
        WAY,
        WAY | {"place": "near", "dispersal": 3.0},
        WAY | {"kind": "simplified", "place": "near", "dispersal": 3.0},
    ):
        world = meadow(
            count=300, world={"space": {"size": [100.0, 80.0]}}, reproduction=way, body={"radius": 0.05}
        )
        deer = arrange(world, "deer", energy=1.0)
        parents, rows = _born(world)
        p = deer[Position]
        at = {u: world.locate(u)[1] for u in parents}
        d = np.array([[p.x[r] - p.x[at[u]], p.y[r] - p.y[at[u]]] for u, r in zip(parents, rows, strict=True)])
        d -= np.array([100, 80]) * np.round(d / np.array([100, 80]))
        distance = np.hypot(*d.T)
        assert len(rows) > 120
        if "dispersal" in way:
            assert distance.max() <= 3.001
            assert abs((distance**2).mean() - 4.5) < 0.8  # even over the disc: half of its radius squared
        else:
            assert (distance > 10).mean() > 0.8
            assert np.histogram2d(p.x[rows], p.y[rows], 3, [(0, 100), (0, 80)])[0].min() > 5


def test_no_newborn_where_a_body_is_and_none_pays_for_a_birth_that_fails(meadow):
    tree = {"objects": {"tree": {"count": 150, "body": {"radius": 1.5}}}}
    world = meadow(count=60, world=tree, reproduction=WAY, body={"radius": 0.3})
    deer = arrange(world, "deer", energy=1.0)
    old = deer.by_uid()
    parents, rows = _born(world)
    p, t = deer[Position], world.tables["tree"]
    for r in rows:
        for table, reach, others in ((deer, 0.6, old), (t, 1.8, t.rows())):
            q = table[Position]
            d = np.stack([q.x[others] - p.x[r], q.y[others] - p.y[r]])
            d -= 20 * np.round(d / 20)
            assert np.hypot(*d).min() >= reach - 1e-4
    paid = {int(deer.uid[r]) for r in old if deer[Metabolism].energy[r] < 1}
    assert paid == set(parents)
    assert 0 < len(parents) < 20  # most found no room


def test_spacing_keeps_the_newborn_from_others_of_its_kind_and_from_each_other(meadow):
    world = meadow(count=20, reproduction=WAY | {"spacing": 3.0}, body={"radius": 0.05})
    deer = arrange(world, "deer", energy=1.0, x=np.linspace(0, 19, 20), y=1.0)
    parents, rows = _born(world)
    p, everyone = deer[Position], deer.rows()
    for r in rows:
        others = everyone[everyone != r]
        d = np.stack([p.x[others] - p.x[r], p.y[others] - p.y[r]])
        d -= 20 * np.round(d / 20)
        assert np.hypot(*d).min() >= 3 - 1e-4
    assert len(parents) >= 2


def test_spacing_holds_between_newborn_that_were_moved_out_of_the_way_of_bodies(meadow):
    tree = {"space": {"size": [60.0, 60.0]}, "objects": {"tree": {"count": 300, "body": {"radius": 1.5}}}}
    world = meadow(
        count=60, world=tree, reproduction=WAY | {"spacing": 3.0}, body={"radius": 0.05, "opaque": False}
    )
    deer = arrange(world, "deer", energy=1.0, x=1.0, y=1.0)
    _, rows = _born(world)
    p = deer[Position]
    d = np.stack([p.x[rows] - p.x[rows][:, None], p.y[rows] - p.y[rows][:, None]])
    d -= 60 * np.round(d / 60)
    apart = np.hypot(*d)[~np.eye(len(rows), dtype=bool)]
    assert len(rows) >= 5
    assert apart.min() >= 3 - 1e-4


def test_a_place_given_up_for_a_body_keeps_no_other_away(meadow):
    tree = {"objects": {"tree": {"count": 60, "body": {"radius": 1.5}}}}
    world = meadow(
        count=1,
        world=tree,
        reproduction=WAY | {"rate": 1.0, "spacing": 8.0},
        body={"radius": 0.05, "opaque": False},
    )
    trees, uid = world.tables["tree"], world.tables["deer"].uid[:1]
    q, n = trees[Position], 0
    for world.tick in range(300):
        arrange(world, "deer", energy=0.7, x=0.0, y=0.0)  # for one birth
        expected = []
        for attempt in range(8):
            at = [
                random.draw_many(world.key, uid, random.PLACE + (axis << 8) + (attempt << 10))[0] * 20
                for axis in (0, 1)
            ]
            d = np.stack([q.x[trees.rows()] - at[0], q.y[trees.rows()] - at[1]])
            far = np.hypot(*(np.array(at) - 20 * np.round(np.array(at) / 20))) >= 8
            if not far or np.hypot(*(d - 20 * np.round(d / 20))).min() >= 1.55:
                expected = [at] if far else []
                break
        if random.draw_many(world.key, uid, random.BIRTH)[0] < 1 - np.exp(-1):
            act(world, Reproduce)
            births, world.tables["deer"].births = world.tables["deer"].births, []
            places = [[v[Position, axis][0] for axis in "xy"] for _, _, v in births]
            assert np.ravel(places) == pytest.approx(np.ravel(expected))
            n += len(births) * (attempt > 0)
    assert n >= 8


def test_a_litter_is_as_many_as_the_parent_can_pay_for_and_live(meadow):
    way = WAY | {"rate": 1e3, "litter": 3, "energy_min": 0.25}
    world = meadow(count=5, world={"dt": 1e-3, "space": {"size": [400.0, 400.0]}}, reproduction=way)
    deer = arrange(world, "deer", energy=[0.25, 0.5, 0.51, 0.75, 0.76])
    old = deer.by_uid()
    keys = ((tick, random.tick_key(world.seed, tick)) for tick in range(9999))
    world.tick = next(
        tick for tick, key in keys if (random.draw_many(key, deer.uid[old], random.BIRTH) < 0.6).all()
    )
    parents, rows = _born(world)
    assert parents == np.repeat(deer.uid[old], [0, 1, 2, 2, 3]).tolist()
    m = deer[Metabolism]
    assert m.energy[old] == pytest.approx([0.25, 0.25, 0.01, 0.25, 0.01], abs=1e-6)
    assert m.given[old].tolist() == [0, 0.25, 0.5, 0.5, 0.75]
    assert m.energy[rows].tolist() == [0.25] * 8
    for field in ("x", "y", "heading"):
        assert len(set(deer.field(Position, field)[rows].tolist())) == 8


def test_the_organisms_own_life_history_replaces_that_of_the_species(meadow):
    world = meadow(count=200, world={"space": {"size": [400.0, 400.0]}}, reproduction=WAY | {"age_min": 1e3})
    deer = world.tables["deer"]
    deer.add_component(LifeHistory)
    kind = np.arange(200) % 4
    arrange(
        world,
        "deer",
        energy=0.75,
        age=20,
        age_min=np.where(kind == 0, 21, 20),
        energy_min=np.where(kind == 1, 0.76, 0.75),
        energy_given=np.where(kind == 2, 0.125, 0.25),
        litter=np.where(kind == 3, 2.4, 1.4),
    )
    old, (parents, rows) = deer.by_uid(), _born(world)
    draws = random.draw_many(world.key, deer.uid[old], random.BIRTH) < 1 - np.exp(-1)
    number = np.where(draws, np.array([0, 0, 1, 2])[kind], 0)
    assert parents == np.repeat(deer.uid[old], number).tolist()
    assert (
        deer[Metabolism].energy[rows].tolist() == np.repeat(np.where(kind == 2, 0.125, 0.25), number).tolist()
    )
    assert (
        deer[Metabolism].energy[old].tolist() == (0.75 - number * np.where(kind == 2, 0.125, 0.25)).tolist()
    )


def test_what_heredity_says_of_a_newborn_holds(meadow):
    class Fake:
        def offspring(self, world, table, first, second, who):
            self.arguments = first.tolist(), second, who.tolist()
            return {(Body, "radius"): np.arange(len(who), dtype=np.float32)}

    world = meadow(count=30, world={"space": {"size": [400.0, 400.0]}}, reproduction=WAY | {"litter": 2})
    deer = arrange(world, "deer", energy=0.9)  # for one birth
    deer.species.heredity = fake = Fake()
    parents, rows = _born(world)
    assert deer.uid[fake.arguments[0]].tolist() == parents
    assert fake.arguments[1] is None
    assert fake.arguments[2][::2] == parents[::2]
    assert len(set(fake.arguments[2])) == len(parents) > 20
    assert deer[Body].radius[rows].tolist() == list(range(len(rows)))


def test_max_count_leaves_room_for_those_that_are_drawn(meadow):
    world = meadow(count=10, max_count=12, world={"space": {"size": [400.0, 400.0]}}, reproduction=WAY)
    deer = arrange(world, "deer", energy=1.0)
    uid = deer.uid[deer.by_uid()]
    ready = uid[random.draw_many(world.key, uid, random.BIRTH) < 1 - np.exp(-1)]
    wanted = (random.draw_many(world.key, uid, random.BIRTH)[:, None] < poisson.sf([0, 1, 2], 1.0)).sum()
    lots = [random.bits(world.key, one, random.LOT) for one in ready]
    shuffle(world, 3)
    assert _born(world)[0] == sorted(ready[np.argsort(lots)[:2]].tolist())
    assert deer.species.refused == wanted - 2 >= len(ready) - 2 > 0
    assert _born(world)[0] == []


def _crowd(meadow, seed, **deer):
    """A population at its `max_count`, of whom one in twenty dies at random in a tick."""
    return meadow(
        **{
            "count": 60,
            "max_count": 60,
            "age": [0.0, 60.0],
            "fertility": 0.5,
            "metabolism": {"energy": 1.0, "photosynthesis": 1.0, "basal": 0.0},
            "reproduction": WAY | {"energy_given": 0.125},
            "world": {
                "space": {"size": [400.0, 400.0]},
                "seed": seed,
                "land_use": [{"kind": "harvest", "species": "deer", "rate": 0.05}],
            },
        }
        | deer
    )


def test_under_max_count_parents_are_of_any_age(meadow):
    world, ranks = _crowd(meadow, 1), []

    def note(table, rows, parents, _):
        if table.name == "deer":
            living = np.sort(table.uid[table.alive])
            living = living[living < table.uid[rows].min()]
            ranks.extend(np.searchsorted(living, parents) / (living.size - 1))

    world.on_birth.append(note)
    world.run(150)
    assert world.tables["deer"].n >= 50
    assert len(ranks) > 300
    assert abs(np.mean(ranks) - 0.5) < 4 * np.sqrt(1 / 12 / len(ranks))  # 0 is the oldest


def test_under_max_count_a_gene_that_delays_breeding_by_a_mean_life_disappears(meadow):
    gene = {"name": "late", "trait": "reproduction.age_min", "letters": 1, "values": [0.0, 20.0]}
    world = _crowd(meadow, 4, genome={"alphabet": "01", "mutate": {"indpb": 0.0}, "genes": [gene]})
    deer = world.tables["deer"]
    assert 0.3 < np.mean(deer[LifeHistory].age_min[deer.rows()] > 0) < 0.7
    world.run(200)
    assert np.mean(deer[LifeHistory].age_min[deer.rows()] > 0) < 0.1


def test_the_series_says_how_many_births_max_count_refused(meadow):
    limited, free = (_crowd(meadow, 2, max_count=most).run(1).series().to_pydict() for most in (60, 999))
    deer = limited["species"].index("deer")
    assert limited["refused"][deer] == free["births"][deer] - limited["births"][deer] > 10
    assert not any(free["refused"])


def test_who_gets_a_place_below_max_count_does_not_depend_on_rows(meadow):
    one, other = _crowd(meadow, 3).run(20), _crowd(meadow, 3)
    for _ in range(20):
        shuffle(other, other.tick).run(1)
    assert one.digest() == other.digest()


def test_immigrants_share_the_room_below_max_count_with_the_newborn(meadow):
    way, came, expected = WAY | {"immigration": 10.0}, 0, 0.0
    world = meadow(count=10, max_count=13, world={"space": {"size": [400.0, 400.0]}}, reproduction=way)
    deer = world.tables["deer"]
    for world.tick in range(100):
        arrange(world, "deer", energy=1.0)
        act(world, Reproduce)
        born, deer.births = deer.births, []
        assert sum(parents.size for parents, _, _ in born) == 3
        came += sum((parents == 0).sum() for parents, _, _ in born)
        ready = (random.draw_many(world.key, deer.uid[deer.rows()], random.BIRTH) < 1 - np.exp(-1)).sum()
        expected += 3 * 10 / (10 + ready)
    assert abs(came - expected) < 36  # four standard deviations


@pytest.mark.parametrize("most", [broods.MOST_PAIRS, -1])
def test_of_newborn_too_near_to_each_other_any_may_get_its_place(meadow, monkeypatch, most):
    monkeypatch.setattr(broods, "MOST_PAIRS", most)
    world = meadow(
        count=30,
        world={"space": {"size": [60.0, 60.0]}},
        body={"radius": 0.1, "opaque": False},
        reproduction=FREE,
    )
    deer, ranks = arrange(world, "deer", energy=1.0, x=1.0, y=1.0), []
    way = deer.species.reproduction.model_copy(update={"spacing": 15.0})
    deer.species.section = deer.species.section.model_copy(update={"reproduction": way})
    first = int(deer.uid[deer.by_uid()[0]])
    for world.tick in range(60):
        act(world, Reproduce)
        for parents, _, _ in deer.births:
            ranks += [(int(uid) - first) / 29 for uid in parents]
        deer.births = []
    assert 200 < len(ranks) < 900
    assert abs(np.mean(ranks) - 0.5) < 4 * np.sqrt(1 / 12 / len(ranks))  # 0 is the oldest


def test_a_species_without_an_energy_budget_has_grandchildren(meadow):
    world = meadow(
        count=40,
        world={"space": {"size": [400.0, 400.0]}},
        reproduction=FREE | {"kind": "asexual", "rate": 0.2, "dispersal": 9.0},
    )
    deer = arrange(world, "deer", energy=0.0)
    founders, parents = deer.uid[deer.by_uid()].max(), []
    world.on_birth.append(lambda table, rows, first, _: parents.extend(first.tolist()))
    for world.tick in range(10):
        act(world, Reproduce)
        world.flush()
    assert sum(uid > founders for uid in parents) > 20


def test_max_count_counts_those_who_wait_to_be_born(meadow):
    world = meadow(count=10, max_count=12, world={"space": {"size": [400.0, 400.0]}}, reproduction=WAY)
    deer = arrange(world, "deer", energy=1.0)
    deer.request(np.zeros(2, np.uint64), {})
    assert _born(world)[0] == [0, 0]
    assert deer.n == 12


@pytest.mark.definition("1 sex")
def test_sexes_are_drawn_where_they_are_random(meadow):
    world = meadow(count=400, sex="random", world={"space": {"size": [400.0, 400.0]}}, reproduction=WAY)
    deer = arrange(world, "deer", energy=1.0)
    assert set(deer[Biology].sex[deer.rows()].tolist()) == {1, 2}
    _, rows = _born(world)
    sex = deer[Biology].sex[rows]
    assert abs((sex == 1).mean() - 0.5) < 0.15
    assert set(sex.tolist()) == {1, 2}
    assert meadow(sex="female").tables["deer"][Biology].sex[:2].tolist() == [1, 1]


@pytest.mark.definition("1 fertility")
def test_the_infertile_and_worlds_in_training_have_no_births(meadow):
    world = meadow(count=50, fertility=0.0, reproduction=WAY)
    arrange(world, "deer", energy=1.0)
    assert _born(world)[0] == []
    world = meadow(count=50, reproduction=WAY)
    arrange(world, "deer", energy=1.0)
    world.reproduction = False
    assert _born(world)[0] == []


def test_in_a_volume_the_newborn_land_at_all_heights(meadow):
    world = meadow(count=200, world={"space": {"size": [100.0, 100.0, 50.0]}}, reproduction=WAY)
    deer = arrange(world, "deer", energy=1.0, z=25)
    _, rows = _born(world)
    assert np.histogram(deer[Position].z[rows], 3, (0, 50))[0].min() > 20


def test_immigrants_come_without_parents_at_their_rate_to_all_depths(meadow):
    way = WAY | {"rate": 0.0, "immigration": 2.25}
    world = meadow(count=1, world={"space": {"size": [50.0, 50.0, 20.0]}}, reproduction=way)
    born = []
    world.on_birth.append(lambda table, rows, parents, _: born.append((table[Position].z[rows], parents)))
    for tick in range(400):
        world.tick = tick
        act(world, Reproduce)
        world.flush()
    depths = np.concatenate([z for z, _ in born])
    assert not np.concatenate([p for _, p in born]).any()
    assert {len(z) for z, _ in born} == {2, 3}
    assert depths.size == world.tables["deer"].n - 1
    assert depths.size == pytest.approx(900, abs=35)  # four standard deviations
    assert np.histogram(depths, 4, (0, 20))[0].min() > 180


def test_plants_divide_also_where_animals_are_only_trained(meadow):
    world = meadow(grass={"count": 50, "reproduction": WAY, "metabolism": {"energy": 0.9}})
    world.reproduction = False
    act(world, Reproduce)
    world.flush()
    assert world.tables["grass"].n > 60
    assert world.tables["deer"].n == 2
