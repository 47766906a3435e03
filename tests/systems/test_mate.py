import numpy as np
import pytest

from ecs_eco.components import Biology, Body, Genome, Gestation, LifeHistory, Metabolism, Nervous, Position
from ecs_eco.config import load
from ecs_eco.engine import random
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import Mate
from ecs_eco.systems.mate import MEET, TASTE
from ecs_eco.testing import act, arrange, check_system, difference, shuffle, state

# bodies of 0.5 m: centres within 2 m
WAY = {"kind": "sexual", "energy_min": 0.5, "energy_given": 0.25, "reach": 1.0}
WIDE = {"space": {"size": [400.0, 400.0]}}
FEMALE, MALE = 1, 2


def _mated(world):
    """Let deer mate; return {mother: father} by number, the first deer being 0."""
    act(world, Mate)
    deer = world.tables["deer"]
    g, rows = deer[Gestation], deer.by_uid()
    first = int(deer.uid[rows[0]])
    return {i: int(g.father[r]) - first for i, r in enumerate(rows) if g.carrying[r]}


def _couples(meadow, n, **changes):
    """A world of n couples, each 10 m from the next, the female first, 1 m before the male; all are ready."""
    way = WAY | changes.pop("reproduction", {})
    world = meadow(count=2 * n, sex="random", world=WIDE | changes.pop("world", {}),
                   reproduction=way, **changes)
    x = np.repeat(10.0 * np.arange(n), 2) + np.tile([0.0, 1.0], n)
    arrange(world, "deer", x=x % 400, y=10.0 + 10 * np.floor(x / 400), sex=np.tile([FEMALE, MALE], n),
            energy=0.75, age=20.0)
    return world


def _by_uid(world, component, field):
    deer = world.tables["deer"]
    return deer.field(component, field)[deer.by_uid()]


def test_a_female_conceives_by_a_male_if_both_are_old_and_fed_enough_rested_and_not_pregnant(meadow):
    world = _couples(meadow, 13, reproduction={"age_min": 10.0, "gestation": 5.0, "litter": 3})
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
    assert _mated(world) == {0: 1, 18: -int(deer.uid[deer.by_uid()[0]]), 25: 24}
    assert _by_uid(world, Gestation, "carrying")[[0, 18, 25]].tolist() == [3, 2, 3]
    assert _by_uid(world, Gestation, "due")[[0, 18, 25]].tolist() == [5, 0, 5]


def test_who_rests_until_a_tick_mates_in_that_tick(meadow):
    world = _couples(meadow, 2)
    world.tick = 7
    arrange(world, "deer", rest=[7, 0, 0, 8])
    assert _mated(world) == {0: 1}


@pytest.mark.parametrize(("x", "meets"), [(1.99, True), (2.01, False), (18.01, True), (17.99, False)])
def test_mates_meet_within_reach_beyond_their_bodies_also_around_the_torus(meadow, x, meets):
    world = meadow(sex="random", reproduction=WAY)
    arrange(world, "deer", x=[0.0, x], y=5.0, sex=[FEMALE, MALE], energy=0.75)
    assert _mated(world) == ({0: 1} if meets else {})


def test_larger_bodies_meet_from_farther(meadow):
    world = meadow(sex="random", reproduction=WAY)
    arrange(world, "deer", x=[0.0, 2.9], y=5.0, sex=[FEMALE, MALE], energy=0.75, radius=[0.5, 1.5])
    assert _mated(world) == {0: 1}


@pytest.mark.parametrize(("consent", "couples"), [("both", [3]), ("one", [1, 2, 3]), ("none", [0, 1, 2, 3])])
def test_consent_is_of_both_of_one_or_of_nobody(meadow, consent, couples):
    world = _couples(meadow, 4, actions={"mate": ["mate"]}, reproduction={"consent": consent})
    decision = np.zeros((8, 8), int)  # the gaits, the turns, eat, mate
    decision[:, 7] = [0, 0, 0, 1, 1, 0, 1, 1]
    arrange(world, "deer", decision=decision)
    assert list(_mated(world)) == [2 * c for c in couples]


