"""Mating: who conceives by whom, what it costs, and the kernels against plain loops."""

import numpy as np
import pytest

from ecs_eco.components import Biology, Body, Genome, Gestation, LifeHistory, Metabolism, Nervous, Position
from ecs_eco.engine import random
from ecs_eco.systems import Mate
from ecs_eco.systems.mate import MEET, TASTE, TIE
from ecs_eco.testing import arrange, check_system, difference, shuffle, state
from tests.systems.couples import FEMALE, MALE, WAY, WIDE, couples_of, mate, mix, plain_draw, values_by_uid


@pytest.mark.definition("3 reproduction")
def test_a_female_conceives_by_a_male_if_both_are_old_and_fed_enough_rested_and_not_pregnant(meadow):
    world = couples_of(meadow, 13, reproduction={"age_min": 10.0, "gestation": 5.0, "litter": 3})
    age, energy, sex = np.full((13, 2), 10.0), np.full((13, 2), 0.5), np.tile([FEMALE, MALE], (13, 1))
    rest, carrying, cause = np.zeros((13, 2), int), np.zeros((13, 2), int), np.zeros((13, 2), int)
    age[1, 0] = age[2, 1] = 9.9
    energy[3, 0] = energy[4, 1] = 0.49
    sex[5], sex[6] = FEMALE, MALE
    rest[7, 0] = rest[8, 1] = 1
    carrying[9, 0] = 2
    cause[10, 0] = cause[11, 1] = 1
    sex[12] = MALE, FEMALE
    flat = {"age": age, "energy": energy, "sex": sex, "rest": rest, "carrying": carrying}
    deer = arrange(world, "deer", **{k: v.ravel() for k, v in flat.items()})
    deer.cause[deer.by_uid()] = cause.ravel()
    # 18 was pregnant, by nobody known
    assert mate(world) == {0: 1, 18: -int(deer.uid[deer.by_uid()[0]]), 25: 24}
    assert values_by_uid(world, Gestation, "carrying")[[0, 18, 25]].tolist() == [3, 2, 3]
    assert values_by_uid(world, Gestation, "due")[[0, 18, 25]].tolist() == [5, 0, 5]


def test_who_rests_until_a_tick_mates_in_that_tick(meadow):
    world = couples_of(meadow, 2)
    world.tick = 7
    arrange(world, "deer", rest=[7, 0, 0, 8])
    assert mate(world) == {0: 1}


@pytest.mark.parametrize(("x", "meets"), [(1.99, True), (2.01, False), (18.01, True), (17.99, False)])
def test_mates_meet_within_reach_beyond_their_bodies_also_around_the_torus(meadow, x, meets):
    world = meadow(sex="random", reproduction=WAY)
    arrange(world, "deer", x=[0.0, x], y=5.0, sex=[FEMALE, MALE], energy=0.75)
    assert mate(world) == ({0: 1} if meets else {})


def test_larger_bodies_meet_from_farther(meadow):
    world = meadow(sex="random", reproduction=WAY)
    arrange(world, "deer", x=[0.0, 2.9], y=5.0, sex=[FEMALE, MALE], energy=0.75, radius=[0.5, 1.5])
    assert mate(world) == {0: 1}


@pytest.mark.parametrize(("consent", "couples"), [("both", [3]), ("one", [1, 2, 3]), ("none", [0, 1, 2, 3])])
def test_consent_is_of_both_of_one_or_of_nobody(meadow, consent, couples):
    world = couples_of(meadow, 4, actions={"mate": ["mate"]}, reproduction={"consent": consent})
    decision = np.zeros((8, 8), int)  # the gaits, the turns, eat, mate
    decision[:, 7] = [0, 0, 0, 1, 1, 0, 1, 1]
    arrange(world, "deer", decision=decision)
    assert list(mate(world)) == [2 * c for c in couples]


