"""A world with all of a life: eggs, kin, care, growth, fertility with age and season, genes for them;
it keeps its promises."""

import copy

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Body, Breeding, Incubation, Parentage, Stature
from ecs_eco.config import load
from ecs_eco.record.ledger import LEDGER, imbalance
from ecs_eco.testing import check_world
from tests.worlds.aviary import AVIARY


def aviary(**options):
    return World.from_config(copy.deepcopy(AVIARY), seed=4, policies="random", **options)


@pytest.fixture(scope="module")
def lived():
    return aviary().run(45)


def test_all_of_it_happens(lived):
    bird, egg, series = lived.tables["bird"], lived.tables["egg"], lived.series().to_pydict()
    rows = bird.rows()
    assert {Breeding, Parentage, Stature} <= set(bird.columns)
    assert {Incubation, Parentage} <= set(egg.columns)
    assert sum(series["died: hatched"]) > 10
    assert sum(series["died: eaten by rat"]) > 0
    assert (bird[Body].mass[rows] < bird[Stature].mass[rows]).any()
    assert bird[Parentage].mother[rows].any()
    assert bird[Parentage].father[rows].any()


def test_the_ledger_of_energy_closes_in_every_tick(lived):
    page = {name: np.array(lived.series()[name].to_pylist()) for name in LEDGER}
    assert page["taken_in"].sum() > 1
    assert np.abs(imbalance(page)).max() < 1e-6


def test_a_saved_or_copied_world_goes_on_as_if_nothing_had_been(lived, tmp_path):
    path = aviary().run(23).save(tmp_path / "birds")
    assert World.restore(path).run(22).digest() == lived.digest()
    assert World.restore(path).copy().run(22).digest() == lived.digest()


def test_the_world_keeps_the_rules_of_worlds():
    check_world(lambda threads: aviary(threads=threads), ticks=20)


def test_the_file_that_is_written_is_the_world(lived):
    assert load(lived.config.resolved()).config_hash == lived.config.config_hash


def test_shipped_worlds_have_no_word_of_it():
    for name in ("predator-prey", "lamb"):
        values = load(name).resolved()
        assert "year" not in values
        for species in values["species"].values():
            assert not {"growth", "breeding", "care", "hatch"} & set(species)
            assert "eggs" not in (species["reproduction"] or {})
            assert all("kin" not in sensor for sensor in species["sensors"])