@pytest.mark.parametrize("consent", ["both", "one", "none"])
def test_a_species_without_the_action_is_always_willing(meadow, consent):
    assert _mated(_couples(meadow, 2, reproduction={"consent": consent})) == {0: 1, 2: 3}


@pytest.mark.parametrize(("choice", "chosen"), [("nearest", 3), ("richest", 1), ("oldest", 2)])
def test_a_female_chooses_the_nearest_the_richest_or_the_oldest(meadow, choice, chosen):
    world = meadow(count=5, sex="random", reproduction=WAY | {"choice": choice})
    arrange(world, "deer", x=[5.0, 6.5, 4.0, 5.5, 5.1], y=5.0, sex=[FEMALE, MALE, MALE, MALE, FEMALE],
            energy=[0.6, 0.9, 0.7, 0.8, 0.4], age=[9, 20, 40, 30, 99])
    assert _mated(world) == {0: chosen}


@pytest.mark.parametrize(("choice", "distances", "chosen"), [
    ("richest", [1.5, 1.0, 1.5], 2), ("oldest", [1.5, 1.0, 1.5], 2), ("richest", [1.0, 1.0, 1.0], 1),
    ("nearest", [1.0, 1.0, 1.0], 1),
])  # fmt: skip
def test_of_equals_the_nearer_is_chosen_and_then_the_lower_uid(meadow, choice, distances, chosen):
    world = meadow(count=4, sex="random", reproduction=WAY | {"choice": choice})
    a, b, c = distances
    arrange(world, "deer", x=[5.0, 5 - a, 5 + b, 5.0], y=[5.0, 5.0, 5.0, 5 + c],
            sex=[FEMALE, MALE, MALE, MALE], energy=0.75)
    assert _mated(shuffle(world, 4)) == {0: chosen}


def test_a_random_choice_takes_every_male_equally_often(meadow):
    world = _couples(meadow, 300, reproduction={"choice": "random"})
    x, sex = (np.repeat(10.0 * np.arange(200), 3) + np.tile([0.0, 1.0, 1.8], 200),
              np.tile([FEMALE, MALE, MALE], 200))
    deer = arrange(world, "deer", x=x % 400, y=10 + 10 * np.floor(x / 400), sex=sex)
    mated = _mated(world)
    assert list(mated) == list(range(0, 600, 3))
    uid = deer.uid[deer.by_uid()]
    for mother, father in mated.items():
        drawn = [_draw(world.key, _mix(int(uid[mother])) ^ int(uid[m]), TASTE)
                 for m in (mother + 1, mother + 2)]
        assert father == mother + 1 + int(np.argmin(drawn))
    assert abs(sum(f % 3 == 1 for f in mated.values()) - 100) < 25


def test_two_females_who_want_one_male_leave_him_to_the_nearer_and_of_equals_to_the_lower_uid(meadow):
    for x, mother in (([3.5, 5.0, 6.0], 2), ([4.0, 5.0, 6.0], 0), ([4.5, 5.0, 6.0], 0)):
        world = meadow(count=3, sex="random", reproduction=WAY)
        arrange(world, "deer", x=x, y=5.0, sex=[FEMALE, MALE, FEMALE], energy=0.75)
        assert _mated(shuffle(world, 1)) == {mother: 1}


def test_of_two_hermaphrodites_one_conceives(meadow):
    world = meadow(count=2, reproduction=WAY)
    arrange(world, "deer", x=[5.0, 6.0], y=5.0, energy=0.75)
    assert _mated(world) == {0: 1}
    assert _mated(world) == {0: 1}  # and neither the pregnant nor the other has whom to mate with
    world = meadow(count=3, reproduction=WAY)
    arrange(world, "deer", x=[5.0, 6.5, 7.0], y=5.0, energy=0.75)
    assert _mated(world) == {1: 2}  # the first wants 1, who has mated
    assert _mated(meadow(count=1, reproduction=WAY)) == {}


