import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.cli.summary import summary
from ecs_eco.components import Metabolism
from ecs_eco.config import load
from ecs_eco.config.notes import meaningless_debt, notes
from ecs_eco.config.shipped import shipped
from ecs_eco.engine.errors import ConfigError


def _hermit(**species):
    return load(
        {
            "format": 1,
            "name": "cell",
            "space": {"size": [10.0, 10.0]},
            "species": {"hermit": {"count": 3, "body": {"radius": 0.5}} | species},
        }
    )


@pytest.mark.parametrize("name", shipped())
def test_energy_below_zero_means_something_in_every_shipped_world(name):
    config = load(name)
    assert {n: meaningless_debt(config, s) for n, s in config.species.items()} == dict.fromkeys(
        config.species, ""
    )
    assert notes(config) == []


@pytest.mark.parametrize("name", shipped())
def test_nobody_in_a_shipped_world_lives_on_with_less_than_no_energy(name):
    world = World.from_config(name, seed=3)
    for _ in range(4):
        world.run(10)
        for table in world.tables.values():
            if Metabolism in table:
                assert (table[Metabolism].energy[table.rows()] >= 0).all(), table.name


@pytest.mark.parametrize(
    ("species", "why"),
    [
        ({}, ""),
        ({"metabolism": {"photosynthesis": 0.5}}, ""),
        ({"metabolism": {"basal": 0.25}}, "metabolism.basal"),
        ({"metabolism": {"basal": 0.25, "torpor": True}}, ""),
        ({"metabolism": {"basal": 0.25}, "lethal": [{"property": "energy", "min": -1.0}]}, ""),
        ({"metabolism": {"basal": 0.25}, "lethal": [{"property": "energy", "max": 2.0}]}, "metabolism.basal"),
        (
            {"locomotion": {"speed": {"walk": 1.0, "run": 2.0}, "cost": {"walk": 0.0, "run": 0.5}}},
            "locomotion.cost.run",
        ),
        ({"diet": [{"eats": "hermit", "gain": -0.5}]}, "diet.0.gain"),
        (
            {"diet": [{"eats": "hermit", "gain": 0.5}], "defence": {"poison": 0.25}},
            "species.hermit.defence.poison",
        ),
    ],
)
def test_a_note_names_what_takes_energy_that_nothing_kills_for(species, why):
    config = _hermit(**species)
    assert meaningless_debt(config, config.species["hermit"]) == why
    written = [line for line in summary(config).splitlines() if "note:" in line]
    assert len(written) == (1 if why else 0)
    assert not why or f"species.hermit: its energy can fall below 0 ({why})" in written[0]


def test_what_a_note_warns_of_does_happen():
    world = World.from_config(_hermit(metabolism={"basal": 0.25, "energy": 0.5})).run(4)
    assert np.unique(world.tables["hermit"][Metabolism].energy[:3]).tolist() == [-0.5]


WALKS = {
    "locomotion": {"speed": {"still": 0.0, "walk": 1.0}},
    "actions": {"speed": ["still", "walk"]},
    "lethal": [{"property": "age", "max": 50.0}],
}
THINKS = {
    "policy": {"kind": "shared"},
    "sensors": [{"kind": "own", "property": "energy"}],
    "happiness": {"weights": {"energy": 1.0}, "minimum": 0.0},
}
BREEDS = {"reproduction": {"kind": "asexual", "rate": 0.1, "energy_min": 0.5, "energy_given": 0.2}}

LIVES = {"lethal": [{"property": "age", "max": 50.0}]}
PAIRS = {"max_count": 9, "reproduction": {"kind": "sexual", "energy_min": 0.5, "energy_given": 0.3}}


