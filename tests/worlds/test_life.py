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

BIRD = {
    "count": 40, "max_count": 150, "sex": "random",
    "body": {"radius": 0.3, "mass": 1.0, "opaque": False},
    "metabolism": {"energy": 0.7, "energy_max": 1.0, "basal": 0.002, "growth": 0.012},
    "growth": {"rate": 0.05, "newborn": 0.1, "cost": 0.05, "reserve": 0.1, "pace": 0.2},
    "care": {"rate": 0.01, "reach": 3.0, "until": 20.0, "reserve": 0.3, "efficiency": 0.9, "by": "both"},
    "breeding": {"maturity": 4.0, "end": 200.0, "season": 0.25, "width": 0.2},
    "locomotion": {"speed": {"sit": 0.0, "walk": 0.6}, "cost": {"walk": 0.001}, "turn": 0.8},
    "sensors": [{"kind": "nearest", "target": "bird", "radius": 8.0, "kin": kin}
                for kin in ("mother", "father", "siblings")]
    + [{"kind": "property", "property": "energy", "of": ["bird", "egg"], "radius": 6.0, "kin": "offspring"}],
    "actions": {"speed": ["sit", "walk"], "turn": ["left", "none", "right"], "nurse": ["nurse"]},
    "neutral": {"speed": "sit", "turn": "none"},
    "automatic": ["nurse"],
    "reflex": {"formulas": {"left": "bird_mother_left", "right": "-bird_mother_left"}},
    "happiness": {"weights": {"bird_mother_near": 1.0}, "minimum": 0.0},
    "policy": {"kind": "shared", "hidden": [4]},
    "reproduction": {"kind": "sexual", "energy_min": 0.5, "energy_given": 0.1, "litter": 3, "reach": 6.0,
                     "gestation": 2.0, "rest": 5.0, "eggs": "egg"},
    "genome": {"genes": [
        {"name": "mass", "trait": "body.mass", "letters": 4, "low": 0.5, "high": 2.0},
        {"name": "season", "trait": "breeding.season", "letters": 4, "low": 0.0, "high": 0.9},
    ]},
    "lethal": [{"property": "energy", "min": 0.0, "low": "starved"}],
}  # fmt: skip
EGG = {"count": 3, "body": {"radius": 0.05, "mass": 0.1, "opaque": False},
       "metabolism": {"energy": 0.1, "basal": 1e-4},
       "hatch": {"into": "bird", "incubation": 6.0, "temperature": 285.0}}
RAT = {"count": 4, "body": {"radius": 0.3, "opaque": False}, "metabolism": {"energy": 0.5},
       "diet": [{"eats": "egg", "efficiency": 0.5, "reach": 0.5}]}
AVIARY = {"format": 1, "name": "aviary", "space": {"size": [25.0, 25.0]},
          "year": {"length": 60.0, "temperature": 5.0}, "species": {"bird": BIRD, "egg": EGG, "rat": RAT}}


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