@pytest.mark.parametrize("consent", ["both", "one", "none"])
def test_a_species_without_the_action_is_always_willing(meadow, consent):
    assert mate(couples_of(meadow, 2, reproduction={"consent": consent})) == {0: 1, 2: 3}


def test_of_two_hermaphrodites_one_conceives(meadow):
    world = meadow(count=2, reproduction=WAY)
    arrange(world, "deer", x=[5.0, 6.0], y=5.0, energy=0.75)
    pair = mate(world)
    assert pair in ({0: 1}, {1: 0})
    assert mate(world) == pair  # and neither the pregnant nor the other has whom to mate with
    world = meadow(count=3, reproduction=WAY)
    arrange(world, "deer", x=[5.0, 6.5, 7.0], y=5.0, energy=0.75)
    assert mate(world) in ({1: 2}, {2: 1})  # the first wants 1, who has mated
    assert mate(meadow(count=1, reproduction=WAY)) == {}


def test_the_older_of_two_hermaphrodites_bears_the_young_no_more_often_than_the_younger(meadow):
    world = meadow(count=400, reproduction=WAY, world=WIDE)
    x = np.repeat(10.0 * np.arange(200), 2) + np.tile([0.0, 1.0], 200)
    arrange(world, "deer", x=x % 400, y=10.0 + 10 * np.floor(x / 400), energy=0.75)
    mothers = np.array(list(mate(world)))
    assert mothers.size == 200
    assert abs((mothers % 2 == 0).sum() - 100) < 29  # four standard deviations


def test_of_equally_rich_and_near_mates_each_is_chosen_as_often(meadow):
    world = meadow(count=3, sex="random", reproduction=WAY | {"choice": "richest"})
    chosen = []
    for world.tick in range(100):
        arrange(world, "deer", x=[5.0, 4.0, 6.0], y=5.0, sex=[FEMALE, MALE, MALE], energy=0.75, carrying=0)
        chosen += mate(world).values()
    assert len(chosen) == 100
    assert abs(chosen.count(1) - 50) < 20  # four standard deviations


def test_a_father_without_energy_sires_young_that_cost_nothing(meadow):
    world = couples_of(meadow, 1, reproduction={"father_share": 1.0, "energy_given": 0.0, "energy_min": 0.0})
    arrange(world, "deer", energy=0.0)
    assert mate(world) == {0: 1}


def test_the_father_pays_his_share_of_the_litter_at_once(meadow):
    way = {"father_share": 0.25, "litter": 3, "energy_given": 0.125, "father_rest": 4.0}
    world = couples_of(meadow, 1, reproduction=way)
    world.tick = 10
    assert mate(world) == {0: 1}
    assert values_by_uid(world, Metabolism, "energy").tolist() == [0.75, 0.75 - 0.09375]
    assert values_by_uid(world, Metabolism, "given").tolist() == [0, 0.09375]
    assert values_by_uid(world, Gestation, "energy").tolist() == [0.09375, 0]
    assert values_by_uid(world, Gestation, "rest").tolist() == [0, 14]


def test_who_cannot_pay_the_fathers_share_and_live_is_not_chosen(meadow):
    world = meadow(
        count=3, sex="random", reproduction=WAY | {"father_share": 1.0, "litter": 3, "energy_min": 0.25}
    )
    arrange(world, "deer", x=[5.0, 5.5, 6.5], y=5.0, sex=[FEMALE, MALE, MALE], energy=[0.5, 0.75, 0.875])
    assert mate(world) == {0: 2}
    assert values_by_uid(world, Metabolism, "energy").tolist() == [0.5, 0.75, 0.125]


