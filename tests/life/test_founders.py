"""Organisms without parents: how old they are, and how much energy they have."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Biology, Metabolism
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError

CARP = {
    "count": 400,
    "body": {"radius": 0.2},
    "metabolism": {"energy": 0.5},
    "lethal": [{"property": "age", "max": 2000.0, "cause_above": "old"}],
}


def pond(**carp):
    return {
        "format": 1,
        "name": "pond",
        "space": {"size": [50.0, 50.0]},
        "dt": 10.0,
        "ticks": 300,
        "species": {"carp": CARP | carp},
    }


def ages(world):
    carp = world.table("carp")
    return carp[Biology].age[carp.rows()]


def test_founders_are_as_old_as_their_world_file_says_and_go_on_from_there():
    world = World.from_config(pond(age=[100.0, 2000.0]), seed=3)
    first = ages(world).copy()
    assert first.min() >= 100.0
    assert first.max() < 2000.0
    assert np.allclose(np.quantile(first, [0.25, 0.5, 0.75]), [575.0, 1050.0, 1525.0], atol=120.0)
    world.run(1)
    carp = world.table("carp")
    assert np.allclose(carp[Biology].age[:400][carp.alive[:400]], first[carp.alive[:400]] + 10.0)


def test_a_cohort_of_age_0_dies_in_one_tick_and_one_of_many_ages_over_a_life():
    alike, mixed = (World.from_config(pond(**more), seed=3) for more in ({}, {"age": [0.0, 2000.0]}))
    alike.run(199), mixed.run(100)
    assert alike.table("carp").n == 400
    assert 150 < mixed.table("carp").n < 250
    alike.run(1), mixed.run(100)
    assert alike.table("carp").n == mixed.table("carp").n == 0


def test_immigrants_and_those_that_are_added_are_as_old_as_founders():
    way = {"kind": "asexual", "rate": 0.0, "energy_min": 0.5, "energy_given": 0.2, "immigration": 0.5}
    world = World.from_config(pond(count=0, age=[500.0, 600.0], reproduction=way), seed=3).run(10)
    world.intervene({"kind": "add", "species": "carp", "count": 20})
    world.run(1)
    assert len(ages(world)) > 50
    assert ages(world).min() >= 500.0
    assert ages(world).max() < 700.0


def test_plants_that_spread_have_ages_too():
    moss = {"reproduction": {"kind": "spread", "rate": 0.0, "spacing": 5.0}, "age": [10.0, 20.0]}
    found = ages(World.from_config(pond(count=90, **moss), seed=3))
    assert len(found) == 90
    assert ((found >= 10.0) & (found < 20.0)).all()


def test_a_world_without_the_key_has_the_hash_and_the_founders_that_it_had():
    assert load(pond()).config_hash == load(pond(age=None)).config_hash
    assert "age" not in load(pond()).species["carp"].model_dump(mode="json")
    one, other = (World.from_config(pond(**more), seed=3).table("carp") for more in ({}, {"age": [0.0, 9.0]}))
    for component in one.columns:
        for name in component.fields:
            if name != "age":
                assert np.array_equal(one.field(component, name), other.field(component, name)), name


@pytest.mark.parametrize(
    ("age", "message"),
    [
        ([2000.0, 0.0], r"(?s)species.carp.age = .*the minimum is above the maximum; expected: .0, 2000"),
        ([0.0], "species.carp.age"),
        ([-1.0, 0.0], "species.carp.age"),
    ],
)
def test_ages_that_cannot_be_are_refused(age, message):
    with pytest.raises(ConfigError, match=message):
        load(pond(age=age))


SENSES = {
    "sensors": [{"kind": "own", "property": "energy"}],
    "locomotion": {"speed": {"go": 1.0}},
    "actions": {"speed": ["go"]},
    "always_on": ["go"],
}


@pytest.mark.parametrize(
    ("metabolism", "nerves", "low", "high"),
    [
        ({}, {}, 0.5, 0.5),
        ({}, SENSES, 0.375, 0.625),
        ({"energy_spread": 0.0}, SENSES, 0.5, 0.5),
        ({"energy_spread": 0.5}, {}, 0.25, 0.75),
        ({"energy_spread": 1.0, "energy_max": 0.75}, SENSES, 0.0, 0.75),
    ],
)
def test_energies_of_founders_are_spread_as_their_world_file_says(metabolism, nerves, low, high):
    carp = World.from_config(pond(metabolism={"energy": 0.5} | metabolism, **nerves), seed=3).table("carp")
    energy = carp[Metabolism].energy[carp.rows()]
    assert (energy.min(), energy.max()) == pytest.approx((low, high), abs=0.01)
    assert len(set(energy.tolist())) == 1 or energy.min() < 0.5 < energy.max()