def test_the_father_pays_his_share_of_the_litter_at_once(meadow):
    way = {"father_share": 0.25, "litter": 3, "energy_given": 0.125, "father_rest": 4.0}
    world = _couples(meadow, 1, reproduction=way)
    world.tick = 10
    assert _mated(world) == {0: 1}
    assert _by_uid(world, Metabolism, "energy").tolist() == [0.75, 0.75 - 0.09375]
    assert _by_uid(world, Metabolism, "given").tolist() == [0, 0.09375]
    assert _by_uid(world, Gestation, "energy").tolist() == [0.09375, 0]
    assert _by_uid(world, Gestation, "rest").tolist() == [0, 14]


def test_who_cannot_pay_the_fathers_share_and_live_is_not_chosen(meadow):
    world = meadow(count=3, sex="random",
                   reproduction=WAY | {"father_share": 1.0, "litter": 3, "energy_min": 0.25})
    arrange(world, "deer", x=[5.0, 5.5, 6.5], y=5.0, sex=[FEMALE, MALE, MALE], energy=[0.5, 0.75, 0.875])
    assert _mated(world) == {0: 2}
    assert _by_uid(world, Metabolism, "energy").tolist() == [0.5, 0.75, 0.125]


@pytest.mark.parametrize(("dt", "fertility"), [(1.0, 1.0), (0.5, 1.0), (1.0, 0.5)])
def test_mating_succeeds_with_its_chance_per_second_and_the_fertility_of_both(meadow, dt, fertility):
    world = _couples(meadow, 400, reproduction={"chance": 0.6, "father_share": 1.0, "father_rest": 9.0},
                     world={"dt": dt}, fertility=fertility)
    deer = world.tables["deer"]
    chance = (1 - 0.4**dt) * fertility**2
    lucky = np.flatnonzero(random.draw_many(world.key, deer.uid[deer.by_uid()][::2], MEET) < chance) * 2
    assert list(_mated(world)) == lucky.tolist()
    assert abs(len(lucky) - 400 * chance) < 4 * np.sqrt(400 * chance * (1 - chance))
    paid = _by_uid(world, Metabolism, "energy") < 0.75
    assert np.flatnonzero(paid).tolist() == (lucky + 1).tolist()  # who fails pays nothing and does not rest
    assert np.flatnonzero(_by_uid(world, Gestation, "rest")).tolist() == (lucky + 1).tolist()


def test_a_mother_keeps_the_fathers_genome(meadow):
    world = _couples(meadow, 3)
    deer = world.tables["deer"]
    with_genome(deer, 4)
    arrange(world, "deer", loci=np.arange(24).reshape(6, 4), fertility=[1, 1, 1, 1, 0, 1])
    assert _mated(world) == {0: 1, 2: 3}  # the last does not conceive
    assert _by_uid(world, Gestation, "sperm").tolist() == [[4, 5, 6, 7], [0] * 4, [12, 13, 14, 15], [0] * 4,
                                                           [0] * 4, [0] * 4]


def with_genome(table, loci):
    """Give a table genomes of so many loci, and mothers the room to keep one."""
    table.dims["loci"] = loci
    for component in (Genome, Gestation):
        table.columns.pop(component, None)
        table.defaults.pop(component, None)
        table.add_component(component)


def test_the_organisms_own_life_history_replaces_that_of_the_species(meadow):
    world = _couples(meadow, 4, reproduction={"father_share": 0.5, "energy_given": 0.5, "age_min": 50.0})
    world.tables["deer"].add_component(LifeHistory)
    arrange(world, "deer", age_min=[20, 20, 20, 21, 20, 20, 20, 20],
            energy_min=[0.5, 0.75, 0, 0, 0.76, 0, 0, 0], energy_given=0.125,
            litter=[2.4, 1, 1, 1, 1, 1, 1.5, 1])
    assert _mated(world) == {0: 1, 6: 7}
    assert _by_uid(world, Gestation, "carrying")[[0, 6]].tolist() == [2, 2]
    assert _by_uid(world, Metabolism, "energy")[[1, 7]].tolist() == [0.625, 0.625]