@pytest.mark.parametrize(("dt", "fertility"), [(1.0, 1.0), (0.5, 1.0), (1.0, 0.5), (0.5, 0.5)])
def test_mating_succeeds_with_its_chance_per_second_and_the_fertility_of_both(meadow, dt, fertility):
    world = couples_of(
        meadow,
        400,
        reproduction={"chance": 0.6, "father_share": 1.0, "father_rest": 9.0},
        world={"dt": dt},
        fertility=fertility,
    )
    deer = world.tables["deer"]
    chance = 1 - (1 - 0.6 * fertility**2) ** dt
    lucky = np.flatnonzero(random.draw_many(world.key, deer.uid[deer.by_uid()][::2], MEET) < chance) * 2
    assert list(mate(world)) == lucky.tolist()
    assert abs(len(lucky) - 400 * chance) < 4 * np.sqrt(400 * chance * (1 - chance))
    paid = values_by_uid(world, Metabolism, "energy") < 0.75
    assert np.flatnonzero(paid).tolist() == (lucky + 1).tolist()  # who fails pays nothing and does not rest
    assert np.flatnonzero(values_by_uid(world, Gestation, "rest")).tolist() == (lucky + 1).tolist()


def test_a_mother_keeps_the_fathers_genome(meadow):
    world = couples_of(meadow, 3)
    deer = world.tables["deer"]
    with_genome(deer, 4)
    arrange(world, "deer", loci=np.arange(24).reshape(6, 4), fertility=[1, 1, 1, 1, 0, 1])
    assert mate(world) == {0: 1, 2: 3}  # the last does not conceive
    nothing = [0] * 4
    assert values_by_uid(world, Gestation, "sperm").tolist() == [
        [4, 5, 6, 7],
        nothing,
        [12, 13, 14, 15],
        nothing,
        nothing,
        nothing,
    ]


def with_genome(table, loci):
    """Give a table genomes of so many loci, and mothers the room to keep one."""
    table.dims["loci"] = loci
    for component in (Genome, Gestation):
        table.columns.pop(component, None)
        table.defaults.pop(component, None)
        table.add_component(component)


@pytest.mark.definition("3 hyperparameters")
def test_the_organisms_own_life_history_replaces_that_of_the_species(meadow):
    world = couples_of(meadow, 4, reproduction={"father_share": 0.5, "energy_given": 0.5, "age_min": 50.0})
    world.tables["deer"].add_component(LifeHistory)
    arrange(
        world,
        "deer",
        age_min=[20, 20, 20, 21, 20, 20, 20, 20],
        energy_min=[0.5, 0.75, 0, 0, 0.76, 0, 0, 0],
        energy_given=0.125,
        litter=[2.4, 1, 1, 1, 1, 1, 1.5, 1],
    )
    assert mate(world) == {0: 1, 6: 7}
    assert values_by_uid(world, Gestation, "carrying")[[0, 6]].tolist() == [2, 2]
    assert values_by_uid(world, Metabolism, "energy")[[1, 7]].tolist() == [0.625, 0.625]


def test_a_litter_of_none_is_not_conceived(meadow):
    world = couples_of(meadow, 2)
    world.tables["deer"].add_component(LifeHistory)
    arrange(world, "deer", litter=[0.4, 1, 0.5, 1])
    assert mate(world) == {2: 3}


def test_nobody_mates_while_numbers_are_held_constant(meadow):
    world = couples_of(meadow, 2)
    world.reproduction = False
    assert mate(world) == {}


