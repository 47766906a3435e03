"""One function applies a configuration: to a world that is built, and to one that lives."""

import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.config.shipped import shipped
from ecs_eco.life.apply import apply
from tests.worlds.herd import herd


@pytest.mark.parametrize("name", [*shipped(), "herd"])
def test_a_configuration_that_is_applied_once_more_changes_nothing(name):
    world = World.from_config(herd() if name == "herd" else name, policies="untrained").run(2)
    digest = world.digest()
    apply(world, world.config)
    apply(world, world.config, world.config)
    assert world.digest() == digest


def test_a_reflex_that_a_treatment_took_away_does_not_come_back():
    world = World.from_config("reflexes", controls=("no-reflexes",))
    apply(world, world.config)
    assert world.tables["goat"].species.nerves.reflex is None


def test_what_a_user_has_set_stays_where_another_value_changes(menagerie):
    world = World.from_config(menagerie(), policies="untrained")
    world.ambient["light"], world.fields["musk"].decay = 0.125, 0.25
    world.reconfigure(load(world.config, {"ambient.temperature": 290.0, "fields.musk.diffusion": 0.75}))
    assert (world.ambient["light"], world.ambient["temperature"]) == (0.125, 290.0)
    assert (world.fields["musk"].decay, world.fields["musk"].diffusion) == (0.25, 0.75)