@pytest.mark.parametrize(("choice", "chosen"), [(0, 3), (2, 1), (3, 2)])
def test_a_chooser_may_have_a_taste_of_its_own(meadow, choice, chosen):
    world = meadow(count=4, sex="random", reproduction=WAY)
    world.tables["deer"].add_component(LifeHistory)
    arrange(world, "deer", x=[5.0, 6.5, 4.0, 5.5], y=5.0, sex=[FEMALE, MALE, MALE, MALE],
            energy=[0.6, 0.9, 0.7, 0.8], age=[9, 20, 40, 30], choice=[choice, 0, 0, 0])
    assert _mated(world) == {0: chosen}


GENES = {"genome": {"genes": [{"name": "mark", "letters": 3, "low": 0.0, "high": 1.0}]}}


def _court(meadow, rule):
    """One female and three males at .5, 1 and 1.5 m, the toolbox of the species choosing by `rule`."""
    world = meadow(count=4, sex="random", world=WIDE, reproduction=WAY, **GENES)
    arrange(world, "deer", x=[10, 10.5, 11, 11.5], y=10, sex=[FEMALE, MALE, MALE, MALE],
            energy=[0.6, 0.6, 0.9, 0.7], age=20.0)
    toolbox = world.tables["deer"].species.heredity.operators.toolbox
    toolbox.register("select_mate", rule)
    return world


def test_a_function_of_ones_own_in_the_toolbox_chooses(meadow):
    asked = []

    def farthest(chooser, candidates, distance, energy, age):
        asked.append((chooser, candidates, distance, energy, age))
        return candidates[int(np.argmax(distance))]

    world = _court(meadow, farthest)
    assert _mated(world) == {0: 3}
    uids = _by_uid_all(world)
    (chooser, candidates, distance, energy, age), = asked
    assert (chooser, sorted(candidates)) == (uids[0], uids[1:])
    by = dict(zip(candidates, zip(distance, energy, age, strict=True), strict=True))
    assert np.allclose([by[u] for u in uids[1:]], [(0.5, 0.6, 20), (1, 0.9, 20), (1.5, 0.7, 20)])


def test_a_rule_registered_anew_is_followed(meadow):
    from ecs_eco.genomes.choices import RULES

    assert _mated(_court(meadow, RULES["nearest"])) == {0: 1}
    assert _mated(_court(meadow, RULES["richest"])) == {0: 2}


def test_a_function_that_chooses_somebody_else_is_refused(meadow):
    with pytest.raises(ValueError, match="select_mate of 'deer' returns 0"):
        _mated(_court(meadow, lambda chooser, candidates, distance, energy, age: 0))


def test_a_function_that_draws_chooses_alike_in_any_order_of_rows(meadow):
    import random as python_random

    def any_one(chooser, candidates, distance, energy, age):
        return python_random.choice(sorted(candidates))

    python_random.seed(5)
    before = python_random.getstate()
    first = [_mated(_court(meadow, any_one)) for _ in range(2)]
    python_random.seed(6)
    assert first == [_mated(shuffle(_court(meadow, any_one), seed)) for seed in (1, 2)]
    python_random.setstate(before)


def _by_uid_all(world):
    deer = world.tables["deer"]
    return deer.uid[deer.by_uid()].tolist()


def test_a_litter_of_none_is_not_conceived(meadow):
    world = _couples(meadow, 2)
    world.tables["deer"].add_component(LifeHistory)
    arrange(world, "deer", litter=[0.4, 1, 0.5, 1])
    assert _mated(world) == {2: 3}