@pytest.mark.parametrize(
    ("species", "note"),
    [
        (WALKS, "species.hermit.actions: nothing controls speed.still, speed.walk; add a reflex or"),
        (
            WALKS | {"default_action": {"speed": "still"}},
            "species.hermit.actions: nothing controls speed.walk; add",
        ),
        (WALKS | {"actions": {"speed": ["walk"]}, "default_action": {"speed": "walk"}}, ""),
        (WALKS | THINKS, ""),
        (WALKS | {"reflex": {"formulas": {"walk": "1"}}}, ""),
        (
            WALKS | THINKS | {"reflex": {"formulas": {"still": "1.0"}}},
            "species.hermit.reflex.formulas.still always forces this action, and only the first forced "
            "action",
        ),
        (WALKS | THINKS | {"reflex": {"formulas": {"still": "energy - 0.5"}}}, ""),
        (BREEDS, "species.hermit: it breeds, but nothing kills it"),
        (BREEDS | {"max_count": 9}, ""),
        (BREEDS | {"diet": [{"eats": "hermit", "gain": 0.5}]}, ""),
        (BREEDS | {"lethal": [{"property": "age", "max": 50.0}]}, ""),
        (
            {
                "reproduction": BREEDS["reproduction"] | {"age_min": 50.0},
                "lethal": [{"property": "age", "max": 50.0}],
            },
            "species.hermit.reproduction.age_min = 50: it never breeds, because it dies at age 50",
        ),
        (
            BREEDS | {"lethal": [{"property": "age", "max": 50.0}], "breeding": {"maturity": 60.0}},
            "species.hermit.breeding.maturity = 60: it never breeds, because it dies at age 50",
        ),
        (
            LIVES | {"reproduction": BREEDS["reproduction"] | {"age_min": 20.0}},
            "species.hermit: all founders have age 0, so none breed before 20 s, all survivors die at 50 s, and",
        ),
        (LIVES | {"reproduction": BREEDS["reproduction"] | {"age_min": 10.0}}, ""),
        (LIVES | {"reproduction": BREEDS["reproduction"] | {"age_min": 20.0}, "age": [0.0, 50.0]}, ""),
        (LIVES | {"age": [0.0, 51.0]}, "species.hermit.age = [0, 51]: it dies at age 50, so older founders"),
        (
            BREEDS | {"max_count": 9, "reproduction": BREEDS["reproduction"] | {"litter": 5}},
            "species.hermit.reproduction.litter = 5: no mother can pay for the whole litter, because "
            "metabolism.energy_max is 1, and",
        ),
        (PAIRS, ""),
        (
            PAIRS | {"reproduction": PAIRS["reproduction"] | {"energy_min": 0.2}},
            "species.hermit.reproduction.energy_min = 0.2: less than the 0.3 that a newborn costs its mother",
        ),
        (PAIRS | {"reproduction": PAIRS["reproduction"] | {"energy_min": 0.2, "father_share": 0.5}}, ""),
        (
            {"diet": [{"eats": "hermit", "gain": 0.5, "satiation": 1.5}]},
            "species.hermit.diet.0.satiation = 1.5: never reached, because metabolism.energy_max is 1",
        ),
    ],
)
def test_notes_name_what_cannot_work(species, note):
    metabolism = {"metabolism": {"energy": 0.5, "energy_max": 1.0}}
    found = notes(_hermit(**metabolism | species))
    assert len(found) == (1 if note else 0), found
    assert not note or found[0].startswith(note)


def test_a_search_over_less_than_a_life_is_noted():
    config = {
        "format": 1,
        "name": "cell",
        "space": {"size": [10.0, 10.0]},
        "ticks": 40,
        "species": {
            "hermit": {
                "count": 3,
                "body": {"radius": 0.5},
                "max_count": 9,
                "lethal": [{"property": "age", "max": 50.0}],
            }
            | BREEDS
        },
    }
    ranges = {"search": {"ranges": {"species.hermit.reproduction.rate": [0.05, 0.2]}}}
    assert notes(load(config)) == []
    assert notes(load(config | ranges | {"ticks": 60})) == []
    (found,) = notes(load(config | ranges))
    assert found.startswith("species.hermit: a search's runs last 40 s, less than a lifespan of 50 s")


def test_the_words_of_others_for_hyperparameters_are_taken_and_noted():
    ours, others = (
        load("predator-prey", {"species.deer.ppo": settings})
        for settings in ({"discount": 0.97, "learning_rate": 1e-3}, {"gamma": 0.97, "lr": 1e-3})
    )
    assert others.config_hash == ours.config_hash
    assert others.species["deer"].ppo == ours.species["deer"].ppo
    assert notes(ours) == []
    assert notes(others) == [
        "species.deer.ppo: gamma is called discount here",
        "species.deer.ppo: lr is called learning_rate here",
    ]
    with pytest.raises(ConfigError, match=r"(?s)species.deer.ppo.gamma = 0.97.*another name for discount"):
        load("predator-prey", {"species.deer.ppo.gamma": 0.97})


def test_the_summary_says_that_plants_have_sites_of_their_own():
    moss = {
        "count": 3,
        "body": {"radius": 0.1},
        "reproduction": {"kind": "spread", "rate": 0.1, "spacing": 0.5},
    }
    told = [
        summary(
            load(
                {
                    "format": 1,
                    "name": "heath",
                    "space": {"size": [10.0, 5.0]},
                    "species": dict.fromkeys(names, moss),
                }
            )
        )
        for names in (["moss"], ["moss", "fern"])
    ]
    assert "spreads over 20 × 10 sites\n" in told[0]
    assert told[1].count("sites; other plants can occupy the same ground") == 2