def _pairs(world, way, own):
    """Who mates with whom, in plain loops: [(chooser, chosen)] by number."""
    deer = world.tables["deer"]
    rows = deer.by_uid()
    p, b, m, g, radius = deer[Position], deer[Biology], deer[Metabolism], deer[Gestation], deer[Body].radius
    h = deer[LifeHistory] if own else None
    wills = deer[Nervous].decision[:, 7]
    size = world.space.size

    def ready(r):
        return (
            not deer.cause[r]
            and not g.carrying[r]
            and g.rest[r] <= world.tick
            and b.age[r] >= way["age_min"]
            and m.energy[r] >= 0.5
        )

    def distance2(r, s):
        total = np.float32(0)
        for column, length in ((p.x, size[0]), (p.y, size[1])):
            d = column[s] - column[r]
            d = np.float32(d - np.float32(length) * np.floor(d / np.float32(length) + np.float32(0.5)))
            total += d * d
        return total

    proposals = []
    for r in rows:
        best = None
        choice = ("nearest", "random", "richest", "oldest").index(way["choice"]) if h is None else h.choice[r]
        for s in rows:
            if r == s or not ready(r) or not ready(s) or b.sex[r] == MALE or b.sex[s] == FEMALE:
                continue
            if int(wills[r]) + int(wills[s]) < {"none": 0, "one": 1, "both": 2}[way["consent"]]:
                continue
            d2 = distance2(r, s)
            if d2 > (radius[r] + radius[s] + np.float32(way["reach"])) ** 2:
                continue
            score = (
                d2,
                plain_draw(world.key, mix(int(deer.uid[r])) ^ int(deer.uid[s]), TASTE),
                -m.energy[s],
                -b.age[s],
            )[choice]
            lot = random.bits(world.key, np.uint64(mix(int(deer.uid[r])) ^ int(deer.uid[s])), TIE)
            if best is None or (score, d2, lot) < best[:3]:
                best = (score, d2, lot, deer.uid[s])
        if best is not None:
            lot = random.bits(world.key, deer.uid[r], TIE)
            proposals.append((best[1], lot, deer.uid[r], best[3]))
    taken, pairs = set(), {}
    first = deer.uid[rows[0]]
    for _, _, she, he in sorted(proposals):
        if not {she, he} & taken:
            taken |= {she, he}
            pairs[int(she - first)] = int(he - first)
    return pairs


@pytest.mark.parametrize("own", [False, True])
@pytest.mark.parametrize("consent", ["both", "one", "none"])
@pytest.mark.parametrize("choice", ["nearest", "random", "richest", "oldest"])
@pytest.mark.parametrize("sex", ["random", "none"])
def test_kernels_agree_with_plain_loops_whatever_the_order_of_rows(meadow, own, consent, choice, sex):
    way = WAY | {"consent": consent, "choice": choice, "age_min": 5.0}
    world = meadow(count=60, sex=sex, reproduction=way, actions={"mate": ["mate"]})
    if own:
        world.tables["deer"].add_component(LifeHistory, age_min=5.0, energy_min=0.5, energy_given=0.25)
        arrange(world, "deer", choice=np.arange(60) % 4)
    rng = np.random.Generator(np.random.Philox(1))
    arrange(
        world,
        "deer",
        x=np.round(20 * rng.random(60)) % 20,
        y=np.round(20 * rng.random(60)) % 20,
        age=np.round(rng.random(60) * 30),
        energy=np.round(rng.random(60) * 4 + 1) / 4,
        decision=(rng.random((60, 8)) < 0.7),
        radius=np.round(4 * rng.random(60) + 1) / 8,
        rest=rng.integers(0, 10, 60) == 0,
    )
    expected = _pairs(world, way, own)
    assert len(expected) >= 2
    before = state(world)
    assert mate(shuffle(world, 5)) == expected
    changed = state(world)
    assert difference(before, changed)
    assert (before["deer"]["Position.x"] == changed["deer"]["Position.x"]).all()


def _herd(meadow, threads=1, **way):
    world = meadow(
        count=80,
        sex="random",
        reproduction=WAY | {"father_share": 0.5, "gestation": 3.0, "rest": 2.0, "consent": "one"} | way,
        actions={"mate": ["mate"]},
        always_on=["eat"],
        policy={"kind": "shared", "hidden": [4]},
        options={"policies": "random", "threads": threads},
    )
    arrange(world, "deer", energy=0.9)
    return world


def test_the_system_keeps_the_rules(meadow):
    conceived = []
    check_system(Mate, lambda threads: _herd(meadow, threads), ticks=8)
    world = _herd(meadow)
    world.on_birth.append(lambda table, rows, *_: conceived.append(rows.size))
    world.run(8)
    assert sum(conceived) >= 5