def test_nobody_mates_while_numbers_are_held_constant(meadow):
    world = _couples(meadow, 2)
    world.reproduction = False
    assert _mated(world) == {}


# the slow twin


def _mix(z):
    return int(random.mix(np.uint64(z)))


def _draw(key, who, purpose):
    return float(random.draw(key, np.uint64(who), purpose))


def _pairs(world, way, own):
    """Who mates with whom, in plain loops: [(chooser, chosen)] by number."""
    deer = world.tables["deer"]
    rows = deer.by_uid()
    p, b, m, g, radius = deer[Position], deer[Biology], deer[Metabolism], deer[Gestation], deer[Body].radius
    h = deer[LifeHistory] if own else None
    wills = deer[Nervous].decision[:, 7]
    size = world.space.size

    def ready(r):
        return (not deer.cause[r] and not g.carrying[r] and g.rest[r] <= world.tick
                and b.age[r] >= way["age_min"] and m.energy[r] >= 0.5)

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
            score = (d2, _draw(world.key, _mix(int(deer.uid[r])) ^ int(deer.uid[s]), TASTE),
                     -m.energy[s], -b.age[s])[choice]
            if best is None or (score, d2, deer.uid[s]) < best[:3]:
                best = (score, d2, deer.uid[s])
        if best is not None:
            proposals.append((best[1], deer.uid[r], best[2]))
    taken, pairs = set(), {}
    first = deer.uid[rows[0]]
    for _, she, he in sorted(proposals):
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
    arrange(world, "deer", x=np.round(20 * rng.random(60)) % 20, y=np.round(20 * rng.random(60)) % 20,
            age=np.round(rng.random(60) * 30),
            energy=np.round(rng.random(60) * 4 + 1) / 4, decision=(rng.random((60, 8)) < 0.7),
            radius=np.round(4 * rng.random(60) + 1) / 8, rest=rng.integers(0, 10, 60) == 0)
    expected = _pairs(world, way, own)
    assert len(expected) >= 2
    before = state(world)
    assert _mated(shuffle(world, 5)) == expected
    changed = state(world)
    assert difference(before, changed)
    assert (before["deer"]["Position.x"] == changed["deer"]["Position.x"]).all()


def _herd(meadow, threads=1, **way):
    world = meadow(count=80, sex="random", reproduction=WAY | {"father_share": 0.5, "gestation": 3.0,
                                                               "rest": 2.0, "consent": "one"} | way,
                   actions={"mate": ["mate"]}, automatic=["eat"], policy={"kind": "shared", "hidden": [4]},
                   options={"policies": "random", "threads": threads})
    arrange(world, "deer", energy=0.9)
    return world


def test_the_system_keeps_the_rules(meadow):
    conceived = []
    check_system(Mate, lambda threads: _herd(meadow, threads), ticks=8)
    world = _herd(meadow)
    world.on_birth.append(lambda table, rows, *_: conceived.append(rows.size))
    world.run(8)
    assert sum(conceived) >= 5


# what a world file may not say


