import numpy as np
import pytest

from ecs_eco.components import Nervous
from ecs_eco.systems import Perish
from ecs_eco.systems.perish import perish
from ecs_eco.testing import act, arrange

BODY = {
    "properties": {"temperature": 310.0},
    "lethal": [
        {"property": "energy", "min": 0.0, "cause_below": "starved"},
        {
            "property": "temperature",
            "min": 300.0,
            "max": 315.0,
            "cause_below": "too cold",
            "cause_above": "too hot",
        },
        {"property": "age", "max": 50.0, "cause_above": "too old"},
    ],
}


def _causes(world):
    act(world, Perish)
    table = world.tables["deer"]
    codes = table.cause[table.by_uid()]
    return [world.causes[c - 1] if c else None for c in codes]


def test_starved_deer_die(meadow):
    world = meadow(count=4, **BODY)
    arrange(world, "deer", energy=[0.0, -0.1, 1e-6, 1.0])
    assert _causes(world) == ["starved", "starved", None, None]
    world.flush()
    assert world.tables["deer"].n == 2


def test_each_end_of_an_interval_is_a_cause_of_its_own_and_belongs_to_death(meadow):
    world = meadow(count=5, **BODY)
    arrange(world, "deer", temperature=[299, 300, 301, 315, 320], age=[0, 0, 49.9, 0, 0])
    assert _causes(world) == ["too cold", "too cold", None, "too hot", "too hot"]


def test_the_first_cause_counts(meadow):
    world = meadow(count=3, **BODY)
    arrange(world, "deer", energy=[0, 0, 1], age=[99, 0, 99], temperature=[0, 310, 310])
    world.kill(int(world.tables["deer"].uid[1]), "drowned")
    assert _causes(world) == ["starved", "drowned", "too old"]


def test_causes_are_known_from_the_start_in_the_order_of_species(meadow):
    assert meadow(**BODY).causes == ["culled", "eaten by deer", "starved", "too cold", "too hot", "too old"]


def test_the_last_reward_reaches_the_learner_whatever_one_dies_of(meadow):
    happiness, options = {"formula": "energy", "minimum": -2.0}, {"policies": "untrained", "learn": True}
    world = meadow(
        count=3, policy={"kind": "shared", "hidden": [4]}, happiness=happiness, options=options, **BODY
    )
    table = world.tables["deer"]
    world.run(1)
    rollout = table.species.nerves.learner.rollout
    uids = table.uid[table.by_uid()].tolist()[:2]
    felt = [world.get(uid, Nervous).happiness for uid in uids]
    rows = [world.locate(uid)[1] for uid in uids]
    for uid in uids:  # culled between ticks
        world.kill(uid)
        world.flush()
    records = [rollout.steps["row"].tolist().index(row) for row in rows]
    assert rollout.steps["reward"][records].tolist() == pytest.approx([-2 - h for h in felt])
    assert rollout.ended.sum() == rollout.ended[records].sum() == 2
    assert rollout.last[rows].tolist() == [-1, -1]


def test_the_kernel_is_its_slow_twin():
    rng = np.random.default_rng(3)
    n = 60
    alive, value = rng.random(n) < 0.7, rng.normal(size=n).astype(np.float32)
    cause = np.where(rng.random(n) < 0.2, 9, 0).astype(np.uint8)
    expected = np.where(alive & (cause == 0), np.where(value <= -1, 3, np.where(value >= 0.5, 4, 0)), cause)
    perish(alive, value, np.float32(-1), np.float32(0.5), 3, 4, cause)
    assert (cause == expected).all()
