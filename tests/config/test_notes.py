import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.cli.summary import summary
from ecs_eco.components import Metabolism
from ecs_eco.config import load
from ecs_eco.config.notes import meaningless_debt, notes
from ecs_eco.config.shipped import shipped


def _hermit(**species):
    return load({"format": 1, "name": "cell", "space": {"size": [10.0, 10.0]},
                 "species": {"hermit": {"count": 3, "body": {"radius": 0.5}} | species}})


@pytest.mark.parametrize("name", shipped())
def test_energy_below_zero_means_something_in_every_shipped_world(name):
    config = load(name)
    assert {n: meaningless_debt(config, s) for n, s in config.species.items()} == dict.fromkeys(
        config.species, "")
    assert notes(config) == []


@pytest.mark.parametrize("name", shipped())
def test_nobody_in_a_shipped_world_lives_on_with_less_than_no_energy(name):
    world = World.from_config(name, seed=3)
    for _ in range(4):
        world.run(10)
        for table in world.tables.values():
            if Metabolism in table:
                assert (table[Metabolism].energy[table.rows()] >= 0).all(), table.name


@pytest.mark.parametrize(("species", "why"), [
    ({}, ""),
    ({"metabolism": {"growth": 0.5}}, ""),
    ({"metabolism": {"basal": 0.25}}, "metabolism.basal"),
    ({"metabolism": {"basal": 0.25, "torpor": True}}, ""),
    ({"metabolism": {"basal": 0.25}, "lethal": [{"property": "energy", "min": -1.0}]}, ""),
    ({"metabolism": {"basal": 0.25}, "lethal": [{"property": "energy", "max": 2.0}]}, "metabolism.basal"),
    ({"locomotion": {"speed": {"walk": 1.0, "run": 2.0}, "cost": {"walk": 0.0, "run": 0.5}}},
     "locomotion.cost.run"),
    ({"diet": [{"eats": "hermit", "gain": -0.5}]}, "diet.0.gain"),
    ({"diet": [{"eats": "hermit", "gain": 0.5}], "defence": {"poison": 0.25}},
     "species.hermit.defence.poison"),
])  # fmt: skip
def test_a_note_names_what_takes_energy_that_nothing_kills_for(species, why):
    config = _hermit(**species)
    assert meaningless_debt(config, config.species["hermit"]) == why
    written = [line for line in summary(config).splitlines() if "note:" in line]
    assert len(written) == (1 if why else 0)
    assert not why or f"species.hermit: its energy can fall below 0 ({why})" in written[0]


def test_what_a_note_warns_of_does_happen():
    world = World.from_config(_hermit(metabolism={"basal": 0.25, "energy": 0.5})).run(4)
    assert np.unique(world.tables["hermit"][Metabolism].energy[:3]).tolist() == [-0.5]