@pytest.mark.parametrize(
    ("changes", "key", "what", "allowed"),
    [
        ({"sex": "female"}, "sex", "nobody to mate with", "random, or none"),
        ({"sex": "male"}, "sex", "nobody to mate with", "random, or none"),
        ({"reproduction": {"reach": 10.1}}, "reproduction.reach", "larger than half of the torus",
         "at most 10 m"),
        ({"reproduction": {"reach": -1.0}}, "reproduction.reach", "", "at least 0"),
        ({"reproduction": {"chance": 1.1}}, "reproduction.chance", "", "at most 1"),
        ({"reproduction": {"father_share": -0.1}}, "reproduction.father_share", "", "at least 0"),
        ({"reproduction": {"father_share": 1.0, "litter": 4}}, "reproduction.father_share",
         "no father can pay", "less than 1, or"),
        ({"reproduction": {"energy_given": 1.0}}, "reproduction.energy_given", "no mother can pay",
         "less than 1"),
        ({"reproduction": {"energy_given": 1.1}}, "reproduction.energy_given", "more than energy_max",
         "at most 1"),
        ({"reproduction": {"energy_min": 1.1}}, "reproduction.energy_min", "more than energy_max",
         "at most 1"),
        ({"reproduction": {"consent": "all"}}, "reproduction.consent", "", "both, one, none"),
        ({"reproduction": {"choice": "richer"}}, "reproduction.choice", "", 'did you mean "richest"'),
        ({"reproduction": {"gestation": -1.0}}, "reproduction.gestation", "", "at least 0"),
        ({"reproduction": {"rest": -1.0}}, "reproduction.rest", "", "at least 0"),
        ({"reproduction": {"father_rest": -1.0}}, "reproduction.father_rest", "", "at least 0"),
        ({"reproduction": {"litter": 0}}, "reproduction.litter", "", "at least 1"),
        ({"reproduction": {"litter": 1.5}}, "reproduction.litter", "", "whole number"),
        ({"reproduction": {"place": "far"}}, "reproduction.place", "", "near, anywhere"),
        ({"reproduction": {"dispersal": 10.1}}, "reproduction.dispersal", "larger than half of the torus",
         "at most 10 m"),
        ({"reproduction": {"dispersal": 1.0}}, "reproduction.dispersal", "the mother's own body",
         "more than 1 m"),
        ({"reproduction": {"spacing": 2.0}}, "reproduction.spacing", "the mother herself", "less than 2 m"),
        ({"reproduction": {"rate": 0.1}}, "reproduction.rate", "unknown key", "energy_min"),
        ({"reproduction": None, "actions": {"mate": ["mate"]}}, "actions.mate", "no sexual reproduction",
         'kind = "sexual"'),
        ({"actions": {"mate": ["meet"]}}, "actions.mate.0", "no action of this name", "mate"),
    ],
)
def test_what_cannot_be_is_refused(meadow, changes, key, what, allowed):
    with pytest.raises(ConfigError) as refused:
        _couples_config(meadow, **changes)
    assert len(refused.value.problems) == 1, refused.value
    problem = refused.value.problems[0]
    assert problem.path == f"species.deer.{key}"
    assert what in problem.what
    assert allowed in str(problem)


def _couples_config(meadow, reproduction=(), **changes):
    way = None if reproduction is None else WAY | dict(reproduction)
    return meadow(**{"sex": "random", "reproduction": way} | changes)


def test_the_mate_action_needs_reproduction_that_is_sexual_or_a_system_of_ones_own(meadow):
    way = {"kind": "asexual", "rate": 0.1, "energy_min": 0.5, "energy_given": 0.25}
    with pytest.raises(ConfigError, match=r'species.deer.actions.mate = .*\n.*allowed: '
                                          r'reproduction.kind = "sexual", or no such group'):
        meadow(reproduction=way, actions={"mate": ["mate"]})
    config = meadow(reproduction=way).config.model_dump()
    config["species"]["deer"]["actions"]["mate"] = ["mate"]
    assert "mate" in load(config, systems=[Courting]).species["deer"].actions


class Courting(Mate):
    """A system of one's own that carries out the action."""

    acts = ("mate",)


def test_what_is_left_out_has_its_default(meadow):
    way = meadow(sex="random", reproduction={
        "kind": "sexual", "energy_min": 0.5, "energy_given": 0.25
    }).config.species["deer"].reproduction
    assert way.model_dump(exclude={"kind", "energy_min", "energy_given"}) == {
        "father_share": 0.0, "reach": 0.0, "chance": 1.0, "consent": "both", "choice": "nearest",
        "gestation": 0.0, "rest": 0.0,
        "father_rest": 0.0, "place": "near", "dispersal": None, "age_min": 0.0, "litter": 1, "spacing": 0.0,
    }  # fmt: skip
