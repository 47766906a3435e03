"""The page learns how nervous systems are wired: which readings lead to reflexes and happiness."""

import pytest

from ecs_eco import World
from ecs_eco.analysis.nervous_diagram import nervous_species
from ecs_eco.config import load
from ecs_eco.config.shipped import shipped
from ecs_eco.view.scene import wiring


@pytest.fixture(scope="module")
def lamb():
    return World.from_config("lamb", seed=1, policies="untrained", populate=False, record=False)


def test_reflexes_join_the_readings_and_the_action_that_the_world_file_names(lamb):
    species = lamb.config.species["lamb"]
    said = wiring(lamb.config, "lamb")["wiring"]
    channels, actions = species.channels(lamb.config.dims), species.action_list()
    told = {(channels[row], actions[action][1]) for rows, action, _ in said["reflexes"] for row in rows}
    given = {(c.sensor, c.action.split(".")[-1]) for c in species.reflex.connections}
    assert told == given == {("touch_udder", "suck"), ("touch_water", "inhale")}
    assert said["happiness"]
    assert said["felt"]
    assert said["all"] == {"reflex": False, "policy": True, "happiness": False}


@pytest.mark.parametrize("name", sorted(shipped()))
def test_every_shipped_animal_has_a_wiring_and_a_drawing(name):
    config = load(name)
    for species in nervous_species(config):
        said = wiring(config, species)["wiring"]
        own = config.species[species]
        rows, actions = len(own.channels(config.dims)), len(own.action_list())
        assert all(row < rows for row in said["felt"])
        assert all(max(row) < rows and action < actions for row, action, _ in said["reflexes"] if row)


def test_who_has_no_nerves_has_no_wiring(lamb):
    assert wiring(lamb.config, "water") == {}
    assert wiring(None, "lamb") == {}
