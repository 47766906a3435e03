"""Whom a female chooses: the rules, tastes that differ, and functions of one's own."""

import numpy as np
import pytest

from ecs_eco.components import Gestation, LifeHistory
from ecs_eco.systems.mate import TASTE
from ecs_eco.testing import arrange, shuffle
from tests.systems.couples import FEMALE, MALE, WAY, WIDE, couples_of, mate, mix, plain_draw


@pytest.mark.parametrize(("choice", "chosen"), [("nearest", 3), ("richest", 1), ("oldest", 2)])
def test_a_female_chooses_the_nearest_the_richest_or_the_oldest(meadow, choice, chosen):
    world = meadow(count=5, sex="random", reproduction=WAY | {"choice": choice})
    arrange(
        world,
        "deer",
        x=[5.0, 6.5, 4.0, 5.5, 5.1],
        y=5.0,
        sex=[FEMALE, MALE, MALE, MALE, FEMALE],
        energy=[0.6, 0.9, 0.7, 0.8, 0.4],
        age=[9, 20, 40, 30, 99],
    )
    assert mate(world) == {0: chosen}


@pytest.mark.parametrize(
    ("choice", "distances", "chosen"),
    [
        ("richest", [1.5, 1.0, 1.5], {2}),
        ("oldest", [1.5, 1.0, 1.5], {2}),
        ("richest", [1.0, 1.0, 1.0], {1, 2, 3}),
        ("nearest", [1.0, 1.0, 1.0], {1, 2, 3}),
    ],
)
def test_of_equals_the_nearer_is_chosen_and_then_any(meadow, choice, distances, chosen):
    world = meadow(count=4, sex="random", reproduction=WAY | {"choice": choice})
    a, b, c = distances
    found = set()
    for world.tick in range(30):
        deer = arrange(
            world,
            "deer",
            x=[5.0, 5 - a, 5 + b, 5.0],
            y=[5.0, 5.0, 5.0, 5 + c],
            sex=[FEMALE, MALE, MALE, MALE],
            energy=0.75,
        )
        deer[Gestation].carrying[:], deer[Gestation].rest[:] = 0, 0
        mated = mate(shuffle(world, 4))
        assert list(mated) == [0]
        found.add(mated[0])
    assert found == chosen


def test_a_random_choice_takes_every_male_equally_often(meadow):
    world = couples_of(meadow, 300, reproduction={"choice": "random"})
    x, sex = (
        np.repeat(10.0 * np.arange(200), 3) + np.tile([0.0, 1.0, 1.8], 200),
        np.tile([FEMALE, MALE, MALE], 200),
    )
    deer = arrange(world, "deer", x=x % 400, y=10 + 10 * np.floor(x / 400), sex=sex)
    mated = mate(world)
    assert list(mated) == list(range(0, 600, 3))
    uid = deer.uid[deer.by_uid()]
    for mother, father in mated.items():
        drawn = [
            plain_draw(world.key, mix(int(uid[mother])) ^ int(uid[m]), TASTE)
            for m in (mother + 1, mother + 2)
        ]
        assert father == mother + 1 + int(np.argmin(drawn))
    assert abs(sum(f % 3 == 1 for f in mated.values()) - 100) < 25


def test_two_females_who_want_one_male_leave_him_to_the_nearer_and_of_equals_to_the_lower_uid(meadow):
    for x, mother in (([3.5, 5.0, 6.0], 2), ([4.0, 5.0, 6.0], 0), ([4.5, 5.0, 6.0], 0)):
        world = meadow(count=3, sex="random", reproduction=WAY)
        arrange(world, "deer", x=x, y=5.0, sex=[FEMALE, MALE, FEMALE], energy=0.75)
        assert mate(shuffle(world, 1)) == {mother: 1}


@pytest.mark.parametrize(("choice", "chosen"), [(0, 3), (2, 1), (3, 2)])
def test_a_chooser_may_have_a_taste_of_its_own(meadow, choice, chosen):
    world = meadow(count=4, sex="random", reproduction=WAY)
    world.tables["deer"].add_component(LifeHistory)
    arrange(
        world,
        "deer",
        x=[5.0, 6.5, 4.0, 5.5],
        y=5.0,
        sex=[FEMALE, MALE, MALE, MALE],
        energy=[0.6, 0.9, 0.7, 0.8],
        age=[9, 20, 40, 30],
        choice=[choice, 0, 0, 0],
    )
    assert mate(world) == {0: chosen}


GENES = {"genome": {"genes": [{"name": "mark", "letters": 3, "low": 0.0, "high": 1.0}]}}


def _court(meadow, rule):
    """One female and three males at .5, 1 and 1.5 m, the toolbox of the species choosing by `rule`."""
    world = meadow(count=4, sex="random", world=WIDE, reproduction=WAY, **GENES)
    arrange(
        world,
        "deer",
        x=[10, 10.5, 11, 11.5],
        y=10,
        sex=[FEMALE, MALE, MALE, MALE],
        energy=[0.6, 0.6, 0.9, 0.7],
        age=20.0,
    )
    toolbox = world.tables["deer"].species.heredity.operators.toolbox
    toolbox.register("select_mate", rule)
    return world


def test_a_function_of_ones_own_in_the_toolbox_chooses(meadow):
    asked = []

    def farthest(chooser, candidates, distance, energy, age):
        asked.append((chooser, candidates, distance, energy, age))
        return candidates[int(np.argmax(distance))]

    world = _court(meadow, farthest)
    assert mate(world) == {0: 3}
    uids = _by_uid_all(world)
    ((chooser, candidates, distance, energy, age),) = asked
    assert (chooser, sorted(candidates)) == (uids[0], uids[1:])
    by = dict(zip(candidates, zip(distance, energy, age, strict=True), strict=True))
    assert np.allclose([by[u] for u in uids[1:]], [(0.5, 0.6, 20), (1, 0.9, 20), (1.5, 0.7, 20)])


def test_a_rule_registered_anew_is_followed(meadow):
    from ecs_eco.genomes.choices import RULES

    assert mate(_court(meadow, RULES["nearest"])) == {0: 1}
    assert mate(_court(meadow, RULES["richest"])) == {0: 2}


def test_a_function_that_chooses_somebody_else_is_refused(meadow):
    with pytest.raises(ValueError, match="select_mate of 'deer' returns 0"):
        mate(_court(meadow, lambda chooser, candidates, distance, energy, age: 0))


def test_a_function_that_draws_chooses_alike_in_any_order_of_rows(meadow):
    import random as python_random

    def any_one(chooser, candidates, distance, energy, age):
        return python_random.choice(sorted(candidates))

    python_random.seed(5)
    before = python_random.getstate()
    first = [mate(_court(meadow, any_one)) for _ in range(2)]
    python_random.seed(6)
    assert first == [mate(shuffle(_court(meadow, any_one), seed)) for seed in (1, 2)]
    python_random.setstate(before)


def _by_uid_all(world):
    deer = world.tables["deer"]
    return deer.uid[deer.by_uid()].tolist()
